"""Photos come into a case unaltered, and what does not belong is moved, never deleted."""

from pathlib import Path

import pytest

from limbgram.cases import folder
from limbgram.cases.folder import CaseFolder, take_in, written_whole
from limbgram.errors import CaseError, PhotoError


@pytest.fixture
def source(tmp_path: Path) -> Path:
    source = tmp_path / "Fotos Ärztin"
    (source / "masks").mkdir(parents=True)
    (source / "other").mkdir()
    for name in ("a 1.jpg", "b.jpg", ".hidden", "masks/b.png", "other/c.jpg"):
        (source / name).write_bytes(name.encode() * 100)
    return source


def names(case: CaseFolder) -> list[str]:
    return sorted(f.relative_to(case.photos).as_posix() for f in case.photos.rglob("*.*"))


def test_files_and_masks_come_in_by_link_or_by_copy(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    linked, copied = CaseFolder(tmp_path / "linked"), CaseFolder(tmp_path / "copied")
    take_in(linked, [source])

    def no_links(*_: object) -> None:
        raise OSError("no links here")

    monkeypatch.setattr(folder.Path, "hardlink_to", no_links)
    take_in(copied, [source])
    for case in (linked, copied):
        assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]
        assert (case.photos / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()
    assert (linked.photos / "b.jpg").samefile(source / "b.jpg")
    assert not (copied.photos / "b.jpg").samefile(source / "b.jpg")
    take_in(copied, [source])  # a second time: nothing to do


def test_photos_that_are_no_longer_wanted_are_moved_aside(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    take_in(case, [source / "a 1.jpg"])
    assert names(case) == ["a 1.jpg"]
    assert (case.left_out / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()
    assert (source / "b.jpg").exists()


def test_the_case_can_be_its_own_source(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    take_in(case, [case.photos])
    assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]


def test_another_file_of_the_same_name_is_refused(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    other = tmp_path / "b.jpg"
    other.write_bytes(b"another")
    with pytest.raises(CaseError, match="another file"):
        take_in(case, [other])
    with pytest.raises(PhotoError, match="same name"):
        take_in(CaseFolder(tmp_path / "new"), [source, other])
    assert (case.photos / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()


def test_a_missing_source_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match="does not exist"):
        take_in(CaseFolder(tmp_path / "case"), [tmp_path / "nowhere"])


def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path) -> None:
    file = tmp_path / "x.json"
    file.write_text("old")
    with pytest.raises(RuntimeError), written_whole(file) as half:  # noqa: PT012
        half.write_text("ne")
        raise RuntimeError
    assert file.read_text() == "old"
    with written_whole(file) as half:
        half.write_text("new")
    assert file.read_text() == "new"
