"""The search over hypotheses: what is told, of captures whose truth is known."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.reconstruction.hypotheses.random_motion import sway_versus_lenses
from limbgram.reconstruction.hypotheses.search import explain
from limbgram.reconstruction.hypotheses.search_result import SearchResult
from limbgram.reconstruction.hypotheses.two_body_equations import TwoBodyEquations
from limbgram.reconstruction.mapping.lens_equations import USUAL_SPREAD, deviation_slice
from limbgram.reconstruction.mapping.scene import Deviation

Take = Callable[..., Any]
N = 14
FLOOR_MM = 0.25
ALONG = np.array([0.6, 0.64, 0.48])


def told(equations: TwoBodyEquations) -> SearchResult:
    return explain(equations, "limb and room", FLOOR_MM)


def phone(seed: int, photos: int = N) -> np.ndarray:
    """Stabiliser, focus and rolling shutter of a phone."""
    return np.random.default_rng(seed).normal(size=(photos, 9)) * USUAL_SPREAD


def along(sizes: np.ndarray) -> np.ndarray:
    motions = np.zeros((len(sizes), 6))
    motions[:, 3:] = sizes[:, None] * ALONG
    return motions


def step(size_mm: float, first: int = N // 2) -> np.ndarray:
    return along(np.where(np.arange(N) >= first, size_mm, 0.0))


def drift(size_mm: float) -> np.ndarray:
    return along(size_mm * np.linspace(-0.5, 0.5, N))


def sway(sigma_mm: float, seed: int) -> np.ndarray:
    motions = np.zeros((N, 6))
    motions[:, 3:] = np.random.default_rng(seed).normal(0.0, sigma_mm, (N, 3))
    return motions


@pytest.mark.parametrize(
    ("photos", "by_exif"), [(10, False), pytest.param(14, True, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("kind", ["camera", "phone", "shared errors", "half a ring"])
def test_sound_captures_show_nothing(take: Take, photos: int, by_exif: bool, kind: str) -> None:
    """Eight kinds of captures, one of each: no accusation, and nothing left open."""
    for seed in (photos,):
        rng = np.random.default_rng(seed)
        equations = take(
            photos=photos,
            seed=seed,
            by_exif=by_exif,
            own=phone(seed, photos) if kind in ("phone", "half a ring") else None,
            shared=0.5 if kind in ("shared errors", "half a ring") else 0.0,
            turn_deg=200.0 if kind == "half a ring" else 360.0,
            focal_px=1500.0 * (1.0 + 0.01 * by_exif * rng.normal()),
            k1=-0.05 + 0.02 * by_exif * rng.normal(),
        ).equations
        assert told(equations).verdict == "still"


@pytest.mark.parametrize("by_exif", [False, True])
@pytest.mark.parametrize("size_mm", [0.5, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_step_is_a_fact_where_and_as_large_as_it_was(
    take: Take, size_mm: float, by_exif: bool
) -> None:
    """Also in photos of a phone that nobody calibrated."""
    for seed in (1,):
        found = told(
            take(seed=seed, by_exif=by_exif, own=phone(seed), motions=step(size_mm, 9)).equations
        )
        assert found.verdict == "moved"
        assert [one.kind for one in found.facts] == ["step"]
        assert found.course_known
        one = found.facts[0]
        assert one.photos == (9, 10, 11, 12, 13)
        assert one.low - 0.05 < size_mm < one.high + 0.05
        assert one.high - one.low < 0.5 + 0.3 * size_mm
        shift = (found.motions[-1] - found.motions[0])[3:]
        np.testing.assert_allclose(shift, size_mm * ALONG, atol=0.15)


@pytest.mark.parametrize("size_mm", [0.75, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_drift_is_a_drift(take: Take, size_mm: float) -> None:
    for seed in (2,):
        found = told(take(seed=seed, own=phone(seed), motions=drift(size_mm)).equations)
        assert [one.kind for one in found.facts] == ["drift"]
        assert found.course_known
        assert found.facts[0].low - 0.05 < size_mm < found.facts[0].high + 0.05


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_a_body_that_slid_for_a_while_moved_by_no_known_course(take: Take, seed: int) -> None:
    """In 6 of 14 photos: neither a step nor a drift of the whole walk explains it clearly best."""
    slid = along(np.clip((np.arange(N) - 4) / 5.0, 0.0, 1.0) * 1.5)
    found = told(take(seed=seed, own=phone(seed), motions=slid).equations)
    assert found.verdict == "moved"
    assert not found.course_known


@pytest.mark.parametrize("by_exif", [False, True])
def test_a_sway_is_a_fact_only_where_a_board_calibrated_the_lens(take: Take, by_exif: bool) -> None:
    for seed in (2,):
        found = told(
            take(seed=seed, by_exif=by_exif, own=phone(seed), motions=sway(2.0, seed)).equations
        )
        assert ("sway" in [one.kind for one in found.facts]) is not by_exif
        assert "sway" in [one.kind for one in (*found.facts, *found.undecided)]


def test_a_sway_is_told_from_lenses_that_were_solved_for_it(take: Take) -> None:
    """A limb that lies elsewhere in every photo looks like photos read row after row."""
    equations = take(seed=2, own=phone(2), motions=sway(4.0, 2)).equations
    found = told(replace(equations, deviations=("rolling shutter",)))
    assert [one.kind for one in found.facts] == ["sway"]
    assert found.instead_of_lenses == ("rolling shutter",)


def test_a_sway_is_held_once_against_the_one_kind_of_lenses(
    take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sway's own rule and the rule of that kind ask the same."""
    asked: list[object] = []

    def counted(*given: Any) -> Any:
        asked.append(given[2])
        return sway_versus_lenses(*given)

    monkeypatch.setattr("limbgram.reconstruction.hypotheses.search.sway_versus_lenses", counted)
    equations = take(seed=2, own=phone(2), motions=sway(4.0, 2)).equations
    told(replace(equations, deviations=("rolling shutter",)))
    assert asked == [("rolling shutter",)]


