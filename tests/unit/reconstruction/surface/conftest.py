"""Point clouds of shapes known exactly."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Cloud

MakeCloud = Callable[..., Cloud]


@pytest.fixture(scope="session")
def make_cloud() -> MakeCloud:
    """Cloud of points and outward normals, moved along the normals by seeded noise."""

    def make(points: np.ndarray, normals: np.ndarray, noise_mm: float = 0.0) -> Cloud:
        rng = np.random.default_rng(7)
        moved = points + noise_mm * rng.standard_normal((len(points), 1)) * normals
        return Cloud(
            points_mm=moved.astype(np.float32),
            normals=normals.astype(np.float32),
            colours=np.clip(128 + points, 0, 255).astype(np.uint8),
            views=np.full(len(points), 4, np.uint16),
            spacing_mm=1.0,
        )

    return make


@pytest.fixture(scope="session")
def even_directions() -> Callable[[int], np.ndarray]:
    """Unit vectors spread evenly: a Fibonacci lattice."""

    def make(count: int) -> np.ndarray:
        k = np.arange(count) + 0.5
        z = 1 - 2 * k / count
        angle = np.pi * (1 + 5**0.5) * k
        across = np.sqrt(1 - z**2)
        return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])

    return make


@pytest.fixture(scope="session")
def sphere_cloud(make_cloud: MakeCloud, even_directions: Callable[[int], np.ndarray]) -> Cloud:
    """Radius 30 mm, a point per square millimetre, noise 0.05 mm."""
    directions = even_directions(round(4 * np.pi * 30**2))
    return make_cloud(30 * directions, directions, 0.05)


@pytest.fixture(scope="session")
def open_cylinder(make_cloud: MakeCloud) -> Callable[[float], Cloud]:
    """A limb-like thimble: radius 20 mm, 60 mm of wall from z = 0, a half sphere on top."""

    def make(noise_mm: float) -> Cloud:
        # Turns of a helix a millimetre apart, by arc length along the profile.
        length = 60 + 20 * np.pi / 2
        arc, angle = [], []
        for row in np.arange(0.5, length, 0.9):
            radius = 20.0 if row < 60 else 20 * np.cos((row - 60) / 20)
            count = max(3, round(2 * np.pi * radius))
            arc.append(np.full(count, row))
            angle.append(2 * np.pi * (np.arange(count) + 0.5 * (len(arc) % 2)) / count)
        s, a = np.concatenate(arc), np.concatenate(angle)
        lift = np.where(s < 60, 0.0, (s - 60) / 20)
        normals = np.column_stack(
            [np.cos(lift) * np.cos(a), np.cos(lift) * np.sin(a), np.sin(lift)]
        )
        points = 20 * normals
        points[:, 2] += np.minimum(s, 60)
        return make_cloud(points, normals, noise_mm)

    return make
