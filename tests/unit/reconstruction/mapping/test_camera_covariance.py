"""The covariance of placed photos against adjustments of drawn measurements."""

import numpy as np

from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, Camera, with_pose_step
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.mapping.bundle_adjustment import Adjusted, adjust
from limbgram.reconstruction.mapping.scene import Observations, Scene

PHOTOS, POINTS, NOISE_PX, TRIALS = 6, 90, 0.3, 12
ALIKE = 9
"""Neighbours that err as one: what the adjustment takes residuals for (3 sigmas, squared)."""
CAMERA = Camera(width_px=900, height_px=900, fx=1500.0, fy=1500.0, cx=450.0, cy=450.0)
KNOWN = Calibration(
    label="", source="board", camera=CAMERA, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), rms_px=0.1
)


def drawn(seed: int) -> Scene:
    """A ring round a cloud of bunches of points, measured with a bunch's noise."""
    random = np.random.default_rng(seed)
    points = np.random.default_rng(0).normal(size=(POINTS, 3)) * 40.0
    poses: list[Rigid] = []
    xy: list[np.ndarray] = []
    for k in range(PHOTOS):
        turn = 2 * np.pi * k / PHOTOS
        centre = 600.0 * np.array([np.cos(turn), np.sin(turn), 0.2 * (k % 2)])
        poses.append(Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 0.0, 1.0])))
        exact = CAMERA.project(poses[-1].apply(points))
        xy.append(np.tile(exact + random.normal(0, NOISE_PX, exact.shape), (ALIKE, 1)))
    return Scene(
        names=tuple(f"{k}.jpg" for k in range(PHOTOS)),
        cameras=(CAMERA,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(poses),
        points_in_world=np.tile(points, (ALIKE, 1)),
        observations=Observations(
            np.repeat(np.arange(PHOTOS, dtype=np.int32), POINTS * ALIKE),
            np.tile(np.arange(POINTS * ALIKE, dtype=np.int32), PHOTOS),
            np.concatenate(xy),
        ),
        verdicts=(),
    )


def centre_errors(centres: np.ndarray) -> float:
    """Mean square distance from the true centres after a similarity."""
    true = np.array([view.centre_in_world for view in drawn(0).views])
    return float(np.mean((fit_similarity(centres, true).apply(centres) - true) ** 2))


def test_photos_scatter_as_their_covariance_says() -> None:
    solved = [adjust(drawn(seed), (KNOWN,), outlier_sigmas=6.0) for seed in range(1, TRIALS + 1)]
    actual = np.mean(
        [
            centre_errors(np.array([view.centre_in_world for view in one.scene.views]))
            for one in solved
        ]
    )
    told = _drawn_errors(solved[0])
    assert 0.6 < actual / told < 1.6


def test_held_lenses_have_no_variance_and_the_frame_carries_nothing() -> None:
    covariance = adjust(drawn(1), (KNOWN,)).covariance
    assert covariance.shape == (6 * PHOTOS + LENS_SIZE, 6 * PHOTOS + LENS_SIZE)
    assert np.abs(covariance[-LENS_SIZE:]).max() == 0
    values = np.linalg.eigvalsh(covariance[:-LENS_SIZE, :-LENS_SIZE])
    assert (values > 1e-9 * values[-1]).sum() == 6 * PHOTOS - 7


def _drawn_errors(adjusted: Adjusted) -> float:
    """The same mean square for steps drawn from the covariance, about the true poses."""
    views = [view.packed for view in drawn(0).views]
    random = np.random.default_rng(9)
    steps = random.multivariate_normal(
        np.zeros(len(adjusted.covariance)), adjusted.covariance, 300, method="eigh"
    )
    errors: list[float] = []
    for step in steps:
        rows = [with_pose_step(view, step[6 * k : 6 * k + 6]) for k, view in enumerate(views)]
        errors.append(
            centre_errors(np.array([-row[:9].reshape(3, 3).T @ row[9:12] for row in rows]))
        )
    return float(np.mean(errors))
