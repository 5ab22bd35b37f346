"""The app on a network: users, what they may do, the lock, the log, and the encrypted socket."""

import asyncio
import contextlib
import hashlib
import json
import shutil
import socket
import ssl
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from argon2 import PasswordHasher
from fastapi.testclient import TestClient
from tests.unit.file_sizes import require_takes_up_to
from typer.testing import CliRunner

from limbgram.app import network_server as network_module
from limbgram.app import phone as phone_module
from limbgram.app.access import Access, Guard
from limbgram.app.journal import Journal
from limbgram.app.local_server import EndingServer, ServeOptions, socket_at
from limbgram.app.network_server import NetworkOptions, Reached, names_of, serve_on_network
from limbgram.app.openapi import document
from limbgram.app.password_attempts import Attempts
from limbgram.app.phone_port import PhonePorts
from limbgram.app.server_socket import ImpatientProtocol
from limbgram.app.state import AppState
from limbgram.app.tls_certificates import given_certificate, own_certificate
from limbgram.app.users import Users, make_private
from limbgram.cases.shelf import Shelf
from limbgram.cli.main import app
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.ply import write_ply

API = "/api/v1"
HOST = "192.168.1.20:8443"
NAME, PASSWORD = "A. Meier", "table river candle seven"
QUICK = PasswordHasher(time_cost=1, memory_cost=8 * 1024, parallelism=1)
"""The same function, weaker, so that tests do not wait."""


@pytest.fixture
def users(tmp_path: Path) -> Users:
    made = Users(tmp_path / "cases" / "access", QUICK)
    made.add(NAME, PASSWORD)
    return made


@pytest.fixture
def now() -> list[float]:
    return [1000.0]


@pytest.fixture
def app_state(tmp_path: Path, users: Users, now: list[float]) -> AppState:
    access = Access(
        frozenset({HOST}),
        "https",
        clock=lambda: now[0],
        people=users,
        lock_after_s=900,
        attempts=Attempts(lambda: now[0]),
    )
    doors = PhonePorts(diary=Journal(tmp_path / "cases" / "access"))
    shelf = Shelf(tmp_path / "cases")
    return AppState(shelf, access, phone_ports=doors, origin=lambda: f"https://{HOST}")


@pytest.fixture
def stranger(app_state: AppState, serve: Callable[[AppState], Guard]) -> Iterator[TestClient]:
    with TestClient(serve(app_state), base_url=f"https://{HOST}") as client:
        yield client


@pytest.fixture
def client(stranger: TestClient) -> TestClient:
    """Somebody who signed in."""
    assert sign_in(stranger).status_code == 200
    return stranger


def sign_in(client: TestClient, name: str = NAME, password: str = PASSWORD) -> httpx.Response:
    return client.post(f"{API}/session/sign-in", json={"name": name, "password": password})


def acts(app_state: AppState) -> list[tuple[str, str, int]]:
    lines = Journal(app_state.shelf.root / "access").lines()
    return [(one.act.who, one.act.act, one.act.status) for one in lines if one.act]


def test_passwords_are_kept_as_argon2_and_nowhere_else(tmp_path: Path) -> None:
    users = Users(tmp_path / "access")
    users.add(NAME, PASSWORD)
    kept = users.file.read_text("utf-8")
    assert "$argon2id$" in kept
    assert PASSWORD not in kept
    assert users.is_right("a. meier", PASSWORD)
    assert not users.is_right(NAME, PASSWORD + ".")
    assert not users.is_right("nobody", PASSWORD)
    if sys.platform != "win32":
        assert stat.S_IMODE(users.file.stat().st_mode) == 0o600
        assert stat.S_IMODE(users.folder.stat().st_mode) == 0o700


@pytest.mark.parametrize(
    ("name", "password"),
    [
        ("B", "short"),
        ("B", "aaaaaaaaaaaaaaaa"),
        ("Baumann", "baumann-baumann-1"),
        ("B", "x" * 201),
        ("", PASSWORD),
        ("../B", PASSWORD),
        ("B\n", "\n" * 20),
        ("B" * 41, PASSWORD),
        (NAME.upper(), PASSWORD),
    ],
)
def test_weak_passwords_and_odd_names_are_refused(users: Users, name: str, password: str) -> None:
    with pytest.raises(OptionsError):
        users.add(name, password)
    assert [one.name for one in users.all()] == [NAME]


