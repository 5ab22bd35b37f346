"""Who may ask, and from where."""

import asyncio
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from limbgram.app import access
from limbgram.app.access import Access
from limbgram.app.openapi import document
from limbgram.app.server import guarded
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf

API = "/api/v1"


def test_a_start_link_is_good_once(app_state: AppState, stranger: TestClient) -> None:
    token = app_state.access.new_link_token()
    assert stranger.get(f"{API}/cases").status_code == 401
    assert stranger.get(f"/start?token={token}").status_code == 200
    assert stranger.get(f"{API}/cases").status_code == 200
    stranger.cookies.clear()
    assert stranger.get(f"/start?token={token}").status_code == 401
    assert stranger.get(f"{API}/cases").status_code == 401


def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites(
    app_state: AppState, stranger: TestClient
) -> None:
    answer = stranger.get(f"/start?token={app_state.access.new_link_token()}")
    said = answer.headers["set-cookie"].lower()
    assert "httponly" in said
    assert "samesite=strict" in said


def test_links_and_sessions_end() -> None:
    now = [0.0]
    access = Access(frozenset(), clock=lambda: now[0])
    late, good = access.new_link_token(), access.new_link_token()
    session = access.open_session(good)
    assert session is not None
    now[0] = 16 * 60.0
    assert access.open_session(late) is None
    assert access.is_open(session)
    now[0] += 13 * 3600.0
    assert not access.is_open(session)


def test_five_hundred_may_be_signed_in_and_the_one_of_longest_ago_gives_way() -> None:
    now = [0.0]
    access = Access(frozenset(), clock=lambda: now[0])
    sessions: list[str] = []
    for number in range(501):
        now[0] = float(number)
        sessions.append(access.begin(f"user {number}"))
    assert [access.is_open(one) for one in sessions[:2]] == [False, True]


def test_every_route_refuses_another_host_and_another_origin(client: TestClient) -> None:
    elsewhere = (
        {"host": "evil.example"},
        {"host": "127.0.0.1:9999"},
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    )
    for path, methods in document()["paths"].items():
        filled = path.replace("{case_id}", "ABC-234").replace("{name}", "a.jpg")
        for method in methods:
            for headers in elsewhere:
                answer = client.request(method.upper(), filled, headers=headers)
                assert answer.status_code == 403, (method, path, headers)


def test_every_route_but_the_session_needs_a_session(stranger: TestClient) -> None:
    for path, methods in document()["paths"].items():
        if path == f"{API}/session":
            continue
        filled = path.replace("{case_id}", "ABC-234").replace("{name}", "a.jpg")
        for method in methods:
            assert stranger.request(method.upper(), filled).status_code == 401, (method, path)


def test_a_page_of_another_site_may_link_here_but_not_ask(client: TestClient) -> None:
    link = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert client.get("/", headers=link).status_code == 200
    assert client.get(f"{API}/cases", headers=link).status_code == 403


def test_answers_let_nothing_from_outside_run(client: TestClient) -> None:
    for path in ("/", f"{API}/cases", f"{API}/nothing"):
        policy = client.get(path).headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "script-src 'self'" in policy
        assert "unsafe" not in policy


@pytest.mark.parametrize(
    "path",
    [
        "/../secret",
        "/%2e%2e/secret",
        "/assets/..%2f..%2fsecret",
        "/assets/%2e%2e/%2e%2e/pace.json",
        f"{API}/cases/../session",
        f"{API}/cases/ABC-234%2f..%2f..",
        f"{API}/cases/ABC-234/exports/..%2f..%2fcase.json",
        f"{API}/cases/ABC-234/photos/..%2fcase.json/file",
    ],
)
def test_no_path_leads_out_of_its_folder(
    client: TestClient, app_state: AppState, path: str
) -> None:
    (app_state.shelf.root.parent / "secret").write_text("of somebody else", "utf-8")
    (app_state.shelf.root / "pace.json").write_text("of somebody else", "utf-8")
    (app_state.shelf.root / "ABC-234").mkdir()
    answer = client.get(path)
    assert "of somebody else" not in answer.text
    assert answer.status_code < 500


def test_a_request_that_is_too_large_is_not_read(client: TestClient) -> None:
    large = client.post(f"{API}/cases", content=bytes(9_000_000))
    assert large.status_code == 413
    unsaid = client.post(f"{API}/cases", content=(bytes(100_000) for _ in range(100)))
    assert 400 <= unsaid.status_code < 500
    assert client.get(f"{API}/cases").json()["cases"] == []


