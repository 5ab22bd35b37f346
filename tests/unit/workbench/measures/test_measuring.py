"""The whole table, tape, sock and lengths against bodies with closed forms."""

import csv
import io
import json
import math
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
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, told
from limbgram.formats.limb_file import write_limb
from limbgram.services.measure import MeasureFiles, MeasureRequest, measure
from limbgram.workbench.anatomy.landmark import Placing
from limbgram.workbench.compare.levels import changes_by_level
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.lengths import vertex_gradient
from limbgram.workbench.measures.levels import Sigmas
from limbgram.workbench.measures.measured_skin import without_sock
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.measures.table import COLUMNS, csv_text, tree
from limbgram.workbench.measures.tape import TapeReading, fit_to_tape

N = 96
CORNERS = 2 * N * math.sin(math.pi / N)
"""Length round the polygon of radius 1."""
SMOOTH = 2 * math.pi * (1 - (math.pi / N) ** 2 / 3)
"""Length of a contour or a tape round it: of the circle at the mean distance of its sides."""
UNIT = 0.5 * N * math.sin(2 * math.pi / N)
ORIGIN = "origin of the limb frame"
POSE = Rigid.from_rotation_vector(np.array([0.4, -1.0, 0.7]), np.array([200.0, -30, 55]))


def aligned(mesh_in_limb: Mesh, *marks: tuple[str, float, float, float]) -> Limb:
    """A limb whose mesh lies elsewhere than its frame."""
    back = POSE.inverse
    return AlignedLimb(
        mesh=mesh_in_limb.with_vertices(back.apply(mesh_in_limb.vertices_mm)),
        landmarks=tuple(
            Landmark(name=name, position_mm=back.apply(np.array([[x, y, z]]))[0])
            for name, x, y, z in marks
        ),
        frame=LimbFrame(limb_from_mesh=POSE, side="right"),
    )


def value(figures: object, name: str) -> float:
    return figures[name].value  # type: ignore[index]


def test_a_table_of_a_cylinder(cylinder: Mesh) -> None:
    table = measure_limb(aligned(cylinder), LimbMeasureOptions(spacing_mm=25))
    np.testing.assert_allclose([row.height_mm for row in table.rows], np.arange(25, 200, 25))
    for row in table.rows:
        assert row.reasons == ()
        assert value(row.figures, "tape_mm") == pytest.approx(50 * SMOOTH, rel=3e-5)
        assert value(row.figures, "ap_mm") == pytest.approx(100, rel=1e-9)
        below = UNIT * 2500 * row.height_mm
        assert value(row.figures, "volume_below_mm3") == pytest.approx(below, rel=1e-9)


def test_heights_count_from_a_landmark(cylinder: Mesh) -> None:
    limb = aligned(cylinder, ("knee", 50, 0, 160.0))
    table = measure_limb(
        limb, LimbMeasureOptions(spacing_mm=50, reference="knee", volumes_mm=((-60, -20),))
    )
    np.testing.assert_allclose([row.from_reference_mm for row in table.rows], [-150, -100, -50, 0])
    np.testing.assert_allclose([row.height_mm for row in table.rows], [10, 60, 110, 160])
    (volume,) = table.volumes
    assert volume.volume_mm3.value == pytest.approx(UNIT * 2500 * 40, rel=1e-9)


