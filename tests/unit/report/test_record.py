"""The record of a shape: biases in closed form, names that are not printed, what to check."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh
from tests.unit.report.conftest import papers_of

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import HOLDS
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.typed import value_of
from limbgram.findings import Gravity, doubt, note, told
from limbgram.findings.tell import as_json
from limbgram.report.html import html_of
from limbgram.report.record.advice import tape_checks
from limbgram.report.record.bias import biases
from limbgram.report.record.content import TapeRead
from limbgram.report.record.layout import badge, change_rows, measure_rows, record_report
from limbgram.report.record.record import Record, RecordOptions, record_of
from limbgram.report.record.sources import CaseAccuracy, CaseSource, RecipeSource, ShapeSource
from limbgram.workbench.edits.from_template import FromTemplate
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.measuring import measure_limb
from limbgram.workbench.recipe.file import parse_recipe
from limbgram.workbench.recipe.recipe import Entry, Recipe
from limbgram.workbench.templates.chart_field import ANGLES, node_heights
from limbgram.workbench.templates.files import encode_template
from limbgram.workbench.templates.template import Template, TemplateMark

RADIUS_MM, HEIGHT_MM, ROUND = 50.0, 200.0, 360


def cylinder() -> Limb:
    """Closed, standing on its distal end, its corners on every spoke that AOP takes."""
    angles = 2 * np.pi * np.arange(ROUND) / ROUND
    ring = RADIUS_MM * np.column_stack([np.cos(angles), np.sin(angles)])
    vertices = np.concatenate(
        [
            np.column_stack([ring, np.zeros(ROUND)]),
            np.column_stack([ring, np.full(ROUND, HEIGHT_MM)]),
            [[0, 0, 0], [0, 0, HEIGHT_MM]],
        ]
    )
    k = np.arange(ROUND)
    after = (k + 1) % ROUND
    faces = np.concatenate(
        [
            np.column_stack([k, after, after + ROUND]),
            np.column_stack([k, after + ROUND, k + ROUND]),
            np.column_stack([after, k, np.full(ROUND, 2 * ROUND)]),
            np.column_stack([k + ROUND, after + ROUND, np.full(ROUND, 2 * ROUND + 1)]),
        ]
    ).astype(np.int32)
    return AlignedLimb(
        mesh=Mesh(vertices_mm=vertices, faces=faces),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        landmarks=(
            Landmark(name="tibial crest", position_mm=np.array([0, RADIUS_MM, 60.0])),
            Landmark(name="Anna's scar", position_mm=np.array([RADIUS_MM, 0, 80.0])),
        ),
        name="Anna.ply",
        notes=(note("said.as_is", message="Anna.ply has a seam"),),
    )


def source(limb: Limb, digit: str = "a") -> ShapeSource:
    return ShapeSource(limb=limb, sha256=64 * digit, kind="PLY", limb_file_sha256=None)


@cache
def usual() -> Record:
    """Of the cylinder alone."""
    return record_of(source(cylinder()))


@pytest.fixture
def drawn_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Records with the usual one's pictures: to draw others takes most of the time of a record."""
    pictures = usual().pictures
    monkeypatch.setattr("limbgram.report.record.record._pictures", lambda *_: pictures)


def case(**accuracy: Any) -> CaseSource:
    tree = {
        "light": "green",
        "headline": "GREEN. Surface: 95 % within 0.10 mm.",
        "lengths": {
            "check": [{"label": "A-B"}, {"label": "B-C"}],
            "check_worst": 0.001,
            "check_rms": 0.0004,
        },
        "expected": {"rms_mm": 0.05, "p95_mm": 0.1, "basis": "vertex sigmas"},
        **accuracy,
    }
    said = value_of(tree, CaseAccuracy)
    return CaseSource(sha256=64 * "c", accuracy=said, files=frozenset([64 * "a"]))


def lines(limb: Limb, of_case: CaseSource | None = None) -> dict[str, Any]:
    found = biases(measure_limb(limb), limb.aligned().mesh_in_limb, of_case, None)
    return {line.step: line for line in found}


