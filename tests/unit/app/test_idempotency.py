"""Acts: what is sent again under its id is done once; changes at once leave each other alone."""

import errno
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from limbgram.app.access import Access
from limbgram.app.server import guarded
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf
from limbgram.cases.workspace import Workspace
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.ply import write_ply
from limbgram.synthetic import SMALL
from limbgram.synthetic.props.limb import make_limb

API = "/api/v1"
HOST = "127.0.0.1:8000"


@pytest.fixture(scope="module")
def limb() -> Mesh:
    """As coarse as it may be: what is asked of it is which act was done."""
    return make_limb(SMALL.kind, SMALL.seed, 12.0, 60.0).mesh


@pytest.fixture
def case(client: TestClient, app_state: AppState, limb: Mesh) -> str:
    """A case with a surface, a place on it, and axes."""
    case_id = client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"]
    folder = app_state.shelf.root / case_id / "deliverables"
    folder.mkdir()
    write_ply(limb, folder / "surface.ply", "mm")
    front = limb.vertices_mm[np.argmax(limb.vertices_mm[:, 1])].tolist()
    root = f"{API}/cases/{case_id}"
    client.put(f"{root}/limb/places/patellar tendon", json={"position_mm": front})
    axes = {"side": "left", "kind": "transtibial", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    assert client.post(f"{root}/limb/align", json=axes).status_code == 200
    return root


def smoothing(passes: int) -> dict[str, Any]:
    return {"kind": "smoothing", "parameters": {"passes": passes}}


def act(number: int) -> dict[str, str]:
    return {"act-id": f"{number:024x}"}


def passes(client: TestClient, case: str) -> list[int]:
    """Of the smoothings in the recipe."""
    edits = client.get(f"{case}/recipe").json()["edits"]
    return [one["parameters"]["passes"] for one in edits]


def readings(client: TestClient, case: str) -> dict[float, float]:
    return {one["height_mm"]: one["girth_mm"] for one in client.get(f"{case}/tape").json()}


def test_an_edit_that_is_sent_twice_under_one_id_is_in_the_recipe_once(
    client: TestClient, case: str
) -> None:
    first = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    again = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    assert (first.status_code, again.status_code) == (201, 201)
    assert again.json() == first.json()
    assert passes(client, case) == [2]
    client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(2))  # meant twice
    assert passes(client, case) == [2, 2]


def test_an_edit_that_comes_eight_times_at_once_under_one_id_is_in_the_recipe_once(
    client: TestClient, case: str
) -> None:
    def add(_: int) -> int:
        return client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1)).status_code

    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(add, range(8))) == {201}
    assert passes(client, case) == [2]


def test_an_act_is_known_to_the_program_that_is_started_again(
    client: TestClient, case: str, app_state: AppState, tmp_path: Path
) -> None:
    first = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    anew = AppState(Shelf(app_state.shelf.root), Access(frozenset({HOST})))
    with TestClient(guarded(anew, tmp_path), base_url=f"http://{HOST}") as other:
        other.get(f"/start?token={anew.access.new_link_token()}")
        again = other.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
        assert again.json() == first.json()
        assert passes(other, case) == [2]


@pytest.mark.parametrize(
    "damaged",
    [
        pytest.param(b"", id="empty", marks=pytest.mark.slow),
        pytest.param(b'{"of": "PO', id="cut"),
        pytest.param(b"\xff\xfe", id="none", marks=pytest.mark.slow),
    ],
)
def test_an_act_whose_answer_cannot_be_read_is_not_done_a_second_time(
    client: TestClient, app_state: AppState, case: str, damaged: bytes
) -> None:
    client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    kept = app_state.shelf.root / case.rpartition("/")[2] / ".acts" / f"{1:024x}.json"
    kept.write_bytes(damaged)
    again = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    assert (again.status_code, again.json()["finding"]["code"]) == (409, "app.act_unreadable")
    assert passes(client, case) == [2]
    assert kept.read_bytes() == damaged
    client.post(f"{case}/recipe/edits", json=smoothing(3), headers=act(2))
    assert passes(client, case) == [2, 3], "other acts go on"


