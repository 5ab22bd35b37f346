"""A clinic in a temporary folder, and somebody who is signed in to it."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from limbgram.app.access import Access, Guard
from limbgram.app.server import build
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic import SMALL
from limbgram.synthetic.props.limb import make_limb

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
    """Of edges of 6 mm where a test asks for no others."""
    step_mm: float = getattr(request, "param", 6.0)
    return make_limb(SMALL.kind, SMALL.seed, step_mm, 60.0).mesh


@pytest.fixture
def app_state(tmp_path: Path) -> AppState:
    access = Access(frozenset({HOST}))
    return AppState(Shelf(tmp_path / "cases"), access, origin=lambda: f"http://{HOST}")


class Present:
    """Stands for what the test that runs has made."""

    def __init__(self) -> None:
        self.it: Any = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self.it, name)


@pytest.fixture(scope="session")
def serve(tmp_path_factory: pytest.TempPathFactory) -> Callable[[AppState], Guard]:
    """The server as it stands on a socket, as `guarded` gives it, over what a test has.

    Its routes, whose schemas take 0.2 s of the processor, are made once.
    """
    static = tmp_path_factory.mktemp("static")
    (static / "index.html").write_text("<!doctype html><title>limbgram</title>", "utf-8")
    present: Any = Present()
    present.shelf = Present()
    app = build(present, static)

    def served(app_state: AppState) -> Guard:
        present.it, present.shelf.it = app_state, app_state.shelf
        return Guard(app, app_state.access, diary=app_state.phone_ports.diary)

    return served


@pytest.fixture
def stranger(app_state: AppState, serve: Callable[[AppState], Guard]) -> Iterator[TestClient]:
    """A browser that nobody signed in."""
    with TestClient(serve(app_state), base_url=f"http://{HOST}") as client:
        yield client


@pytest.fixture
def client(app_state: AppState, stranger: TestClient) -> TestClient:
    """A browser that opened the start link."""
    stranger.get(f"/start?token={app_state.access.new_link_token()}")
    return stranger