def test_a_password_has_12_to_200_letters(users: Users) -> None:
    for name, letters in (("Baumann", 12), ("Curie", 200)):
        users.add(name, ("clear sky at noon " * 12)[:letters])
    for letters in (11, 201):
        with pytest.raises(OptionsError) as refused:
            users.add("Dunant", ("clear sky at noon " * 12)[:letters])
        assert refused.value.finding.code == "app.user.password_length"


def test_a_damaged_list_of_users_lets_nobody_in(users: Users) -> None:
    users.file.write_text('{"users": [{"name": "A. Meier"}]}', "utf-8")
    with pytest.raises(CaseError, match="damaged"):
        users.is_right(NAME, PASSWORD)


def test_nothing_but_signing_in_answers_a_stranger(stranger: TestClient) -> None:
    open_paths = (f"{API}/session", f"{API}/session/sign-in")
    for path, methods in document()["paths"].items():
        filled = path.replace("{case_id}", "ABC-234").replace("{name}", "a.jpg")
        for method in methods:
            if path not in open_paths:
                answer = stranger.request(method.upper(), filled)
                assert answer.status_code == 401, (method, path)
                assert "password" in answer.json()["message"]
    assert stranger.get(f"{API}/session").json()["network"]
    assert not stranger.get(f"{API}/session").json()["open"]


def test_who_signed_in_may_work_and_is_named(client: TestClient) -> None:
    assert sign_in(client, NAME.upper()).status_code == 200
    said = client.get(f"{API}/session").json()
    assert (said["open"], said["user"], said["lock_after_s"]) == (True, NAME, 900)
    assert client.get(f"{API}/cases").status_code == 200


def test_the_cookie_goes_by_encrypted_lines_alone(stranger: TestClient) -> None:
    said = sign_in(stranger).headers["set-cookie"].lower()
    assert "secure" in said
    assert "httponly" in said
    assert "samesite=strict" in said


def test_wrong_names_and_wrong_passwords_look_the_same(stranger: TestClient) -> None:
    one, other = sign_in(stranger, password="wrong wrong wrong"), sign_in(stranger, "Nobody")
    assert one.status_code == other.status_code == 401
    assert one.json() == other.json()
    assert stranger.get(f"{API}/cases").status_code == 401


def test_guessing_is_slowed_down_and_the_user_is_not_shut_out(
    stranger: TestClient, now: list[float]
) -> None:
    for _ in range(5):
        assert sign_in(stranger, password="wrong wrong wrong").status_code == 401
    slowed = sign_in(stranger)
    assert slowed.status_code == 429, "also a right password waits"
    assert int(slowed.headers["retry-after"]) == 1
    now[0] += 1.01
    assert sign_in(stranger, password="wrong wrong wrong").status_code == 401
    assert int(sign_in(stranger).headers["retry-after"]) == 2
    now[0] += 2.01
    assert sign_in(stranger).status_code == 200
    assert sign_in(stranger, password="wrong wrong wrong").status_code == 401, "forgotten"


def test_waits_end_and_do_not_fill_the_memory() -> None:
    now = [0.0]
    attempts = Attempts(lambda: now[0])
    for _ in range(40):
        attempts.failed("A", "10.0.0.1")
        now[0] += 301
    assert attempts.wait_s("A", "10.0.0.1") == 0
    attempts.failed("A", "10.0.0.1")
    assert attempts.wait_s("A", "10.0.0.9") <= 30, "of a name: nobody is kept out for long"
    assert 100 < attempts.wait_s("B", "10.0.0.1") <= 300, "of an address"
    now[0] += 1000
    assert attempts.wait_s("A", "10.0.0.1") == 0
    for k in range(20_100):
        attempts.failed(f"name {k}", f"address {k}")
    assert len(attempts._wrong) <= 10_000


