"""`align`, then `export`: no way round what is known of a limb's side."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from limbgram.cli.main import app
from limbgram.formats.reading import read_limb
from limbgram.formats.stl import write_stl
from limbgram.workbench.limb import Limb

FRONT = ["--anterior", "+y"]


def run(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def said(answer: Result) -> str:
    return " ".join(answer.stderr.split())


@pytest.fixture
def scan(stump: Limb, tmp_path: Path) -> Path:
    write_stl(stump.mesh, tmp_path / "scan.stl", "mm")
    return tmp_path / "scan.stl"


@pytest.fixture
def aop(tmp_path: Path) -> Path:
    """A right limb, an elliptic cylinder 200 mm long."""
    angles = 2 * np.pi * np.arange(36) / 36
    radii = 60 * 40 / np.hypot(40 * np.sin(angles), 60 * np.cos(angles))
    lines = ["AAOP1", "END COMMENTS", "CYLINDRICAL", "RIGHT", "0", "36", "10", "41", "5"]
    lines += [f"{radius:.4f}" for _ in range(41) for radius in radii]
    path = tmp_path / "limb.aop"
    path.write_text("\n".join([*lines, ""]))
    return path


def test_a_side_is_not_swapped_past_kept_landmarks(scan: Path) -> None:
    mark = ["--kind", "transtibial", "--landmark", "fibula head=53.7,0,170"]
    first = run("align", scan, "--side", "right", *FRONT, *mark, "--json")
    assert first.exit_code == 0, first.stderr
    assert json.loads(first.stdout)["kind"] == "transtibial"
    assert read_limb(scan).kind == "transtibial"
    kept = scan.with_name("scan.limb.json")
    before = kept.read_bytes()
    for _ in range(2):
        answer = run("align", scan, "--side", "left", *FRONT)
        assert answer.exit_code == 4
        assert "180 degrees from where it belongs" in said(answer)
        # Once more as a limb file that is older than the entry.
        tree = json.loads(before)
        tree.pop("kind", None)
        kept.write_text(json.dumps(tree))
    assert read_limb(scan).kind is None
    assert json.loads(kept.read_bytes())["side"] == "right"


def test_an_aop_tells_its_front_and_keeps_its_side(aop: Path) -> None:
    wrong = run("align", aop, "--side", "left", *FRONT)
    assert wrong.exit_code == 4
    assert "says that it is a right limb" in said(wrong)
    assert not aop.with_name("limb.limb.json").exists()
    answer = run("align", aop, "--side", "right", "--json")
    assert answer.exit_code == 0, answer.stderr
    told = json.loads(answer.stdout)
    np.testing.assert_allclose(told["limb_from_mesh"]["rotation"], np.eye(3), atol=1e-6)
    again = run("align", aop, "--side", "left")
    assert again.exit_code == 4
    assert "says that it is a right limb" in said(again)


def test_a_limb_file_does_not_overrule_the_side_of_an_aop(aop: Path, tmp_path: Path) -> None:
    assert run("align", aop, "--side", "right").exit_code == 0
    kept = aop.with_name("limb.limb.json")
    kept.write_text(json.dumps(json.loads(kept.read_bytes()) | {"side": "left"}))
    out = tmp_path / "out.nc"
    answer = run("export", aop, "--to", "gcode", "--side", "left", "-o", out)
    assert answer.exit_code == 3
    assert "is a right limb and its limb file limb.limb.json says left" in said(answer)
    assert not out.exists()


def test_directions_and_angles_that_cannot_be_are_refused(scan: Path) -> None:
    down = run("align", scan, "--side", "right", *FRONT, "--proximal=-z")
    assert down.exit_code == 4
    assert "open" in down.stderr
    bent = run("align", scan, "--side", "right", *FRONT, "--flexion", "400")
    assert bent.exit_code == 2
    assert not scan.with_name("scan.limb.json").exists()
    slip = run("align", scan, "--side", "right", *FRONT, "--landmark", "fibula heda=53.7,0,170")
    assert slip.exit_code == 0
    assert "'fibula head' meant" in " ".join(slip.stdout.split())
