"""The truth: where everything is, known exactly before a picture is taken.

In      CaptureOptions.
Out     a Truth: the limb, the views, the boards. Its views and `surface_points` give later
        stages something to test against without a picture being rendered.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.run import in_parallel
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import camera_of, film_round, over_board, walk_round
from limbgram.synthetic.props.board import CALIBRATION_BOARD, LaidBoard, lay_alone, lay_beside
from limbgram.synthetic.props.limb import Limb, make_limb
from limbgram.synthetic.rendering.renderer import seen

BASE_MM = 60.0
_AIM = 0.2
"""Fraction of the limb's height that is looked at, so that the board is in the picture."""
_FIRST_PHOTO, _FIRST_CALIBRATION_PHOTO = 1001, 901


@dataclass(frozen=True)
class Truth:
    """A capture before its pictures are taken."""

    limb: Limb
    views: tuple[View, ...]
    calibration_views: tuple[View, ...]
    """Their world frame is the calibration board's table, not the limb's."""
    board: LaidBoard | None
    calibration_board: LaidBoard


@dataclass(frozen=True)
class SurfacePoints:
    """Points on the limb's skin with outward unit normals."""

    points_in_world: Points3
    normals_in_world: Points3
    seen: Bool[np.ndarray, "n views"]
    """Which view sees which point."""


def stage_truth(options: CaptureOptions) -> Truth:
    """Build the limb, place the boards, and decide where every photo is taken from."""
    limb = make_limb(
        options.kind, options.seed, options.mesh_step_mm, BASE_MM, options.fin_mm, options.relief
    )
    camera = camera_of(options.lens, options.width_px, options.height_px, options.distance_mm)
    target = np.array([0.0, 0.0, BASE_MM + _AIM * limb.height_mm])
    ring = (
        film_round(target, options.distance_mm, options.photos, options.seed)
        if options.filmed
        else walk_round(target, options.distance_mm, options.photos, options.rings, options.seed)
    )
    bench = lay_alone(CALIBRATION_BOARD, options.seed)
    tilted = over_board(bench.outline_in_world(), camera, options.calibration_photos, options.seed)
    return Truth(
        limb=limb,
        views=tuple(
            View(f"IMG_{_FIRST_PHOTO + k}.jpg", camera, pose) for k, pose in enumerate(ring)
        ),
        calibration_views=tuple(
            View(f"CAL_{_FIRST_CALIBRATION_PHOTO + k:04d}.jpg", camera, pose)
            for k, pose in enumerate(tilted)
        ),
        board=None if options.board is None else lay_beside(options.board, options.seed),
        calibration_board=bench,
    )


def surface_points(truth: Truth, count: int, seed: int = 0) -> SurfacePoints:
    """Random vertices of the skin, each seen by two views or more, spread evenly by area."""
    visible = np.stack(in_parallel(lambda view: seen(view, truth.limb), truth.views), -1)
    mesh = truth.limb.mesh
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    shares = np.bincount(mesh.faces.ravel(), np.repeat(areas, 3), len(mesh.vertices_mm))
    shares[truth.limb.cut | (visible.sum(1) < 2)] = 0.0
    rng = np.random.default_rng((seed, 9))
    chosen = np.sort(rng.choice(len(shares), count, replace=False, p=shares / shares.sum()))
    return SurfacePoints(mesh.vertices_mm[chosen], truth.limb.normals[chosen], visible[chosen])