def test_an_act_whose_answer_found_no_room_is_not_done_a_second_time(
    client: TestClient, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("limbgram.app.idempotency.write_bytes", full)
    first = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    again = client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    assert (first.status_code, again.json()) == (201, first.json())
    assert passes(client, case) == [2]


def test_an_act_that_was_refused_is_tried_again(client: TestClient, case: str) -> None:
    assert (
        client.post(f"{case}/recipe/edits", json=smoothing(-1), headers=act(1)).status_code == 422
    )
    assert client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1)).status_code == 201
    assert passes(client, case) == [2]


def test_an_id_answers_for_its_own_act_alone(client: TestClient, case: str) -> None:
    client.post(f"{case}/recipe/edits", json=smoothing(2), headers=act(1))
    assert client.post(f"{case}/recipe/undo", headers=act(1)).json()["recipe"]["edits"] == []


def test_a_case_that_is_made_twice_under_one_id_is_one(client: TestClient) -> None:
    made = [client.post(f"{API}/cases", json={}, headers=act(1)).json()["id"] for _ in range(2)]
    assert made[0] == made[1]
    assert len(client.get(f"{API}/cases").json()["cases"]) == 1


def test_an_id_holds_for_the_body_that_was_sent_with_it(client: TestClient) -> None:
    left = client.post(f"{API}/cases", json={"side": "left"}, headers=act(1))
    assert left.status_code == 201
    corrected = client.post(f"{API}/cases", json={"side": "right"}, headers=act(1))
    assert corrected.status_code == 409, "else a left case is opened for a right limb"
    again = client.post(f"{API}/cases", json={"side": "left"}, headers=act(1))
    assert again.json() == left.json()
    (only,) = client.get(f"{API}/cases").json()["cases"]
    assert only["side"] == "left"


def test_only_an_answer_that_is_given_again_says_so(client: TestClient) -> None:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
    first = client.patch(case, json={"note": "old"}, headers=act(1))
    client.patch(case, json={"note": "new"}, headers=act(2))
    again = client.patch(case, json={"note": "old"}, headers=act(1))
    assert again.json()["note"] == "old"
    assert [one.headers.get("act-replayed") for one in (first, again)] == [None, "1"]
    assert client.get(case).json()["note"] == "new"


def test_of_a_case_that_is_deleted_no_act_is_kept_but_its_deletion(
    client: TestClient, app_state: AppState
) -> None:
    stays = client.post(f"{API}/cases", json={"note": "stays"}, headers=act(1)).json()["id"]
    goes = client.post(f"{API}/cases", json={"note": "goes for good"}, headers=act(2)).json()["id"]
    deleted = [client.delete(f"{API}/cases/{goes}", headers=act(3)) for _ in range(2)]
    assert [one.status_code for one in deleted] == [204, 204]
    assert [one.content for one in deleted] == [b"", b""]
    kept = [file.read_text("utf-8") for file in (app_state.shelf.root / ".acts").iterdir()]
    assert not any("goes for good" in one for one in kept)
    again = client.post(f"{API}/cases", json={"note": "stays"}, headers=act(1))
    assert again.json()["id"] == stays
    assert client.delete(f"{API}/cases/{goes}", headers=act(4)).status_code == 404


def test_answers_go_with_their_case_and_no_more_than_a_hundred_are_kept(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    for number in range(103):
        client.patch(f"{API}/cases/{case_id}", json={"note": f"{number}"}, headers=act(number))
    kept = app_state.shelf.root / case_id / ".acts"
    assert len(list(kept.iterdir())) == 100
    assert client.delete(f"{API}/cases/{case_id}", headers=act(200)).status_code == 204
    assert not kept.parent.exists()


def test_readings_that_come_at_once_are_all_kept(client: TestClient, case: str) -> None:
    heights = [20.0 * k for k in range(1, 13)]

    def read(height_mm: float) -> int:
        body = {"height_mm": height_mm, "girth_mm": 300 + height_mm}
        return client.patch(f"{case}/tape", json=body).status_code

    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(read, heights)) == {200}
    assert readings(client, case) == {height: 300 + height for height in heights}


def test_a_reading_is_changed_and_taken_back_by_itself(client: TestClient, case: str) -> None:
    for height_mm, girth_mm in [(100.0, 300.0), (20.0, 250.0), (100.0, 301.5), (20.0, None)]:
        body = {"height_mm": height_mm, "girth_mm": girth_mm}
        assert client.patch(f"{case}/tape", json=body).status_code == 200
    assert readings(client, case) == {100.0: 301.5}
    no_girth = client.patch(f"{case}/tape", json={"height_mm": 60.0, "girth_mm": 3.0})
    assert no_girth.status_code == 422
    assert readings(client, case) == {100.0: 301.5}


