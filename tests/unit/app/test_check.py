"""Checks over HTTP: what is known of a capture's photos is kept as long as it is of use."""

import errno
import io
import math
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app import live_checks
from limbgram.capture.answer import CaptureCheck, CheckedPhoto
from limbgram.core.errors import Cancelled, ScaleError
from limbgram.findings import doubt, fault, told
from limbgram.formats.board_file import read_board, write_board
from limbgram.formats.printed_size import PrintedSize, Reading
from limbgram.reconstruction.targets.board import Board

API = "/api/v1"


@dataclass
class Watch:
    """Stands for a CaptureWatch, and says what became of it."""

    calibrations: Sequence[object]
    board: Board | None
    checks: list[int] = field(default_factory=list[int])
    closed: bool = False
    made: "ClassVar[list[Watch]]"

    def __post_init__(self) -> None:
        self.made.append(self)

    def check(self, sources: Sequence[Path], _run: object) -> None:
        assert not self.closed
        self.checks.append(len(sources))
        raise ScaleError("No answer.")

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def watches(monkeypatch: pytest.MonkeyPatch) -> list[Watch]:
    monkeypatch.setattr(Watch, "made", [], raising=False)
    monkeypatch.setattr(live_checks, "CaptureWatch", Watch)
    return Watch.made


def case_with_photos(client: TestClient, count: int) -> str:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    for number in range(count):
        add_photo(client, case, number)
    return case


def add_photo(client: TestClient, case: str, number: int) -> None:
    noise = np.random.default_rng(number).integers(0, 255, (60, 80, 3), np.uint8)
    made = io.BytesIO()
    Image.fromarray(noise).save(made, "PNG")
    sent = client.put(f"{case}/photos/{number}.png", content=made.getvalue())
    assert sent.json()["whole"]


def checked(client: TestClient, case: str, **kit: Any) -> dict[str, Any]:
    assert client.post(f"{case}/check", json=kit).status_code == 202
    for _ in range(600):
        told: dict[str, Any] = client.get(f"{case}/check").json()
        if told["state"] != "running":
            return told
        time.sleep(0.02)
    raise AssertionError("The check does not end.")


def test_photos_that_cannot_be_checked_are_refused_in_words(client: TestClient) -> None:
    told = checked(client, case_with_photos(client, 2))
    assert (told["state"], told["current"], told["photos"]) == ("refused", True, 2)
    assert "too small for a photo" in told["message"]
    assert told["answer"] is None


