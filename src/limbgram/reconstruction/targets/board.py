"""Boards: flat plates of known size that calibration and scale rely on, and where photos show them.

Board frame: millimetres, origin at the outer corner of the first square, x right and y down as
printed, z into the board. Detections hold the inner corners that each photo shows.
"""

import re
from dataclasses import dataclass
from typing import Literal, Self

import cv2
import numpy as np
from jaxtyping import Bool, Float64, Int32, UInt8

from limbgram.core.errors import OptionsError
from limbgram.core.known_words import require_known_words
from limbgram.findings import Finding, Value, note, told
from limbgram.reconstruction.photos.photo import SetAside

BoardKind = Literal["checkerboard", "charuco"]

DICTIONARIES: dict[str, int] = {
    name.removeprefix("DICT_").upper(): getattr(cv2.aruco, name)
    for name in dir(cv2.aruco)
    if name.startswith("DICT_")
}
"""Marker dictionaries by name, without the DICT_ that OpenCV puts before them."""

KIT_DICTIONARY = "APRILTAG_36H11"
"""Dictionary of the marks that are printed here: its codes differ in 11 bits at least, so that
paint is hardly ever read as one, and no mark of the scale board (4X4_50) as another."""


def marker_dictionary(name: str) -> cv2.aruco.Dictionary:
    """OpenCV's dictionary of a name in DICTIONARIES."""
    return cv2.aruco.getPredefinedDictionary(DICTIONARIES[name])


def code_count(name: str) -> int:
    """Number of codes in a dictionary; their ids run from 0."""
    return len(marker_dictionary(name).bytesList)


_CELLS_ACROSS = 6
"""Cells along the side of a square without a marker."""


@dataclass(frozen=True, kw_only=True)
class Board:
    """A checkerboard, or a ChArUco board (a checkerboard with a marker in each white square)."""

    kind: BoardKind
    columns: int
    """Inner corners across for a checkerboard; SQUARES across for ChArUco."""
    rows: int
    """Inner corners down for a checkerboard; SQUARES down for ChArUco."""
    square_mm: float
    marker_mm: float = 0.0
    """Side of the coded markers; 0 for a checkerboard."""
    dictionary: str = ""
    """Name in DICTIONARIES, such as 4X4_50 or APRILTAG_36H11; empty for a checkerboard."""
    legacy: bool = False
    """ChArUco with an even number of rows, printed by OpenCV before 4.6: a marker comes first."""

    def __post_init__(self) -> None:
        require_known_words(self)
        _check_size(self)
        if self.kind == "charuco":
            _check_markers(self)

    @classmethod
    def checkerboard(cls, size: str, square_mm: float) -> Self:
        """A checkerboard from its INNER CORNERS across and down, such as "14x10"."""
        columns, rows = parse_size(size)
        return cls(kind="checkerboard", columns=columns, rows=rows, square_mm=square_mm)

    @classmethod
    def charuco(
        cls,
        size: str,
        square_mm: float,
        marker_mm: float,
        dictionary: str,
        *,
        legacy: bool = False,
    ) -> Self:
        """A ChArUco board from its SQUARES across and down, such as "7x5"."""
        columns, rows = parse_size(size)
        return cls(
            kind="charuco",
            columns=columns,
            rows=rows,
            square_mm=square_mm,
            marker_mm=marker_mm,
            dictionary=parse_dictionary(dictionary),
            legacy=legacy,
        )

    @property
    def squares(self) -> tuple[int, int]:
        """Squares across and down."""
        extra = 1 if self.kind == "checkerboard" else 0
        return self.columns + extra, self.rows + extra

    @property
    def inner(self) -> tuple[int, int]:
        """Inner corners across and down."""
        across, down = self.squares
        return across - 1, down - 1

    @property
    def marker_first(self) -> bool:
        """Whether the first square holds a marker."""
        return self.legacy and self.rows % 2 == 0

    @property
    def white_squares(self) -> Bool[np.ndarray, "rows columns"]:
        """Which squares are white; those of a ChArUco board hold markers."""
        columns, rows = self.squares
        return (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 1) != self.marker_first

    @property
    def has_quarter_turns(self) -> bool:
        """Whether corners cannot tell x from y: a checkerboard with as many rows as columns."""
        return self.kind == "checkerboard" and self.columns == self.rows

    @property
    def corners_mm(self) -> Float64[np.ndarray, "n 3"]:
        """Inner corners in the board frame, row by row; a corner's id is its row here."""
        across, down = self.inner
        y, x = np.mgrid[1 : down + 1, 1 : across + 1].reshape(2, -1)
        return np.stack([x, y, np.zeros_like(x)], axis=1) * float(self.square_mm)

    def cells(self) -> UInt8[np.ndarray, "rows columns cell cell"]:
        """The pattern: 1 white, 0 black, by square and by cell of the marker in the square."""
        columns, rows = self.squares
        white = self.white_squares
        if self.kind == "checkerboard":
            cells = np.zeros((rows, columns, _CELLS_ACROSS, _CELLS_ACROSS), np.uint8)
            cells[white] = 1
            return cells
        markers = marker_dictionary(self.dictionary)
        side = markers.markerSize + 2
        cells = np.zeros((rows, columns, side, side), np.uint8)
        for number, (row, column) in enumerate(np.argwhere(white)):
            cells[row, column] = markers.generateImageMarker(number, side) > 0
        return cells

    def opencv(self) -> cv2.aruco.CharucoBoard:
        """The same ChArUco board as OpenCV has it."""
        markers = marker_dictionary(self.dictionary)
        board = cv2.aruco.CharucoBoard(self.squares, self.square_mm, self.marker_mm, markers)
        board.setLegacyPattern(self.legacy)
        return board

    @property
    def finding(self) -> Finding:
        """The board in words, as the value of another finding."""
        sizes: dict[str, Value] = {
            "columns": self.columns,
            "rows": self.rows,
            "square_mm": self.square_mm,
        }
        if self.kind == "checkerboard":
            return note("board.checkerboard", **sizes)
        return note(
            "board.charuco",
            marker_mm=self.marker_mm,
            dictionary=self.dictionary,
            legacy=self.legacy,
            **sizes,
        )

    def __str__(self) -> str:
        return told(self.finding)


