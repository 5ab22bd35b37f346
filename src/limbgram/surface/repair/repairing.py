"""Repair: a mesh of one piece without holes, but for the brim.

In      a Mesh with islands, holes, folds; the Cloud it was made from.
Out     a Mesh: one component, manifold, outward, no opening but the brim; what was closed is
        marked `filled`, what was done is told in `repairs`.
Method  take away what is no surface, tell the brim from the holes, close holes by triangles of
        least area, made even and bent as a thin plate (Liepa 2003).
Fails   SurfaceError: nothing is left, or a hole cannot be closed.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from limbgram.errors import SurfaceError
from limbgram.geometry.arrays import Faces, Points3
from limbgram.geometry.cloud import Cloud
from limbgram.surface.mesh import Mesh, Repairs
from limbgram.surface.repair.cleaning import (
    drop_dangling,
    drop_flat_and_double,
    drop_folds,
    drop_tongues,
    largest_component,
    make_manifold,
    settle,
)
from limbgram.surface.repair.filling import fill_holes
from limbgram.surface.repair.openings import find_openings
from limbgram.surface.topology import (
    boundary_loops,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    with_faces,
)

_FEWEST_FACES = 50


@dataclass(frozen=True, kw_only=True)
class RepairOptions:
    """What counts as the brim."""

    brim_share_at_end: float = 0.1
    """An opening at the low or high end is the brim if it is at least this part of what the
    mesh shows from that side."""
    brim_share: float = 0.35
    """The same for an opening anywhere else."""


DEFAULTS = RepairOptions()


def repair(mesh: Mesh, cloud: Cloud, options: RepairOptions = DEFAULTS) -> Mesh:
    """Make one whole surface of a mesh; colours come from the cloud."""
    vertices = mesh.vertices_mm
    faces = make_manifold(drop_flat_and_double(vertices, mesh.faces))
    faces = make_manifold(drop_tongues(vertices, drop_folds(vertices, faces)))
    if len(faces) < _FEWEST_FACES:
        raise _nothing_left(len(mesh.faces), len(faces))
    islands = int(face_components(faces).max()) + 1
    largest = largest_component(vertices, faces)
    main = settle(vertices, drop_dangling(largest))
    if len(main) < _FEWEST_FACES:
        raise _nothing_left(len(mesh.faces), len(main))
    start = with_faces(Mesh(vertices_mm=vertices, faces=main), main)
    start = replace(start, faces=_outwards(start.vertices_mm, start.faces, cloud))
    openings = find_openings(
        start.vertices_mm, start.faces, options.brim_share_at_end, options.brim_share
    )
    whole = fill_holes(start.vertices_mm, start.faces, openings.holes)
    brim = openings.brim
    _check(whole.faces, 0 if brim is None else 1)
    nearest = KDTree(cloud.points_mm).query(whole.vertices_mm)[1]
    return replace(
        whole,
        colours=cloud.colours[nearest],
        repairs=Repairs(
            islands_dropped=islands - 1,
            island_faces_dropped=len(faces) - len(largest),
            island_share=1 - len(largest) / len(faces),
            holes_filled=len(openings.holes),
            filled_share=_filled_share(whole),
            brim_mm=0.0 if brim is None else _length(whole.vertices_mm[brim]),
        ),
    )


def _outwards(vertices: Points3, faces: Faces, cloud: Cloud) -> Faces:
    """Faces turned so that the normals look the way of the cloud's."""
    mesh = Mesh(vertices_mm=vertices, faces=faces)
    nearest = KDTree(cloud.points_mm).query(vertices)[1]
    agreement = (mesh.vertex_normals() * cloud.normals[nearest]).sum()
    return faces if agreement > 0 else np.ascontiguousarray(faces[:, ::-1])


def _check(faces: Faces, openings: int) -> None:
    whole = is_edge_manifold(faces) and is_vertex_manifold(faces)
    if not whole or len(boundary_loops(faces)) != openings or face_components(faces).any():
        raise SurfaceError(
            "The holes of the surface could not be closed. The cloud is probably torn to "
            "shreds: look at its picture, and add photos where points are missing."
        )


def _filled_share(mesh: Mesh) -> float:
    filled = np.zeros(len(mesh), np.bool_) if mesh.filled is None else mesh.filled
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    return float(areas[filled[mesh.faces].any(1)].sum() / areas.sum())


def _length(loop: Points3) -> float:
    return float(np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).sum())


def _nothing_left(before: int, after: int) -> SurfaceError:
    return SurfaceError(
        f"Of {before} triangles only {after} make a surface. The points are probably too few or "
        "too noisy: check the depth maps and the cloud, and take sharper or more photos."
    )
