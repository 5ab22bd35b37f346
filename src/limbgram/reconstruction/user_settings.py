"""User settings (choices): the user's settings of a reconstruction, apart from its input data.

It imports nothing, so that a command line which hands a job on starts without the stages.
"""

from dataclasses import dataclass
from typing import Literal

SurfaceMethod = Literal["ball-pivoting", "poisson"]

MOST_TRIANGLES = 400_000
"""Edges of 0.7 mm on a limb of 900 cm2. Where the pixels allow more, edges grow, and all pixels
still serve the measurement."""


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What `pipeline.options_for` makes options of."""

    surface: SurfaceMethod = "ball-pivoting"
    """How points become a surface."""
    box_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    """Only what lies in this box of the world: its lowest and its highest corner."""
    gap_mm: float = 0.0
    """Pieces of one object may lie so far apart in the scene; 0: as far as the paint's spots."""
    part: int | None = None
    """Which body is the limb, by its number in the report; None: the one that is looked at most."""
    most_triangles: int = MOST_TRIANGLES
    """Of the measured surface, of all its parts together."""
