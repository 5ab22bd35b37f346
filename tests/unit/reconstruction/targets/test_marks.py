"""Coded marks in renders whose corners are known exactly: flat, oblique, blurred, on round skin."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.edges import fit_square, linear_light
from limbgram.reconstruction.targets.marks import FoundMark, find_marks, marks_in
from limbgram.synthetic.mark_photo import MarkPhoto, MarkShot, photograph_mark

CAMERA = Camera(
    width_px=400, height_px=300, fx=1500.0, fy=1500.0, cx=203.1, cy=148.4, k1=-0.3, p1=0.002
)
FLAT = float("inf")


def held(seed: int, **more: object) -> MarkShot:
    """A mark tilted by up to 45 degrees, anywhere in the picture."""
    rng = np.random.default_rng(seed)
    tilt, azimuth = np.radians(rng.uniform(0, 45)), rng.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    turn = Rigid.from_rotation_vector(np.array([0, 0, rng.uniform(0, 6.28)]), np.zeros(3))
    leaning = Rigid.from_rotation_vector(tilt * axis, np.zeros(3)) @ turn
    far = rng.uniform(300, 450)
    place = np.array([rng.uniform(-0.06, 0.06) * far, rng.uniform(-0.045, 0.045) * far, far])
    return MarkShot(
        camera=CAMERA,
        camera_from_mark=Rigid(leaning.rotation, place),
        mark_id=int(rng.integers(0, 587)),
        twist_deg=float(rng.uniform(0, 90)),
        seed=seed,
        **more,  # pyright: ignore[reportArgumentType]
    )


def the_mark(shot: MarkShot, photo: MarkPhoto, camera: Camera | None = CAMERA) -> FoundMark:
    found = marks_in(photo.luma, shot.dictionary, camera)
    assert [one.mark_id for one in found] == [shot.mark_id]
    assert found[0].doubt is None
    return found[0]


def misses_px(count: int = 4, **more: object) -> np.ndarray:
    """Fitted minus true corners of several shots, and whether each was taken for bent."""
    off: list[np.ndarray] = []
    for seed in range(count):
        shot = held(seed, **more)
        photo = photograph_mark(shot)
        fit = the_mark(shot, photo).fit
        assert fit is not None
        assert fit.bent == np.isfinite(shot.radius_mm)
        off.append(fit.corners_px - photo.corners_px)
    return np.array(off)


@pytest.mark.parametrize(
    "blur_px", [1.3, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.4, 1.0))]
)
def test_flat_marks_are_measured_to_hundredths(blur_px: float) -> None:
    off = misses_px(blur_px=blur_px)
    assert 1e-4 < np.sqrt((off**2).mean()) < 0.03
    assert np.abs(off.mean((0, 1))).max() < 0.01


@pytest.mark.parametrize("blur_px", [0.4, pytest.param(1.0, marks=pytest.mark.slow)])
def test_marks_on_a_cylinder_of_50_mm_are_measured_to_a_twentieth(blur_px: float) -> None:
    off = misses_px(blur_px=blur_px, radius_mm=50.0)
    assert 1e-3 < np.sqrt((off**2).mean()) < 0.05


@pytest.mark.slow
def test_noise_costs_its_share_and_no_more() -> None:
    clean = np.sqrt((misses_px(noise=0.0) ** 2).mean())
    noisy = np.sqrt((misses_px(noise=6.0) ** 2).mean())
    assert clean < noisy < 0.08


def test_a_start_two_pixels_off_ends_at_the_same_corners() -> None:
    shot = held(4)
    photo = photograph_mark(shot)
    light = linear_light(photo.luma)
    codes = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36H11)
    code = (codes.generateImageMarker(shot.mark_id, 8) > 0).astype(np.uint8)
    ends = []
    for move in ((0.0, 0.0), (1.3, -1.1), (-1.2, 0.9)):
        fit = fit_square(light, photo.corners_px + np.array(move), code, CAMERA)
        assert fit is not None
        ends.append(fit.corners_px)
    np.testing.assert_allclose(ends[1], ends[0], atol=0.01)
    np.testing.assert_allclose(ends[2], ends[0], atol=0.01)


def test_opencv_of_any_release_leaves_no_bias_in_the_corners() -> None:
    """Its own corners were half a pixel off for years; only the starts come from it."""
    for dictionary in ("APRILTAG_36H11", "4X4_50"):
        off = []
        for seed in range(3):
            rng = np.random.default_rng(seed)
            middle = np.array([rng.uniform(-8, 8), rng.uniform(-5, 5), 400.0])
            turn = Rigid.from_rotation_vector(np.array([0, 0, 0.3 + seed]), np.zeros(3))
            pose = Rigid(turn.rotation, middle)
            shot = MarkShot(
                camera=CAMERA, camera_from_mark=pose, mark_id=seed, dictionary=dictionary
            )
            photo = photograph_mark(shot)
            fit = the_mark(shot, photo).fit
            assert fit is not None
            off.append(fit.corners_px - photo.corners_px)
        assert np.abs(np.mean(off, axis=(0, 1))).max() < 0.015
        assert np.sqrt(np.mean(np.square(off))) < 0.03


def test_the_lens_tells_bent_sides_from_bent_paper() -> None:
    """Seen by a lens that bends lines, a flat mark is flat only for who knows the lens."""
    camera = Camera(
        width_px=400, height_px=300, fx=300.0, fy=300.0, cx=199.5, cy=149.5, k1=-0.35, k2=0.08
    )
    pose = Rigid(np.eye(3), np.array([30.0, 20.0, 80.0]))
    shot = MarkShot(camera=camera, camera_from_mark=pose, side_mm=20.0, mark_id=3)
    photo = photograph_mark(shot)
    knowing, not_knowing = the_mark(shot, photo, camera).fit, the_mark(shot, photo, None).fit
    assert knowing is not None
    assert not_knowing is not None
    assert not knowing.bent
    assert not_knowing.bent
    assert np.abs(knowing.corners_px - photo.corners_px).max() < 0.06
    assert np.abs(knowing.centre_px - photo.centre_px).max() < 0.02


def test_a_photo_that_shows_a_mark_twice_or_cut_off_is_not_believed(tmp_path: Path) -> None:
    shot = held(1)
    photo = photograph_mark(shot)
    twice = np.hstack([photo.luma, photo.luma])
    Image.fromarray(cv2.cvtColor(twice, cv2.COLOR_GRAY2RGB)).save(tmp_path / "a.png")
    Image.fromarray(cv2.cvtColor(photo.luma, cv2.COLOR_GRAY2RGB)).save(tmp_path / "b.png")
    found = find_marks(read_photos([tmp_path]))
    assert found.ids == (shot.mark_id,)
    assert found.seen_in(shot.mark_id) == 1
    doubtful = next(one for one in found.photos if one.name == "a.png")
    assert doubtful.doubts[0].code == "board.mark.twice"
    smeared = photo.luma.copy()
    low, high = photo.corners_px.min(0).astype(int), photo.corners_px.max(0).astype(int)
    middle = int(photo.corners_px[:, 1].mean())
    smeared[middle - 6 : middle + 6, : low[0] + (high[0] - low[0]) // 8] = 10
    doubts = [one.doubt for one in marks_in(smeared, camera=CAMERA)]
    assert all(doubts)


def test_lenses_that_are_not_one_for_each_photo_are_refused(tmp_path: Path) -> None:
    for seed in (1, 2):
        photo = photograph_mark(held(seed))
        Image.fromarray(cv2.cvtColor(photo.luma, cv2.COLOR_GRAY2RGB)).save(tmp_path / f"{seed}.png")
    with pytest.raises(OptionsError, match="1 lenses"):
        find_marks(read_photos([tmp_path]), lenses=(CAMERA,))
