"""Along the centreline: tubes, bent and straight, whose girths and lengths have closed forms."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.smoothed_length import taut_length
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.anatomy.landmark import Placing
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.along import AlongCentreline, measure_along
from limbgram.workbench.measures.levels import Figure
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetOptions, measuring_sheet

RADIUS_MM, SIDES = 30.0, 96
GIRTH_PER_MM = 2 * SIDES * np.sin(np.pi / SIDES)
AREA_PER_MM2 = SIDES / 2 * np.sin(2 * np.pi / SIDES)
LEG_MM, TURN_MM = 215.0, 85.0
"""Straight parts, and the arc between: 0.85 of the 100 mm from the ankle half way to the ball."""
ARC_MM = np.pi / 2 * TURN_MM
WHOLE_MM = 2 * LEG_MM + ARC_MM
PLACES = {
    "fibula head": (-RADIUS_MM, 0.0, 300.0),
    "medial tibial condyle": (RADIUS_MM, 0.0, 300.0),
    "medial malleolus": (RADIUS_MM, 20.0, 0.0),
    "lateral malleolus": (-RADIUS_MM, 20.0, 0.0),
    "heel": (0.0, -40.0, 0.0),
    "first metatarsal head": (RADIUS_MM, 200.0, 0.0),
    "fifth metatarsal head": (-RADIUS_MM, 200.0, 0.0),
    "second toe": (0.0, 300.0, 0.0),
}
"""Their middles lie at the knee, a right angle at the ankle, the ball and the toe."""
SURE = Placing(click_mm=0.0)


def foot(taper: float = 0.0, step_mm: float = 2.0, sides: int = SIDES) -> Limb:
    """A round tube about the centreline of its landmarks; it tapers towards the toe."""
    at = np.linspace(0, WHOLE_MM, round(WHOLE_MM / step_mm) + 1)
    turned = np.clip((at - LEG_MM) / TURN_MM, 0, np.pi / 2)
    before, behind = np.minimum(at, LEG_MM), np.maximum(at - LEG_MM - ARC_MM, 0)
    y = TURN_MM * (1 - np.cos(turned)) + behind
    z = 300.0 - before - TURN_MM * np.sin(turned)
    angles = 2 * np.pi * np.arange(sides) / sides
    inwards = np.column_stack([0 * at, np.cos(turned), np.sin(turned)])
    radii = (RADIUS_MM - taper * at)[:, None, None]
    ring = np.cos(angles)[None, :, None] * np.array([1.0, 0, 0])
    ring = ring + np.sin(angles)[None, :, None] * inwards[:, None]
    rings = np.column_stack([0 * y, y, z])[:, None] + radii * ring
    i, j = (k.ravel() for k in np.meshgrid(np.arange(len(at) - 1), np.arange(sides), indexing="ij"))
    here, beside = i * sides + j, i * sides + (j + 1) % sides
    first, last = len(at) * sides, len(at) * sides + 1
    k = np.arange(sides)
    after, end = (k + 1) % sides, (len(at) - 1) * sides
    faces = np.concatenate(
        [
            np.column_stack([here, beside + sides, beside]),
            np.column_stack([here, here + sides, beside + sides]),
            np.column_stack([k, after, np.full(sides, first)]),
            np.column_stack([end + after, end + k, np.full(sides, last)]),
        ]
    )
    vertices = np.concatenate([rings.reshape(-1, 3), [[0, 0, 300.0], [0, 300.0, 0]]])
    return AlignedLimb(
        mesh=Mesh(
            vertices_mm=vertices,
            faces=faces.astype(np.int32),
            sigma_mm=np.full(len(vertices), 0.1, np.float32),
        ),
        landmarks=tuple(
            Landmark(name=name, position_mm=np.array(place)) for name, place in PLACES.items()
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        kind="foot",
    )


@pytest.fixture(scope="module")
def sheet() -> MeasuringSheet:
    """A tube of few triangles, by rows with and without a figure."""
    only = ("ankle_deg", "hindfoot_deg", "foot_length_mm", "ball_width_mm", "ball_girth_mm")
    only = (*only, "navicular_height_mm", "navicular_height_per_cent", "fibula_head_height_mm")
    return measuring_sheet(foot(step_mm=10.0, sides=36), SheetOptions(only=only))


def test_girths_across_a_bent_tube_are_those_of_its_rings() -> None:
    found = measure_along(foot(), 50.0, placing=SURE)
    turns = 2 * np.pi * np.arange(SIDES) / SIDES
    girth_mm = taut_length(RADIUS_MM * np.column_stack([np.cos(turns), np.sin(turns)])).value_mm
    assert found.bends
    assert [one.along_mm for one in found.stations] == [50.0 * k for k in range(1, 12)]
    for one in found.stations:
        figures = one.figures
        assert figures["tape_mm"].value == pytest.approx(girth_mm, abs=0.02)
        assert figures["area_mm2"].value == pytest.approx(AREA_PER_MM2 * RADIUS_MM**2, rel=1e-4)
        assert figures["ml_mm"].value == pytest.approx(2 * RADIUS_MM, abs=0.01)
        assert figures["depth_mm"].value == pytest.approx(2 * RADIUS_MM, abs=0.01)
        assert 0 < figures["tape_mm"].sigma < 0.3  # type: ignore[operator]
    by_height = measure_limb(foot(), LimbMeasureOptions(heights_mm=(0.0,)))
    (level,) = by_height.rows
    assert level.figures["tape_mm"].value > 2 * 200  # type: ignore[union-attr]


def test_lengths_along_a_bent_tube() -> None:
    pairs = (("first metatarsal head", "fibula head"), ("fibula head", "second toe"))
    first, whole = measure_along(foot(), 500.0, pairs).lengths
    assert first.length_mm.value == pytest.approx(WHOLE_MM - 100.0, abs=0.02)
    assert whole.length_mm.value == pytest.approx(-WHOLE_MM, abs=0.02)


@pytest.mark.slow
def test_landmarks_that_tell_the_curve_make_their_part_of_the_sigmas() -> None:
    limb, pair = foot(taper=0.03, step_mm=5.0), ("first metatarsal head", "fibula head")
    surest = measure_along(limb, 250.0, (pair,), SURE)
    told = measure_along(limb, 250.0, (pair,), Placing(click_mm=2.0))
    rng = np.random.default_rng(5)
    girths, lengths = [], []
    for _ in range(40):
        moved = replace(limb, landmarks=tuple(_slid(one, rng) for one in limb.landmarks))
        seen = measure_along(moved, 250.0, (pair,), SURE)
        girths.append([_at(seen, along_mm).value for along_mm in (250.0, 500.0)])
        lengths.append(seen.lengths[0].length_mm.value)
    for along_mm, spread in zip((250.0, 500.0), np.std(girths, axis=0), strict=True):
        both = [_at(one, along_mm).sigma or 0.0 for one in (told, surest)]
        assert np.sqrt(both[0] ** 2 - both[1] ** 2) == pytest.approx(spread, rel=0.35)
    both = [one.lengths[0].length_mm.sigma or 0.0 for one in (told, surest)]
    assert np.sqrt(both[0] ** 2 - both[1] ** 2) == pytest.approx(np.std(lengths), rel=0.35)


def _at(found: AlongCentreline, along_mm: float) -> Figure:
    (station,) = [one for one in found.stations if one.along_mm == along_mm]
    return station.figures["tape_mm"]


def _slid(mark: Landmark, rng: np.random.Generator) -> Landmark:
    """A landmark at another place of the tube, 2 mm away in each direction along it."""
    step = rng.normal(0, 2.0, 3)
    step[{"heel": 1, "second toe": 1}.get(mark.name, 0)] = 0.0
    return replace(mark, position_mm=mark.position_mm + step)


def test_a_straight_axis_is_the_straight_centreline(make_turned: Callable[..., Mesh]) -> None:
    heights = np.linspace(0, 200, 101)
    mesh = make_turned(30 + 0.1 * heights, heights, SIDES, squeeze=0.8)
    sure = replace(mesh, sigma_mm=np.full(len(mesh), 0.1, np.float32))
    limb = replace(foot(), mesh=sure, landmarks=(), kind="arm")
    found = measure_along(limb, 39.0)
    assert not found.bends
    levels = measure_limb(limb, LimbMeasureOptions(spacing_mm=39.0)).rows
    assert [one.along_mm for one in found.stations] == [one.height_mm for one in levels]
    same = {"tape_mm": "tape_mm", "contour_mm": "contour_mm", "ml_mm": "ml_mm", "depth_mm": "ap_mm"}
    for station, level in zip(found.stations, levels, strict=True):
        for name, other in same.items():
            figure, known = station.figures[name], level.figures[other]
            assert known is not None
            assert figure.value == pytest.approx(known.value, abs=1e-9)
            assert figure.sigma == pytest.approx(known.sigma, rel=1e-6)


def test_what_tells_no_curve_is_refused() -> None:
    limb = foot()
    with pytest.raises(MeasureError) as missing:
        measure_along(replace(limb, landmarks=limb.landmarks[1:]))
    assert missing.value.finding.code == "anatomy.missing"
    with pytest.raises(MeasureError) as untold:
        measure_along(replace(limb, kind=None))
    assert untold.value.finding.code == "anatomy.no_kind"


def test_the_command_measures_across_the_centreline(tmp_path: Path) -> None:
    shape = str(write_limb(foot(step_mm=5.0), tmp_path / "foot.ply"))
    book, pair = tmp_path / "foot.xlsx", "first metatarsal head:fibula head"
    words = ["measure", shape, "--every", "200", "--along", "--length", pair, "--xlsx", str(book)]
    found = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)["along"]
    assert found["bends"]
    assert [one["along_mm"] for one in found["stations"]] == [200, 400]
    for one in found["stations"]:
        assert one["tape_mm"]["value"] == pytest.approx(GIRTH_PER_MM * RADIUS_MM, abs=0.1)
    assert found["lengths"][0]["length_mm"]["value"] == pytest.approx(WHOLE_MM - 100.0, abs=0.02)
    rows = openpyxl.load_workbook(book)["along the centreline"].iter_rows(values_only=True)
    assert len(list(rows)) == 3
    told = CliRunner().invoke(app, words).stdout
    assert "Across the centreline of this kind of limb" in told
    assert "mm along the centreline" in told


def test_the_tables_in_a_notebook_have_their_reach_and_in_pandas_their_sigma(
    sheet: MeasuringSheet,
) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    found = measure_along(foot(step_mm=10.0), 200.0, placing=SURE)
    (station, *_), frame = found.stations, found.to_frame()
    girth = station.figures["tape_mm"]
    assert girth.sigma is not None
    assert (frame.tape_mm[0], frame.sigma_tape_mm[0]) == (girth.value, girth.sigma)
    assert f"{girth.value:.1f} ± {1.96 * girth.sigma:.1f}" in found._repr_html_()
    rows = sheet.to_frame()
    assert list(rows.name) == [row.name for row in sheet.rows]
    row = next(one for one in sheet.rows if one.figure is not None and one.figure.sigma)
    assert row.figure is not None
    assert rows.value[list(rows.name).index(row.name)] == pytest.approx(row.figure.value, rel=1e-5)
    assert row.figure.with_interval in sheet._repr_html_()
    assert len(repr(sheet)) < 600


def test_a_crumb_below_a_straight_limb_does_not_shift_its_stations(cylinder: Mesh) -> None:
    corners = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]]) - [1, 1, 30]
    sides = len(cylinder) + np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    limb = AlignedLimb(
        mesh=Mesh(
            vertices_mm=np.concatenate([cylinder.vertices_mm, corners]),
            faces=np.concatenate([cylinder.faces, sides]).astype(np.int32),
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        kind="transtibial",
    )
    found = measure_along(limb, 50.0)
    assert [one.along_mm for one in found.stations] == [50.0, 100.0, 150.0]


def test_a_figure_made_of_others_is_given_without_them(sheet: MeasuringSheet) -> None:
    limb = foot(step_mm=10.0, sides=36)
    alone = measuring_sheet(limb, SheetOptions(only=("navicular_height_per_cent",)))
    (row,) = alone.rows
    assert row.name == "navicular_height_per_cent"
    assert row.reason is not None, "no navicular is marked"
    whole = {one.name: one for one in sheet.rows}
    assert row == whole[row.name]
    with pytest.raises(MeasureError):
        alone[row.name]
    with pytest.raises(KeyError, match="calf"):
        alone["calf"]


@pytest.mark.parametrize("spacing_mm", [0.0, -10.0, np.nan, np.inf])
def test_a_spacing_that_is_none_is_refused(spacing_mm: float) -> None:
    with pytest.raises(OptionsError) as refused:
        measure_along(foot(), spacing_mm)
    assert refused.value.finding.code == "measure.spacing.not_positive"
