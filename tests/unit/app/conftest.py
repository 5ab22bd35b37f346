"""A clinic in a temporary folder, and somebody who is signed in to it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from limbgram.app.access import Access
from limbgram.app.clinic import Clinic
from limbgram.app.server import guarded
from limbgram.cases.shelf import Shelf

HOST = "127.0.0.1:8000"
API = "/api/v1"


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where programs of the account keep what is theirs, beside the shelf."""
    folder = tmp_path / "state"
    for name in ("XDG_STATE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(folder))
    return folder


@pytest.fixture
def clinic(tmp_path: Path) -> Clinic:
    access = Access(frozenset({HOST}))
    return Clinic(Shelf(tmp_path / "cases"), access, origin=lambda: f"http://{HOST}")


@pytest.fixture
def stranger(clinic: Clinic, tmp_path: Path) -> Iterator[TestClient]:
    """A browser that nobody signed in."""
    static = tmp_path / "static"
    static.mkdir()
    (static / "index.html").write_text("<!doctype html><title>limbgram</title>", "utf-8")
    with TestClient(guarded(clinic, static), base_url=f"http://{HOST}") as client:
        yield client


@pytest.fixture
def client(clinic: Clinic, stranger: TestClient) -> TestClient:
    """A browser that opened the start link."""
    stranger.get(f"/start?token={clinic.access.new_link_token()}")
    return stranger