def test_only_a_file_that_is_sent_may_be_large(client: TestClient) -> None:
    file = f"{API}/cases/ABC-234/photos/a.jpg"
    assert client.post(file, content=bytes(9_000_000)).status_code == 413
    assert client.put(file, content=bytes(9_000_000)).status_code == 404


@pytest.mark.parametrize("path", ["/a%00.js", f"/{'a' * 300}.js"], ids=["NUL", "too long"])
def test_a_name_that_no_file_can_have_is_no_file(client: TestClient, path: str) -> None:
    assert client.get(path).status_code == 404


def test_signing_in_while_sessions_are_looked_through_harms_neither(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = Access(frozenset())
    first = made.begin("first")
    last = made.begin("last")
    same = access._same

    def same_while_others_sign_in(one: str, other: str) -> bool:
        made.begin("another")
        made.new_link_token()
        return same(one, other)

    token = [made.new_link_token() for _ in range(2)][1]
    monkeypatch.setattr(access, "_same", same_while_others_sign_in)
    assert made.is_open(last)
    assert made.open_session(token)
    made.close_session(first)
    assert not made.is_open(first)


@pytest.mark.parametrize(("piece", "whole"), [(1, False), (2000, True)])
def test_a_request_that_comes_drop_by_drop_is_given_up(
    monkeypatch: pytest.MonkeyPatch, piece: int, whole: bool
) -> None:
    """Each piece comes in time; all of them at 50 and at 100,000 bytes a second."""
    monkeypatch.setattr(access, "_SILENCE_S", 0.5)
    sent = iter(range(60))

    async def receive() -> access.Message:
        await asyncio.sleep(0.02)
        return {
            "type": "http.request",
            "body": bytes(piece),
            "more_body": next(sent) < 59,
        }

    async def kinds() -> list[str]:
        bounded, found = access._bounded(receive, None), list[str]()
        while True:
            message = await bounded()
            found.append(message["type"])
            if message["type"] == "http.disconnect" or not message["more_body"]:
                return found

    found = asyncio.run(kinds())
    assert (found[-1] == "http.request") is whole
    assert len(found) == 60 if whole else 2 < len(found) < 40


def test_a_fault_of_ours_is_no_missing_thing(
    client: TestClient, app_state: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fault(*_: object) -> None:
        raise KeyError("frame")

    case = client.post(f"{API}/cases", json={}).json()["id"]
    assert client.get(f"{API}/cases/ABC-234").status_code == 404
    monkeypatch.setattr(type(app_state.overviews), "of", fault)
    with pytest.raises(KeyError):
        client.get(f"{API}/cases/{case}")


def test_a_route_that_is_none_says_so(client: TestClient) -> None:
    for answer in (client.get(f"{API}/nothing"), client.put(f"{API}/cases")):
        assert answer.status_code in (404, 405)
        assert answer.json()["message"]


def test_the_clients_files_travel_compressed_where_that_is_understood(tmp_path: Path) -> None:
    text = "const some = 'text';\n" * 500
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html><title>limbgram</title>", "utf-8")
    (tmp_path / "assets" / "a.js").write_text(text, "utf-8")
    app_state = AppState(Shelf(tmp_path / "cases"), Access(frozenset({"127.0.0.1:8000"})))
    with TestClient(guarded(app_state, tmp_path), base_url="http://127.0.0.1:8000") as client:
        small = client.get("/assets/a.js", headers={"accept-encoding": "br, gzip"})
        plain = client.get("/assets/a.js", headers={"accept-encoding": "identity"})
        assert small.headers["content-encoding"] == "gzip"
        assert int(small.headers["content-length"]) < 500
        assert "content-encoding" not in plain.headers
        assert small.text == plain.text == text
        assert small.headers["content-type"] == plain.headers["content-type"]
        (tmp_path / "assets" / "a.js").write_text(text + "more", "utf-8")
        assert client.get("/assets/a.js").text == text + "more"


def test_one_sample_is_made_at_a_time(client: TestClient, app_state: AppState) -> None:
    with app_state.sampling:
        assert client.post(f"{API}/cases/sample").status_code == 409
    assert client.get(f"{API}/cases").json()["cases"] == []