def test_what_is_said_of_a_case_at_once_is_all_kept(client: TestClient) -> None:
    said = [{"side": "left"}, {"kind": "foot"}, {"note": "second"}, {"archived": True}]
    for _ in range(10):
        case = f"{API}/cases/" + client.post(f"{API}/cases", json={}).json()["id"]
        with ThreadPoolExecutor(4) as pool:
            for answer in [pool.submit(client.patch, case, json=one) for one in said]:
                assert answer.result().status_code == 200
        found = client.get(case).json()
        assert {name: found[name] for one in said for name in one} == {
            name: value for one in said for name, value in one.items()
        }


def test_a_number_meets_the_edit_that_was_seen_under_it_or_none(
    client: TestClient, case: str
) -> None:
    for number in (1, 2, 3):
        client.post(f"{case}/recipe/edits", json=smoothing(number))
    seen = client.get(f"{case}/recipe").json()["mark"]
    edits = f"{case}/recipe/edits"

    # One window takes out two edits, the second before the first is answered.
    assert client.delete(f"{edits}/1?seen={seen}", headers=act(1)).status_code == 200
    assert client.delete(f"{edits}/1?seen={act(1)['act-id']}", headers=act(2)).status_code == 200
    assert passes(client, case) == [3]
    # Whoever asks before an answer came is told whose changes the recipe has in it already.
    assert client.get(f"{case}/recipe").json()["act"] == act(2)["act-id"]

    # Another one still shows all three: its number 1 is gone.
    late = client.patch(f"{edits}/1?seen={seen}", json={"on": False}, headers=act(3))
    assert late.status_code == 409
    assert client.post(f"{case}/recipe/undo?seen={seen}", headers=act(4)).status_code == 409
    # What hung on the act that was refused is refused too.
    after = client.delete(f"{edits}/1?seen={act(3)['act-id']}", headers=act(5))
    assert after.status_code == 409
    assert passes(client, case) == [3]
    assert client.get(f"{case}/recipe").json()["edits"][0]["on"]


def test_a_recipe_takes_the_place_of_the_one_that_was_seen_or_of_none(
    client: TestClient, case: str
) -> None:
    client.post(f"{case}/recipe/edits", json=smoothing(1))
    seen = client.get(f"{case}/recipe").json()["mark"]
    text = {"toml": client.get(f"{case}/recipe/file").text}
    client.post(f"{case}/recipe/edits", json=smoothing(2))  # in another window
    assert client.put(f"{case}/recipe/file?seen={seen}", json=text).status_code == 409
    assert passes(client, case) == [1, 2]
    seen = client.get(f"{case}/recipe").json()["mark"]
    assert client.put(f"{case}/recipe/file?seen={seen}", json=text).status_code == 200
    assert passes(client, case) == [1]


def test_undo_and_redo_are_told_to_other_windows(
    client: TestClient, case: str, app_state: AppState
) -> None:
    case_id = case.rpartition("/")[2]
    client.post(f"{case}/recipe/edits", json=smoothing(2))
    for way in ("undo", "redo"):
        before = app_state.news.of(case_id)["work"]
        assert client.post(f"{case}/recipe/{way}").status_code == 200
        assert app_state.news.of(case_id)["work"] == before + 1
    assert len(Workspace(app_state.shelf.case(case_id)).history().recipes) == 2


def test_an_answer_that_is_a_file_is_given_whatever_id_was_sent(
    client: TestClient, case: str
) -> None:
    """It changes nothing, so it is not kept."""
    asked = [
        (f"{case}/recipe/preview", smoothing(2)),
        (f"{case}/measures.xlsx", {"spacing_mm": 50}),
        (f"{case}/compare/differences", {}),
    ]
    for number, (path, body) in enumerate(asked):
        answers = [client.post(path, json=body, headers=act(number)) for _ in range(2)]
        assert [one.status_code for one in answers] == [200, 200], path
        assert answers[0].content
        assert "act-replayed" not in answers[1].headers
