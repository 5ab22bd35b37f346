"""What lies in a folder becomes captures by one rule, and no two become one case."""

from pathlib import Path

import pytest

from limbgram.batch.captures import find_captures, loose_photos, sources_in
from limbgram.batch.settings import Batch
from limbgram.core.errors import OptionsError


def laid(folder: Path, *names: str) -> Path:
    for name in names:
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if place.suffix:
            place.write_bytes(b"x")
        else:
            place.mkdir()
    return folder


def names(folder: Path, batch: Batch, cases: str = "cases") -> list[tuple[str, str]]:
    return [(one.name, one.kind) for one in find_captures(folder, batch, folder / cases)]


def test_folders_zips_and_videos_are_captures(tmp_path: Path) -> None:
    laid(tmp_path, "P2/a.jpg", "P1.zip", "P3.MOV", "batch.toml", ".hidden/a.jpg", "a.jpg",
         "cases/P1", "calibration/b.jpg")  # fmt: skip
    found = names(tmp_path, Batch(leave_out=("calib*",)))
    assert found == [("P1", "zip"), ("P2", "folder"), ("P3", "video")]
    assert loose_photos(tmp_path) == 1


def test_captures_may_lie_deeper(tmp_path: Path) -> None:
    laid(tmp_path, "Mon/P1/a.jpg", "Tue/P1/a.jpg")
    found = names(tmp_path, Batch(captures=("*/*",)))
    assert found == [("Mon-P1", "folder"), ("Tue-P1", "folder")]


@pytest.mark.parametrize("pair", [("P1.zip", "P1/a.jpg"), ("P1/a.jpg", "p1/a.jpg")])
def test_two_captures_of_one_name_are_refused(tmp_path: Path, pair: tuple[str, str]) -> None:
    laid(tmp_path, *pair)
    with pytest.raises(OptionsError, match="both become the case"):
        names(tmp_path, Batch())


@pytest.mark.parametrize("pattern", ["../*", "/etc/*", ""])
def test_patterns_stay_in_the_folder(tmp_path: Path, pattern: str) -> None:
    laid(tmp_path / "in", "P1/a.jpg")
    laid(tmp_path, "other/a.jpg")
    with pytest.raises(OptionsError, match=r"pattern|leaves|No capture"):
        names(tmp_path / "in", Batch(captures=(pattern,)))


def test_an_empty_folder_and_one_folder_for_both_are_refused(tmp_path: Path) -> None:
    with pytest.raises(OptionsError, match="No capture"):
        names(tmp_path, Batch())
    with pytest.raises(OptionsError, match="itself"):
        names(tmp_path, Batch(), ".")


def test_videos_are_taken_where_there_are_no_photos(tmp_path: Path) -> None:
    laid(tmp_path, "P1/a.mp4", "P1/b.mov", "P2/a.jpg", "P2/b.mp4")
    assert [one.name for one in sources_in(tmp_path / "P1")] == ["a.mp4", "b.mov"]
    assert sources_in(tmp_path / "P2") == (tmp_path / "P2",)
