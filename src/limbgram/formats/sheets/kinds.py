"""All kinds of sheets: what `limbgram print` offers, its help and its guide follow this table.

To add a kind: write the function that draws it, from page and options to a Sheet, and give it a
name and a row here, with the options that it takes.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.boards import draw_board_sheet
from limbgram.formats.sheets.coded import (
    STICKER_MM,
    draw_bars,
    draw_mat,
    draw_ring,
    draw_stickers,
)
from limbgram.formats.sheets.page import PageName, Sheet
from limbgram.formats.sheets.sock import draw_sock
from limbgram.reconstruction.targets.board import LENS_BOARD, SCALE_BOARD, Board


class KindName(StrEnum):
    """What is printed."""

    SCALE_BOARD = "scale-board"
    CHECKERBOARD = "checkerboard"
    SCALE_BARS = "scale-bars"
    MAT = "mat"
    RING = "ring"
    STICKERS = "stickers"
    SOCK = "sock"
    KIT = "kit"
    """All of them."""


@dataclass(frozen=True, kw_only=True)
class SheetOptions:
    """What differs between sheets of one kind; each kind takes what concerns it."""

    board: Board | None = None
    """Another pattern for a board."""
    sticker_mm: float = STICKER_MM
    """Side of a sticker's mark."""
    first: int = 0
    """Number of the first sticker."""
    pixel_mm: float = 0.25
    """What one pixel of the camera shows of the skin."""
    distance_mm: float | None = None
    """From the camera to the skin, where that is known: the sock says on itself what it is for."""
    seed: int = 0
    """Another seed is another sock pattern."""


@dataclass(frozen=True)
class SheetKind:
    """One kind of sheet."""

    name: KindName
    use: str
    """What it is for, after its name."""
    draw: Callable[[PageName, SheetOptions], Sheet] = field(repr=False)
    takes: tuple[str, ...] = ()
    """Names of the options that concern it."""


def _scale_board(page: PageName, options: SheetOptions) -> Sheet:
    return draw_board_sheet(options.board or SCALE_BOARD, page, "scale board")


def _checkerboard(page: PageName, options: SheetOptions) -> Sheet:
    board = options.board or LENS_BOARD
    if board.kind != "checkerboard":
        raise OptionsError("export.sheet.no_checkerboard")
    return draw_board_sheet(board, page, "calibration board")


KINDS: tuple[SheetKind, ...] = (
    SheetKind(
        KindName.SCALE_BOARD, "lies beside the limb and sets the scale", _scale_board, ("board",)
    ),
    SheetKind(KindName.CHECKERBOARD, "calibrates the camera", _checkerboard, ("board",)),
    SheetKind(
        KindName.SCALE_BARS, "are known lengths beside the limb", lambda page, _: draw_bars(page)
    ),
    SheetKind(
        KindName.MAT,
        "lies under and round the limb and holds known lengths",
        lambda page, _: draw_mat(page),
    ),
    SheetKind(KindName.RING, "turns with the limb on a turntable", lambda page, _: draw_ring(page)),
    SheetKind(
        KindName.STICKERS,
        "mark landmarks on limb or sock by number",
        lambda page, options: draw_stickers(page, options.sticker_mm, options.first),
        ("sticker_mm", "first"),
    ),
    SheetKind(
        KindName.SOCK,
        "is a pattern for fabric or transfer film",
        lambda page, options: draw_sock(page, options.pixel_mm, options.seed, options.distance_mm),
        ("pixel_mm", "distance_mm", "seed"),
    ),
)