@pytest.mark.usefixtures("watches")
def test_an_answer_tells_codes_and_values_and_nothing_of_what_is_not_known(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    unseen = fault("coach.board_unseen", photos=2, least=3)
    blurred = doubt("photo.blurred", edge_px=4.0, usual_px=1.0)
    photo = CheckedPhoto(
        name="0.png", placed=False, points=0, edge_px=math.nan, burnt=0.0,
        features_per_cm2=math.nan, azimuth_deg=math.nan, elevation_deg=math.nan, counts=False,
        remarks=(blurred,),
    )  # fmt: skip
    found = CaptureCheck(
        go=False, headline=fault("coach.not_yet", why=unseen), findings=(unseen,), photos=(photo,),
        missing=(), largest_gap_deg=math.nan, board_photos=2,
    )  # fmt: skip
    monkeypatch.setattr(Watch, "check", lambda *_: found)
    answer = checked(client, case_with_photos(client, 2))["answer"]
    assert answer["findings"][0]["code"] == "coach.board_unseen"
    assert answer["findings"][0]["values"] == {"photos": 2, "least": 3}
    assert answer["headline"]["sentence"].startswith("NOT YET: The scale board is found in 2")
    assert answer["photos"][0]["remarks"][0]["code"] == "photo.blurred"
    assert answer["photos"][0]["edge_px"] is None
    assert answer["coverage"] is None


def test_a_further_photo_goes_to_what_is_known_already(
    client: TestClient, watches: list[Watch]
) -> None:
    case = case_with_photos(client, 2)
    assert checked(client, case)["message"] == "No answer."
    add_photo(client, case, 2)
    assert client.get(f"{case}/check").json()["current"] is False
    checked(client, case)
    assert [watch.checks for watch in watches] == [[2, 3]]


@pytest.mark.usefixtures("watches")
def test_an_answer_is_of_these_photos_and_not_of_as_many_others(client: TestClient) -> None:
    case = case_with_photos(client, 2)
    assert checked(client, case)["current"]
    client.delete(f"{case}/photos/1.png")
    add_photo(client, case, 2)
    assert not client.get(f"{case}/check").json()["current"], "another one came for it"
    assert checked(client, case)["current"]
    first, second = (client.get(f"{case}/photos/{k}.png/file").content for k in (0, 2))
    client.put(f"{case}/photos/2.png?replace=true", content=first)
    assert not client.get(f"{case}/check").json()["current"], "it was replaced"
    client.put(f"{case}/photos/2.png?replace=true", content=second)
    assert client.get(f"{case}/check").json()["current"]


@pytest.mark.usefixtures("watches")
def test_the_answer_that_stays_when_the_next_check_is_ended_is_not_of_its_photos(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ended(*_: object) -> None:
        raise Cancelled("job.run_stopped")

    case = case_with_photos(client, 2)
    assert checked(client, case)["photos"] == 2
    add_photo(client, case, 2)
    monkeypatch.setattr(Watch, "check", ended)
    told = checked(client, case)
    assert (told["message"], told["photos"], told["current"]) == ("No answer.", 2, False)


@pytest.mark.usefixtures("watches")
@pytest.mark.parametrize("fault", [OSError(errno.ENOSPC, "No space left"), ZeroDivisionError()])
def test_a_check_that_fails_ends_and_the_next_one_answers(
    client: TestClient, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    def fails(*_: object) -> None:
        raise fault

    case = case_with_photos(client, 1)
    monkeypatch.setattr(threading, "excepthook", lambda _: None)  # a fault of ours passes on
    with monkeypatch.context() as broken:
        broken.setattr(Watch, "check", fails)
        told = checked(client, case)
    assert (told["state"], told["answer"]) == ("refused", None)
    assert told["message"]
    assert checked(client, case)["message"] == "No answer."


def test_a_check_that_is_asked_for_as_another_ends_is_let_be(
    watches: list[Watch], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The end of the first one comes while the second runs: it leaves it what it works with."""
    running, ending = threading.Event(), threading.Event()

    def check(watch: Watch, sources: Sequence[Path], _run: object) -> None:
        watch.checks.append(len(sources))
        if len(sources) == 2:
            running.set()
            ending.wait(20)
        raise ScaleError("No answer.")

    class Between(live_checks.LiveCheck):
        def _check_all(self) -> None:
            super()._check_all()
            if not running.is_set():
                self.ask(asked(2))
                running.wait(20)

    def asked(photos: int) -> live_checks.Asked:
        sources = tuple(Path(f"{k}.png") for k in range(photos))
        return live_checks.Asked(
            sources=sources, calibrations=(), camera_sha256=(), board=None, photos=len(sources)
        )

    monkeypatch.setattr(Watch, "check", check)
    first_told = threading.Event()
    coach = Between(lambda: first_told.set() if running.is_set() else None)
    coach.ask(asked(1))
    assert running.wait(20)
    assert first_told.wait(20), "the first one is over"
    assert (coach.state, told_by(coach)) == ("running", "No answer.")
    assert [one.closed for one in watches] == [False]
    ending.set()
    until = time.monotonic() + 20
    while coach.state == "running" and time.monotonic() < until:
        time.sleep(0.01)
    assert (coach.state, told_by(coach)) == ("done", "No answer.")
    assert [one.checks for one in watches] == [[1, 2]]


def test_another_board_or_another_case_begins_anew_and_nothing_is_left(
    client: TestClient, watches: list[Watch]
) -> None:
    case, other = case_with_photos(client, 1), case_with_photos(client, 1)
    checked(client, case)
    checked(client, case, board=None)
    assert [watch.closed for watch in watches] == [True, False]
    checked(client, other)
    assert [watch.closed for watch in watches] == [True, True, False]
    assert client.delete(other).status_code == 204
    assert all(watch.closed for watch in watches)


def test_a_camera_that_is_not_here_is_refused(client: TestClient) -> None:
    case = case_with_photos(client, 1)
    asked = client.post(f"{case}/check", json={"cameras": ["none-such"]})
    assert 400 <= asked.status_code < 500
    assert client.get(f"{case}/check").json()["state"] == "none"
    assert client.get(f"{API}/cameras").json() == []


def test_a_board_is_as_large_as_the_ruler_of_its_print_says(
    client: TestClient, watches: list[Watch], tmp_path: Path
) -> None:
    case = case_with_photos(client, 3)
    checked(client, case, board={"ruler": {"measured_mm": 249.4}})
    drawn = Board.charuco("7x5", 30, 22, "4X4_50")
    size = PrintedSize(across=Reading(drawn_mm=250, measured_mm=249.4))
    write_board(tmp_path / "board.json", drawn, size)
    board = watches[-1].board
    assert board == read_board(tmp_path / "board.json")
    assert board is not None
    assert board.square_mm == pytest.approx(30 * 249.4 / 250, abs=1e-12)


@pytest.mark.parametrize("measured_mm", [237.4, 262.6, 25.0])
@pytest.mark.parametrize("asked", ["check", "job"])
def test_a_ruler_more_than_five_per_cent_off_is_refused(
    client: TestClient, watches: list[Watch], asked: str, measured_mm: float
) -> None:
    case = case_with_photos(client, 3)
    refused = client.post(
        f"{case}/{asked}", json={"board": {"ruler": {"measured_mm": measured_mm}}}
    )
    assert 400 <= refused.status_code < 500
    assert "100 %" in refused.json()["message"]
    assert not watches


def told_by(coach: live_checks.LiveCheck) -> str:
    return "" if coach.refusal is None else told(coach.refusal)
