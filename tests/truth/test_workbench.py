"""From scan to carver by the command line, on a synthetic limb whose shape is known."""

import base64
import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
import trimesh
from pypdfium2 import PdfDocument
from tests.unit.report.conftest import papers_of
from typer.testing import CliRunner, Result

from limbgram.cli.main import app
from limbgram.core.typed import Strictness, value_of
from limbgram.findings import Gravity
from limbgram.formats.reading import read_limb
from limbgram.formats.sidecar import hash_of
from limbgram.formats.stl import write_stl
from limbgram.report.drawings.drawing import Picture
from limbgram.report.record.advice import findings
from limbgram.report.record.content import Content
from limbgram.report.record.layout import record_report
from limbgram.report.record.sources import RecipeSource, ShapeSource, replayed_on
from limbgram.synthetic.props.limb import TRANSTIBIAL_PLACES, LimbKind, make_limb
from limbgram.workbench.measures.measuring import measure_limb
from limbgram.workbench.recipe.file import read_recipe
from limbgram.workbench.recipe.recipe import switched

SEED, STEP_MM = 4, 3.5
NAME = "Maria Huber"
OWN_LANDMARK = "where Maria is sore"
PLACES = {**TRANSTIBIAL_PLACES, OWN_LANDMARK: (40.0, 0.6)}
LOAD_MM, REDUCED = 5.0, 0.03
EDITS = (
    f'load at="patellar tendon" depth_mm={LOAD_MM} falloff_mm=16',
    'relieve at="popliteal crease" depth_mm=4 falloff_mm=40',
    f'relieve at="{OWN_LANDMARK}" depth_mm=2 falloff_mm=25',
    f"reduction heights_mm=[20,140] per_cent=[{100 * REDUCED:g},0] of=girth",
    "smoothing passes=3",
)


def run(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def reply_of(*words: object) -> dict[str, Any]:
    """What a command that succeeds replies."""
    answer = run(*words, "--json")
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout)


def volume_ml(path: Path) -> float:
    """Of a closed mesh file, by another program's reader and our own sum."""
    mesh = trimesh.load_mesh(path, process=False)
    a, b, c = (np.asarray(mesh.triangles, float)[:, k] for k in range(3))
    return float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6000


def content_of(tree: dict[str, Any]) -> Content:
    """What a reply of `report` says of the shape, without what it says of files."""
    return value_of(tree, Content, strictness=Strictness(pass_over_unknown=True))


def printed(tree: dict[str, Any], page: str) -> str:
    """What stands on the sheets of a record's PDF."""
    pictures = [
        Picture("", "", "", np.frombuffer(base64.b64decode(content), np.uint8))
        for content in re.findall(r'base64,([^"]*)"', page)
    ]
    papers = papers_of(record_report(content_of(tree), pictures))
    assert len(papers) == 2
    return " ".join(one.words for one in papers)


@dataclass(frozen=True)
class Bench:
    """The files of one way from scan to carver, and what is known of the limb."""

    folder: Path
    side: str
    anterior: np.ndarray
    """In the frame of the scan, which stands with its distal end up."""

    @property
    def scan(self) -> Path:
        return self.folder / f"{NAME}.stl"

    @property
    def recipe(self) -> Path:
        return self.folder / f"{NAME}.toml"

    @property
    def rectified(self) -> Path:
        return self.folder / f"{NAME} rectified.ply"


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """An aligned scan, a recipe for it, and what the recipe makes of it."""
    limb = make_limb(LimbKind.TRANSTIBIAL, SEED, STEP_MM, base_mm=0.0)
    made = Bench(
        folder=tmp_path_factory.mktemp(NAME),
        side=limb.side,
        anterior=np.array([np.cos(limb.anterior_rad), np.sin(limb.anterior_rad), 0.0]),
    )
    write_stl(limb.mesh, made.scan, "mm")
    marks: list[str] = []
    for name, (angle_deg, share) in PLACES.items():
        place = limb.place_mm(angle_deg, share)
        marks += ["--landmark", f"{name}={','.join(map(str, place))}"]
    wrong = {"left": "right", "right": "left"}[made.side]
    refused = run("align", made.scan, "--side", wrong, "--kind", "transtibial", *marks)
    assert refused.exit_code == 4, "the fibula tells the other side"
    reply_of("align", made.scan, "--side", made.side, "--kind", "transtibial", *marks)
    reply_of("edit", "new", made.recipe, "--for", made.scan)
    for edit in EDITS:
        kind, rest = edit.split(" ", 1)
        reply_of("edit", "add", made.recipe, kind, *re.findall(r'\w+=(?:"[^"]*"|\S+)', rest))
    return made