def test_aop_costs_a_cylinder_what_a_polygon_of_its_spokes_costs() -> None:
    line = lines(cylinder())["leaving as AOP"]
    fine, coarse = (n * np.sin(2 * np.pi / n) / 2 for n in (ROUND, 120))
    assert line.volume_share == pytest.approx(coarse / fine - 1, rel=0.02)
    side_mm = ROUND * 2 * np.sin(np.pi / ROUND)
    assert line.bias_mm == pytest.approx((coarse - fine) * RADIUS_MM / side_mm, rel=0.03)
    sagitta = RADIUS_MM * (1 - np.cos(np.pi / 120))
    assert 0.5 * sagitta < line.largest_mm <= sagitta


@pytest.mark.usefixtures("drawn_before")
def test_plus_minus_on_the_record_is_what_holds_in_95_of_100() -> None:
    scanned = cylinder()
    shared = np.full((len(scanned.mesh), 1), 0.1, np.float32)  # the whole surface in or out
    known = replace(scanned.mesh, sigma_mm=shared[:, 0], shared_mm=shared, correlation_mm=1.0)
    bare = usual()
    content = record_of(source(replace(scanned, mesh=known))).content
    page = html_of(record_report(content, bare.pictures))
    told = content.measures["levels"][1]["tape_mm"]
    assert told["sigma"] == pytest.approx(2 * np.pi * 0.1, rel=0.02)
    assert f"{told['value']:.1f} ± {1.96 * told['sigma']:.2f}" in page
    assert f"± {told['sigma']:.2f}" not in page
    assert page.count(HOLDS) == 1
    assert HOLDS not in html_of(record_report(bare.content, bare.pictures))


def test_scale_and_sock_in_millimetres_of_radius() -> None:
    found = lines(replace(cylinder(), sock_mm=0.3), case())
    assert found["scale"].largest_mm == pytest.approx(0.001 * RADIUS_MM, rel=1e-3)
    assert found["scale"].typical_mm == pytest.approx(0.0004 * RADIUS_MM, rel=1e-3)
    assert found["surface"].typical_mm == 0.05
    assert found["surface"].bias_mm is None
    assert found["sock taken off"].bias_mm == -0.3
    assert "0.4 % of volume" in told(found["sock taken off"].basis)
    assert 0 < found["leaving as STL"].largest_mm < 1e-5


def test_a_scale_without_check_is_not_known() -> None:
    bare = {"check": [], "check_worst": None, "check_rms": None}
    found = lines(cylinder(), case(lengths=bare))
    assert found["scale"].largest_mm is None
    assert lines(cylinder())["scale"].largest_mm is None


def test_no_name_of_file_or_landmark_is_in_the_record() -> None:
    other = replace(cylinder(), name="Berta.ply", notes=())
    record = record_of(source(cylinder()), source(other, "b"), case=case())
    text = repr(record.tree) + "".join(picture.caption for picture in record.pictures)
    assert [picture.name for picture in record.pictures] == ["sides", "differences"]
    for name in ("Anna", "Berta", "scar"):
        assert name not in text
    assert [mark["name"] for mark in record.tree["landmarks"]] == ["tibial crest", "own landmark 1"]
    seam, holds = record.tree["notes"]
    assert seam == "shape aaaaaaaa has a seam"
    assert holds.startswith("watertight: ")
    assert record.tree["comparison"]["first"] == "shape bbbbbbbb"
    assert record.tree["comparison"]["volume"]["ml"]["difference"] == pytest.approx(0, abs=1e-6)
    assert badge(record.content) == "RIGHT · mm"


def test_heights_may_count_from_a_landmark_whose_name_is_not_printed() -> None:
    record = record_of(source(cylinder()), options=RecordOptions(reference="Anna's scar"))
    assert [picture.name for picture in record.pictures] == ["sides", "sections"]
    assert "own landmark 1" in record.pictures[1].caption
    assert not any("Anna" in picture.caption for picture in record.pictures)
    assert record.tree["measures"]["reference"] == "own landmark 1"
    heights = [row["from_reference_mm"] for row in record.tree["measures"]["levels"]]
    assert heights[0] == pytest.approx(-60.0)
    assert measure_rows(record.content)[0][0] == "-60.0"


