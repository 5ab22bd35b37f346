"""The commands `align` and `measure`: what they take, reply and leave on the disk."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from limbgram.cli.main import app
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb
from limbgram.formats.stl import write_stl
from limbgram.workbench.limb import Limb

FRONT = ["--anterior", "+y"]


def run(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture
def scan(stump: Limb, tmp_path: Path) -> Path:
    write_stl(stump.mesh, tmp_path / "scan.stl", "mm")
    return tmp_path / "scan.stl"


def test_align_keeps_the_frame_beside_the_shape_and_leaves_the_shape(
    scan: Path, stump: Limb
) -> None:
    before = scan.read_bytes()
    spots = [
        f"{mark.name}={','.join(str(value) for value in mark.position_mm)}"
        for mark in stump.landmarks
    ]
    options = [word for spot in spots for word in ("--landmark", spot)]
    answer = run("align", scan, "--side", "right", "--kind", "transtibial", *options, "--json")
    assert answer.exit_code == 0, answer.output
    told = json.loads(answer.stdout)
    np.testing.assert_allclose(told["limb_from_mesh"]["rotation"], np.eye(3), atol=1e-5)
    assert [mark["name"] for mark in told["landmarks"]] == [mark.name for mark in stump.landmarks]
    assert scan.read_bytes() == before
    limb = read_limb(scan)
    assert limb.frame.side == "right"
    assert len(limb.landmarks) == 4


def test_measure_prints_what_holds_in_95_of_100(stump: Limb, tmp_path: Path) -> None:
    shared = np.full((len(stump.mesh), 1), 0.1, np.float32)
    known = replace(stump.mesh, sigma_mm=shared[:, 0], shared_mm=shared, correlation_mm=1.0)
    scan = tmp_path / "scan.ply"
    write_ply(known, scan, "mm")
    words = ("measure", scan, "--unaligned", "--tape", "120=300")
    told = json.loads(run(*words, "--json").stdout)["tape"][0]["measured_mm"]
    lines = run(*words).stdout
    assert 0.5 < told["sigma"] < 0.8  # 2 pi 0.1
    assert f"{told['value']:.1f} ± {1.96 * told['sigma']:.1f} " in lines
    assert lines.count("± holds in 95 of 100") == 1


def test_the_side_is_never_guessed(scan: Path) -> None:
    answer = run("align", scan, *FRONT)
    assert answer.exit_code == 2
    assert "--side" in answer.stderr
    assert not scan.with_name("scan.limb.json").exists()


def test_a_refused_alignment_leaves_no_limb_file(scan: Path) -> None:
    far = run("align", scan, "--side", "left", *FRONT, "--landmark", "scar=500,0,0")
    assert far.exit_code == 4
    assert "from the surface" in far.stderr
    assert not scan.with_name("scan.limb.json").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--axis", "up"], "no direction for --axis"),
        (["--anterior", "0,0,0"], "no direction for --anterior"),
        (["--landmark", "scar"], "no landmark"),
        (["--landmark", "scar=1,2"], "no landmark"),
        (["--plumb", "scar"], "names no two landmarks"),
        (["--marks", "--colour", "0.9,0.1,0.8"], "whole numbers from 0 to 255"),
        (["--marks", "--colour", "230,20,256"], "whole numbers from 0 to 255"),
        (["--unit", "furlong"], "no unit"),
    ],
)
def test_what_is_mistyped_is_said(scan: Path, words: list[str], told: str) -> None:
    answer = run("align", scan, "--side", "right", *words)
    assert answer.exit_code == 2, answer.output
    assert told in " ".join(answer.stderr.split())


def test_the_names_of_a_kind_are_listed() -> None:
    answer = run("align", "--names", "--kind", "torso", "--json")
    assert [row["name"] for row in json.loads(answer.stdout)["torso"]][:1] == [
        "seventh cervical vertebra"
    ]


def test_every_landmark_is_listed_with_what_it_serves() -> None:
    rows = json.loads(run("align", "--names", "--kind", "transtibial", "--json").stdout)
    uses = {row["name"]: row["uses"] for row in rows["transtibial"]}
    assert uses["patellar tendon"] == ["axes", "sheet", "device"]
    assert uses["lateral femoral epicondyle"] == ["sheet", "device", "no pressure"]
    assert uses["hamstring tendon"] == ["no pressure", "build-up"]
    assert uses["calf"] == []
    lines = run("align", "--names", "--kind", "torso").stdout.splitlines()
    (line,) = (one for one in lines if "third lumbar vertebra" in one)
    assert line.endswith("axes, sheet, joint")


def test_a_painted_mark_becomes_a_landmark(stump: Limb, tmp_path: Path) -> None:
    middle = stump.landmarks[2].position_mm
    colours = np.full((len(stump.mesh), 3), 200, np.uint8)
    colours[np.linalg.norm(stump.mesh.vertices_mm - middle, axis=1) < 7] = (190, 20, 30)
    mesh = type(stump.mesh)(
        vertices_mm=stump.mesh.vertices_mm, faces=stump.mesh.faces, colours=colours
    )
    write_ply(mesh, tmp_path / "sock.ply", "mm")
    seen = json.loads(run("align", tmp_path / "sock.ply", "--marks", "--json").stdout)["marks"]
    assert len(seen) == 1
    words = ["--side", "right", "--kind", "transtibial", "--landmark", "fibula head=#1"]
    answer = run("align", tmp_path / "sock.ply", *words, "--json")
    assert answer.exit_code == 0, answer.output
    (mark,) = json.loads(answer.stdout)["landmarks"]
    np.testing.assert_allclose(mark["in_limb_mm"], middle, atol=1.0)
    none = run("align", tmp_path / "sock.ply", "--side", "right", "--landmark", "fibula head=#2")
    assert none.exit_code == 2
    assert "1 were seen" in none.stderr


def test_measure_writes_table_picture_and_a_fitted_shape(scan: Path, tmp_path: Path) -> None:
    assert run("align", scan, "--side", "right", *FRONT).exit_code == 0
    words = [
        "--every",
        20,
        "--volume",
        "end:100",
        "--tape",
        "100=300",
        "--fit",
        tmp_path / "fit.ply",
    ]
    files = ["--csv", tmp_path / "t.csv", "--picture", tmp_path / "p.png"]
    answer = run("measure", scan, *words, *files, "--json")
    assert answer.exit_code == 0, answer.output
    told = json.loads(answer.stdout)
    assert [row["height_mm"] for row in told["levels"]] == pytest.approx(list(range(20, 221, 20)))
    assert told["tape"][0]["conflict"] is True
    assert told["fit"]["changes"][0]["after_mm"] == pytest.approx(300)
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG"
    rows = list(csv.DictReader((tmp_path / "t.csv").read_text("utf-8").splitlines()))
    assert float(rows[4]["tape_mm"]) == pytest.approx(
        told["levels"][4]["tape_mm"]["value"], abs=1e-4
    )
    again = json.loads(run("measure", tmp_path / "fit.ply", "--height", 100, "--json").stdout)
    assert again["levels"][0]["tape_mm"]["value"] == pytest.approx(300, abs=1e-3)
    shown = run("measure", scan, "--every", 50)
    assert "No sock was taken off" in shown.stdout
    heights = re.findall(r"^ +(\d+\.\d) ", shown.stdout, re.MULTILINE)
    assert heights == ["50.0", "100.0", "150.0", "200.0"]


def test_a_fit_tells_heights_from_the_landmark_as_the_readings_do(
    scan: Path, tmp_path: Path
) -> None:
    knee = ("--landmark", "knee=0,48.263,200")
    assert run("align", scan, "--side", "right", *FRONT, *knee).exit_code == 0
    words = ("--from", "knee", "--tape", "-100=300", "--fit", tmp_path / "fit.ply")
    shown = run("measure", scan, *words).stdout
    assert "Tape at -100.0 mm" in shown
    assert "Fitted at -100.0 mm" in shown


def test_measure_refuses_what_it_cannot_do(scan: Path, tmp_path: Path) -> None:
    bare = run("measure", scan)
    assert bare.exit_code == 4
    assert "limbgram align" in bare.stderr
    assert run("measure", scan, "--unaligned", "--height", 100).exit_code == 0
    missed = run("measure", scan, "--unaligned", "--height", 999)
    assert missed.exit_code == 4
    assert "misses the limb" in missed.stderr
    alone = run("measure", scan, "--unaligned", "--fit", tmp_path / "fit.ply")
    assert alone.exit_code == 2
    for words in (["--volume", "80:20"], ["--volume", "80"], ["--tape", "80"], ["--tape", "a=b"]):
        assert run("measure", scan, "--unaligned", *words).exit_code == 2
    assert not (tmp_path / "fit.ply").exists()


def test_heights_without_an_answer_stand_in_the_table(scan: Path) -> None:
    answer = run("measure", scan, "--unaligned", "--height", 100, "--height", 999)
    assert answer.exit_code == 0
    assert "misses the limb" in answer.stdout
