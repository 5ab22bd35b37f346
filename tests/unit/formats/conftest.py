"""A small mesh with everything known of it."""

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.mesh import Mesh

AWAY = np.array([100.123456789, -50, 30])


@pytest.fixture(scope="session")
def mesh() -> Mesh:
    """A capsule 100 mm off the origin, its axis tilted off x."""
    shape = trimesh.creation.capsule(height=40.0, radius=15.0, count=[16, 16])
    shape.apply_transform(trimesh.transformations.rotation_matrix(0.3, [0, 1, 0], [0, 0, 0]))
    rng = np.random.default_rng(5)
    count = len(shape.vertices)
    return Mesh(
        vertices_mm=np.asarray(shape.vertices, float) + AWAY,
        faces=shape.faces.astype(np.int32),
        colours=rng.integers(0, 256, (count, 3), np.uint8),
        filled=rng.random(count) < 0.1,
        sigma_mm=rng.random(count).astype(np.float32),
    )
