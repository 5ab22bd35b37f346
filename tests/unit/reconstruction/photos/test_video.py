"""Frames of a video: spread by how far the picture moved, sharp, upright for people.

The film is a window that slides over a large texture, so that its way is known exactly.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.errors import Cancelled, PhotoError
from limbgram.core.geometry.arrays import ColourImage
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.reconstruction.photos.video import (
    FrameChoice,
    FrameOptions,
    FrameVerdict,
    Survey,
    choose_frames,
    open_video,
    survey,
)

WIDTH_PX, HEIGHT_PX = 320, 240


@dataclass(frozen=True)
class Film:
    path: Path
    way: np.ndarray
    """True way of the picture at every frame, in its own widths."""


def texture(rows: int, columns: int) -> ColourImage:
    chance = np.random.default_rng(3)
    grain = chance.integers(0, 256, (rows // 8, columns // 8, 3), dtype=np.uint8)
    squares = cv2.resize(grain, (columns, rows), interpolation=cv2.INTER_NEAREST)
    return cv2.GaussianBlur(squares, (0, 0), 0.8)


def film(
    path: Path,
    speeds_px: list[float],
    codec: str = "MJPG",
    blurred: tuple[int, ...] = (),
    tremble_px: float = 0.0,
) -> Film:
    """A film with this speed, pixels a frame, at each of its frames."""
    x_px = np.cumsum(speeds_px)
    ground = texture(HEIGHT_PX + 40, int(x_px[-1]) + WIDTH_PX + 60)
    chance = np.random.default_rng(4)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 30, (WIDTH_PX, HEIGHT_PX))
    assert writer.isOpened()
    for number, x in enumerate(x_px):
        dx, dy = chance.normal(0, tremble_px, 2) if tremble_px else (0.0, 0.0)
        shift = np.array([[1.0, 0, -20 - x - dx], [0, 1, -20 - dy]])
        frame = cv2.warpAffine(ground, shift, (WIDTH_PX, HEIGHT_PX))
        if number in blurred:
            frame = cv2.blur(frame, (15, 1))
        writer.write(frame)
    writer.release()
    return Film(path, x_px / WIDTH_PX)


def chosen(path: Path, options: FrameOptions) -> tuple[FrameChoice, list[ColourImage]]:
    pixels: list[ColourImage] = []

    def keep(verdict: FrameVerdict, frame: ColourImage) -> None:
        assert verdict.taken
        pixels.append(frame)

    choice = choose_frames(survey(open_video(path)), keep, options)
    assert len(pixels) == len(choice.taken)
    return choice, pixels


UNEVEN = [4.0] * 30 + [0.0] * 25 + [12.0] * 15 + [1.0] * 60
"""A walk, a rest, a run, a creep."""


@pytest.mark.parametrize(
    ("codec", "ending"),
    [
        pytest.param("MJPG", "avi", marks=pytest.mark.slow),
        ("mp4v", "mp4"),
        pytest.param("MJPG", "mov", marks=pytest.mark.slow),
    ],
)
def test_frames_are_spread_by_way_not_by_time(tmp_path: Path, codec: str, ending: str) -> None:
    made = film(tmp_path / f"walk.{ending}", UNEVEN, codec, tremble_px=0.5)
    choice, pixels = chosen(made.path, FrameOptions(count=6))
    assert len(choice.frames) == len(UNEVEN)
    found = np.array([frame.way for frame in choice.frames])
    assert abs(found[-1] / made.way[-1] - 1) < 0.03
    gaps = np.diff([made.way[frame.number] for frame in choice.taken])
    assert len(choice.taken) == 6
    step = made.way[-1] / 6
    assert 0.35 * step < gaps.min() <= gaps.max() < 1.65 * step
    in_rest = [frame.number for frame in choice.taken if 30 <= frame.number < 55]
    assert len(in_rest) <= 1
    assert all(frame.shape == (HEIGHT_PX, WIDTH_PX, 3) for frame in pixels)
    assert all(frame.reason for frame in choice.frames)


def test_blurred_frames_are_passed_over_with_their_reason(tmp_path: Path) -> None:
    speeds = [4.0] * 100
    blurred = tuple(k for k in range(100) if k % 10 < 7 or 40 <= k < 70)
    made = film(tmp_path / "walk.avi", speeds, blurred=blurred)
    choice, _ = chosen(made.path, FrameOptions(count=5))
    assert not {frame.number for frame in choice.taken} & set(blurred)
    assert 3 <= len(choice.taken) <= 4  # one part or two hold nothing but blurred ones
    reasons = [told(frame.reason) for frame in choice.frames if 40 <= frame.number < 70]
    assert any(reason.startswith("blurred, and so are") for reason in reasons)
    assert any("less sharp than frame" in told(frame.reason) for frame in choice.frames)


def test_no_part_goes_empty_where_the_camera_hurries(tmp_path: Path) -> None:
    made = film(tmp_path / "walk.avi", [2.0] * 30 + [16.0] * 12 + [2.0] * 30)
    choice, _ = chosen(made.path, FrameOptions(count=26))
    hurried = [frame.number for frame in choice.taken if 30 <= frame.number < 42]
    assert len(hurried) >= 11  # each frame is more than a part further than the one before


def test_a_camera_that_goes_back_a_little_gives_no_part_two_frames(tmp_path: Path) -> None:
    """A step back to the middle of a part that has given its frame."""
    way = np.array([0.0, 0.1, 0.125, 0.2, 0.3, 0.26, 0.13, 0.12, 0.26, 0.375, 0.5, 0.625, 0.8, 1.0])
    made = film(tmp_path / "walk.avi", [4.0] * len(way))
    choice = choose_frames(
        Survey(open_video(made.path), way), lambda _verdict, _frame: None, FrameOptions(count=4)
    )
    parts = np.array([frame.way for frame in choice.taken]) / 0.25
    assert parts.astype(int).tolist() == [0, 1, 2, 3]


def test_the_pixels_are_those_of_the_frame(tmp_path: Path) -> None:
    made = film(tmp_path / "walk.avi", [4.0] * 40)
    choice, pixels = chosen(made.path, FrameOptions(count=5))
    stored = cv2.VideoCapture(str(made.path))
    frames = [stored.read()[1] for _ in range(40)]
    for verdict, taken in zip(choice.taken, pixels, strict=True):
        np.testing.assert_array_equal(taken, frames[verdict.number][:, :, ::-1])


@pytest.mark.parametrize(
    ("turn", "quarters"),
    [
        (90, 1),
        pytest.param(0, 0, marks=pytest.mark.slow),
        pytest.param(180, 2, marks=pytest.mark.slow),
        pytest.param(270, 3, marks=pytest.mark.slow),
    ],
)
def test_the_turn_is_told_and_the_pixels_stay(tmp_path: Path, turn: int, quarters: int) -> None:
    made = film(tmp_path / "walk.mp4", [4.0] * 24, "mp4v")
    _, straight = chosen(made.path, FrameOptions(count=4))
    content = made.path.read_bytes()
    one, zero, unit = struct.pack(">i", 1 << 16), bytes(4), struct.pack(">i", 1 << 30)
    minus = struct.pack(">i", -(1 << 16))
    matrices = {
        0: one + zero * 3 + one + zero * 3 + unit,
        90: zero + one + zero + minus + zero * 4 + unit,
        180: minus + zero * 3 + minus + zero * 3 + unit,
        270: zero + minus + zero + one + zero * 4 + unit,
    }
    track_at = content.index(b"tkhd")
    matrix_at = content.index(matrices[0], track_at)
    turned = content[:matrix_at] + matrices[turn] + content[matrix_at + 36 :]
    made.path.write_bytes(turned)
    video = open_video(made.path)
    assert video.quarter_turns == quarters
    assert (video.width_px, video.height_px) == (WIDTH_PX, HEIGHT_PX)
    _, pixels = chosen(made.path, FrameOptions(count=4))
    for before, after in zip(straight, pixels, strict=True):
        np.testing.assert_array_equal(before, after)
    turning = cv2.VideoCapture(str(made.path))
    turning.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)  # as OpenCV shows it to people
    shown = turning.read()[1]
    stored = cv2.VideoCapture(str(made.path))
    stored.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    np.testing.assert_array_equal(shown, np.rot90(stored.read()[1], -quarters))


def test_a_still_camera_is_refused(tmp_path: Path) -> None:
    made = film(tmp_path / "still.avi", [0.0] * 40, tremble_px=1.0)
    with pytest.raises(PhotoError, match=r"hardly moved.*walk all round"):
        survey(open_video(made.path))


def test_a_cut_off_film_is_used_as_far_as_it_goes_or_refused(tmp_path: Path) -> None:
    made = film(tmp_path / "walk.avi", [4.0] * 60)
    whole = made.path.read_bytes()
    made.path.write_bytes(whole[: len(whole) * 2 // 3])
    choice, _ = chosen(made.path, FrameOptions(count=5))
    assert 30 < len(choice.frames) < 48
    made.path.write_bytes(whole[:3000])
    with pytest.raises(PhotoError, match=r"No frame|cannot be decoded"):
        survey(open_video(made.path))


@pytest.mark.parametrize(
    "content",
    [
        b"#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nhttp://127.0.0.1:9/a.ts\n",
        b"ffconcat version 1.0\nfile /etc/hostname\n",
        b"<?xml version='1.0'?><MPD></MPD>",
        b"",
    ],
)
def test_lists_of_addresses_are_never_opened(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "walk.mp4"
    path.write_bytes(content)
    with pytest.raises(PhotoError, match="does not begin as a video"):
        open_video(path)


def test_it_stops_when_asked(tmp_path: Path) -> None:
    made = film(tmp_path / "walk.avi", [4.0] * 60)
    seen: list[int] = []

    def listen(_stage: str, done: int, _total: int) -> None:
        seen.append(done)
        if done == 20:
            run.cancel()

    run = Run(listener=listen)
    with pytest.raises(Cancelled):
        run(survey, open_video(made.path))
    assert max(seen) <= 21
