"""Certificates: kept with one camera file, cited with their age, and never edited."""

import json
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from limbgram.capture.acceptance import Acceptance
from limbgram.capture.certificate import ArtefactTested, CameraTested, Certificate, cite
from limbgram.capture.setup import Outcome
from limbgram.cases.certificates import (
    certificate_beside,
    cited_setups,
    read_certificate,
    require_certificate_place,
    take_certificates_in,
    write_certificate,
)
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.findings import advice, note, told
from limbgram.formats.camera import write_camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.report.accuracy.judgement import Criterion, kit_criteria


def certificate(
    made: str = "2026-03-31", outcome: Outcome = "pass", sha256: str = "c" * 64
) -> Certificate:
    return Certificate(
        program="limbgram 0.1.0",
        made=made,
        cameras=(CameraTested(label="Some camera", sha256=sha256),),
        artefact=ArtefactTested(name="Ball bar 12", certificate="", calibrated="", sha256="a" * 64),
        captures=(),
        acceptance=Acceptance(
            outcome=outcome,
            headline=note("said.as_is", message="so it is"),
            values=(),
            spreads=(),
            bodies=(),
            not_measured=(),
            permitted=(),
        ),
    )


def camera_file(path: Path, fx: float = 3000.0) -> Path:
    camera = Camera(width_px=1200, height_px=800, fx=fx, fy=fx, cx=600.0, cy=400.0)
    calibration = Calibration(
        camera=camera, covariance=np.eye(LENS_SIZE), source="board", label="Cam"
    )
    write_camera(path, calibration)
    return path


@pytest.mark.parametrize(
    ("made", "today", "months"),
    [
        ("2026-03-31", "2026-03-31", 0),
        ("2026-03-31", "2026-04-30", 0),
        ("2026-03-31", "2026-05-31", 2),
        ("2025-12-01", "2026-12-01", 12),
        ("2025-12-02", "2026-12-01", 11),
        ("2026-06-01", "2026-03-01", -3),
    ],
)
def test_whole_months_are_counted(made: str, today: str, months: int) -> None:
    one = certificate(made)
    cited = cite(one, "f" * 64, one.cameras[0], date.fromisoformat(today))
    assert cited.months == months
    assert cited.to_do == (months >= 12 or months < 0)
    assert bool(advice(cited.finding)) == cited.to_do


def test_the_users_own_term_counts() -> None:
    one = replace(certificate("2026-01-01"), valid_months=3)
    cited = cite(one, "f" * 64, one.cameras[0], date(2026, 4, 1))
    assert "3 months old and was meant to count for 3" in told(cited.finding)
    with pytest.raises(OptionsError):
        replace(one, valid_months=0)


def test_a_kit_that_failed_is_never_green_and_one_that_passed_is() -> None:
    def judged(outcome: Outcome, made: str = "2026-03-31") -> Criterion:
        one = certificate(made, outcome)
        (found,) = kit_criteria([cite(one, "f" * 64, one.cameras[0], date(2026, 4, 1))])
        return found

    assert judged("fail").light == "amber"
    assert "FAILED" in told(judged("fail").finding)
    assert "Calibrate" not in told(judged("fail").finding)
    assert judged("pass").light == "green"
    assert judged("cannot tell").light == "amber"
    assert "could neither pass nor fail" in told(judged("cannot tell").finding)
    assert judged("pass", "2025-04-02").light == "green"
    old = judged("pass", "2025-02-01")
    assert old.light == "amber"
    assert "14 months old and was meant to count for 12" in told(old.finding)


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camera.acceptance.json"
    write_certificate(path, certificate())
    assert read_certificate(path) == certificate()


def test_an_edited_certificate_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "camera.acceptance.json"
    write_certificate(path, certificate(outcome="fail"))
    tree = json.loads(path.read_text())
    tree["acceptance"]["outcome"] = "pass"
    path.write_text(json.dumps(tree))
    with pytest.raises(CaseError, match="edited"):
        read_certificate(path)


def test_no_other_file_is_written_over(tmp_path: Path) -> None:
    path = tmp_path / "notes.json"
    path.write_text("{}")
    with pytest.raises(CaseError, match="it would be lost"):
        require_certificate_place(path)
    with pytest.raises(CaseError, match=r"end in \.json"):
        require_certificate_place(tmp_path / "notes.txt")


def test_a_case_cites_the_certificate_of_its_very_camera_file(tmp_path: Path) -> None:
    file = camera_file(tmp_path / "phone.json")
    assert certificate_beside(file) == tmp_path / "phone.acceptance.json"
    write_certificate(certificate_beside(file), certificate(sha256=file_sha256(file)))
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    case.camera_file(0).write_bytes(file.read_bytes())
    take_certificates_in(case, (file,))
    (cited,) = cited_setups(case, date(2026, 9, 30))
    assert cited.camera == "Cam"
    said = "passed its acceptance test on Ball bar 12 on 2026-03-31, 5 months ago"
    assert said in told(cited.finding)

    camera_file(file, fx=3001.0)  # calibrated anew: the old proof is none any more
    case.camera_file(0).write_bytes(file.read_bytes())
    assert cited_setups(case, date(2026, 9, 30)) == ()
    take_certificates_in(case, (file,))
    assert not certificate_beside(case.camera_file(0)).exists()


def test_a_case_without_certificates_cites_nothing(tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    camera_file(case.camera_file(0))
    assert cited_setups(case, date(2026, 9, 30)) == ()


def test_a_kit_is_tested_again_after_a_year_unless_up_to_ten_are_stated() -> None:
    assert certificate().valid_months == 12
    assert replace(certificate(), valid_months=120).valid_months == 120
    with pytest.raises(OptionsError) as refused:
        replace(certificate(), valid_months=121)
    assert refused.value.finding.code == "kit.valid_months"


def test_a_certificate_is_cited_by_eight_digits_of_its_hash() -> None:
    one = certificate()
    cited = cite(one, "0123456789abcdef" * 4, one.cameras[0], date(2026, 4, 1))
    assert cited.certificate == "01234567"
