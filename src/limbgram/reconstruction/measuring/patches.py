"""Multi-photo least-squares matching of one small surface patch per vertex (compiled).

Unknown per patch: offset d along the normal and two slopes. Every photo that sees the patch
shows the same unknown texture with its own gain and mean; texture, gains and means are
eliminated (the texture is the leading left singular vector of the photos' windows, derivative
after Kaufman 1975), so that no photo is the reference. The patch is curved by a given quadric:
without it the surface sinks.
Threads take blocks of patches. Functions that the kernels call are inlined (`forceinline`): linked
ones were compiled once more when the cache was read, and gave other last digits.
Gruen and Baltsavias 1988 (geometrically constrained matching); Furukawa and Ponce 2010.
"""

import math

import numpy as np

from limbgram.core.kernels import njit
from limbgram.core.run import in_parallel
from limbgram.core.solvers import adjugate
from limbgram.reconstruction.measuring.imagery import Imagery
from limbgram.reconstruction.measuring.sampling import (
    HALF_WIDTH,
    SAMPLES,
    Patches,
    Windows,
    drop_inconsistent_photos,
    empty_windows,
    fill_gram,
    sample_windows,
)

f4 = np.float32

_BLOCK = 2048
"""Patches per block of a thread."""
_MIN_VARIANCE = 4.0
"""Windows of less grey variance count as untextured."""
_MAX_SLOPE = 1.2
_SLOPE_PRIOR = 0.3

MEASURED, UNSEEN, INCONSISTENT, SINGULAR, DIVERGED, STEEP = 1, 0, -1, -2, -3, -4
"""Outcome of a patch; every value but MEASURED is a failure."""


def measure_patches(
    imagery: Imagery,
    seen_by: np.ndarray,
    patches: Patches,
    max_iterations: int,
    state: np.ndarray,
) -> np.ndarray:
    """Offset and slopes of every patch, in `state`, and a report on each.

    seen_by   (n, c) int32, photos of each patch, -1 = none
    state     (n, 3) start values, mm and slopes; changed in place
    Returns (n, 5) float32: outcome, formal sigma of d (mm), noise (grey levels), mean
    correlation (less for photos left out), photos used.
    """
    report = np.zeros((len(seen_by), 5), np.float32)

    def block(first: int) -> None:
        rows = slice(first, first + _BLOCK)
        _measure_block(
            imagery, seen_by[rows], patches.rows(rows), max_iterations, state[rows], report[rows]
        )

    in_parallel(block, range(0, len(seen_by), _BLOCK))
    return report


@njit(fastmath=True, cache=True, nogil=True)
def _measure_block(
    imagery: Imagery,
    seen_by: np.ndarray,
    patches: Patches,
    max_iterations: int,
    state: np.ndarray,
    report: np.ndarray,
):
    """Measure the patches, each independently."""
    windows = empty_windows(seen_by.shape[1])
    gram, weights = windows.gram, windows.weights
    texture = np.empty(SAMPLES, np.float32)
    texture_slope = np.empty(SAMPLES, np.float32)
    effective_samples = f4(0)
    for k in range(SAMPLES):
        effective_samples += weights[k] * weights[k]
    effective_samples = f4(1) / effective_samples
    normal = np.empty(9)
    for p in range(len(seen_by)):
        step_mm = patches.step_mm[p]
        for iteration in range(max_iterations + 1):
            used, px_per_mm = sample_windows(
                imagery, seen_by[p], patches, p, state[p], _MIN_VARIANCE, windows
            )
            if used < 2:
                report[p, 0] = UNSEEN
                break
            fill_gram(windows, used)
            initial = used
            used = drop_inconsistent_photos(windows, used, 0.0)
            if used == 0:
                report[p, 0] = INCONSISTENT
                break
            window_energy = 0.0
            for i in range(used):
                window_energy += gram[i, i]
            energy = _mean_texture(windows, used, texture, texture_slope)
            _normal_equations(windows, used, texture, texture_slope, energy, step_mm, normal)
            degrees_of_freedom = (used - 1) * (effective_samples - 2) - 3
            noise2 = max(
                (window_energy - energy) * effective_samples / max(degrees_of_freedom, 1.0), 0.0
            )
            prior = max(noise2, 0.5) / (effective_samples * _SLOPE_PRIOR**2)
            step_d, step_a, step_b, cofactor = _solve_step(normal, prior, state[p])
            if not cofactor > 0:
                report[p, 0] = SINGULAR
                break
            report[p, 1] = math.sqrt(noise2 / effective_samples * cofactor)
            report[p, 2] = math.sqrt(noise2)
            correlation = (energy / window_energy * used - 1) / (used - 1)
            report[p, 3] = correlation * used / initial
            report[p, 4] = used
            report[p, 0] = MEASURED
            if iteration == max_iterations:
                break
            if not abs(step_d) * px_per_mm < 6:
                report[p, 0] = DIVERGED
                break
            damping = 1.0 / max(1.0, abs(step_d) * px_per_mm / 1.5)
            state[p, 0] += damping * step_d
            state[p, 1] += damping * step_a
            state[p, 2] += damping * step_b
            if abs(state[p, 1]) > _MAX_SLOPE or abs(state[p, 2]) > _MAX_SLOPE:
                report[p, 0] = STEEP
                break
            reach = (abs(step_a) + abs(step_b)) * HALF_WIDTH * step_mm
            if abs(step_d) * px_per_mm < 0.01 and reach * px_per_mm < 0.03:
                break


