"""Events over a real socket: who listens hears of photos that arrive and of a run's steps."""

import asyncio
import io
import json
import socket
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import httpx
import numpy as np
import pytest
from PIL import Image

from limbgram.app import events
from limbgram.app.access import Access
from limbgram.app.local_server import EndingServer
from limbgram.app.server import guarded
from limbgram.app.server_socket import configured
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf

API = "/api/v1"
RUN = """
import json
for stage in ("read photos", "detect"):
    print(json.dumps({"event": "progress", "stage": stage, "done": 1, "total": 1}), flush=True)
"""


@dataclass
class Served:
    """A server on a socket, and somebody who is signed in to it."""

    server: EndingServer
    client: httpx.Client


@pytest.fixture
def browser(served: Served) -> httpx.Client:
    return served.client


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    listening = socket.create_server(("127.0.0.1", 0))
    host = f"127.0.0.1:{listening.getsockname()[1]}"
    app_state = AppState(Shelf(tmp_path / "cases"), Access(frozenset({host})))
    app_state.runner.command = (sys.executable, "-c", RUN)
    server = EndingServer(configured(guarded(app_state, tmp_path), None, "on"), app_state)
    serving = threading.Thread(target=server.run, args=([listening],))
    serving.start()
    try:
        with httpx.Client(base_url=f"http://{host}", timeout=20) as client:
            client.get(f"/start?token={app_state.access.new_link_token()}")
            yield Served(server, client)
    finally:
        server.should_exit = True
        serving.join(20)
        listening.close()


def changes(lines: Iterator[str]) -> Iterator[list[str]]:
    for line in lines:
        if line.startswith("data: "):
            yield json.loads(line.removeprefix("data: "))["changed"]


def test_photos_and_steps_of_a_run_are_told_as_they_come(browser: httpx.Client) -> None:
    case_id = browser.post(f"{API}/cases", json={}).json()["id"]
    case = f"{API}/cases/{case_id}"
    made = io.BytesIO()
    Image.new("RGB", (40, 30)).save(made, "PNG")
    with (
        browser.stream("GET", f"{case}/events") as own,
        browser.stream("GET", f"{API}/events") as all_cases,
    ):
        assert own.headers["content-type"].startswith("text/event-stream")
        told, told_of_all = changes(own.iter_lines()), changes(all_cases.iter_lines())
        next(told)
        next(told_of_all)
        browser.put(f"{case}/photos/a.png", content=made.getvalue()).raise_for_status()
        assert next(told) == ["photos"]
        assert next(told_of_all) == [case_id]
        asked = {"board": None, "unscaled": True}
        browser.post(f"{case}/job", json=asked).raise_for_status()
        assert "job" in next(told)


def test_what_changes_all_the_time_is_told_once_a_second_and_to_its_end(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    looks = 0

    async def look_again(_: float) -> None:
        nonlocal looks
        looks += 1

    class Listener:
        async def is_disconnected(self) -> bool:
            return looks == 200

    def steps() -> dict[str, int]:
        return {"job": min(looks, 150)}

    async def told() -> list[int]:
        app_state = AppState(Shelf(tmp_path), Access(frozenset()))
        changes = events._changes(app_state, cast(Any, Listener()), steps, lambda: True)
        return [looks async for line in changes if line.startswith("event: change")]

    monkeypatch.setattr(asyncio, "sleep", look_again)
    at = asyncio.run(told())
    assert at[:2] == [0, 1], "the first change at once"
    apart_s = events._LOOK_S * np.diff(at[1:])
    assert apart_s.min() >= 1.0
    assert apart_s.max() < 1.2
    assert at[-1] >= 150, "the last one is told as well"


def test_nobody_listens_without_a_session(browser: httpx.Client) -> None:
    browser.cookies.clear()
    assert browser.get(f"{API}/events").status_code == 401


def test_a_server_that_ends_ends_its_streams_first(
    served: Served, caplog: pytest.LogCaptureFixture
) -> None:
    with served.client.stream("GET", f"{API}/events") as stream:
        lines = stream.iter_lines()
        next(changes(lines))
        served.server.should_exit = True
        assert not any(changes(lines))  # to its end, and no further
    assert not caplog.records
