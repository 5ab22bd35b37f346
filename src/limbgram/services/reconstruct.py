"""Reconstruct: what is decided about a surface, and what is known of lengths in its photos.

In      a request: words and files, as people give them.
Out     Shaping, decided alike at every door; Known: the files read, the words parsed.
Fails   a file that holds something else, a word that is none, a scale that nothing would set.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import Flag, Text, Within
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, TapedGirth
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.plates import MarkPlate
from limbgram.reconstruction.user_settings import MOST_TRIANGLES, Choices, SurfaceMethod
from limbgram.services.parse_capture import (
    DEFAULT_BOARD,
    Box,
    parse_board,
    parse_box,
    parse_tape,
    plates_of,
    read_distances,
)

NO_BOARD = "none"
"""In the place of a board: look for none."""


@dataclass(frozen=True, kw_only=True)
class Shaping:
    """What is decided about a surface beside what is given."""

    unscaled: bool = False
    """Go on without a scale: the size stays unknown."""
    surface: SurfaceMethod = Choices.surface
    """How points become a surface."""
    box_mm: Annotated[Box | None, Flag("box"), Text(lambda text, _at: parse_box(text))] = None
    """Only what lies in this box, mm in the world: x,y,z,x,y,z, its lowest and highest corner."""
    part: Annotated[int | None, Within(1, 1000)] = None
    """Which body is the limb where the photos show several: its number in the report; without it
    the one that the photos look at."""
    triangles: Annotated[int, Within(10_000, 20_000_000)] = MOST_TRIANGLES
    """Triangles at most, of all parts together."""
    memory_gb: Annotated[float | None, Within(0.5, 4096), Flag("memory")] = None
    """Memory to keep to, GB; without it half of the machine's."""

    @property
    def choices(self) -> Choices:
        """The options of the stages."""
        return Choices(
            surface=self.surface,
            box_mm=self.box_mm,
            part=self.part,
            most_triangles=self.triangles,
        )

    @property
    def memory_mb(self) -> float | None:
        return None if self.memory_gb is None else 1024 * self.memory_gb


@dataclass(frozen=True, kw_only=True)
class Known:
    """What is known of lengths in the photos."""

    board: Board | None
    """The scale board that is looked for."""
    distances: tuple[KnownDistance, ...] = ()
    tapes: tuple[TapedGirth, ...] = ()
    """Girths taped on the limb, to test the size by."""
    plates: tuple[MarkPlate, ...] = ()
    """Scale bars, mats and rings in the scene."""

    def require_size(self, *, unscaled: bool) -> None:
        """Refuse what would end without millimetres, unless that is asked for.

        Raises:
            OptionsError: nothing would set the scale.
        """
        if not (self.board or self.distances or self.plates or unscaled):
            raise OptionsError("options.no_size")


@dataclass(frozen=True, kw_only=True)
class ReconstructRequest(Shaping):
    """A surface of a limb, in millimetres, from photos taken round it."""

    camera: tuple[Path, ...] = ()
    """Camera file of `limbgram calibrate`; without it EXIF is a first guess."""
    board: str | None = None
    """Scale board in the scene, or the board file of `limbgram print`; without it, and without
    another length, charuco:7x5:30:22:4X4_50."""
    known_distances: Annotated[tuple[Path, ...], Flag("known-distance")] = ()
    """JSON file of known distances between points picked in the photos; length_sigma_mm beside
    length_mm says how surely a tape read it, such as 0.5."""
    marks: tuple[Path, ...] = ()
    """File that `limbgram print` wrote beside scale bars, a mat or a ring: their lengths set the
    scale, or with --board check it."""
    tapes: Annotated[tuple[str, ...], Flag("tape")] = ()
    """Girth that a tape read on the limb, in mm, to test the size: 150=354 at 150 mm above the
    printed side of the board (above the table without a board), or widest=354. It counts as read
    to 3 mm in 95 of 100; state another as 150=354+-2."""

    def known(self) -> Known:
        """The files read, and the words parsed.

        Raises:
            OptionsError: one of them is none, or nothing would set the scale.
        """
        known = Known(
            board=self._board(),
            distances=tuple(one for file in self.known_distances for one in read_distances(file)),
            tapes=tuple(parse_tape(text) for text in self.tapes),
            plates=tuple(plate for file in self.marks for plate in plates_of(file)),
        )
        known.require_size(unscaled=self.unscaled)
        return known

    def _board(self) -> Board | None:
        """None: told so, or another answer to the scale was given."""
        answered = bool(self.known_distances or self.marks or self.unscaled)
        if self.board == NO_BOARD or (self.board is None and answered):
            return None
        return parse_board(self.board or DEFAULT_BOARD)