@njit(fastmath=True, cache=True, forceinline=True)
def _mean_texture(windows: Windows, used: int, texture: np.ndarray, texture_slope: np.ndarray):
    """Fill the common texture and its change with d; returns the texture's weighted energy."""
    value, slope, weights, gains = windows.value, windows.slope, windows.weights, windows.gains
    energy = f4(0)
    for k in range(SAMPLES):
        grey, change = f4(0), f4(0)
        for i in range(used):
            grey += f4(gains[i]) * value[i, k]
            change += f4(gains[i]) * slope[i, k]
        texture[k], texture_slope[k] = grey, change
        energy += weights[k] * grey * grey
    return energy


@njit(fastmath=True, cache=True, forceinline=True)
def _normal_equations(
    windows: Windows,
    used: int,
    texture: np.ndarray,
    texture_slope: np.ndarray,
    energy: float | np.float32,
    step: float,
    normal: np.ndarray,
):
    """Fill the upper triangle (6) and right-hand side (3) of the equations for d and the slopes.

    With windows G = gains texture^T, H_j their change by parameter j, a and t the unit gains and
    texture: texture and gains are eliminated by (I - a a^T) H_j (I - t t^T), means by weighted
    centring. The residual is orthogonal to both, so the right-hand side needs no projection.
    """
    value, slope, weights, gains = windows.value, windows.slope, windows.weights, windows.gains
    side = 2 * HALF_WIDTH + 1
    for k in range(9):
        normal[k] = 0.0
    per_energy = f4(1) / energy
    for i in range(used + 1):
        common = i == used
        sign = -1.0 if common else 1.0
        gain = f4(0) if common else f4(gains[i])
        c0 = c1 = c2 = f4(0)
        t0 = t1 = t2 = f4(0)
        r0 = r1 = r2 = f4(0)
        m00 = m01 = m02 = m11 = m12 = m22 = f4(0)
        for k in range(SAMPLES):
            u, v = f4((k % side - HALF_WIDTH) * step), f4((k // side - HALF_WIDTH) * step)
            change = texture_slope[k] if common else slope[i, k]
            residual = f4(0) if common else value[i, k] - gain * texture[k]
            w0 = weights[k] * change
            w1, w2 = w0 * u, w0 * v
            c0 += w0
            c1 += w1
            c2 += w2
            t0 += w0 * texture[k]
            t1 += w1 * texture[k]
            t2 += w2 * texture[k]
            r0 += w0 * residual
            r1 += w1 * residual
            r2 += w2 * residual
            m00 += w0 * change
            m01 += w1 * change
            m02 += w2 * change
            m11 += w1 * change * u
            m12 += w1 * change * v
            m22 += w2 * change * v
        normal[0] += sign * (m00 - c0 * c0 - t0 * t0 * per_energy)
        normal[1] += sign * (m01 - c0 * c1 - t0 * t1 * per_energy)
        normal[2] += sign * (m02 - c0 * c2 - t0 * t2 * per_energy)
        normal[3] += sign * (m11 - c1 * c1 - t1 * t1 * per_energy)
        normal[4] += sign * (m12 - c1 * c2 - t1 * t2 * per_energy)
        normal[5] += sign * (m22 - c2 * c2 - t2 * t2 * per_energy)
        normal[6] -= r0
        normal[7] -= r1
        normal[8] -= r2


@njit(cache=True, forceinline=True)
def _solve_step(
    normal: np.ndarray, prior: float | np.float32, state: np.ndarray
) -> tuple[float, ...]:
    """Steps of d and the slopes under a weak prior on the slopes, and the cofactor of d."""
    m00, m01, m02 = normal[0], normal[1], normal[2]
    m11, m12, m22 = normal[3] + prior, normal[4], normal[5] + prior
    r0, r1, r2 = normal[6], normal[7] - prior * state[1], normal[8] - prior * state[2]
    q00, q01, q02, q11, q12, q22, determinant = adjugate(m00, m01, m02, m11, m12, m22)
    if not determinant > 1e-12 * m00 * m11 * m22:
        return 0.0, 0.0, 0.0, 0.0
    return (
        (q00 * r0 + q01 * r1 + q02 * r2) / determinant,
        (q01 * r0 + q11 * r1 + q12 * r2) / determinant,
        (q02 * r0 + q12 * r1 + q22 * r2) / determinant,
        q00 / determinant,
    )