def test_other_limbs_at_a_height_are_named_and_not_taped(
    make_forked: Callable[..., Mesh], cylinder: Mesh
) -> None:
    """Two thighs of 50 and 45 mm, 300 mm apart, joined below: table, CSV, tree and tape."""
    limb = aligned(make_forked(300.0, (50.0, 45.0)), ("right", 300, 45, 120.0))
    options = LimbMeasureOptions(heights_mm=(-160.0, 100.0, 150.0))
    readings = (TapeReading(height_mm=100.0, girth_mm=50 * SMOOTH),)
    table = measure_limb(limb, replace(options, tape=readings))
    assert [len(row.others) for row in table.rows] == [0, 1, 1]
    assert table.others_note is not None
    other = f"{45 * SMOOTH:.1f}"
    assert told(table.others_note).startswith("At 2 of 3 heights lie several outlines.")
    assert told(table.others_note).endswith(f"mm round: at 100 {other}; at 150 {other}.")
    assert not table.tape[0].conflict
    kept = tree(table)
    assert Finding.from_tree(kept["beside"]) == table.others_note
    assert kept["levels"][0]["others"] == []
    assert kept["levels"][1]["others"][0]["contour_mm"] == pytest.approx(45 * SMOOTH, rel=3e-5)
    assert kept["smoothed_over_mm"] == 5
    rows = list(csv.DictReader(io.StringIO(csv_text(table))))
    assert [row["others_mm"][:5] for row in rows] == ["", other, other]
    assert {row["girths_smoothed_over_mm"] for row in rows} == {"5.0"}
    asked = measure_limb(limb, replace(options, through="right"))
    assert value(asked.rows[1].figures, "tape_mm") == pytest.approx(45 * SMOOTH, rel=3e-5)
    assert asked.others_note is not None
    assert asked.others_note.values["on_axis"] is False
    fitted = fit_to_tape(limb, (TapeReading(height_mm=100.0, girth_mm=320.0),))
    assert fitted.changes[0].before_mm == pytest.approx(50 * SMOOTH, rel=3e-5)
    assert measure_limb(aligned(cylinder)).others_note is None


def test_other_limbs_are_named_on_the_terminal_and_in_a_comparison(
    make_forked: Callable[..., Mesh], tmp_path: Path
) -> None:
    body = make_forked(300.0, (50.0, 45.0))
    shape = write_limb(aligned(body), tmp_path / "thighs.ply")
    shown = CliRunner().invoke(app, ["measure", str(shape), "--height", "100"])
    other = f"{45 * SMOOTH:.1f}"
    row = next(line for line in shown.output.splitlines() if line.startswith("   100.0"))
    assert row.split()[1:3] == [f"{50 * SMOOTH:.1f}"] * 2
    assert f"beside it: {other} mm" in row
    assert "girths smoothed over 5 mm" in shown.output
    assert "At 1 of 1 heights lie several outlines. Measured is the one" in shown.output
    (level,) = changes_by_level(body, body, (100.0,)).levels
    assert level.measures["tape_mm"].first.value == pytest.approx(50 * SMOOTH, rel=3e-5)
    assert level.others_mm == ((pytest.approx(45 * SMOOTH, rel=3e-5),),) * 2


def test_a_volume_s_sigma_counts_limbs_of_which_none_is_told(
    make_forked: Callable[..., Mesh],
) -> None:
    """Two alike arms rise beside the axis: no girth there, but a volume that hangs on the place."""
    body = make_forked(300.0, (50.0, 50.0))
    body = body.with_vertices(body.vertices_mm - [150.0, 0.0, 0.0])
    found = changes_by_level(body, body, (-160.0, 50.0, 100.0), slide_sigma_mm=0.5)
    assert [level.reason is None for level in found.levels] == [True, False, False]
    assert found.volume is not None
    assert found.laid_sigma_mm3 == pytest.approx(0.5 * 2 * UNIT * 2500, rel=1e-3)
    sure = replace(body, sigma_mm=np.full(len(body), 1e-6, np.float32))
    last = changes_by_level(sure, sure, (-160.0, 50.0, 100.0), slide_sigma_mm=0.5).levels[-1]
    assert last.since_last is not None
    assert last.since_last.sigma == pytest.approx(0.0, abs=5.0)  # both ends slide alike


