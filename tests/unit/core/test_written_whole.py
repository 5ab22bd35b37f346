"""A file or a folder appears whole and proved, or not at all."""

import errno
import os
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import BinaryIO

import pytest

from limbgram.core.errors import ExportError
from limbgram.core.files import short_name, write_bytes, write_file, write_folder, written_whole


def _nothing_to_check(_path: Path) -> None:
    pass


def test_a_full_disk_leaves_the_old_file_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "surface.stl"
    path.write_bytes(b"old")

    def encode(stream: BinaryIO) -> None:
        stream.write(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(ExportError, match=r"disk of .* is full.*Free some space"):
        write_file(path, encode, _nothing_to_check)
    assert [p.name for p in tmp_path.iterdir()] == ["surface.stl"]
    assert path.read_bytes() == b"old"


def test_bytes_are_kept_only_if_they_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "table.csv"
    assert write_bytes(path, b"whole") == path
    sync = os.fsync

    def spoil(handle: int) -> None:
        sync(handle)
        os.pwrite(handle, b"x", 2)

    monkeypatch.setattr(os, "fsync", spoil)
    with pytest.raises(ExportError, match=r"found table\.csv: other bytes"):
        write_bytes(path, b"later")
    assert [p.name for p in tmp_path.iterdir()] == ["table.csv"]
    assert path.read_bytes() == b"whole"


@pytest.mark.skipif(sys.platform == "win32", reason="needs os.fork")
def test_what_a_killed_process_left_goes_and_what_a_living_one_writes_stays(tmp_path: Path) -> None:
    path, folder = tmp_path / "limb.stl", tmp_path / "colmap"

    def die(_stream: BinaryIO) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    for write in (
        lambda: write_file(path, die, _nothing_to_check),
        lambda: write_folder(folder, {"images.txt": die}, _nothing_to_check),
    ):
        child = os.fork()
        if child == 0:
            write()
        os.waitpid(child, 0)
    assert len(list(tmp_path.iterdir())) == 2
    living = tmp_path / f".{short_name(path)}.{os.getppid()}.part.stl"
    foreign = tmp_path / ".limb.stl.swp"
    for file in (living, foreign):
        file.write_bytes(b"")
    write_bytes(path, b"whole")
    write_folder(folder, {}, _nothing_to_check)
    assert {file.name for file in tmp_path.iterdir()} == {
        "limb.stl",
        "colmap",
        living.name,
        foreign.name,
    }


@pytest.mark.parametrize("name", ["x" * 251 + ".stl", "x" * 255, "x." + "y" * 253])
def test_a_name_may_be_as_long_as_the_disk_allows(tmp_path: Path, name: str) -> None:
    assert write_bytes(tmp_path / name, b"whole").read_bytes() == b"whole"
    with pytest.raises(ExportError, match="name is not too long"):
        write_bytes(tmp_path / f"{name}z", b"whole")
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_gives_way_only_to_a_proved_one(tmp_path: Path) -> None:
    path = tmp_path / "colmap"

    def refuse(_path: Path) -> None:
        raise ExportError("no")

    def encode(content: bytes):
        return lambda stream: stream.write(content)

    write_folder(path, {"a": encode(b"1"), "b": encode(b"2")}, _nothing_to_check)
    with pytest.raises(ExportError):
        write_folder(path, {"a": encode(b"3")}, refuse)
    assert sorted(p.name for p in path.iterdir()) == ["a", "b"]
    write_folder(path, {"a": encode(b"3")}, _nothing_to_check)
    assert [p.name for p in path.iterdir()] == ["a"]
    assert [p.name for p in tmp_path.iterdir()] == ["colmap"]


@pytest.mark.parametrize("killed", [True, False])
def test_a_write_that_ends_between_its_two_renames_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, killed: bool
) -> None:
    folder, replaced = tmp_path / "colmap", Path.replace
    write_folder(folder, {"images.txt": lambda stream: stream.write(b"old")}, _nothing_to_check)

    def end(path: Path, target: Path) -> Path:
        if target != folder:
            return replaced(path, target)
        if killed:
            os.kill(os.getpid(), signal.SIGKILL)
        monkeypatch.undo()
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(Path, "replace", end)
    if killed:
        if (child := os.fork()) == 0:
            write_folder(folder, {}, _nothing_to_check)
        os.waitpid(child, 0)
        monkeypatch.undo()
        assert not folder.exists()
        with pytest.raises(RuntimeError), written_whole(folder):
            raise RuntimeError
    else:
        with pytest.raises(ExportError):
            write_folder(folder, {}, _nothing_to_check)
    assert (folder / "images.txt").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["colmap"]


def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path) -> None:
    file = tmp_path / "x.json"
    file.write_text("old")
    with pytest.raises(RuntimeError), written_whole(file) as beside:  # noqa: PT012
        beside.write_text("ne")
        raise RuntimeError
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]
    with written_whole(file) as beside:
        beside.write_text("new")
    assert file.read_text() == "new"


def test_threads_that_write_the_same_file_do_not_meet(tmp_path: Path) -> None:
    file = tmp_path / "x.json"

    def write(number: int) -> None:
        for _ in range(20):
            with written_whole(file) as beside:
                beside.write_text(f"{number}" * 1000)

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(write, range(4)))
    assert file.read_text() in {f"{number}" * 1000 for number in range(4)}
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]
