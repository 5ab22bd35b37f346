"""A zip from anywhere is unpacked whole into its folder, or nothing of it is."""

import stat
import zipfile
from pathlib import Path

import pytest

from limbgram.cases.zips import unpack
from limbgram.core.errors import PhotoError


def zipped(path: Path, files: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return path


def unpacked(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_the_folders_round_all_photos_are_taken_off(tmp_path: Path) -> None:
    files = {
        "Export/P1/a.jpg": b"a",
        "Export/P1/masks/a.jpg.png": b"m",
        "__MACOSX/Export/._a": b"",
        "Export/P1/.DS_Store": b"x",
    }
    found = unpack(zipped(tmp_path / "p.zip", files), tmp_path / "to")
    assert unpacked(found) == {"a.jpg": b"a", "masks/a.jpg.png": b"m"}


def test_what_lay_there_gives_way(tmp_path: Path) -> None:
    to = tmp_path / "to"
    to.mkdir()
    (to / "old.jpg").write_bytes(b"old")
    assert unpacked(unpack(zipped(tmp_path / "p.zip", {"a.jpg": b"a"}), to)) == {"a.jpg": b"a"}


@pytest.mark.parametrize(
    "name", ["../a.jpg", "x/../../a.jpg", "/a.jpg", "..\\a.jpg", "C:a.jpg", "a\x07.jpg", "n" * 300]
)
def test_a_name_that_leaves_the_folder_is_refused_with_the_whole_zip(
    tmp_path: Path, name: str
) -> None:
    source = zipped(tmp_path / "p.zip", {"good.jpg": b"g", name: b"bad"})
    with pytest.raises(PhotoError, match="outside the folder"):
        unpack(source, tmp_path / "deep" / "to")
    assert unpacked(tmp_path) == {"p.zip": source.read_bytes()}


def test_a_link_is_refused(tmp_path: Path) -> None:
    info = zipfile.ZipInfo("a.jpg")
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(tmp_path / "p.zip", "w") as archive:
        archive.writestr(info, "/etc/passwd")
    with pytest.raises(PhotoError, match="link"):
        unpack(tmp_path / "p.zip", tmp_path / "to")


def test_a_bomb_is_refused_before_a_byte_is_written(tmp_path: Path) -> None:
    source = zipped(tmp_path / "p.zip", {"a.jpg": bytes(30_000_000)})
    with pytest.raises(PhotoError, match="30 MB unpacked"):
        unpack(source, tmp_path / "to")
    assert not unpacked(tmp_path / "to")


def test_many_small_files_are_refused(tmp_path: Path) -> None:
    source = zipped(tmp_path / "p.zip", {f"{k}.jpg": b"" for k in range(2001)})
    with pytest.raises(PhotoError, match="2,001 in all"):
        unpack(source, tmp_path / "to")


def test_a_file_larger_than_the_list_says_is_not_written_out(tmp_path: Path) -> None:
    content = bytes(range(256)) * 4000
    source = zipped(tmp_path / "p.zip", {"a.jpg": content})
    data = source.read_bytes()
    source.write_bytes(
        data.replace(len(content).to_bytes(4, "little"), (5000).to_bytes(4, "little"))
    )
    with pytest.raises(PhotoError, match="cannot be unpacked"):
        unpack(source, tmp_path / "to")
    assert sum(map(len, unpacked(tmp_path / "to").values())) <= 5000


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x05\x06" + bytes(10)])
def test_what_is_no_zip_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "p.zip").write_bytes(content)
    with pytest.raises(PhotoError, match="cannot be unpacked"):
        unpack(tmp_path / "p.zip", tmp_path / "to")


def test_a_damaged_or_locked_zip_and_twice_one_name_are_refused(tmp_path: Path) -> None:
    source = zipped(tmp_path / "p.zip", {"a.jpg": bytes(range(256)) * 50})
    data = bytearray(source.read_bytes())
    data[60] ^= 255
    source.write_bytes(bytes(data))
    with pytest.raises(PhotoError, match="cannot be unpacked"):
        unpack(source, tmp_path / "to")
    with pytest.raises(PhotoError, match="twice"):
        unpack(zipped(tmp_path / "q.zip", {"a.jpg": b"a", "A.JPG": b"b"}), tmp_path / "to")
    source = zipped(tmp_path / "r.zip", {"a.jpg": b"a"})
    data = bytearray(source.read_bytes())
    data[6] |= 1
    data[data.index(b"PK\x01\x02") + 8] |= 1
    source.write_bytes(bytes(data))
    with pytest.raises(PhotoError, match="password"):
        unpack(source, tmp_path / "to")
    with pytest.raises(PhotoError, match="no files"):
        unpack(zipped(tmp_path / "s.zip", {".hidden": b"a"}), tmp_path / "to")
