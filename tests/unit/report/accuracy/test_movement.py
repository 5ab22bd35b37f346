"""What is said of movement, and what light it gets: one sentence, everywhere the same."""

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from limbgram.findings import note, told
from limbgram.reconstruction.mapping.lens_deviations import with_deviation
from limbgram.reconstruction.mapping.scene import Explanation, Movement
from limbgram.reconstruction.movement import moved_mm, movement_found, movement_remark
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.metric import Scale
from limbgram.report.accuracy.assessment import Assessment, assess
from limbgram.report.accuracy.capture import movement_figures
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.layout import accuracy_report
from limbgram.report.html import html_of


def movement(
    shifts: list[float], kind: Literal["still", "step", "drift", "restless", "unclear"] = "step"
) -> Movement:
    shift = np.array(shifts)
    return Movement(
        kind=kind, group=(shift > 0).astype(np.int64), shift=shift, turn_deg=0.1 * shift
    )


def assessed(
    evidence: Evidence, moved: Movement | None = None, bent: Movement | None = None
) -> Assessment:
    scene = replace(evidence.metric.scene, movement=moved, bending=bent)
    return assess(replace(evidence, metric=replace(evidence.metric, scene=scene)))


def shifts(evidence: Evidence, size_mm: float) -> list[float]:
    count = len(evidence.metric.scene.names)
    return [size_mm if k >= count / 2 else 0.0 for k in range(count)]


def light_of(assessment: Assessment, key: str) -> str:
    return next(one.light for one in assessment.criteria if one.key == key)


def test_nothing_is_said_where_nobody_looked_or_nothing_is_known(with_sigmas: Evidence) -> None:
    unknown = Movement.unknown(
        len(with_sigmas.metric.scene.names), note("said.as_is", message="no points")
    )
    for found in (assessed(with_sigmas), assessed(with_sigmas, unknown, unknown)):
        assert not {"movement", "bending"} & {one.key for one in found.criteria}
        assert found.light == "green"


def test_a_board_in_two_planes_is_red_unless_the_limb_kept_still(with_sigmas: Evidence) -> None:
    """An object that was turned over beside it may stand in the scene twice."""
    count = len(with_sigmas.metric.scene.names)
    reason = note("board.photo.tipped", others=9, pushes=())
    aside = tuple(SetAside(name, reason) for name in ("a.jpg", "b.jpg"))
    scale = replace(with_sigmas.metric.scale, set_aside=aside)
    tipped = replace(with_sigmas, metric=replace(with_sigmas.metric, scale=scale))
    unknown = Movement.unknown(count, note("said.as_is", message="no points"))
    for moved in (None, unknown):
        found = assessed(tipped, moved)
        assert (found.light, light_of(found, "board_tipped")) == ("red", "red")
        (one,) = (one for one in found.criteria if one.key == "board_tipped")
        assert told(one.finding).startswith("2 photos show the board in another plane than the 9 ")
    still = assessed(tipped, movement([0.0] * count, "still"))
    assert "board_tipped" not in {one.key for one in still.criteria}


def test_what_does_not_fit_for_a_cause_that_is_not_known_is_a_doubt(with_sigmas: Evidence) -> None:
    """A lens without a board may cause it as well as the limb: neither is green."""
    count = len(with_sigmas.metric.scene.names)
    unsure = note("said.as_is", message="the lens is not known closely enough to tell")
    misfit = Movement.unknown(count, unsure, 1e-9)
    still = movement([0.0] * count, "still")
    moved = assessed(with_sigmas, misfit, still)
    assert (moved.light, light_of(moved, "movement")) == ("amber", "amber")
    assert "Whether the limb kept still is not known" in told(moved.headline)
    bent = assessed(with_sigmas, still, misfit)
    assert (bent.light, light_of(bent, "bending")) == ("amber", "amber")
    assert "Whether the limb kept its shape is not known" in told(bent.headline)
    assert bent.tree["movement"]["bending_misfit"] is True


def explanation(**changes: Any) -> Explanation:
    one = Explanation(
        bodies="halves",
        kind="sway",
        photos=(0, 1),
        numbers=2,
        score=40.0,
        chance=1e-9,
        effect=0.6,
        low=0.3,
        high=0.9,
        variance_before=3.0,
        variance_after=1.1,
        failed=("lens",),
        floor=0.25,
    )
    return replace(one, **changes)


def left_open(photos: int, *explanations: Explanation) -> Movement:
    return replace(Movement.unknown(photos, None, 1e-9), explanations=explanations)


