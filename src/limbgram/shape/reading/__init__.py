"""Reading: shapes from files, in millimetres, with what the limb file beside them tells."""

from limbgram.shape.reading.reading import SUFFIXES, ShapeFile, read_limb, read_shape
from limbgram.shape.reading.units import mm_per_unit_of

__all__ = ["SUFFIXES", "ShapeFile", "mm_per_unit_of", "read_limb", "read_shape"]
