"""Measures: girths, widths, areas, volumes, lengths, with their uncertainty."""

from limbgram.shape.measures.geodesic import length_mm, shortest_path
from limbgram.shape.measures.lengths import Length
from limbgram.shape.measures.levels.figures import Figure
from limbgram.shape.measures.measuring import (
    MeasureOptions,
    Measures,
    Row,
    VolumeRow,
    measure,
    measure_inside,
)
from limbgram.shape.measures.sock import without_sock
from limbgram.shape.measures.tape import TapeChange, TapeCheck, TapeFit, TapeReading, fit_to_tape

__all__ = [
    "Figure",
    "Length",
    "MeasureOptions",
    "Measures",
    "Row",
    "TapeChange",
    "TapeCheck",
    "TapeFit",
    "TapeReading",
    "VolumeRow",
    "fit_to_tape",
    "length_mm",
    "measure",
    "measure_inside",
    "shortest_path",
    "without_sock",
]