@pytest.fixture(scope="module")
def ledger(bench: Bench) -> list[dict[str, Any]]:
    applied = reply_of("edit", "apply", bench.scan, bench.recipe, "-o", bench.rectified)
    return applied["ledger"]["lines"]


@pytest.fixture(scope="module")
def made(bench: Bench, ledger: list[dict[str, Any]]) -> Path:
    """The rectified shape."""
    assert len(ledger) == len(EDITS)
    return bench.rectified


@pytest.fixture(scope="module")
def record(bench: Bench, made: Path) -> dict[str, Any]:
    words = ["--against", bench.scan, "--recipe", bench.recipe, "-o", bench.folder / "record"]
    return reply_of("report", made, *words)


def test_the_axes_are_those_of_the_limb_that_was_made(bench: Bench) -> None:
    frame = read_limb(bench.scan).frame
    assert frame.side == bench.side
    right, anterior, proximal = frame.limb_from_mesh.rotation
    assert proximal[2] < -np.cos(np.radians(5)), "the distal end stands up, the axis is bent"
    assert anterior @ bench.anterior > np.cos(np.radians(12)), "bones lie up to 6 degrees aside"
    np.testing.assert_allclose(np.cross(right, anterior), proximal, atol=1e-9)


def test_the_volume_is_that_of_the_triangles(bench: Bench) -> None:
    found = reply_of("measure", bench.scan, "--every", 50, "--volume", "end:end")
    assert found["volumes"][0]["volume_ml"]["value"] == pytest.approx(volume_ml(bench.scan))


def test_the_ledger_is_what_happened(bench: Bench, ledger: list[dict[str, Any]]) -> None:
    first, last = ledger[0]["before"]["volume_ml"], ledger[-1]["after"]["volume_ml"]
    assert first == pytest.approx(volume_ml(bench.scan))
    assert last == pytest.approx(volume_ml(bench.rectified), rel=1e-7)
    assert [line["after"] for line in ledger[:-1]] == [line["before"] for line in ledger[1:]]
    assert ledger[0]["displacement"]["largest_mm"] == pytest.approx(-LOAD_MM, abs=0.05)
    assert ledger[1]["displacement"]["largest_mm"] == pytest.approx(4.0, abs=0.05)
    smoothed = ledger[-1]["after"]["volume_ml"] / ledger[-1]["before"]["volume_ml"] - 1
    assert abs(smoothed) < 5e-4
    assert ledger[-1]["displacement"]["mean_size_mm"] > 1e-3, "it did smooth"


def test_the_comparison_finds_the_edits(bench: Bench, ledger: list[dict[str, Any]]) -> None:
    found = reply_of("compare", bench.scan, bench.rectified, "--align", "as-is", "--every", 20)
    change_ml = ledger[-1]["after"]["volume_ml"] - ledger[0]["before"]["volume_ml"]
    assert change_ml < -10
    whole = found["volume"]["ml"]
    assert whole["difference"] == pytest.approx(change_ml, abs=5e-4 * whole["first"])
    girths = {level["height_mm"]: level["tape_mm"]["share"] for level in found["levels"]}
    assert girths[20.0] == pytest.approx(-REDUCED, abs=4e-3)
    assert girths[80.0] == pytest.approx(-REDUCED / 2, abs=4e-3)
    assert abs(girths[240.0]) < 2e-3
    assert found["surface"]["on_first"]["largest_mm"] == pytest.approx(LOAD_MM, abs=0.3)


def test_the_aop_file_holds_the_shape(bench: Bench, made: Path) -> None:
    path = bench.folder / "positive.aop"
    assert run("export", made, "--to", "aop", "-o", path).exit_code == 2, "side unsure"
    wrong = {"left": "right", "right": "left"}[bench.side]
    words = ["export", made, "--to", "aop", "-o", path, "--side"]
    assert run(*words, wrong).exit_code == 4
    assert not path.exists()
    found = reply_of(*words, bench.side)
    assert abs(found["volume_change"]) < 0.005
    held = read_limb(path)
    assert held.frame.side == bench.side
    marks = {mark.name: mark.position_mm for mark in held.landmarks}
    outer = held.frame.limb_from_mesh.apply(marks["fibula head"][None])[0, 0]
    assert (outer > 30) == (bench.side == "right"), "+X is the patient's right"
    assert abs(outer) > 30
    size = [np.ptp(limb.mesh.vertices_mm, axis=0) for limb in (held, read_limb(bench.scan))]
    assert size[0][2] == pytest.approx(size[1][2], rel=0.05)


