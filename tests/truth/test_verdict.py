"""One verdict: what the terminal, the page, the files, the JSON and the exit code say of a capture.

A surface that lacks half of the limb must not look right anywhere, and a size that nothing confirms
must not look confirmed.
"""

import json
import math
import shutil
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from limbgram.cases.scoring import read_truth_mesh
from limbgram.cli.main import app
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.scale.stated_lengths import TapedGirth
from limbgram.reconstruction.scale.taped_girths import hold_tapes

pytestmark = pytest.mark.usefixtures("jobs_in_process")

PHOTOS = 12
TAPED_AT_MM = 150
"""Above the table."""
SAID = ("light", "headline", "size_checked", "reasons")


def limbgram(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def photos(folder: Path) -> list[Path]:
    return sorted((folder / "capture" / "images").iterdir())


def again(folder: Path, name: str, *words: object) -> Result:
    """The finished case run again under another name, so that it takes up what did not change."""
    case = folder / name
    if not case.exists():
        shutil.copytree(folder / "case", case)
    camera = () if "--camera" in words else ("--camera", folder / "camera.json")
    return limbgram("reconstruct", *photos(folder), *camera, "-o", case, *words)


def accuracy_of(case: Path) -> dict[str, Any]:
    """What the case says of itself; that every place says the same is tested on the way."""
    summary = json.loads((case / "summary.json").read_text("utf-8"))
    record = json.loads((case / "case.json").read_text("utf-8"))
    accuracy = json.loads((case / "accuracy.json").read_text("utf-8"))
    verdict = summary["verdict"]
    assert record["verdict"] == verdict
    assert {key: accuracy[key] for key in SAID} == {key: verdict[key] for key in SAID}
    light = verdict["light"]
    assert verdict["headline"]["sentence"].startswith(light.upper())
    page = (case / "report.html").read_text("utf-8")
    assert f'<div class="banner {light}"><b>{light.upper()}</b>' in page
    assert page.count('<div class="banner') == 1
    assert f'<div class="banner {light}">' in (case / "accuracy.html").read_text("utf-8")
    names = {file["path"] for file in record["files"]}
    assert ("deliverables/surface-RED.stl" in names) == (light == "red")
    assert ("deliverables/surface.stl" in names) == (light != "red")
    return accuracy


def criterion(accuracy: dict[str, Any], key: str) -> dict[str, Any]:
    (found,) = (one for one in accuracy["criteria"] if one["key"] == key)
    return found


def tape_of(folder: Path) -> str:
    """A height and what a tape reads there on the true limb."""
    vertices, faces = read_truth_mesh(folder / "capture" / "truth" / "mesh.ply")
    skin = Mesh(
        vertices_mm=vertices["xyz"].astype(float), faces=faces[(vertices["cap"][faces] == 0).all(1)]
    )
    (held,) = hold_tapes(skin, 0.0, (TapedGirth(girth_mm=300, height_mm=TAPED_AT_MM),)).found
    return f"{TAPED_AT_MM}={held.measured_mm:.0f}"


def test_a_whole_limb_is_green_and_its_size_is_said_to_rest_on_the_board(folder: Path) -> None:
    accuracy = accuracy_of(folder / "case")
    assert accuracy["light"] == "green"
    assert accuracy["headline"]["sentence"].endswith("; not checked independently.")
    assert accuracy["size_checked"] is False
    assert criterion(accuracy, "around")["value"] < 5
    assert criterion(accuracy, "open")["value"] < 3
    assert criterion(accuracy, "lens")["light"] == "green"


@pytest.mark.slow
def test_half_a_ring_is_red_everywhere(folder: Path) -> None:
    case = folder / "half"
    half = photos(folder)[: PHOTOS // 2 + 1]
    camera = folder / "camera.json"
    result = limbgram("reconstruct", *half, "--camera", camera, "-o", case, "--json")
    assert result.exit_code == 7, result.output
    assert json.loads(result.stdout)["verdict"]["light"] == "red"
    accuracy = accuracy_of(case)
    assert "directions round the limb" in accuracy["headline"]["sentence"]
    assert 25 < criterion(accuracy, "around")["value"] < 80
    said = limbgram("accuracy", case, "--json")
    assert said.exit_code == 7
    assert json.loads(said.stdout)["headline"] == accuracy["headline"]


def test_what_reads_a_red_surface_says_so_and_hands_it_on(folder: Path, tmp_path: Path) -> None:
    whole = folder / "case" / "deliverables" / "surface.ply"
    red = Path(shutil.copy(whole, tmp_path / "surface-RED.ply"))
    copied = tmp_path / "plain name.obj"
    axes = ("--side", "left", "--axis", "+z", "--proximal=-z", "--anterior", "+y")
    for command in (
        ("align", red, *axes),
        ("measure", red, "--every", 50),
        ("export", red, "--to", "obj", "-o", copied),
        ("measure", copied, "--every", 50),
    ):
        result = limbgram(*command)
        assert result.exit_code == 0, result.output
        assert "verdict is RED" in result.stdout
    assert limbgram("report", copied, "-o", tmp_path / "record").exit_code == 0
    assert "verdict is RED" in (tmp_path / "record" / "report.html").read_text("utf-8")


@pytest.mark.parametrize(
    "chosen",
    [
        pytest.param(slice(0, 3), id="three", marks=pytest.mark.slow),
        pytest.param(slice(0, 4), id="four", marks=pytest.mark.slow),
        pytest.param(slice(None, None, 2), id="sparse", marks=pytest.mark.slow),
    ],
)
def test_too_few_photos_are_red_or_refused_and_never_anything_else(
    folder: Path, chosen: slice, request: pytest.FixtureRequest
) -> None:
    case = folder / request.node.callspec.id
    camera = ("--camera", folder / "camera.json")
    result = limbgram("reconstruct", *photos(folder)[chosen], *camera, "-o", case)
    assert result.exit_code in (4, 7), result.output
    if result.exit_code == 7:
        assert accuracy_of(case)["light"] == "red"
    else:
        assert not (case / "report.html").exists()


@pytest.mark.slow
def test_a_tape_contradicts_the_board(folder: Path) -> None:
    """Nothing else does: a larger board makes all larger alike."""
    larger = ("--board", "charuco:7x5:33:24.2:4X4_50")
    result = again(folder, "larger", *larger, "--tape", tape_of(folder))
    assert result.exit_code == 7
    first = result.stdout.splitlines()[0]
    assert first.startswith("RED. ")
    assert "the scale board is probably not as large as stated" in first
    accuracy = accuracy_of(folder / "larger")
    assert math.isclose(criterion(accuracy, "tape")["value"], 20, rel_tol=0.5)
    assert [one["key"] for one in accuracy["criteria"] if one["light"] == "red"] == ["tape"]


@pytest.mark.slow
def test_a_camera_file_that_the_photos_contradict_is_named_and_not_used(folder: Path) -> None:
    """With a focal length 3 % wrong girths were 0.3 % wrong, at sigmas of a quarter of that."""
    tree = json.loads((folder / "camera.json").read_text("utf-8"))
    true_px = tree["parameters"]["fx"]
    for name in ("fx", "fy"):
        tree["parameters"][name] *= 1.03
    wrong = folder / "wrong camera.json"
    wrong.write_text(json.dumps(tree), "utf-8")
    again(folder, "wrong lens", "--camera", wrong)
    accuracy = accuracy_of(folder / "wrong lens")
    assert accuracy["light"] == "amber"
    found = criterion(accuracy, "lens")["finding"]
    assert found["code"] == "verdict.lens.not_used"
    assert found["values"]["given_px"] == pytest.approx(1.03 * true_px)
    assert found["values"]["shown_px"] == pytest.approx(true_px, rel=2e-3)
    said = limbgram("accuracy", folder / "wrong lens", "--json")
    assert json.loads(said.stdout)["headline"] == accuracy["headline"]
    truth = ("--truth", folder / "capture", "--json")
    compared = json.loads(limbgram("accuracy", folder / "wrong lens", *truth).stdout)["truth"]
    assert abs(compared["scale_error"]) < 1e-3


def test_a_refused_run_sets_the_green_page_aside(folder: Path) -> None:
    case = folder / "refused"
    tree = json.loads((folder / "camera.json").read_text("utf-8"))
    tree["width_px"] += 40
    other = folder / "another camera.json"
    other.write_text(json.dumps(tree), "utf-8")
    result = again(folder, "refused", "--camera", other)
    assert result.exit_code == 4, result.output
    assert "calibration is for" in result.stderr
    assert "Traceback" not in result.output
    assert not (case / "report.html").exists()
    assert not (case / "deliverables").exists()
    assert 'class="banner green"' in (case / "superseded" / "report.html").read_text("utf-8")
    assert json.loads((case / "case.json").read_text("utf-8"))["superseded"] == "superseded"
    assert limbgram("accuracy", case).exit_code == 3


def test_a_tape_makes_the_verdict_red_everywhere_or_confirms_the_size(folder: Path) -> None:
    """Of the case that was refused, whose earlier files give way to those of the first that is not.

    The tape decides last, so all that a reconstruction computes is taken up as it was.
    """
    case = folder / "refused"
    true_mm = float(tape_of(folder).partition("=")[2])
    result = again(folder, "refused", "--tape", f"{TAPED_AT_MM}={1.2 * true_mm:.0f}", "--json")
    assert result.exit_code == 7, result.output
    assert json.loads(result.stdout)["verdict"]["light"] == "red"
    assert not (case / "superseded").exists()
    record = json.loads((case / "case.json").read_text("utf-8"))
    assert [one["stage"] for one in record["stages"] if not one["reused"]] == ["hold_tapes"]
    accuracy = accuracy_of(case)
    assert [one["key"] for one in accuracy["criteria"] if one["light"] == "red"] == ["tape"]
    said = limbgram("accuracy", case, "--json")
    assert said.exit_code == 7
    assert json.loads(said.stdout)["headline"] == accuracy["headline"]
    assert again(folder, "refused", "--tape", tape_of(folder)).exit_code == 0
    accuracy = accuracy_of(case)
    assert accuracy["light"] == "green"
    assert accuracy["headline"]["sentence"].endswith("; confirmed to 0.9 % by tape.")
    assert accuracy["size_checked"] is True
    assert criterion(accuracy, "tape")["value"] < 1
