"""Measures: girths, widths, areas, volumes, lengths, with their uncertainty."""

from limbgram.workbench.measures.geodesic import length_mm, shortest_path
from limbgram.workbench.measures.lengths import Length
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.measured_skin import without_sock
from limbgram.workbench.measures.measuring import (
    LimbMeasureOptions,
    Measures,
    Row,
    VolumeRow,
    measure_inside,
    measure_limb,
)
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
    "LimbMeasureOptions",
    "Measures",
    "Row",
    "TapeChange",
    "TapeCheck",
    "TapeFit",
    "TapeReading",
    "VolumeRow",
    "fit_to_tape",
    "length_mm",
    "measure_inside",
    "measure_limb",
    "shortest_path",
    "without_sock",
]
