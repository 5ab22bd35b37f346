"""Printed boards: their true corners, with errors of the print, and their poses."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.reconstruction.targets.board import LENS_BOARD, Board
from limbgram.reconstruction.targets.board import SCALE_BOARD as PRINTED

BOARD_HEIGHT_MM = 2.5


@dataclass(frozen=True)
class PrintedBoard:
    """A board as it was printed, with the errors of the print."""

    board: Board
    """The board as designed, which the user believes in."""
    print_scale: float = 1.0
    """True size over designed size: 1.03 is a board that was printed enlarged."""
    stretch: float = 0.0
    """Relative excess of its scale down the columns over that along the rows: printers feed paper
    too far or too little, usually by 0.002."""
    sag_mm: float = 0.0
    """Sagitta of its rows, bent upwards to an arc of a circle. Usual for a print glued on card:
    0.5."""

    def __post_init__(self) -> None:
        if not (abs(self.stretch) <= 0.05 and 0 <= self.sag_mm <= 20):
            raise OptionsError("made.board.bent")
        if self.board.legacy:
            raise OptionsError("made.board.legacy")

    @property
    def square_mm(self) -> float:
        """True side of a square."""
        return self.board.square_mm * self.print_scale

    @property
    def marker_mm(self) -> float:
        """True side of a marker; 0 on a checkerboard."""
        return self.board.marker_mm * self.print_scale

    @property
    def size_mm(self) -> Float64[np.ndarray, "2"]:
        """True width and height of the flat print without the white margin."""
        return np.array(self.board.squares, float) * self.square_mm * self._stretched

    def corners_mm(self) -> Points3:
        """True inner corners in the board's frame."""
        flat = self.board.corners_mm * self.print_scale
        across, rise = self.bent_mm(flat[:, 0]).T
        return np.column_stack([across, flat[:, 1] * self._stretched[1], rise])

    def bent_mm(self, along_mm: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "n 2"]:
        """x and z in the board's frame, by distance along a row of the flat print."""
        if self.sag_mm == 0:
            return np.column_stack([along_mm, np.zeros_like(along_mm)])
        half = 0.5 * self.size_mm[0]
        radius = half**2 / (2 * self.sag_mm)  # to a thousandth of the sag
        angle = (along_mm - half) / radius
        rise = radius * (np.cos(angle) - np.cos(half / radius))
        return np.column_stack([half + radius * np.sin(angle), -rise])

    @property
    def _stretched(self) -> Float64[np.ndarray, "2"]:
        return np.array([1.0, 1.0 + self.stretch])


SCALE_BOARD = PrintedBoard(PRINTED)
CALIBRATION_BOARD = PrintedBoard(LENS_BOARD)


@dataclass(frozen=True)
class LaidBoard:
    """A board and its pose."""

    printed: PrintedBoard
    world_from_board: Rigid

    def corners_in_world(self) -> Points3:
        return self.world_from_board.apply(self.printed.corners_mm())

    def outline_in_world(self) -> Points3:
        """The four outer corners of the print."""
        corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
        return self.world_from_board.apply(corners * np.append(self.printed.size_mm, 0.0))


def lay_beside(printed: PrintedBoard, seed: int) -> LaidBoard:
    """Lay a board on the table beside the stand, at a random azimuth."""
    rng = np.random.default_rng((seed, 6))
    toward, turn = rng.uniform(0, 2 * np.pi, 2)
    middle = (80.0 + 0.5 * printed.size_mm[1]) * np.array([np.cos(toward), np.sin(toward)])
    return _lay(printed, middle, toward + np.pi / 2 + 0.15 * np.sin(turn))


def lay_alone(printed: PrintedBoard, seed: int) -> LaidBoard:
    """Lay a board in the middle of the empty table."""
    return _lay(printed, np.zeros(2), np.random.default_rng((seed, 7)).uniform(0, 2 * np.pi))


def _lay(printed: PrintedBoard, middle: np.ndarray, turn: float) -> LaidBoard:
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    down = np.array([right[1], -right[0], 0.0])
    rotation = np.column_stack([right, down, [0.0, 0.0, -1.0]])
    half = 0.5 * printed.size_mm
    origin = np.array([*middle, BOARD_HEIGHT_MM]) - half[0] * right - half[1] * down
    return LaidBoard(printed, Rigid(rotation, origin))
