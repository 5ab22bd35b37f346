"""Splitting: triangles cut where a value given at the vertices passes zero."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.shape.edits.marking.fineness import divide
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import find_edges, with_faces

ON_IT_MM = 1e-3
"""A vertex so near (mm) counts as on the cut: a thinner triangle would be lost in a file."""


@dataclass(frozen=True)
class Cut:
    """What is left of a mesh."""

    mesh: Mesh
    on_cut: Bool[np.ndarray, " n"]
    """Vertices that lie on the cut."""


def keep_positive(mesh: Mesh, values_mm: Float64[np.ndarray, " n"]) -> Cut:
    """The part of a mesh where the value is above zero; faces across it are split.

    Values are distances from the cut; along an edge they are taken as straight.
    """
    values = np.where(np.abs(values_mm) <= ON_IT_MM, 0.0, values_mm)
    sign = np.sign(values)
    edges = find_edges(mesh.faces)
    ends = edges.ends
    crossed = sign[ends[:, 0]] * sign[ends[:, 1]] < 0
    below, above = values[ends[:, 0]], values[ends[:, 1]]
    shares = np.where(crossed, below / np.where(crossed, below - above, 1.0), 0.5)
    division = divide(mesh, edges, crossed, shares)
    signs = np.concatenate([sign, np.zeros(int(crossed.sum()))])
    kept = division.mesh.faces[signs[division.mesh.faces].max(1, initial=-1.0) > 0]
    used = np.unique(kept)
    return Cut(with_faces(division.mesh, kept), signs[used] == 0)
