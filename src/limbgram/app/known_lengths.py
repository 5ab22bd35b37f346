"""Boards and other known lengths, as requests give them."""

from typing import Literal

from pydantic import Field

from limbgram.app.forms import RequestBody
from limbgram.formats.board_file import board_as_printed
from limbgram.formats.printed_size import PrintedSize, Reading
from limbgram.reconstruction.targets.board import SCALE_BOARD, Board


class Ruler(RequestBody):
    """A ruler that is printed with a board, and what a steel rule says that it is long."""

    drawn_mm: float = Field(default=250.0, ge=50, le=2000, description="As printed beside it.")
    measured_mm: float = Field(gt=0, le=2000, description="Refused from 5 % off.")

    def printed(self) -> PrintedSize:
        """What the board's size is corrected by.

        Raises:
            OptionsError: no print of the board is so large or so small.
        """
        return PrintedSize(across=Reading(drawn_mm=self.drawn_mm, measured_mm=self.measured_mm))


class BoardSpec(RequestBody):
    """A scale or calibration board. Without any word: the scale board that the program prints."""

    kind: Literal["charuco", "checkerboard"] = "charuco"
    columns: int = Field(
        default=SCALE_BOARD.columns,
        ge=2,
        le=100,
        description="Squares across; inner corners of a checker.",
    )
    rows: int = Field(
        default=SCALE_BOARD.rows,
        ge=2,
        le=100,
        description="Squares down; inner corners of a checker.",
    )
    square_mm: float = Field(
        default=SCALE_BOARD.square_mm,
        gt=0,
        le=1000,
        description="As measured on the print; with a ruler, as it was drawn.",
    )
    marker_mm: float = Field(default=SCALE_BOARD.marker_mm, ge=0, le=1000)
    dictionary: str = Field(default=SCALE_BOARD.dictionary, max_length=40)
    ruler: Ruler | None = Field(
        default=None,
        description="What the ruler of the print reads: square and marker are corrected by it, "
        "as `limbgram print --measured-mm` does. null: they are given in their true size.",
    )

    def board(self) -> Board:
        """The library's board, in its true size.

        Raises:
            OptionsError: there can be no such board, or no such print of it.
        """
        printed = None if self.ruler is None else self.ruler.printed()
        size = f"{self.columns}x{self.rows}"
        if self.kind == "checkerboard":
            return board_as_printed(Board.checkerboard(size, self.square_mm), printed)
        drawn = Board.charuco(size, self.square_mm, self.marker_mm, self.dictionary)
        return board_as_printed(drawn, printed)
