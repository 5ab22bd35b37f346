"""COLMAP counts from a pixel's corner: half a pixel is added on the way there and taken off."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pycolmap
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.findings import note
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.mapping import placement
from limbgram.reconstruction.mapping.colmap import (
    MapperSettings,
    _lens,
    _write_photos,
    map_incrementally,
)
from limbgram.reconstruction.mapping.placement import _RouteResult, place_roughly, without_photos
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

LENS = Camera(
    width_px=900, height_px=700, fx=1500.0, fy=1500.0, cx=444.0, cy=345.0, k1=-0.08
)  # fmt: skip


def given(scene: Scene, source: Literal["board", "exif"]) -> tuple[PhotoSet, Cameras]:
    sizes = {"width_px": 900, "height_px": 700, "exif": Exif()}
    photos = tuple(
        Photo(name=name, path=Path(name), sha256="", camera_idx=0, **sizes) for name in scene.names
    )
    calibration = Calibration(
        label="",
        source=source,
        camera=scene.cameras[0],
        covariance=np.zeros((LENS_SIZE, LENS_SIZE)),
        rms_px=0.1,
    )
    return PhotoSet(photos, (CameraGroup(label="", **sizes),)), Cameras((calibration,))


@pytest.mark.parametrize("source", ["board", "exif"])
def test_keypoints_and_centre_go_there_half_a_pixel_further(
    make_scene: Callable[..., Scene], source: Literal["board", "exif"]
) -> None:
    """And without skew, which a camera there does not have."""
    scene = make_scene(photos=3, points=20, lenses=(replace(LENS, skew=1.5),))
    photos, cameras = given(scene, source)
    seen = scene.observations
    places = [seen.xy_px[seen.photo_idx == k] for k in range(3)]
    with pycolmap.Database.open(":memory:") as database:
        _write_photos(database, photos, places, cameras)
        camera = database.read_camera(1)
        written = [database.read_keypoints(k + 1) for k in range(3)]
    assert (camera.principal_point_x, camera.principal_point_y) == (LENS.cx + 0.5, LENS.cy + 0.5)
    for xy, there in zip(places, written, strict=True):
        straight = xy[:, 0] - 1.5 * (xy[:, 1] - LENS.cy) / LENS.fy
        np.testing.assert_allclose(there[:, 0], straight + 0.5, atol=1e-4)
        np.testing.assert_allclose(there[:, 1], xy[:, 1] + 0.5, atol=1e-4)


def test_a_refined_lens_comes_back_half_a_pixel_nearer() -> None:
    model = pycolmap.Reconstruction()
    model.add_camera(
        pycolmap.Camera(
            camera_id=1, model="SIMPLE_RADIAL", width=900, height=700,
            params=[1490.0, 450.5, 350.5, 0.05],
        )
    )  # fmt: skip
    held = Calibration(
        label="",
        source="board",
        camera=LENS,
        covariance=np.zeros((LENS_SIZE, LENS_SIZE)),
        rms_px=0.1,
    )
    free = replace(held, source="exif")
    expected = Camera(
        width_px=900, height_px=700, fx=1490.0, fy=1490.0, cx=450.0, cy=350.0, k1=0.05
    )
    assert _lens(model, 1, free) == expected
    assert _lens(model, 1, held) == LENS
    assert _lens(model, 2, free) == LENS, "a camera that no placed photo uses"


def test_exact_matches_come_back_as_an_exact_scene(
    make_scene: Callable[..., Scene], make_pair: Callable[..., VerifiedPair]
) -> None:
    """With a principal point that half a pixel would miss: through our lens nothing is left."""
    scene = make_scene(photos=12, points=120, share=1.0, lenses=(LENS,))
    photos, cameras = given(scene, "board")
    places = [view.project(scene.points_in_world) for view in scene.views]
    rows = np.tile(np.arange(120)[:, None], 2)
    pairs = []
    for first in range(12):
        for second in (first + 1, first + 2):
            if second < 12:
                poses = [scene.view(k).camera_from_world for k in (first, second)]
                pairs.append(make_pair(first, second, rows, poses[1] @ poses[0].inverse))
    held = (True,)
    found = map_incrementally(
        photos, places, Pairs(tuple(pairs), ()), cameras, held, MapperSettings(20)
    )
    assert len(found) == 1
    assert found[0].placed == tuple(range(12))
    assert found[0].cameras == scene.cameras
    assert len(found[0].points_in_world) == 120
    assert np.abs(found[0].residuals_px()).max() < 0.01
    again = map_incrementally(
        photos, places, Pairs(tuple(pairs), ()), cameras, held, MapperSettings(20)
    )[0]
    np.testing.assert_array_equal(again.points_in_world, found[0].points_in_world)


@pytest.mark.parametrize(("source", "routes"), [("exif", 2), ("board", 1)])
def test_photos_that_a_free_lens_loses_are_placed_by_that_of_exif(
    make_scene: Callable[..., Scene],
    make_pair: Callable[..., VerifiedPair],
    monkeypatch: pytest.MonkeyPatch,
    source: Literal["board", "exif"],
    routes: int,
) -> None:
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    photos, cameras = given(scene, source)
    features, pairs = in_a_row(scene, make_pair)
    tried: list[tuple[bool, ...]] = []

    def mapped(*given: Any) -> _RouteResult:
        held = given[2].held
        tried.append(held)
        return _RouteResult(scene if all(held) else without_photos(scene, {4, 5}), (), {})

    monkeypatch.setattr(placement, "_run_route", mapped)
    found = place_roughly(photos, features, pairs, cameras)
    assert found.placed == tuple(range(6))
    assert len(tried) == routes


@pytest.mark.parametrize("left_out", [{5}, {2, 3, 4, 5}])
def test_pairs_without_those_that_contradict_chains_may_place_more_photos(
    make_scene: Callable[..., Scene],
    make_pair: Callable[..., VerifiedPair],
    monkeypatch: pytest.MonkeyPatch,
    left_out: set[int],
) -> None:
    """A ring that a wrong pair folds over loses photos 3 to 5; without that pair, these."""
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    photos, cameras = given(scene, "board")
    features, pairs = in_a_row(scene, make_pair)
    first, second = (scene.view(k).camera_from_world for k in (0, 3))
    wrong = Rigid.from_rotation_vector(np.radians([0.0, 90.0, 0.0]), np.zeros(3))
    rows = np.tile(np.arange(30)[:, None], 2)
    ends_px = tuple(features.keypoints[k].xy_px[:30].astype(float) for k in (0, 3))
    folded = make_pair(0, 3, rows, wrong @ second @ first.inverse, xy_px=ends_px)

    def mapped(*given: Any) -> _RouteResult:
        whole = len(given[2].pairs.verified) == len(pairs.verified) + 1
        return _RouteResult(without_photos(scene, {3, 4, 5} if whole else left_out), (), {})

    monkeypatch.setattr(placement, "_run_route", mapped)
    monkeypatch.setattr(placement, "_with_stragglers", as_mapped)
    given_pairs = Pairs((*pairs.verified, folded), 0)
    found = place_roughly(photos, features, given_pairs, cameras)
    fewer = left_out if len(left_out) < 3 else {3, 4, 5}
    assert {*range(6)} - {*found.placed} == fewer


@pytest.mark.parametrize(("folded", "placed", "tried"), [(True, 6, 4), (False, 3, 1)])
def test_a_ring_that_folded_is_begun_elsewhere(
    make_scene: Callable[..., Scene],
    make_pair: Callable[..., VerifiedPair],
    monkeypatch: pytest.MonkeyPatch,
    folded: bool,
    placed: int,
    tried: int,
) -> None:
    """Only the third way, from the second start, has all photos: by pairs 0-1, then by 2-3.

    Without contradicted photos, few matches are the cause, and no start helps.
    """
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    photos, cameras = given(scene, "board")
    features, pairs = in_a_row(scene, make_pair)
    across = replace(pairs.verified[0], kind="planar", matches=replace(
        pairs.verified[0].matches, first=0, second=5
    ))  # fmt: skip
    starts: list[tuple[int, int] | None] = []
    reason = note("placing.photo.contradicted") if folded else note("placing.photo.loose", points=3)

    def mapped(*given: Any) -> _RouteResult:
        starts.append(given[2].start)
        if given[2].start == (2, 3):
            return _RouteResult(scene, (), {})
        return _RouteResult(without_photos(scene, {3, 4, 5}), (), dict.fromkeys((3, 4, 5), reason))

    monkeypatch.setattr(placement, "_run_route", mapped)
    monkeypatch.setattr(placement, "_with_stragglers", as_mapped)
    found = place_roughly(photos, features, Pairs((*pairs.verified, across), 0), cameras)
    assert len(found.placed) == placed
    assert starts == [None, None, (0, 1), (2, 3)][:tried]


def test_the_mapper_starts_from_the_pair_given(
    make_scene: Callable[..., Scene], make_pair: Callable[..., VerifiedPair]
) -> None:
    """Two rows of photos that nothing joins: the scene is that of the start, and the only one."""
    scene = make_scene(photos=6, points=60, share=1.0, lenses=(LENS,))
    photos, cameras = given(scene, "board")
    features, pairs = in_a_row(scene, make_pair)
    parted = Pairs(tuple(one for one in pairs.verified if one.matches.first != 2), 0)
    places = [one.xy_px.astype(float) for one in features.keypoints]
    for pair, row in (((0, 1), (0, 1, 2)), ((3, 4), (3, 4, 5))):
        found = map_incrementally(
            photos, places, parted, cameras, (True,), MapperSettings(20, 0, pair)
        )
        assert [one.placed for one in found] == [row]


def as_mapped(scene: Scene, *_: Any) -> Scene:
    """Without the photos that few points would place."""
    return scene


def in_a_row(scene: Scene, make_pair: Callable[..., VerifiedPair]) -> tuple[Features, Pairs]:
    """Each photo with the next one, by points that both show."""
    keypoints = [
        Keypoints(
            xy_px=view.project(scene.points_in_world).astype(np.float32),
            scale_px=np.ones(60, np.float32),
            angle_deg=np.zeros(60, np.float32),
            descriptors=np.zeros((60, 128), np.uint8),
        )
        for view in scene.views
    ]
    rows = np.tile(np.arange(60)[:, None], 2)
    pairs = []
    for first in range(5):
        xy_px = keypoints[first].xy_px.astype(float), keypoints[first + 1].xy_px.astype(float)
        poses = [scene.view(k).camera_from_world for k in (first, first + 1)]
        turn = poses[1] @ poses[0].inverse
        pairs.append(make_pair(first, first + 1, rows, turn, xy_px=xy_px))
    return Features(tuple(keypoints)), Pairs(tuple(pairs), 0)
