"""Measures: girths, widths, areas, volumes, lengths, with their uncertainty."""

from limbgram.workbench.measures.lengths import Length, length_mm, shortest_path
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.measuring import (
    MeasureOptions,
    Measures,
    Row,
    VolumeRow,
    measure,
    measure_inside,
)
from limbgram.workbench.measures.skins import without_sock
from limbgram.workbench.measures.tape import (
    TapeChange,
    TapeCheck,
    TapeFit,
    TapeReading,
    fit_to_tape,
)

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
