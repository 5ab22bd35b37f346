"""Carving: its names, each imported when it is first used."""

from .mapping import MapOptions, MappedSurface, map_radii, map_radii_on
from .setup import CarveOptions
from .simulation import CarveCheck, Moves, check_carving, simulate
from .toolpath import Toolpath, plan_toolpath

__all__ = [
    "CarveCheck",
    "CarveOptions",
    "MapOptions",
    "MappedSurface",
    "Moves",
    "Toolpath",
    "check_carving",
    "map_radii",
    "map_radii_on",
    "plan_toolpath",
    "simulate",
]
