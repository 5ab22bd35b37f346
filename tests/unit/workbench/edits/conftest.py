"""A stump of known shape: a tube with a round end, open at its top."""

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame

RADIUS_MM = 40.0
TOP_MM = 160.0
SPOKES = 72


def stump(spokes: int = SPOKES, step_mm: float = 4.0) -> Mesh:
    """Half a sphere below height RADIUS_MM, a tube from there to TOP_MM."""
    angle = 2 * np.pi * np.arange(spokes) / spokes
    polar = np.linspace(0, np.pi / 2, int(RADIUS_MM * np.pi / 2 / step_mm) + 1)[1:]
    rows = [(RADIUS_MM * np.sin(p), RADIUS_MM * (1 - np.cos(p))) for p in polar]
    count = round((TOP_MM - RADIUS_MM) / step_mm)
    rows += [(RADIUS_MM, z) for z in np.linspace(RADIUS_MM, TOP_MM, count + 1)[1:]]
    rings = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle + z]) for r, z in rows
    ]
    vertices = np.concatenate([np.zeros((1, 3)), *rings])
    here = 1 + np.arange(spokes)
    ahead = np.roll(here, -1)
    faces = [np.column_stack([0 * here, ahead, here])]
    for row in range(len(rows) - 1):
        a, b = here + row * spokes, ahead + row * spokes
        faces += [np.column_stack([a, b, b + spokes]), np.column_stack([a, b + spokes, a + spokes])]
    return Mesh(vertices_mm=vertices, faces=np.concatenate(faces).astype(np.int32))


@pytest.fixture(scope="session")
def limb() -> Limb:
    """Aligned in a turned mesh frame, with landmarks in front and at the right."""
    motion = Rigid.from_rotation_vector(np.array([0.3, -0.2, 0.5]), np.array([5.0, -7.0, 11.0]))
    back = motion.inverse
    mesh = stump()
    front, right = back.apply(np.array([[0.0, RADIUS_MM, 100.0], [RADIUS_MM, 0.0, 100.0]]))
    return AlignedLimb(
        mesh=mesh.with_vertices(back.apply(mesh.vertices_mm)),
        frame=LimbFrame(limb_from_mesh=motion, side="right"),
        landmarks=(
            Landmark(name="front", position_mm=front),
            Landmark(name="right", position_mm=right),
        ),
    )