def test_every_height_asked_for_has_a_row(cylinder: Mesh) -> None:
    heights = tuple(np.linspace(-30, 230, 120).tolist())
    table = measure_limb(aligned(cylinder), LimbMeasureOptions(heights_mm=heights))
    assert [row.from_reference_mm for row in table.rows] == list(heights)
    inside = [0 < height <= 200 for height in heights]
    assert [row.level is not None for row in table.rows] == inside
    reasons = [[one.code for one in row.reasons] for row in table.rows if row.level is None]
    assert reasons
    assert all(codes == ["measure.level.missed"] for codes in reasons)
    with pytest.raises(MeasureError, match="No height has an answer"):
        measure_limb(aligned(cylinder), LimbMeasureOptions(heights_mm=(-5.0, 300.0)))


def test_lengths_between_landmarks(cylinder: Mesh) -> None:
    limb = aligned(cylinder, ("a", 50, 0, 40.0), ("b", 0, 50, 130.0))
    (length,) = measure_limb(limb, LimbMeasureOptions(lengths=(("b", "a"),))).lengths
    assert length.along_axis.value == pytest.approx(-90, abs=1e-9)
    assert length.straight.value == pytest.approx(math.sqrt(2 * 50**2 + 90**2), rel=1e-9)
    assert length.over_surface.value == pytest.approx(math.hypot(50 * SMOOTH / 4, 90), rel=5e-5)
    with pytest.raises(MeasureError, match="no landmark 'c'"):
        measure_limb(limb, LimbMeasureOptions(lengths=(("a", "c"),)))


def test_the_sigma_of_a_length_holds_how_its_landmarks_were_placed(cylinder: Mesh) -> None:
    """2 mm of each in each direction along the surface; of the straight way, which leaves the wall
    at an angle, what lies along the wall counts."""
    sure = replace(cylinder, sigma_mm=np.full(len(cylinder), 0.1, np.float32))
    limb = aligned(sure, ("a", 50, 0, 40.0), ("b", 0, 50, 130.0))

    def sigmas(click_mm: float) -> np.ndarray:
        options = LimbMeasureOptions(lengths=(("a", "b"),), placing=Placing(click_mm=click_mm))
        (length,) = measure_limb(limb, options).lengths
        figures = (length.along_axis, length.over_surface, length.straight)
        return np.array([figure.sigma for figure in figures])

    inwards = 50 / math.hypot(50, 50, 90)
    along = np.array([1.0, 1.0, math.sqrt(1 - inwards**2)])
    placed = sigmas(2.0)
    np.testing.assert_allclose(
        np.sqrt(placed**2 - sigmas(0.0) ** 2), 2 * math.sqrt(2) * along, rtol=5e-3
    )
    np.testing.assert_array_equal(placed, _usual_sigmas(limb))


def _usual_sigmas(limb: Limb) -> np.ndarray:
    (length,) = measure_limb(limb, LimbMeasureOptions(lengths=(("a", "b"),))).lengths
    return np.array(
        [one.sigma for one in (length.along_axis, length.over_surface, length.straight)]
    )


def test_a_length_over_a_wall_grows_as_the_wall_does(cylinder: Mesh) -> None:
    """A quarter of the way round lengthens by a quarter of what the girth does."""
    from limbgram.workbench.measures.geodesic import shortest_path
    from limbgram.workbench.measures.lengths import _length_slopes

    path = shortest_path(cylinder, np.array([50.0, 0, 100]), np.array([0.0, 50, 100]))
    sigmas = Sigmas.of(cylinder)
    wall = (np.abs(cylinder.vertices_mm[:, 2] - 100) < 99).astype(float)
    told = float(vertex_gradient(sigmas, path, _length_slopes(path)) @ wall)
    assert told == pytest.approx(CORNERS / 4, rel=0.03)


