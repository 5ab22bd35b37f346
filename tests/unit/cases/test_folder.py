"""Photos come into a case as copies, others stay out, and what is refused says what to do."""

import errno
import os
import sys
from pathlib import Path

import pytest

from limbgram.cases import folder
from limbgram.cases.folder import CaseFolder, require_apart, sweep, take_in, with_disk_advice
from limbgram.core.errors import CaseError, PhotoError
from limbgram.core.files import written_whole
from limbgram.findings import told


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


def test_files_and_masks_come_in_as_copies(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    assert take_in(case, [source]) == ()
    assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]
    received = (source / "b.jpg").read_bytes()
    assert (case.photos / "b.jpg").read_bytes() == received
    with (source / "b.jpg").open("r+b") as file:  # in place, as some programs save
        file.write(b"altered")
    assert (case.photos / "b.jpg").read_bytes() == received
    (source / "b.jpg").write_bytes(received)
    take_in(case, [source])  # a second time: nothing to do
    assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]


def test_masks_of_a_folder_take_the_place_of_those_beside_the_photos(
    source: Path, tmp_path: Path
) -> None:
    """And they may be corrected and given again, which photos may not."""
    case, masks = CaseFolder(tmp_path / "case"), tmp_path / "corrected"
    take_in(case, [source])
    masks.mkdir()
    for name in ("a 1.jpg.png", "b.png", "stranger.png", "at-a-glance.jpg"):
        (masks / name).write_bytes(b"corrected")
    for content in (b"corrected", b"corrected again"):
        (masks / "b.png").write_bytes(content)
        take_in(case, [source], masks)
        assert names(case) == ["a 1.jpg", "b.jpg", "masks/a 1.jpg.png", "masks/b.png"]
        assert (case.photos / "masks" / "b.png").read_bytes() == content
    take_in(case, [source], source / "masks")
    assert (case.photos / "masks" / "b.png").read_bytes() == b"masks/b.png" * 100


