"""Lens groups: photos of two lenses whose files tell none are parted by what they show."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.reconstruction.calibration.cameras import Cameras, from_exif
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.lens_groups import ByLens, by_lens, lens_is_told
from limbgram.reconstruction.mapping.ring import MappingOptions
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.twoview.verification import verify
from limbgram.synthetic import PHONE, SMALL, stage_truth, surface_points

PHOTOS, POINTS, NOISE_PX = 14, 900, 0.1
LONGER = 2.0


def parted(long: set[int]) -> ByLens | None:
    """What is told of photos round a limb, those in `long` by a lens twice as long."""
    truth = stage_truth(
        replace(SMALL, photos=PHOTOS, lens=PHONE, width_px=800, height_px=600, distance_mm=500.0)
    )
    limb, random = surface_points(truth, POINTS), np.random.default_rng(3)
    none = Exif()
    group = CameraGroup(label="", width_px=800, height_px=600, exif=none)
    photos = PhotoSet(
        tuple(
            Photo(
                name=view.name, path=Path(view.name), width_px=800, height_px=600, exif=none,
                sha256=view.name, camera_idx=0,
            )
            for view in truth.views
        ),
        (group,),
    )  # fmt: skip
    places, shown = list[np.ndarray](), limb.seen.copy()
    for k, view in enumerate(truth.views):
        camera = view.camera
        if k in long:
            camera = replace(camera, fx=LONGER * camera.fx, fy=LONGER * camera.fy)
        taken = replace(view, camera=camera)
        places.append(taken.project(limb.points_in_world))
        shown[:, k] &= taken.shows(limb.points_in_world)
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
    cameras = Cameras((from_exif(group),))
    found_matches = Matches(pairs=tuple(pairs), pairs_tried=len(pairs), descriptor_matches=0)
    assert not lens_is_told(photos, cameras)
    verified = verify(photos, found_matches, cameras)
    return by_lens(photos, features, verified, cameras, MappingOptions())


@pytest.mark.parametrize("long", [{1, 4, 7, 10, 13}, {0, 1, 2, 3, 4, 6, 7, 8, 10, 11, 12}])
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


def test_one_lens_stays_one() -> None:
    assert parted(set()) is None
