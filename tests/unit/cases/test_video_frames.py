"""Frames of a video in a folder: photos that are read as such, the reasons, the picture."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from limbgram.cases.folder import CaseFolder
from limbgram.cases.stage_cache import CachingRun
from limbgram.cases.video_frames import take_frames, with_frames
from limbgram.cli.main import app
from limbgram.core.errors import Cancelled, CaseError
from limbgram.core.run import Run
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.photos.video import FrameOptions

FEW = FrameOptions(count=6)


@pytest.fixture
def video(tmp_path: Path) -> Path:
    return filmed(tmp_path / "the walk.avi", 90)


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    """The first second of it, for tests that ask for the files alone."""
    return filmed(tmp_path / "the walk.avi", 25)


def filmed(path: Path, frames: int) -> Path:
    """A window that slides over squares of chance colours, 5 px a frame."""
    grain = np.random.default_rng(5).integers(0, 256, (24, 80, 3), dtype=np.uint8)
    ground = cv2.resize(grain, (800, 240), interpolation=cv2.INTER_NEAREST)
    ground = cv2.GaussianBlur(ground, (0, 0), 0.8)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 25, (320, 240))
    for x in range(0, 5 * frames, 5):
        writer.write(ground[:, x : x + 320])
    writer.release()
    return path


def test_frames_become_photos_of_one_camera(video: Path, tmp_path: Path) -> None:
    made = take_frames(video, tmp_path / "out", Run(), FEW)
    photos = read_photos([made.photos])
    assert (made.taken, made.frames) == (6, 90)
    assert made.duration_s == pytest.approx(3.6)
    assert len(photos.photos) == 6
    assert not photos.set_aside
    assert len(photos.cameras) == 1
    film = cv2.VideoCapture(str(video))
    frames = [film.read()[1] for _ in range(90)]
    for photo in photos.photos:
        number = int(photo.name.removesuffix(".jpg").rpartition("-")[2])
        luma = cv2.cvtColor(frames[number], cv2.COLOR_BGR2GRAY)
        assert np.abs(load_luma(photo).astype(float) - luma).mean() < 0.6
    record = json.loads(made.record.read_text("utf-8"))
    assert [frame["number"] for frame in record["frames"]] == list(range(90))
    assert all(frame["reason"] for frame in record["frames"])
    assert {frame["name"] for frame in record["frames"] if frame["taken"]} == set(photos.names)
    with Image.open(made.sheet) as sheet:
        assert sheet.width > 1000


def test_the_same_again_is_not_made_again_and_other_options_are(clip: Path, tmp_path: Path) -> None:
    stages: list[str] = []
    run = Run(listener=lambda stage, _done, _total: stages.append(stage))
    first = take_frames(clip, tmp_path / "out", run, FEW)
    written = {file: file.read_bytes() for file in first.photos.iterdir()}
    stages.clear()
    assert take_frames(clip, tmp_path / "out", run, FEW) == first
    assert not stages
    next(iter(written)).unlink()
    assert take_frames(clip, tmp_path / "out", run, FEW) == first
    assert {file: file.read_bytes() for file in first.photos.iterdir()} == written
    assert take_frames(clip, tmp_path / "out", run, FrameOptions(count=4)).taken == 4


def test_what_is_no_folder_of_frames_stays(clip: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "note.txt").write_text("keep")
    with pytest.raises(CaseError, match="something else"):
        take_frames(clip, tmp_path / "mine", Run(), FEW)
    assert [file.name for file in (tmp_path / "mine").iterdir()] == ["note.txt"]


def test_stopped_it_leaves_nothing(video: Path, tmp_path: Path) -> None:
    def listen(stage: str, done: int, _total: int) -> None:
        if stage == "choose frames" and done == 50:
            run.cancel()

    run = Run(listener=listen)
    with pytest.raises(Cancelled):
        take_frames(video, tmp_path / "out", run, FEW)
    assert {entry.name for entry in tmp_path.iterdir()} == {"the walk.avi"}


def test_a_case_takes_photos_and_videos(clip: Path, tmp_path: Path) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    photos = tmp_path / "photos"
    sources = with_frames(case, (photos, clip), CachingRun(case=case))
    assert sources == (photos, case.frames / "the_walk" / "photos")
    assert len(list(sources[1].iterdir())) >= 6
    assert not case.stages.exists()


@pytest.mark.parametrize(
    "names",
    [
        ("walk.avi", "walk.mov"),
        ("the walk.avi", "the_walk.avi"),
        ("WhatsApp Video 2026-11-30 at 10.15.30 AM (1).avi",
         "WhatsApp Video 2026-11-30 at 10.15.30 AM (2).avi"),
    ],
)  # fmt: skip
def test_videos_of_like_names_keep_their_frames_apart(
    clip: Path, tmp_path: Path, names: tuple[str, str]
) -> None:
    case = CaseFolder(tmp_path / "case")
    case.root.mkdir()
    films = [tmp_path / "films" / name for name in names]
    films[0].parent.mkdir()
    for number, film in enumerate(films):
        film.write_bytes(clip.read_bytes() + bytes(number))
    folders = with_frames(case, films, CachingRun(case=case))
    assert len({*folders}) == 2
    assert all(len(list(folder.iterdir())) >= 6 for folder in folders)


def test_the_command_tells_how_many(clip: Path, tmp_path: Path) -> None:
    words = ["frames", str(clip), "-o", str(tmp_path / "out"), "--count", "6", "--json"]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    assert json.loads(answer.stdout)["taken"] == 6
    refused = CliRunner().invoke(app, ["frames", str(tmp_path / "no.mp4"), "-o", "x", "--json"])
    assert refused.exit_code == 3