@pytest.mark.usefixtures("drawn_before")
def test_a_loose_body_is_no_part_of_the_record_and_told() -> None:
    limb = cylinder()
    mesh = limb.mesh
    crumb = mesh.with_vertices(mesh.vertices_mm / 50 + np.array([200.0, 0, 50]))
    both = Mesh(
        vertices_mm=np.concatenate([mesh.vertices_mm, crumb.vertices_mm]),
        faces=np.concatenate([mesh.faces, crumb.faces + len(mesh)]).astype(np.int32),
    )
    alone, found = usual().tree, record_of(source(limb.with_mesh(both))).tree
    assert found["size_mm"] == alone["size_mm"]
    assert found["measures"]["levels"] == alone["measures"]["levels"]
    assert found["bias"] == alone["bias"]
    (added,) = set(found["notes"]) - set(alone["notes"])
    assert added.startswith("1 loose body apart from the limb")


@pytest.mark.usefixtures("drawn_before")
@pytest.mark.parametrize(("outcome", "gravity"), [("pass", "note"), ("fail", "fault")])
def test_the_test_of_the_kit_is_cited(outcome: str, gravity: str) -> None:
    setup = {
        "certificate": "abcdef01",
        "camera": "Cam",
        "artefact": "Ball bar 12",
        "outcome": outcome,
        "made": "2026-03-31",
        "months": 2,
        "valid_months": 12,
    }
    tree = record_of(source(cylinder()), case=case(setups=[setup])).tree
    assert tree["case"]["setups"][0]["outcome"] == outcome
    (found,) = (one for one in tree["findings"] if "Ball bar 12" in one["sentence"])
    assert found["gravity"] == gravity


@pytest.mark.usefixtures("drawn_before")
def test_what_is_not_sure_stands_first() -> None:
    mesh = cylinder().mesh
    filled = replace(mesh, filled=np.arange(len(mesh)) < 100)
    strange = replace(case(light="amber"), files=frozenset[str]())
    tree = record_of(source(replace(cylinder(), mesh=filled)), case=strange).tree
    gravity = [found["gravity"] for found in tree["findings"]]
    assert gravity == sorted(gravity, key=["fault", "doubt", "note"].index)
    assert gravity.count("fault") == 2, "filled in, and not of the case"
    topics = {found["code"].split(".")[1] for found in tree["findings"]}
    assert topics == {"case", "surface", "tape", "file"}


@pytest.mark.usefixtures("drawn_before")
@pytest.mark.parametrize("light", ["green", "amber", "red"])
def test_the_verdict_of_the_capture_and_its_case_stand_in_page_paper_and_tree(light: str) -> None:
    headline = f"{light.upper()}. Surface: 95 % within 0.10 mm."
    options = RecordOptions(case_id="K7Q-4F2")
    of_case = case(light=light, headline=headline)
    record = record_of(source(cylinder()), case=of_case, options=options)
    assert record.tree["case"]["light"] == light
    report = record_report(record.content, record.pictures)
    paper = " ".join(one.words for one in papers_of(report))
    for words_of in (" ".join(html_of(report).split()), paper):
        assert headline in words_of
        assert "case K7Q-4F2" in words_of
    doubts = [one for one in record.tree["findings"] if one["code"] == "record.case.light"]
    gravity = {"green": [], "amber": ["doubt"], "red": ["fault"]}
    assert [one["gravity"] for one in doubts] == gravity[light]