def test_carving_and_cad_files_are_proved(bench: Bench, made: Path) -> None:
    path = bench.folder / "positive.gcode"
    carve = ["--side", bench.side, "--scallop", 0.4, "--tool", 20, "--to-mm", 70]
    found = reply_of("export", made, "--to", "gcode", "-o", path, *carve)
    assert found["gouge_mm"] < 0.05
    assert found["scallop_mm"] < 0.5
    assert "G21" in path.read_text("ascii"), "millimetres"
    drawing = bench.folder / "positive.dxf"
    reply_of("export", made, "--to", "dxf", "-o", drawing)
    read = ezdxf.readfile(drawing)
    triangles = len(read_limb(made).mesh.faces)
    (surface,) = read.modelspace().query("MESH")
    assert len(surface.faces) == triangles


def test_the_record_says_side_and_unit_and_no_name(bench: Bench, record: dict[str, Any]) -> None:
    folder = bench.folder / "record"
    page = (folder / "report.html").read_text("utf-8")
    assert f"<b>{bench.side.upper()} · mm</b>" in page
    assert "millimetres" in page
    assert "A professional must verify dimensions before" in page
    assert "<script" not in page
    words = re.sub(r"base64,[^\"]*", "", page)
    assert not re.search(r"https?://|(src|href)=\"(?!data:)", words)
    assert "own landmark 1" in words
    kept = (folder / "report.pdf").read_bytes()
    assert len(PdfDocument(kept)) == 2
    sheets = printed(record, page)
    assert f"Record of {record['id']}" in sheets
    assert f"{bench.side.upper()} · mm" in sheets
    assert "A professional must verify dimensions" in sheets
    for text in (
        words,
        (folder / "report.json").read_text("utf-8"),
        sheets,
        kept.decode("latin-1"),
    ):
        for secret in ("Maria", "Huber", "sore", str(bench.folder), "pytest-"):
            assert secret not in text
    assert record["schema"] == "limbgram-report/2"
    hashes = {file["what"]: file["sha256"] for file in record["files"]}
    assert re.fullmatch(r"[0-9a-f]{64}", hashes["shape"])
    assert record["id"] == f"shape {hashes['shape'][:8]}"


def test_the_record_repeats_what_was_done(
    record: dict[str, Any], ledger: list[dict[str, Any]]
) -> None:
    again = record["recipe"]
    assert again["apart_mm"] < 1e-3
    assert [line["after"] for line in again["lines"]] == [line["after"] for line in ledger]
    change_ml = ledger[-1]["after"]["volume_ml"] - ledger[0]["before"]["volume_ml"]
    whole = record["comparison"]["volume"]["ml"]
    assert whole["difference"] == pytest.approx(change_ml, abs=5e-4 * whole["first"])
    assert record["comparison"]["alignment"]["way"] == "as-is"
    lines = {line["step"]: line for line in record["bias"]}
    smoothing = lines[f"smoothing (edit {len(EDITS)})"]
    assert smoothing["bias_mm"] == ledger[-1]["displacement"]["mean_mm"]
    assert lines["scale"]["bias_mm"] is None, "no case was named"
    assert not any(found["gravity"] == "serious" for found in record["findings"])


def test_a_recipe_that_did_not_make_the_shape_is_found_out(
    bench: Bench, record: dict[str, Any]
) -> None:
    recipe = switched(read_recipe(bench.recipe), 1, on=False)
    shapes = [
        ShapeSource(
            limb=read_limb(path),
            sha256=hash_of(path.read_bytes()),
            kind=path.suffix,
            limb_file_sha256=None,
        )
        for path in (bench.rectified, bench.scan)
    ]
    done = replayed_on(RecipeSource(recipe=recipe, sha256="0" * 64), *shapes)
    assert done.apart_mm == pytest.approx(LOAD_MM, rel=0.1)
    content = content_of(record)
    assert content.recipe is not None
    other = replace(content, recipe=replace(content.recipe, apart_mm=done.apart_mm))
    grave = [
        one for one in findings(other, measure_limb(shapes[0].limb)) if one.gravity is Gravity.FAULT
    ]
    assert [found.code for found in grave] == ["record.recipe.apart"]
    strange = run("report", bench.rectified, "--recipe", bench.recipe)
    assert strange.exit_code == 2
    assert "--against" in strange.stderr
