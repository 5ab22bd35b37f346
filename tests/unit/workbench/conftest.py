"""A limb known in its own frame, and the same limb lying anywhere."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.limb import Landmark, Limb

SPOKES = 96
BRIM_MM = 230.0
LANDMARKS = {
    "patellar tendon": (0, 1, 180.0),
    "tibial crest": (0, 1, 90.0),
    "fibula head": (1, 0, 170.0),
    "popliteal crease": (0, -1, 185.0),
}
"""On a right limb: direction from the axis, and height."""


def radius_mm(height_mm: np.ndarray) -> np.ndarray:
    """A dome of 40 mm, then a wall that widens evenly."""
    h = np.asarray(height_mm, float)
    dome = np.sqrt(np.maximum(1 - (1 - np.minimum(h, 40) / 40) ** 2, 0))
    return dome * (40 + 20 * np.maximum(h - 40, 0) / (BRIM_MM - 40))


@pytest.fixture(scope="session")
def stump() -> Limb:
    """A right stump in its limb frame: its section is an ellipse, wider from side to side."""
    heights = np.concatenate(
        [40 * (1 - np.cos(np.linspace(0.15, np.pi / 2, 15))), np.arange(45, 231, 5.0)]
    )
    angles = 2 * np.pi * np.arange(SPOKES) / SPOKES
    ring = np.column_stack([np.cos(angles), 0.85 * np.sin(angles)])
    vertices = np.concatenate(
        [[[0.0, 0, 0]]]
        + [
            np.column_stack([r * ring, np.full(SPOKES, h)])
            for r, h in zip(radius_mm(heights), heights)
        ]
    )
    i, j = (
        k.ravel()
        for k in np.meshgrid(np.arange(len(heights) - 1), np.arange(SPOKES), indexing="ij")
    )
    here, beside = 1 + i * SPOKES + j, 1 + i * SPOKES + (j + 1) % SPOKES
    k = np.arange(SPOKES)
    faces = np.concatenate(
        [
            np.column_stack([here, beside, beside + SPOKES]),
            np.column_stack([here, beside + SPOKES, here + SPOKES]),
            np.column_stack([1 + (k + 1) % SPOKES, 1 + k, 0 * k]),
        ]
    ).astype(np.int32)
    marks = tuple(
        Landmark(
            name=name,
            position_mm=np.array([x * radius_mm(h), 0.85 * y * radius_mm(h), h]),
        )
        for name, (x, y, h) in LANDMARKS.items()
    )
    return Limb(mesh=Mesh(vertices_mm=vertices, faces=faces), landmarks=marks)


Lay = Callable[[Limb, int], Limb]


@pytest.fixture(scope="session")
def lay() -> Lay:
    """The same limb, unaligned, lying elsewhere: one pose for each seed."""

    def laid(limb: Limb, seed: int) -> Limb:
        rng = np.random.default_rng(seed)
        pose = Rigid(Rotation.random(random_state=seed).as_matrix(), rng.normal(0, 300, 3))
        marks = tuple(
            Landmark(name=mark.name, position_mm=pose.apply(mark.position_mm[None])[0])
            for mark in limb.landmarks
        )
        mesh = limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm))
        return Limb(mesh=mesh, landmarks=marks)

    return laid
