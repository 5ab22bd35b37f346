"""Carving: the shape as a carver takes it, and the proof that it carves it."""

from limbgram.carving.mapping import MapOptions, Mapped, map_radii

__all__ = ["MapOptions", "Mapped", "map_radii"]
