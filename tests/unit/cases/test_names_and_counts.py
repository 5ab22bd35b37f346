"""Names, notes and numbers of files as long and as many as they may be, and one more."""

from collections.abc import Callable
from pathlib import Path

import pytest

from limbgram.cases.cameras import CameraLabel, KeptCamera
from limbgram.cases.folder import CaseFolder
from limbgram.cases.shelf import Label, ShelvedCase
from limbgram.cases.uploads import checked_name, limit_of
from limbgram.core.errors import LimbgramError


def refused(act: Callable[[], object]) -> str:
    """The code of the refusal; empty where it is taken."""
    try:
        act()
    except LimbgramError as error:
        return error.finding.code
    return ""


def test_a_camera_is_called_by_80_letters_at_most(tmp_path: Path) -> None:
    camera = KeptCamera("camera", tmp_path)
    label = [CameraLabel(name="C" * count, made="") for count in (80, 81)]
    assert [refused(lambda one=one: camera.relabel(one)) for one in label] == [
        "", "camera.name_length",
    ]  # fmt: skip


def test_a_note_has_200_letters_at_most(tmp_path: Path) -> None:
    case = ShelvedCase("leg", CaseFolder(tmp_path))
    labels = [Label(made="", note="n" * count) for count in (200, 201)]
    assert [refused(lambda one=one: case.relabel(one)) for one in labels] == [
        "", "case.note_length",
    ]  # fmt: skip


def test_an_uploads_name_has_120_letters_at_most() -> None:
    names = ["a" * count + ".jpg" for count in (116, 117)]
    assert [refused(lambda one=one: checked_name(one)) for one in names] == [
        "", "case.upload.no_name",
    ]  # fmt: skip


@pytest.mark.parametrize(("name", "megabytes"), [("a.JPG", 300), ("a.mov", 8000), ("a.zip", 8000)])
def test_a_photo_has_300_mb_and_a_film_8_gb_at_most(name: str, megabytes: int) -> None:
    assert limit_of(name) == megabytes * 1_000_000
