"""What an edit may not do, also where the scan came with such places of its own."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import EditError
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.guard import require_sound


def ball_beside_crossing_balls() -> Mesh:
    """A ball of 50 mm, and far above it two small ones that pass through each other."""
    parts = [trimesh.creation.icosphere(subdivisions=3, radius=50.0)]
    for x in (0.0, 6.0):
        small = trimesh.creation.icosphere(subdivisions=1, radius=5.0)
        small.apply_translation([x, 0, 120])
        parts.append(small)
    whole = trimesh.util.concatenate(parts)
    return Mesh(vertices_mm=np.asarray(whole.vertices), faces=whole.faces.astype(np.int32))


def test_a_crossing_of_the_scan_excuses_none_elsewhere_however_far_the_edit_moves() -> None:
    before = ball_beside_crossing_balls()
    assert len(find_crossings(before.vertices_mm, before.faces)) > 0
    pushed = before.vertices_mm.copy()
    pushed[pushed[:, 2] < -40, 2] += 150  # the pole through the opposite wall
    with pytest.raises(EditError, match="pass through each other"):
        require_sound(before, before.with_vertices(pushed))


def test_a_crossing_of_the_scan_is_no_reason_to_refuse_what_leaves_it_as_it_is() -> None:
    before = ball_beside_crossing_balls()
    along = before.vertices_mm + np.array([150.0, 0.0, 0.0])
    require_sound(before, before.with_vertices(along))


def test_a_new_face_on_old_vertices_that_lies_on_another_is_refused() -> None:
    square = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0.0]])
    before = Mesh(vertices_mm=square, faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    double = np.concatenate([before.faces, np.array([[1, 0, 3]], np.int32)])
    with pytest.raises(EditError, match="fold over"):
        require_sound(before, replace(before, faces=double))


def test_a_crossing_of_the_scan_stays_excused_where_vertices_are_numbered_anew() -> None:
    """As by a cut that drops as many vertices as it makes."""
    before = ball_beside_crossing_balls()
    turned = np.random.default_rng(1).permutation(len(before))
    faces = np.argsort(turned)[before.faces].astype(np.int32)
    require_sound(before, Mesh(vertices_mm=before.vertices_mm[turned], faces=faces))


def test_a_crossing_of_the_scan_stays_excused_where_triangles_are_made_finer() -> None:
    """Its small triangles lie farther from the middle of the large ones than they are long."""
    before = ball_beside_crossing_balls()
    vertices, faces = before.vertices_mm, before.faces
    for _ in range(3):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    finer = Mesh(vertices_mm=np.asarray(vertices), faces=faces.astype(np.int32))
    assert len(find_crossings(finer.vertices_mm, finer.faces)) > 0
    require_sound(before, finer)
