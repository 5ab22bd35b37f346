"""Scraps on the skin: taken away at reading, told, and the surface under them whole again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold, volume_mm3
from limbgram.findings import told
from limbgram.formats.reading import read_limb
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import Limb
from limbgram.workbench.loose_pieces import TINY_SHARE, without_scraps
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb


def torn(mesh: Mesh, faces: list[int], off_mm: float) -> Mesh:
    """The mesh with faces torn off and laid back by so much, with corners of their own."""
    keep = np.ones(len(mesh.faces), np.bool_)
    keep[faces] = False
    corners = mesh.vertices_mm[mesh.faces[faces]].reshape(-1, 3)
    normals = np.repeat(mesh.face_normals()[faces], 3, axis=0)
    corners = corners + off_mm * normals / np.linalg.norm(normals, axis=1)[:, None]
    own = len(mesh) + np.arange(3 * len(faces)).reshape(-1, 3)
    return replace(
        mesh,
        vertices_mm=np.concatenate([mesh.vertices_mm, corners]),
        faces=np.concatenate([mesh.faces[keep], own]).astype(np.int32),
    )


def near(mesh: Mesh, *places: tuple[float, float, float]) -> list[int]:
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    return [int(np.linalg.norm(middles - place, axis=1).argmin()) for place in places]


PLACES = ((0.0, 30.0, 60.0), (0.0, -30.0, 110.0), (40.0, 0.0, 150.0), (0.0, 1.0, 0.0))
"""Three on the wall, one at the tip."""


def test_torn_triangles_are_taken_away_and_what_they_left_is_closed(
    tmp_path: Path, stump: Limb
) -> None:
    mesh = torn(stump.mesh, near(stump.mesh, *PLACES), 0.4)
    assert len(boundary_loops(mesh.faces)) == 1 + 2 * len(PLACES)
    path = tmp_path / "torn.stl"
    trimesh.Trimesh(mesh.vertices_mm, mesh.faces, process=False).export(path)
    limb = read_limb(path)
    note = told(*limb.notes)
    assert "4 loose scraps of surface on the skin (4 triangles" in note
    assert "holes closed under them: 4" in note
    assert [len(loop) for loop in boundary_loops(limb.mesh.faces)] == [96]
    assert is_edge_manifold(limb.mesh.faces)
    assert len(limb.mesh.faces) == len(stump.mesh.faces)
    assert volume_mm3(limb.mesh) == pytest.approx(volume_mm3(stump.mesh), rel=1e-6)
    aligned = align(limb, AlignOptions(side="right", anterior=np.array([0, 1.0, 0])))
    heights = (50.0, 100.0, 150.0, 200.0)
    rows = measure_limb(aligned, LimbMeasureOptions(heights_mm=heights)).rows
    assert all(row.figures["volume_below_mm3"] is not None for row in rows)


def test_holes_that_meet_in_a_point_are_closed_soundly(tmp_path: Path, stump: Limb) -> None:
    """Two torn triangles that shared a corner, as on the tips of a public shape model."""
    (one,) = near(stump.mesh, (0.0, 40.0, 100.0))
    corner = stump.mesh.faces[one, 0]
    others = np.flatnonzero((stump.mesh.faces == corner).any(1))
    sides = [len(np.intersect1d(stump.mesh.faces[one], stump.mesh.faces[k])) for k in others]
    other = int(others[int(np.argmin(sides))])
    assert min(sides) == 1
    mesh = torn(stump.mesh, [one, other], 0.3)
    path = tmp_path / "torn.stl"
    trimesh.Trimesh(mesh.vertices_mm, mesh.faces, process=False).export(path)
    limb = read_limb(path)
    assert [len(loop) for loop in boundary_loops(limb.mesh.faces)] == [96]
    assert len(limb.mesh) == len(stump.mesh)  # the corner is one vertex again
    assert np.linalg.norm(limb.mesh.face_normals(), axis=1).min() > 1
    assert volume_mm3(limb.mesh) == pytest.approx(volume_mm3(stump.mesh), rel=1e-6)


def test_a_brim_is_known_among_small_openings(stump: Limb) -> None:
    """A third of the open edges lies at the closed end, and none of the limb's width."""
    low = np.flatnonzero(stump.mesh.vertices_mm[stump.mesh.faces].mean(1)[:, 2] < 25)
    taken: list[int] = []
    for face in low.tolist():
        if not np.isin(stump.mesh.faces[face], stump.mesh.faces[taken]).any():
            taken.append(face)
    pierced = replace(stump.mesh, faces=np.delete(stump.mesh.faces, taken, axis=0))
    limb = Limb(mesh=without_loose_vertices(pierced))
    edges = [len(loop) for loop in boundary_loops(limb.mesh.faces)]
    assert sum(edges) - max(edges) > 0.3 * max(edges)
    aligned = align(limb, AlignOptions(side="right", anterior=np.array([0, 1.0, 0])))
    top = aligned.aligned().mesh_in_limb.vertices_mm
    wide = np.hypot(*top[top[:, 2] > top[:, 2].max() - 2, :2].T)
    assert wide.mean() > 50


def without_loose_vertices(mesh: Mesh) -> Mesh:
    used, faces = np.unique(mesh.faces, return_inverse=True)
    return Mesh(vertices_mm=mesh.vertices_mm[used], faces=faces.reshape(-1, 3).astype(np.int32))


def test_what_stands_off_the_skin_or_is_large_stays(stump: Limb) -> None:
    """A patch over a gap is measured surface; so is a scrap that lies clear of the skin."""
    clear = torn(stump.mesh, near(stump.mesh, PLACES[0]), 8.0)
    assert without_scraps(clear).mesh is clear
    areas = np.linalg.norm(stump.mesh.face_normals(), axis=1) / 2
    middles = stump.mesh.vertices_mm[stump.mesh.faces].mean(1)
    patch = np.flatnonzero(np.linalg.norm(middles - [0, 40, 100], axis=1) < 12)
    assert areas[patch].sum() > 2 * TINY_SHARE * areas.sum()
    gap = stump.mesh.faces[patch]
    places = stump.mesh.vertices_mm
    used, inner = np.unique(gap, return_inverse=True)
    apart = replace(
        stump.mesh,
        vertices_mm=np.concatenate([places, places[used] + [0, 0.3, 0]]),
        faces=np.concatenate(
            [np.delete(stump.mesh.faces, patch, axis=0), len(stump.mesh) + inner.reshape(-1, 3)]
        ).astype(np.int32),
    )  # fmt: skip
    assert without_scraps(apart).mesh is apart
    assert without_scraps(stump.mesh).findings() == ()
