"""A rim ends where patches among believed ones are believed; what overhangs there is told."""

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.measurement import trimmed_to_belief

ROWS, COLUMNS, EDGE = 14, 24, 8


def _sheet(first_row: int = 0) -> Mesh:
    """Unit squares, two triangles each; six neighbours round a vertex."""
    y, x = np.mgrid[first_row:ROWS, :COLUMNS].astype(float)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    rows = ROWS - first_row
    first = (np.arange(rows - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()
    below, across = first + COLUMNS, first + COLUMNS + 1
    faces = np.concatenate(
        [np.stack([first, first + 1, across], 1), np.stack([first, across, below], 1)]
    )
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def test_a_tongue_that_chance_believed_goes() -> None:
    """The surface ends at row 8; three patches beyond look alike by chance, at the edge and off."""
    sheet = _sheet()
    x, y, _ = sheet.vertices_mm.T
    chance = [(8, 7), (8, 6), (9, 7), (15, 3), (16, 4), (16, 3)]
    believed = (y >= EDGE) | np.array([(a, b) in chance for a, b in zip(x, y, strict=True)])
    cut, overhang = trimmed_to_belief(sheet, np.ones(len(sheet), bool), believed)
    height = cut.vertices_mm[:, 1]
    assert height.min() == EDGE - 1  # 6 and less without the others' word
    assert (height >= EDGE).sum() == (ROWS - EDGE) * COLUMNS - 1  # a corner of the sheet
    assert overhang[height < EDGE].all()
    assert not overhang[height > EDGE].any()
    assert overhang[height == EDGE].mean() > 0.8  # all but beside what was believed beyond


def test_a_rim_beyond_which_nothing_was_given_overhangs_nowhere() -> None:
    sheet = _sheet(EDGE)
    everywhere = np.ones(len(sheet), bool)
    cut, overhang = trimmed_to_belief(sheet, everywhere, everywhere)
    assert len(cut) == len(sheet)
    assert not overhang.any()
