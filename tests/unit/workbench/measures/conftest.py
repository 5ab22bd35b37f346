"""Bodies whose measures have closed forms, as they are faceted."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh

MakeTurned = Callable[..., Mesh]


def turned(
    radii_mm: np.ndarray,
    heights_mm: np.ndarray,
    spokes: int,
    *,
    capped: bool = True,
    squeeze: float = 1.0,
) -> Mesh:
    """A body of rings of `spokes` corners, the first at +X; y is multiplied by `squeeze`."""
    angles = 2 * np.pi * np.arange(spokes) / spokes
    ring = np.column_stack([np.cos(angles), squeeze * np.sin(angles)])
    rows = len(heights_mm)
    wall = np.concatenate(
        [np.column_stack([r * ring, np.full(spokes, z)]) for r, z in zip(radii_mm, heights_mm)]
    )
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows - 1), np.arange(spokes), indexing="ij"))
    here, beside = i * spokes + j, i * spokes + (j + 1) % spokes
    faces = [
        np.column_stack([here, beside, beside + spokes]),
        np.column_stack([here, beside + spokes, here + spokes]),
    ]
    if capped:
        low, high = rows * spokes, rows * spokes + 1
        wall = np.concatenate([wall, [[0, 0, heights_mm[0]], [0, 0, heights_mm[-1]]]])
        k = np.arange(spokes)
        after = (k + 1) % spokes
        top = (rows - 1) * spokes
        faces.append(np.column_stack([after, k, np.full(spokes, low)]))
        faces.append(np.column_stack([top + k, top + after, np.full(spokes, high)]))
    return Mesh(vertices_mm=wall, faces=np.concatenate(faces).astype(np.int32))


def forked(apart_mm: float, radii_mm: tuple[float, float], spokes: int = 96) -> Mesh:
    """A bent tube: one arm rises at x = 0, the other at x = `apart_mm`; they meet below.

    Between 0 and 200 mm either arm is a prism with a radius of its own.
    """
    bend = np.linspace(np.pi, 2 * np.pi, 61)[1:-1]
    half = apart_mm / 2
    down, up = np.arange(200.0, -1, -4), np.arange(0.0, 201, 4)
    x = np.concatenate(
        [np.zeros(len(down)), half + half * np.cos(bend), np.full(len(up), 2 * half)]
    )
    z = np.concatenate([down, half * np.sin(bend), up])
    turn = np.concatenate([np.full(len(down), np.pi), bend, np.full(len(up), 2 * np.pi)])
    radius = np.interp(turn, [np.pi, 2 * np.pi], radii_mm)
    angles = 2 * np.pi * np.arange(spokes) / spokes
    across = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], 1)[:, None] * np.cos(angles)[:, None]
    beside = np.array([0.0, 1, 0]) * np.sin(angles)[:, None]
    wall = np.stack([x, 0 * x, z], 1)[:, None] + radius[:, None, None] * (across + beside)
    tube = turned(np.ones(len(x)), np.arange(len(x), dtype=float), spokes)
    ends = np.array([[x[0], 0, z[0]], [x[-1], 0, z[-1]]])
    return tube.with_vertices(np.concatenate([wall.reshape(-1, 3), ends]))


@pytest.fixture(scope="session")
def make_forked() -> MakeTurned:
    return forked


@pytest.fixture(scope="session")
def make_turned() -> MakeTurned:
    return turned


@pytest.fixture(scope="session")
def cylinder() -> Mesh:
    """Radius 50 mm, 200 mm high, 96 corners, closed."""
    return turned(np.full(41, 50.0), np.linspace(0, 200, 41), 96)