def test_the_wrong_password_of_longest_ago_is_forgotten_beyond_ten_thousand_keys() -> None:
    """Each attempt has two: its name and its address."""
    for others, waits in ((4999, True), (5000, False)):
        attempts = Attempts(lambda: 0.0)
        for _ in range(6):
            attempts.failed("A", "10.0.0.1")
        for number in range(others):
            attempts.failed(f"user {number}", f"host {number}")
        assert (attempts.wait_s("A", "10.0.0.1") > 0) == waits


def test_a_page_in_which_nobody_did_anything_is_locked(
    client: TestClient, now: list[float]
) -> None:
    case = client.post(f"{API}/cases", json={}).json()["id"]
    for _ in range(10):
        now[0] += 80
        assert client.get(f"{API}/cases").status_code == 200, "looking on by itself is no act"
    now[0] += 110
    locked = client.get(f"{API}/cases")
    assert locked.status_code == 423
    assert client.put(f"{API}/cases/{case}/photos/a.jpg", content=b"x").status_code == 423
    assert client.post(f"{API}/session/stay").status_code == 423, "nobody unlocks it by staying"
    assert client.post(f"{API}/session/links").status_code == 423
    assert client.get(f"{API}/session").json()["locked"]
    wrong = client.post(f"{API}/session/unlock", json={"password": "wrong wrong wrong"})
    assert wrong.status_code == 401
    right = client.post(f"{API}/session/unlock", json={"password": PASSWORD})
    assert right.json()["open"]
    assert client.get(f"{API}/cases").status_code == 200


def test_who_moves_in_the_page_is_not_locked_out(client: TestClient, now: list[float]) -> None:
    for _ in range(4):
        now[0] += 600
        assert client.post(f"{API}/session/stay").status_code == 204
    assert client.post(f"{API}/session/lock").status_code == 204
    assert client.get(f"{API}/cases").status_code == 423


def test_who_is_removed_or_gets_another_password_is_out_at_once(
    client: TestClient, users: Users
) -> None:
    elsewhere = Users(users.folder, QUICK)  # the command line beside the app
    assert client.get(f"{API}/cases").status_code == 200
    elsewhere.change(NAME, "another river candle seven")
    assert client.get(f"{API}/cases").status_code == 401
    assert sign_in(client, password="another river candle seven").status_code == 200
    elsewhere.remove(NAME)
    assert client.get(f"{API}/cases").status_code == 401
    assert sign_in(client, password="another river candle seven").status_code == 401


