"""The list of cases: ids, labels, room on the disk, and going for good."""

import io
import os
import re
import shutil
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient
from PIL import Image

from limbgram.app.state import AppState
from limbgram.cases.shelf import ID_PATTERN, Held, ShelvedCase
from limbgram.cases.uploads import Intake
from limbgram.cases.workspace import Workspace
from limbgram.workbench.measures.tape import TapeReading

API = "/api/v1"


def test_a_case_has_a_random_id_and_says_what_comes_next(client: TestClient) -> None:
    made = [client.post(f"{API}/cases", json={"kind": "transtibial", "side": "right"}).json()]
    made.append(client.post(f"{API}/cases", json={}).json())
    assert all(re.fullmatch(ID_PATTERN, one["id"]) for one in made)
    assert made[0]["id"] != made[1]["id"]
    assert (made[0]["state"], made[0]["next"]) == ("empty", "capture")
    locked = {step["name"] for step in made[0]["steps"] if step["state"] == "locked"}
    assert locked == {"result", "align", "measure", "rectify", "send", "record"}


def test_the_list_is_what_the_folders_are(client: TestClient, app_state: AppState) -> None:
    first = client.post(f"{API}/cases", json={"note": "second fitting"}).json()["id"]
    second = client.post(f"{API}/cases", json={}).json()["id"]
    assert {one["id"] for one in client.get(f"{API}/cases").json()["cases"]} == {first, second}
    (app_state.shelf.root / second).rename(app_state.shelf.root.parent / "elsewhere")
    assert [one["id"] for one in client.get(f"{API}/cases").json()["cases"]] == [first]
    (app_state.shelf.root.parent / "elsewhere").rename(app_state.shelf.root / "ABC-234")
    found = client.get(f"{API}/cases?find=fitting").json()["cases"]
    assert [one["id"] for one in found] == [first]
    assert len(client.get(f"{API}/cases").json()["cases"]) == 2


def test_a_label_is_changed_in_part_and_archived(client: TestClient) -> None:
    case = f"{API}/cases/" + client.post(f"{API}/cases", json={"side": "left"}).json()["id"]
    changed = client.patch(case, json={"note": "cast", "archived": True}).json()
    assert (changed["side"], changed["note"], changed["archived"]) == ("left", "cast", True)
    assert client.get(f"{API}/cases?archived=false").json()["cases"] == []
    assert client.patch(case, json={"side": None}).json()["side"] is None
    assert client.patch(case, json={"note": "two\nlines"}).status_code == 422


