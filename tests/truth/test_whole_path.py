"""From photos to files through the command line, on a capture whose truth is known."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from typer.testing import CliRunner, Result

from limbgram import compare, read_limb
from limbgram.cases.case_assessment import kept_evidence
from limbgram.cases.folder import CaseFolder
from limbgram.cases.masks import mask_of
from limbgram.cases.scoring import score_case
from limbgram.cli.main import app
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.reconstruction.measuring.uncertainty import (
    CAMERAS,
    CREASES,
    FACES,
    GAPS,
    OFFSET,
    SCALE,
)

ROOT = Path(__file__).parents[2]
README, GUIDE = ROOT / "README.md", ROOT / "docs" / "library" / "index.md"
PHOTOS = 14
NAMES = (
    *(f"surface.{kind}" for kind in ("stl", "dxf", "ply", "obj", "glb", "vtp")),
    "cloud.ply",
    "transforms.json",
)


def limbgram(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def last_run(case: Path) -> dict[str, Any]:
    return json.loads((case / "case.json").read_text("utf-8"))


def reconstruct(folder: Path, *words: object) -> Result:
    photos = folder / "capture" / "images"
    camera = folder / "camera.json"
    case = folder / "case"
    return limbgram("reconstruct", photos, "--camera", camera, "-o", case, *words)


def test_the_surface_is_true(folder: Path) -> None:
    """Near what this capture reaches (RMS 0.076 mm at 1.0 mm a pixel), from both sides."""
    score = score_case(folder / "case", folder / "capture" / "truth")
    assert 0.065 < score.rms_mm < 0.088
    assert 0.13 < score.p95_mm < 0.17
    assert abs(score.mean_mm) < 0.02
    assert 1e-6 < abs(score.scale_error) < 5e-4
    assert 0.97 < score.covered < 0.995
    assert len(score.girth_errors_mm) == 4
    assert 0.02 < max(map(abs, score.girth_errors_mm)) < 0.25
    assert 1e-6 < abs(score.volume_error) < 8e-4
    assert score.camera_rms_mm < 1.2


def programs(page: Path) -> list[str]:
    return re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL)


@pytest.mark.slow
def test_the_programs_of_the_guide_run_and_make_the_same_surface(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What README and guide show of Python runs as it stands there, on real photos."""
    shown = programs(GUIDE)
    assert programs(README) == [one for one in shown if "limbgram.reconstruct(" in one]
    (tmp_path / "photos").symlink_to(folder / "capture" / "images")
    (tmp_path / "board").symlink_to(folder / "capture" / "calibration")
    monkeypatch.chdir(tmp_path)
    left: dict[str, Any] = {}
    for program in shown:
        exec(program, left)
    made = trimesh.load_mesh(tmp_path / "limb.stl")
    command = trimesh.load_mesh(folder / "case" / "deliverables" / "surface.stl")
    tree = TriangleTree.of(np.array(command.vertices), np.array(command.faces, np.int32))
    apart_mm = tree.closest(np.array(made.vertices)).distances_mm
    # Not to the byte: the command sets how many threads add up matrix products, and triangles fall
    # otherwise; the surface is the same within a few of its sigmas (0.06 mm).
    assert np.quantile(apart_mm, 0.95) < 0.06
    assert len(made.faces) == pytest.approx(len(command.faces), rel=0.01)
    assert left["judged"].light == "green"
    volume = compare(left["limb"], left["rectified"]).levels.volume
    assert volume is not None
    assert 500 < volume.difference < 1500
    carved = read_limb(tmp_path / "limb.aop")
    assert carved.frame.side == "left"
    assert (tmp_path / "limb.ngc").stat().st_size > 100_000


def test_the_expected_error_has_a_part_from_every_source(folder: Path) -> None:
    tree = json.loads((folder / "case" / "accuracy.json").read_text("utf-8"))
    budget = {one["part"]: one["sigma_mm"] for one in tree["expected"]["budget"]}
    assert set(budget) == {"image measurement", SCALE, CAMERAS, OFFSET, FACES, GAPS, CREASES}
    assert 1e-4 < budget[CAMERAS] < 0.08
    assert min(budget[part] for part in budget if part != CREASES) > 1e-5
    assert 0 <= budget[CREASES] < 0.07  # a smooth limb has hardly any
    assert budget[GAPS] < 0.02  # painted all over
    assert np.hypot.reduce([*budget.values()]) == pytest.approx(
        tree["expected"]["rms_mm"], rel=1e-3
    )


def test_every_file_is_there_and_is_in_millimetres(folder: Path) -> None:
    deliverables = folder / "case" / "deliverables"
    sizes = {
        name: np.sort(trimesh.load(deliverables / name).bounding_box.extents)
        for name in ("surface.stl", "surface.ply", "surface.obj")
    }
    for size in sizes.values():
        np.testing.assert_allclose(size, sizes["surface.stl"], rtol=1e-5)
        assert 200 < size[2] < 320
    assert all((deliverables / name).stat().st_size > 1000 for name in NAMES)
    poses = json.loads((deliverables / "poses.json").read_text("utf-8"))
    assert len(poses["images"]) == PHOTOS
    # The points of the paint have its colours.
    import pycolmap  # after PIL, which it would otherwise give another zlib

    model = pycolmap.Reconstruction(deliverables / "colmap")
    colours = np.array([point.color for point in model.points3D.values()])
    assert len(np.unique(colours, axis=0)) > 100


def test_undistorted_photos_are_those_of_pinhole_cameras(folder: Path) -> None:
    result = limbgram("undistort", folder / "case", "-o", folder / "straight")
    assert result.exit_code == 0, result.output
    import pycolmap

    model = pycolmap.Reconstruction(folder / "straight" / "sparse")
    assert {camera.model.name for camera in model.cameras.values()} == {"PINHOLE"}
    for image in model.images.values():
        with Image.open(folder / "straight" / "images" / image.name) as picture:
            camera = model.cameras[image.camera_id]
            assert picture.size == (camera.width, camera.height)
    assert limbgram("undistort", folder / "case", "-o", folder / "straight").exit_code == 5


