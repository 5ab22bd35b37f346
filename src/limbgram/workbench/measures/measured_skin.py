"""Measured skin: the surface to be measured: a wall's inside, or the skin under a sock.

Cut across, a wall that goes all round has an outline and, in it, the rim of a hollow. The triangles
whose cuts are such rims are the inside; turned over, they are the shape that the wall would hold,
and are measured like a limb: girths, widths, and the volume between levels. Where the wall is open
on a side, as a half shell is, the plane shows no hollow, and there is no inner girth. A sock's
thickness is taken off before anything is measured on the skin.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import MeasureError, OptionsError, refusals_about
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import face_components, find_edges, with_faces
from limbgram.workbench.bodies import outside_of
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.edits.sock import THICKEST_SOCK_MM, Sock
from limbgram.workbench.limb import AlignedLimb, AnyLimb, Limb
from limbgram.workbench.measures.levels import Level, all_levels_at

_SPACING_MM = 1.0
_FEWEST_PLANES, _MOST_PLANES = 60, 400
"""Number of planes that separate the skins; triangles between two planes follow neighbours."""
_SHIFT_SHARE = 0.381966
"""Share of a spacing by which the planes are shifted, so that they meet no row of vertices."""
HOLLOW_SHARE = 0.25
"""Share of an outline's area below which a hollow is a screw hole, not for a limb."""
_WALL_SHARE = 0.3
"""Share of levels with a hollow from which on a shape has two skins."""


def inside_of(limb: Limb) -> AlignedLimb:
    """The inside of an aligned limb's wall, facing outwards as the limb in it would.

    Raises:
        MeasureError: there is no hollow that the wall goes round.
    """
    limb = outside_of(limb.aligned())
    taken = inner_faces(limb.mesh_in_limb)
    if not taken.any():
        raise MeasureError("measure.inside.none")
    return replace(limb, mesh=with_faces(limb.mesh, limb.mesh.faces[taken][:, ::-1].copy()))


def inner_faces(mesh_in_limb: Mesh) -> Bool[np.ndarray, " f"]:
    """Triangles of the inside of a wall's largest hollow; none where it goes round no hollow."""
    mesh = mesh_in_limb
    inner = np.asarray(_inner_vertices(mesh)[mesh.faces].all(axis=1))
    taken = np.flatnonzero(inner)
    if len(taken):
        pieces = face_components(mesh.faces[taken])
        areas = np.bincount(pieces, np.linalg.norm(mesh.face_normals()[taken], axis=1))
        inner[taken[pieces != int(areas.argmax())]] = False
    return inner


def is_hollow(level: Level) -> bool:
    """Whether a level has an outline and a hollow in it that a limb could fill."""
    sizes = _areas_mm2(level)
    outlines, hollows = sizes[level.depth == 0], sizes[level.depth == 1]
    return bool(hollows.max(initial=0.0) > HOLLOW_SHARE * outlines.max(initial=0.0))


def is_two_skinned(levels: Sequence[Level]) -> bool:
    """Whether what was cut is a wall round a hollow rather than one surface."""
    hollow = sum(is_hollow(level) for level in levels)
    return bool(levels) and hollow >= _WALL_SHARE * len(levels)


def without_sock(limb: AnyLimb, sock_mm: float) -> AnyLimb:
    """The limb with the surface moved inwards by the sock; landmarks go along.

    What was taken off before counts: asking for the same sock again changes nothing.

    Raises:
        OptionsError: a thickness that no sock has, or less than was taken off already.
        EditError: the surface would cut through itself.
    """
    if not 0 <= sock_mm <= THICKEST_SOCK_MM:
        raise OptionsError("measure.sock.thickness", sock_mm=sock_mm)
    if sock_mm < limb.sock_mm:
        raise OptionsError("measure.sock.less", off_mm=limb.sock_mm, sock_mm=sock_mm)
    if sock_mm == limb.sock_mm:
        return limb
    with refusals_about(Sock.title):
        mesh = offset(limb.mesh, limb.sock_mm - sock_mm)
    marks = limb.landmarks
    if marks:
        tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
        places = tree.closest(np.stack([mark.position_mm for mark in marks])).points_mm
        marks = tuple(replace(mark, position_mm=place.copy()) for mark, place in zip(marks, places))
    return replace(limb, mesh=mesh, landmarks=marks, sock_mm=sock_mm)


def _inner_vertices(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Which vertices lie on the insides of hollows."""
    z = mesh.vertices_mm[:, 2]
    low, high = float(z.min()), float(z.max())
    count = int(np.clip((high - low) / _SPACING_MM, _FEWEST_PLANES, _MOST_PLANES))
    heights = low + (high - low) * (np.arange(count) + _SHIFT_SHARE) / count
    inner, known = np.zeros(len(mesh), np.bool_), np.zeros(len(mesh), np.bool_)
    levels = [one for one in all_levels_at(mesh, heights.tolist()) if isinstance(one, Level)]
    if not is_two_skinned(levels):
        return inner
    for level in levels:
        # A level through the brim runs along both skins in one loop, and one below the hollow has
        # none: neither tells the skins apart.
        if is_hollow(level):
            known[level.crossed.ravel()] = True
            inner[level.crossed[level.depth[level.loop] % 2 == 1].ravel()] = True
    return _spread_to_neighbours(mesh, inner, known)


def _spread_to_neighbours(
    mesh: Mesh, inner: Bool[np.ndarray, " n"], known: Bool[np.ndarray, " n"]
) -> Bool[np.ndarray, " n"]:
    """The inner vertices, with those that no plane met decided by their neighbours."""
    ends = find_edges(mesh.faces).ends
    inner, known = inner.copy(), known.copy()
    while not known.all():
        votes, heard = np.zeros(len(mesh)), np.zeros(len(mesh))
        for one, other in ((0, 1), (1, 0)):
            telling = known[ends[:, other]]
            heard += np.bincount(ends[telling, one], minlength=len(mesh))
            votes += np.bincount(
                ends[telling, one], inner[ends[telling, other]], minlength=len(mesh)
            )
        fresh = ~known & (heard > 0)
        if not fresh.any():
            return inner
        inner[fresh] = votes[fresh] > heard[fresh] / 2
        known |= fresh
    return inner


def _areas_mm2(level: Level) -> Float64[np.ndarray, " l"]:
    """Unsigned area of each loop."""
    x, y = (level.points_mm - level.points_mm.mean(0)).T
    after = level.after
    parts = np.bincount(level.loop, x * y[after] - x[after] * y, len(level.depth))
    return np.abs(parts) / 2
