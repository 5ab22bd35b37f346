"""Work on a shape over HTTP: what is made is what the command line makes of it, to the byte."""

import asyncio
import errno
import json
import re
import shutil
import threading
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from html import unescape
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from fastapi.testclient import TestClient
from matplotlib.figure import Figure
from pypdfium2 import PdfDocument
from typer.testing import CliRunner

from limbgram.app.binary_arrays import decode_blocks
from limbgram.app.server import build
from limbgram.app.state import AppState
from limbgram.cases.workspace import Workspace
from limbgram.cli.main import app as command_line
from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings.tell import LANGUAGES
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import SUFFIXES, ShapeFile, read_limb, read_shape
from limbgram.report.drawings.drawing import Picture, png
from limbgram.services.export import EXPORTS
from limbgram.workbench.carving.mapping import MapOptions
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.limb import Limb
from limbgram.workbench.recipe.recipe import Recipe

API = "/api/v1"
KINDS = {"brush": "load", "levels": "reduction", "trimline": "trimline", "smoothing": "smoothing"}
LOAD = {"at": "patellar tendon", "depth_mm": 3.0, "falloff_mm": 20.0}


@pytest.fixture
def case(client: TestClient, app_state: AppState, limb: Mesh) -> str:
    """A case with a surface, as a run delivers it."""
    case_id = client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"]
    folder = app_state.shelf.root / case_id / "deliverables"
    folder.mkdir()
    write_ply(limb, folder / "surface.ply", "mm")
    return f"{API}/cases/{case_id}"


@pytest.fixture
def aligned(client: TestClient, case: str, limb: Mesh) -> str:
    """The same with a place and axes."""
    middle = np.abs(limb.vertices_mm[:, 2] - limb.vertices_mm[:, 2].mean()) < 2
    front = limb.vertices_mm[middle][np.argmax(limb.vertices_mm[middle, 1])]
    place = {"position_mm": front.tolist()}
    assert client.put(f"{case}/limb/places/patellar tendon", json=place).status_code == 200
    return with_axes(client, case)


@pytest.fixture
def without_places(client: TestClient, case: str) -> str:
    """The same with axes alone: what places make of a record takes more than half of its time."""
    return with_axes(client, case)


@pytest.fixture
def without_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Records with a white dot for each picture: to draw takes half of their time."""
    dot = png(Figure(figsize=(0.1, 0.1)))
    dots = [Picture(name=one, title=one, caption=one, png=dot) for one in ("sides", "sections")]
    monkeypatch.setattr("limbgram.report.record.record._pictures", lambda *_: tuple(dots))


def with_axes(client: TestClient, case: str) -> str:
    axes = {"side": "left", "kind": "transtibial", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    assert client.post(f"{case}/limb/align", json=axes).status_code == 200
    return case


def typed(*words: str | Path) -> Any:
    """What the command line replies."""
    done = CliRunner().invoke(command_line, [*map(str, words), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def surface(client: TestClient, case: str, of: str) -> dict[str, np.ndarray]:
    return decode_blocks(client.get(f"{case}/surface?of={of}").content)[1]


def changed_by(
    before: dict[str, np.ndarray], header: dict[str, Any], blocks: dict[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and faces after a change, put together as a browser does."""
    positions = np.zeros((header["vertices"], 3), np.float32)
    kept = min(len(positions), len(before["positions"]))
    positions[:kept] = before["positions"][:kept]
    positions[blocks["changed"]] = blocks["positions"]
    faces = np.zeros((header["faces"], 3), np.uint32)
    kept = min(len(faces), len(before["indices"]))
    faces[:kept] = before["indices"][:kept]
    faces[blocks["faces_changed"]] = blocks["indices"]
    return positions, faces


def by_hand(drawn: str, limb: Mesh) -> dict[str, Any]:
    """What a browser sends of a stroke, of levels or of a line round the limb."""
    at = limb.vertices_mm
    middle = float(at[:, 2].mean())
    if drawn == "levels":
        return {"heights_mm": [middle - 40, middle + 40], "per_cent": [1.0, 3.0], "of": "girth"}
    if drawn == "smoothing":
        return {"passes": 2}
    if drawn == "trimline":
        above = np.abs(at[:, 2] - middle - 60) < 3
        angles = np.arctan2(at[above, 1], at[above, 0])
        round_it = [at[above][np.argmin(np.abs(angles - a))] for a in np.linspace(-3, 2.1, 8)]
        return {"through": np.array(round_it).tolist(), "keep": "distal", "positions_in": "mesh"}
    stroke = [(-12, -25), (-12, 0), (-12, 25), (12, 25), (12, 0), (12, -25)]  # a brush 24 mm wide
    front = at[at[:, 1] > 0]
    line = [
        front[np.argmin(np.hypot(front[:, 0] - x, front[:, 2] - middle - z))] for x, z in stroke
    ]
    within = np.array(line).tolist()
    return {"within": within, "depth_mm": 2.0, "falloff_mm": 8.0, "positions_in": "mesh"}


