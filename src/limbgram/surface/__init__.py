"""Surface: from oriented points to one whole mesh."""

from limbgram.surface.mesh import Mesh, Part, Repairs
from limbgram.surface.repair.parts import PartOptions, Parts, tell_parts
from limbgram.surface.repair.repairing import RepairOptions, repair
from limbgram.surface.resampling.decimation import Decimated, DecimateOptions, decimate
from limbgram.surface.resampling.deviation import Deviation, measure_deviation
from limbgram.surface.resampling.refinement import refine
from limbgram.surface.sections import Section, cut
from limbgram.surface.wrapping.pivoting import PivotOptions, pivot
from limbgram.surface.wrapping.poisson import PoissonOptions, poisson

__all__ = [
    "DecimateOptions",
    "Decimated",
    "Deviation",
    "Mesh",
    "Part",
    "PartOptions",
    "Parts",
    "PivotOptions",
    "PoissonOptions",
    "RepairOptions",
    "Repairs",
    "Section",
    "cut",
    "decimate",
    "measure_deviation",
    "pivot",
    "poisson",
    "refine",
    "repair",
    "tell_parts",
]