def test_sigmas_come_with_the_mesh(cylinder: Mesh) -> None:
    sure = replace(cylinder, sigma_mm=np.full(len(cylinder), 0.1, np.float32))
    limb = aligned(sure, ("a", 50, 0, 40.0), ("b", 0, 50, 130.0))
    options = LimbMeasureOptions(
        volumes_mm=((50, 150),),
        lengths=(("a", "b"),),
        tape=(TapeReading(height_mm=60, girth_mm=314),),
    )
    table = measure_limb(limb, options)
    spreads = [
        *(figure.sigma for figure in table.rows[3].figures.values() if figure is not None),
        table.volumes[0].volume_mm3.sigma,
        table.lengths[0].over_surface.sigma,
        table.tape[0].measured.sigma,
    ]
    assert len(spreads) == 12
    assert all(spread is not None and spread > 0 for spread in spreads)
    assert "sigma_tape_mm" in csv_text(table)
    assert "sigma_tape_mm" not in csv_text(measure_limb(aligned(cylinder)))


def test_the_sock_comes_off_first(cylinder: Mesh) -> None:
    limb = aligned(cylinder, ("a", 50, 0, 100.0))
    table = measure_limb(limb, LimbMeasureOptions(sock_mm=2.0, heights_mm=(100.0,)))
    apothem = 50 * math.cos(math.pi / N) - 2
    girth = SMOOTH * apothem / math.cos(math.pi / N)
    assert value(table.rows[0].figures, "tape_mm") == pytest.approx(girth, rel=3e-5)
    assert table.limb.sock_mm == 2.0
    (mark,) = table.limb.landmarks
    assert np.linalg.norm(POSE.apply(mark.position_mm[None])[0][:2]) == pytest.approx(48, abs=0.01)
    again = without_sock(table.limb, 2.0)
    assert again is table.limb
    assert measure_limb(table.limb, LimbMeasureOptions(heights_mm=(100.0,))).rows[0].figures == (
        table.rows[0].figures
    )
    with pytest.raises(OptionsError, match="taken off this surface already"):
        without_sock(table.limb, 1.0)
    for sock in (-1.0, 40.0, math.nan):
        with pytest.raises(OptionsError, match="cannot be"):
            without_sock(limb, sock)


@pytest.mark.parametrize(
    ("off_mm", "sigma_mm", "conflict"),
    [
        (1.2, 1.5, False),
        (2.9, 1.5, False),
        (-2.9, 1.5, False),
        (3.1, 1.5, True),
        (-3.1, 1.5, True),
        (2.9, 1.0, True),
        (3.9, 2.0, False),
    ],
)
def test_a_reading_conflicts_beyond_two_of_its_sigmas(
    cylinder: Mesh, off_mm: float, sigma_mm: float, conflict: bool
) -> None:
    reading = TapeReading(height_mm=70, girth_mm=50 * SMOOTH + off_mm, sigma_mm=sigma_mm)
    (check,) = measure_limb(aligned(cylinder), LimbMeasureOptions(tape=(reading,))).tape
    assert check.conflict is conflict
    assert check.difference_mm == pytest.approx(-off_mm, abs=0.01)
    assert check.sigma_mm == pytest.approx(sigma_mm, abs=1e-9)


def test_the_sigma_of_a_difference_is_of_the_tape_its_height_and_the_shape(
    make_turned: Callable[..., Mesh],
) -> None:
    """A cone whose radius falls by a tenth of a millimetre for each millimetre upwards."""
    z = np.linspace(0, 200, 101)
    cone = make_turned(60 - 0.1 * z, z, N)
    sure = replace(
        cone,
        sigma_mm=np.full(len(cone.vertices_mm), 0.3, np.float32),
        shared_mm=np.full((len(cone.vertices_mm), 1), 0.3, np.float32),
    )
    reading = TapeReading(height_mm=101, girth_mm=300, sigma_mm=1.0)
    (check,) = measure_limb(aligned(sure), LimbMeasureOptions(tape=(reading,))).tape
    taper_mm = 0.1 * 3 * CORNERS
    across = 0.3 * np.sqrt(1.01) * CORNERS  # the cone's walls lean: a section grows by more
    assert check.sigma_mm == pytest.approx(np.sqrt(1.0 + taper_mm**2 + across**2), rel=1e-3)


