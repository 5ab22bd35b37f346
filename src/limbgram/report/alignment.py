"""Alignment: the rigid alignment of a surface with its truth, and signed distances between them.

Never by a scale: a wrong scale is an error of the surface and has to show.

The steps to the nearest place are its own, beside `workbench.compare.icp`: what judges is simple
enough to be checked by eye, and does not change when the comparison of shapes is improved. It also
asks for less: only what three photos saw of the truth counts, and the truth has no brim.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Faces, Points3
from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface

_SAMPLES = 10_000
_ROUNDS = 12
_STILL_MM = 1e-5
"""A step that moves no sample farther ends the alignment."""
_FAR_MM = 3.0
"""Samples farther away take no part in the alignment."""
COMPARED_MM = 5 * _FAR_MM
"""What lies farther from the truth is not compared with it: it is another thing's surface."""
_FEWEST_NEAR = 30
_TRIAL_SAMPLES = 1_000
_TRIAL_ROUNDS = 10
_TRIAL_FAR_MM = 60.0
_TURNS = 8
"""Turns about the long axis from which a truth in a frame of its own is tried."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The true surface."""

    vertices_mm: Points3
    faces: Faces
    seen: Bool[np.ndarray, " n"]
    """True at vertices that three photos or more show."""
    centres_mm: Float64[np.ndarray, "photos 3"]
    """Where the photos were taken; none where the truth tells nothing of them."""

    def moved(self, new_from_truth: Rigid) -> "Truth":
        """The true surface in another frame."""
        return replace(
            self,
            vertices_mm=new_from_truth.apply(self.vertices_mm),
            centres_mm=new_from_truth.apply(self.centres_mm),
        )

    @cached_property
    def surface(self) -> SignedSurface:
        return SignedSurface(self.vertices_mm, self.faces)


@dataclass(frozen=True)
class Fit:
    """A rigid alignment, and the scale error that it leaves, as a fraction."""

    truth_from_world: Rigid
    scale_error: float


def align_by_cameras(centres_mm: Points3, truth: Truth) -> Rigid:
    """truth_from_world by the camera centres alone."""
    found = fit_similarity(centres_mm, truth.centres_mm, with_scale=False)
    return Rigid(found.rotation, found.translation)


def align_by_surface(points_mm: Points3, truth: Truth, start: Rigid) -> Fit:
    """Align by point-to-plane ICP from a start within millimetres."""
    pose, scale = start, 0.0
    for _ in range(_ROUNDS):
        placed = pose.apply(points_mm)
        step, scale = _point_to_plane_step(placed, truth, _FAR_MM)
        pose = step @ pose
        if np.abs(pose.apply(points_mm) - placed).max() < _STILL_MM:
            break
    return Fit(pose, scale)


def align_from_anywhere(points_mm: Points3, truth: Truth) -> Rigid:
    """truth_from_world near the truth, wherever its frame is: the best of several starts."""
    step = max(1, len(points_mm) // _TRIAL_SAMPLES)
    trial = points_mm[::step]
    best, least = Rigid.identity(), np.inf
    for start in _start_poses(trial, truth):
        pose = start
        for far_mm in np.geomspace(_TRIAL_FAR_MM, _FAR_MM, _TRIAL_ROUNDS):
            pose = _point_to_plane_step(pose.apply(trial), truth, float(far_mm))[0] @ pose
        off = float(np.median(truth.surface.tree.closest(pose.apply(trial)).distances_mm))
        if off < least:
            best, least = pose, off
    return best


def signed_mm(
    points_mm: Points3, truth: Truth
) -> tuple[Float64[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """Distances from the truth, positive outside, and whether the seen truth is what is near."""
    found = truth.surface.query(points_mm)
    near = np.abs(found.signed_mm) < COMPARED_MM
    return found.signed_mm, truth.seen[truth.faces[found.faces]].all(1) & near


def measured_samples(mesh: Mesh) -> np.ndarray:
    """Indices of vertices that were measured, evenly thinned."""
    idx = np.flatnonzero(mesh.measured)
    return idx[:: max(1, len(idx) // _SAMPLES)]


def _start_poses(points_mm: Points3, truth: Truth) -> Iterator[Rigid]:
    """Start poses: as it lies, and long axis on long axis, both ways up, turned in steps."""
    yield Rigid.identity()
    seen = truth.vertices_mm[truth.seen]
    ours, theirs = _principal_axes(points_mm), _principal_axes(seen)
    for flip in (np.eye(3), np.diag([1.0, -1.0, -1.0])):
        for angle in np.arange(_TURNS) * 2 * np.pi / _TURNS:
            turn = Rigid.from_rotation_vector(np.array([angle, 0.0, 0.0]), np.zeros(3)).rotation
            rotation = theirs @ turn @ flip @ ours.T
            yield Rigid(rotation, seen.mean(0) - rotation @ points_mm.mean(0))


def _principal_axes(points_mm: Points3) -> Float64[np.ndarray, "3 3"]:
    """Columns: principal axes, the longest first, right-handed."""
    axes = np.linalg.svd(points_mm - points_mm.mean(0), full_matrices=False)[2].T
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return axes


def _point_to_plane_step(points_mm: Points3, truth: Truth, far_mm: float) -> tuple[Rigid, float]:
    """One point-to-plane step (Chen and Medioni 1992), and the scale error that it leaves."""
    found = truth.surface.tree.closest(points_mm)
    near = (found.distances_mm < far_mm) & truth.seen[truth.faces[found.faces]].all(1)
    if near.sum() < _FEWEST_NEAR:
        return Rigid.identity(), float("nan")
    points, normals = points_mm[near], truth.surface.flat_normals[found.faces[near]]
    off = np.einsum("nc,nc->n", points - found.points_mm[near], normals)
    middle = points.mean(0)
    arms = points - middle
    columns = np.column_stack(
        [np.cross(arms, normals), normals, np.einsum("nc,nc->n", arms, normals)]
    )
    with_scale = np.linalg.lstsq(columns, -off, rcond=None)[0]
    rigid = np.linalg.lstsq(columns[:, :6], -off, rcond=None)[0]
    turn = Rigid.from_rotation_vector(rigid[:3], np.zeros(3)).rotation
    return Rigid(turn, middle + rigid[3:] - turn @ middle), -float(with_scale[6])
