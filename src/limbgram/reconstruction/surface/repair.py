"""Repair: a mesh of one piece without holes, but for the brim.

In      the Parts of a wrapped surface, and which of them; the Cloud it was made from.
Out     a Mesh: one component, manifold, outward, no opening but the brim; what was closed is
        marked `filled`, what was done is told in `repairs`.
Method  tell the brim from the holes, close holes by triangles of least area, made even and bent
        as a thin plate (Liepa 2003).
Fails   SurfaceError: nothing is left, or a hole cannot be closed.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.mesh.mesh import Cloud, Mesh, Repairs
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import drop_dangling, largest_manifold
from limbgram.reconstruction.surface.holes import fill_holes, find_openings
from limbgram.reconstruction.surface.parts import FEWEST_FACES, Parts, nothing_left, outwards

_BRIM_SHARE_AT_END = 0.1
"""An opening at the low or high end is the brim if it is at least this part of what the
mesh shows from that side."""
_BRIM_SHARE = 0.35
"""The same for an opening anywhere else."""


def repair(parts: Parts, cloud: Cloud, number: int | None = None) -> Mesh:
    """Make one whole surface of a part, the meant one unless told; colours come from the cloud."""
    vertices, loose = parts.mesh.vertices_mm, parts.faces(number or parts.chosen)
    main = largest_manifold(vertices, drop_dangling(loose))
    if len(main) < FEWEST_FACES:
        raise nothing_left(len(loose), len(main))
    start = with_faces(Mesh(vertices_mm=vertices, faces=main), main)
    start = outwards(start, cloud)
    openings = find_openings(start.vertices_mm, start.faces, _BRIM_SHARE_AT_END, _BRIM_SHARE)
    whole = fill_holes(start.vertices_mm, start.faces, openings.holes)
    brim = openings.brim
    _check(whole.faces, 0 if brim is None else 1)
    nearest = KDTree(cloud.points_mm).query(whole.vertices_mm)[1]
    meant = number in (None, parts.chosen)
    return replace(
        whole,
        colours=cloud.colours[nearest],
        repairs=Repairs(
            islands_dropped=parts.crumbs if meant else 0,
            island_share=parts.left_out_share if meant else 0.0,
            holes_filled=len(openings.holes),
            filled_share=_filled_share(whole),
            brim_mm=0.0 if brim is None else _length(whole.vertices_mm[brim]),
            part=number or parts.chosen,
            part_given=parts.given and meant,
            others=parts.others if meant else (),
        ),
    )


def _check(faces: Faces, openings: int) -> None:
    whole = is_edge_manifold(faces) and is_vertex_manifold(faces)
    if not whole or len(boundary_loops(faces)) != openings or face_components(faces).any():
        raise SurfaceError("surface.holes")


def _filled_share(mesh: Mesh) -> float:
    filled = np.zeros(len(mesh), np.bool_) if mesh.filled is None else mesh.filled
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    return float(areas[filled[mesh.faces].any(1)].sum() / areas.sum())


def _length(loop: Points3) -> float:
    return float(np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).sum())