@pytest.mark.usefixtures("drawn_before")
def test_a_load_on_bone_stands_in_page_paper_and_tree() -> None:
    """Accepted or not: the record tells what was done, it refuses nothing."""
    edits = (
        Entry(edit=Load(at="tibial crest", depth_mm=4.0, falloff_mm=15.0)),
        Entry(
            edit=Load(at="Anna's scar", depth_mm=2.0, falloff_mm=10.0),
            accept=("load on marked place",),
        ),
        Entry(edit=Reduction(heights_mm=(0.0,), per_cent=(2.0,), of="girth")),
    )
    recipe = RecipeSource(recipe=Recipe(name="", entries=edits), sha256=64 * "d")
    record = record_of(source(cylinder()), recipe=recipe)
    tree = record.tree["recipe"]
    concerns = [one for line in tree["lines"] for one in line["concerns"]]
    assert [one["accepted"] for one in concerns] == [False, True, True]
    assert tree["places_mm"]["tibial crest"] == pytest.approx(-5.0, abs=0.1)
    told = [one for one in record.tree["findings"] if one["code"].startswith("record.recipe.")]
    assert [one["gravity"] for one in told] == ["fault", "fault", "doubt"]
    assert "presses 4.0 mm on the tibial crest" in told[0]["sentence"]
    assert "NOT accepted in the recipe: load on tibial crest" in told[0]["sentence"]
    assert "tibial crest 4.9 mm" in told[2]["sentence"]
    report = record_report(record.content, record.pictures)
    page = html_of(report)
    papers = papers_of(report)
    assert len(papers) == 2
    paper = " ".join(one.words for one in papers)
    for words_of in (" ".join(page.split()), paper):
        assert "presses 4.0 mm on the tibial crest: bone edge under the skin (NOT acc" in words_of
        assert "inward (pressure)" in words_of
        assert "Anna" not in words_of


@pytest.mark.usefixtures("drawn_before")
def test_what_was_said_of_the_scan_and_by_a_template_stands_in_the_record_without_names() -> None:
    """The scan has a bone inside; the template knows a mark that the limb lacks, with a name."""
    limb = cylinder()
    bone = trimesh.creation.icosphere(2, 8.0)
    bone.apply_translation(np.asarray(limb.mesh.vertices_mm).mean(0))
    faces = np.concatenate([limb.mesh.faces, len(limb.mesh) + bone.faces]).astype(np.int32)
    vertices = np.concatenate([limb.mesh.vertices_mm, np.asarray(bone.vertices)])
    scan = replace(limb, mesh=Mesh(vertices_mm=vertices, faces=faces), notes=())
    heights = node_heights(1.0)
    shape = (len(heights), ANGLES)
    template = Template(
        name="ours",
        pairs=1,
        sided=True,
        reference=limb.landmarks[-1].name,
        marks=(TemplateMark(name="Ben's graft", height=0.5, angle_deg=0.0),),
        heights=heights,
        displacement_mm=np.full(shape, 0.5),
        spread_mm=np.full(shape, np.nan),
        known_pairs=np.ones(shape, np.int64),
    )
    edit = FromTemplate(learned=encode_template(template).decode())
    recipe = RecipeSource(recipe=Recipe(name="", entries=(Entry(edit=edit),)), sha256=64 * "d")
    tree = record_of(source(scan), recipe=recipe).tree
    told = [sentence for line in tree["recipe"]["lines"] for sentence in line["told"]]
    assert any("lacks own landmark" in sentence["sentence"] for sentence in told)
    assert any("left out" in note for note in tree["recipe"]["notes"])
    assert "Anna" not in str(tree)
    assert "Ben" not in str(tree)


@pytest.mark.usefixtures("drawn_before")
def test_an_old_recipe_is_told_in_the_record() -> None:
    old = (
        'format = "limbgram recipe"\nversion = 1\n[[edit]]\ndo = "relief"\nat = "tibial crest"\n'
        "depth_mm = 3\nfalloff_mm = 15\n"
    )
    recipe = RecipeSource(recipe=parse_recipe(old, "old.toml"), sha256=64 * "d")
    record = record_of(source(cylinder()), recipe=recipe)
    assert record.tree["recipe"]["lines"][0]["edit"].startswith("load:")
    assert any("is of version 1" in one["sentence"] for one in record.tree["findings"])


