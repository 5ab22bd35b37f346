"""Check, reconstruction, calibration and app say the same of the same photos, side by side.

Each capture has three good photos and a fault; what must be said of it is known beforehand. The
photos cannot be joined and show no board, so that every door ends where it has read them.
"""

import io
import os
import re
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from limbgram.capture.answer import CaptureCheck
from limbgram.cases.capture_check import CaptureWatch, check_sources
from limbgram.cases.folder import CaseFolder
from limbgram.cases.job import do
from limbgram.cases.job_messages import Job
from limbgram.cases.stage_cache import CachingRun
from limbgram.cases.uploads import Intake
from limbgram.core.errors import CalibrationError, LimbgramError, PhotoError
from limbgram.core.run import Run
from limbgram.findings import Finding, told
from limbgram.reconstruction.calibration.board import calibrate
from limbgram.reconstruction.calibration.cameras import cameras_for
from limbgram.reconstruction.photos.heif import HAS_HEIF
from limbgram.reconstruction.photos.raw import HAS_RAW
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board import Board

BOARD = Board.checkerboard("9x6", 10.0)
Change = Callable[[Path], None]
_LINE = re.compile(r"^  (.+?): (.+)$", re.MULTILINE)


def picture(seed: int, kind: str = "JPEG", size: tuple[int, int] = (160, 120)) -> bytes:
    coarse = np.random.default_rng(seed).integers(0, 256, (9, 12, 3), dtype=np.uint8)
    made = io.BytesIO()
    Image.fromarray(coarse).resize(size, Image.Resampling.BICUBIC).save(made, kind)
    return made.getvalue()


def good(folder: Path) -> None:
    folder.mkdir(parents=True)
    for number in (1, 2, 3):
        (folder / f"IMG_{number}.jpg").write_bytes(picture(number))


def added(name: str, content: bytes) -> Change:
    def change(folder: Path) -> None:
        (folder / name).write_bytes(content)

    return change


def cut(kind: str, ending: str, part: float) -> Change:
    whole = picture(9, kind)
    return added(f"BAD.{ending}", whole[: round(part * len(whole))])


def of_mode(mode: str, name: str, colour: float | tuple[int, ...], size: int = 100) -> Change:
    made = io.BytesIO()
    kind = {"tif": "TIFF", "gif": "GIF"}.get(name.split(".")[-1], "PNG")
    Image.new(mode, (size, size), colour).save(made, kind)
    return added(name, made.getvalue())


def claiming(side_px: int, folder: Path) -> None:
    data = bytearray(picture(9, "PNG"))
    data[16:24] = side_px.to_bytes(4, "big") * 2
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
    (folder / "BAD.png").write_bytes(data)


def second_folder(folder: Path) -> None:
    """Another camera folder, with the same names and other photos."""
    other = folder.with_name("101APPLE")
    other.mkdir()
    for number in (1, 2, 3):
        (other / f"IMG_{number}.jpg").write_bytes(picture(10 + number))


def same_folder_again(folder: Path) -> None:
    other = folder.with_name("101APPLE")
    other.mkdir()
    for file in folder.iterdir():
        (other / file.name).write_bytes(file.read_bytes())


def spoiled_in_both(folder: Path) -> None:
    second_folder(folder)
    (folder.with_name("101APPLE") / "IMG_2.jpg").write_bytes(b"")


@dataclass(frozen=True)
class Spoiled:
    """A fault, and what must be said of which file."""

    change: Change
    left_out: tuple[tuple[str, str], ...] = ()
    """Names, and a part of the reason."""
    photos: int = 3
    """That are left."""
    sent: bool = True
    """Whether a browser can send it."""


