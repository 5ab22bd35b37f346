"""A finished case is assessed from what it keeps; an unfinished one is refused."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from limbgram.cases.assessing.accuracy import assess_case
from limbgram.cases.assessing.citing import cited
from limbgram.cases.assessing.truths import read_truth
from limbgram.cases.folder import CaseFolder
from limbgram.cases.keeping.store import write_product
from limbgram.cli.quality.accuracy import accuracy_lines
from limbgram.errors import CaseError, OptionsError
from limbgram.export import write_ply
from limbgram.photos.photo import PhotoSet
from limbgram.report.accuracy import Evidence
from limbgram.run import Timing

TIMING = Timing("stage", 1.0, 1.0, 100.0)


def keep(case: CaseFolder, found: Evidence, state: str = "finished") -> None:
    """Write the evidence as a run would have kept it."""
    photos = tuple(replace(photo, path=case.root / photo.path) for photo in found.photos.photos)
    products: dict[str, Any] = {
        "read_photos": PhotoSet(photos, found.photos.cameras),
        "cameras_for": found.cameras,
        "to_millimetres": found.metric,
        "measure": found.mesh,
    }
    for name, product in products.items():
        write_product(case.stages / name, "key", product, type(product), TIMING, None, case.root)
    case.record.write_text(json.dumps({"state": state}))


def test_a_finished_case_gets_json_page_and_pdf(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "limb 7")
    case.root.mkdir()
    keep(case, with_sigmas)
    tree = assess_case(case, None, "surface")
    assert json.loads(case.accuracy("json").read_text("utf-8")) == tree
    assert tree["case"] == "limb 7"
    assert tree["headline"].startswith("GREEN: 0.20 mm.")
    assert "How accurate is limb 7?" in case.accuracy("html").read_text("utf-8")
    assert case.accuracy("pdf").read_bytes().startswith(b"%PDF")


def test_a_mesh_file_in_the_same_frame_is_a_truth(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    keep(case, with_sigmas)
    known = write_ply(with_sigmas.mesh, tmp_path / "true.ply", with_sigmas.metric.scale.unit)
    tree = assess_case(case, known, "frame")
    truth = tree["truth"]
    assert truth["rms_mm"] < 1e-5  # single precision of the file
    told = next(line for line in accuracy_lines(case, tree) if line.startswith("  girths"))
    heights = [one["height_mm"] for one in truth["girths"]]
    assert len(set(heights)) == 4
    assert [f" at {height:.1f}" in told for height in heights] == [True] * 4
    assert "radial error" not in case.accuracy("html", against_truth=True).read_text("utf-8")
    assert truth["camera_rms_mm"] is None
    assert truth["sigma"]["robust_spread"] < 1e-3


def test_a_wrong_truth_leaves_what_the_case_says_of_itself(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    keep(case, with_sigmas)
    case.record.write_text(json.dumps({"state": "finished", "files": []}))
    assess_case(case, None, "surface")
    own = {path.name: path.read_bytes() for path in case.root.glob("accuracy.*")}
    larger = with_sigmas.mesh.with_vertices(1.2 * with_sigmas.mesh.vertices_mm)
    wrong = write_ply(larger, tmp_path / "wrong.ply", with_sigmas.metric.scale.unit)
    tree = assess_case(case, wrong, "frame")
    assert tree["light"] == "red"
    assert {path.name: path.read_bytes() for path in case.root.glob("accuracy.*")} == own
    beside = case.accuracy("json", against_truth=True)
    assert json.loads(beside.read_text("utf-8")) == tree
    assert len(list(case.root.glob("accuracy-truth.*"))) == 3
    assert cited(case).accuracy["light"] == "green"
    case.accuracy("json").write_bytes(beside.read_bytes())  # as earlier versions wrote it
    with pytest.raises(CaseError, match="without --truth"):
        cited(case)


def test_what_is_no_finished_case_is_refused(with_sigmas: Evidence, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no case"):
        assess_case(CaseFolder(tmp_path), None, "surface")
    keep(CaseFolder(tmp_path), with_sigmas, state="cancelled")
    with pytest.raises(CaseError, match="cancelled"):
        assess_case(CaseFolder(tmp_path), None, "surface")


def test_a_damaged_product_is_refused_and_named(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    keep(case, with_sigmas)
    (case.stages / "measure" / "arrays.npz").write_bytes(b"half")
    with pytest.raises(CaseError, match="measure cannot be read"):
        assess_case(case, None, "surface")


def test_a_truth_must_exist_and_have_cameras_to_align_by(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match="holds no truth"):
        read_truth(tmp_path, with_sigmas, "surface")
    known = write_ply(with_sigmas.mesh, tmp_path / "true.ply", with_sigmas.metric.scale.unit)
    with pytest.raises(OptionsError, match="Align by the surface"):
        read_truth(known, with_sigmas, "cameras")
