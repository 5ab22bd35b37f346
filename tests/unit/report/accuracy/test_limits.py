"""What limits a result is said from its limit on, and not a hair before it."""

import math
from dataclasses import replace
from typing import Any

import pytest

from limbgram.findings import Gravity, note, told
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import BoardSeen, Figures, MovementFigures, TapedLength
from limbgram.report.accuracy.judgement import criteria, tape_is_precise
from limbgram.report.accuracy.limits import findings

SIGMA0_PX = 0.08
"""Half of it is less than the pattern which counts in any case."""
USUAL_PX = 0.1
"""RMS of all residuals."""


@pytest.fixture
def figures(with_sigmas: Evidence) -> Figures:
    found = assess(with_sigmas).figures
    board = BoardSeen(board="6x8", photos=12, placed_photos=12, corners=420, corners_per_photo=35.0,
                      diagonal_mm=250.0)  # fmt: skip
    found = put(found, "network.sigma0_robust_px", SIGMA0_PX)
    found = put(found, "residuals.rms_px", USUAL_PX)
    return put(found, "lengths.board", board)


def put(tree: Any, place: str, value: object) -> Any:
    """The tree with another value at a place such as `images.by_photo.0.rms_px`."""
    first, _, rest = place.partition(".")
    if isinstance(tree, tuple):
        row: Any = list(tree)
        row[int(first)] = put(row[int(first)], rest, value)
        return tuple(row)
    return replace(tree, **{first: put(getattr(tree, first), rest, value) if rest else value})


def gravities(figures: Figures) -> dict[str, Gravity]:
    return {one.code: one.gravity for one in findings(figures)}


@pytest.mark.parametrize(
    ("place", "limit", "code"),
    [
        ("images.edge_width_px", 1.5, "limit.photos.soft"),
        ("images.noise_grey", 4.0, "limit.photos.noisy"),
        ("lengths.check_worst", 0.001, "limit.scale.check_off"),
        ("network.rays.two_share", 0.6, "limit.photos.two_rays"),
        ("network.ring.largest_gap_deg", 30.0, "limit.photos.gap"),
        ("residuals.by_camera.0.systematic_px", 0.05, "limit.lens.pattern"),
        ("residuals.by_photo.0.rms_px", 2 * USUAL_PX, "limit.photos.odd"),
        ("cameras.0.parameters.0.contradicted_sigmas", 3.0, "limit.lens.contradicted"),
        ("surface.around.missing_share", 0.10, "limit.surface.not_round"),
        ("surface.around.open_share", 0.05, "limit.surface.open"),
        ("surface.filled_share", 0.02, "limit.surface.filled"),
        ("surface.left_out_share", 0.02, "limit.surface.left_out"),
        ("surface.photos_per_place.below_3_share", 0.05, "limit.surface.few_photos"),
    ],
)
def test_a_figure_is_told_beyond_its_limit(
    figures: Figures, place: str, limit: float, code: str
) -> None:
    assert code not in gravities(put(figures, place, limit))
    assert code in gravities(put(figures, place, 1.001 * limit))


@pytest.mark.parametrize(
    ("place", "limit", "code"),
    [
        ("lengths.board.photos", 6, "limit.scale.board_seen"),  # of twelve
        ("network.angles.median_deg", 12.0, "limit.photos.small_base"),
    ],
)
def test_a_figure_is_told_below_its_limit(
    figures: Figures, place: str, limit: float, code: str
) -> None:
    assert code not in gravities(put(figures, place, limit))
    assert code in gravities(put(figures, place, limit - 1))


def test_a_wide_gap_is_a_note_and_a_gaping_one_a_fault(figures: Figures) -> None:
    place, code = "network.ring.largest_gap_deg", "limit.photos.gap"
    assert gravities(put(figures, place, 60.0))[code] is Gravity.NOTE
    assert gravities(put(figures, place, 60.1))[code] is Gravity.FAULT


def test_a_pattern_is_held_against_the_noise_where_this_is_larger(figures: Figures) -> None:
    noisy = put(figures, "network.sigma0_robust_px", 0.4)
    place, code = "residuals.by_camera.0.systematic_px", "limit.lens.pattern"
    assert code not in gravities(put(noisy, place, 0.2))
    assert code in gravities(put(noisy, place, 0.201))


def light_of(figures: Figures, key: str) -> str:
    (found,) = (one.light for one in criteria(figures) if one.key == key)
    return found


def test_a_pattern_is_doubted_from_half_a_sigma_of_one_coordinate(figures: Figures) -> None:
    noisy = put(figures, "network.sigma0_robust_px", 0.4)
    place = "residuals.by_camera.0.systematic_px"
    assert light_of(put(noisy, place, 0.2), "lens_pattern") == "green"
    assert light_of(put(noisy, place, 0.201), "lens_pattern") == "amber"


@pytest.mark.parametrize(("shift_mm", "light"), [(1.0, "amber"), (1.01, "red")])
def test_a_shift_of_all_that_places_the_photos_is_red_beyond_a_millimetre(
    figures: Figures, shift_mm: float, light: str
) -> None:
    moved = MovementFigures(
        kind="step", found=note("said.as_is", message="it moved"), photos=(), alone=False,
        misfit=False, unexplained=False, explanations=(), shift=shift_mm,
        turn_deg=0.0, chance=0.0, bent=None, bending_misfit=False, bending=0.0,
    )  # fmt: skip
    assert light_of(replace(figures, movement=moved), "movement") == light


@pytest.mark.parametrize(("source", "asks"), [("board", False), ("exif", True)])
def test_a_calibration_that_is_there_is_not_asked_for(
    figures: Figures, source: str, asks: bool
) -> None:
    doubtful = MovementFigures(
        kind="unknown", found=note("said.as_is", message="it may have moved"), photos=(),
        alone=False, misfit=True, unexplained=False, explanations=(), shift=math.nan,
        turn_deg=math.nan, chance=0.0, bent=note("said.as_is", message="it may have bent"),
        bending_misfit=True, bending=math.nan,
    )  # fmt: skip
    found = put(replace(figures, movement=doubtful), "cameras.0.source", source)
    said = [one.finding for one in criteria(found) if one.finding.code.startswith("verdict.misfit")]
    assert [("Calibrate" in told(one)) for one in said] == [asks, asks]


@pytest.mark.parametrize(("sigma_mm", "tells"), [(1.75, True), (1.76, False)])
def test_a_tape_tells_the_size_to_one_per_cent(sigma_mm: float, tells: bool) -> None:
    tape = TapedLength(place="", height_mm=150.0, read_mm=350.0, measured_mm=350.0, error_mm=0.0,
                       error=0.0, sigma_mm=sigma_mm, reason=None)  # fmt: skip
    assert tape_is_precise(tape) == tells