def test_the_surface_comes_as_it_is_and_once(client: TestClient, case: str, limb: Mesh) -> None:
    answer = client.get(f"{case}/surface")
    header, blocks = decode_blocks(answer.content)
    assert header["vertices"] == len(limb)
    np.testing.assert_array_equal(blocks["indices"], limb.faces)
    np.testing.assert_allclose(blocks["positions"], limb.vertices_mm, atol=1e-4)
    length = np.linalg.norm(blocks["normals"], axis=1)
    np.testing.assert_allclose(length, 1, atol=1e-5)
    again = client.get(f"{case}/surface", headers={"if-none-match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
def test_a_place_that_is_no_number_is_refused(client: TestClient, case: str, number: str) -> None:
    body = f'{{"position_mm": [0, {number}, 0]}}'.encode()
    headers = {"content-type": "application/json"}
    asked = client.post(f"{case}/surface/point", content=body, headers=headers)
    placed = client.put(f"{case}/limb/places/patella", content=body, headers=headers)
    assert (asked.status_code, placed.status_code) == (422, 422)


def test_a_fresh_surface_that_is_asked_for_twice_at_once_is_taken_in_once(
    client: TestClient, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[Path] = []
    copy, together = shutil.copyfile, threading.Barrier(2)

    def slow_copy(source: Path, place: Path) -> Path:
        taken.append(place)
        time.sleep(0.3)
        return copy(source, place)

    def ask(what: str) -> int:
        together.wait(10)
        return client.get(f"{case}/{what}").status_code

    monkeypatch.setattr(shutil, "copyfile", slow_copy)
    with ThreadPoolExecutor(2) as pool:
        # The recipe asks the workspace itself, not by way of the shapes in memory.
        statuses = list(pool.map(ask, ["recipe", "limb"]))
    assert (statuses, len(taken)) == ([200, 200], 1)


def test_places_are_glued_to_the_surface_and_known_in_the_limb(
    client: TestClient, aligned: str
) -> None:
    known = client.get(f"{aligned}/limb").json()
    assert (known["aligned"], known["side"], known["kind"]) == (True, "left", "transtibial")
    place = known["places"][0]
    assert place["in_limb_mm"][1] > 20
    off = np.array(place["position_mm"]) + np.array([0.0, 3.0, 0.0])
    moved = client.put(f"{aligned}/limb/places/patellar tendon", json={"position_mm": off.tolist()})
    again = np.array(moved.json()["places"][0]["position_mm"])
    assert np.linalg.norm(again - off) < 3.1
    far = {"position_mm": [0.0, 900.0, 0.0]}
    refused = client.put(f"{aligned}/limb/places/patellar tendon", json=far)
    assert refused.status_code == 422
    assert "from the surface" in refused.json()["message"]


def test_what_the_shape_tells_is_offered_as_a_guess(
    client: TestClient, aligned: str, limb: Mesh
) -> None:
    guessed = client.get(f"{aligned}/limb/guesses").json()
    (one,) = guessed["places"]
    assert (one["by"], one["name"]) == ("shape", "distal end")
    assert one["position_mm"][2] - limb.vertices_mm[:, 2].min() < 2
    assert guessed["note"]  # this case has no photos to show stickers
    place = {"position_mm": one["position_mm"]}
    assert client.put(f"{aligned}/limb/places/distal end", json=place).status_code == 200
    assert client.get(f"{aligned}/limb/guesses").json()["places"] == []


def test_places_of_an_earlier_visit_are_proposed_until_somebody_confirms_them(
    client: TestClient, app_state: AppState, aligned: str, limb: Mesh
) -> None:
    """Today's scan is the earlier one, turned and moved: where each place lies is known."""
    motion = Rigid.from_rotation_vector(np.array([0.1, -0.2, 0.5]), np.array([30.0, -12.0, 5.0]))
    label = {"kind": "transtibial", "side": "left"}
    today_id = client.post(f"{API}/cases", json=label).json()["id"]
    folder = app_state.shelf.root / today_id / "deliverables"
    folder.mkdir()
    write_ply(limb.with_vertices(motion.apply(limb.vertices_mm)), folder / "surface.ply", "mm")
    today, earlier_id = f"{API}/cases/{today_id}", aligned.rpartition("/")[2]
    (marked,) = client.get(f"{aligned}/limb").json()["places"]

    carried = client.get(f"{today}/limb/guesses/{earlier_id}").json()
    (guess,) = carried["places"]
    assert (guess["by"], guess["name"]) == ("visit", "patellar tendon")
    true_mm = motion.apply(np.array([marked["position_mm"]]))[0]
    off_mm = float(np.linalg.norm(np.array(guess["position_mm"]) - true_mm))
    assert off_mm < guess["within_mm"] == pytest.approx(1.96 * guess["sigma_mm"], rel=1e-3)
    assert guess["sigma_mm"] >= 2.0  # no better than a click on the earlier scan
    assert carried["left_out"] == []
    assert client.get(f"{today}/limb").json()["places"] == []  # proposed, and nothing more

    place = {key: guess[key] for key in ("position_mm", "sigma_mm")} | {"placed": "proposed"}
    assert client.put(f"{today}/limb/places/patellar tendon", json=place).status_code == 200
    workspace = Workspace(app_state.shelf.case(today_id))
    (kept,) = app_state.shape_cache.shape(workspace).limb.landmarks
    assert (kept.placed, kept.sigma_mm, kept.confirmed) == ("proposed", guess["sigma_mm"], True)
    assert client.get(f"{today}/limb/guesses/{earlier_id}").json()["places"] == []

    client.patch(f"{today}", json={"side": "right"})
    refused = client.get(f"{today}/limb/guesses/{earlier_id}")
    assert refused.status_code == 422
    assert "a left limb" in refused.json()["message"]


def test_the_flexion_with_which_axes_were_set_is_told_to_set_them_again(
    client: TestClient, case: str
) -> None:
    """Without it the end up that is shown lies 60 degrees off the limb, and is refused."""
    assert client.get(f"{case}/limb").json()["flexion_deg"] == 0.0
    axes = {"side": "left", "kind": "transtibial", "axis": "fit", "anterior": [0, 1, 0]}
    bent = axes | {"proximal": [0, 0, 1], "flexion_deg": 60.0}
    assert client.post(f"{case}/limb/align", json=bent).json()["flexion_deg"] == 60.0
    told = client.get(f"{case}/limb").json()
    _, forwards, up = np.array(told["rotation"])
    flexion = np.radians(told["flexion_deg"])
    along = np.cos(flexion) * up - np.sin(flexion) * forwards
    again = axes | {"proximal": along.tolist(), "flexion_deg": told["flexion_deg"]}
    done = client.post(f"{case}/limb/align", json=again).json()
    np.testing.assert_allclose(done["rotation"], told["rotation"], atol=1e-9)
    lost = axes | {"proximal": up.tolist()}
    assert client.post(f"{case}/limb/align", json=lost).status_code == 422
    by_hand = {"side": "left", "axis": up.tolist(), "anterior": [0, 1, 0]}
    assert client.post(f"{case}/limb/align", json=by_hand).json()["flexion_deg"] == 0.0


# So fine that what a load changes is less than half of the surface, and is sent alone.
@pytest.mark.parametrize("limb", [1.6], indirect=True)
def test_a_preview_is_what_is_kept_afterwards(client: TestClient, aligned: str) -> None:
    asked = {"kind": "load", "parameters": LOAD}
    before = surface(client, aligned, "rectified")
    tried = client.post(f"{aligned}/recipe/preview", json=asked)
    header, blocks = decode_blocks(tried.content)
    assert client.get(f"{aligned}/recipe").json()["edits"] == []
    kept = client.post(f"{aligned}/recipe/edits", json=asked).json()
    assert kept["recipe"]["tag"] == header["tag"]
    after = surface(client, aligned, "rectified")
    positions, faces = changed_by(before, header, blocks)
    np.testing.assert_array_equal(positions, after["positions"])
    np.testing.assert_array_equal(faces, after["indices"])
    far = decode_blocks(client.get(f"{aligned}/surface/differences").content)[1]["signed_mm"]
    assert far.min() == pytest.approx(-3.0, abs=0.05)
    assert kept["ledger"]["lines"][0]["displacement"]["largest_mm"] == pytest.approx(-3.0, abs=0.05)


@pytest.mark.parametrize("drawn", ["brush", "levels", "trimline", "smoothing"])
def test_what_is_shown_after_release_is_what_is_made(
    client: TestClient, aligned: str, limb: Mesh, drawn: str
) -> None:
    before = surface(client, aligned, "rectified")
    asked = {"kind": KINDS[drawn], "parameters": by_hand(drawn, limb)}
    tried = client.post(f"{aligned}/recipe/preview", json=asked)
    assert tried.status_code == 200, tried.text
    header, blocks = decode_blocks(tried.content)
    client.post(f"{aligned}/recipe/edits", json=asked).raise_for_status()
    after = surface(client, aligned, "rectified")
    positions, faces = blocks["positions"], blocks["indices"]
    if "changed" in blocks:
        positions, faces = changed_by(before, header, blocks)
    np.testing.assert_array_equal(positions, after["positions"])
    np.testing.assert_array_equal(faces, after["indices"])
    assert not np.array_equal(after["positions"], before["positions"])


def test_undo_goes_back_over_every_gesture(client: TestClient, aligned: str) -> None:
    edits = f"{aligned}/recipe/edits"
    client.post(edits, json={"kind": "load", "parameters": LOAD})
    client.post(edits, json={"kind": "smoothing", "parameters": {"passes": 2}})
    client.patch(f"{edits}/1", json={"on": False})
    client.patch(f"{edits}/2", json={"number": 1})
    client.patch(f"{edits}/1", json={"parameters": {"passes": 3}})
    client.delete(f"{edits}/2")

    def told() -> list[str]:
        found = client.get(f"{aligned}/recipe").json()["edits"]
        return [f"{one['kind']}{'' if one['on'] else ' off'}" for one in found]

    history = [told()]
    while client.get(f"{aligned}/recipe").json()["can_undo"]:
        client.post(f"{aligned}/recipe/undo")
        history.append(told())
    assert history == [
        ["smoothing"],
        ["smoothing", "load off"],
        ["smoothing", "load off"],
        ["load off", "smoothing"],
        ["load", "smoothing"],
        ["load"],
        [],
    ]
    for _ in range(6):
        client.post(f"{aligned}/recipe/redo")
    assert told() == ["smoothing"]
    assert client.post(f"{aligned}/recipe/redo").status_code == 422


@pytest.mark.parametrize("step", ["undo", "redo"])
def test_other_windows_hear_of_undo_and_redo(
    client: TestClient, app_state: AppState, aligned: str, step: str
) -> None:
    case_id = aligned.rpartition("/")[2]
    client.post(f"{aligned}/recipe/edits", json={"kind": "load", "parameters": LOAD})
    if step == "redo":
        client.post(f"{aligned}/recipe/undo")
    before = app_state.news.of(case_id)["work"]
    assert client.post(f"{aligned}/recipe/{step}").status_code == 200
    assert app_state.news.of(case_id)["work"] == before + 1
    assert client.post(f"{aligned}/recipe/{step}").status_code == 422
    assert app_state.news.of(case_id)["work"] == before + 1, "nothing changed"


def test_an_edit_that_is_refused_changes_nothing(client: TestClient, aligned: str) -> None:
    deep = {**LOAD, "depth_mm": 25.0}
    refused = client.post(f"{aligned}/recipe/edits", json={"kind": "load", "parameters": deep})
    assert refused.status_code == 422
    assert "depth" in refused.json()["message"]
    assert client.get(f"{aligned}/recipe").json()["edits"] == []
    unknown = client.post(f"{aligned}/recipe/edits", json={"kind": "dent", "parameters": {}})
    assert unknown.status_code == 422
    assert client.patch(f"{aligned}/recipe/edits/1", json={"on": False}).status_code == 422


@pytest.mark.parametrize(
    "kinds",
    [("stl", "aop"), pytest.param(("dxf", "ply", "obj", "glb"), marks=pytest.mark.slow)],
    ids=" ".join,
)
def test_exported_bytes_are_those_of_the_command_line(
    client: TestClient, app_state: AppState, aligned: str, tmp_path: Path, kinds: tuple[str, ...]
) -> None:
    client.post(f"{aligned}/recipe/edits", json={"kind": "load", "parameters": LOAD})
    client.post(f"{aligned}/recipe/edits", json={"kind": "smoothing", "parameters": {"passes": 2}})
    work = app_state.shelf.root / aligned.rpartition("/")[2] / "work"
    rectified = tmp_path / "rectified.ply"
    typed("edit", "apply", work / "surface.ply", work / "recipe.toml", "-o", rectified)
    for kind in kinds:
        made = client.post(f"{aligned}/exports", json={"kind": kind, "side": "left"})
        assert made.status_code == 201, made.text
        name = made.json()["name"]
        got = client.get(f"{aligned}/exports/{name}").content
        typed("export", rectified, "--to", kind, "-o", tmp_path / name, "--side", "left")
        assert got == (tmp_path / name).read_bytes(), kind
        mirror = client.get(f"{aligned}/exports/{name}/mirror").content
        assert mirror.startswith(b"\x89PNG"), kind
        (work / "files" / f"{name}.mirror.png").unlink()
        assert client.get(f"{aligned}/exports/{name}/mirror").status_code == 404


def test_every_kind_of_file_is_offered_with_its_words_in_every_language(client: TestClient) -> None:
    kinds = client.get(f"{API}/exports").json()
    assert [one["kind"] for one in kinds if one["everyday"]] == ["aop", "gcode", "stl", "dxf"]
    assert {one["kind"] for one in kinds} == set(EXPORTS)
    assert all(set(one["used_for"]) == set(LANGUAGES) for one in kinds)
    assert all(all(one["used_for"].values()) for one in kinds)
    assert {one["kind"] for one in kinds if one["mesh"]} >= {"stl", "3mf", "ply"}
    assert client.get(f"{API}/shape-files").json() == list(SUFFIXES)
    assert ".3mf" in SUFFIXES


def test_what_is_usual_is_told_once_by_the_writers_own_options(client: TestClient) -> None:
    kinds = client.get(f"{API}/exports").json()
    told = {(one["kind"], field["name"]): field for one in kinds for field in one["fields"]}
    assert told["aop", "spokes"]["usual"] == MapOptions().spokes == 120
    assert told["aop", "spacing_mm"]["usual"] == MapOptions().spacing_mm == 2
    assert told["aop", "spokes"]["default"] is None, "an AOP keeps its own grid"
    assert told["gcode", "tool_diameter_mm"]["usual"] == CarveOptions().tool_diameter_mm == 12
    assert (told["dxf", "spacing_mm"]["default"], told["dxf", "spacing_mm"]["usual"]) == (10, None)


def test_another_side_is_not_handed_over(client: TestClient, aligned: str) -> None:
    refused = client.post(f"{aligned}/exports", json={"kind": "stl", "side": "right"})
    assert refused.status_code == 422
    assert "side" in refused.json()["message"]
    assert client.get(f"{aligned}/exports").json() == []
    assert client.post(f"{aligned}/exports", json={"kind": "stl"}).status_code == 422


def test_measures_are_those_of_the_command_line_with_the_tape_beside(
    client: TestClient, app_state: AppState, aligned: str
) -> None:
    tape = [{"height_mm": 100.0, "girth_mm": 150.0}, {"height_mm": 4000.0, "girth_mm": 300.0}]
    client.put(f"{aligned}/tape", json=tape)
    found = client.post(f"{aligned}/measures", json={"heights_mm": [60, 100]}).json()
    scan = app_state.shelf.root / aligned.rpartition("/")[2] / "work" / "surface.ply"
    wanted = typed("measure", scan, "--height", "60", "--height", "100")["levels"]
    for got, row in zip(found["levels"], wanted, strict=True):
        assert got["tape_mm"]["value"] == row["tape_mm"]["value"]
        assert got["contour_mm"]["value"] == row["contour_mm"]["value"]
    near, beyond = found["tape"]
    assert near["conflict"]
    assert near["difference_mm"] == near["measured_mm"]["value"] - 150.0
    assert beyond["measured_mm"] is None
    assert beyond["reason"]
    ring = client.get(f"{aligned}/surface/section?height_mm=100").json()["rings"][0]
    assert ring["length_mm"] == pytest.approx(found["levels"][1]["contour_mm"]["value"], rel=2e-3)


@pytest.mark.usefixtures("without_drawing")
def test_the_record_tells_every_reading_conflict_and_acceptance(
    client: TestClient, without_places: str
) -> None:
    """From clicks to the sheets: 10 mm beyond the shape's girth, a mistyped one, one that fits."""
    at = {60.0: 0.0, 80.0: 10.0, 100.0: -45.0}
    asked = {"heights_mm": list(at), "with_tape": False}
    levels = client.post(f"{without_places}/measures", json=asked).json()["levels"]
    girths = {row["height_mm"]: row["tape_mm"]["value"] for row in levels}
    for height, off in at.items():
        reading = {"height_mm": height, "girth_mm": round(girths[height] + off, 1)}
        assert client.patch(f"{without_places}/tape", json=reading).status_code == 200
    nobodys = {"height_mm": 80.0, "girth_mm": 500.0}
    assert client.post(f"{without_places}/tape/accept", json=nobodys).status_code == 422
    kept = {"height_mm": 80.0, "girth_mm": round(girths[80.0] + 10, 1)}
    assert client.post(f"{without_places}/tape/accept", json=kept).status_code == 200
    client.patch(f"{without_places}/tape", json={"height_mm": 100.0, "girth_mm": None})
    told = {
        one["height_mm"]: one
        for one in client.post(f"{without_places}/measures", json={}).json()["tape"]
    }
    assert not told[60.0]["conflict"]
    assert told[80.0]["conflict"]
    assert told[80.0]["accepted"]
    assert not told[60.0]["accepted"]

    page = client.get(f"{without_places}/record.html").text
    assert without_places.rpartition("/")[2] in page
    assert "No tape reading has been compared" not in page
    for height, off in at.items():
        assert f"{girths[height] + off:.1f}" in page
    assert f"accepted {told[80.0]['accepted']}" in page
    assert "taken back 20" in page
    assert page.count("they contradict each other") == 3  # the advice once, and both rows
    sheets = client.get(f"{without_places}/record.pdf").content
    assert sheets.startswith(b"%PDF")
    paper = PdfDocument(sheets)
    assert len(paper) == 2
    text = " ".join(sheet.get_textpage().get_text_range() for sheet in paper)
    printed = " ".join(text.replace("\u200b", "").split())  # long words may be parted there
    paper.close()
    assert f"case {without_places.rpartition('/')[2]}" in printed
    apart = "they contradict each other; "
    said = {
        60.0: "[+-]0.0 ± [0-9.]+ agrees",
        80.0: f"-10.0 ± [0-9.]+ {apart}accepted {re.escape(told[80.0]['accepted'])}",
        100.0: f"[+]45.0 ± [0-9.]+ {apart}taken back 20",
    }
    for height, off in at.items():
        read, scan = f"{girths[height] + off:.1f}", f"{girths[height]:.1f}"
        assert re.search(f"{height:.0f} {read} {scan} {said[height]}", printed)


@pytest.mark.usefixtures("without_drawing")
def test_a_record_says_where_the_verdict_of_the_capture_cannot_be_told(
    client: TestClient, app_state: AppState, without_places: str
) -> None:
    """A red capture whose files were damaged looked as one of which nothing is doubted."""
    untold = "The verdict on the capture is not known here"
    assert untold not in client.get(f"{without_places}/record.html").text
    folder = app_state.shelf.case(without_places.rpartition("/")[2]).folder.root
    for kept in ("case.json", "accuracy.json"):
        file = folder / kept
        before = file.read_bytes() if file.exists() else None
        file.write_text('{"light": "red", "schema"')
        page = " ".join(client.get(f"{without_places}/record.html").text.split())
        assert page.count(untold) == 1, kept
        assert str(folder) not in page
        if before is None:
            file.unlink()
        else:
            file.write_bytes(before)


def test_a_reading_is_judged_by_the_scan_whatever_shape_is_measured(
    client: TestClient, aligned: str
) -> None:
    """A tape on the patient reads the scan's girth; the mould is 6 % tighter, and no witness."""
    scan = {"heights_mm": [100.0]}
    girth = client.post(f"{aligned}/measures", json=scan).json()["levels"][0]["tape_mm"]["value"]
    client.patch(f"{aligned}/tape", json={"height_mm": 100.0, "girth_mm": round(girth, 1)})
    tighter = {"heights_mm": [60.0, 140.0], "per_cent": [6.0, 6.0], "of": "girth"}
    made = client.post(f"{aligned}/recipe/edits", json={"kind": "reduction", "parameters": tighter})
    assert made.status_code == 201, made.text
    mould = {**scan, "of": "rectified", "sock_mm": 1.0, "reference": "patellar tendon"}
    mould["heights_mm"] = [0.0]
    told = [client.post(f"{aligned}/measures", json=one).json() for one in (scan, mould)]
    assert told[0]["tape"] == told[1]["tape"]
    (reading,) = told[1]["tape"]
    assert not reading["conflict"]
    assert reading["measured_mm"]["value"] == girth
    page = client.get(f"{aligned}/record.html").text
    assert "they contradict each other" not in page


def test_what_was_accepted_of_a_reading_ends_when_that_is_taken_back(
    client: TestClient, app_state: AppState, aligned: str
) -> None:
    wrong = {"height_mm": 100.0, "girth_mm": 150.0}
    accepted: list[bool] = []
    for deed in ("patch", "accept", "back", "patch"):
        if deed == "accept":
            client.post(f"{aligned}/tape/accept", json=wrong)
        else:
            girth = None if deed == "back" else wrong["girth_mm"]
            client.patch(f"{aligned}/tape", json={**wrong, "girth_mm": girth})
        found = client.post(f"{aligned}/measures", json={}).json()["tape"]
        accepted += [bool(one["accepted"]) for one in found]
    assert accepted == [False, True, False], "read anew it is to be accepted anew"
    standings = Workspace(app_state.shelf.case(aligned.rpartition("/")[2])).tape_standings()
    assert [(bool(one.withdrawn), bool(one.accepted)) for one in standings] == [
        (True, True),
        (False, False),
    ]


def test_a_reading_of_before_acts_were_kept_stays_when_it_is_accepted(
    client: TestClient, app_state: AppState, aligned: str
) -> None:
    reading = {"height_mm": 80.0, "girth_mm": 200.0}
    workspace = Workspace(app_state.shelf.case(aligned.rpartition("/")[2]))
    workspace.tape_file.write_text(json.dumps({"readings": [reading]}), "utf-8")
    assert client.post(f"{aligned}/tape/accept", json=reading).status_code == 200
    (standing,) = workspace.tape_standings()
    assert (standing.read.made, standing.withdrawn) == ("", "")
    assert standing.accepted


def test_work_stays_where_the_case_is_computed_again(
    client: TestClient, app_state: AppState, aligned: str, limb: Mesh
) -> None:
    folder = app_state.shelf.root / aligned.rpartition("/")[2] / "deliverables"
    higher = limb.with_vertices(limb.vertices_mm + np.array([0.0, 0.0, 0.5]))
    write_ply(higher, folder / "surface.ply", "mm")
    known = client.get(f"{aligned}/limb").json()
    assert known["stale"]
    assert [one["name"] for one in known["places"]] == ["patellar tendon"]
    steps = {one["name"]: one["state"] for one in client.get(aligned).json()["steps"]}
    assert steps["align"] == "check"
    fresh = client.post(f"{aligned}/limb/refresh").json()
    assert not fresh["stale"]
    assert [one["name"] for one in fresh["places"]] == ["patellar tendon"]
    assert not fresh["aligned"]


@pytest.mark.parametrize("fails", ["reading", "full disk", "ended in between"])
@pytest.mark.parametrize("other_name", [False, True])
def test_a_new_surface_that_cannot_be_taken_leaves_the_one_before(
    app_state: AppState,
    aligned: str,
    limb: Mesh,
    monkeypatch: pytest.MonkeyPatch,
    fails: str,
    other_name: bool,
) -> None:
    workspace = Workspace(app_state.shelf.case(aligned.rpartition("/")[2]))
    folder = workspace.case.folder.deliverables
    before = {file.name: file.read_bytes() for file in workspace.root.iterdir() if file.is_file()}
    assert {"surface.ply", "surface.limb.json"} <= set(before)
    (folder / "surface.ply").unlink()
    higher = limb.with_vertices(limb.vertices_mm + np.array([0.0, 0.0, 0.5]))
    new = "surface-RED.ply" if other_name else "surface.ply"
    write_ply(higher, folder / new, "mm")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    def one_read_then_none(path: Path) -> ShapeFile:
        if path.name in before and path.parent == workspace.root:
            return read_shape(path)
        raise ShapeFileError("It cannot be read.")

    with monkeypatch.context() as broken:
        match fails:
            case "reading":
                broken.setattr("limbgram.cases.workspace.read_shape", one_read_then_none)
            case "full disk":
                broken.setattr(shutil, "copyfile", full)
            case _:
                move = Path.replace

                def ends(file: Path, place: Path) -> Path:
                    if file.parent.name == ".taken":
                        raise OSError(errno.EIO, "Input/output error")
                    return move(file, place)

                broken.setattr(Path, "replace", ends)
        with pytest.raises((ShapeFileError, OSError)):
            workspace.take_scan()
    if fails == "ended in between":  # the new surface was whole: it is taken when asked for next
        assert workspace.scan_file().name == new
        assert workspace.scan_file().read_bytes() == (folder / new).read_bytes()
    else:
        kept = {file.name: file.read_bytes() for file in workspace.root.iterdir() if file.is_file()}
        assert kept == before
    assert [one.name for one in workspace.read().limb.landmarks] == ["patellar tendon"]
    assert not list(workspace.root.glob(".*"))
    assert workspace.take_scan().name == new
    assert not workspace.is_stale()
    assert [one.name for one in workspace.read().limb.landmarks] == ["patellar tendon"]


def test_two_who_edit_at_once_lose_nothing(
    client: TestClient, aligned: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    recipe, together = Workspace.recipe, threading.Barrier(2)

    def slow(workspace: Workspace) -> Recipe:
        read = recipe(workspace)
        time.sleep(0.1)
        return read

    def add(depth_mm: float) -> int:
        together.wait(10)
        edit = {"kind": "load", "parameters": {**LOAD, "depth_mm": depth_mm}}
        return client.post(f"{aligned}/recipe/edits", json=edit).status_code

    client.get(f"{aligned}/recipe")
    monkeypatch.setattr(Workspace, "recipe", slow)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(add, [1.0, 2.0])) == [201, 201]
        assert len(client.get(f"{aligned}/recipe").json()["edits"]) == 2

        def again(step: str) -> int:
            together.wait(10)
            return client.post(f"{aligned}/recipe/{step}").status_code

        assert list(pool.map(again, ["undo", "undo"])) == [200, 200]
    assert client.get(f"{aligned}/recipe").json()["edits"] == []


def test_two_who_place_at_once_lose_nothing(
    client: TestClient, aligned: str, limb: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    save, together = Workspace.save_limb, threading.Barrier(2)

    def slow(workspace: Workspace, limb: Limb, read: ShapeFile) -> None:
        time.sleep(0.1)
        save(workspace, limb, read)

    def place(name: str) -> int:
        together.wait(10)
        mark = {"position_mm": limb.vertices_mm[len(name)].tolist()}
        return client.put(f"{aligned}/limb/places/{name}", json=mark).status_code

    monkeypatch.setattr(Workspace, "save_limb", slow)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(place, ["one", "another"])) == [200, 200]
    names = {one["name"] for one in client.get(f"{aligned}/limb").json()["places"]}
    assert names == {"patellar tendon", "one", "another"}


def test_others_are_answered_while_a_shape_is_read(
    client: TestClient, aligned: str, limb: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, answered = threading.Event(), threading.Event()

    def slow(path: Path) -> Limb:
        begun.set()
        assert answered.wait(10), "nobody was answered meanwhile"
        return read_limb(path)

    monkeypatch.setattr("limbgram.app.compare.read_limb", slow)
    content = write_ply(limb, tmp_path / "other.ply", "mm").read_bytes()
    with ThreadPoolExecutor(1) as pool:
        sent = pool.submit(client.put, f"{aligned}/shapes/other.ply", content=content)
        assert begun.wait(10)
        assert client.get(f"{aligned}/shapes").json() == []
        answered.set()
        assert sent.result(20).status_code == 200
    assert [one["name"] for one in client.get(f"{aligned}/shapes").json()] == ["other.ply"]


@pytest.mark.parametrize("slow", ["read", "_take_scan"])
def test_other_cases_are_answered_while_one_reads_its_surface(
    client: TestClient, app_state: AppState, limb: Mesh, monkeypatch: pytest.MonkeyPatch, slow: str
) -> None:
    workspaces: list[Workspace] = []
    for _ in range(2):
        made = app_state.shelf.new_case("transtibial", "left")
        made.folder.deliverables.mkdir()
        write_ply(limb, made.folder.deliverables / "surface.ply", "mm")
        workspaces.append(Workspace(made))
    begun, answered, act = threading.Event(), threading.Event(), getattr(Workspace, slow)

    def acts_slowly(workspace: Workspace) -> Any:
        if workspace == workspaces[0]:
            begun.set()
            assert answered.wait(30), "the other case was not answered meanwhile"
        return act(workspace)

    monkeypatch.setattr(Workspace, slow, acts_slowly)
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(client.get, f"{API}/cases/{workspaces[0].case.case_id}/limb")
        assert begun.wait(30)
        other = client.get(f"{API}/cases/{workspaces[1].case.case_id}/limb")
        answered.set()
        assert (other.status_code, first.result(30).status_code) == (200, 200)


def test_a_shape_that_is_sent_does_not_stay_in_memory(
    app_state: AppState, aligned: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> Limb:
        assert path.stat().st_size == pieces * len(piece)
        raise ShapeFileError("It is none.")

    monkeypatch.setattr("limbgram.app.compare.read_limb", refuse)
    piece, pieces = bytes(1 << 20), 64
    left = iter([*({"body": piece, "more_body": True} for _ in range(pieces)), {"body": b""}])
    answers: list[Any] = []

    async def receive() -> Any:
        return {"type": "http.request", **next(left)}

    async def send(message: Any) -> None:
        answers.append(message)

    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": "PUT",
        "path": f"{aligned}/shapes/large.ply",
        "raw_path": b"",
        "query_string": b"",
        "headers": [],
        "scheme": "http",
        "server": None,
        "client": None,
        "root_path": "",
    }
    served = build(app_state)
    tracemalloc.start()
    try:
        asyncio.run(cast(Any, served)(scope, receive, send))
        held = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert answers[0]["status"] == 422
    assert held < 0.2 * pieces * len(piece)
    assert not list(
        (app_state.shelf.root / aligned.rpartition("/")[2] / "work" / "shapes").iterdir()
    )


def test_comparing_with_the_scan_tells_what_was_done(client: TestClient, aligned: str) -> None:
    edit = {"kind": "load", "parameters": LOAD}
    assert client.post(f"{aligned}/recipe/edits", json=edit).status_code == 201
    told = client.post(f"{aligned}/compare", json={}).json()
    assert "3.0 mm" in told["verdict"]["sentence"]
    header, blocks = decode_blocks(client.post(f"{aligned}/compare/differences", json={}).content)
    assert header["figures"] == told["figures"]
    assert np.nanmin(blocks["signed_mm"]) == pytest.approx(-3.0, abs=0.1)


def test_an_earlier_state_of_the_recipe_is_compared_as_any_other_shape(
    client: TestClient, aligned: str
) -> None:
    offset = {"kind": "offset", "parameters": {"distance_mm": -1.0}}
    assert client.post(f"{aligned}/recipe/edits", json=offset).status_code == 201
    edit = {"kind": "load", "parameters": LOAD}
    assert client.post(f"{aligned}/recipe/edits", json=edit).status_code == 201

    def differences(query: str) -> np.ndarray:
        answer = client.get(f"{aligned}/surface/differences{query}")
        assert answer.status_code == 200, answer.text
        return decode_blocks(answer.content)[1]["signed_mm"]

    # All of it moved against the scan; against the state before the load, what the load moved.
    assert np.median(differences("")) == pytest.approx(-1.0, abs=0.02)
    since = differences("?edits=1")
    assert since.min() == pytest.approx(-3.0, abs=0.15)
    assert np.mean(since == 0) > 0.5
    np.testing.assert_array_equal(differences("?edits=2"), 0.0)
    np.testing.assert_array_equal(differences("?edits=0"), differences(""))

    compared = client.post(f"{aligned}/compare", json={"edits": 1}).json()
    volume = compared["figures"]["volume"]["ml"]
    ledger = client.get(f"{aligned}/recipe/ledger").json()["ledger"]["lines"][1]
    change = ledger["after"]["volume_ml"] - ledger["before"]["volume_ml"]
    assert volume["difference"] == pytest.approx(change, abs=0.2)
    for query in ("surface/differences?edits=3", "surface/differences?edits=-1"):
        assert client.get(f"{aligned}/{query}").status_code == 422
    several = client.post(f"{aligned}/compare", json={"edits": 1, "case": "K7Q-4F2"})
    assert several.status_code == 422
    assert "not with several" in several.json()["message"]


def test_a_shape_of_elsewhere_is_read_before_it_is_kept(
    client: TestClient, aligned: str, limb: Mesh, tmp_path: Path
) -> None:
    path = write_ply(limb, tmp_path / "other.ply", "mm")
    sent = client.put(f"{aligned}/shapes/other.ply", content=path.read_bytes())
    assert sent.status_code == 200
    assert client.post(f"{aligned}/compare", json={"shape": "other.ply"}).status_code == 200
    bad = client.put(f"{aligned}/shapes/bad.ply", content=b"ply of nothing")
    assert "bad.ply" in bad.json()["message"]
    assert bad.status_code == 422
    assert [one["name"] for one in client.get(f"{aligned}/shapes").json()] == ["other.ply"]
    assert client.post(f"{aligned}/compare", json={"shape": "bad.ply"}).status_code == 404
    assert client.delete(f"{aligned}/shapes/bad.ply").status_code == 404
    assert client.delete(f"{aligned}/shapes/other.ply").status_code == 204
    assert client.get(f"{aligned}/shapes").json() == []


def test_what_a_browser_opens_as_a_page_is_refused_as_one_that_may_stand_in_the_app(
    client: TestClient,
) -> None:
    """The step Record shows its sheet in a frame, and its link opens the PDF in a tab."""
    case = f"{API}/cases/{client.post(f'{API}/cases', json={}).json()['id']}"
    browser = {"accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    for path in ("record.html", "record.pdf", "report/report"):
        refused = client.get(f"{case}/{path}", headers=browser)
        assert refused.status_code in (404, 409, 422)
        assert refused.headers["content-type"].startswith("text/html")
        assert "frame-ancestors 'self'" in refused.headers["content-security-policy"]
        assert client.get(f"{case}/{path}").json()["message"] in unescape(refused.text)
    german = {**browser, "accept-language": "de-AT,de;q=0.9,en;q=0.8"}
    told = client.get(f"{case}/report/report", headers=german).text
    assert '<html lang="de">' in told
    assert "Es gibt noch keinen Bericht" in told
