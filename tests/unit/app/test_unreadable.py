"""A file that cannot be read is not an empty one: it is told, and nothing is written over it."""

from collections.abc import Callable

import httpx
import pytest
from fastapi.testclient import TestClient

from limbgram.app.state import AppState
from limbgram.cases.shelf import ShelvedCase
from limbgram.cases.workspace import Workspace
from limbgram.core.errors import CaseError
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.measures.tape import TapeReading
from limbgram.workbench.recipe.recipe import Entry, Recipe

API = "/api/v1"
DAMAGED = b'{"made": "2026-03-31T10:00:00+00:00", "side": "ri'
"""As a disk leaves a file that it lost the end of."""

Ask = Callable[[TestClient, str], httpx.Response]


@pytest.fixture
def case(client: TestClient, app_state: AppState) -> ShelvedCase:
    case_id = client.post(f"{API}/cases", json={"side": "right", "note": "cast"}).json()["id"]
    case = app_state.shelf.case(case_id)
    case.work.mkdir()
    return case


def say(client: TestClient, at: str) -> httpx.Response:
    return client.patch(at, json={"note": "another"})


def compute(client: TestClient, at: str) -> httpx.Response:
    photos = client.get(f"{at}/photos").json()
    assert photos["here"] == 0
    return client.post(f"{at}/job/resume")


def tape(client: TestClient, at: str) -> httpx.Response:
    return client.put(f"{at}/tape", json=[{"height_mm": 100.0, "girth_mm": 351.0}])


@pytest.mark.parametrize(
    ("name", "save"),
    [("label.json", say), ("job.json", compute), ("work/tape.json", tape)],
    ids=["label", "job", "tape"],
)
def test_what_cannot_be_read_is_told_kept_and_begun_anew_only_when_asked(
    client: TestClient, case: ShelvedCase, name: str, save: Ask
) -> None:
    at, file = f"{API}/cases/{case.case_id}", case.folder.root / name
    file.write_bytes(DAMAGED)
    other = client.post(f"{API}/cases", json={}).json()["id"]
    listed = {one["id"]: one for one in client.get(f"{API}/cases").json()["cases"]}
    assert set(listed) == {case.case_id, other}, "it hides no other case"
    unreadable = listed[case.case_id]["unreadable"]
    assert [file.name in one["sentence"] for one in unreadable] == [True]
    assert listed[other]["unreadable"] == []
    refused = save(client, at)
    assert refused.status_code == 409
    assert file.name in refused.json()["message"]
    assert file.read_bytes() == DAMAGED, "nothing was written over it"

    (aside,) = client.post(f"{at}/set-aside").json()
    assert (file.parent / aside).read_bytes() == DAMAGED
    assert client.get(at).json()["unreadable"] == []
    if name != "job.json":
        assert save(client, at).status_code == 200
    assert client.post(f"{at}/set-aside").json() == [], "what can be read stays where it is"
    file.write_bytes(DAMAGED)
    (second,) = client.post(f"{at}/set-aside").json()
    assert second != aside
    assert (file.parent / aside).read_bytes() == DAMAGED


@pytest.mark.parametrize("content", [DAMAGED, b"\xff\xfe\x00"], ids=["cut off", "no text"])
def test_all_that_cannot_be_read_is_told_and_set_aside(
    client: TestClient, app_state: AppState, case: ShelvedCase, content: bytes
) -> None:
    at, workspace = f"{API}/cases/{case.case_id}", Workspace(case)
    (case.work / "surface.ply").write_bytes(b"ply")
    assert workspace.limb_file is not None
    files = [
        *(case.label_file, case.folder.record, case.folder.job_file),
        *(workspace.tape_file, workspace.recipe_file, workspace.limb_file),
    ]
    for file in files:
        file.write_bytes(content)
    listed = client.get(f"{API}/cases")
    assert listed.status_code == 200
    (told,) = (one["unreadable"] for one in listed.json()["cases"])
    assert [sum(file.name in one["sentence"] for one in told) for file in files] == [1] * 6
    assert str(app_state.shelf.root) not in listed.text, "nobody before the app need know where"
    assert len(client.post(f"{at}/set-aside").json()) == 6
    assert client.get(at).json()["unreadable"] == []
    assert client.post(f"{at}/set-aside").json() == []


def test_readings_by_tape_that_cannot_be_read_are_not_none(case: ShelvedCase) -> None:
    workspace = Workspace(case)
    workspace.save_tape((TapeReading(height_mm=100.0, girth_mm=351.0),))
    whole = workspace.tape_file.read_bytes()
    workspace.tape_file.write_bytes(whole[:-9])
    with pytest.raises(CaseError, match=r"tape\.json"):
        workspace.tape()
    workspace.tape_file.write_bytes(whole)
    assert [one.girth_mm for one in workspace.tape()] == [351.0]


def test_a_history_that_cannot_be_read_is_kept_beside_the_new_one(case: ShelvedCase) -> None:
    workspace = Workspace(case)
    (case.work / "surface.ply").write_bytes(b"ply")
    for offset_mm in (1.0, 2.0):
        edit = Entry(edit=Offset(distance_mm=offset_mm))
        workspace.save_recipe(Recipe(name="own", entries=(edit,)))
    history = case.work / "history.json"
    history.write_bytes(DAMAGED)
    assert not workspace.history().can_undo
    assert len(workspace.notes()) == 1
    workspace.save_recipe(Recipe(name="own"))
    assert workspace.history().can_undo
    (aside,) = case.work.glob("history.unreadable-*")
    assert aside.read_bytes() == DAMAGED
    assert [aside.name in one for one in workspace.notes()] == [True]


def test_a_camera_that_cannot_be_read_hides_no_other_and_keeps_its_name(
    client: TestClient, app_state: AppState
) -> None:
    first, second = (client.post(f"{API}/cameras", json={"name": name}).json() for name in "AB")
    label = app_state.shelf.cameras / first["id"] / "label.json"
    label.write_bytes(DAMAGED)
    listed = {one["id"]: one for one in client.get(f"{API}/cameras").json()}
    assert listed[second["id"]]["name"] == "B"
    assert "label.json" in listed[first["id"]]["message"]
    refused = client.patch(f"{API}/cameras/{first['id']}", json={"name": "C"})
    assert refused.status_code == 409
    assert label.read_bytes() == DAMAGED


def test_a_photo_of_which_nothing_can_be_read_is_told_and_not_replaced(
    client: TestClient, case: ShelvedCase
) -> None:
    at = f"{API}/cases/{case.case_id}/photos/a.png"
    assert client.put(at, content=b"no picture").json()["whole"]
    kept = (case.received / "a.png").read_bytes()
    (case.received / ".records" / "a.png.json").write_bytes(DAMAGED)
    (told,) = client.get(f"{API}/cases/{case.case_id}/photos").json()["photos"]
    assert (told["name"], told["state"]) == ("a.png", "unusable")
    assert "cannot be read" in told["problem"]["sentence"]
    assert client.put(at, content=b"another picture").status_code == 409
    assert (case.received / "a.png").read_bytes() == kept
    assert client.delete(at).status_code == 204
    assert client.put(at, content=b"another picture").status_code == 200
