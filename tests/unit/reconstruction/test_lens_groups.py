"""Lens groups: photos of two lenses whose files tell none are parted by what they show."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, Camera
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    Cameras,
    cameras_for,
    from_exif,
)
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.lens_groups import ByLens, by_cut, by_lens, lens_is_told
from limbgram.reconstruction.mapping.placement import MappingOptions
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.lenses import cut_from
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.verification import verify
from limbgram.synthetic import PHONE, SMALL, stage_truth, surface_points
from limbgram.synthetic.truth import SurfacePoints, Truth, ideal_camera

PHOTOS, POINTS, NOISE_PX = 14, 500, 0.1
LONGER = 2.0
K1, K2 = map(PARAMETERS.index, ("k1", "k2"))
OPTIONS = replace(
    SMALL, photos=PHOTOS, calibration_photos=0, lens=PHONE, width_px=800, height_px=600,
    distance_mm=500.0,
)  # fmt: skip
LENS = ideal_camera(OPTIONS)
WHOLE = CameraGroup(label="", width_px=800, height_px=600, exif=Exif())
SMALLER = replace(WHOLE, width_px=640, height_px=480)


@dataclass(frozen=True)
class Taken:
    """Photos round a limb, and what pairs of them share."""

    photos: PhotoSet
    features: Features
    matches: Matches


@cache
def staged() -> tuple[Truth, SurfacePoints]:
    truth = stage_truth(OPTIONS)
    return truth, surface_points(truth, POINTS)


def taken(cameras: Sequence[Camera], sizes: Sequence[CameraGroup]) -> Taken:
    """Photos by these cameras, those of one size in one group."""
    truth, limb = staged()
    random = np.random.default_rng(3)
    of_size = {(one.width_px, one.height_px): k for k, one in enumerate(sizes)}
    photos = PhotoSet(
        tuple(
            Photo(
                name=view.name, path=Path(view.name), width_px=lens.width_px,
                height_px=lens.height_px, exif=Exif(), sha256=view.name,
                camera_idx=of_size[lens.width_px, lens.height_px],
            )
            for view, lens in zip(truth.views, cameras, strict=True)
        ),
        tuple(sizes),
    )  # fmt: skip
    places, shown = list[np.ndarray](), limb.seen.copy()
    for k, (view, camera) in enumerate(zip(truth.views, cameras, strict=True)):
        own = replace(view, camera=camera)
        places.append(own.project(limb.points_in_world))
        shown[:, k] &= own.shows(limb.points_in_world)
        places[k] = np.nan_to_num(places[k]) + random.normal(0.0, NOISE_PX, (POINTS, 2))
    features = Features(
        tuple(
            Keypoints(
                xy_px=xy_px.astype(np.float32),
                scale_px=np.full(POINTS, 2.0, np.float32),
                angle_deg=np.zeros(POINTS, np.float32),
                descriptors=np.zeros((POINTS, 128), np.uint8),
            )
            for xy_px in places
        )
    )
    pairs: list[PairMatches] = []
    for first in range(PHOTOS):
        for second in range(first + 1, PHOTOS):
            both = np.flatnonzero(shown[:, first] & shown[:, second])
            if len(both) >= 30:
                pairs.append(
                    PairMatches(
                        first=first,
                        second=second,
                        keypoint_idx=np.column_stack([both, both]).astype(np.int32),
                        xy_first_px=features.keypoints[first].xy_px[both].astype(float),
                        xy_second_px=places[second][both],
                        correlation=np.ones(len(both), np.float32),
                    )
                )
    matches = Matches(pairs=tuple(pairs), pairs_tried=len(pairs), descriptor_matches=0)
    return Taken(photos, features, matches)


def parted(long: set[int], bare: frozenset[int] = frozenset()) -> ByLens | None:
    """What is told of photos round a limb, those in `long` by a lens twice as long.

    Args:
        bare: Photos that share nothing with the others.
    """
    lens = LENS.with_parameters(LENS.packed * ([LONGER, LONGER] + (LENS_SIZE - 2) * [1.0]))
    one = taken([lens if k in long else LENS for k in range(PHOTOS)], [WHOLE])
    cameras = Cameras((from_exif(WHOLE),))
    assert not lens_is_told(one.photos, cameras)
    shared = tuple(pair for pair in one.matches.pairs if not bare & {*pair.photos})
    verified = verify(one.photos, replace(one.matches, pairs=shared), cameras)
    return by_lens(one.photos, one.features, verified, cameras, MappingOptions())


@pytest.mark.parametrize(
    "long",
    [
        {1, 4, 7, 10, 13},
        pytest.param({0, 1, 2, 3, 4, 6, 7, 8, 10, 11, 12}, marks=pytest.mark.slow),
    ],
)
def test_two_lenses_are_told_by_the_photos(long: set[int]) -> None:
    """The first group is that of most photos, be its lens the longer or the shorter one."""
    found = parted(long)
    assert found is not None
    few = long if len(long) * 2 < PHOTOS else {*range(PHOTOS)} - long
    assert {k for k, one in enumerate(found.photos.photos) if one.camera_idx == 1} == few
    times = LONGER if few == long else 1 / LONGER
    longer = found.photos.cameras[1].longer
    assert longer == pytest.approx(times, rel=0.03)
    first, second = (one.camera for one in found.cameras.calibrations)
    assert second.fx / first.fx == pytest.approx(times, rel=0.03)
    for one in found.cameras.calibrations:
        corner = 0.5 * float(np.hypot(800, 600)) / one.camera.fx
        assert one.sigmas[0] / one.camera.fx == pytest.approx(0.05)
        told = corner ** np.array([2, 4]) * one.sigmas[[K1, K2]]
        assert told == pytest.approx([0.02, 0.02]), "as open at the corner as any other lens is"


def test_a_photo_without_a_place_is_not_said_to_be_of_the_rarer_lens() -> None:
    few = {5, 9, 13}
    found = parted({*range(PHOTOS)} - few, frozenset({12}))
    assert found is not None
    assert {k for k, one in enumerate(found.photos.photos) if one.camera_idx == 1} == few


def test_one_lens_stays_one() -> None:
    assert parted(set()) is None


def small(left_px: float, top_px: float, reduced: float) -> Camera:
    """The lens of every third photo: cut at these pixels, or reduced."""
    packed = LENS.packed.copy()
    packed[:4] *= reduced
    packed[2:4] -= left_px, top_px
    size = replace(LENS, width_px=SMALLER.width_px, height_px=SMALLER.height_px)
    return size.with_parameters(packed)


@pytest.mark.parametrize(
    ("known", "lens", "cut"),
    [
        pytest.param(True, small(0, 0, 0.8), False, id="copy", marks=pytest.mark.slow),
        pytest.param(False, small(0, 0, 0.8), False, id="copy of an unknown lens"),
        pytest.param(True, small(10, 20, 0.9), True, id="cut and reduced"),
        pytest.param(
            False, small(30, 70, 1.0), True, id="cut of an unknown lens", marks=pytest.mark.slow
        ),
    ],
)
def test_a_picture_cut_in_its_own_shape_is_no_copy(known: bool, lens: Camera, cut: bool) -> None:
    one = taken([lens if k % 3 == 1 else LENS for k in range(PHOTOS)], [WHOLE, SMALLER])
    given = [Calibration(camera=LENS, covariance=1e-6 * np.eye(LENS_SIZE), source="board")] * known
    cameras = cameras_for(one.photos, given)
    verified = verify(one.photos, one.matches, cameras)
    found = by_cut(one.photos, one.features, verified, cameras, MappingOptions())
    assert [group.cut_out for group in found.photos.cameras] == [False, cut]
    assert cut_from(found.photos) == ({1: 0} if cut else {})
    assert (found.cameras.calibrations[1].source == "guess") is (cut or not known)
    assert found.cameras.calibrations[0] == cameras.calibrations[0]
