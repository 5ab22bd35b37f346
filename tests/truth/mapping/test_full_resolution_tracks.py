"""Following points on a painted plane whose photos are known everywhere, not only at pixels."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import Camera, View
from limbgram.findings import fault
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.full_resolution_tracks import FollowingOptions, follow_points
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet

LENS = Camera(width_px=560, height_px=420, fx=900.0, fy=900.0, cx=279.5, cy=209.5, k1=-0.05)
SIGMAS = np.array([0.3, 0.3, 0.5, 0.5, 0.0, 1e-3, 1e-3, 1e-5, 1e-5, 0.0])
LEANING_DEG = (0.0, 18.0, -20.0, 34.0, -38.0)
LYING_DEG = 78.0
"""A photo that looks at the plane too flatly to be asked."""
COARSE_PX = 0.4
POINTS = 250


def paint(x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
    """Luma of the plane: waves between 4 and 25 mm long."""
    rng = np.random.default_rng(3)
    direction, length = rng.uniform(0, 2 * np.pi, 80), rng.uniform(4, 25, 80)
    total = np.zeros(x_mm.shape)
    for angle, wave, phase in zip(direction, length, rng.uniform(0, 2 * np.pi, 80)):
        along = np.cos(angle) * x_mm + np.sin(angle) * y_mm
        total += np.cos(2 * np.pi * along / wave + phase)
    return 128 + 6.0 * total


def view_leaning(degrees: float) -> View:
    turn = np.radians(degrees)
    centre = 600.0 * np.array([np.sin(turn), 0.1, np.cos(turn)])
    return View(
        f"{degrees:.0f}", LENS, Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 1, 0]))
    )


def photographed(view: View, noise: float, seed: int) -> np.ndarray:
    y, x = np.mgrid[: LENS.height_px, : LENS.width_px].astype(float)
    rays = LENS.rays(np.column_stack([x.ravel(), y.ravel()])) @ view.camera_from_world.rotation
    far = -view.centre_in_world[2] / rays[:, 2]
    place = view.centre_in_world + far[:, None] * rays
    luma = paint(place[:, 0], place[:, 1]).reshape(x.shape)
    luma += np.random.default_rng(seed).normal(0, noise, luma.shape)
    return np.clip(np.rint(luma), 0, 255).astype(np.uint8)


@dataclass(frozen=True)
class Capture:
    photos: PhotoSet
    scene: Scene
    cameras: Cameras
    views: tuple[View, ...]


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    """Photos of the plane, each point roughly seen in two of them, and a wrong one in each."""
    folder: Path = tmp_path_factory.mktemp("plane")
    views = tuple(view_leaning(degrees) for degrees in (*LEANING_DEG, LYING_DEG))
    shared = {"width_px": LENS.width_px, "height_px": LENS.height_px, "exif": Exif()}
    photos = []
    for k, view in enumerate(views):
        path = folder / f"{k}.png"
        cv2.imwrite(str(path), photographed(view, 2.0, k))
        photos.append(Photo(name=path.name, path=path, sha256="", camera_idx=0, **shared))
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-90, 90, POINTS), rng.uniform(-70, 70, POINTS)])
    points = np.column_stack([points, np.zeros(POINTS)])
    seen = np.sort(np.array([rng.permutation(len(LEANING_DEG))[:2] for _ in points]), axis=1)
    xy_px = np.array([views[photo].project(points[k : k + 1])[0] for k in range(POINTS)
                      for photo in seen[k]])  # fmt: skip
    scene = Scene(
        names=tuple(photo.name for photo in photos),
        cameras=(LENS,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points + rng.normal(0, 0.3, points.shape),
        observations=Observations(
            seen.ravel().astype(np.int32),
            np.repeat(np.arange(POINTS, dtype=np.int32), 2),
            xy_px + rng.normal(0, COARSE_PX, xy_px.shape),
        ),
        verdicts=tuple(
            PhotoVerdict(name=p.name, placed=True, points=0, rms_px=0.0) for p in photos
        ),
    )
    calibration = Calibration(camera=LENS, covariance=np.diag(SIGMAS**2), source="board")
    return Capture(
        PhotoSet(tuple(photos), (CameraGroup(label="made up", **shared),)),
        scene,
        Cameras((calibration,)),
        views,
    )


@pytest.fixture(scope="module")
def followed(capture: Capture) -> Scene:
    return follow_points(capture.photos, capture.scene, capture.cameras)


def test_points_are_found_in_every_photo_that_looks_at_them_and_in_no_other(
    followed: Scene,
) -> None:
    seen = followed.observations
    rays = np.bincount(seen.point_idx)
    assert len(followed.points_in_world) > 0.8 * POINTS
    assert np.median(rays) == len(LEANING_DEG)
    assert followed.placed == tuple(range(len(LEANING_DEG)))
    assert followed.verdicts[-1].reason == fault("placing.photo.unfollowed", points=0)
    assert [one.points for one in followed.verdicts] == np.bincount(
        seen.photo_idx, minlength=6
    ).tolist()


def test_they_are_measured_many_times_better_than_they_were_placed(followed: Scene) -> None:
    assert 0.003 < followed.sigma_px < COARSE_PX / 10  # lower: the photos have noise


def test_the_points_come_to_lie_on_the_plane(capture: Capture, followed: Scene) -> None:
    centres = np.array([view.centre_in_world for view in followed.views[: len(LEANING_DEG)]])
    truth = np.array([view.centre_in_world for view in capture.views[: len(LEANING_DEG)]])
    fit = fit_similarity(centres, truth)
    heights_mm = fit.apply(followed.points_in_world)[:, 2]
    plane = np.polynomial.polynomial.polyfit(np.arange(len(heights_mm)), heights_mm, 0)[0]
    assert np.std(heights_mm - plane) < 0.1
    assert np.std(capture.scene.points_in_world[:, 2]) > 0.25


def test_fewer_tries_keep_points_in_all_parts_of_the_photos(capture: Capture) -> None:
    few = follow_points(
        capture.photos, capture.scene, capture.cameras, FollowingOptions(tries_a_photo=(80, 80))
    )
    assert 0.2 * POINTS < len(few.points_in_world) < 0.8 * POINTS
    x, y = few.points_in_world[:, :2].T
    for left in (x < 0, x > 0):
        for low in (y < 0, y > 0):
            assert (left & low).mean() > 0.15


def test_the_same_photos_give_the_same_bytes(capture: Capture, followed: Scene) -> None:
    again = follow_points(capture.photos, capture.scene, capture.cameras)
    assert again.observations.xy_px.tobytes() == followed.observations.xy_px.tobytes()
    assert again.points_in_world.tobytes() == followed.points_in_world.tobytes()