def test_the_page_holds_everything_and_asks_for_nothing(folder: Path) -> None:
    page = (folder / "case" / "report.html").read_text("utf-8")
    assert f"{PHOTOS} of {PHOTOS} photos placed" in page
    assert "not a cleared medical device" in page
    assert page.count("<img") == page.count('src="data:image/png;base64,') == 7
    outside = re.sub(r'src="data:[^"]*"', "", page)
    assert not re.search(r"https?:|<script|<link|url\(|@import", outside)
    assert len(list((folder / "case" / "report").glob("*.png"))) == 7


def test_masks_of_the_case_hold_the_limb_and_little_else(folder: Path, tmp_path: Path) -> None:
    result = limbgram("masks", folder / "case", "-o", tmp_path / "masks", "--margin", 4)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "masks" / "at-a-glance.jpg").stat().st_size > 10_000
    truth = sorted((folder / "capture" / "truth" / "masks").iterdir())
    assert len(truth) == PHOTOS
    for path in truth:
        limb, made = picture(path), picture(tmp_path / "masks" / path.name)
        assert np.count_nonzero(limb & ~made) < 0.005 * np.count_nonzero(limb)
        assert 0.02 < np.count_nonzero(made & ~limb) / np.count_nonzero(limb) < 0.3
    again = limbgram("masks", folder / "case", "-o", tmp_path / "masks")
    assert again.exit_code == 3
    assert "corrected by hand" in again.output


@pytest.mark.slow
def test_corrected_masks_say_what_the_limb_is(folder: Path, tmp_path: Path) -> None:
    """Its upper half painted black in all masks but one, which is missing, is not measured.

    Where it was cut the surface is closed by a cap, which counts as filled in.
    """
    whole = kept_evidence(CaseFolder(folder / "case"))
    middle_mm = float(np.median(whole.mesh.vertices_mm[:, 2]))
    below = (whole.mesh.vertices_mm[whole.mesh.faces][:, :, 2] < middle_mm).all(axis=1)
    scene, lower = whole.metric.scene, replace(whole.mesh, faces=whole.mesh.faces[below])
    (tmp_path / "masks").mkdir()
    for idx, name in enumerate(scene.names[1:], start=1):
        levels = mask_of(lower, scene.view(idx), 3.0).astype(np.uint8) * 255
        Image.fromarray(levels).save((tmp_path / "masks" / name).with_suffix(".png"))
    photos, camera = folder / "capture" / "images", folder / "camera.json"
    words = (photos, "--camera", camera, "--masks", tmp_path / "masks", "-o", tmp_path / "case")
    result = limbgram("reconstruct", *words)
    assert result.exit_code == 7, result.output
    notes = json.loads((tmp_path / "case" / "summary.json").read_text("utf-8"))["scene"]["notes"]
    assert f"for want of a mask: {scene.names[0]}." in notes[0]
    half = kept_evidence(CaseFolder(tmp_path / "case")).mesh
    assert half.filled is not None
    measured_mm = half.vertices_mm[~half.filled]
    assert middle_mm - 15 < np.quantile(measured_mm[:, 2], 0.99) < middle_mm + 15
    tree = TriangleTree.of(whole.mesh.vertices_mm, whole.mesh.faces)
    assert 1e-3 < np.median(tree.closest(measured_mm).distances_mm) < 0.1


def picture(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("L")) > 127


def test_no_file_of_the_case_has_the_name_of_its_folder(folder: Path, finished: Path) -> None:
    files = [file for file in (folder / "case").rglob("*") if file.is_file()]
    assert folder.name == finished.name == "Fuß links0"
    assert len(files) > 60
    assert [file.name for file in files if b" links0" in file.read_bytes()] == []


@pytest.mark.usefixtures("jobs_in_process")
def test_a_second_run_computes_nothing_and_gives_the_same_bytes(folder: Path) -> None:
    before = last_run(folder / "case")
    result = reconstruct(folder, "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["unit"] == "mm"
    after = last_run(folder / "case")
    assert before["state"] == after["state"] == "finished"
    assert all(stage["reused"] for stage in after["stages"])
    assert not any(stage["reused"] for stage in before["stages"])
    assert after["files"] == before["files"]


@pytest.mark.slow  # a tape, in `test_verdict`, recomputes less
@pytest.mark.usefixtures("jobs_in_process")
def test_another_surface_recomputes_only_what_hangs_on_it(folder: Path) -> None:
    assert reconstruct(folder, "--surface", "poisson").exit_code == 0
    computed = [s["stage"] for s in last_run(folder / "case")["stages"] if not s["reused"]]
    shaped = ["tell_parts", "repair", "refine", "measure", "hold_tapes"]
    assert computed == ["poisson", *shaped, "draw"]


@pytest.mark.usefixtures("jobs_in_process")
@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--board", "charuco:7x5:30"], 2, "names no board"),
        (["--no-board"], 2, "size of the surface is unknown"),
        (["--no-board", "--board", "charuco:7x5:30:22:4X4_50"], 2, "contradict"),
        (["--box", "1,2,3"], 2, "is no box"),
        (["--camera", "nowhere.json"], 3, "nowhere.json"),
    ],
)
def test_refusals_say_why_and_have_their_exit_code(
    folder: Path, words: list[str], code: int, message: str
) -> None:
    result = reconstruct(folder, *words)
    assert result.exit_code == code, result.output
    assert message in result.stderr
    assert "Traceback" not in result.output
