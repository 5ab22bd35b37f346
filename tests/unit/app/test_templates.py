"""Templates over HTTP: learned from a case that was rectified, and done as an edit."""

from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from limbgram.app.binary_arrays import decode_blocks
from limbgram.app.state import AppState
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.ply import write_ply

API = "/api/v1"
DEPTH_MM = 4.0


def case_of(client: TestClient, app_state: AppState, limb: Mesh) -> str:
    """A case that is aligned, with a place in front of its middle."""
    case_id: str = client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"]
    folder = app_state.shelf.root / case_id / "deliverables"
    folder.mkdir()
    write_ply(limb, folder / "surface.ply", "mm")
    case = f"{API}/cases/{case_id}"
    for name, share in (("patellar tendon", 0.7), ("tibial crest", 0.45)):
        at = {"position_mm": front_of(limb, share)}
        assert client.put(f"{case}/limb/places/{name}", json=at).status_code == 200
    axes = {"side": "left", "kind": "transtibial", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    assert client.post(f"{case}/limb/align", json=axes).status_code == 200
    return case_id


def front_of(limb: Mesh, share: float) -> list[float]:
    low, high = limb.vertices_mm[:, 2].min(), limb.vertices_mm[:, 2].max()
    near = np.abs(limb.vertices_mm[:, 2] - (low + share * (high - low))) < 3
    return limb.vertices_mm[near][np.argmax(limb.vertices_mm[near, 1])].tolist()


def test_what_was_done_to_one_limb_is_learned_and_done_to_another(
    client: TestClient, app_state: AppState, limb: Mesh
) -> None:
    first, second = (case_of(client, app_state, limb) for _ in range(2))
    empty = client.post(f"{API}/templates", json={"name": "mine", "cases": [first]})
    assert empty.status_code == 422
    assert "no edits" in empty.json()["message"]

    load = {"at": "tibial crest", "depth_mm": DEPTH_MM, "falloff_mm": 30.0}
    edit = {"kind": "load", "parameters": load, "accept": ["load on tibial crest"]}
    done = client.post(f"{API}/cases/{first}/recipe/edits", json=edit)
    assert done.status_code == 201, done.text
    learned = client.post(f"{API}/templates", json={"name": "mine", "cases": [first]})
    assert learned.status_code == 201, learned.text
    (known,) = learned.json()["templates"]
    assert (known["name"], known["pairs"]) == ("mine", 1)
    moves = {one["place"]: one["moved_mm"] for one in known["places"]}
    assert moves["tibial crest"] == pytest.approx(-DEPTH_MM, abs=0.5)

    text = client.get(f"{API}/templates/{known['id']}/file").text
    apply: dict[str, Any] = {"kind": "from-template", "parameters": {"learned": text}}
    tried = client.post(f"{API}/cases/{second}/recipe/preview", json=apply)
    assert tried.status_code == 200, tried.text
    assert client.post(f"{API}/cases/{second}/recipe/edits", json=apply).status_code == 201
    answer = client.get(f"{API}/cases/{second}/surface/differences").content
    signed = decode_blocks(answer)[1]["signed_mm"]
    assert signed.min() == pytest.approx(-DEPTH_MM, abs=0.6)
    told = client.get(f"{API}/cases/{second}/recipe").json()["edits"][0]
    assert len(told["text"]) < 200

    picture = client.get(f"{API}/templates/{known['id']}/picture")
    assert picture.content.startswith(b"\x89PNG")
    again = client.put(f"{API}/templates/file", content=text.encode())
    assert len(again.json()) == 2
    assert client.put(f"{API}/templates/file", content=b"{}").status_code == 422
    assert client.delete(f"{API}/templates/{known['id']}").status_code == 204
    assert client.get(f"{API}/templates/{known['id']}/file").status_code == 404


def test_a_template_that_was_spoiled_is_refused_and_changes_nothing(
    client: TestClient, app_state: AppState, limb: Mesh
) -> None:
    case = case_of(client, app_state, limb)
    edit = {"kind": "from-template", "parameters": {"learned": "{}"}}
    refused = client.post(f"{API}/cases/{case}/recipe/edits", json=edit)
    assert refused.status_code == 422
    assert "cannot be read" in refused.json()["message"]
    assert client.get(f"{API}/cases/{case}/recipe").json()["edits"] == []


def test_a_damaged_template_hides_no_other_and_can_be_deleted(
    client: TestClient, app_state: AppState, limb: Mesh
) -> None:
    case = case_of(client, app_state, limb)
    load = {"at": "tibial crest", "depth_mm": DEPTH_MM, "falloff_mm": 30.0}
    edit = {"kind": "load", "parameters": load, "accept": ["load on tibial crest"]}
    client.post(f"{API}/cases/{case}/recipe/edits", json=edit)
    for name in ("first", "second"):
        client.post(f"{API}/templates", json={"name": name, "cases": [case]})
    first, second = sorted(app_state.shelf.templates.glob("*.json"))
    first.write_bytes(first.read_bytes()[:100])
    listed = client.get(f"{API}/templates")
    assert listed.status_code == 200, listed.text
    told = {one["id"]: one["finding"] for one in listed.json()}
    assert told[second.stem] is None
    assert told[first.stem]["code"] == "template.file.unreadable"
    third = client.post(f"{API}/templates", json={"name": "third", "cases": [case]})
    assert third.status_code == 201
    assert client.delete(f"{API}/templates/{first.stem}").status_code == 204
    left = client.get(f"{API}/templates").json()
    assert [one["finding"] for one in left] == [None, None]