def test_refusals() -> None:
    with pytest.raises(MeasureError, match="not aligned"):
        record_of(source(cylinder().unaligned()))
    recipe = RecipeSource(recipe=Recipe(name="", scan_sha256=64 * "f"), sha256=64 * "d")
    with pytest.raises(OptionsError, match="another scan"):
        record_of(source(cylinder()), recipe=recipe)


@pytest.mark.usefixtures("drawn_before")
def test_a_tape_has_its_interval_where_the_shape_has_none() -> None:
    read = TapeRead(
        made="", height_mm=60.0, read_mm=314.0, measured_mm=314.1, within_mm=2.9, conflict=False
    )
    record = record_of(source(cylinder()), options=RecordOptions(tape=(read,)))
    page = html_of(record_report(record.content, record.pictures))
    assert "+0.1 ± 2.9" in page
    assert "no figure has a ±" not in page
    assert "none of its own figures has a ±" in page


@pytest.mark.usefixtures("drawn_before")
def test_two_tables_of_heights_say_from_where_each_counts() -> None:
    options = RecordOptions(reference="tibial crest")
    record = record_of(source(cylinder()), source(cylinder(), "b"), options=options)
    measured = [float(row[0]) for row in measure_rows(record.content)]
    compared = [float(row[0]) for row in change_rows(record.content)]
    assert min(measured) < 0 <= min(compared)
    page = html_of(record_report(record.content, record.pictures))
    assert "Heights count from: tibial crest." in page
    assert "Heights count from the origin of the other one" in page


@pytest.mark.usefixtures("drawn_before")
def test_a_red_capture_is_the_first_to_be_said_of_a_shape() -> None:
    """A full sheet, and a terminal, leave out the last."""
    red = doubt("verdict.red_shape")
    limb = replace(cylinder(), doubt=red, notes=(red, *cylinder().notes))
    content = record_of(source(limb)).content
    first, *others = content.findings
    assert (first.code, first.gravity) == ("verdict.red_shape", Gravity.FAULT)
    assert not any("RED" in told(one) for one in others)
    assert any("has a seam" in told(one) for one in others)
    assert told(red) in content.notes


def wall(high: float = 0.9) -> Limb:
    """The cylinder round a hollow of a part of its height."""
    outer, inner = cylinder().mesh, cylinder().mesh
    hollow = inner.vertices_mm * [0.94, 0.94, high] + [0, 0, HEIGHT_MM * (1 - high) / 2]
    both = Mesh(
        vertices_mm=np.concatenate([outer.vertices_mm, hollow]),
        faces=np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer)]),
    )
    return replace(cylinder(), mesh=both, landmarks=(), notes=())


def test_a_wall_s_thickness_and_inside_are_in_the_record() -> None:
    record = record_of(source(wall()))
    thickness = record.tree["measures"]["wall"]
    assert thickness["thinnest_mm"] == pytest.approx(0.06 * RADIUS_MM, rel=0.01)
    assert record.tree["measures"]["skin"] == "outside"
    girths = [row["tape_mm"] for row in record.tree["inside"]["levels"] if row["tape_mm"]]
    expected = 2 * np.pi * 0.94 * RADIUS_MM
    assert all(girth["value"] == pytest.approx(expected, rel=1e-3) for girth in girths)
    assert [picture.name for picture in record.pictures] == ["sides", "sections", "wall"]
    page = html_of(record_report(record.content, record.pictures))
    assert "Measures of the inside by level" in page
    assert "Of the OUTSIDE of the wall" in page
    assert "mm thick where it is thinnest" in page


@pytest.mark.usefixtures("drawn_before")
def test_what_a_tape_checks_of_a_wall_is_its_inside_and_the_cards_say_what_they_tell() -> None:
    record = record_of(source(wall()))
    inside_mm = 2 * np.pi * 0.94 * RADIUS_MM
    assert all(
        girth == pytest.approx(inside_mm, abs=0.1) for _, girth in tape_checks(record.content)
    )
    volume, girth = record_report(record.content, record.pictures).cards[1:3]
    assert volume.note.startswith("of the material, from the distal end")
    assert girth.note.startswith("outside, at ")
    page = html_of(record_report(record.content, record.pictures))
    assert "Girths of the inside, mm, and what the tape reads" in page