def test_readings_that_cannot_be_are_refused(cylinder: Mesh) -> None:
    limb = aligned(cylinder)
    with pytest.raises(OptionsError, match=r"345, not 34\.5"):
        measure_limb(limb, LimbMeasureOptions(tape=(TapeReading(height_mm=70, girth_mm=3.14),)))
    with pytest.raises(MeasureError, match="tape reading has no girth"):
        measure_limb(limb, LimbMeasureOptions(tape=(TapeReading(height_mm=400, girth_mm=314),)))
    twice = [TapeReading(height_mm=70, girth_mm=314), TapeReading(height_mm=70, girth_mm=310)]
    with pytest.raises(OptionsError, match="height of its own"):
        fit_to_tape(limb, twice)


def test_fitting_to_the_tape_gives_the_girths_that_were_read(cylinder: Mesh) -> None:
    away = cylinder.with_vertices(cylinder.vertices_mm + np.array([7.0, -4, 0]))
    limb = aligned(away, ("a", 57, -4, 100.0))
    readings = [TapeReading(height_mm=61, girth_mm=300), TapeReading(height_mm=-29, girth_mm=330)]
    fit = fit_to_tape(limb, readings, reference_mm=70)
    table = measure_limb(fit.limb, LimbMeasureOptions(heights_mm=(10, 41, 131, 190)))
    girths = [value(row.figures, "tape_mm") for row in table.rows]
    np.testing.assert_allclose(girths[1:3], [330, 300], rtol=1e-8)
    np.testing.assert_allclose(girths[0], 330, rtol=1e-3)  # constant beyond the last reading
    np.testing.assert_allclose(girths[3], 300, rtol=1e-3)
    assert [change.height_mm for change in fit.changes] == [41, 131]
    np.testing.assert_allclose([change.before_mm for change in fit.changes], 50 * SMOOTH, rtol=3e-5)
    assert fit.changes[0].factor == pytest.approx(330 / (50 * SMOOTH), rel=1e-3)
    assert fit.largest_mm == pytest.approx(50 * (330 / (50 * SMOOTH) - 1), rel=0.03)
    # Its middle stays, and a landmark rides along.
    vertices = POSE.apply(fit.limb.mesh.vertices_mm)
    np.testing.assert_allclose(vertices[:, :2].mean(0), [7, -4], atol=1e-6)
    np.testing.assert_allclose(vertices[:, 2], cylinder.vertices_mm[:, 2], atol=1e-9)
    (mark,) = fit.limb.landmarks
    place = POSE.apply(mark.position_mm[None])[0]
    share = (100 - 41) / 90
    factor = (1 - share) * fit.changes[0].factor + share * fit.changes[1].factor
    np.testing.assert_allclose(place, [7 + 50 * factor, -4, 100], atol=0.02)


def test_bones_inside_the_skin_are_not_measured(
    make_turned: Callable[..., Mesh], cylinder: Mesh
) -> None:
    bone = make_turned(np.full(9, 12.0), np.linspace(20, 180, 9), N)
    both = Mesh(
        vertices_mm=np.concatenate([cylinder.vertices_mm, bone.vertices_mm]),
        faces=np.concatenate([cylinder.faces, bone.faces + len(cylinder)]).astype(np.int32),
    )
    table = measure_limb(aligned(both), LimbMeasureOptions(heights_mm=(100.0,)))
    assert table.bodies_left_out == 1
    assert value(table.rows[0].figures, "area_mm2") == pytest.approx(UNIT * 2500, rel=1e-9)
    hollow = replace(
        both,
        faces=np.concatenate([cylinder.faces, bone.faces[:, ::-1] + len(cylinder)]).astype(
            np.int32
        ),
    )
    table = measure_limb(aligned(hollow), LimbMeasureOptions(heights_mm=(100.0,)))
    assert table.bodies_left_out == 0
    assert value(table.rows[0].figures, "area_mm2") == pytest.approx(UNIT * (2500 - 144), rel=1e-9)


