"""The door for a phone: photos of one case go in, and nothing else passes."""

import io
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import httpx
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app import phone
from limbgram.app.phone_port import PhonePort
from limbgram.app.state import AppState

API = "/api/v1"


@pytest.fixture
def case(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(phone, "own_address", lambda: "127.0.0.1")
    return str(client.post(f"{API}/cases", json={}).json()["id"])


@pytest.fixture
def at_the_door(client: TestClient, case: str) -> Iterator[httpx.Client]:
    """A phone that opened the link."""
    opened = client.post(f"{API}/cases/{case}/phone").json()
    assert opened["qr_svg"].startswith("<svg")
    assert not opened["encrypted"]
    with httpx.Client(base_url=opened["url"].partition("/start")[0], timeout=20) as browser:
        page = browser.get(opened["url"])
        assert page.status_code == 200
        assert f"url=/#/phone/{case}" in page.text
        yield browser
    client.delete(f"{API}/cases/{case}/phone")


def test_photos_go_in_by_the_phone(
    client: TestClient, at_the_door: httpx.Client, case: str
) -> None:
    made = io.BytesIO()
    Image.new("RGB", (120, 90)).save(made, "JPEG")
    sent = at_the_door.put(f"{API}/cases/{case}/photos/a.jpg", content=made.getvalue())
    assert sent.json()["whole"]
    assert client.get(f"{API}/cases/{case}/photos").json()["here"] == 1
    assert at_the_door.get(f"{API}/cases/{case}/photos").json()["here"] == 1


def test_nothing_else_passes_the_door(
    client: TestClient, at_the_door: httpx.Client, case: str
) -> None:
    other = client.post(f"{API}/cases", json={}).json()["id"]
    refused = (
        ("GET", f"{API}/cases"),
        ("GET", f"{API}/cases/{other}"),
        ("GET", f"{API}/cases/{other}/photos"),
        ("PUT", f"{API}/cases/{other}/photos/a.jpg"),
        ("DELETE", f"{API}/cases/{case}/photos/a.jpg"),
        ("GET", f"{API}/cases/{case}/photos/a.jpg/file"),
        ("DELETE", f"{API}/cases/{case}"),
        ("PATCH", f"{API}/cases/{case}"),
        ("GET", f"{API}/cases/{case}/surface"),
        ("POST", f"{API}/cases/{case}/job"),
        ("POST", f"{API}/session/links"),
        ("GET", f"{API}/openapi.json"),
    )
    for method, path in refused:
        assert at_the_door.request(method, path).status_code == 403, (method, path)


def test_a_session_of_the_door_is_none_of_the_app(
    client: TestClient, at_the_door: httpx.Client
) -> None:
    ((theirs, value),) = at_the_door.cookies.items()
    ((own, _),) = client.cookies.items()
    assert own == "limbgram_session_8000"
    assert own != theirs == f"limbgram_session_{at_the_door.base_url.port}"
    client.cookies.clear()
    client.cookies.set(own, value)
    assert client.get(f"{API}/cases").status_code == 401


def test_the_door_closes(client: TestClient, app_state: AppState, case: str) -> None:
    opened = client.post(f"{API}/cases/{case}/phone").json()
    assert client.get(f"{API}/cases/{case}/phone").json()["open"]
    client.delete(f"{API}/cases/{case}/phone")
    assert not client.get(f"{API}/cases/{case}/phone").json()["open"]
    assert app_state.phone_ports.access_at(opened["url"].split("/")[2]) is None


def test_a_door_that_is_opened_twice_at_once_is_one(app_state: AppState) -> None:
    """Of two, one could not be closed any more."""
    app_state.shelf.open()
    case = app_state.shelf.new_case(None, None)
    both = threading.Barrier(2)

    def address() -> str:
        with suppress(threading.BrokenBarrierError):
            both.wait(0.5)
        return "127.0.0.1"

    async def nothing(*_: object) -> None: ...

    def opened(_: int) -> PhonePort:
        return app_state.phone_ports.open(case, nothing, address, lambda: True)

    with ThreadPoolExecutor(2) as pool:
        ports = list(pool.map(opened, range(2)))
    app_state.phone_ports.close(case)
    assert ports[0] is ports[1]
