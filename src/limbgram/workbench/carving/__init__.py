"""Carving: the shape as a carver takes it, and the proof that it carves it."""

from limbgram.workbench.carving.mapping import MapOptions, Mapped, map_radii, map_radii_on
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.carving.simulation import CarveCheck, Moves, check_carving, simulate
from limbgram.workbench.carving.toolpath import Toolpath, plan_toolpath

__all__ = [
    "CarveCheck",
    "CarveOptions",
    "MapOptions",
    "Mapped",
    "Moves",
    "Toolpath",
    "check_carving",
    "map_radii",
    "map_radii_on",
    "plan_toolpath",
    "simulate",
]
