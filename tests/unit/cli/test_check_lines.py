"""What `limbgram check` says on the terminal: the answer first, then what it rests on."""

import errno
import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from limbgram.capture.answer import CaptureCheck, CheckedPhoto
from limbgram.cli.check import check_lines
from limbgram.cli.main import app
from limbgram.core.errors import PhotoError
from limbgram.findings import Finding, note

PHOTO = CheckedPhoto(
    name="IMG_1.jpg", placed=True, points=900, edge_px=0.8, burnt=0.0, features_per_cm2=12.0,
    azimuth_deg=0.0, elevation_deg=20.0, counts=True, remarks=(),
)  # fmt: skip


def said(message: str) -> Finding:
    return note("said.as_is", message=message)


def check(*photos: CheckedPhoto) -> CaptureCheck:
    return CaptureCheck(
        go=False,
        headline=note("coach.not_yet", why=said("the first finding")),
        findings=(said("the first finding"), said("the second finding")),
        photos=photos,
        missing=(),
        largest_gap_deg=30.0,
        board_photos=3,
        notes=(said("a note"),),
    )


def test_the_answer_comes_first_and_each_finding_once() -> None:
    lines = check_lines(check(replace(PHOTO, remarks=(said("blurred: hold still"),))))
    assert lines[:3] == ("NOT YET: the first finding", "  the second finding", "  a note")
    assert lines[-1] == "  IMG_1.jpg: blurred: hold still"


def test_the_texture_is_told_with_its_poorest_photo() -> None:
    photos = [
        replace(PHOTO, name=f"IMG_{k}.jpg", features_per_cm2=dense)
        for k, dense in enumerate([12.0, 3.04, 20.0, math.nan])
    ]
    told = [line for line in check_lines(check(*photos)) if "Texture" in line]
    assert told == [
        "  Texture: 12.0 feature points a cm² of the limb in the middle one of the photos, 3.0 in "
        "the poorest (IMG_1.jpg)."
    ]


def test_without_a_size_nothing_is_said_of_the_texture() -> None:
    lines = check_lines(check(replace(PHOTO, features_per_cm2=math.nan)))
    assert not any("Texture" in line for line in lines)


class Watch:
    """Stands for a CaptureWatch: one photo is too few, and two are good."""

    def __init__(self, *_given: object, masks: Path | None = None) -> None:
        assert masks is None

    def __enter__(self) -> "Watch":
        return self

    def __exit__(self, *_ended: object) -> None:
        pass

    def check(self, sources: list[Path], _run: object) -> CaptureCheck:
        second = sources[0] / "two.jpg"
        if second.exists():
            return replace(check(PHOTO), go=True)
        second.touch()
        raise PhotoError("photo.too_few_yet", photos=1, least=2, aside=0, left_out=())


def test_while_it_waits_it_speaks_the_language_of_the_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("limbgram.cli.check.CaptureWatch", Watch)
    (tmp_path / "one.jpg").touch()
    words = ["check", str(tmp_path), "--watch"]
    answer = CliRunner().invoke(app, words, env={"LIMBGRAM_LANGUAGE": "de"})
    assert answer.exit_code == 0, answer.output
    assert "Bisher lesbare Fotos: 1; 2 sind für eine Prüfung nötig." in answer.stderr


class VanishingWatch(Watch):
    """Stands for a CaptureWatch: the second photo vanishes while it is checked; then it is GO."""

    refusal: type[Exception] = PhotoError

    def check(self, sources: list[Path], _run: object) -> CaptureCheck:
        second = sources[1]
        if not second.exists():
            return replace(check(PHOTO), go=True)
        second.unlink()
        if self.refusal is PhotoError:
            raise PhotoError("photo.gone", photo=second.name, path=str(second))
        raise FileNotFoundError(errno.ENOENT, "No such file or directory", str(second))


@pytest.mark.parametrize("refusal", [PhotoError, FileNotFoundError])
def test_a_photo_that_vanishes_does_not_end_the_watch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusal: type[Exception]
) -> None:
    monkeypatch.setattr("limbgram.cli.check.CaptureWatch", VanishingWatch)
    monkeypatch.setattr(VanishingWatch, "refusal", refusal)
    monkeypatch.setattr("limbgram.cli.check._POLL_S", 0.01)
    photos = [tmp_path / "one.jpg", tmp_path / "two.jpg"]
    for photo in photos:
        photo.touch()
    answer = CliRunner().invoke(app, ["check", *map(str, photos), "--watch"])
    assert answer.exit_code == 0, answer.output
    assert "two.jpg" in answer.stderr


def test_a_watch_of_what_was_never_there_is_refused(tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["check", str(tmp_path / "fotos"), "--watch"])
    assert answer.exit_code == 3, answer.output
    assert "fotos" in answer.stderr


def test_what_is_said_while_it_waits_is_json_where_json_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("limbgram.cli.check.CaptureWatch", Watch)
    monkeypatch.setattr("limbgram.cli.check._POLL_S", 0.01)
    (tmp_path / "one.jpg").touch()
    answer = CliRunner().invoke(app, ["check", str(tmp_path), "--watch", "--json"])
    assert json.loads(answer.stdout)["go"] is True
    events = [json.loads(line) for line in answer.stderr.splitlines()]
    assert [one["event"] for one in events] == ["said"]
    assert "can be read" in events[0]["line"]
