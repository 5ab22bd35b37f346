"""Gaps in a walk: whole walks are never held back, and missing sides are asked for."""

import numpy as np
import pytest

from limbgram.capture.coach import CheckedPhoto, missing_round
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
    assert [seed for seed in SEEDS if missing_round(walk(photos, rings, seed))] == []


@pytest.mark.parametrize("photos", [12, 16, 20])
def test_two_neighbours_that_are_missing_are_asked_for(photos: int) -> None:
    for seed in SEEDS:
        left = walk(photos, 1, seed)
        del left[4:6]
        asked = missing_round(left)
        assert len(asked) == 1
        assert asked[0].between == ("3.jpg", "6.jpg")


def test_a_side_that_is_missing_in_both_rings_is_asked_for() -> None:
    for seed in SEEDS:
        left = [one for one in walk(24, 2, seed) if not 100 < one.azimuth_deg < 180]
        assert sum(one.count for one in missing_round(left)) >= 2
