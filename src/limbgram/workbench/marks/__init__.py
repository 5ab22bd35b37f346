"""Marks: spots of one plain colour on the sock, found in the placed photos."""

from limbgram.workbench.marks.finding import (
    PaintedMark,
    PaintedMarks,
    find_painted_marks,
)

__all__ = ["PaintedMark", "PaintedMarks", "find_painted_marks"]