def test_no_error_is_stated_where_something_that_matters_is_not_explained(
    with_sigmas: Evidence,
) -> None:
    count = len(with_sigmas.metric.scene.names)
    still = movement([0.0] * count, "still")
    found = assessed(with_sigmas, still, left_open(count, explanation()))
    assert math.isnan(found.figures.expected.p95_mm)
    assert found.light == "amber"
    assert light_of(found, "surface_p95") == "amber"
    assert found.tree["expected"]["p95_mm"] is None
    small = replace(still, explanations=(explanation(high=0.2),))
    assert assessed(with_sigmas, still, small).light == "green"
    assert math.isfinite(assessed(with_sigmas, still, small).figures.expected.p95_mm)


def test_surroundings_do_not_matter_to_photos_that_the_limb_alone_places(
    with_sigmas: Evidence,
) -> None:
    count = len(with_sigmas.metric.scene.names)
    still = movement([0.0] * count, "still")
    open_ = explanation(bodies="limb and room")
    stepped = replace(movement(shifts(with_sigmas, 2.0)), explanations=(open_,), largest=2.0)
    assert math.isnan(assessed(with_sigmas, stepped, still).figures.expected.p95_mm)
    alone = assessed(with_sigmas, replace(stepped, alone=True), still)
    assert math.isfinite(alone.figures.expected.p95_mm)


def test_the_list_of_explanations_stands_on_the_page_and_in_the_tree(
    with_sigmas: Evidence,
) -> None:
    names = with_sigmas.metric.scene.names
    still = movement([0.0] * len(names), "still")
    found = assessed(with_sigmas, still, left_open(len(names), explanation()))
    listed = found.tree["movement"]["explanations"]
    assert [(one["bodies"], one["kind"], one["told"]) for one in listed] == [
        ("halves", "sway", False)
    ]
    assert listed[0]["photos"] == list(names[:2])
    page = html_of(accuracy_report(found, ()))
    assert "What explains the photos" in page
    assert "undecided: a changing lens explains it as well" in page
    nothing = html_of(accuracy_report(assessed(with_sigmas, still, still), ()))
    assert "What explains the photos" not in nothing


def test_the_table_says_where_nobody_looked_for_movement(with_sigmas: Evidence) -> None:
    unknown = Movement.unknown(
        len(with_sigmas.metric.scene.names), note("said.as_is", message="no points")
    )
    still = movement([0.0] * len(with_sigmas.metric.scene.names), "still")
    never = html_of(accuracy_report(assessed(with_sigmas), ()))
    assert never.count(">not looked for</td>") == 2
    vain = html_of(accuracy_report(assessed(with_sigmas, unknown, unknown), ()))
    assert "not looked for" not in vain
    assert "Whether the limb kept still is not known: no points." in vain
    found = html_of(accuracy_report(assessed(with_sigmas, still, still), ()))
    assert "not looked for" not in found


def test_a_limb_that_kept_still_stays_green(with_sigmas: Evidence) -> None:
    still = movement([0.0] * len(with_sigmas.metric.scene.names), "still")
    found = assessed(with_sigmas, still, still)
    assert (light_of(found, "movement"), light_of(found, "bending")) == ("green", "green")
    assert found.light == "green"


def test_what_looks_bent_may_be_the_lens_where_that_is_not_known(with_sigmas: Evidence) -> None:
    metric = with_sigmas.metric
    still = movement([0.0] * len(metric.scene.names), "still")
    bent = movement(shifts(with_sigmas, 0.4))
    (given,) = with_sigmas.cameras.calibrations
    guessed = replace(with_sigmas.cameras, calibrations=(replace(given, source="exif"),))
    wandering = replace(metric, scene=with_deviation(metric.scene, "principal point"))
    cases = (
        (with_sigmas, "The limb bent: one half"),
        (replace(with_sigmas, cameras=guessed), "because no board calibrated it"),
        (replace(with_sigmas, metric=wandering), "because it differed from photo to photo"),
    )
    for evidence, cause in cases:
        scene = replace(evidence.metric.scene, movement=still, bending=bent)
        evidence = replace(evidence, metric=replace(evidence.metric, scene=scene))
        said = movement_figures(evidence)
        assert said is not None
        assert said.bent is not None
        assert cause in told(said.bent)
        assert (said.bent.code == "movement.shape.bent_or_lens") is cause.startswith("because")
    (judged,) = [one for one in assessed(with_sigmas, still, bent).criteria if one.key == "bending"]
    assert told(judged.finding).endswith("No rigid surface fits all photos. Take them again.")


def test_things_that_moved_beside_limb_and_board_cost_no_light(with_sigmas: Evidence) -> None:
    nothing = movement([0.0] * len(with_sigmas.metric.scene.names), "still")
    found = assessed(with_sigmas, replace(nothing, beside=True), nothing)
    assert found.light == "green"
    (said,) = [one for one in found.criteria if one.key == "movement"]
    assert "Limb and scale board kept still" in told(said.finding)