def test_deleting_lists_what_goes_and_leaves_nothing(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    folder = app_state.shelf.root / case_id
    (folder / "received").mkdir()
    (folder / "received" / "a.jpg").write_bytes(bytes(1000))
    (folder / "stages" / "detect").mkdir(parents=True)
    (folder / "stages" / "detect" / "arrays.npz").write_bytes(bytes(5000))
    held = {one["what"]: one for one in client.get(f"{API}/cases/{case_id}/contents").json()}
    assert held["photos"] == {"what": "photos", "files": 1, "bytes": 1000}
    (folder / "superseded").mkdir()
    (folder / "superseded" / "report.html").write_bytes(bytes(300))
    assert client.post(f"{API}/cases/{case_id}/clear").json() == {"bytes": 5000}
    assert (folder / "received" / "a.jpg").is_file()
    assert (folder / "superseded" / "report.html").is_file(), "results stay, it was said"
    assert client.delete(f"{API}/cases/{case_id}").status_code == 204
    assert client.get(f"{API}/cases/{case_id}").status_code == 404
    assert not list(app_state.shelf.root.rglob("a.jpg"))


def a_reading(workspace: Workspace) -> None:
    workspace.save_tape((TapeReading(height_mm=100.0, girth_mm=351.0),))


def a_file_for_machines(workspace: Workspace) -> None:
    workspace.make_folder(workspace.files)


def a_photo(workspace: Workspace) -> None:
    with Intake(workspace.case.received, b"key").begin("IMG_1.jpg", 0, None):
        pass


@pytest.mark.parametrize("write", [a_reading, a_file_for_machines, a_photo])
def test_who_writes_in_a_case_that_was_deleted_meanwhile_does_not_bring_it_back(
    client: TestClient, app_state: AppState, write: Callable[[Workspace], None]
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    workspace = Workspace(app_state.shelf.case(case_id))
    assert client.delete(f"{API}/cases/{case_id}").status_code == 204
    with pytest.raises(LookupError):
        write(workspace)
    with pytest.raises(LookupError), app_state.shape_cache.changing(workspace):
        pass
    assert not workspace.case.folder.root.exists()


def test_a_case_that_goes_while_the_list_is_made_hides_no_other(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes, stays = (client.post(f"{API}/cases", json={}).json()["id"] for _ in range(2))
    whole = ShelvedCase.holdings

    def holdings(case: ShelvedCase) -> tuple[Held, ...]:
        if case.case_id == goes:
            shutil.rmtree(case.folder.root)
        return whole(case)

    monkeypatch.setattr(ShelvedCase, "holdings", holdings)
    listed = client.get(f"{API}/cases")
    assert listed.status_code == 200
    assert [one["id"] for one in listed.json()["cases"]] == [stays]


def test_a_case_is_deleted_after_the_change_that_is_being_made(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    workspace = Workspace(app_state.shelf.case(case_id))
    with ThreadPoolExecutor(1) as pool:
        with app_state.shape_cache.changing(workspace):
            deleting = pool.submit(client.delete, f"{API}/cases/{case_id}")
            with pytest.raises(TimeoutError):
                deleting.result(0.3)
            a_reading(workspace)
        assert deleting.result(20).status_code == 204
    assert not workspace.case.folder.root.exists()


def looked_at(client: TestClient, root: Path) -> int:
    """Files that were opened, and folders that were listed, to answer with the list."""
    watched.append(str(root))
    try:
        assert client.get(f"{API}/cases").status_code == 200
        return len(watched) - 1
    finally:
        watched.clear()


watched: list[str] = []


def _watch(event: str, args: tuple[object, ...]) -> None:
    if watched and event in ("open", "os.listdir", "os.scandir"):
        path = os.fspath(args[0]) if isinstance(args[0], str | os.PathLike) else ""
        if str(path).startswith(watched[0]):
            watched.append(str(path))


sys.addaudithook(_watch)  # it cannot be taken away: it looks on only while somebody asks


def test_the_list_costs_the_same_however_much_a_case_holds(
    client: TestClient, app_state: AppState
) -> None:
    cost: list[int] = []
    for photos in (2, 60):
        case_id = client.post(f"{API}/cases", json={}).json()["id"]
        folder = app_state.shelf.case(case_id).folder
        for name in ("received/.records", "stages/detect", "deliverables", "work"):
            (folder.root / name).mkdir(parents=True)
        for k in range(photos):
            (folder.root / "received" / f"{k}.jpg").write_bytes(bytes(1000))
            (folder.root / "received" / ".records" / f"{k}.jpg.json").write_text("{}", "utf-8")
            (folder.stages / "detect" / f"{k}.npz").write_bytes(bytes(500))
        for name in ("deliverables", "work"):
            (folder.root / name / "surface.ply").write_bytes(name[:4].encode() * 100_000)
        for place in (folder.root, *folder.root.rglob("*")):
            os.utime(place, (1.7e9, 1.7e9 + 1.0 * (place.parent.name == "work")))
        told = client.get(f"{API}/cases/{case_id}").json()
        assert told["photos"] == photos
        assert told["bytes"] > 1500 * photos + 800_000
        assert {one["name"]: one["state"] for one in told["steps"]}["align"] == "check", "stale"
        cost.append(looked_at(client, folder.root))
        again = client.get(f"{API}/cases/{case_id}").json()
        assert again == told
        (folder.root / "received" / "0.jpg").unlink()
        assert client.get(f"{API}/cases/{case_id}").json()["photos"] == photos - 1
        shutil.rmtree(folder.root)
    assert cost[0] == cost[1] < 6


def test_the_thumbnail_is_the_first_view_alone_without_a_ground(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    assert client.get(f"{API}/cases/{case_id}/thumbnail").status_code == 404
    picture = np.full((400, 1000, 3), 255, np.uint8)
    picture[:20, 80:120] = 90  # words above the views, and a scale below them
    picture[385:, 30:200] = 90
    picture[60:360, 50:150] = (200, 30, 30)
    picture[60:360, 300:400] = (30, 30, 200)
    report = app_state.shelf.case(case_id).folder.report
    report.mkdir(parents=True)
    Image.fromarray(picture).save(report / "surface.png")
    answer = client.get(f"{API}/cases/{case_id}/thumbnail")
    with Image.open(io.BytesIO(answer.content)) as small:
        assert small.size == (37, 112)
        drawn = np.asarray(small.convert("RGBA")).astype(int)
    assert np.abs(drawn[1:-1, 1:-1] - (200, 30, 30, 255)).max() <= 2


def test_a_picture_that_was_drawn_anew_lies_where_no_browser_has_one(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post(f"{API}/cases", json={}).json()["id"]
    assert client.get(f"{API}/cases/{case_id}").json()["thumbnail"] is None
    picture = app_state.shelf.case(case_id).folder.surface_picture
    picture.parent.mkdir()
    found: list[str] = []
    for second in (1, 2):
        Image.new("RGB", (400, 200), (90, 90 * second, 90)).save(picture)
        os.utime(picture, (second, second))
        found.append(client.get(f"{API}/cases/{case_id}").json()["thumbnail"])
        assert client.get(found[-1]).status_code == 200
    assert found[0] != found[1]


@pytest.mark.parametrize("note", ["a\nb", "a\u202eb"], ids=["two lines", "turned round"])
def test_a_case_whose_note_is_refused_leaves_nothing_behind(
    client: TestClient, app_state: AppState, note: str
) -> None:
    assert client.post(f"{API}/cases", json={"note": note}).status_code == 422
    assert app_state.shelf.cases() == ()