@pytest.mark.usefixtures("drawn_before")
def test_radii_of_a_wall_are_those_of_its_inside() -> None:
    (sock,) = (one for one in record_of(source(wall())).content.bias if "sock" in one.step)
    radius_mm = 0.94 * RADIUS_MM
    assert sock.basis.values["volume_per_cent"] == pytest.approx(20 / radius_mm, rel=1e-3)


@pytest.mark.usefixtures("drawn_before")
def test_a_wall_round_a_short_hollow_has_a_record_without_its_inside() -> None:
    """One level of one is hollow, and of many levels too few are."""
    short = record_of(source(wall(0.2)), options=RecordOptions(spacing_mm=100.0))
    assert short.tree["measures"]["skin"] == "outside"
    assert short.tree["inside"] is None


@pytest.mark.usefixtures("drawn_before")
def test_the_sheet_of_a_wall_says_which_skin_it_tells() -> None:
    bare = usual().content
    row = {
        "words": {"en": "Girth"}, "formula": "", "value": 300.0, "sigma": None, "unit": "mm",
        "doubt": None,
    }  # fmt: skip
    for skin, said in (("only", 0), ("outside", 2)):
        measures = {**bare.measures, "skin": skin}
        content = replace(bare, measures=measures, sheet={"rows": [row]})
        page = html_of(record_report(content, usual().pictures))
        assert page.count("Of the OUTSIDE of the wall") == said


def test_the_sheet_names_landmarks_in_doubt_and_those_that_stand_in_for_others() -> None:
    doubts = (
        doubt("measure.sheet.stand_ins", lacking=("condyle", "head"), stand_ins=("tubercle",)),
        doubt("landmark.unconfirmed", names=("navicular",)),
        None,
    )
    plain = {"words": {"en": "Ankle"}, "formula": "", "value": 90.0, "sigma": None, "unit": "deg"}
    rows = [plain | {"doubt": None if one is None else as_json(one)} for one in doubts]
    content = replace(usual().content, sheet={"rows": rows})
    page = html_of(record_report(content, usual().pictures))
    assert page.count("<td>tubercle instead of condyle, head</td>") == 1
    assert page.count("<td>navicular (not confirmed)</td>") == 1


@pytest.mark.usefixtures("drawn_before")
def test_a_landmark_that_nobody_confirmed_is_named_in_table_advice_and_sheet() -> None:
    limb = cylinder()
    crest, scar = limb.landmarks
    open_marks = (
        replace(crest, confirmed=False, placed="proposed"),
        replace(scar, confirmed=False),
    )
    read = replace(
        limb,
        landmarks=open_marks,
        notes=(doubt("landmark.unconfirmed", names=(crest.name, scar.name)),),
    )
    record = record_of(source(read))
    said = [one for one in record.content.findings if one.code == "landmark.unconfirmed"]
    assert [one.values["names"] for one in said] == [("tibial crest", "own landmark 1")]
    assert [one.confirmed for one in record.content.landmarks] == [False, False]
    report = record_report(record.content, record.pictures)
    paper = " ".join(one.words for one in papers_of(report))
    for words_of in (" ".join(html_of(report).split()), paper):
        assert words_of.count("tibial crest (proposed, not confirmed)") == 1
        assert words_of.count("own landmark 1 (proposed, not confirmed)") == 1
        assert "Proposed, and confirmed by nobody: tibial crest" in words_of
        assert "Anna" not in words_of


def test_confirmed_landmarks_are_not_doubted() -> None:
    record = usual()
    assert all(one.confirmed for one in record.content.landmarks)
    page = html_of(record_report(record.content, record.pictures))
    assert "not confirmed" not in page
