"""Lights, first line and advice follow the figures, at their limits exactly."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.measuring import uncertainty as sources
from limbgram.report.accuracy import Evidence, assess
from limbgram.report.accuracy.judgement import GAP, SCALE, SURFACE_P95
from limbgram.scale.metric import Scale
from limbgram.surface.mesh import Part, Relation, Repairs


def tree_of(evidence: Evidence) -> dict[str, Any]:
    return assess(evidence).tree


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
    assert limit.judge(value, "").light == light


def test_a_good_case_is_green_in_millimetres(with_sigmas: Evidence) -> None:
    tree = tree_of(with_sigmas)
    assert tree["light"] == "green"
    assert tree["headline"].startswith("GREEN: 0.20 mm.")  # 1.96 * 0.1
    assert "0.050 %" in tree["headline"]
    assert tree["expected"]["basis"] == "vertex sigmas"
    assert {one["part"]: round(one["sigma_mm"], 3) for one in tree["expected"]["budget"]} == {
        "image measurement": 0.08,
        "scale": 0.06,
    }


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
        expected = tree_of(replace(case, mesh=uneven))["expected"]
        budget = {one["part"]: one["sigma_mm"] for one in expected["budget"]}
        assert budget == pytest.approx(
            {name: np.sqrt(areas @ (of**2).sum(1) / areas.sum()) for name, of in put_in.items()},
            rel=1e-4,
        )
        assert np.hypot.reduce([*budget.values()]) == pytest.approx(expected["rms_mm"], rel=1e-6)


def test_sources_without_names_stay_in_the_budget(with_sigmas: Evidence) -> None:
    unnamed = replace(with_sigmas.mesh, shared_sources=())
    budget = tree_of(replace(with_sigmas, mesh=unnamed))["expected"]["budget"]
    assert {one["part"]: round(one["sigma_mm"], 3) for one in budget} == {
        "image measurement": 0.08,
        "shared by all vertices": 0.06,
    }


@pytest.mark.parametrize(("error", "light"), [(0.002, "amber"), (-0.004, "red")])
def test_a_check_length_that_is_off_sets_the_light_and_is_named(
    with_sigmas: Evidence, error: float, light: str
) -> None:
    tree = tree_of(with_check(with_sigmas, error))
    assert tree["light"] == light
    assert f"A-B is off by {100 * abs(error):.3f} %" in tree["headline"]
    assert tree["findings"][0]["gravity"] == "serious"


def test_without_a_check_it_is_never_green(with_sigmas: Evidence) -> None:
    scale = replace(with_sigmas.metric.scale, lengths=with_sigmas.metric.scale.lengths[:1])
    tree = tree_of(replace(with_sigmas, metric=replace(with_sigmas.metric, scale=scale)))
    assert tree["light"] == "amber"
    assert "No length" in tree["headline"]
    assert any("second length" in one["what"] for one in tree["findings"])


def test_without_scale_there_are_no_millimetres(evidence: Evidence) -> None:
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    tree = tree_of(replace(evidence, metric=replace(evidence.metric, scale=scale)))
    assert tree["headline"].startswith("RED: no millimetres.")
    assert tree["unit"] == "scene units"


def test_a_side_without_photos_is_red_however_sure_the_rest_is(with_sigmas: Evidence) -> None:
    scene = with_sigmas.metric.scene
    assert scene.ring is not None
    half = replace(scene, ring=replace(scene.ring, largest_gap_deg=190.0))
    tree = tree_of(replace(with_sigmas, metric=replace(with_sigmas.metric, scene=half)))
    assert tree["light"] == "red"
    assert "190 degrees" in tree["headline"]


def test_advice_names_what_is_wrong_and_nothing_else(with_sigmas: Evidence) -> None:
    said = " ".join(one["what"] for one in tree_of(with_sigmas)["findings"])
    assert "largest part of the expected error is image measurement: 0.080 mm" in said
    for absent in ("board", "EXIF", "filled", "pattern", "soft", "base is small"):
        assert absent not in said
    camera = replace(with_sigmas.cameras.calibrations[0], source="exif")
    guessed = replace(with_sigmas, cameras=replace(with_sigmas.cameras, calibrations=(camera,)))
    assert any("EXIF" in one["what"] for one in tree_of(guessed)["findings"])


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
        filled_share=0.0,
        brim_mm=0.0,
        part_given=given,
        others=(other,),
    )
    return replace(evidence, mesh=replace(evidence.mesh, repairs=repairs))


def test_the_other_side_of_a_wall_is_nothing_missing(with_sigmas: Evidence) -> None:
    assert tree_of(with_part(with_sigmas, "other side", 0.0, given=False))["light"] == "green"


def test_what_was_torn_off_is_red(with_sigmas: Evidence) -> None:
    tree = tree_of(with_part(with_sigmas, "torn off", 0.45, given=True))
    assert tree["light"] == "red"
    assert "45.0 % of what was measured" in tree["headline"]


def test_a_body_apart_leaves_a_doubt_until_the_user_chooses(with_sigmas: Evidence) -> None:
    tree = tree_of(with_part(with_sigmas, "apart", 0.0, given=False))
    assert tree["light"] == "amber"
    assert "part 2" in tree["headline"]
    assert "--part" in tree["headline"]
    assert tree_of(with_part(with_sigmas, "apart", 0.0, given=True))["light"] == "green"
