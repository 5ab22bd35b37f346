"""Trimming: cut the ragged rim of an opening back to what was measured.

In      a mesh, and which of its vertices are in doubt.
Out     the mesh without the doubtful vertices along its openings.
"""

import numpy as np
from jaxtyping import Bool

from limbgram.surface.mesh import Mesh
from limbgram.surface.repair.cleaning import settle
from limbgram.surface.topology import boundary_half_edges, with_faces


def cut_back(mesh: Mesh, doubtful: Bool[np.ndarray, " n"], rings: int) -> Mesh:
    """Take doubtful vertices off the openings, at most `rings` rows of them.

    A doubtful vertex inside the surface stays: no hole opens there.
    """
    faces = mesh.faces
    for _ in range(rings):
        at_rim = np.zeros(len(mesh), bool)
        at_rim[boundary_half_edges(faces).ravel()] = True
        going = at_rim & doubtful
        if not going.any():
            break
        faces = faces[~going[faces].any(axis=1)]
    return with_faces(mesh, settle(mesh.vertices_mm, faces))
