"""A scan spoilt in known ways is cleaned to what it was, and what was taken away is told."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, face_components, volume_mm3
from limbgram.findings import note, told
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.edits.clean import Clean
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.sock import Sock
from limbgram.workbench.limb import Limb, LimbFrame
from limbgram.workbench.recipe.ledger import lines_of
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

SPIKES, SPIKE_MM = (1500, 2211, 3020), 14.0


@pytest.fixture
def scan(stump: Limb) -> Limb:
    """The stump in its limb frame, with sigmas."""
    sigma = np.full(len(stump.mesh), 0.1, np.float32)
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return stump.with_mesh(replace(stump.mesh, sigma_mm=sigma)).with_frame(frame)


def _around(mesh: Mesh, place: tuple[float, float, float], reach_mm: float) -> np.ndarray:
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    return np.linalg.norm(middles - place, axis=1) < reach_mm


def _nearest(mesh: Mesh, place: tuple[float, float, float]) -> np.ndarray:
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    return np.array([np.linalg.norm(middles - place, axis=1).argmin()])


def _with_copy(mesh: Mesh, faces: np.ndarray, off_mm: float) -> Mesh:
    """The mesh with some faces there once more, laid off the surface."""
    used, inner = np.unique(mesh.faces[faces], return_inverse=True)
    places = mesh.vertices_mm[used] + off_mm * mesh.vertex_normals()[used]
    sigma = mesh.sigma_mm
    return replace(
        mesh,
        vertices_mm=np.concatenate([mesh.vertices_mm, places]),
        faces=np.concatenate([mesh.faces, len(mesh) + inner.reshape(-1, 3)]).astype(np.int32),
        sigma_mm=None if sigma is None else np.concatenate([sigma, sigma[used]]),
    )


@pytest.fixture
def spoilt(scan: Limb) -> Limb:
    """With a doubled sheet, two scraps, three spikes and three small holes."""
    mesh = scan.mesh
    vertices = mesh.vertices_mm.copy()
    vertices[list(SPIKES)] += SPIKE_MM * mesh.vertex_normals()[list(SPIKES)]
    whole = mesh
    mesh = mesh.with_vertices(vertices)
    holes = np.zeros(len(mesh.faces), np.bool_)
    for place in ((0.0, 40.0, 180.0), (-45.0, 0.0, 120.0), (0.0, -34.0, 60.0)):
        middle = whole.vertices_mm[whole.faces[_nearest(whole, place)[0]]].mean(0)
        holes |= _around(whole, tuple(middle.tolist()), 3.5)
    sheet = np.flatnonzero(_around(whole, (20.0, -40.0, 130.0), 30.0))
    scraps = [_nearest(whole, place) for place in ((45.0, 0.0, 90.0), (0.0, 42.0, 120.0))]
    for faces, off_mm in ((sheet, 0.8), (scraps[0], 6.0), (scraps[1], -4.0)):
        mesh = _with_copy(mesh, faces, off_mm)
    keep = ~np.concatenate([holes, np.zeros(len(mesh.faces) - len(holes), np.bool_)])
    mesh = replace(mesh, faces=mesh.faces[keep])
    assert int(face_components(mesh.faces).max()) == 3
    assert len(boundary_loops(mesh.faces)) == 1 + 3 + 3
    return scan.with_mesh(mesh)


def test_a_spoilt_scan_is_what_it_was(scan: Limb, spoilt: Limb) -> None:
    cleaned = do_edit(spoilt, Clean())
    mesh = cleaned.mesh
    assert int(face_components(mesh.faces).max()) == 0
    assert [len(loop) for loop in boundary_loops(mesh.faces)] == [96]
    tree = TriangleTree.of(scan.mesh.vertices_mm, scan.mesh.faces)
    assert tree.closest(mesh.vertices_mm).distances_mm.max() < 0.6
    assert volume_mm3(mesh) == pytest.approx(volume_mm3(scan.mesh), rel=2e-4)
    notes = " / ".join(map(told, cleaned.notes))
    assert "2 loose scraps of surface" in notes
    assert "1 loose scrap of surface on the skin" in notes
    assert "spikes of 3 points" in notes
    assert f"up to {SPIKE_MM:.0f}" in notes
    assert "holes closed" in notes
    assert mesh.filled is not None
    assert mesh.sigma_mm is not None
    np.testing.assert_array_equal(np.isnan(mesh.sigma_mm), mesh.filled)
    measured = ~mesh.filled
    known = np.isin(mesh.vertices_mm[measured], scan.mesh.vertices_mm).all(1)
    assert known.all()  # nothing that was measured has moved
    assert (
        measured.sum()
        == len(np.unique(spoilt.mesh.faces[face_components(spoilt.mesh.faces) == 0])) - 3
    )


def test_each_kind_can_be_left(spoilt: Limb) -> None:
    none = Clean(scraps_mm=0, sheets_mm=0, spikes=False, holes_mm=20)
    assert int(face_components(do_edit(spoilt, none).mesh.faces).max()) == 3
    only_scraps = do_edit(spoilt, Clean(sheets_mm=0, spikes=False, holes_mm=0))
    assert int(face_components(only_scraps.mesh.faces).max()) == 1  # the sheet is there still
    assert len(boundary_loops(only_scraps.mesh.faces)) == 1 + 3 + 1
    tight = do_edit(spoilt, Clean(scraps_mm=0, sheets_mm=0.5, spikes=False, holes_mm=5))
    assert len(tight.mesh.faces) == len(spoilt.mesh.faces)
    assert tight.notes[-1] == note("edit.clean.nothing")


def test_a_sound_shape_stays_as_it_is(scan: Limb) -> None:
    cleaned = do_edit(scan, Clean())
    assert cleaned.mesh is scan.mesh
    assert cleaned.notes == (note("edit.clean.nothing"),)


@pytest.mark.parametrize(
    "edit",
    [
        Clean(scraps_mm=-1),
        Clean(holes_mm=200),
        Clean(sheets_mm=float("nan")),
        Clean(scraps_mm=0, sheets_mm=0, spikes=False, holes_mm=0),
    ],
)
def test_amounts_that_make_no_sense_are_refused(scan: Limb, edit: Clean) -> None:
    with pytest.raises(EditError, match="The clean"):
        do_edit(scan, edit)


def test_the_ledger_says_what_was_taken_away(spoilt: Limb) -> None:
    replayed = replay(Recipe(name="a", scan_sha256="", entries=(Entry(edit=Clean()),)), spoilt)
    (line,) = replayed.ledger.lines
    assert line.displacement is None
    taken = ["limb.scraps", "limb.scraps", "edit.clean.spikes", "edit.clean.holes"]
    assert [one.code for one in line.told] == [*taken, "edit.enclosed"]
    printed = "\n".join(lines_of(replayed.ledger))
    assert all(told(one) in printed for one in line.told)


def test_it_stands_in_a_recipe_like_the_others(tmp_path: Path, spoilt: Limb) -> None:
    scan = write_limb(spoilt, tmp_path / "scan.ply")
    recipe, out = tmp_path / "first.toml", tmp_path / "clean.ply"
    for words in (
        ["new", str(recipe)],
        ["add", str(recipe), "clean", "holes_mm=12"],
        ["apply", str(scan), str(recipe), "-o", str(out), "--json"],
    ):
        done = CliRunner().invoke(app, ["edit", *words])
        assert done.exit_code == 0, done.output
    (line,) = json.loads(done.stdout)["ledger"]["lines"]
    (spikes,) = (one for one in line["told"] if one["code"] == "edit.clean.spikes")
    assert spikes["values"]["count"] == 3
    assert 'do = "clean"' in recipe.read_text()


def test_a_sock_comes_off_after_a_rough_brim_was_cut_off(scan: Limb) -> None:
    """Depths count from the whole scan, whose brim would fold: it goes in as the rest does."""
    mesh, random = scan.mesh, np.random.default_rng(0)
    rough_mm = 2.0 * random.normal(size=(len(mesh), 3))
    rough_mm[mesh.vertices_mm[:, 2] <= 200] = 0.0
    rough = scan.with_mesh(mesh.with_vertices(mesh.vertices_mm + rough_mm))
    sock = Sock(thickness_mm=2.3)
    with pytest.raises(EditError):
        do_edit(rough, sock)
    deep = Load(at="popliteal crease", depth_mm=9.8, falloff_mm=25.0)
    entries = tuple(Entry(edit=edit) for edit in (PlaneCut(height_mm=195.0), sock, deep))
    done = replay(Recipe(name="a", entries=entries), rough)
    assert done.limb.sock_mm == 2.3
    assert done.ledger.lines[2].concerns == ()


@pytest.mark.parametrize("others", [(), (SPIKES[1],)])
def test_a_spike_that_cannot_be_laid_back_is_told(scan: Limb, others: tuple[int, ...]) -> None:
    """A scrap stands in it: laid back, the skin would cut through that."""
    mesh, at = scan.mesh, SPIKES[0]
    normals, vertices = mesh.vertex_normals(), mesh.vertices_mm.copy()
    aside = np.cross(normals[at], [0.0, 0.0, 1.0])
    scrap = vertices[at] + np.array([-3.0 * normals[at] - aside, -3.0 * normals[at] + aside])
    scrap = np.vstack([scrap, vertices[at] + 5.0 * normals[at]])
    vertices[[at, *others]] += SPIKE_MM * normals[[at, *others]]
    stuck = Mesh(
        vertices_mm=np.vstack([vertices, scrap]),
        faces=np.vstack([mesh.faces, len(mesh) + np.arange(3)]).astype(np.int32),
    )
    cleaned = do_edit(scan.with_mesh(stuck), Clean(scraps_mm=0, sheets_mm=0, holes_mm=0))
    said = {one.code: one.values.get("count") for one in cleaned.notes}
    laid = {"edit.clean.spikes": len(others)} if others else {}
    assert said == {**laid, "edit.clean.spikes_left": 1}