def test_it_is_told_from_what_heights_count(cylinder: Mesh) -> None:
    """A tip that an edit moved by 5 mm is no origin any more; 0.3 mm of sock change no words."""
    at_40 = LimbMeasureOptions(heights_mm=(40.0,))
    for up_mm, counted in ((0.3, "distal end"), (-0.3, "distal end"), (5.0, ORIGIN), (-2, ORIGIN)):
        raised = cylinder.with_vertices(cylinder.vertices_mm + np.array([0, 0, up_mm]))
        table = measure_limb(aligned(raised), at_40)
        assert table.reference_name == counted
        assert table.tip_mm == pytest.approx(up_mm)
        assert tree(table)["reference"] == counted
        assert tree(table)["tip_height_mm"] == pytest.approx(up_mm)
        assert next(csv.DictReader(io.StringIO(csv_text(table))))["reference"] == counted
        assert ("the tip lies at" in table.reference_phrase) == (counted == ORIGIN)
    assert table.reference_phrase == f"the {ORIGIN}; the tip lies at -2.0 mm"
    limb = aligned(raised, ("knee", 50, 0, 160.0))
    assert (
        measure_limb(
            limb, LimbMeasureOptions(heights_mm=(-100,), reference="knee")
        ).reference_phrase
        == "knee"
    )


def test_a_volume_from_just_below_the_tip_begins_at_the_tip(cylinder: Mesh) -> None:
    """0.31 mm of the limb's end gone with the sock, as in a thin nylon's."""
    raised = cylinder.with_vertices(cylinder.vertices_mm + np.array([0, 0, 0.31]))
    spans = ((0.0, 100.0), (100.0, 0.0), (100.0, 200.9), (50.0, 100.0))
    table = measure_limb(aligned(raised), LimbMeasureOptions(heights_mm=(40.0,), volumes_mm=spans))
    high = [row.volume_mm3.value / (UNIT * 2500) for row in table.volumes]
    assert high == pytest.approx([99.69, -99.69, 100.31, 50.0], rel=1e-9)
    notes = [[dict(one.values) for one in row.notes] for row in table.volumes]
    assert notes[0] == [{"end_mm": pytest.approx(0.31), "asked_mm": 0.0}]
    assert notes[2] == [{"end_mm": pytest.approx(200.31), "asked_mm": 200.9}]
    assert notes[3] == []
    for low, most in ((-0.8, 100.0), (50.0, 201.5)):
        with pytest.raises(MeasureError) as refused:
            measure_limb(
                aligned(raised), LimbMeasureOptions(heights_mm=(40.0,), volumes_mm=((low, most),))
            )
        assert refused.value.finding.code == "measure.volume.beyond"
    in_sock = replace(aligned(raised), sock_mm=2.0)
    table = measure_limb(
        in_sock, LimbMeasureOptions(heights_mm=(40.0,), volumes_mm=((-2.5, 100.0),))
    )
    assert table.volumes[0].volume_mm3.value == pytest.approx(UNIT * 2500 * 99.69, rel=1e-9)


def test_what_cannot_be_asked_is_refused(cylinder: Mesh) -> None:
    with pytest.raises(MeasureError, match="limbgram align"):
        measure_limb(Limb(mesh=cylinder))
    for spacing in (0.0, -3.0, math.nan, 1e-4, 900.0):
        with pytest.raises(OptionsError, match="spacing"):
            measure_limb(aligned(cylinder), LimbMeasureOptions(spacing_mm=spacing))
    with pytest.raises(OptionsError, match="numbers"):
        measure_limb(aligned(cylinder), LimbMeasureOptions(heights_mm=(math.nan,)))


