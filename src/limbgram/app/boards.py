"""Boards and other known lengths, as requests give them."""

from typing import Literal

from pydantic import BaseModel, Field

from limbgram.reconstruction.targets.board import Board


class BoardSpec(BaseModel):
    """A scale or calibration board. Without any word: the scale board that the program prints."""

    kind: Literal["charuco", "checkerboard"] = "charuco"
    columns: int = Field(
        default=7, ge=2, le=100, description="Squares across; inner corners of a checker."
    )
    rows: int = Field(
        default=5, ge=2, le=100, description="Squares down; inner corners of a checker."
    )
    square_mm: float = Field(default=30.0, gt=0, le=1000, description="As measured on the print.")
    marker_mm: float = Field(default=22.0, ge=0, le=1000)
    dictionary: str = Field(default="4X4_50", max_length=40)

    def board(self) -> Board:
        """The library's board.

        Raises:
            OptionsError: there can be no such board.
        """
        size = f"{self.columns}x{self.rows}"
        if self.kind == "checkerboard":
            return Board.checkerboard(size, self.square_mm)
        return Board.charuco(size, self.square_mm, self.marker_mm, self.dictionary)
