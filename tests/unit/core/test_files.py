"""Files that people name: never opened without end, and never taken for what they are not."""

import errno
import os
import pickle
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import (
    CaseError,
    LimbgramError,
    OptionsError,
    ShapeFileError,
    disk_finding,
)
from limbgram.core.files import ContentError, file_lock, json_of, read_content, toml_of
from limbgram.findings import Finding, told
from limbgram.formats.camera import read_camera
from limbgram.formats.reading import read_limb
from limbgram.services.parse_capture import read_distances
from limbgram.services.parse_text import landmarks_of
from limbgram.workbench.recipe.file import parse_recipe, read_recipe
from limbgram.workbench.templates.files import read_template

HUGE = "1" + "0" * 400
NONSENSE = {
    "a number without end": f'{{"a": {HUGE}}}',
    "a number of 5,000 digits": f'{{"a": {"7" * 5000}}}',
    "beyond floating point": '{"a": 1e400}',
    "a word of Python's": '{"a": NaN}',
    "half a letter": '{"a": "\\ud800"}',
    "twice": '{"a": 1, "a": 2}',
    "deep": "[" * 6000 + "]" * 6000,
    "deep, but not too deep for Python": "[" * 200 + "]" * 200,
}


@pytest.mark.parametrize("text", NONSENSE.values(), ids=NONSENSE.keys())
def test_json_is_taken_strictly(text: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        json_of(text.encode())


def test_toml_of_a_file_is_text_in_utf_8_with_or_without_its_mark() -> None:
    for coding in ("utf-8", "utf-8-sig"):
        assert toml_of('name = "Höhe"'.encode(coding)) == {"name": "Höhe"}
    with pytest.raises(ContentError) as refused:
        toml_of('name = "Höhe"'.encode("latin-1"))
    assert refused.value.finding.code == "file.no_text"


def test_json_of_any_coding_is_read() -> None:
    tree = {"name": "Höhe", "mm": [1, 2.5, -3e-4, None, True]}
    text = '{"name": "Höhe", "mm": [1, 2.5, -3e-4, null, true]}'
    for coding in ("utf-8", "utf-8-sig", "utf-16"):
        assert json_of(text.encode(coding)) == tree


@pytest.mark.parametrize(
    "line",
    [
        f"passes = {HUGE}",
        f"passes = {'7' * 5000}",
        f"passes = 0x{'f' * 5000}",
        f"leave = {'[' * 6000}{']' * 6000}",
        f"{'a.' * 6000}a = 1",
        f"{'a.' * 100}a = 1",
    ],
    ids=["large", "digits", "hexadecimal", "deep", "key", "short key"],
)
def test_a_recipe_without_end_is_refused(tmp_path: Path, line: str) -> None:
    text = f'format = "limbgram recipe"\nversion = 1\n\n[[edit]]\ndo = "smoothing"\n{line}\n'
    with pytest.raises(ShapeFileError, match=r"a\.toml"):
        parse_recipe(text, "a.toml")
    with pytest.raises(ValueError, match=r"\w"):
        toml_of(line)
    done = CliRunner().invoke(app, ["edit", "add", str(tmp_path / "a.toml"), "smoothing", line])
    assert done.exit_code in (2, 3), done.exception


READERS = {
    "shape": (lambda path: read_limb(path), ".stl", ShapeFileError),
    "recipe": (read_recipe, ".toml", ShapeFileError),
    "template": (read_template, ".json", ShapeFileError),
    "camera": (read_camera, ".json", CaseError),
    "distances": (read_distances, ".json", OptionsError),
}


@pytest.mark.parametrize("reader", READERS)
def test_what_has_no_end_is_not_read(tmp_path: Path, reader: str) -> None:
    """A pipe would keep the reader waiting, a device would fill the memory."""
    read, ending, refusal = READERS[reader]
    pipe = tmp_path / f"pipe{ending}"
    os.mkfifo(pipe)
    zeros = tmp_path / f"zeros{ending}"
    zeros.symlink_to("/dev/zero")
    folder = tmp_path / f"folder{ending}"
    folder.mkdir()
    for path, kind in ((pipe, "device or pipe"), (zeros, "device or pipe"), (folder, "folder")):
        with pytest.raises(refusal, match=kind):
            read(path)
    with pytest.raises(refusal, match="cannot be read"):
        read(tmp_path / f"nowhere{ending}")


def test_why_a_file_cannot_be_read_is_told_in_both_languages(tmp_path: Path) -> None:
    with pytest.raises(ShapeFileError) as refused:
        read_limb(tmp_path / "nowhere.stl")
    found = refused.value.finding
    assert found.code == "file.unread"
    assert isinstance(why := found.values["why"], Finding)
    assert (why.code, why.values["error"]) == ("disk.said", "ENOENT")
    assert told(found).startswith(f"{tmp_path / 'nowhere.stl'} cannot be read: No such file")
    assert "Datei oder Ordner nicht gefunden. Die Datei angeben" in told(found, "de")


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (errno.ENOSPC, "disk.full"),
        (errno.EACCES, "disk.not_yours"),
        (errno.EROFS, "disk.read_only"),
        (errno.ENOENT, "disk.not_there"),
        (errno.EISDIR, "disk.in_the_way"),
        (errno.ENAMETOOLONG, "disk.long_name"),
        (errno.ELOOP, "disk.loop"),
        (errno.EMFILE, "disk.no_means"),
        (errno.EIO, "disk.failing"),
    ],
)
def test_what_a_disk_says_becomes_a_finding(number: int, code: str) -> None:
    error = OSError(number, os.strerror(number), "photo.jpg")
    found = disk_finding(error)
    assert (found.code, found.values["name"]) == (code, "photo.jpg")
    nameless = disk_finding(OSError(number, os.strerror(number)))
    assert "a file" in told(nameless)
    assert "Datei" in told(nameless, "de")