def parse_size(size: str) -> tuple[int, int]:
    """Columns and rows of "14x10"."""
    match = re.fullmatch(r"\s*(\d{1,3})\s*[xX×]\s*(\d{1,3})\s*", size)
    if match is None:
        raise OptionsError("board.no_size", size=size)
    return int(match[1]), int(match[2])


def parse_dictionary(name: str) -> str:
    """A name in DICTIONARIES, however it is spelled: dict_4x4_50, tag36h11, AprilTag 36h11."""
    plain = re.sub(r"[\s_-]", "", name.upper()).removeprefix("DICT")
    plain = re.sub(r"^(APRIL)?TAG", "APRILTAG", plain)
    for known in DICTIONARIES:
        if known.replace("_", "") == plain:
            return known
    raise OptionsError("board.no_dictionary", name=name, known=tuple(sorted(DICTIONARIES)))


def _check_size(board: Board) -> None:
    if min(board.inner) < 2 or max(board.inner) > 100:
        raise OptionsError("board.corners", across=board.inner[0], down=board.inner[1])
    if not 0.1 <= board.square_mm <= 2000:
        raise OptionsError("board.square", square_mm=board.square_mm)


def _check_markers(board: Board) -> None:
    if board.dictionary not in DICTIONARIES:
        parse_dictionary(board.dictionary)
        raise OptionsError("board.spelling", name=parse_dictionary(board.dictionary))
    if not 0 < board.marker_mm < board.square_mm:
        raise OptionsError("board.marker", marker_mm=board.marker_mm, square_mm=board.square_mm)
    across, down = board.squares
    codes = code_count(board.dictionary)
    if across * down // 2 > codes:
        raise OptionsError(
            "board.few_markers",
            dictionary=board.dictionary,
            there=codes,
            across=across,
            down=down,
            needed=across * down // 2,
        )


SCALE_BOARD = Board.charuco("7x5", 30.0, 22.0, "4X4_50")
"""Board that is printed to lie beside the limb, and looked for unless another is named."""
LENS_BOARD = Board.checkerboard("14x10", 10.0)
"""Board that is printed to calibrate a camera."""


@dataclass(frozen=True, kw_only=True)
class PhotoCorners:
    """Inner corners of the board in one photo."""

    name: str
    photo_idx: int
    """Place in the PhotoSet."""
    ids: Int32[np.ndarray, " n"]
    """Rows of `BoardDetections.corners_mm`, ascending."""
    xy_px: Float64[np.ndarray, "n 2"]
    sigmas_px: Float64[np.ndarray, " n"]
    """Formal sigma of one coordinate from the fit to the pixels; a relative weight, no promise."""
    blur_px: float
    """Median sigma of the edges' Gaussian blur."""
    step_px: float
    """Median side of a square in this photo."""
    doubtful_ids: Int32[np.ndarray, " m"]
    """Corners that were found but rejected."""
    doubtful_xy_px: Float64[np.ndarray, "m 2"]
    doubts: tuple[str, ...]
    """Why, for each doubtful corner: the code of a finding."""


@dataclass(frozen=True, kw_only=True)
class BoardDetections:
    """One board in all photos that show it; the others are set aside with their reason."""

    board: Board
    corners_mm: Float64[np.ndarray, "n 3"]
    """All inner corners in the board frame (`Board.corners_mm`)."""
    photos: tuple[PhotoCorners, ...]
    set_aside: tuple[SetAside, ...]
    cause: Finding | None = None
    """What is wrong with the photos: why, should too few show the board."""
