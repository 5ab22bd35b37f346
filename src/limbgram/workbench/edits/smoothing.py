"""Smoothing: wrinkles taken off while the volume stays.

Method  Taubin 1995: each pass takes a step to the neighbours' mean and a slightly larger one back,
        along the normal only, so that waves longer than some edges stay; what volume that still
        costs is put back along the normals, spread over all that was free to move.
"""

from typing import Annotated

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh, dots
from limbgram.core.mesh.topology import faces_touching, volume_mm3
from limbgram.core.request_fields import Within
from limbgram.core.run import track
from limbgram.workbench.edits.areas import falloff
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, FromZeroMm, Words, edit, spoken
from limbgram.workbench.edits.guard import require_sound, unsound_vertices
from limbgram.workbench.edits.regions import (
    FrameName,
    Place,
    displaced,
    distances_from,
    distances_from_point,
    neighbour_averaging,
    on_open_edge,
    on_surface,
    position_mm,
)
from limbgram.workbench.limb import Limb

_LAMBDA, _MU = 0.60, -0.63
"""Taubin's two steps: waves of more than about 11 edges stay (1 / 0.60 - 1 / 0.63 = 0.08)."""
_VOLUME_ROUNDS = 4
_FOLD_ROUNDS = 4
_VOLUME_KEPT, _TOUCH_MM3 = 5e-4, 1.0


@edit(
    group="surface",
    order=2,
    effect=Effect(moves_skin=True),
    everyday=True,
    rarely=("leave", "leave_mm", "positions_in"),
    guarded=False,
    example={"passes": 5},
)
class Smoothing(Edit):
    """Take wrinkles off; the volume stays, the brim and marked places stay where they are."""

    passes: Annotated[int, Within(1, 500)] = 10
    """More passes calm more; 5 for a good scan, 20 for a rough one."""
    brim_mm: FromZeroMm = 5.0
    """Width along the open brim that stays as it is, and again as much over which it begins."""
    leave: tuple[Place, ...] = ()
    """Places that stay as they are."""
    leave_mm: AboveZeroMm = 15.0
    """Radius round those places that stays, and again a third over which it begins."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    words = spoken(
        en=Words(
            name="Smooth",
            title="The smoothing",
            labels={"brim_mm": "Brim left alone", "leave_mm": "Left round each place"},
        ),
        de=Words(
            name="Glätten",
            title="Das Glätten",
            does="Falten wegnehmen; das Volumen bleibt, Rand und markierte Stellen bleiben, wo sie "
            "sind.",
            labels={
                "passes": "Durchgänge",
                "brim_mm": "Rand bleibt",
                "leave": "Stellen, die bleiben",
                "leave_mm": "Umkreis, der bleibt",
                "positions_in": "Koordinaten gelten",
            },
            help={
                "passes": "Mehr Durchgänge glätten mehr; 5 für einen guten Scan, 20 für einen "
                "rauen.",
                "brim_mm": "Breite am offenen Rand, die bleibt, und noch einmal so viel, über die "
                "es beginnt.",
                "leave": "Stellen, die bleiben, wie sie sind.",
                "leave_mm": "Radius um diese Stellen, der bleibt, und noch ein Drittel, über das "
                "es beginnt.",
                "positions_in": "Koordinatensystem der Punkte.",
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Smooth the surface.

        Raises:
            EditError: numbers that make no sense, or a surface that would fold.
        """
        free = movable_shares(limb, self)
        if not (free > 0).any():
            raise EditError("edit.smoothing.nothing")
        smooth = taubin_smoothed(limb.mesh, free, self.passes)
        spoilt = np.ones(len(smooth), np.bool_)
        for _ in range(_FOLD_ROUNDS):
            spoilt = unsound_vertices(limb.mesh, smooth)
            if not spoilt.any():
                break
            # Where triangles would fold, their surroundings stay as they are.
            for _ in range(2):
                spoilt[limb.mesh.faces[faces_touching(spoilt, limb.mesh.faces)]] = True
            free[spoilt] = 0.0
            if not free.any():
                raise EditError("edit.smoothing.folds")
            smooth = taubin_smoothed(limb.mesh, free, self.passes)
        before, after = volume_mm3(limb.mesh), volume_mm3(smooth)
        if not abs(after - before) <= _VOLUME_KEPT * abs(before) + _TOUCH_MM3:
            raise EditError("edit.smoothing.volume", change_ml=(after - before) / 1000)
        changed = displaced(limb, smooth.vertices_mm)
        if spoilt.any():  # else this very shape was found sound above
            require_sound(limb.mesh, changed.mesh)
        return changed


def taubin_smoothed(mesh: Mesh, free: Float64[np.ndarray, " n"], passes: int) -> Mesh:
    """The mesh after Taubin smoothing, with its volume restored.

    Args:
        free: Share of each step that each vertex takes, 0 to 1.
    """
    mean = neighbour_averaging(mesh)
    work = mesh
    for _ in track(range(passes)):
        for share in (_LAMBDA, _MU):
            normals = work.vertex_normals()
            towards = mean @ work.vertices_mm - work.vertices_mm
            along = dots(towards, normals) * free * share
            work = work.with_vertices(work.vertices_mm + along[:, None] * normals)
    return with_volume_restored(work, volume_mm3(mesh), free)


def with_volume_restored(mesh: Mesh, wanted_mm3: float, free: Float64[np.ndarray, " n"]) -> Mesh:
    """The mesh moved along its normals, where it may move, until it has a given volume.

    Raises:
        EditError: nothing that is free to move would change it.
    """
    for _ in range(_VOLUME_ROUNDS):
        normals = mesh.vertex_normals()
        gain = _volume_gain(mesh, free[:, None] * normals)
        if not gain > 0:
            raise EditError("edit.smoothing.held")
        step = (wanted_mm3 - volume_mm3(mesh)) / gain
        mesh = mesh.with_vertices(mesh.vertices_mm + step * free[:, None] * normals)
    return mesh


def movable_shares(limb: Limb, edit: Smoothing) -> Float64[np.ndarray, " n"]:
    """Share by which each vertex may move: 1, but 0 at the brim and round places to leave."""
    mesh = limb.mesh
    free = np.ones(len(mesh))
    brim = on_open_edge(mesh)
    if brim.any():
        limit = max(2 * edit.brim_mm, 1e-6)
        start = np.where(brim, 0.0, np.inf)
        distance = distances_from(mesh, start, np.ones(len(mesh), np.bool_), limit)
        free *= 1 - falloff((distance - edit.brim_mm) / max(edit.brim_mm, 1e-6))
        free[brim] = 0.0
    for place in edit.leave:
        point = on_surface(limb, position_mm(limb, place, edit.positions_in)[None])[0]
        ramp = edit.leave_mm / 3
        distance = distances_from_point(mesh, point, edit.leave_mm + ramp)
        free *= 1 - falloff((distance - edit.leave_mm) / ramp)
    return free


def _volume_gain(mesh: Mesh, direction: Float64[np.ndarray, "n 3"]) -> float:
    """Derivative of the volume along a field of vertex displacements."""
    normals = mesh.face_normals() / 2
    return float((_face_means(direction, mesh.faces) * normals).sum())


@njit(cache=True, nogil=True)
def _face_means(values: np.ndarray, faces: np.ndarray):
    """Mean over each face's corners: values[faces].mean(1), to the last bit."""
    found = np.empty((len(faces), 3))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for axis in range(3):
            found[f, axis] = (values[a, axis] + values[b, axis] + values[c, axis]) / 3
    return found