CAPTURES = {
    "sound": Spoiled(lambda _: None),
    "cut off in the middle": Spoiled(cut("JPEG", "jpg", 0.5), (("BAD.jpg", "cut off"),)),
    "cut off near the end": Spoiled(cut("JPEG", "jpg", 0.9), (("BAD.jpg", "cut off"),)),
    "a PNG cut off": Spoiled(cut("PNG", "png", 0.5), (("BAD.png", "cut off"),)),
    "a TIFF cut off": Spoiled(cut("TIFF", "tif", 0.5), (("BAD.tif", "copy it again"),)),
    "hardly a beginning": Spoiled(cut("JPEG", "jpg", 0.01), (("BAD.jpg", "cut off"),)),
    "empty": Spoiled(added("BAD.jpg", b""), (("BAD.jpg", "empty"),)),
    "a text": Spoiled(added("BAD.jpg", b"no picture" * 9), (("BAD.jpg", "not a JPEG, PNG"),)),
    "too large": Spoiled(partial(claiming, 13_000), (("BAD.png", "150 megapixels"),)),
    "beyond the decoder": Spoiled(partial(claiming, 60_000), (("BAD.png", "megapixels"),)),
    "of pixels that are not there": Spoiled(
        partial(claiming, 9_000), (("BAD.png", "pixels are not in its"),)
    ),
    "too small": Spoiled(of_mode("RGB", "BAD.png", (9, 9, 9), 16), (("BAD.png", "too small"),)),
    "floating point": Spoiled(of_mode("F", "BAD.tif", 0.5), (("BAD.tif", "floating-point"),)),
    "transparent": Spoiled(
        of_mode("RGBA", "BAD.png", (9, 9, 9, 0)), (("BAD.png", "transparent everywhere"),)
    ),
    "the same photo twice": Spoiled(
        added("IMG_3 (1).jpg", picture(3)), (("IMG_3.jpg", "the same file as IMG_3 (1).jpg"),)
    ),
    "two cards that count alike": Spoiled(second_folder, (), 6, sent=False),
    "one card copied twice": Spoiled(
        same_folder_again,
        tuple(
            (f"101APPLE_IMG_{k}.jpg", f"the same file as 100APPLE_IMG_{k}.jpg") for k in (1, 2, 3)
        ),
        sent=False,
    ),
    "a photo of the second card": Spoiled(
        spoiled_in_both, (("101APPLE_IMG_2.jpg", "empty"),), 5, sent=False
    ),
    "a link that leads nowhere": Spoiled(
        lambda folder: (folder / "BAD.jpg").symlink_to("nowhere.jpg"),
        (("BAD.jpg", "leads nowhere"),),
        sent=False,
    ),
    "a folder called as a photo": Spoiled(
        lambda folder: (folder / "BAD.jpg").mkdir(), (("BAD.jpg", "a folder"),), sent=False
    ),
    "another kind of picture": Spoiled(
        of_mode("P", "BAD.gif", 3), (("BAD.gif", "not a picture"),), sent=False
    ),
    "a film among them": Spoiled(
        added("BAD.mov", b"\0" * 99), (("BAD.mov", "a video"),), sent=False
    ),
    "a mask of another size": Spoiled(
        added("IMG_1.jpg.png", picture(9, "PNG", (90, 80))),
        (("IMG_1.jpg.png", "as mask of IMG_1.jpg: its size"),),
        sent=False,
    ),
}
if not HAS_RAW:
    CAPTURES["a raw file"] = Spoiled(
        added("BAD.dng", picture(9, "TIFF")), (("BAD.dng", "raw"),), sent=False
    )
if not HAS_HEIF:
    CAPTURES["a photo of a phone"] = Spoiled(
        added("BAD.heic", b"\0\0\0\x18ftypheic" + b"\0" * 99), (("BAD.heic", "HEI"),)
    )


def said_in(message: str) -> dict[str, str]:
    """What a refusal says of files, one a line."""
    return dict(_LINE.findall(message))


def by_check(sources: Sequence[Path], _: Path) -> dict[str, str]:
    return told_by(check_sources(sources, (), None, Run()))


def by_watch(sources: Sequence[Path], _: Path) -> dict[str, str]:
    with CaptureWatch((), None) as watch:
        watch.check(sources)
        return told_by(watch.check(sources))  # what is known already is told all the same


def told_by(found: CaptureCheck) -> dict[str, str]:
    for one in found.set_aside:
        assert f"{one.name} is left out: {told(one.reason)}." in map(told, found.notes)
    return {one.name: told(one.reason) for one in found.set_aside}


def by_reconstruction(sources: Sequence[Path], scratch: Path) -> dict[str, str]:
    case = CaseFolder(scratch / "case")
    job = Job(case=case.root, sources=tuple(sources), unscaled=True)
    with pytest.raises(LimbgramError) as refusal:
        do(job, CachingRun(case=case))
    assert not isinstance(refusal.value, PhotoError)
    return said_in(str(refusal.value))


def by_calibration(sources: Sequence[Path], _: Path) -> dict[str, str]:
    with pytest.raises(CalibrationError) as refusal:
        calibrate(read_photos(sources), BOARD)
    return said_in(str(refusal.value))


def by_app(sources: Sequence[Path], scratch: Path) -> dict[str, str]:
    """Sent file by file; the coach of the app reads what came."""
    intake = Intake(scratch / "received", b"key")
    problems: dict[str, Finding | None] = {}
    for file in sorted(sources[0].iterdir()):
        with intake.begin(file.name, 0, None) as piece:
            piece.write(file.read_bytes())
            piece.close()
            problems[file.name] = intake.finish(file.name)[0].problem
    received = [intake.folder / one.name for one in intake.received()]
    watched = by_watch(received, scratch)
    for name, problem in problems.items():
        if problem:
            assert told(problem) == f"It cannot be used: {watched[name]}."
        else:  # alone it is good
            assert watched.get(name, "the same file as").startswith("the same file as")
    return watched


