"""Shared errors: what cameras and scale do to the whole surface at once.

In      the metric scene with the covariance of its cameras, the mesh, which photos measured what.
Out     displacement along the normal of every vertex, for one standard deviation of each source.
Method  A photo moved by p sees another point of the tangent plane, s_k p away; the surface moves by
        -sum (t_k - t)'(s_k - s) / sum |t_k - t|^2 to make the photos agree again, t_k being how far
        along the plane photo k moves for a millimetre along the normal, t and s their means
        (texture alike in all directions). The scale is set anew from the board in each case, and
        what only moves the surface as a whole is taken off: a shape has no place.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int32

from limbgram.geometry.arrays import Points3
from limbgram.geometry.projection import LENS_SIZE, POSE_SIZE, differentiate_all
from limbgram.mapping.scene import Scene
from limbgram.scale.metric import MetricScene
from limbgram.surface.mesh import Mesh

_CAMERA_MODES, _WEAKER_MODES = 6, 5
"""Sources kept by themselves beside the scale; the next ones go to the local part."""
_ASKED = 2000
"""Vertices that tell which modes are strong."""
_LEAST_SPREAD = 1e-4
"""Photos that look along nearly one ray (mean square of t_k - t) do not measure."""


@dataclass(frozen=True, kw_only=True)
class SharedErrors:
    """By vertex, along the normal."""

    modes_mm: Float64[np.ndarray, "n k"]
    """The scale first, then the cameras' strongest modes."""
    rest_mm2: Float64[np.ndarray, " n"]
    """Variance of the cameras' other modes."""


def shared_errors(
    mesh: Mesh,
    axes: Float64[np.ndarray, "n 3 3"],
    seen_by: Int32[np.ndarray, "n c"],
    measured: Bool[np.ndarray, " n"],
    metric: MetricScene,
) -> SharedErrors:
    """Scale and camera errors on the surface."""
    asked = np.flatnonzero(measured)
    asked = asked[:: max(1, len(asked) // _ASKED)]
    vertices, normals = mesh.vertices_mm, axes[:, 2]
    arms = vertices - (vertices[asked] if len(asked) else vertices).mean(0)
    growth = np.einsum("ni,ni->n", arms, normals)
    in_place = np.hstack([normals, np.cross(arms, normals)])
    scale = np.nan_to_num(metric.scale.relative_sigma) * growth[:, None]
    scale -= in_place @ _laid(in_place[asked], scale[asked])
    covariance = metric.scene.camera_covariance
    if covariance is None or not len(asked):
        return SharedErrors(modes_mm=scale, rest_mm2=np.zeros(len(mesh)))

    root = _root(covariance)
    by_cameras = metric.scale.by_cameras
    if by_cameras is None:  # the scale was found otherwise: cameras do not make it grow
        in_place = np.hstack([in_place, growth[:, None]])
        by_cameras = np.zeros(len(root))
    few = _displacements(vertices[asked], axes[asked], seen_by[asked], metric.scene, root)
    few += np.outer(growth[asked], by_cameras @ root)
    laid = _laid(in_place[asked], few)
    few -= in_place[asked] @ laid
    values, turn = np.linalg.eigh(few.T @ few)
    strongest = turn[:, np.argsort(-values)[: _CAMERA_MODES + _WEAKER_MODES]]
    modes = _displacements(vertices, axes, seen_by, metric.scene, root @ strongest)
    modes += np.outer(growth, by_cameras @ root @ strongest) - in_place @ (laid @ strongest)
    return SharedErrors(
        modes_mm=np.hstack([scale, modes[:, :_CAMERA_MODES]]),
        rest_mm2=(modes[:, _CAMERA_MODES:] ** 2).sum(1),
    )


def _laid(
    in_place: Float64[np.ndarray, "m g"], moves: Float64[np.ndarray, "m r"]
) -> Float64[np.ndarray, "g r"]:
    """Shifts and turns that lay moved surfaces on themselves again."""
    return np.linalg.lstsq(in_place, moves, rcond=None)[0]


def _root(covariance: Float64[np.ndarray, "u u"]) -> Float64[np.ndarray, "u r"]:
    """Columns whose outer products add up to the covariance."""
    sigma = np.sqrt(np.diag(covariance))
    scale = np.where(sigma > 0, sigma, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = values > 1e-12 * values[-1]
    return scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def _displacements(
    vertices: Points3,
    axes: Float64[np.ndarray, "n 3 3"],
    seen_by: Int32[np.ndarray, "n c"],
    scene: Scene,
    root: Float64[np.ndarray, "u r"],
) -> Float64[np.ndarray, "n r"]:
    """Moves along the normal for each column of camera numbers."""
    count = (seen_by >= 0).sum(1)
    sum_t, sum_s = np.zeros((len(vertices), 2)), np.zeros((len(vertices), 2, root.shape[1]))
    sum_tt, sum_ts = np.zeros(len(vertices)), np.zeros((len(vertices), root.shape[1]))
    lenses = POSE_SIZE * len(scene.placed)
    for k, photo in enumerate(scene.placed):
        rows = np.flatnonzero((seen_by == k).any(1))
        by_point, by_pose = np.zeros((len(rows), 2, 3)), np.zeros((len(rows), 2, POSE_SIZE))
        by_lens = np.zeros((len(rows), 2, LENS_SIZE))
        differentiate_all(scene.view(photo).packed, vertices[rows], by_point, by_pose, by_lens)
        in_frame = np.einsum("nai,nji->naj", by_point, axes[rows])
        first = lenses + LENS_SIZE * scene.camera_idx[photo]
        pixels = by_pose @ root[POSE_SIZE * k : POSE_SIZE * (k + 1)]
        pixels += by_lens @ root[first : first + LENS_SIZE]
        plane = np.linalg.inv(in_frame[:, :, :2])
        t = np.einsum("nab,nb->na", plane, in_frame[:, :, 2])
        s = plane @ pixels
        sum_t[rows] += t
        sum_s[rows] += s
        sum_tt[rows] += (t * t).sum(1)
        sum_ts[rows] += np.einsum("na,nar->nr", t, s)
    mean_t = sum_t / np.maximum(count, 1)[:, None]
    spread = sum_tt - (mean_t * sum_t).sum(1)
    together = sum_ts - np.einsum("na,nar->nr", mean_t, sum_s)
    known = spread > _LEAST_SPREAD * count
    return np.where(known[:, None], -together / np.where(known, spread, 1.0)[:, None], 0.0)
