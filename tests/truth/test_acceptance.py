"""A kit proved on a rendered ball bar, from photos to the reports that cite the certificate."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from limbgram.cli.main import app
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.gauges import BallBar

BAR = """
format = "limbgram artefact"
version = 1
name = "Ball bar 12"
spheres = [
    {{name = "A", diameter_mm = 60.0, uncertainty_mm = 0.01}},
    {{name = "B", diameter_mm = 60.0, uncertainty_mm = 0.01}},
]
lengths = [{{first = "A", second = "B", length_mm = {length_mm}, uncertainty_mm = 0.01}}]
"""


def limbgram(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.slow
def test_a_kit_is_proved_and_cited(tmp_path: Path) -> None:
    bar = BallBar(diameter_mm=60.0, spacing_mm=140.0, bar_mm=24.0)
    options = replace(SMALL, gauge=bar, photos=12, width_px=900, height_px=600, coverage=0.6)
    make_capture(tmp_path / "capture", options)
    camera = tmp_path / "camera.json"
    boards = tmp_path / "capture" / "calibration"
    done = limbgram("calibrate", boards, "--board", "14x10", "--square", 10, "-o", camera)
    assert done.exit_code == 0, done.output

    right, wrong = tmp_path / "right.toml", tmp_path / "wrong.toml"
    right.write_text(BAR.format(length_mm=140.0))
    wrong.write_text(BAR.format(length_mm=141.0))
    images = tmp_path / "capture" / "images"
    done = limbgram("verify-setup", right, images, "--camera", camera, "--mpe", 0.5, "--json")
    assert done.exit_code == 0, done.output
    reply: Any = json.loads(done.stdout)
    errors = {(one["kind"], one["name"]): one["error_mm"] for one in reply["acceptance"]["values"]}
    assert abs(errors["spacing", "A to B"]) < 0.1
    assert abs(errors["size", "A"]) < 0.25
    assert 0.02 < errors["form", "A"] < 0.5
    assert reply["cameras"][0]["sha256"]

    case = tmp_path / "camera.acceptance-cases" / "capture-1"
    elsewhere = tmp_path / "wrong.json"
    done = limbgram("verify-setup", wrong, case, "--mpe", 0.5, "-o", elsewhere)
    assert done.exit_code == 7
    assert done.stdout.startswith("FAIL")

    shutil.copytree(case, tmp_path / "again")  # of the same photos: nothing is measured anew
    done = limbgram("reconstruct", images, "--camera", camera, "-o", tmp_path / "again")
    assert done.exit_code in (0, 7), done.output
    assert "The kit passed its acceptance test on Ball bar 12" in done.stdout
    assert "Proof of the kit" in (tmp_path / "again" / "report.html").read_text()
    summary: Any = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert summary["setups"][0]["outcome"] == "pass"
    accuracy: Any = json.loads((tmp_path / "again" / "accuracy.json").read_text())
    assert accuracy["setups"] == summary["setups"]
