"""Surface: from oriented points to one whole mesh."""

from limbgram.core.mesh.mesh import Mesh, Part, Repairs
from limbgram.core.mesh.sections import Section, cut
from limbgram.reconstruction.surface.parts import PartOptions, Parts, tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.poisson import poisson
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.reconstruction.surface.repair import repair

__all__ = [
    "Mesh",
    "Part",
    "PartOptions",
    "Parts",
    "Repairs",
    "Section",
    "cut",
    "pivot",
    "poisson",
    "refine",
    "repair",
    "tell_parts",
]
