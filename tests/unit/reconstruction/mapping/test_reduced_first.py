"""Placing by reduced photos, and by those of the full size where that does not place all firmly."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import MatchingError, PlacementError
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.core.run import Run
from limbgram.findings import note
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    Cameras,
    cameras_for,
    from_exif,
)
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.lens_groups import ByLens
from limbgram.reconstruction.limb_groups import LimbGroups
from limbgram.reconstruction.mapping.placement import ring_of, without_photos
from limbgram.reconstruction.mapping.scene import Explanation, PhotoVerdict, Scene
from limbgram.reconstruction.matching.matching import Matches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photo_lenses import files_contradicted
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.pipeline import (
    PipelineOptions,
    PlacedPhotos,
    Placing,
    place_photos,
    with_files_that_fit,
)
from limbgram.reconstruction.targets.board import KIT_DICTIONARY
from limbgram.reconstruction.targets.marks import MarkDetections
from limbgram.reconstruction.twoview.pairs import Pairs

MakeScene = Callable[..., Scene]


class Told(Run):
    """A run whose stages give what the test tells."""

    def __init__(self, products: dict[str, Any]) -> None:
        super().__init__()
        self.products = products
        self.called: list[str] = []

    def __call__(self, stage: Callable[..., Any], *_: Any, **__: Any) -> Any:
        self.called.append(stage.__name__)
        told = self.products.get(stage.__name__)
        if isinstance(told, Exception):
            raise told
        return told


def firm(scene: Scene, points: int = 80) -> Scene:
    verdicts = tuple(
        PhotoVerdict(name=name, placed=pose is not None, points=points, rms_px=0.1)
        for name, pose in zip(scene.names, scene.camera_from_world)
    )
    return replace(scene, verdicts=verdicts, ring=ring_of(scene))


@pytest.fixture
def ring(make_scene: MakeScene) -> Scene:
    return firm(make_scene(photos=12, points=60, share=1.0))


def showing(count: int) -> Features:
    one = Keypoints(
        xy_px=np.zeros((count, 2), np.float32),
        scale_px=np.ones(count, np.float32),
        angle_deg=np.zeros(count, np.float32),
        descriptors=np.zeros((count, 128), np.uint8),
    )
    return Features((one,) * 3)


def photos(width_px: int = 1500) -> PhotoSet:
    one = Photo(
        name="a.jpg",
        path=Path("a.jpg"),
        width_px=width_px,
        height_px=1000,
        exif=Exif(),
        sha256="",
        camera_idx=0,
    )
    return PhotoSet((one,) * 3, ())


NO_MATCHES = Matches(pairs=(), pairs_tried=0, descriptor_matches=0)
NO_MARKS = MarkDetections(dictionary=KIT_DICTIONARY, photos=())
FULL_SIZE = ["detect", "find_still", "match", "verify", "place", "limb_groups"]
REDUCED = ["detect", "find_still", "match", "verify", "place_roughly"]


def placed(ring: Scene, **told: Any) -> tuple[Placing, list[str]]:
    products = {
        "detect": showing(2000),
        "find_still": StaticBackground(),
        "match": NO_MATCHES,
        "verify": Pairs((), 0),
        "place": ring,
        "place_roughly": ring,
        "follow_points": ring,
        "limb_groups": LimbGroups(),
    }
    run = Told({**products, **told})
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=750.0, cy=500.0)
    given = Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")
    cameras = Cameras((given,) * len(ring.cameras))
    return place_photos(photos(), cameras, PipelineOptions(), run), run.called


def test_a_firm_ring_is_followed_and_nothing_is_done_at_full_size(ring: Scene) -> None:
    placing, called = placed(ring)
    assert called == [*REDUCED, "follow_points", "limb_groups"]
    assert placing.scene.full_size is None


def test_photos_hardly_larger_than_reduced_ones_stay_as_they_are(ring: Scene) -> None:
    run = Told(
        {
            "place": ring,
            "find_still": StaticBackground(),
            "match": NO_MATCHES,
            "limb_groups": LimbGroups(),
        }
    )
    placing = place_photos(photos(width_px=1150), Cameras(()), PipelineOptions(), run)
    assert run.called == FULL_SIZE
    assert placing.scene.full_size is None


def test_a_lens_that_no_board_calibrated_asks_for_the_full_size(ring: Scene) -> None:
    told = {
        "detect": showing(2000),
        "find_still": StaticBackground(),
        "match": NO_MATCHES,
        "limb_groups": LimbGroups(),
    }
    run = Told({**told, "place": ring})
    cameras = Cameras((from_exif(CameraGroup(label="", width_px=400, height_px=300, exif=Exif())),))
    placing = place_photos(photos(), cameras, PipelineOptions(), run)
    assert run.called == FULL_SIZE
    assert placing.scene.full_size == note("placing.reduced.lens")


CONTRADICTED = Explanation(
    bodies="lenses",
    kind="camera file",
    photos=(0,),
    numbers=1,
    score=88.0,
    chance=1e-16,
    effect=-0.03,
    low=0.028,
    high=0.032,
    variance_before=1.0,
    variance_after=0.2,
)


ZOOMED = replace(CONTRADICTED, kind="focal length", score=841425.0, effect=0.107)


def test_photos_that_were_zoomed_say_nothing_of_their_camera_file(ring: Scene) -> None:
    scene = replace(ring, lens_explanations=(ZOOMED, CONTRADICTED))
    assert files_contradicted(scene) == ()
    assert files_contradicted(replace(ring, lens_explanations=(CONTRADICTED,))) == (CONTRADICTED,)
    refocused = replace(ZOOMED, effect=0.003, low=0.002, high=0.004)
    scene = replace(ring, lens_explanations=(refocused, CONTRADICTED))
    assert files_contradicted(scene) == (CONTRADICTED,)  # by ten times as much


@pytest.mark.parametrize(("told", "camera_files"), [(True, ["board", "guess"]), (False, ["board"])])
def test_a_camera_file_is_left_out_where_the_photos_contradict_it_as_a_fact(
    ring: Scene, told: bool, camera_files: list[str]
) -> None:
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=750.0, cy=500.0)
    given = Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")
    shown = replace(CONTRADICTED, failed=() if told else ("size",))
    group = CameraGroup(label="", width_px=1500, height_px=1000, exif=Exif())
    tried: list[Cameras] = []

    def place(cameras: Cameras) -> PlacedPhotos:
        scene = replace(ring, lens_explanations=() if tried else (shown,))
        tried.append(cameras)
        placing = Placing(showing(1), NO_MATCHES, Pairs((), 0), scene, StaticBackground())
        return PlacedPhotos(photos(), cameras, placing, None)

    found = with_files_that_fit(
        replace(photos(), cameras=(group,)), Cameras((given,)), place, Run()
    )
    assert [one.calibrations[0].source for one in tried] == camera_files
    assert found.placing.scene.lens_explanations == (shown,)  # said either way
    assert found.cameras.calibrations[0].instead_of == (given if told else None)


def test_a_camera_file_is_left_out_for_every_size_of_its_photos(ring: Scene) -> None:
    """Two photos of half the size kept a focal length that was 3 % too long."""
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=749.5, cy=499.5, k1=-0.05)
    exact = np.zeros((LENS_SIZE, LENS_SIZE))
    given = Calibration(camera=lens, covariance=exact, source="board", label="A")
    other = replace(given, camera=replace(lens, k1=-0.04), label="B")
    groups = [
        CameraGroup(label="", width_px=width, height_px=height, exif=Exif(model=model))
        for model, width, height in (
            ("A", 1500, 1000),
            ("A", 750, 500),
            ("A", 500, 750),
            ("B", 1500, 1000),
        )
    ]
    taken = replace(photos(), cameras=tuple(groups))
    cameras = cameras_for(taken, [given, other])
    assert [one.source for one in cameras.calibrations] == ["board"] * 4
    tried: list[Cameras] = []

    def place(cameras: Cameras) -> PlacedPhotos:
        scene = replace(ring, lens_explanations=() if tried else (CONTRADICTED,))
        tried.append(cameras)
        placing = Placing(showing(1), NO_MATCHES, Pairs((), 0), scene, StaticBackground())
        return PlacedPhotos(taken, cameras, placing, None)

    found = with_files_that_fit(taken, cameras, place, Run()).cameras.calibrations
    assert [one.source for one in found] == ["guess", "guess", "guess", "board"]
    assert [one.instead_of for one in found] == [*cameras.calibrations[:3], None]


def test_a_camera_file_is_kept_where_the_photos_told_of_two_lenses(ring: Scene) -> None:
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=750.0, cy=500.0)
    given = Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")
    group = CameraGroup(label="", width_px=1500, height_px=1000, exif=Exif())
    taken = replace(photos(), cameras=(group,))
    two = ByLens(replace(taken, cameras=(group, group)), Cameras((given, given)))
    tried: list[Cameras] = []

    def place(cameras: Cameras) -> PlacedPhotos:
        tried.append(cameras)
        scene = replace(ring, lens_explanations=(CONTRADICTED,))
        placing = Placing(
            showing(1), NO_MATCHES, Pairs((), 0), scene, StaticBackground(), lenses=two
        )
        return PlacedPhotos(two.photos, two.cameras, placing, None)

    found = with_files_that_fit(taken, Cameras((given,)), place, Run())
    assert [one.calibrations for one in tried] == [(given,)]  # placed once, by the file
    assert found.cameras is two.cameras
    assert found.placing.scene.lens_explanations == (CONTRADICTED,)


def test_photos_that_only_a_wrong_camera_file_places_are_refused_with_both_focal_lengths(
    ring: Scene,
) -> None:
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=750.0, cy=500.0)
    given = Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")
    group = CameraGroup(label="", width_px=1500, height_px=1000, exif=Exif())

    def place(cameras: Cameras) -> PlacedPhotos:
        if cameras.calibrations[0].source != "board":
            raise PlacementError("placing.none")
        scene = replace(ring, lens_explanations=(CONTRADICTED,))
        placing = Placing(showing(1), NO_MATCHES, Pairs((), 0), scene, StaticBackground())
        return PlacedPhotos(photos(), cameras, placing, None)

    taken = replace(photos(width_px=ring.cameras[0].width_px), cameras=(group,))
    with pytest.raises(PlacementError) as refusal:
        with_files_that_fit(taken, Cameras((given,)), place, Run())
    assert refusal.value.finding.code == "lens.foreign"
    assert refusal.value.finding.values["given_px"] == 2000.0
    assert refusal.value.finding.values["shown_px"] == pytest.approx(1940.0)


TWICE = Exif(focal_35mm=96.0)
"""Of twice the focal length, in pixels, that the file tells."""


@pytest.mark.parametrize(("exif", "told"), [(TWICE, "lens.foreign"), (Exif(), "placing.none")])
def test_photos_that_cannot_be_placed_tell_of_a_camera_file_that_their_headers_contradict(
    exif: Exif, told: str
) -> None:
    """A file of half the focal length let one walk round look like a limb that was turned over."""
    lens = Camera(width_px=1500, height_px=1000, fx=2000.0, fy=2000.0, cx=750.0, cy=500.0)
    given = Calibration(camera=lens, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board")
    group = CameraGroup(label="", width_px=1500, height_px=1000, exif=exif)

    def place(_: Cameras) -> PlacedPhotos:
        raise PlacementError("placing.none")

    with pytest.raises(PlacementError) as refusal:
        with_files_that_fit(replace(photos(), cameras=(group,)), Cameras((given,)), place, Run())
    assert refusal.value.finding.code == told


def test_sparse_paint_asks_for_the_full_size_at_once(ring: Scene) -> None:
    placing, called = placed(ring, detect=showing(1500))
    assert called == ["detect", "find_still", *FULL_SIZE]
    assert placing.scene.full_size == note("placing.reduced.few_points")


def test_what_stands_still_is_no_paint(ring: Scene) -> None:
    room = np.arange(2000) < 1000
    still = StaticBackground(groups=((0, 1, 2),), keypoints=(room,) * 3)
    placing, called = placed(ring, find_still=still)
    assert called == ["detect", "find_still", *FULL_SIZE]
    assert all(len(one) == 1000 for one in placing.features.keypoints)
    assert placing.still is still


def test_a_photo_left_out_asks_for_the_full_size(ring: Scene) -> None:
    placing, called = placed(ring, place_roughly=firm(without_photos(ring, {3})))
    assert called == REDUCED + FULL_SIZE
    assert placing.scene.full_size == note("placing.reduced.unplaced", photos=1)


def test_a_photo_that_is_lost_later_asks_for_it_too(ring: Scene) -> None:
    placing, called = placed(ring, follow_points=firm(ring, points=30))
    assert called == [*REDUCED, "follow_points", *FULL_SIZE]
    assert placing.scene.full_size == note("placing.reduced.loose")


def test_a_gap_in_the_ring_asks_for_it_too(make_scene: MakeScene, ring: Scene) -> None:
    arc = firm(without_photos(make_scene(photos=12, points=60, share=1.0), {4, 5, 6}))
    names = tuple(name for k, name in enumerate(arc.names) if k not in {4, 5, 6})
    poses = tuple(pose for pose in arc.camera_from_world if pose is not None)
    whole = replace(arc, names=names, camera_from_world=poses)
    whole = replace(whole, verdicts=tuple(v for v in arc.verdicts if v.placed))
    placing, called = placed(ring, place_roughly=whole)
    assert called == REDUCED + FULL_SIZE
    assert placing.scene.full_size == note("placing.reduced.gap")


def test_a_refusal_at_reduced_size_is_none(ring: Scene) -> None:
    placing, called = placed(ring, place_roughly=MatchingError("too little"))
    assert called == REDUCED + FULL_SIZE
    assert placing.scene.full_size == note("placing.reduced.few_matches")


def test_a_refusal_at_full_size_is_one(ring: Scene) -> None:
    with pytest.raises(MatchingError):
        placed(ring, match=MatchingError("too little"), find_marks=NO_MARKS)


def test_marks_are_looked_for_only_where_paint_leaves_the_ring_open(ring: Scene) -> None:
    part = firm(without_photos(ring, {3}))
    placing, called = placed(ring, place_roughly=part, place=part, find_marks=NO_MARKS)
    assert called == [*REDUCED, *FULL_SIZE, "find_marks"]
    assert placing.scene.marks is None
    assert len(placing.scene.placed) == 11
