"""Stated 95 % intervals of contours and tapes hold on smooth, wrinkled and knitted limbs alike.

No photos: a band of a limb whose surface is known, and the same as it is measured, with errors of
known size that are alike over a known reach, and without the knit, which no photo shows.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.smoothed_length import FILTER_LENGTH_MM
from limbgram.core.interval import COVER
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.measures.levels import (
    Level,
    Measure,
    Sigmas,
    contour_mm,
    level_at,
    levels_at,
    tape_mm,
)

RADIUS_MM, HALF_MM = 50.0, 14.0
LEVELS_MM = (-9.0, -3.0, 3.0, 9.0)
SIGMA_MM, REACH_MM = 0.06, 4.0
TRIALS = 100
Skin = Callable[[np.ndarray, np.ndarray], np.ndarray]


def smooth(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    return 3 * np.sin(2 * along / RADIUS_MM) + 0 * up


def wrinkled(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Creases 12 to 25 mm apart in all directions, which the photos show."""
    rng = np.random.default_rng(5)
    waves = np.geomspace(12, 25, 12)
    turns = rng.uniform(0, 2 * np.pi, 12)
    whole = 2 * np.pi * RADIUS_MM
    total = smooth(along, up)
    for wave, turn, phase in zip(waves, turns, rng.uniform(0, 6, 12), strict=True):
        around = np.round(whole * np.cos(turn) / wave) / whole
        total = total + 0.15 * np.sin(
            2 * np.pi * (around * along + np.sin(turn) / wave * up) + phase
        )
    return total


def knit(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    """A weave of 0.1 mm from top to bottom, 2 mm from stitch to stitch."""
    stitch = 2 * np.pi * RADIUS_MM / round(np.pi * RADIUS_MM)
    return 0.05 * np.cos(2 * np.pi * along / stitch) * np.cos(np.pi * up)


def knitted(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    return smooth(along, up) + knit(along, up)


def grid(step_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Places round the limb, in mm along it, and heights, by row and spoke."""
    count = round(2 * np.pi * RADIUS_MM / step_mm)
    along = np.arange(count) * 2 * np.pi * RADIUS_MM / count
    up = np.linspace(-HALF_MM, HALF_MM, round(2 * HALF_MM / step_mm) + 1)
    wide, high = np.meshgrid(along, up)
    return wide, high


def band(rise_mm: np.ndarray, step_mm: float) -> Mesh:
    along, up = grid(step_mm)
    rows, spokes = along.shape
    angle, radius = along / RADIUS_MM, RADIUS_MM + rise_mm
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), up], -1).reshape(-1, 3)
    at = np.arange(rows * spokes).reshape(rows, spokes)
    beside = np.roll(at, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (at[:-1], beside[:-1], beside[1:], at[1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def errors_mm(step_mm: float, rng: np.random.Generator) -> np.ndarray:
    """Errors of one sigma, alike by exp(-(d / reach)^2): white noise through a Gaussian."""
    along, up = grid(step_mm)
    shape = len(up) + 40, along.shape[1]
    wide = (
        2
        * np.pi
        * np.hypot(np.fft.fftfreq(shape[0], step_mm)[:, None], np.fft.rfftfreq(shape[1], step_mm))
    )
    noise = np.fft.irfft2(
        np.fft.rfft2(rng.standard_normal(shape)) * np.exp(-((wide * REACH_MM) ** 2) / 8), shape
    )
    return SIGMA_MM * (noise / noise.std())[: len(up)]


def longer_by_noise() -> float:
    """How much longer a smoothed line is for such errors: half of its squared slope."""
    k = np.linspace(0, 12, 4001)
    spectrum = REACH_MM * np.exp(-((k * REACH_MM) ** 2) / 4) / np.sqrt(np.pi)
    stays = 1 / (1 + (k * FILTER_LENGTH_MM) ** 4)
    return SIGMA_MM**2 * float(np.sum(k**2 * stays**2 * spectrum) * (k[1] - k[0])) / 2


def value_mm(girth: Measure, level: Level) -> float:
    sloped = girth(level)
    assert sloped is not None
    return sloped.value


@pytest.mark.parametrize("girth", [pytest.param(contour_mm, marks=pytest.mark.slow), tape_mm])
@pytest.mark.parametrize(
    ("true", "seen"),
    [
        pytest.param(smooth, smooth, marks=pytest.mark.slow),
        (wrinkled, wrinkled),
        pytest.param(knitted, smooth, marks=pytest.mark.slow),
    ],
)
def test_intervals_of_girths_hold_on_every_skin(true: Skin, seen: Skin, girth: Measure) -> None:
    fine = band(true(*grid(0.4)), 0.4)
    truth = [value_mm(girth, level_at(fine, height)) for height in LEVELS_MM]
    along, up = grid(1.0)
    rng = np.random.default_rng(17)
    ratios: list[float] = []
    for _ in range(TRIALS):
        mesh = band(seen(along, up) + errors_mm(1.0, rng), 1.0)
        mesh = replace(
            mesh,
            sigma_mm=np.full(len(mesh), SIGMA_MM, np.float32),
            correlation_mm=REACH_MM,
            lost_length=np.tile(np.array([-longer_by_noise(), 0.0], np.float32), (len(mesh), 1)),
        )
        sigmas = Sigmas.of(mesh)
        for level, known in zip(levels_at(mesh, LEVELS_MM), truth, strict=True):
            assert isinstance(level, Level)
            sloped = girth(level)
            assert sloped is not None
            figure = sigmas.figure(level, sloped)
            assert figure.sigma is not None
            ratios.append((figure.value - known) / figure.sigma)
    held = np.mean(np.abs(ratios) < COVER)
    assert 0.93 <= held <= 0.97
    assert 0.9 < np.sqrt(np.mean(np.square(ratios))) < 1.1
    assert abs(np.mean(ratios)) < 0.35  # faces of 1 mm cut the creases' tops by 0.02 mm of line
