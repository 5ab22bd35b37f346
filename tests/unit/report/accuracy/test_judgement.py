"""Lights, first line and advice follow the figures, at their limits exactly."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.interval import Interval, plus_minus
from limbgram.core.mesh.mesh import Part, Relation, Repairs
from limbgram.findings import Finding, Gravity, note, sentence, told
from limbgram.reconstruction.measuring import uncertainty as sources
from limbgram.reconstruction.scale.metric import Scale
from limbgram.reconstruction.scale.stated_lengths import LengthEnds, TapedGirth
from limbgram.reconstruction.scale.taped_girths import TapeWitness, TapeWitnesses
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.judgement import GAP, SCALE, SURFACE_P95, findings_in
from limbgram.report.accuracy.layout import accuracy_report
from limbgram.report.accuracy.truth import KnownTruth
from limbgram.report.alignment import Truth
from limbgram.report.html import html_of
from limbgram.report.image_scale import image_scales

RADIUS_MM = 50.0
GIRTH_MM = 2 * math.pi * RADIUS_MM
"""Of the tube."""


def codes(found: Sequence[Finding]) -> list[str]:
    return [one.code for one in found]


def with_check(evidence: Evidence, error: float) -> Evidence:
    control, check = evidence.metric.scale.lengths
    lengths = (control, replace(check, measured_mm=check.known_mm * (1 + error)))
    scale = replace(evidence.metric.scale, lengths=lengths)
    return replace(evidence, metric=replace(evidence.metric, scale=scale))


@pytest.mark.parametrize(
    ("limit", "value", "light"),
    [
        (SCALE, 0.1, "green"),
        (SCALE, 0.1001, "amber"),
        (SCALE, 0.3, "amber"),
        (SCALE, 0.3001, "red"),
        (SURFACE_P95, 0.6, "green"),
        (SURFACE_P95, 1.01, "red"),
        (GAP, float("nan"), "amber"),
    ],
)
def test_lights_change_at_their_limits(limit: Any, value: float, light: str) -> None:
    assert limit.judge("verdict.part.clear", value).light == light


def test_a_good_case_is_green_in_millimetres(with_sigmas: Evidence) -> None:
    tree = assess(with_sigmas)
    assert tree.light == "green"
    assert told(tree.headline).startswith(
        "GREEN. Surface: 95 % within 0.25 mm (limit 0.60 mm). Scale: "
    )  # 1.96 * 0.1
    assert "0.050 %" in told(tree.headline)
    assert tree.figures.expected.basis == "vertex sigmas"
    assert {one.part: round(one.sigma_mm, 3) for one in tree.figures.expected.budget} == {
        "image measurement": 0.08,
        "scale": 0.06,
    }


def test_a_surface_that_its_rms_alone_puts_in_doubt_says_so(with_sigmas: Evidence) -> None:
    """A few very unsure places: 95 % of the surface are as sure as they need to be."""
    assert with_sigmas.mesh.sigma_mm is not None
    sigma_mm = with_sigmas.mesh.sigma_mm.copy()
    for size_mm, light in ((1.8, "amber"), (3.0, "red")):
        sigma_mm[::25] = size_mm
        tree = assess(replace(with_sigmas, mesh=replace(with_sigmas.mesh, sigma_mm=sigma_mm)))
        p95, rms = (
            next(one for one in tree.criteria if one.key == key)
            for key in ("surface_p95", "surface_rms")
        )
        assert (tree.light, p95.light, rms.light) == (light, "green", light)
        assert findings_in(tree.headline)[0] == rms.finding
        assert "Expected RMS error 0." in told(tree.headline)


def test_a_remark_that_is_a_sentence_ends_once(with_sigmas: Evidence) -> None:
    scene = with_sigmas.metric.scene
    zoomed = replace(
        scene.verdicts[0], remark=note("said.as_is", message="It was zoomed. Take it again.")
    )
    scene = replace(scene, verdicts=(zoomed, *scene.verdicts[1:]))
    tree = assess(replace(with_sigmas, metric=replace(with_sigmas.metric, scene=scene)))
    (said,) = (one for one in tree.findings if one.code == "limit.photos.remark")
    assert sentence(said) == f"{zoomed.name}: It was zoomed. Take it again."


def test_a_share_put_into_the_surface_is_the_share_of_the_budget(with_sigmas: Evidence) -> None:
    """Also of uneven triangles, and where a check length contradicts the scale."""
    mesh = with_sigmas.mesh
    squeezed, top = mesh.vertices_mm.copy(), mesh.vertices_mm[:, 2].max()
    height = (squeezed[:, 2] / top) ** 2
    squeezed[:, 2] = height * top  # small triangles at the foot
    noise, scale, offset = 0.03 * np.ones(len(mesh)), 0.05 * height, 0.01 * np.ones(len(mesh))
    cameras = np.column_stack([0.04 * (1 - height), np.where(height > 0.5, -0.02, 0.0)])
    shared = np.column_stack([scale, cameras, offset])
    uneven = replace(
        mesh,
        vertices_mm=squeezed,
        sigma_mm=np.sqrt(noise**2 + (shared**2).sum(1)).astype(np.float32),
        shared_mm=shared.astype(np.float32),
        shared_sources=(sources.SCALE, sources.CAMERAS, sources.CAMERAS, sources.OFFSET),
    )
    areas = uneven.vertex_areas_mm2()
    put_in = {
        "image measurement": noise[:, None],
        sources.SCALE: scale[:, None],
        sources.CAMERAS: cameras,
        sources.OFFSET: offset[:, None],
    }
    for case in (with_sigmas, with_check(with_sigmas, 0.004)):
        expected = assess(replace(case, mesh=uneven)).figures.expected
        budget = {one.part: one.sigma_mm for one in expected.budget}
        assert budget == pytest.approx(
            {name: np.sqrt(areas @ (of**2).sum(1) / areas.sum()) for name, of in put_in.items()},
            rel=1e-4,
        )
        assert np.hypot.reduce([*budget.values()]) == pytest.approx(expected.rms_mm, rel=1e-6)


def test_sources_without_names_stay_in_the_budget(with_sigmas: Evidence) -> None:
    unnamed = replace(with_sigmas.mesh, shared_sources=())
    budget = assess(replace(with_sigmas, mesh=unnamed)).figures.expected.budget
    assert {one.part: round(one.sigma_mm, 3) for one in budget} == {
        "image measurement": 0.08,
        "shared by all vertices": 0.06,
    }


@pytest.mark.parametrize(("error", "light"), [(0.002, "amber"), (-0.004, "red")])
def test_a_check_length_that_is_off_sets_the_light_and_is_named(
    with_sigmas: Evidence, error: float, light: str
) -> None:
    tree = assess(with_check(with_sigmas, error))
    assert tree.light == light
    assert f"A-B is off by {100 * abs(error):.3f} %" in told(tree.headline)
    assert tree.findings[0].gravity is Gravity.FAULT
    assert tree.findings[0].code == "limit.scale.check_off"


@pytest.mark.parametrize(
    ("higher", "light", "said"),
    [
        (1.0, "green", "come out square"),
        (1.0009, "green", "come out square"),
        (1.0037, "amber", "come out 0.37 % higher than wide (limit 0.1 %)"),
        (0.9963, "amber", "come out 0.37 % wider than high (limit 0.1 %)"),
    ],
)
def test_pixels_that_are_not_square_are_amber_and_told_why(
    with_sigmas: Evidence, higher: float, light: str, said: str
) -> None:
    scene = with_sigmas.metric.scene
    lens = replace(scene.cameras[0], fx=scene.cameras[0].fx * higher)
    metric = replace(with_sigmas.metric, scene=replace(scene, cameras=(lens,)))
    judged = assess(replace(with_sigmas, metric=metric)).criteria
    found = next(one for one in judged if one.key == "square_pixels")
    assert found.light == light
    assert said in sentence(found.finding)


def test_a_calibration_whose_pixels_are_not_square_is_amber_though_the_photos_mend_it(
    with_sigmas: Evidence,
) -> None:
    (given,) = with_sigmas.cameras.calibrations
    lens = replace(given.camera, fx=given.camera.fy * 0.9963)
    spoiled = replace(with_sigmas.cameras, calibrations=(replace(given, camera=lens),))
    judged = assess(replace(with_sigmas, cameras=spoiled)).criteria
    found = next(one for one in judged if one.key == "square_pixels")
    assert found.light == "amber"
    assert "says that its pixels are 0.37 % wider than high (limit 0.1 %)" in sentence(
        found.finding
    )
    assert "the calibration board is stretched" in sentence(found.finding)


def test_a_board_stretched_one_way_is_amber_and_the_reason_is_told(
    with_sigmas: Evidence,
) -> None:
    metric = with_sigmas.metric
    spoiled = replace(metric.scale, board_stretch=-0.002, relative_sigma=0.001)
    tree = assess(replace(with_sigmas, metric=replace(metric, scale=spoiled)))
    assert tree.light == "amber"
    assert "known to 0.200 % (limit 0.1 %): the board is 0.20 % longer along its y" in told(
        tree.headline
    )
    assert tree.figures.lengths.board_stretch == -0.002
    for doubt in ("uncalibrated", "rolling shutter"):
        doubted = replace(metric, scale=replace(spoiled, stretch_doubt=doubt))
        either = assess(replace(with_sigmas, metric=doubted))
        assert "verdict.scale.stretched_or_lens" in codes(either.reasons)
    unsure = replace(metric.scale, board_stretch=0.0, relative_sigma=0.003)
    taped = assess(replace(with_sigmas, metric=replace(metric, scale=unsure)))
    assert "verdict.scale.vague" in codes(taped.reasons)
    true = replace(metric.scale, board_stretch=0.0002, relative_sigma=0.0001)
    fine = assess(replace(with_sigmas, metric=replace(metric, scale=true)))
    assert fine.light == "green"


def test_without_a_check_it_is_never_green(with_sigmas: Evidence) -> None:
    scale = replace(with_sigmas.metric.scale, lengths=with_sigmas.metric.scale.lengths[:1])
    tree = assess(replace(with_sigmas, metric=replace(with_sigmas.metric, scale=scale)))
    assert tree.light == "amber"
    assert "No length" in told(tree.headline)
    assert "limit.scale.unchecked" in codes(tree.findings)


def test_a_share_that_nothing_tells_is_not_known_rather_than_nothing(evidence: Evidence) -> None:
    scale = replace(evidence.metric.scale, relative_sigma=math.nan, lengths=())
    found = assess(replace(evidence, metric=replace(evidence.metric, scale=scale)))
    budget = {one.part: one.sigma_mm for one in found.figures.expected.budget}
    assert math.isnan(budget["scale, at the far end"])
    assert found.figures.expected.rms_mm == budget["image measurement"] > 0
    known = {one.part: one.sigma_mm for one in assess(evidence).figures.expected.budget}
    assert known["scale, at the far end"] > 0


def test_without_scale_there_are_no_millimetres(evidence: Evidence) -> None:
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    tree = assess(replace(evidence, metric=replace(evidence.metric, scale=scale)))
    assert told(tree.headline).startswith("RED. No millimetres. Nothing")
    assert tree.unit == "scene units"
    assert math.isnan(tree.figures.images.distance_over_stated)
    page = html_of(accuracy_report(tree, ()))
    assert "give a known length" in page
    assert ">-0.0<" not in page


def test_an_image_scale_needs_a_scale(evidence: Evidence) -> None:
    bare = replace(evidence.metric, scale=replace(evidence.metric.scale, unit="unitless"))
    for metric, known in ((evidence.metric, True), (bare, False)):
        numbers = [one.scale_number for one in image_scales(evidence.photos, metric)]
        assert len(numbers) == 12
        assert np.isfinite(numbers).all() == known


def test_a_side_without_photos_is_red_however_sure_the_rest_is(with_sigmas: Evidence) -> None:
    scene = with_sigmas.metric.scene
    assert scene.ring is not None
    half = replace(scene, ring=replace(scene.ring, largest_gap_deg=190.0))
    tree = assess(replace(with_sigmas, metric=replace(with_sigmas.metric, scene=half)))
    assert tree.light == "red"
    assert "190 degrees" in told(tree.headline)


def test_advice_names_what_is_wrong_and_nothing_else(with_sigmas: Evidence) -> None:
    said = " ".join(sentence(one) for one in assess(with_sigmas).findings)
    assert "largest part of the expected error is image measurement: 0.080 mm" in said
    for absent in ("board", "EXIF", "filled", "pattern", "soft", "base is small"):
        assert absent not in said
    camera = replace(with_sigmas.cameras.calibrations[0], source="exif")
    guessed = replace(with_sigmas, cameras=replace(with_sigmas.cameras, calibrations=(camera,)))
    assert any("guessed from EXIF" in sentence(one) for one in assess(guessed).findings)
    untold = replace(camera, source="guess")
    guessed = replace(with_sigmas, cameras=replace(with_sigmas.cameras, calibrations=(untold,)))
    said = " ".join(sentence(one) for one in assess(guessed).findings)
    assert "was guessed, as EXIF tells nothing of it" in said
    assert "from EXIF" not in said


def without_camera_file(evidence: Evidence) -> Evidence:
    camera = replace(evidence.cameras.calibrations[0], source="exif")
    return replace(evidence, cameras=replace(evidence.cameras, calibrations=(camera,)))


def test_a_missing_camera_file_is_told_in_millimetres(with_sigmas: Evidence) -> None:
    assert assess(with_sigmas).self_calibration is None
    mesh = with_sigmas.mesh
    assert mesh.shared_mm is not None
    shared_mm = np.column_stack([mesh.shared_mm, np.full(len(mesh), 0.02, np.float32)])
    named = (*mesh.shared_sources, sources.CAMERAS)
    mesh = replace(mesh, shared_mm=shared_mm, shared_sources=named)
    guessed = assess(without_camera_file(replace(with_sigmas, mesh=mesh)))
    found = guessed.self_calibration
    assert found is not None
    share = next(one for one in guessed.figures.expected.budget if one.part == sources.CAMERAS)
    assert found.sigma_mm == share.sigma_mm == pytest.approx(0.02, rel=0.01)
    assert f"costs {plus_minus(Interval.of_sigma(found.sigma_mm), 3)} mm" in sentence(found.finding)
    (judged,) = (one for one in guessed.criteria if one.key == "lens_found")
    assert judged.value == pytest.approx(1.96 * found.sigma_mm)
    assert judged.light == "green"
    (advised,) = (one for one in guessed.findings if one.code == "limit.no_camera_file")
    assert advised.values["cost"] == found.finding
    assert advised.gravity is Gravity.DOUBT


def test_a_lens_of_which_nobody_knows_the_cost_is_never_green(with_sigmas: Evidence) -> None:
    bare = replace(with_sigmas, mesh=replace(with_sigmas.mesh, sigma_mm=None, shared_mm=None))
    guessed = assess(without_camera_file(bare))
    assert guessed.self_calibration is not None
    assert guessed.self_calibration.finding.code == "verdict.no_camera_file.cost_unknown"
    (judged,) = (one for one in guessed.criteria if one.key == "lens_found")
    assert judged.light == "amber"
    assert guessed.light != "green"
    (advised,) = (one for one in guessed.findings if one.code == "limit.no_camera_file")
    assert advised.gravity is Gravity.FAULT


def test_zoomed_photos_are_never_green_and_are_named(with_sigmas: Evidence) -> None:
    scene = with_sigmas.metric.scene
    verdicts = tuple(
        replace(one, remark=note("said.as_is", message="zoomed") if k in (1, 2) else None)
        for k, one in enumerate(scene.verdicts)
    )
    scene = replace(scene, verdicts=verdicts)
    tree = assess(replace(with_sigmas, metric=replace(with_sigmas.metric, scene=scene)))
    assert tree.light == "amber"
    names = f"{scene.names[1]}, {scene.names[2]}"
    assert (
        f"2 of {len(scene.names)} photos have another focal length than the others: {names}."
        in told(tree.headline)
    )
    assert not [one for one in assess(with_sigmas).criteria if one.key == "zoomed"]


def with_part(evidence: Evidence, relation: Relation, lacking: float, *, given: bool) -> Evidence:
    """The same limb beside another body of half its size."""
    other = Part(
        number=2,
        area_mm2=30_000.0,
        middle_mm=np.zeros(3),
        size_mm=200.0,
        looked_at=0.3,
        relation=relation,
    )
    repairs = Repairs(
        islands_dropped=0,
        island_share=lacking,
        holes_filled=0,
        part_given=given,
        others=(other,),
    )
    return replace(evidence, mesh=replace(evidence.mesh, repairs=repairs))


def test_the_other_side_of_a_wall_is_nothing_missing(with_sigmas: Evidence) -> None:
    assert assess(with_part(with_sigmas, "other side", 0.0, given=False)).light == "green"


def test_what_was_torn_off_is_red(with_sigmas: Evidence) -> None:
    tree = assess(with_part(with_sigmas, "torn off", 0.45, given=True))
    assert tree.light == "red"
    assert "45.0 % of what was measured" in told(tree.headline)


def test_a_body_apart_leaves_a_doubt_until_the_user_chooses(with_sigmas: Evidence) -> None:
    tree = assess(with_part(with_sigmas, "apart", 0.0, given=False))
    assert tree.light == "amber"
    assert "part 2" in told(tree.headline)
    assert "--part" in told(tree.headline)
    assert assess(with_part(with_sigmas, "apart", 0.0, given=True)).light == "green"


def with_tape(found: Evidence, read_mm: float, sigma_mm: float = 1.5) -> Evidence:
    """A tape on the tube, whose girth is that of its radius."""
    witness = TapeWitness(
        taped=TapedGirth(girth_mm=read_mm), measured_mm=GIRTH_MM, sigma_mm=sigma_mm
    )
    return replace(found, tapes=TapeWitnesses((witness,)))


def on_one_board(found: Evidence) -> Evidence:
    """Scaled by a board alone: every check lies between its own corners."""
    scale = found.metric.scale
    lengths = tuple(replace(one, between="board") for one in scale.lengths)
    scale = replace(scale, source="board", lengths=lengths)
    return replace(found, metric=replace(found.metric, scale=scale))


@pytest.mark.parametrize(("sigma_mm", "checked"), [(0.59, True), (0.61, False)])
def test_a_length_known_to_1_percent_checks_and_a_vague_one_does_not(
    evidence: Evidence, sigma_mm: float, checked: bool
) -> None:
    scale = evidence.metric.scale
    lengths = tuple(
        replace(one, sigma_mm=sigma_mm) if one.role == "check" else one for one in scale.lengths
    )
    metric = replace(evidence.metric, scale=replace(scale, lengths=lengths))
    vague = replace(evidence, metric=metric)
    tree = assess(vague)
    assert tree.size_checked is checked
    assert ("limit.scale.one_source" in codes(tree.findings)) is not checked


def test_a_size_that_rests_on_one_board_is_said_to_be_unchecked(with_sigmas: Evidence) -> None:
    tree = assess(on_one_board(with_sigmas))
    assert tree.light == "green"
    assert told(tree.headline).endswith("; not checked independently.")
    assert not tree.size_checked
    taped = assess(with_tape(on_one_board(with_sigmas), GIRTH_MM + 1))
    assert told(taped.headline).endswith("; confirmed to 1.0 % by tape.")
    assert taped.size_checked
    assert "limit.scale.one_source" not in codes(taped.findings)
    typed = on_one_board(with_sigmas)
    other = replace(typed.metric.scale.lengths[1], between="points")
    scale = replace(typed.metric.scale, lengths=(typed.metric.scale.lengths[0], other))
    checked = assess(replace(typed, metric=replace(typed.metric, scale=scale)))
    assert told(checked.headline).startswith(
        "GREEN. Surface: 95 % within 0.25 mm (limit 0.60 mm). "
    )
    assert told(checked.headline).endswith("; checked independently.")
    assert checked.tree["size_checked"] is True


def between(found: Evidence, control: LengthEnds, check: LengthEnds) -> Evidence:
    lengths = (
        replace(found.metric.scale.lengths[0], between=control),
        replace(found.metric.scale.lengths[1], between=check),
    )
    scale = replace(found.metric.scale, lengths=lengths)
    return replace(found, metric=replace(found.metric, scale=scale))


def test_a_print_that_checks_a_print_leaves_the_size_unchecked(with_sigmas: Evidence) -> None:
    """A mat printed 3 % too large agrees with itself, and with a board of the same printer."""
    mat = between(with_sigmas, "plate", "plate")
    board = between(on_one_board(with_sigmas), "board", "plate")
    for printed in (mat, board):
        tree = assess(printed)
        assert tree.light == "green"
        assert not tree.size_checked
        assert "Scale: set by prints of one printer, 1 check length agrees" in told(tree.headline)
        assert told(tree.headline).endswith("; not checked independently.")
        assert "limit.scale.one_source" in codes(tree.findings)
        taped = assess(with_tape(printed, GIRTH_MM))
        assert "; confirmed to 1.0 % by tape" in told(taped.headline)
        assert "limit.scale.one_source" not in codes(taped.findings)
    assert assess(between(with_sigmas, "points", "plate")).size_checked


@pytest.mark.parametrize("error", [0.002, -0.002])
def test_a_length_that_disagrees_checks_no_size(with_sigmas: Evidence, error: float) -> None:
    """A second distance that is 0.2 % off: the scale is amber, and nothing confirms the size."""
    tree = assess(with_check(with_sigmas, error))
    assert [one.light for one in tree.criteria if one.key == SCALE.key] == ["amber"]
    assert not tree.size_checked
    assert told(tree.headline).endswith("; an independent check disagrees.")
    assert assess(with_check(with_sigmas, error / 3)).size_checked
    taped = assess(with_tape(with_check(with_sigmas, error), GIRTH_MM))
    assert taped.size_checked
    assert told(taped.headline).endswith("; confirmed to 1.0 % by tape.")


def test_a_board_s_own_length_does_not_speak_against_another_that_agrees(
    with_sigmas: Evidence,
) -> None:
    found = between(on_one_board(with_check(with_sigmas, 0.002)), "board", "board")
    own, typed = found.metric.scale.lengths[1], with_sigmas.metric.scale.lengths[1]
    lengths = (found.metric.scale.lengths[0], own, replace(typed, between="points"))
    scale = replace(found.metric.scale, lengths=lengths)
    assert assess(replace(found, metric=replace(found.metric, scale=scale))).size_checked


@pytest.mark.parametrize(("times", "checked"), [(1.0005, True), (1.01, False)])
def test_a_true_surface_checks_the_size_where_it_agrees(
    with_sigmas: Evidence, times: float, checked: bool
) -> None:
    mesh = with_sigmas.mesh
    truth = Truth(
        vertices_mm=times * mesh.vertices_mm,
        faces=mesh.faces,
        seen=np.ones(len(mesh), bool),
        centres_mm=np.zeros((0, 3)),
    )
    known = KnownTruth(
        kind="a mesh file", truth=truth, centres_mm=np.zeros((0, 3)), alignment="frame"
    )
    tree = assess(with_sigmas, known)
    assert tree.size_checked is checked
    assert told(tree.headline).endswith(
        "; checked independently." if checked else "; an independent check disagrees."
    )


def test_a_tape_that_is_not_sure_enough_does_not_check_the_size(with_sigmas: Evidence) -> None:
    board = on_one_board(with_sigmas)
    for sigma_mm, checked in ((0.00499 * GIRTH_MM, True), (0.00501 * GIRTH_MM, False)):
        assert assess(with_tape(board, GIRTH_MM, sigma_mm)).size_checked is checked
    vague = assess(with_tape(board, 1.03 * GIRTH_MM, 39.0))
    assert vague.light == "green"  # it contradicts nothing
    assert told(vague.headline).endswith(
        "; not checked independently: the tape is sure to 24.1 % only (1 % is needed)."
    )
    assert "limit.scale.one_source" in codes(vague.findings)


def test_a_scale_that_a_tape_confirms_is_not_advised_to_be_unchecked(with_sigmas: Evidence) -> None:
    scale = replace(with_sigmas.metric.scale, lengths=with_sigmas.metric.scale.lengths[:1])
    alone = replace(with_sigmas, metric=replace(with_sigmas.metric, scale=scale))
    for sigma_mm, checked in ((1.5, True), (20.0, False)):
        tree = assess(with_tape(alone, GIRTH_MM, sigma_mm))
        assert tree.size_checked is checked
        assert ("limit.scale.unchecked" in codes(tree.findings)) is not checked


def test_every_tape_that_can_tell_must_agree(with_sigmas: Evidence) -> None:
    board = on_one_board(with_sigmas)
    (good,) = with_tape(board, GIRTH_MM, 1.5).tapes.found
    (off,) = with_tape(board, GIRTH_MM + 3.1, 1.5).tapes.found
    (vague,) = with_tape(board, GIRTH_MM + 10, 20.0).tapes.found
    both = assess(replace(board, tapes=TapeWitnesses((good, off))))
    assert (both.light, both.size_checked) == ("amber", False)
    assert told(both.headline).endswith("; not checked independently.")
    by_hand = assess(replace(with_sigmas, tapes=TapeWitnesses((good, off))))
    assert (by_hand.light, by_hand.size_checked) == ("amber", False)
    assert told(by_hand.headline).endswith("; a taped girth contradicts it.")
    passed_over = assess(replace(board, tapes=TapeWitnesses((good, vague))))
    assert (passed_over.light, passed_over.size_checked) == ("green", True)
    assert "; confirmed to 1.0 % by tape" in told(passed_over.headline)


def test_a_result_that_is_not_green_says_so_too_where_a_tape_confirms_its_size(
    with_sigmas: Evidence,
) -> None:
    doubtful = with_part(on_one_board(with_sigmas), "apart", 0.0, given=False)
    assert told(assess(doubtful).headline).endswith("; not checked independently.")
    taped = assess(with_tape(doubtful, GIRTH_MM))
    assert told(taped.headline).endswith("; confirmed to 1.0 % by tape.")


def test_nothing_confirms_a_size_without_millimetres(evidence: Evidence) -> None:
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    bare = replace(evidence, metric=replace(evidence.metric, scale=scale))
    assert not assess(with_tape(bare, GIRTH_MM)).size_checked


@pytest.mark.parametrize(
    ("off_mm", "sigma_mm", "light"),
    [
        (2.9, 1.5, "green"),
        (-2.9, 1.5, "green"),
        (3.1, 1.5, "amber"),
        (-6.1, 1.5, "red"),
        (6.1, 4.0, "green"),
        (-0.1 * 2 * math.pi * RADIUS_MM, 1.5, "red"),
    ],
)
def test_a_tape_is_believed_within_its_own_error_and_no_further(
    with_sigmas: Evidence, off_mm: float, sigma_mm: float, light: str
) -> None:
    tree = assess(with_tape(on_one_board(with_sigmas), GIRTH_MM + off_mm, sigma_mm))
    assert tree.light == light
    named = "the scale board is probably not as large as stated" in told(tree.headline)
    assert named == (light != "green")
    assert tree.size_checked == (light == "green" and sigma_mm == 1.5)
    assert ("not checked" in told(tree.headline)) == (not tree.size_checked)
    advised = "limit.tape.conflict" in codes(tree.findings)
    assert advised == (light != "green")


def test_a_tape_that_cannot_be_compared_confirms_nothing(with_sigmas: Evidence) -> None:
    witness = TapeWitness(
        taped=TapedGirth(girth_mm=300, height_mm=40),
        measured_mm=math.nan,
        sigma_mm=math.nan,
        reason=note("said.as_is", message="the surface has no whole girth there"),
    )
    tree = assess(replace(on_one_board(with_sigmas), tapes=TapeWitnesses((witness,))))
    assert tree.light == "green"
    assert not tree.size_checked
    assert (
        "; not checked independently: the taped girth at 40 mm above board or table could not be "
        "compared (the surface has no whole girth there)." in told(tree.headline)
    )
    (advised,) = (one for one in tree.findings if one.code == "limit.tape.not_compared")
    assert "40 mm above board or table could not be compared" in sentence(advised)


@pytest.mark.parametrize(("stated_m", "light"), [(0.9, "green"), (0.5, "amber"), (9.0, "red")])
def test_a_scale_that_contradicts_the_focus_is_questioned(
    with_sigmas: Evidence, stated_m: float, light: str
) -> None:
    photos = tuple(
        replace(photo, exif=replace(photo.exif, subject_m=stated_m))
        for photo in with_sigmas.photos.photos
    )
    found = replace(with_sigmas, photos=replace(with_sigmas.photos, photos=photos))
    tree = assess(found)
    assert tree.light == light
    assert ("another unit" in told(tree.headline)) == (light != "green")


@pytest.mark.parametrize(("sigmas", "light"), [(2.9, "green"), (-3.1, "amber"), (300.0, "amber")])
def test_a_camera_that_the_photos_contradict_is_amber(
    with_sigmas: Evidence, sigmas: float, light: str
) -> None:
    given = with_sigmas.cameras.calibrations[0]
    assert with_sigmas.metric.scene.lens_covariance is not None
    after = with_sigmas.metric.scene.lens_covariance[0, 0, 0]
    learned = math.sqrt(given.covariance[0, 0] - after)
    moved = replace(given.camera, fx=given.camera.fx - sigmas * learned)
    cameras = replace(with_sigmas.cameras, calibrations=(replace(given, camera=moved),))
    tree = assess(replace(with_sigmas, cameras=cameras))
    assert tree.light == light
    assert ("say another fx" in told(tree.headline)) == (light != "green")


def test_half_a_limb_is_red_though_every_photo_was_placed(with_sigmas: Evidence) -> None:
    mesh = with_sigmas.mesh
    y = mesh.vertices_mm[:, 1]
    half = replace(mesh, faces=mesh.faces[(y[mesh.faces] >= 0).all(1)])
    tree = assess(replace(with_sigmas, mesh=half))
    assert tree.light == "red"
    assert "directions round the limb have no measured surface" in told(tree.headline)
    assert told(tree.headline).startswith("RED. ")
    assert tree.reasons[0] in findings_in(tree.headline)


def test_every_reason_is_kept_the_gravest_first(with_sigmas: Evidence) -> None:
    tree = assess(with_tape(with_check(with_sigmas, 0.002), GIRTH_MM + 30))
    assert [one.light for one in tree.criteria if one.light != "green"]
    assert tree.reasons[0].code == "verdict.tape.contradicts"
    assert tree.reasons[1].code == "verdict.scale.off"
    assert tree.reasons[1].values["label"] == "A-B"


def test_bare_places_are_said_before_all_that_is_as_grave(with_sigmas: Evidence) -> None:
    """A third of the surface is three times less sure than the rest; then all of it is."""
    mesh = with_sigmas.mesh
    bare = mesh.vertices_mm[:, 2] > np.quantile(mesh.vertices_mm[:, 2], 2 / 3)
    for sigma_mm, said in ((np.where(bare, 0.3, 0.1), True), (np.full(len(mesh), 0.3), False)):
        sparse = replace(mesh, sigma_mm=sigma_mm.astype(np.float32))
        found = assess(replace(with_sigmas, mesh=sparse)).findings
        missing = [one for one in found if one.code == "limit.paint"]
        assert bool(missing) == said
        if said:
            unsure = missing[0].values["unsure_share"]
            assert isinstance(unsure, float)
            assert 0.3 < unsure < 0.4
            worth_doing = [one for one in found if one.gravity is Gravity.DOUBT]
            assert worth_doing[0] is missing[0]


def test_what_95_percent_of_the_surface_keep_is_kept_by_95_of_100_captures(
    with_sigmas: Evidence,
) -> None:
    """Of captures whose sigmas are off by 14 % each, one standard deviation."""
    expected = assess(with_sigmas).figures.expected
    draw = np.random.default_rng(95)
    sigmas_mm = with_sigmas.mesh.sigma_mm[:: len(with_sigmas.mesh) // 300]
    off_mm = np.abs(draw.normal(0.0, sigmas_mm, (4000, len(sigmas_mm))))
    true_mm = np.quantile(off_mm, 0.95, axis=1)
    usual_mm = float(np.median(true_mm))
    kept = usual_mm * np.exp(draw.normal(0.0, 0.14, 4000)) <= expected.p95_mm
    assert 0.94 < kept.mean() < 0.96
