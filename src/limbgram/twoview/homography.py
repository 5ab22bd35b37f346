"""Planes and pure rotations: pairs whose matches one homography, or one rotation, explains.

They agree with a whole family of fundamental matrices, so F says nothing about them; a rotation
does not even have a baseline, so no depth can come from it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from limbgram.geometry.arrays import Matrix3, Points2, Points3
from limbgram.geometry.rigid import Rigid
from limbgram.twoview.fundamental import ransac

_ROUNDS = 5


@dataclass(frozen=True)
class RobustHomography:
    """x2 ~ H x1 in pixels freed of lens distortion, and the part of the matches it explains."""

    matrix: Matrix3
    share: float


def estimate_homography(
    xy_first: Points2, xy_second: Points2, *, threshold_px: float, seed: int = 0
) -> RobustHomography:
    """The homography that most matches obey to within `threshold_px`; needs 4 matches."""
    found, _ = cv2.findHomography(xy_first, xy_second, ransac(threshold_px, seed))
    homography = np.asarray(found, float)
    if homography.shape != (3, 3):
        return RobustHomography(np.eye(3), 0.0)
    image = np.hstack([xy_first, np.ones((len(xy_first), 1))]) @ homography.T
    distance = np.linalg.norm(image[:, :2] / image[:, 2:] - xy_second, axis=1)
    return RobustHomography(homography, float(np.mean(distance < threshold_px)))


def poses_from_homography(
    homography: Matrix3, first_matrix: Matrix3, second_matrix: Matrix3
) -> tuple[Rigid, ...]:
    """second_from_first of every plane that makes this homography (unit baselines).

    Two of them usually have the points in front of both cameras (Malis and Vargas 2007).
    """
    ideal = np.linalg.inv(second_matrix) @ homography @ first_matrix
    _, rotations, translations, _ = cv2.decomposeHomographyMat(ideal, np.eye(3))
    lengths = [float(np.linalg.norm(translation)) for translation in translations]
    return tuple(
        Rigid(np.asarray(rotation, float), np.asarray(translation, float).ravel() / length)
        for rotation, translation, length in zip(rotations, translations, lengths)
        if length > 0
    )


def rotation_share(
    ideal_first: Points2,
    ideal_second: Points2,
    second_matrix: Matrix3,
    *,
    threshold_px: float,
) -> float:
    """Share of the matches that a turn of the camera on its spot explains to `threshold_px`.

    The rotation is fitted to the rays and, a few times over, to the better half of them.
    """
    first, second = _rays(ideal_first), _rays(ideal_second)
    weights = np.ones(len(first))
    distance = np.zeros(len(first))
    for _ in range(_ROUNDS):
        u, _, vt = np.linalg.svd((second * weights[:, None]).T @ first)
        rotation = (u * [1.0, 1.0, np.linalg.det(u) * np.linalg.det(vt)]) @ vt
        seen = first @ rotation.T @ second_matrix.T
        wanted = second @ second_matrix.T
        distance = np.linalg.norm(seen[:, :2] / seen[:, 2:] - wanted[:, :2] / wanted[:, 2:], axis=1)
        weights = (distance <= np.median(distance)).astype(float)
    return float(np.mean(distance < threshold_px))


def _rays(ideal: Points2) -> Points3:
    rays = np.hstack([ideal, np.ones((len(ideal), 1))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
