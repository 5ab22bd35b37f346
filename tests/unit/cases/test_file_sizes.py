"""Files in which a case's work is kept are read up to a size that no work has."""

from pathlib import Path

from tests.unit.file_sizes import require_takes_up_to

from limbgram.cases.case_record import CaseRecord, read_kept
from limbgram.cases.certificates import read_certificate
from limbgram.cases.folder import CaseFolder
from limbgram.cases.shelf import ShelvedCase
from limbgram.cases.workspace import Workspace


def test_a_record_takes_40_mb(tmp_path: Path) -> None:
    require_takes_up_to(
        lambda path: read_kept(path, CaseRecord, "record"), tmp_path / "case.json", 40_000_000
    )


def test_a_recipe_takes_40_mb(tmp_path: Path) -> None:
    workspace = Workspace(ShelvedCase("leg", CaseFolder(tmp_path)))
    workspace.recipe_file.parent.mkdir(parents=True, exist_ok=True)
    require_takes_up_to(lambda _: workspace.recipe(), workspace.recipe_file, 40_000_000)


def test_a_certificate_takes_4_mb(tmp_path: Path) -> None:
    require_takes_up_to(read_certificate, tmp_path / "kit.json", 4_000_000)
