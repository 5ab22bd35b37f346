"""Gaps in a walk: whole walks are never held back, missing sides are asked for. And the limb."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from limbgram.capture.answer import CheckedPhoto
from limbgram.capture.coach import Coach, tipped_board_finding
from limbgram.capture.limb_in_photos import InspectionCache, inspect_limb, limb_points
from limbgram.capture.limb_motion import limb_motion
from limbgram.capture.photos_to_add import photos_for_gaps
from limbgram.core.errors import RegionError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.core.run import Run
from limbgram.findings import Finding, Gravity, doubt
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.dense.region import find_region
from limbgram.reconstruction.features.detection import detect
from limbgram.reconstruction.mapping.scene import Movement, Observations, Scene
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.synthetic.photographer import walk_round

SEEDS = range(40)


def walk(photos: int, rings: int, seed: int) -> list[CheckedPhoto]:
    """Photos of a walk whose steps waver by a third, all of them good."""
    centres = [pose.centre for pose in walk_round(np.zeros(3), 1000.0, photos, rings, seed)]
    return [
        CheckedPhoto(
            name=f"{number}.jpg",
            placed=True,
            points=500,
            edge_px=1.2,
            burnt=0.0,
            features_per_cm2=8.0,
            azimuth_deg=float(np.degrees(np.arctan2(y, x)) % 360),
            elevation_deg=float(np.degrees(np.arctan2(z, np.hypot(x, y)))),
            counts=True,
            remarks=(),
        )
        for number, (x, y, z) in enumerate(centres)
    ]


@pytest.mark.parametrize(("photos", "rings"), [(9, 1), (15, 1), (15, 2), (17, 2), (24, 2)])
def test_a_whole_walk_is_never_held_back(photos: int, rings: int) -> None:
    """A second ring falls between the photos of the first and takes none of them away."""
    assert [seed for seed in SEEDS if photos_for_gaps(walk(photos, rings, seed))] == []


@pytest.mark.parametrize(("code", "photos"), [("tipped", 3), ("pushed", 0)])
def test_a_board_in_two_planes_of_a_scene_is_a_fault(code: str, photos: int) -> None:
    """A push along the table leaves one plane, and is told elsewhere."""
    reason = doubt(f"board.photo.{code}", others=9, pushes=())
    aside = tuple(SetAside(f"{k}.jpg", reason) for k in range(3))
    found = tipped_board_finding(
        Scale(unit="mm", source="board", relative_sigma=1e-4, set_aside=aside)
    )
    assert [one.values["photos"] for one in found] == [photos] * bool(photos)
    assert all(one.gravity is Gravity.FAULT and one.values["others"] == 9 for one in found)


@pytest.mark.parametrize("photos", [12, 16, 20])
def test_two_neighbours_that_are_missing_are_asked_for(photos: int) -> None:
    for seed in SEEDS:
        left = walk(photos, 1, seed)
        del left[4:6]
        asked = photos_for_gaps(left)
        assert len(asked) == 1
        assert asked[0].between == ("3.jpg", "6.jpg")


def test_a_side_that_is_missing_in_both_rings_is_asked_for() -> None:
    for seed in SEEDS:
        left = [one for one in walk(24, 2, seed) if not 100 < one.azimuth_deg < 180]
        assert sum(one.count for one in photos_for_gaps(left)) >= 2


@pytest.mark.parametrize(("unit", "far"), [("mm", 4.0), ("% of the limb's length", 2.0)])
def test_without_a_size_a_movement_is_a_share_of_the_limb(unit: str, far: float) -> None:
    moved = Movement(
        kind="step",
        group=np.array([0, 0, 1]),
        shift=np.array([0.0, 0.0, 4.0]),
        turn_deg=np.array([0.0, 0.0, 1.5]),
        largest=4.0,
    )
    scene = Scene(
        names=("a", "b", "c"),
        cameras=(),
        camera_idx=(0, 0, 0),
        camera_from_world=(None, None, None),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
        bending=moved,
    )
    in_mm = unit == "mm"
    scale = Scale(
        unit="mm" if in_mm else "unitless",
        source="board" if in_mm else "none",
        relative_sigma=0.001,
    )
    across = np.random.default_rng(2).uniform(-20.0, 20.0, (400, 2))
    limb = np.column_stack([across, np.linspace(0.0, 200.0, 400)])
    told = limb_motion(MetricScene(scene=scene, scale=scale), limb)
    (said,) = told.findings(Cameras(()))
    how = said.values["how"]
    assert isinstance(how, Finding)
    assert how.values["unit"] == unit
    assert how.values["far"] == pytest.approx(far, rel=0.02)
    assert how.values["turn_deg"] == 1.5


@pytest.mark.parametrize("floor_sigma", [0.001, 0.003])
def test_without_a_size_the_floor_is_no_limb(floor_sigma: float) -> None:
    """A thinly painted pot, in units of its distance, on a printed sheet with ten times its points.

    The sheet's own points lie on both sides of its plane, by their errors and by its relief.
    """
    draw = np.random.default_rng(5)
    angle, height = draw.uniform(0, 2 * np.pi, 900), draw.uniform(0, 0.3, 900)
    pot = np.column_stack([0.15 * np.cos(angle), 0.15 * np.sin(angle), height])
    sheet = np.column_stack(
        [draw.uniform(-0.4, 0.4, (9000, 2)), draw.normal(scale=floor_sigma, size=9000)]
    )
    lens = Camera(width_px=1000, height_px=1300, fx=1200.0, fy=1200.0, cx=499.5, cy=649.5)
    walked = walk_round(np.array([0.0, 0.0, 100.0]), 1000.0, 20, 2, 3)  # its hand wavers by mm
    poses = tuple(Rigid(pose.rotation, pose.translation / 1000.0) for pose in walked)
    nothing = np.zeros(0, np.int32)
    names = tuple(f"{number}.jpg" for number in range(len(poses)))
    scene = Scene(
        names=names,
        cameras=(lens,),
        camera_idx=(0,) * len(poses),
        camera_from_world=poses,
        points_in_world=np.concatenate([pot, sheet]),
        observations=Observations(nothing, nothing, np.zeros((0, 2))),
        verdicts=(),
    )
    metric = to_millimetres(scene)
    limb = limb_points(metric)
    of_pot = np.isin(np.arange(900), limb)
    assert metric.floor_z_mm is not None
    assert of_pot.sum() > 0.95 * len(limb)
    assert of_pot.mean() > 0.9


@pytest.mark.parametrize(("beside", "answers"), [(0.0, True), (1.3, False)])
@pytest.mark.parametrize("k2", [0.0, -0.58])
def test_check_and_reconstruction_ask_the_same_of_the_photos(
    beside: float, answers: bool, k2: float
) -> None:
    """A limb in the middle, by a sound lens and by one whose corners have no ray; and photos that
    look past it, each to another side."""
    draw = np.random.default_rng(5)
    angle, height = draw.uniform(0, 2 * np.pi, 900), draw.uniform(0, 0.3, 900)
    pot = np.column_stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), height])
    lens = Camera(width_px=1600, height_px=1200, fx=1250.0, fy=1250.0, cx=799.5, cy=599.5, k2=k2)
    focus = np.array([0.0, 0.0, 0.15])
    places = [pose.centre for pose in walk_round(focus, 1.0, 20, 1, 3)]
    up = np.array([0.0, 0.0, 1.0])
    aside = [beside * np.cross(place - focus, up) * (-1) ** k for k, place in enumerate(places)]
    poses = tuple(
        Rigid.looking_at(place, focus + one, up) for place, one in zip(places, aside, strict=True)
    )
    nothing = np.zeros(0, np.int32)
    names = tuple(f"{number}.jpg" for number in range(len(poses)))
    metric = to_millimetres(
        Scene(
            names=names,
            cameras=(lens,),
            camera_idx=(0,) * len(poses),
            camera_from_world=poses,
            points_in_world=pot,
            observations=Observations(nothing, nothing, np.zeros((0, 2))),
            verdicts=(),
        )
    )
    photos = PhotoSet(photos=tuple(_photo(name) for name in names), cameras=())
    if answers:
        assert len(limb_points(metric)) > 850
        assert find_region(photos, metric).occupied.any()
        return
    for asked in (lambda: limb_points(metric), lambda: find_region(photos, metric)):
        with pytest.raises(RegionError, match="scene points lie where the photos look"):
            asked()


def _photo(name: str) -> Photo:
    return Photo(
        name=name, path=Path(name), width_px=1600, height_px=1200, exif=Exif(), sha256="",
        camera_idx=0,
    )  # fmt: skip


@pytest.mark.parametrize("burnt_px", [0, 60])
def test_exposure_is_judged_on_the_limb_and_not_on_what_its_outline_spans(
    tmp_path: Path, burnt_px: int
) -> None:
    """A leg with its foot before paper that is burnt out; a spot on the leg is burnt too."""
    draw = np.random.default_rng(6)
    angle, along = draw.uniform(0, 2 * np.pi, (2, 2000)), draw.uniform(0, 0.3, (2, 2000))
    across = 0.03 * np.stack([np.cos(angle), np.sin(angle)])
    leg = np.column_stack([across[0, 0], across[1, 0], along[0]])
    foot = np.column_stack([across[0, 1], along[1], across[1, 1]])
    limb = np.concatenate([leg, foot])
    lens = Camera(width_px=900, height_px=800, fx=1500.0, fy=1500.0, cx=449.5, cy=399.5)
    pose = Rigid(np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]]), np.array([-0.13, 0.15, 1.0]))
    nothing = np.zeros(0, np.int32)
    scene = Scene(
        names=("a.png", "b.png", "c.png"),
        cameras=(lens,),
        camera_idx=(0, 0, 0),
        camera_from_world=(pose, pose, pose),
        points_in_world=limb,
        observations=Observations(nothing, nothing, np.zeros((0, 2))),
        verdicts=(),
    )
    xy_px = np.round(scene.view(0).project(limb)).astype(int)
    shown = np.zeros((800, 900), np.uint8)
    shown[xy_px[:, 1], xy_px[:, 0]] = 1
    shown = np.asarray(cv2.morphologyEx(shown, cv2.MORPH_CLOSE, np.ones((41, 41), np.uint8)))
    luma = np.where(shown > 0, draw.integers(60, 180, shown.shape), 255).astype(np.uint8)
    row, column = (int(value) for value in np.median(np.argwhere(shown[:300]), axis=0))
    luma[row : row + burnt_px, column - 30 : column - 30 + burnt_px] = 255
    for name in ("a.png", "b.png"):
        luma[0, 0] -= 1
        Image.fromarray(luma).save(tmp_path / name)
    photos = read_photos([tmp_path])
    whole = cv2.contourArea(cv2.convexHull(xy_px.astype(np.float32)))
    assert shown.sum() < 0.7 * whole  # the outline spans more paper than would be called burnt
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    metric = MetricScene(scene=scene, scale=scale)
    found = detect(photos)
    looked = inspect_limb(photos, photos, found, metric, limb, {})
    assert looked[0].photo.burnt == pytest.approx(burnt_px**2 / shown.sum(), abs=0.02)
    known: dict[str, InspectionCache] = {}
    inspect_limb(photos, photos, found, metric, limb, known)
    called = replace(
        photos, photos=tuple(replace(one, name=f"left_{one.name}") for one in photos.photos)
    )
    looked = inspect_limb(called, called, found, metric, limb, known)
    assert tuple(one.photo.name for one in looked) == called.names


def test_a_photo_that_gets_a_mask_is_looked_at_anew(tmp_path: Path) -> None:
    draw = np.random.default_rng(7)
    for name in ("a.jpg", "b.jpg"):
        coarse = Image.fromarray(draw.integers(0, 256, (50, 60), dtype=np.uint8))
        coarse.resize((600, 500)).save(tmp_path / name)
    bare = read_photos([tmp_path])
    left = np.zeros((500, 600), np.uint8)
    left[:, :300] = 255
    Image.fromarray(left).save(tmp_path / "a.png")
    masked = read_photos([tmp_path])
    coach = Coach((), None)
    before, after = (coach._features(photos, Run()).keypoints for photos in (bare, masked))
    assert before[0].xy_px[:, 0].max() > 400
    assert len(after[0]) > 0
    assert after[0].xy_px[:, 0].max() < 300
    assert after[1] is before[1]
