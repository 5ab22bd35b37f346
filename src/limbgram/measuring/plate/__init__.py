"""Plate: the surface held together where the photos are unsure."""

from limbgram.measuring.plate.bending import (
    Plate,
    bending_of,
    curvature_of,
    plate_of,
    settle,
    tangent_axes,
)
from limbgram.measuring.plate.quadrics import quadrics
from limbgram.measuring.plate.solver import solve

__all__ = [
    "Plate",
    "bending_of",
    "curvature_of",
    "plate_of",
    "quadrics",
    "settle",
    "solve",
    "tangent_axes",
]
