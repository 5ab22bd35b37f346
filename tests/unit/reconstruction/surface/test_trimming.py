"""Rims cut back: exactly the doubtful rows go, and no hole opens inside."""

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold
from limbgram.reconstruction.surface.cleaning import cut_back

ROWS, COLUMNS = 12, 20


def _sheet() -> Mesh:
    y, x = np.mgrid[:ROWS, :COLUMNS].astype(float)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()
    below, across = first + COLUMNS, first + COLUMNS + 1
    faces = np.concatenate(
        [np.stack([first, first + 1, across], 1), np.stack([first, across, below], 1)]
    )
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def test_doubtful_rows_at_the_rim_go_and_no_more() -> None:
    sheet = _sheet()
    cut = cut_back(sheet, sheet.vertices_mm[:, 1] < 2.5, rings=8)
    assert cut.vertices_mm[:, 1].min() == 3
    assert len(cut) == (ROWS - 3) * COLUMNS
    assert is_edge_manifold(cut.faces)


def test_no_more_rows_go_than_allowed() -> None:
    sheet = _sheet()
    cut = cut_back(sheet, sheet.vertices_mm[:, 1] < 5.5, rings=2)
    assert cut.vertices_mm[:, 1].min() == 2


def test_doubt_inside_opens_no_hole() -> None:
    sheet = _sheet()
    inside = np.linalg.norm(sheet.vertices_mm - [10, 6, 0], axis=1) < 2.5
    cut = cut_back(sheet, inside, rings=8)
    assert len(cut) == len(sheet)
    assert len(boundary_loops(cut.faces)) == 1