@pytest.mark.parametrize("fault", CAPTURES)
def test_all_doors_say_the_same_of_a_spoiled_capture(fault: str, tmp_path: Path) -> None:
    spoiled, folder = CAPTURES[fault], tmp_path / "100APPLE"
    good(folder)
    spoiled.change(folder)
    sources = [one for one in (folder, tmp_path / "101APPLE") if one.is_dir()]
    doors = {"check": by_check, "watch": by_watch}
    doors |= {"reconstruct": by_reconstruction, "calibrate": by_calibration}
    doors |= {"app": by_app} if spoiled.sent else {}
    read = read_photos(sources)
    assert len(read.photos) == spoiled.photos
    assert [one.name for one in read.set_aside] == [name for name, _ in spoiled.left_out]
    assert all(part in told(one.reason) for one, (_, part) in zip(read.set_aside, spoiled.left_out))
    for door, says in doors.items():
        heard = says(sources, tmp_path)
        assert heard == {one.name: told(one.reason) for one in read.set_aside}, door
    assert read_photos([tmp_path / "case" / "photos"]).names == read.names


def test_the_check_tells_the_size_of_the_photos_and_not_of_its_copies(tmp_path: Path) -> None:
    for number in range(2):
        photo = picture(number, size=(1600, 1200))
        (tmp_path / f"{number}.jpg").write_bytes(photo)
    photos = read_photos([tmp_path])
    (fitting,) = cameras_for(photos, ()).calibrations
    other = replace(fitting, camera=replace(fitting.camera, width_px=1440, height_px=1080))
    with pytest.raises(CalibrationError, match="1440 x 1080, the photos are 1600 x 1200") as said:
        cameras_for(photos, [other])
    found = check_sources([tmp_path], [other], None, Run())
    assert found.findings == (said.value.finding,)
    (first, *_) = check_sources([tmp_path], [fitting], None, Run()).findings
    assert first.code != "lens.none_fits"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all")
def test_a_photo_without_permission_is_told(tmp_path: Path) -> None:
    good(tmp_path / "a")
    (tmp_path / "a" / "IMG_2.jpg").chmod(0)
    for says in (by_check, by_watch, by_reconstruction, by_calibration):
        assert says([tmp_path / "a"], tmp_path) == {"IMG_2.jpg": "no permission to read it"}


MARKERS = "4X4_50"


def board_photos(folder: Path, columns: int, rows: int, legacy: bool, mirrored: bool) -> None:
    """Four photos of a print that OpenCV itself draws, as it did before 4.6 where that is asked."""
    kind = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    printed = cv2.aruco.CharucoBoard((columns, rows), 30.0, 22.0, kind)
    printed.setLegacyPattern(legacy)
    flat = np.pad(printed.generateImage((40 * columns, 40 * rows)), 27, constant_values=255)
    high, wide = flat.shape
    corners = np.array([[0, 0], [wide, 0], [wide, high], [0, high]], np.float32)
    for k, (dx, dy) in enumerate(((0, 0), (40, 13), (-33, 27), (13, -40))):
        ends = [[100 + dx, 80], [520, 93 + dy], [533 - dx, 400], [80, 413 - dy]]
        seen = cv2.getPerspectiveTransform(corners, np.array(ends, np.float32) * 0.6)
        grey = cv2.warpPerspective(flat, seen, (384, 288), borderValue=(180,))
        grey = cv2.GaussianBlur(grey, (0, 0), 0.8)
        cv2.imwrite(str(folder / f"{k}.png"), grey[:, ::-1] if mirrored else grey)


LEGACY = "as on a board of 8 x 6 squares, legacy pattern (of OpenCV before 4.6); "


@pytest.mark.parametrize(
    ("given", "mirrored", "said"),
    [
        pytest.param("8x6", False, "", marks=pytest.mark.slow, id="legacy print"),
        pytest.param("6x8", False, f"{LEGACY}6 x 8 was given", marks=pytest.mark.slow, id="turned"),
        pytest.param("9x7", False, f"{LEGACY}9 x 7 was given", marks=pytest.mark.slow, id="other"),
        pytest.param("8x6", True, "mirrored: 4 of them", marks=pytest.mark.slow, id="mirrored"),
    ],
)
def test_all_doors_say_the_same_of_a_board(
    given: str, mirrored: bool, said: str, tmp_path: Path
) -> None:
    """A board of 8 x 6 squares in the pattern from before OpenCV 4.6, whatever was given."""
    board = Board.charuco(given, 30.0, 22.0, MARKERS)
    folder = tmp_path / "photos"
    folder.mkdir()
    board_photos(folder, 8, 6, legacy=True, mirrored=mirrored)
    checked = check_sources([folder], (), board, Run())
    with CaptureWatch((), board) as watch:
        watched = watch.check([folder])
    with pytest.raises(CalibrationError) as calibration:
        calibrate(read_photos([folder]), board)
    case = CaseFolder(tmp_path / "case")
    with pytest.raises(LimbgramError) as reconstruction:
        do(Job(case=case.root, sources=(folder,), board=board), CachingRun(case=case))
    by_coach = told(checked.findings[0])
    assert told(watched.findings[0]) == by_coach
    assert str(reconstruction.value) == by_coach
    for door in (by_coach, str(calibration.value)):
        if said:
            assert said in door
        else:  # it is read: what they miss in four photos is of other kinds
            assert "lie as on a board" not in door
            assert "mirrored" not in door
            assert "0 photos show" not in door
