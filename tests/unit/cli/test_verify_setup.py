"""verify-setup: the exit code, the JSON and the files say the same."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from limbgram.capture.acceptance import MeasuredCapture, accept
from limbgram.capture.artefact import read_artefact
from limbgram.capture.certificate import ArtefactTested, CaptureTested, Certificate
from limbgram.capture.permissible_errors import parse_limits
from limbgram.capture.probing import surface_of
from limbgram.cases import kit_verification
from limbgram.cli.main import app
from limbgram.report.acceptance import acceptance_report
from limbgram.report.blocks import Illustration
from limbgram.report.drawings.drawing import Chart
from limbgram.report.html import html_of
from limbgram.synthetic.props.gauges import BallBar, make_gauge

BAR = """
format = "limbgram artefact"
version = 1
name = "Ball bar 12"
spheres = [
    {name = "A", diameter_mm = 50.0, uncertainty_mm = 0.01},
    {name = "B", diameter_mm = 50.0, uncertainty_mm = 0.01},
]
lengths = [{first = "A", second = "B", length_mm = 150.0, uncertainty_mm = 0.01}]
"""


GERMAN = {"PASS": "BESTANDEN: ", "FAIL": "NICHT BESTANDEN: ", "CANNOT TELL": "UNENTSCHIEDEN: "}


def kit(scale: float) -> MeasuredCapture:
    mesh = make_gauge(BallBar(), 1.5, 60.0).mesh
    mesh = mesh.with_vertices(scale * mesh.vertices_mm + np.array([5.0, 0.0, 0.0]))
    return MeasuredCapture(
        name="capture 1",
        id="abcdef01",
        photos=15,
        light="green",
        scale="the scale board",
        meshes=(mesh,),
        surface=surface_of([mesh]),
    )


def certified(folder: Path, mpe: str, scale: float) -> Certificate:
    artefact = read_artefact(folder / "bar.toml")
    return Certificate(
        program="limbgram",
        made="2026-03-31",
        cameras=(),
        artefact=ArtefactTested(
            name=artefact.name, certificate="", calibrated="", sha256=artefact.sha256
        ),
        captures=(CaptureTested(name="capture 1", id="ab", photos=15, light="green", scale=""),),
        acceptance=accept(artefact, [kit(scale)], parse_limits([mpe])),
    )


@pytest.mark.parametrize(
    ("mpe", "scale", "code", "word"),
    [
        ("0.1", 1.0, 0, "PASS"),
        ("0.1", 1.002, 7, "FAIL"),
        ("spacing=0.3", 1.002, 8, "CANNOT TELL"),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_every_answer_has_its_code(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    mpe: str,
    scale: float,
    code: int,
    word: str,
    as_json: bool,
) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    case = tmp_path / "case"
    case.mkdir()
    (case / "case.json").write_text("{}")
    made = certified(tmp_path, mpe, scale)

    def verify_kit(*_: object, **__: object) -> Certificate:
        return made

    monkeypatch.setattr(kit_verification, "verify_kit", verify_kit)
    out = tmp_path / "proof.json"
    words = [str(tmp_path / "bar.toml"), str(case), "--mpe", mpe, "-o", str(out)]
    answer = CliRunner().invoke(app, ["verify-setup", *words, *(["--json"] if as_json else [])])
    assert answer.exit_code == code
    if as_json:
        reply: Any = json.loads(answer.stdout)
        assert reply["acceptance"]["outcome"] == word.lower()
    else:
        assert answer.stdout.startswith(f"{word}: ")
        german = CliRunner().invoke(app, ["verify-setup", *words], env={"LIMBGRAM_LANGUAGE": "de"})
        assert german.stdout.startswith(GERMAN[word])
    assert f"<b>{word}</b>" in out.with_suffix(".html").read_text()
    assert out.with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    assert json.loads(out.read_text())["acceptance"]["outcome"] == word.lower()


def test_a_certificate_needs_a_place(tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    words = ["verify-setup", str(tmp_path / "bar.toml"), str(tmp_path), "--mpe", "0.1"]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 2
    assert "--camera" in answer.output


def test_the_page_says_what_was_not_measured(tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    artefact = read_artefact(tmp_path / "bar.toml")
    third = replace(artefact.spheres[0], name="C", diameter_mm=20.0)
    found = accept(
        replace(artefact, spheres=(*artefact.spheres, third)), [kit(1.0)], parse_limits(["0.1"])
    )
    made = replace(certified(tmp_path, "0.1", 1.0), acceptance=found)
    page = html_of(acceptance_report(made))
    assert "sphere C, capture 1: no such sphere is in the surface." in page


def test_the_mean_error_of_lengths_is_of_those_between_marks_too(tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    made = certified(tmp_path, "0.1", 1.0)
    (spacing,) = (one for one in made.acceptance.spreads if one.kind == "spacing")
    marks = replace(spacing, kind="length", count=3, bias_share=0.004)
    for spreads, mean in (
        ((replace(spacing, bias_share=0.0),), "+0.000 %"),
        ((replace(spacing, bias_share=0.0), marks), "+0.300 %"),
        ((), "not tested"),
    ):
        found = replace(made.acceptance, spreads=spreads)
        cards = acceptance_report(replace(made, acceptance=found)).cards
        (card,) = (one for one in cards if one.question == "Mean error of lengths")
        assert card.answer == mean


def test_the_whiskers_of_the_chart_are_whole(tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(BAR)
    made = certified(tmp_path, "0.1", 1.0)
    one = next(one for one in made.acceptance.values if one.kind == "size")
    for error, reach in ((0.095, 1.27), (0.0, 1.15)):
        value = replace(one, error_mm=error, uncertainty_mm=0.03, permissible_mm=0.1)
        found = replace(made.acceptance, values=(value,))
        section = acceptance_report(replace(made, acceptance=found)).sections[0]
        (figure,) = (block for block in section.blocks if isinstance(block, Illustration))
        assert isinstance(figure.image, Chart)
        axes = Figure().subplots()
        figure.image.draw(axes)
        assert axes.get_xlim() == pytest.approx((-reach, reach), abs=0.01)