def test_what_no_file_may_hold_is_refused_by_its_code() -> None:
    for text, code in (
        ("[" * 100 + "]" * 100, "file.tree.deep"),
        ("[NaN]", "file.json.no_number"),
        ("[1e999]", "file.tree.no_value"),
        ("[90071992547409920]", "file.tree.large_number"),
        ('{"a": 1, "a": 2}', "file.json.twice"),
    ):
        with pytest.raises(ContentError) as refused:
            json_of(text.encode())
        assert refused.value.finding.code == code
        again = pickle.loads(pickle.dumps(refused.value))
        assert isinstance(again, ContentError)
        assert again.finding == refused.value.finding


def test_a_file_is_read_up_to_its_bound_and_not_beyond(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(1000))
    assert read_content(path, 1000, OptionsError) == bytes(1000)
    with pytest.raises(OptionsError, match="too large"):
        read_content(path, 999, OptionsError)
    with pytest.raises(LimbgramError, match="cannot be read"):
        read_content(Path("a\0b"), 10, LimbgramError)


def test_a_seed_is_a_number_from_0(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["make-capture", str(tmp_path / "new"), "--seed", "-5"])
    assert done.exit_code == 2
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("number", ["inf", "-inf", "nan", "1e400", "1e308", "1e-308"])
@pytest.mark.parametrize(
    "words",
    [
        ("measure", "--every="),
        ("measure", "--height="),
        ("measure", "--sock="),
        ("align", "--side=right", "--flexion="),
        ("align", "--side=right", "--axis=0,0,"),
        ("export", "--to=gcode", "--side=right", "--blank="),
        ("export", "--to=gcode", "--side=right", "--blank-length="),
        ("export", "--to=aop", "--side=right", "--spacing="),
        ("report", "--every="),
    ],
    ids=" ".join,
)
def test_a_number_that_measures_nothing_is_refused(
    tmp_path: Path, words: tuple[str, ...], number: str
) -> None:
    """typer takes them all for numbers; divisions and lists without end followed."""
    scan = tmp_path / "scan.stl"
    box = trimesh.creation.box((80.0, 80.0, 120.0))
    trimesh.Trimesh(box.vertices, box.faces[:-2]).export(scan)
    command, *rest, last = words
    done = CliRunner().invoke(app, [command, str(scan), *rest, last + number])
    assert done.exit_code == 2, (done.output, done.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["scan.stl"]


@pytest.mark.parametrize("number", ["0", "3", "7" * 5000, "²", "-1", ""])
def test_a_marks_number_is_one_of_those_seen(number: str) -> None:
    with pytest.raises(OptionsError, match="names no mark"):
        landmarks_of([f"fibula head=#{number}"], [np.zeros(3), np.ones(3)])
    (found,) = landmarks_of(["fibula head=#2"], [np.zeros(3), np.ones(3)])
    np.testing.assert_array_equal(found.position_mm, np.ones(3))


def test_a_lock_is_waited_for_on_windows_however_long_another_holds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There a waiting lock gives up after ten seconds with EDEADLOCK."""
    tried: list[int] = []

    def locking(_handle: int, mode: int, _count: int) -> None:
        tried.append(mode)
        if len(tried) < 3:
            raise OSError(errno.EDEADLOCK, "Resource deadlock avoided")

    windows = SimpleNamespace(locking=locking, LK_LOCK=1, LK_NBLCK=2)
    monkeypatch.setitem(sys.modules, "msvcrt", windows)
    monkeypatch.setattr(sys, "platform", "win32")
    with file_lock(tmp_path / "a", wait=True) as held:
        assert held
    assert tried == [1, 1, 1]
    tried.clear()
    with file_lock(tmp_path / "a", wait=False) as held:
        assert not held
    assert tried == [2]