def test_the_phone_of_a_user_who_is_removed_is_out_and_its_port_closes(
    client: TestClient, users: Users, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(phone_module, "own_address", lambda: "127.0.0.1")
    case = client.post(f"{API}/cases", json={}).json()["id"]
    opened = client.post(f"{API}/cases/{case}/phone").json()
    with httpx.Client(base_url=opened["url"].partition("/start")[0], timeout=20) as phone:
        assert phone.get(opened["url"]).status_code == 200
        photos = f"{API}/cases/{case}/photos"
        assert phone.get(photos).status_code == 200
        Users(users.folder, QUICK).remove(NAME)  # the command line beside the app
        with contextlib.suppress(httpx.TransportError):  # it may be closed already
            assert phone.get(photos).status_code == 401
    port = int(opened["url"].split("/")[2].rpartition(":")[2])
    given_up = time.monotonic() + 60
    while listens(port):
        assert time.monotonic() < given_up, "the door stays open"
        time.sleep(0.1)


def listens(port: int) -> bool:
    with socket.socket() as asking:
        return asking.connect_ex(("127.0.0.1", port)) == 0


def test_a_link_works_under_the_name_of_who_made_it(
    client: TestClient, app_state: AppState
) -> None:
    link = client.post(f"{API}/session/links").json()["url"]
    client.cookies.clear()
    assert client.get(link).status_code == 200
    assert client.get(f"{API}/session").json()["user"] == NAME
    token = app_state.access.new_link_token()
    client.cookies.clear()
    client.get(f"/start?token={token}")
    assert client.get(f"{API}/cases").status_code == 401, "of nobody"


def test_the_log_says_who_did_what_and_no_patient(client: TestClient, app_state: AppState) -> None:
    case = client.post(f"{API}/cases", json={"note": "Frau Huber"}).json()["id"]
    client.get(f"{API}/cases/{case}")
    client.get(f"{API}/cases/{case}")
    client.get(f"{API}/cases")
    client.put(f"{API}/cases/{case}/photos/huber.jpg", content=b"no photo")
    client.post(f"{API}/cases/{case}/job/cancel")
    client.delete(f"{API}/cases/{case}")
    sign_in(client, "Nobody", "wrong wrong wrong")
    assert acts(app_state) == [
        (NAME, "sign_in", 200),
        (NAME, "new_case", 201),
        (NAME, "read_case", 200),
        (NAME, "put_photo", 200),
        (NAME, "cancel_job", 409),
        (NAME, "delete_case", 204),
        ("unknown", "sign_in", 401),
    ]
    text = (app_state.shelf.root / "access" / "log.jsonl").read_text("utf-8")
    assert "uber" not in text
    assert text.count(case) == 5
    if sys.platform != "win32":
        assert stat.S_IMODE((app_state.shelf.root / "access" / "log.jsonl").stat().st_mode) == 0o600


def test_pieces_of_a_file_are_one_line(client: TestClient, app_state: AppState) -> None:
    case = client.post(f"{API}/cases", json={}).json()["id"]
    for k in range(4):
        told = {"content-range": f"bytes {10 * k}-{10 * k + 9}/40"}
        client.put(f"{API}/cases/{case}/photos/a.jpg", content=bytes(10), headers=told)
    assert [act for _, act, _ in acts(app_state)].count("put_photo") == 1


def test_only_a_file_comes_in_pieces(client: TestClient, app_state: AppState) -> None:
    case = client.post(f"{API}/cases", json={}).json()["id"]
    piece = {"content-range": "bytes 0-0/10"}
    assert client.delete(f"{API}/cases/{case}", headers=piece).status_code == 204
    assert acts(app_state)[-1] == (NAME, "delete_case", 204)


def test_no_path_puts_words_into_the_log_or_breaks_it(
    client: TestClient, app_state: AppState
) -> None:
    assert client.delete(f"{API}/cases/Frau Huber").status_code == 422
    assert client.delete(f"{API}/cases/{'x' * 5000}").status_code == 422
    client.post(f"{API}/cases", json={})
    journal = Journal(app_state.shelf.root / "access")
    assert b"uber" not in journal.file.read_bytes()
    assert all(one.whole for one in journal.lines())
    assert [act for _, act, _ in acts(app_state)] == [
        "sign_in", "delete_case", "delete_case", "new_case"
    ]  # fmt: skip


def test_a_case_is_shown_once_the_log_has_that_it_was_opened(
    client: TestClient, app_state: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    with monkeypatch.context() as meanwhile:
        meanwhile.setattr(Journal, "write", full)
        assert [client.get(case).status_code for _ in range(2)] == [507, 507]
    assert [client.get(case).status_code for _ in range(2)] == [200, 200]
    assert [act for _, act, _ in acts(app_state)] == ["sign_in", "new_case", "read_case"]


def test_a_case_is_opened_by_whatever_is_read_of_it_first(
    client: TestClient, app_state: AppState
) -> None:
    """As by a bookmark of a photo."""
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    client.put(f"{case}/photos/a.jpg", content=b"no photo")
    client.get(f"{case}/thumbnail")
    client.get(f"{case}/photos")
    client.get(f"{case}/photos/a.jpg/picture")
    client.get(case)
    assert [act for _, act, _ in acts(app_state)][2:] == ["put_photo", "list_photos"]
    sign_in(client)
    client.post(f"{case}/compare", json={})
    client.get(f"{case}/contents")
    client.get(f"{case}/photos")
    assert [act for _, act, _ in acts(app_state)][5:] == ["compare_with", "list_contents"]


def test_another_case_that_is_read_is_in_the_log_too(
    client: TestClient, app_state: AppState, limb: Mesh
) -> None:
    """Compared with, proposed from, or learned from; the log had the case in the path alone."""
    ids: list[str] = []
    for _ in range(3):
        ids.append(client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"])
        folder = app_state.shelf.root / ids[-1] / "deliverables"
        folder.mkdir()
        write_ply(limb, folder / "surface.ply", "mm")
    here, there, third = ids
    case = f"{API}/cases/{here}"
    began = len(acts(app_state))
    client.get(case)
    client.get(f"{case}/limb/guesses/{there}")
    for _ in range(2):
        assert client.post(f"{case}/compare", json={"of": "scan", "case": third}).is_success
    client.get(f"{API}/cases/{third}")
    client.post(f"{API}/templates", json={"name": "a", "cases": [there]})
    lines = Journal(app_state.shelf.root / "access").lines()
    told = [(one.act.act, one.act.case) for one in lines if one.act is not None]
    assert told[began:] == [
        ("read_case", here),
        ("list_carried_guesses", there),
        ("compare_with", third),
        ("learn_template", there),
    ]


def test_a_log_that_was_changed_says_where(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "access")
    for k in range(6):
        journal.write("A", "10.0.0.1", f"act {k}")
    lines = journal.file.read_bytes().splitlines(keepends=True)
    assert all(one.whole for one in journal.lines())
    for changed, wrong in (
        ([*lines[:2], lines[2].replace(b"act 2", b"act 7"), *lines[3:]], [2, 3]),
        ([*lines[:2], *lines[3:]], [2]),
        ([*lines[:2], lines[4], *lines[2:]], [2, 3]),
        ([lines[1], lines[0], *lines[2:]], [0, 1, 2]),
    ):
        journal.file.write_bytes(b"".join(changed))
        found = [k for k, one in enumerate(journal.lines()) if not one.whole]
        assert found[:1] == wrong[:1]
        assert set(found) <= set(wrong)


def test_a_log_that_was_made_anew_or_cut_off_is_not_whole(tmp_path: Path, state: Path) -> None:
    """By somebody who can write in the shelf, and knows how seals were made without a key."""
    journal = Journal(tmp_path / "access")
    for k in range(6):
        journal.write("A", "10.0.0.1", f"act {k}")
    written = journal.file.read_bytes()
    lines = written.splitlines(keepends=True)

    def forged(acts: list[bytes]) -> bytes:
        seal, made = "0" * 32, b""
        for one in acts:
            text = one.rpartition(b',"seal"')[0].decode() + "}"
            seal = hashlib.sha256(f"{seal}{text}".encode()).hexdigest()[:32]
            made += f'{text[:-1]},"seal":"{seal}"}}\n'.encode()
        return made

    for changed in (forged([*lines[:2], *lines[3:]]), b"".join(lines[:4]), b""):
        journal.file.write_bytes(changed)
        assert not all(one.whole for one in journal.lines())
        journal.write("A", "", "goes on")
        assert not all(one.whole for one in journal.lines()), "what is added does not heal it"
        journal.file.write_bytes(written)
        journal.anchor_file.write_bytes(
            journal.anchor_file.read_bytes().replace(
                json.loads(journal.anchor_file.read_bytes())["last"].encode(),
                json.loads(lines[-1])["seal"].encode(),
            )
        )
        assert all(one.whole and one.proved for one in journal.lines())
    assert journal.anchor_file.is_relative_to(state)
    if sys.platform != "win32":
        assert stat.S_IMODE(journal.anchor_file.stat().st_mode) == 0o600


def test_a_log_of_before_there_was_a_key_goes_on_and_is_not_called_proved(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "access")
    journal.write("A", "", "one")
    journal.write("A", "", "two")
    journal.anchor_file.unlink()
    journal.begin()
    journal.write("A", "", "three")
    found = [(one.act.act if one.act else "", one.proved) for one in journal.lines()]
    assert found == [("one", False), ("two", False), ("three", True)]
    assert all(one.whole for one in journal.lines())


def test_a_log_whose_key_stayed_behind_is_unproved_and_not_called_changed(tmp_path: Path) -> None:
    """As on another machine, before the app runs there and afterwards."""
    journal = Journal(tmp_path / "access")
    show = ["app", "log", "--cases", str(tmp_path)]
    journal.write("A", "", "one")
    journal.write("A", "", "two")
    journal.anchor_file.unlink()
    moved = CliRunner().invoke(app, show)
    assert moved.exit_code == 0, moved.output
    assert "The first 2 lines were not written with this account" in moved.output
    journal.begin()
    journal.write("A", "", "three")
    later = CliRunner().invoke(app, show)
    assert later.exit_code == 0, later.output
    assert "  three" in CliRunner().invoke(app, [*show, "--user", "a"]).output
    written = journal.file.read_bytes()
    for changed in (written.replace(b"one", b"eno"), written.partition(b"\n")[2]):
        journal.file.write_bytes(changed)
        assert CliRunner().invoke(app, show).exit_code == 7
    journal.file.write_bytes(written[: written.rindex(b"\n", 0, -1) + 1])
    cut_off = json.loads(CliRunner().invoke(app, [*show, "--json"]).output)
    assert (cut_off["lines"], cut_off["broken"]) == (2, [3])


def test_a_folder_without_a_log_is_told_as_such(tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, ["app", "log", "--cases", str(tmp_path / "nowhere")])
    assert "There is no log" in shown.output


@pytest.mark.parametrize("lost", ["file", "folder", "damaged"])
def test_an_act_is_not_confirmed_where_the_key_of_the_log_is_gone(
    client: TestClient, app_state: AppState, state: Path, lost: str
) -> None:
    """Another one made without a word would leave all earlier lines unproved."""
    journal = Journal(app_state.shelf.root / "access")
    assert client.post(f"{API}/cases", json={}).status_code == 201
    kept, lines = journal.anchor_file.read_bytes(), journal.file.read_bytes()
    if lost == "file":
        journal.anchor_file.unlink()
    elif lost == "folder":
        shutil.rmtree(journal.anchors)
    else:
        journal.anchor_file.write_bytes(b'{"key": ')
    answer = client.post(f"{API}/cases", json={})
    assert answer.status_code == 507
    assert "key" in answer.json()["message"]
    assert str(state) not in answer.json()["message"]
    assert journal.file.read_bytes() == lines
    make_private(journal.anchors)
    journal.anchor_file.write_bytes(kept)
    assert client.post(f"{API}/cases", json={}).status_code == 201
    assert all(one.whole and one.proved for one in journal.lines())


def test_a_line_that_could_not_be_noted_outside_is_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal(tmp_path / "access")
    journal.write("A", "", "one")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as broken:
        broken.setattr("limbgram.app.journal.write_json", full)
        with pytest.raises(OSError, match="space"):
            journal.write("A", "", "two")
    journal.write("A", "", "three")
    found = [(one.act.act if one.act else "", one.whole) for one in journal.lines()]
    assert found == [("one", True), ("three", True)]


def test_a_line_that_was_cut_off_does_not_hide_the_next(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "access")
    journal.write("A", "", "one")
    with journal.file.open("ab") as stream:
        stream.write(b'{"at":"2026-')
    journal.write("A", "", "two")
    journal.write("A", "", "three")
    found = [(one.act.act if one.act else "", one.whole) for one in journal.lines()]
    assert found == [("one", True), ("", False), ("two", True), ("three", True)]


def test_two_programs_write_one_log(tmp_path: Path) -> None:
    def many(name: str) -> None:
        own = Journal(tmp_path / "access")
        for k in range(40):
            own.write(name, "", f"act {k}")

    threads = [threading.Thread(target=many, args=(name,)) for name in "AB"]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    lines = list(Journal(tmp_path / "access").lines())
    assert len(lines) == 80
    assert all(one.whole for one in lines)


def test_an_act_that_cannot_be_written_down_is_not_confirmed(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Journal, "write", full)
    answer = client.post(f"{API}/cases", json={})
    assert answer.status_code == 507
    assert "log" in answer.json()["message"]
    assert client.get(f"{API}/cases").status_code == 200


def test_a_certificate_is_kept_until_it_does_not_fit(tmp_path: Path) -> None:
    first = own_certificate(tmp_path, ("192.168.1.20", "sock.local"))
    assert own_certificate(tmp_path, ("192.168.1.20",)).fingerprint == first.fingerprint
    other = own_certificate(tmp_path, ("192.168.1.21", "sock.local"))
    assert other.fingerprint != first.fingerprint
    if sys.platform != "win32":
        assert stat.S_IMODE(other.key.stat().st_mode) == 0o600


def test_given_certificates_that_cannot_be_used_say_why(tmp_path: Path) -> None:
    one = own_certificate(tmp_path / "one", ("127.0.0.1",))
    other = own_certificate(tmp_path / "other", ("127.0.0.1",))
    with pytest.raises(OptionsError, match="belongs"):
        given_certificate(one.file, other.key)
    with pytest.raises(OptionsError, match="no certificate"):
        given_certificate(one.key, one.key)
    with pytest.raises(OptionsError, match="cannot be read"):
        given_certificate(tmp_path / "none.pem", one.key)
    with pytest.raises(OptionsError, match="belong together"):
        serve_with(tmp_path, NetworkOptions(address="127.0.0.1", certificate=one.file))


def test_names_are_names_of_machines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network_module, "own_address", lambda: "10.1.2.3")
    monkeypatch.setattr(socket, "gethostname", lambda: "Sock")
    assert names_of(NetworkOptions()) == ("10.1.2.3", "sock", "sock.local")
    assert names_of(NetworkOptions(address="127.0.0.1", names=("a.example",))) == (
        "127.0.0.1",
        "a.example",
    )
    for odd in ("https://a.example", "a:8443", "a b", "-a", ""):
        with pytest.raises(OptionsError):
            names_of(NetworkOptions(names=(odd,)))


def test_without_users_it_does_not_start(tmp_path: Path) -> None:
    with pytest.raises(OptionsError, match="users add"):
        serve_on_network(ServeOptions(cases=tmp_path), NetworkOptions(), lambda _: None)


def serve_with(folder: Path, network: NetworkOptions, on_ready: Any = print) -> None:
    users = Users(folder / "cases" / "access", QUICK)
    if not users.all():
        users.add(NAME, PASSWORD)
    options = ServeOptions(cases=folder / "cases", port=free_port(), no_browser=True)
    serve_on_network(options, network, on_ready)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


@pytest.fixture
def reached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Reached]:
    """The app on an encrypted socket."""
    monkeypatch.setattr(ImpatientProtocol, "head_s", 0.5)
    ready = threading.Event()
    found: list[Reached] = []

    def opened(reached: Reached) -> None:
        found.append(reached)
        ready.set()

    servers: list[EndingServer] = []
    configuring = EndingServer.__init__

    def noted(self: EndingServer, *args: Any, **kwargs: Any) -> None:
        servers.append(self)
        configuring(self, *args, **kwargs)

    monkeypatch.setattr(EndingServer, "__init__", noted)
    serving = threading.Thread(
        target=serve_with, args=(tmp_path, NetworkOptions(address="127.0.0.1"), opened)
    )
    serving.start()
    assert ready.wait(20)
    yield found[0]
    servers[0].should_exit = True
    serving.join(20)


def test_a_connection_sends_each_answer_at_once() -> None:
    """Else asyncio leaves them to Nagle, and each answer takes 40 ms more."""
    prompt: list[int] = []

    async def asked() -> None:
        async def answer(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            line = writer.get_extra_info("socket")
            prompt.append(line.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        listening = socket_at("127.0.0.1", 0)
        async with await asyncio.start_server(answer, sock=listening):
            reader, writer = await asyncio.open_connection(*listening.getsockname())
            await reader.read()
            writer.close()

    asyncio.run(asked())
    assert prompt == [1]


def test_the_socket_is_encrypted_and_a_door_of_it_too(reached: Reached, tmp_path: Path) -> None:
    trust = ssl.create_default_context(cafile=tmp_path / "cases" / "access" / "certificate.pem")
    with httpx.Client(base_url=reached.links[0], verify=trust, timeout=20) as browser:
        assert browser.get(f"{API}/cases").status_code == 401
        signed = browser.post(f"{API}/session/sign-in", json={"name": NAME, "password": PASSWORD})
        assert signed.json()["user"] == NAME
        origin = {"origin": "https://evil.example"}
        assert browser.get(f"{API}/cases", headers=origin).status_code == 403
        assert browser.get(f"{API}/cases", headers={"host": "evil.example"}).status_code == 403
        plain = {"origin": reached.links[0].replace("https", "http")}
        assert browser.get(f"{API}/cases", headers=plain).status_code == 403
        assert browser.get(f"{API}/cases").status_code == 200
    with pytest.raises(httpx.HTTPError):
        httpx.get(reached.links[0].replace("https", "http"))
    served = ssl.get_server_certificate(("127.0.0.1", int(reached.links[0].rpartition(":")[2])))
    digest = given_certificate(*_written(tmp_path, served)).fingerprint
    assert digest == reached.fingerprint
    log = Journal(tmp_path / "cases" / "access").lines()
    assert [one.act.act for one in log if one.act][:2] == ["start_app", "sign_in"]


def test_a_head_that_does_not_come_is_not_waited_for(reached: Reached, tmp_path: Path) -> None:
    trust = ssl.create_default_context(cafile=tmp_path / "cases" / "access" / "certificate.pem")
    port = int(reached.links[0].rpartition(":")[2])
    with (
        socket.create_connection(("127.0.0.1", port), timeout=10) as plain,
        trust.wrap_socket(plain, server_hostname="127.0.0.1") as line,
    ):
        line.sendall(b"GET /api/v1/session HTTP/1.1\r\nHost: ")
        began = time.monotonic()
        assert line.recv(100) == b""
        assert 0.2 < time.monotonic() - began < 5


def _written(folder: Path, pem: str) -> tuple[Path, Path]:
    file = folder / "served.pem"
    file.write_text(pem, "utf-8")
    return file, folder / "cases" / "access" / "key.pem"


def test_users_are_kept_by_commands(tmp_path: Path) -> None:
    run = CliRunner().invoke
    cases = ["--cases", str(tmp_path / "cases")]
    added = run(
        app, ["app", "users", "add", NAME, "--password-stdin", *cases], input=f"{PASSWORD}\n"
    )
    assert added.exit_code == 0, added.output
    again = run(app, ["app", "users", "add", NAME, "--password-stdin", *cases], input="x\n")
    assert again.exit_code == 2
    listed = json.loads(run(app, ["app", "users", "list", "--json", *cases]).output)
    assert [one["name"] for one in listed["users"]] == [NAME]
    assert run(app, ["app", "users", "remove", "Nobody", *cases]).exit_code == 2
    assert run(app, ["app", "users", "remove", NAME, *cases]).exit_code == 0
    shown = run(app, ["app", "log", *cases])
    assert shown.exit_code == 0
    assert f"add_user {NAME}" in shown.output
    log = tmp_path / "cases" / "access" / "log.jsonl"
    log.write_bytes(log.read_bytes().replace(b"add_user", b"bad_user"))
    assert run(app, ["app", "log", *cases]).exit_code == 7
    assert run(app, ["app", "--address", "127.0.0.1", *cases]).exit_code == 2
    assert run(app, ["app", "--network", "--no-browser", *cases]).exit_code == 2, "no users"


def test_certificates_and_users_are_read_up_to_a_megabyte(tmp_path: Path, users: Users) -> None:
    pem = tmp_path / "clinic.pem"
    require_takes_up_to(lambda path: given_certificate(path, path), pem, 1_000_000)
    require_takes_up_to(lambda _: users.all(), users.file, 1_000_000)
