"""Closing: keeps a solid closed after an edit that opened it.

In      a shape that an edit left open, and that was closed before it.
Out     the same, closed along what the edit opened; its vertices do not move.
Method  Openings that lie in one plane are capped together, so that a wall that was cut level has a
        flat rim. Two openings that run against each other, as those of a wall's skins do, are
        joined by a strip across the wall. What is left is spanned with least area.
Fails   EditError: an outline crosses itself, or the shape stays open.
"""

import numpy as np
from jaxtyping import Int64
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import (
    boundary_half_edges,
    boundary_loops,
    enclosed_by,
    is_edge_manifold,
    is_watertight,
    split_nonmanifold_vertices,
    with_faces,
)
from limbgram.findings import Finding, note
from limbgram.reconstruction.surface.holes import loop_area
from limbgram.workbench.edits.cutting import cap
from limbgram.workbench.edits.level_edges import Plane
from limbgram.workbench.edits.membrane import with_openings_spanned
from limbgram.workbench.edits.regions import with_surface_added
from limbgram.workbench.edits.triangle_strip import strip


def enclosure_finding(mesh: Mesh) -> Finding:
    """A note of whether a shape is watertight, and of its volume."""
    found = enclosed_by(mesh)
    return note(
        "edit.enclosed",
        watertight=found.watertight,
        open_edges=found.open_edges,
        volume_ml=found.volume_mm3 / 1000,
    )


def closed_again(before: Mesh, after: Mesh) -> Mesh:
    """The shape after an edit, closed where it was closed before.

    Raises:
        EditError: it was closed, is open, and cannot be closed.
    """
    if is_watertight(after.faces) or not is_watertight(before.faces):
        return after
    if not len(after.faces) or not is_edge_manifold(after.faces):
        raise EditError("edit.branches")
    closed = with_openings_joined(split_nonmanifold_vertices(after))
    if len(boundary_half_edges(closed.faces)):
        closed = with_openings_spanned(closed)
        closed = with_faces(closed, closed.faces)
    left = boundary_half_edges(closed.faces)
    if len(left):
        point_mm = tuple(closed.vertices_mm[left[0, 0]].tolist())
        raise EditError("edit.opened", open_edges=len(left), point_mm=point_mm)
    return closed


def with_openings_joined(mesh: Mesh) -> Mesh:
    """The mesh with coplanar or opposite openings joined; its own faces come first.

    Raises:
        EditError: an outline crosses itself.
    """
    return _with_strips(_with_flat_caps(mesh))


def _with_flat_caps(mesh: Mesh) -> Mesh:
    """The mesh with its flat openings capped, those in one plane together."""
    while True:
        loops = [loop.astype(np.int64) for loop in boundary_loops(mesh.faces)]
        plane = next((one for one in (Plane.of_loop(mesh, loop) for loop in loops) if one), None)
        if plane is None:
            return mesh
        on_it = np.zeros(len(mesh), np.bool_)
        for loop in loops:
            on_it[loop] = plane.holds(mesh.vertices_mm[loop]).all()
        capped = cap(mesh, on_it)
        if len(boundary_half_edges(capped.faces)) == len(boundary_half_edges(mesh.faces)):
            return mesh
        mesh = capped


def _with_strips(mesh: Mesh) -> Mesh:
    """The mesh with a strip between any two opposite openings that are nearest to each other."""
    loops = [loop.astype(np.int64) for loop in boundary_loops(mesh.faces)]
    if len(loops) < 2:
        return mesh
    ways = unit(np.stack([loop_area(mesh.vertices_mm[loop]) for loop in loops]))
    against = ways @ ways.T < 0
    apart = np.array([[_mean_distance_mm(mesh, one, two) for two in loops] for one in loops])
    apart = np.where(against, apart, np.inf)
    nearest = apart.argmin(1)
    strips: list[np.ndarray] = []
    for one, two in enumerate(nearest.tolist()):
        if one < two and nearest[two] == one and np.isfinite(apart[one, two]):
            back = loops[two][::-1]
            numbers = np.concatenate([loops[one], back])
            strips.append(numbers[strip(mesh.vertices_mm[loops[one]], mesh.vertices_mm[back])])
    if not strips:
        return mesh
    none = np.empty(0, np.int64)
    return with_surface_added(mesh, np.empty((0, 3)), none, np.concatenate(strips).astype(np.int32))


def _mean_distance_mm(
    mesh: Mesh, one: Int64[np.ndarray, " k"], two: Int64[np.ndarray, " l"]
) -> float:
    """Mean distance of the first loop's vertices from the second loop."""
    return float(KDTree(mesh.vertices_mm[two]).query(mesh.vertices_mm[one])[0].mean())
