"""Limbs whose radius is a known function of height and angle."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

Radius = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""mm, of height in mm and angle in radians from the front (+Y) towards the right (+X)."""
MakeLimb = Callable[..., Limb]

TOP_MM = 220.0
DOME_MM = 45.0


def uneven(height_mm: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """A wall that widens, flatter behind, with a crest in front: no two of its sides are alike."""
    widening = 45 + 0.06 * height_mm
    return widening * (
        1
        + 0.05 * np.cos(2 * angle)
        + 0.03 * np.cos(3 * angle + 0.4)
        + 0.04 * np.exp(4 * (np.cos(angle) - 1)) * np.sin(height_mm / 60)
    )


def shaped(radius: Radius = uneven, *, spokes: int = 90, rows: int = 70, turn: float = 0.0) -> Limb:
    """A limb with a dome below and an open brim, in its own limb frame."""
    rise = np.linspace(0, 1, rows + 1)[1:]
    arc = np.pi / 2 * DOME_MM
    along = rise * (arc + TOP_MM - DOME_MM)
    dome = np.minimum(along / DOME_MM, np.pi / 2)
    heights = np.where(along < arc, DOME_MM * (1 - np.cos(dome)), along - arc + DOME_MM)
    angles = turn + 2 * np.pi * np.arange(spokes) / spokes
    z, a = np.meshgrid(heights, angles, indexing="ij")
    r = radius(z, a) * np.sin(dome)[:, None]
    wall = np.stack([r * np.sin(a), r * np.cos(a), z], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([wall, [[0.0, 0.0, 0.0]]])
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rows - 1), np.arange(spokes), indexing="ij"))
    here, beside = i * spokes + j, i * spokes + (j + 1) % spokes
    k = np.arange(spokes)
    faces = np.concatenate(
        [
            np.column_stack([beside, here, beside + spokes]),
            np.column_stack([here, here + spokes, beside + spokes]),
            np.column_stack([k, (k + 1) % spokes, np.full(spokes, rows * spokes)]),
        ]
    )
    mesh = Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return AlignedLimb(mesh=mesh, frame=frame, name="limb.ply")


@pytest.fixture(scope="session")
def make_limb() -> MakeLimb:
    return shaped


@pytest.fixture(scope="session")
def limb() -> Limb:
    return shaped()


def moved(limb: Limb, pose: Rigid) -> Limb:
    """The limb lying elsewhere, with nothing known of how."""
    return Limb(mesh=limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm)), name="moved.ply")


@pytest.fixture(scope="session")
def move() -> Callable[[Limb, Rigid], Limb]:
    return moved
