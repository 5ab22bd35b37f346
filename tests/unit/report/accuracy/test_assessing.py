"""A finished case is assessed from what it keeps; an unfinished one is refused."""

import hashlib
import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from limbgram.cases.case_assessment import (
    assess_case,
    cited,
    kept_evidence,
    read_truth,
    require_unaltered,
)
from limbgram.cases.encoding import unsealed
from limbgram.cases.folder import CaseFolder
from limbgram.cases.stage_cache import write_product
from limbgram.cli.accuracy import accuracy_lines
from limbgram.core.errors import CaseError, MeasureError, OptionsError
from limbgram.core.run import Timing
from limbgram.formats.ply import write_ply
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.photos.photo import Exif, Photo, PhotoSet
from limbgram.report.accuracy.evidence import Evidence

TIMING = Timing("stage", 1.0, 1.0, 100.0)


@pytest.fixture
def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages without what takes longest to draw."""
    monkeypatch.setattr("limbgram.cases.case_assessment.accuracy_pictures", lambda *_: ())


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
        key = f"key of {name}"
        write_product(case.stages / name, key, product, type(product), TIMING, None, case.root)
    record_as(case, state, list(products))


def record_as(case: CaseFolder, state: str, stages: list[str]) -> None:
    """Write a record of these stages."""
    listed = [{"stage": name, "key": f"key of {name}"} for name in stages]
    case.record.write_text(json.dumps({"state": state, "stages": listed, "files": []}), "utf-8")


def test_a_finished_case_gets_json_page_and_pdf(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "Erika Mustermann 1951")
    case.root.mkdir()
    keep(case, with_sigmas)
    tree = assess_case(case, None, "surface").tree
    assert unsealed(json.loads(case.accuracy("json").read_text("utf-8"))) == tree
    told = with_sigmas.name
    assert tree["case"] == told
    assert told.startswith("case ")
    assert len(told) == len("case ") + 8
    assert tree["headline"]["sentence"].startswith("GREEN. Surface: 95 % within 0.25 mm")
    assert f"How accurate is {told}?" in case.accuracy("html").read_text("utf-8")
    assert case.accuracy("pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.usefixtures("without_pictures")
def test_a_case_placed_again_without_its_camera_file_is_assessed_by_what_was_placed_last(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    """What was found with the file, boards among it, does not count any more."""
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    keep(case, with_sigmas)
    (given,) = with_sigmas.cameras.calibrations
    file = replace(given, camera=replace(given.camera, fx=1.03 * given.camera.fx))
    freed = Cameras((replace(given, source="exif", instead_of=file),))
    key = "key of without_files"
    write_product(case.stages / "without_files", key, freed, Cameras, TIMING, None, case.root)
    measured = case.stages / "measure"
    measured.rename(case.stages / "measure-2")
    before = ["read_photos", "cameras_for", "still_board"]
    record_as(case, "finished", [*before, "without_files", "to_millimetres", "measure"])
    record = json.loads(case.record.read_text("utf-8"))
    record["stages"][-1]["stage"] = "measure-2"
    case.record.write_text(json.dumps(record), "utf-8")
    evidence = kept_evidence(case)
    assert evidence.cameras.calibrations[0].instead_of is not None
    assert evidence.detections is None
    found = assess_case(case, None, "surface").tree
    assert found["light"] == "amber"
    (lens,) = (one for one in found["criteria"] if one["key"] == "lens")
    assert lens["finding"]["code"] == "verdict.lens.not_used"
    assert lens["finding"]["values"]["given_px"] == pytest.approx(1.03 * given.camera.fx)
    assert lens["finding"]["values"]["shown_px"] == pytest.approx(given.camera.fx)
    assert found["self_calibration"]["finding"]["values"]["not_used"] is True


@pytest.mark.usefixtures("without_pictures")
def test_a_mesh_file_in_the_same_frame_is_a_truth(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    keep(case, with_sigmas)
    known = write_ply(with_sigmas.mesh, tmp_path / "true.ply", with_sigmas.metric.scale.unit)
    found = assess_case(case, known, "frame")
    truth = found.tree["truth"]
    assert truth["rms_mm"] < 1e-5  # single precision of the file
    told = next(line for line in accuracy_lines(case, found) if line.startswith("  girths"))
    heights = [one["height_mm"] for one in truth["girths"]]
    assert len(set(heights)) == 4
    assert [f" at {height:.1f}" in told for height in heights] == [True] * 4
    assert "radial error" not in case.accuracy("html", against_truth=True).read_text("utf-8")
    assert truth["camera_rms_mm"] is None
    assert truth["sigma"]["robust_spread"] < 1e-3


@pytest.mark.usefixtures("without_pictures")
def test_a_wrong_truth_leaves_what_the_case_says_of_itself(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    keep(case, with_sigmas)
    assess_case(case, None, "surface")
    own = {path.name: path.read_bytes() for path in case.root.glob("accuracy.*")}
    larger = with_sigmas.mesh.with_vertices(1.2 * with_sigmas.mesh.vertices_mm)
    wrong = write_ply(larger, tmp_path / "wrong.ply", with_sigmas.metric.scale.unit)
    tree = assess_case(case, wrong, "frame").tree
    assert tree["light"] == "red"
    assert {path.name: path.read_bytes() for path in case.root.glob("accuracy.*")} == own
    beside = case.accuracy("json", against_truth=True)
    assert unsealed(json.loads(beside.read_text("utf-8"))) == tree
    assert len(list(case.root.glob("accuracy-truth.*"))) == 3
    assert cited(case).accuracy.light == "green"
    case.accuracy("json").write_bytes(beside.read_bytes())  # as earlier versions wrote it
    with pytest.raises(CaseError, match="without --truth"):
        cited(case)


@pytest.mark.usefixtures("without_pictures")
def test_an_edited_accuracy_is_not_cited(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    keep(case, with_sigmas)
    tree = assess_case(case, None, "surface").tree
    path = case.accuracy("json")
    whole = path.read_text("utf-8")
    said, lengths, expected = cited(case).accuracy, tree["lengths"], tree["expected"]
    assert said.light == tree["light"] == "green"
    assert asdict(said.expected) == {name: expected[name] for name in asdict(said.expected)}
    assert [one.label for one in said.lengths.check] == [one["label"] for one in lengths["check"]]
    assert said.lengths.check_rms == lengths["check_rms"]
    assert said.lengths.check_worst == lengths["check_worst"]
    for old, new in (
        ('"light": "green"', '"light": "amber"'),
        ('"unit": "mm"', '"unit": "mm", "more": 1'),
        ('"seal": "', '"seal": "0'),
        ('"seal": "', '"shell": "'),
    ):
        assert old in whole
        path.write_text(whole.replace(old, new, 1), "utf-8")
        with pytest.raises(CaseError, match=r"not as it was written: .* `limbgram accuracy`"):
            cited(case)


def test_what_is_no_finished_case_is_refused(with_sigmas: Evidence, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no case"):
        assess_case(CaseFolder(tmp_path), None, "surface")
    keep(CaseFolder(tmp_path), with_sigmas, state="cancelled")
    with pytest.raises(CaseError, match="cancelled"):
        assess_case(CaseFolder(tmp_path), None, "surface")


@pytest.mark.parametrize("stage", ["measure", "to_millimetres", "cameras_for", "read_photos"])
@pytest.mark.parametrize("file", ["product.json", "arrays.npz", "stage.json"])
def test_a_damaged_or_edited_product_is_refused_and_named(
    with_sigmas: Evidence, tmp_path: Path, stage: str, file: str
) -> None:
    case = CaseFolder(tmp_path)
    keep(case, with_sigmas)
    path = case.stages / stage / file
    content = path.read_bytes()
    digits = [k for k, byte in enumerate(content) if chr(byte).isdigit()]
    place = max(digits, default=len(content) - 1)
    other = bytes([content[place] ^ 1])  # of a digit, its neighbour
    path.write_bytes(content[:place] + other + content[place + 1 :])
    with pytest.raises(CaseError, match=rf"{stage} is not what .* reconstruct. on the case again"):
        assess_case(case, None, "surface")


def test_a_product_of_another_run_is_refused(with_sigmas: Evidence, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    keep(case, with_sigmas)
    mesh = with_sigmas.mesh
    folder = case.stages / "measure"
    write_product(folder, "key of another run", mesh, type(mesh), TIMING, None, case.root)
    with pytest.raises(CaseError, match="measure is not what the case was finished with"):
        assess_case(case, None, "surface")


def test_a_board_that_the_finished_run_did_not_ask_for_is_not_read(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    case = CaseFolder(tmp_path)
    keep(case, with_sigmas)
    (case.stages / "find_board").mkdir()
    assert kept_evidence(case).detections is None


def test_an_altered_photo_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.jpg"
    file.write_bytes(b"as received")
    sha256 = hashlib.sha256(b"as received").hexdigest()
    photo = Photo(
        name="a.jpg", path=file, width_px=9, height_px=9, exif=Exif(), sha256=sha256, camera_idx=0
    )
    require_unaltered([photo])
    file.write_bytes(b"as retouched")
    with pytest.raises(CaseError, match=r"a\.jpg is no longer the photo"):
        require_unaltered([photo])
    file.unlink()
    with pytest.raises(CaseError, match=r"a\.jpg is no longer the photo"):
        require_unaltered([photo])


def test_a_truth_must_exist_and_have_cameras_to_align_by(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match="holds no truth"):
        read_truth(tmp_path, with_sigmas, "surface")
    known = write_ply(with_sigmas.mesh, tmp_path / "true.ply", with_sigmas.metric.scale.unit)
    with pytest.raises(OptionsError, match="Align by the surface"):
        read_truth(known, with_sigmas, "cameras")


def test_lengths_without_a_scale_are_not_compared_with_a_truth_in_mm(
    with_sigmas: Evidence, tmp_path: Path
) -> None:
    known = write_ply(with_sigmas.mesh, tmp_path / "true.ply", "mm")
    bare = replace(with_sigmas.metric, scale=replace(with_sigmas.metric.scale, unit="unitless"))
    assert read_truth(known, with_sigmas, "surface").kind == "a mesh file"
    with pytest.raises(MeasureError, match="no scale"):
        read_truth(known, replace(with_sigmas, metric=bare), "surface")