@pytest.mark.parametrize(("kind", "times"), [("rolling shutter", 3.0), ("principal point", 4.0)])
def test_a_strong_fault_of_a_lens_is_no_sway(take: Take, kind: Deviation, times: float) -> None:
    own = phone(2)
    own[:, deviation_slice(kind)] *= times
    found = told(replace(take(seed=2, own=own).equations, deviations=(kind,)))
    assert found.verdict == "still"
    assert found.instead_of_lenses == ()


def test_a_sway_of_photos_that_few_points_hold_is_no_fact(take: Take) -> None:
    """A wrong match draws such a photo its own way."""
    found = told(take(points=40, motions=sway(3.0, 1)).equations)
    (one,) = [one for one in found.explanations if one.kind == "sway"]
    assert "few points" in one.failed
    assert found.verdict == "undecided"


def test_a_small_sway_of_a_phone_is_left_open_and_named(take: Take) -> None:
    """A lens of each photo's own explains it as well: no fact, and nothing is kept back."""
    found = [told(take(seed=k, own=phone(k), motions=sway(0.18, k)).equations) for k in range(4)]
    assert not any(one.facts for one in found)
    assert sum(one.verdict == "undecided" for one in found) >= 3


def test_two_steps_are_told_apart(take: Take) -> None:
    motions = step(1.0, 4)
    motions[9:, 3:] += [-1.0, 0.8, 0.0]
    found = told(take(motions=motions).equations)
    assert sorted(one.kind for one in found.facts) == ["step", "step"]
    groups = np.unique(np.round(found.motions, 6), axis=0)
    assert len(groups) == 3


def test_a_rotation_alone_is_told(take: Take) -> None:
    motions = np.zeros((N, 6))
    motions[7:, :3] = np.radians(0.4) * ALONG
    found = told(take(motions=motions).equations)
    assert [one.kind for one in found.facts] == ["step"]
    assert found.facts[0].effect > FLOOR_MM, "0.4 degrees are 0.6 mm at the limb's surface"


def test_what_is_too_small_to_matter_is_no_fact(take: Take) -> None:
    for seed in (2,):
        found = told(take(seed=seed, noise_px=0.03, motions=step(0.1)).equations)
        assert not found.facts
        assert found.verdict == "still"
        assert [one.failed for one in found.explanations] == [("size",)]


@pytest.mark.parametrize("first", [5, pytest.param(7, marks=pytest.mark.slow)])
def test_zoomed_photos_are_no_movement(take: Take, first: int) -> None:
    own = np.zeros((N, 9))
    own[first:, 2] = 0.01
    assert told(take(own=own).equations).verdict == "still"


def test_a_wrong_calibration_is_no_movement(take: Take) -> None:
    """Half a per cent of the focal length, and another bend."""
    for seed in (2,):
        found = told(take(seed=seed, focal_px=1507.5, k1=-0.06).equations)
        assert found.verdict == "still"


@pytest.mark.parametrize("by_exif", [False, True])
def test_what_keeps_to_the_frame_of_photos_from_one_side_is_no_fact(
    take: Take, by_exif: bool
) -> None:
    """Three neighbours see the room turned alike in their own frames: a lens does that, too."""
    for seed in (0,):
        taken = take(photos=24, seed=seed, by_exif=by_exif)
        turned = Rigid.from_rotation_vector(np.array([0.0008, -0.0005, 0.001]), np.zeros(3))
        poses = [
            None if pose is None else (turned @ pose if k < 3 else pose)
            for k, pose in enumerate(taken.room.camera_from_world)
        ]
        room = replace(taken.room, camera_from_world=tuple(poses))
        seen = room.observations
        xy_px = seen.xy_px.copy()
        for k in range(3):
            rows = seen.photo_idx == k
            points = room.points_in_world[seen.point_idx[rows]]
            xy_px[rows] += room.view(k).project(points) - taken.room.view(k).project(points)
        found = told(
            replace(taken, room=replace(room, observations=replace(seen, xy_px=xy_px))).equations
        )
        assert not found.facts
        assert found.undecided


def test_one_photo_is_named_and_never_a_fact(take: Take) -> None:
    motions = np.zeros((N, 6))
    motions[5, 3:] = [2.0, 1.0, 0.0]
    found = told(take(motions=motions).equations)
    assert found.verdict == "undecided"
    assert found.undecided[0].photos == (5,)
    assert "one photo" in found.undecided[0].failed


def test_the_list_is_ranked(take: Take) -> None:
    motions = step(3.0, 4)
    motions[9:, 3:] += [0.4, 0.0, 0.0]
    scores = [one.score for one in told(take(motions=motions).equations).explanations]
    assert len(scores) >= 2
    assert scores == sorted(scores, reverse=True)
