"""What cannot be laid back is left out: the rest is a manifold without folds, and has not moved."""

import numpy as np

from limbgram.core.mesh.folds import find_branching, find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.measurement import torn_open


def sheet(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A flat sheet of unit squares, two triangles each."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def test_a_sheet_that_another_one_passes_through_loses_the_strip_between() -> None:
    """A sheet of 20 x 9, cut at x = 15.5 by an upright one: its left part of 15 x 9 stays."""
    flat, faces = sheet(20, 9)
    upright, more = sheet(9, 9)
    upright = np.column_stack([np.full(len(upright), 15.5), upright[:, 0], upright[:, 1] - 4.5])
    mesh = Mesh(
        vertices_mm=np.vstack([flat, upright]),
        faces=np.vstack([faces, more + len(flat)]).astype(np.int32),
        filled=np.arange(len(flat) + len(upright)) % 7 == 0,
    )
    assert len(find_folds(mesh).crossing) > 0
    rest = torn_open(mesh)
    assert len(find_folds(rest)) == 0
    assert not len(find_branching(rest.faces))
    assert len(rest.faces) >= 2 * 14 * 9  # the column beside the cut may go with it
    assert rest.vertices_mm[:, 0].max() <= 15.0
    known = {tuple(point): mark for point, mark in zip(mesh.vertices_mm, mesh.filled, strict=True)}
    for point, mark in zip(rest.vertices_mm, rest.filled, strict=True):
        assert known[tuple(point)] == mark


def test_a_sound_sheet_stays_whole() -> None:
    points, faces = sheet(6, 6)
    mesh = Mesh(vertices_mm=points, faces=faces.astype(np.int32))
    assert len(torn_open(mesh).faces) == len(faces)