def test_the_table_reads_back_from_csv_and_json(cylinder: Mesh) -> None:
    limb = aligned(cylinder, ("knee, inner", 50, 0, 160.0))
    options = LimbMeasureOptions(
        heights_mm=(-100, -50, 90), reference="knee, inner", volumes_mm=((-math.inf, 0),)
    )
    table = measure_limb(limb, options)
    rows = list(csv.DictReader(io.StringIO(csv_text(table))))
    assert len(rows) == 3
    assert rows[0]["reference"] == "knee, inner"
    assert float(rows[0]["height_mm"]) == pytest.approx(60)
    assert float(rows[0]["tape_mm"]) == pytest.approx(50 * SMOOTH, rel=3e-5)
    assert float(rows[0]["volume_below_ml"]) == pytest.approx(UNIT * 2.5 * 60, abs=1e-3)
    assert all(rows[2][name] == "" for name in COLUMNS)
    assert "misses" in rows[2]["reason"]
    read = json.loads(json.dumps(tree(table), allow_nan=False))
    assert read["levels"][0]["area_mm2"]["value"] == pytest.approx(UNIT * 2500)
    assert read["levels"][2]["area_mm2"] is None
    assert [one["code"] for one in read["levels"][2]["reasons"]] == ["measure.level.missed"]
    assert read["volumes"][0]["from_mm"] is None
    assert read["volumes"][0]["volume_ml"]["value"] == pytest.approx(UNIT * 2.5 * 160)


def test_the_measuring_sheet_is_a_sheet_of_the_workbook(cylinder: Mesh, tmp_path: Path) -> None:
    limb = aligned(cylinder, ("distal end", 0.0, 0, 0), ("patellar tendon", 0.0, 50, 160))
    limb = replace(limb, kind="transtibial")
    path = tmp_path / "limb.xlsx"
    measure(limb, MeasureRequest(sheet=True), MeasureFiles(xlsx=path))
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["levels", "measuring sheet", "about"]
    rows = {row[0]: row for row in book["measuring sheet"].iter_rows(values_only=True)}
    assert rows["patellar_tendon_to_end_mm"][2:4] == (160.0, "mm")
    assert rows["fibula_length_mm"][2] is None
    assert "fibula head" in rows["fibula_length_mm"][7]
    measure(limb, MeasureRequest(), MeasureFiles(xlsx=path))
    assert openpyxl.load_workbook(path).sheetnames == ["levels", "about"]


def test_a_volume_may_end_a_millimetre_beyond_the_limb(cylinder: Mesh) -> None:
    limb = aligned(cylinder)
    last, beyond = (
        LimbMeasureOptions(spacing_mm=100, volumes_mm=((50.0, 200.0 + mm),)) for mm in (0.99, 1.01)
    )
    (row,) = measure_limb(limb, last).volumes
    assert [one.code for one in row.notes] == ["measure.volume.clamped"]
    with pytest.raises(MeasureError, match=r"no volume up to 201\.01 mm"):
        measure_limb(limb, beyond)


@pytest.mark.parametrize(("off_mm", "counted"), [(0.5, "distal end"), (0.51, ORIGIN)])
def test_a_tip_within_half_a_millimetre_of_the_origin_is_where_heights_begin(
    cylinder: Mesh, off_mm: float, counted: str
) -> None:
    lifted = cylinder.with_vertices(cylinder.vertices_mm + np.array([0.0, 0.0, off_mm]))
    table = measure_limb(aligned(lifted), LimbMeasureOptions(spacing_mm=100))
    assert replace(table, tip_mm=off_mm).reference_name == counted


def test_more_than_five_thousand_levels_are_refused(cylinder: Mesh) -> None:
    with pytest.raises(OptionsError) as refused:
        measure_limb(aligned(cylinder), LimbMeasureOptions(spacing_mm=200 / 5002))
    assert refused.value.finding.code == "measure.spacing.levels"
    assert refused.value.finding.values["levels"] == 5001


