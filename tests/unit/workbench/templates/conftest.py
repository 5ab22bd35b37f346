"""Limbs of different sizes and shapes with landmarks, and what is done to them round those."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame, Side

SPOKES, ROWS = 96, 70


@dataclass(frozen=True, kw_only=True)
class Build:
    """What makes a limb unlike another."""

    size: float = 1.0
    tall: float = 1.0
    squeeze: float = 0.0
    turn: float = 0.0
    """Of the landmarks about the axis, radians."""


def limb_of(build: Build, side: Side = "right") -> Limb:
    """A dome and a widening wall; on a left limb everything is mirrored."""
    lateral = -1.0 if side == "left" else 1.0
    dome, top = 45.0 * build.size, 210.0 * build.tall
    arc = np.pi / 2 * dome
    along = np.linspace(0, 1, ROWS + 1)[1:] * (arc + top - dome)
    bend = np.minimum(along / dome, np.pi / 2)
    heights = np.where(along < arc, dome * (1 - np.cos(bend)), along - arc + dome)
    angles = 2 * np.pi * np.arange(SPOKES) / SPOKES

    def wall(z: np.ndarray, a: np.ndarray) -> np.ndarray:
        widening = build.size * (45 + 0.05 * z / build.tall)
        return widening * (1 + (0.04 + build.squeeze) * np.cos(2 * a) + 0.02 * np.cos(3 * a + 0.3))

    z, a = np.meshgrid(heights, angles, indexing="ij")
    r = wall(z, a) * np.sin(bend)[:, None]
    points = np.stack([lateral * r * np.sin(a), r * np.cos(a), z], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([points, [[0.0, 0.0, 0.0]]])
    i, j = (k.ravel() for k in np.meshgrid(np.arange(ROWS - 1), np.arange(SPOKES), indexing="ij"))
    here, beside = i * SPOKES + j, i * SPOKES + (j + 1) % SPOKES
    k = np.arange(SPOKES)
    faces = np.concatenate(
        [
            np.column_stack([beside, here, beside + SPOKES]),
            np.column_stack([here, here + SPOKES, beside + SPOKES]),
            np.column_stack([k, (k + 1) % SPOKES, np.full(SPOKES, ROWS * SPOKES)]),
        ]
    ).astype(np.int32)
    places = {
        "patellar tendon": (165 * build.tall, 0.0),
        "tibial crest": (90 * build.tall, 0.15),
        "fibula head": (150 * build.tall, 1.4 + build.turn),
        "popliteal crease": (160 * build.tall, np.pi - 0.5 * build.turn),
    }
    marks = tuple(
        Landmark(
            name=name,
            position_mm=np.array(
                [lateral * wall(h, t) * np.sin(t), wall(h, t) * np.cos(t), h], float
            ),
        )
        for name, (h, t) in places.items()
    )
    mesh = Mesh(vertices_mm=vertices, faces=faces if side != "left" else faces[:, ::-1].copy())
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side=side)
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, name="limb.ply")


RECTIFICATION = {"patellar tendon": -6.0, "popliteal crease": 4.0, "fibula head": 3.0}
"""Depth at each landmark, mm outwards, falling off with 16 mm."""
FALLOFF_MM = 16.0


def rectification(limb: Limb, depths: Mapping[str, float] = RECTIFICATION) -> np.ndarray:
    """True displacement of every vertex, by its distance from the landmarks."""
    total = np.zeros(len(limb.mesh))
    for mark in limb.landmarks:
        square = ((limb.mesh.vertices_mm - mark.position_mm) ** 2).sum(1)
        total += depths.get(mark.name, 0.0) * np.exp(-square / (2 * FALLOFF_MM**2))
    return total


def after(limb: Limb, moved_mm: np.ndarray) -> Limb:
    vertices = limb.mesh.vertices_mm + moved_mm[:, None] * limb.mesh.vertex_normals()
    return limb.with_mesh(limb.mesh.with_vertices(vertices))


def lying(limb: Limb, seed: int) -> Limb:
    """The same limb in another pose, its frame and landmarks with it."""
    pose = Rigid(
        Rotation.random(random_state=seed).as_matrix(),
        np.random.default_rng(seed).normal(0, 80, 3),
    )
    marks = tuple(
        replace(mark, position_mm=pose.apply(mark.position_mm[None])[0]) for mark in limb.landmarks
    )
    mesh = limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm))
    lain = replace(limb, mesh=mesh, landmarks=marks)
    if not isinstance(limb, AlignedLimb):
        return lain
    return lain.with_frame(replace(limb.frame, limb_from_mesh=limb.limb_from_mesh @ pose.inverse))


def ripple(limb: Limb, seed: int, size_mm: float) -> np.ndarray:
    """A hand's smooth inaccuracy: waves of random direction over the surface."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(0, 1 / 25, (12, 3))
    phases = rng.uniform(0, 2 * np.pi, 12)
    return size_mm * np.sqrt(2 / 12) * np.cos(limb.mesh.vertices_mm @ waves.T + phases).sum(1)


@dataclass(frozen=True)
class Bench:
    """The builders, for tests."""

    build: type[Build] = Build
    limb_of: Callable[..., Limb] = limb_of
    rectification: Callable[..., np.ndarray] = rectification
    after: Callable[[Limb, np.ndarray], Limb] = after
    lying: Callable[[Limb, int], Limb] = lying
    ripple: Callable[[Limb, int, float], np.ndarray] = ripple


@pytest.fixture(scope="session")
def bench() -> Bench:
    return Bench()
