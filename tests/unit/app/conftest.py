"""A clinic in a temporary folder, and somebody who is signed in to it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from limbgram.app.access import Access
from limbgram.app.server import guarded
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic import SMALL, stage_truth

HOST = "127.0.0.1:8000"
API = "/api/v1"


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where programs of the account keep what is theirs, beside the shelf."""
    folder = tmp_path / "state"
    for name in ("XDG_STATE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(folder))
    return folder


@pytest.fixture(scope="session")
def limb(request: pytest.FixtureRequest) -> Mesh:
    """Of edges of 2.4 mm where a test asks for no others."""
    step_mm: float = getattr(request, "param", 2.4)
    return stage_truth(replace(SMALL, mesh_step_mm=step_mm)).limb.mesh


@pytest.fixture
def app_state(tmp_path: Path) -> AppState:
    access = Access(frozenset({HOST}))
    return AppState(Shelf(tmp_path / "cases"), access, origin=lambda: f"http://{HOST}")


@pytest.fixture
def stranger(app_state: AppState, tmp_path: Path) -> Iterator[TestClient]:
    """A browser that nobody signed in."""
    static = tmp_path / "static"
    static.mkdir()
    (static / "index.html").write_text("<!doctype html><title>limbgram</title>", "utf-8")
    with TestClient(guarded(app_state, static), base_url=f"http://{HOST}") as client:
        yield client


@pytest.fixture
def client(app_state: AppState, stranger: TestClient) -> TestClient:
    """A browser that opened the start link."""
    stranger.get(f"/start?token={app_state.access.new_link_token()}")
    return stranger
