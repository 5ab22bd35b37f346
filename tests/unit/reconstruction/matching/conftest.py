"""A picture known everywhere, not only at pixels: a sum of waves."""

from collections.abc import Callable

import numpy as np
import pytest

Waves = Callable[[np.ndarray, np.ndarray], np.ndarray]


@pytest.fixture(scope="session")
def waves() -> Waves:
    """Luma at real coordinates: 150 waves between 6 and 40 px long."""
    rng = np.random.default_rng(3)
    direction, length = rng.uniform(0, 2 * np.pi, 150), rng.uniform(6, 40, 150)
    phase = rng.uniform(0, 2 * np.pi, 150)
    kx, ky = 2 * np.pi * np.cos(direction) / length, 2 * np.pi * np.sin(direction) / length

    def luma(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        total = np.zeros(np.broadcast(x, y).shape)
        for wave_x, wave_y, start in zip(kx, ky, phase):
            total += np.cos(wave_x * x + wave_y * y + start)
        return 128 + 4.5 * total

    return luma