def test_refusals_name_heights_as_they_were_asked_for(cylinder: Mesh) -> None:
    """From a knee at 160 mm of 200: the limb reaches from -160 to 40."""
    holed = replace(cylinder, faces=np.delete(cylinder.faces, 100, axis=0))
    knee = ("knee", 50, 0, 160.0)
    asked = LimbMeasureOptions(heights_mm=(-100.0, 90.0), reference="knee")
    missed = measure_limb(aligned(cylinder, knee), asked).rows[1].reasons[0]
    assert missed.values == {
        "height_mm": pytest.approx(90),
        "low_mm": pytest.approx(-160),
        "high_mm": pytest.approx(40),
    }
    (opened,) = measure_limb(aligned(holed, knee), asked).rows[0].reasons
    assert opened.code == "measure.volume.open"
    assert opened.values["high_mm"] == pytest.approx(-100)
    assert opened.values["low_mm"] is None
    for more, code in (
        ({"volumes_mm": ((-50.0, 90.0),)}, "measure.volume.beyond"),
        ({"tape": (TapeReading(height_mm=90, girth_mm=314),)}, "tape.no_girth"),
    ):
        with pytest.raises(MeasureError) as refused:
            measure_limb(aligned(cylinder, knee), replace(asked, **more))
        said = refused.value.finding
        assert said.code == code
        inner = said.values.get("reason", said)
        assert isinstance(inner, Finding)
        assert inner.values["height_mm"] == pytest.approx(90)
        assert inner.values["high_mm"] == pytest.approx(40)


def test_a_landmark_is_no_way_from_itself(cylinder: Mesh) -> None:
    sure = replace(cylinder, sigma_mm=np.full(len(cylinder), 0.1, np.float32))
    limb = aligned(sure, ("a", 50, 0, 40.0))
    (length,) = measure_limb(limb, LimbMeasureOptions(lengths=(("a", "a"),))).lengths
    assert length.along_axis.value == 0.0
    for figure in (length.straight, length.over_surface):
        assert (figure.value, figure.sigma) == (0.0, 0.0)


def test_a_surface_that_no_photo_measured_is_not_known_exactly(cylinder: Mesh) -> None:
    unknown = replace(cylinder, sigma_mm=np.full(len(cylinder), np.nan, np.float32))
    options = LimbMeasureOptions(heights_mm=(60.0,), volumes_mm=((50, 150),), lengths=(("a", "b"),))
    limb = aligned(unknown, ("a", 50, 0, 40.0), ("b", 0, 50, 130.0))
    table = measure_limb(limb, options)
    figures = [*table.rows[0].figures.values(), table.volumes[0].volume_mm3]
    figures += [table.lengths[0].straight, table.lengths[0].over_surface]
    assert [one.sigma for one in figures if one is not None] == [None] * len(figures)


@pytest.mark.parametrize("brim_mm", [3.5, 2.0, 0.5])
def test_a_tape_beside_the_brim_keeps_the_sigma_of_its_height(
    make_turned: Callable[..., Mesh], brim_mm: float
) -> None:
    """A wall that is upright below the tape, and flares by 45 degrees up to a brim over it."""
    z = np.concatenate([np.linspace(0, 100, 51), 100 + np.linspace(0, brim_mm, 5)[1:]])
    flared = make_turned(50 + np.maximum(z - 100, 0), z, N, capped=False)
    reading = TapeReading(height_mm=99.999, girth_mm=50 * SMOOTH, sigma_mm=1.0)
    (check,) = measure_limb(aligned(flared), LimbMeasureOptions(tape=(reading,))).tape
    assert check.sigma_mm == pytest.approx(np.hypot(1.0, 3 * CORNERS), rel=0.01)