def test_restlessness_has_more_causes_than_the_limb(with_sigmas: Evidence) -> None:
    swayed = movement(shifts(with_sigmas, 1.6), "restless")
    (said,) = [one for one in assessed(with_sigmas, swayed).criteria if one.key == "movement"]
    assert "in every photo, by up to 1.6 mm and 0.2 degrees: the limb swayed" in told(said.finding)
    assert "stabiliser or rolling shutter" in told(said.finding)


def test_a_limb_that_moved_is_amber_where_it_alone_places_the_photos(
    with_sigmas: Evidence,
) -> None:
    moved = replace(movement(shifts(with_sigmas, 8.0)), alone=True)
    found = assessed(with_sigmas, moved)
    assert found.light == "amber"
    assert "moved by up to 8.0 mm and turned by 0.8 degrees" in told(found.headline)
    assert "by the points on the limb alone" in told(found.headline)
    names = with_sigmas.metric.scene.names
    assert names[-1] in told(found.headline)
    assert "limit.moved" in [one.code for one in found.findings]
    assert found.tree["movement"]["photos"] == list(names[-len(names) // 2 :])


def test_a_board_beside_a_limb_that_moved_is_not_sent_to_the_printer(
    with_sigmas: Evidence,
) -> None:
    metric = with_sigmas.metric
    scale = replace(metric.scale, board_stretch=0.0016, relative_sigma=0.0008)
    unsure = replace(with_sigmas, metric=replace(metric, scale=scale))
    moved = replace(movement(shifts(with_sigmas, 4.0)), alone=True)
    (said,) = [one for one in assessed(unsure, moved).reasons if "longer" in one.values]
    assert said.code == "verdict.scale.beside_moved"
    assert (said.values["longer"], said.values["shorter"]) == ("x", "y")


def test_otherwise_it_is_red_from_a_millimetre(with_sigmas: Evidence) -> None:
    for size_mm, light in ((0.9, "amber"), (1.1, "red")):
        assert assessed(with_sigmas, movement(shifts(with_sigmas, size_mm))).light == light


def test_a_limb_that_bent_is_never_green(with_sigmas: Evidence) -> None:
    for size_mm, light in ((0.9, "amber"), (4.0, "red")):
        still = movement(shifts(with_sigmas, 0.0), "still")
        found = assessed(with_sigmas, still, movement(shifts(with_sigmas, size_mm)))
        assert found.light == light
        assert "The limb bent" in told(found.headline)


def test_a_drift_counts_from_end_to_end() -> None:
    drift = movement([2.0, 1.0, 0.0, 1.0, 2.5], "drift")
    assert moved_mm(drift) == 4.5
    assert moved_mm(replace(drift, largest=4.2)) == 4.2, "between any two photos, as it was found"
    assert "by 4.5 mm in all" in told(movement_found(drift, list("abcde"), "mm"))
    assert math.isnan(moved_mm(None))


def test_a_movement_without_a_clear_course_blames_no_photo() -> None:
    moved = replace(movement([0.0, 0.3, 0.5], "unclear"), largest=0.6)
    said = movement_found(moved, list("abc"), "mm")
    assert (said.code, said.gravity) == ("movement.unclear", "doubt")
    assert said.values == {"far": 0.6, "unit": "mm"}


def test_each_moved_photo_has_its_remark(with_sigmas: Evidence) -> None:
    scene = replace(with_sigmas.metric.scene, movement=movement(shifts(with_sigmas, 8.0)))
    assert movement_remark(scene, 0, "mm") == ()
    last = len(scene.names) - 1
    (remark,) = movement_remark(scene, last, "mm")
    assert told(remark) == "the limb lies 8.0 mm from where most photos show it"


def test_many_photos_are_counted_not_listed() -> None:
    names = [f"{k}.jpg" for k in range(20)]
    said = told(movement_found(movement([0.0] * 10 + [3.0] * 10), names, "mm"))
    assert said.endswith("in 10.jpg, 11.jpg, 12.jpg, 13.jpg, 14.jpg, 15.jpg and 4 more.")


def test_movement_of_a_scene_without_scale_is_not_in_mm(with_sigmas: Evidence) -> None:
    scale = Scale(unit="unitless", source="none", relative_sigma=math.nan)
    bare = replace(with_sigmas, metric=replace(with_sigmas.metric, scale=scale))
    moved = movement(shifts(with_sigmas, 0.6))
    for evidence, unit in ((with_sigmas, "mm"), (bare, "scene units")):
        found = assessed(evidence, moved, moved)
        told_in = {one.key: one.unit for one in found.criteria}
        assert told_in["movement"] == told_in["bending"] == unit
    page = html_of(accuracy_report(assessed(bare), ()))
    assert '<td>scene units</td><td class="n"></td>' in page
    assert "<td>mm</td>" not in page