def test_a_folder_without_a_mask_of_any_photo_is_refused(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    (tmp_path / "corrected").mkdir()
    (tmp_path / "corrected" / "c.png").write_bytes(b"of no photo")
    with pytest.raises(PhotoError, match=r"The mask of a 1\.jpg is called a 1\.png"):
        take_in(case, [source], tmp_path / "corrected")
    with pytest.raises(PhotoError, match="is no folder of masks"):
        take_in(case, [source], tmp_path / "nowhere")


def test_a_hard_link_of_an_earlier_version_becomes_a_copy(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    case.photos.mkdir(parents=True)
    (case.photos / "b.jpg").hardlink_to(source / "b.jpg")
    take_in(case, [source])
    assert not (case.photos / "b.jpg").samefile(source / "b.jpg")
    assert (case.photos / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()


def test_a_copy_that_is_not_the_same_is_refused(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = CaseFolder(tmp_path / "case")
    monkeypatch.setattr(folder, "_copy", lambda _source, to: to.write_bytes(b"failing disk"))
    with pytest.raises(CaseError, match=r"copy of .*a 1\.jpg .* not the same"):
        take_in(case, [source])
    assert names(case) == []
    assert list(case.photos.glob(".*")) == []


def test_the_disk_may_share_the_bytes(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fcntl = pytest.importorskip("fcntl")
    if sys.platform != "linux":
        pytest.skip("asked for on Linux only")
    asked: list[tuple[int, int]] = []

    def share(writer: object, request: int, reader: int) -> None:
        asked.append((request, reader))
        os.write(writer.fileno(), os.read(reader, 10_000))  # type: ignore[attr-defined]

    monkeypatch.setattr(fcntl, "ioctl", share)
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    assert len(asked) == 3
    assert {request for request, _ in asked} == {0x40049409}
    assert (case.photos / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()


def test_ten_thousand_other_files_stay_out_and_are_summed_up(source: Path, tmp_path: Path) -> None:
    for number in range(10_000):
        (source / f"note {number:05}.txt").touch()
    (source / "without ending").write_bytes(b"\xff\xd8\xff and so on")
    (source / "film.mov").write_bytes(b"\0\0\0\x14ftypqt  ")
    case = CaseFolder(tmp_path / "case")
    (left_out,) = take_in(case, [source])
    assert left_out.name == "film.mov ..."
    assert told(left_out.reason).startswith("not pictures: film.mov, note 00000.txt, ")
    assert told(left_out.reason).endswith(" and so on, 10,001 in all")
    assert told(left_out.reason, "de").endswith(" und so weiter, 10.001 insgesamt")
    assert len(told(left_out.reason)) < 200
    kept = sorted(file.name for file in case.photos.rglob("*") if file.is_file())
    assert kept == ["a 1.jpg", "b.jpg", "b.png", "without ending"]


def test_what_cannot_be_read_is_set_aside_by_name(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (source / "folder.jpg").mkdir()
    (source / "lost.jpg").symlink_to(tmp_path / "nowhere")
    (source / "circle.jpg").symlink_to(source / "circle.jpg")
    (source / "red\x1b[31m.jpg").write_bytes(b"name")
    (source / "two\nlines.jpg").write_bytes(b"name")
    for name in ("locked.jpg", "scratched.jpg"):
        (source / name).write_bytes(b"unreadable")
    if hasattr(os, "mkfifo"):
        os.mkfifo(source / "pipe.jpg")
    plain = folder.file_sha256

    def unreadable(path: Path) -> str:
        if path.name == "locked.jpg":
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        if path.name == "scratched.jpg":
            raise OSError(errno.EIO, "Input/output error", str(path))
        return plain(path)

    monkeypatch.setattr(folder, "file_sha256", unreadable)
    case = CaseFolder(tmp_path / "case")
    set_aside = take_in(case, [source])
    assert all(one.reason.code.startswith("photo.file.") for one in set_aside)  # in every language
    reasons = {one.name: told(one.reason) for one in set_aside}
    expected = {
        "folder.jpg": "a folder",
        "lost.jpg": "leads nowhere",
        "circle.jpg": "leads nowhere",
        "red\\x1b[31m.jpg": "rename it",
        "two\\nlines.jpg": "rename it",
        "locked.jpg": "no permission",
        "scratched.jpg": "Input/output error): copy it again",
    } | ({"pipe.jpg": "not a file"} if hasattr(os, "mkfifo") else {})
    assert reasons.keys() == expected.keys()
    for name, part in expected.items():
        assert part in reasons[name], name
    assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]


@pytest.mark.parametrize("length", [245, 250, 251, 252, 253, 254, 255])
def test_a_name_may_be_as_long_as_the_disk_allows(tmp_path: Path, length: int) -> None:
    source = tmp_path / "photos"
    source.mkdir()
    photo = source / ("x" * (length - 4) + ".jpg")
    photo.write_bytes(b"photo")
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    assert (case.photos / photo.name).read_bytes() == b"photo"
    with written_whole(tmp_path / photo.name) as beside:
        beside.write_bytes(b"whole")
    assert (tmp_path / photo.name).read_bytes() == b"whole"


def test_a_folder_without_photos_is_refused(tmp_path: Path) -> None:
    empty, deep, other = (tmp_path / name for name in ("empty", "deep", "other"))
    for place in (empty, deep / "left leg", other):
        place.mkdir(parents=True)
    (other / "letter.docx").write_bytes(b"PK")
    case = CaseFolder(tmp_path / "case")
    with pytest.raises(PhotoError, match=r"no photos in .*empty\. Name the folder"):
        take_in(case, [empty])
    with pytest.raises(PhotoError, match=r"holds folders \(left leg\)\. Name the folder"):
        take_in(case, [deep])
    with pytest.raises(PhotoError, match=r"Left out:\n  letter\.docx: not a picture"):
        take_in(case, [other])


def test_the_case_is_not_the_photos_own_folder(source: Path, tmp_path: Path) -> None:
    before = sorted(source.rglob("*"))
    link = tmp_path / "link"
    link.symlink_to(source)
    for root in (source, link, source / "masks", source / "other" / ".."):
        with pytest.raises(CaseError, match="folder of the photos itself"):
            take_in(CaseFolder(root), [source])
    (tmp_path / "walk" / "photos").mkdir(parents=True)
    (tmp_path / "walk" / "photos" / "a.jpg").write_bytes(b"photo")
    with pytest.raises(CaseError, match="its own copies"):
        take_in(CaseFolder(tmp_path / "walk"), [tmp_path / "walk" / "photos"])
    assert sorted(source.rglob("*")) == before
    require_apart(CaseFolder(source / "case"), [source])  # sub-folders are not searched


def test_photos_that_are_no_longer_wanted_are_moved_aside(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    take_in(case, [source / "a 1.jpg"])
    assert names(case) == ["a 1.jpg"]
    assert (case.left_out / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()
    assert (source / "b.jpg").exists()


def test_a_photo_moved_aside_takes_no_other_one_s_place(tmp_path: Path) -> None:
    """Two walks whose photos are numbered alike: each is left out in turn."""
    case = CaseFolder(tmp_path / "case")
    kept = tmp_path / "kept.jpg"
    kept.write_bytes(b"kept")
    for walk in ("first", "second", "third", "second"):
        (tmp_path / walk).mkdir(exist_ok=True)
        (tmp_path / walk / "1.jpg").write_bytes(walk.encode())
        take_in(case, [kept, tmp_path / walk / "1.jpg"])
        take_in(case, [kept])
    aside = {file.name: file.read_bytes() for file in case.left_out.iterdir()}
    assert aside == {"1.jpg": b"first", "1-2.jpg": b"second", "1-3.jpg": b"third"}


def test_the_case_can_be_its_own_source(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    case.record.write_text("{}")
    take_in(case, [case.photos])
    assert names(case) == ["a 1.jpg", "b.jpg", "masks/b.png"]


def test_another_file_of_the_same_name_is_refused(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source])
    other = tmp_path / "b.jpg"
    other.write_bytes(b"another")
    with pytest.raises(CaseError, match="another file"):
        take_in(case, [other])
    assert (case.photos / "b.jpg").read_bytes() == (source / "b.jpg").read_bytes()


def test_photos_of_one_name_come_in_with_their_folders_and_their_masks(tmp_path: Path) -> None:
    for side in ("left", "right"):
        for name in ("1.jpg", "2.png", "masks/1.png", "masks/2.png.png"):
            (tmp_path / side / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / side / name).write_bytes(f"{side} {name}".encode())
    case = CaseFolder(tmp_path / "case")
    assert take_in(case, [tmp_path / "left", tmp_path / "right"]) == ()
    assert names(case) == [
        "left_1.jpg", "left_2.png", "masks/left_1.png", "masks/left_2.png.png",
        "masks/right_1.png", "masks/right_2.png.png", "right_1.jpg", "right_2.png",
    ]  # fmt: skip
    assert (case.photos / "right_1.jpg").read_bytes() == b"right 1.jpg"
    assert (case.photos / "masks" / "right_1.png").read_bytes() == b"right masks/1.png"
    masks = tmp_path / "corrected"
    masks.mkdir()
    (masks / "left_1.png").write_bytes(b"corrected")
    take_in(case, [tmp_path / "left", tmp_path / "right"], masks)
    assert (case.photos / "masks" / "left_1.png").read_bytes() == b"corrected"
    assert not (case.photos / "masks" / "right_1.png").exists()


def test_a_photo_named_by_itself_brings_its_mask(source: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    take_in(case, [source / "b.jpg"])
    assert names(case) == ["b.jpg", "masks/b.png"]


def test_a_missing_source_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PhotoError, match="does not exist"):
        take_in(CaseFolder(tmp_path / "case"), [tmp_path / "nowhere"])


def test_what_killed_runs_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    left = (
        ".0123456789abcdef.half",
        ".0123456789abcdef.123.part.json",
        ".0123456789abcdef.123.part",
        ".case.json.half",
        "photos/.a.jpg.half",
        "photos/masks/.0123456789abcdef.half",
        "stages/.measure.half/arrays.npz",
        "stages/.0123456789abcdef.123.part/arrays.npz",
        "stages/.0123456789abcdef.123.old/arrays.npz",
        "deliverables/.surface.123.part.stl",
        "deliverables/.0123456789abcdef.123.part.dxf",
        "deliverables/.colmap.123.old/images.txt",
        "report/.map.png.half",
        "frames/.0123456789abcdef.123.part/frames.json",
        "frames/.walk.part/photos/walk-000001.jpg",
    )
    kept = (
        ".lock",
        ".bashrc.old",
        ".x.half",
        ".x.123.part",
        "photos/a.jpg",
        "stages/measure/arrays.npz",
    )
    for name in (*left, *kept):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    sweep(case)
    files = {file.relative_to(tmp_path).as_posix() for file in tmp_path.rglob("*")}
    assert {name for name in files if (tmp_path / name).is_file()} == set(kept)
    assert not any(".half" in name or ".123." in name for name in files - set(kept))


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (errno.ENOSPC, "is full .* continues"),
        (errno.EDQUOT, "is full .* continues"),
        (errno.EACCES, "may not be read or written by you. Change its permissions"),
        (errno.EROFS, "may only be read. Use a folder on another disk"),
        (errno.ENOENT, "is not there: .* Put it back"),
        (errno.EISDIR, "is in the way: .* Move it elsewhere"),
        (errno.ENAMETOOLONG, "too long for its disk. Shorten it"),
        (errno.ELOOP, "leads round in a circle"),
        (errno.EMFILE, "no means left .* Close other programs"),
        (errno.EIO, "probably failing: use another disk"),
        (errno.ESTALE, "probably failing: use another disk"),
    ],
)
def test_what_the_system_says_becomes_advice(tmp_path: Path, number: int, told: str) -> None:
    with pytest.raises(CaseError, match=told) as caught, with_disk_advice(CaseFolder(tmp_path)):
        raise OSError(number, os.strerror(number), str(tmp_path / "surface.stl"))
    assert "run the same command again" in str(caught.value)
    if number not in (errno.ENOSPC, errno.EDQUOT):
        assert "surface.stl" in str(caught.value)


def test_a_fault_of_ours_stays_one(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="cut off"), with_disk_advice(CaseFolder(tmp_path)):
        raise OSError("image file is cut off")


def test_a_photo_that_was_replaced_where_the_case_received_it_is_computed(tmp_path: Path) -> None:
    """As in the app, where a blurred photo gives way to another one of its name."""
    case = CaseFolder(tmp_path / "case")
    received = case.root / "received"
    received.mkdir(parents=True)
    for content in (b"blurred", b"sharp"):
        (received / "1.jpg").write_bytes(content)
        take_in(case, [received / "1.jpg"])
        assert (case.photos / "1.jpg").read_bytes() == content
    assert (case.left_out / "1.jpg").read_bytes() == b"blurred"
