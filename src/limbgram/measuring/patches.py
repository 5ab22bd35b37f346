"""Multi-photo least-squares matching of one small surface patch per vertex (compiled).

Unknown per patch: offset d along the normal and two slopes. Every photo that sees the patch
shows the same unknown texture with its own gain and mean; texture, gains and means are
eliminated (the texture is the leading left singular vector of the photos' windows, derivative
after Kaufman 1975), so that no photo is the reference. The patch is curved by a given quadric:
without it the surface sinks.
Gruen and Baltsavias 1988 (geometrically constrained matching); Furukawa and Ponce 2010.
"""

import math

import numpy as np
from numba import njit, prange

from limbgram.measuring.sampling import MARGIN_PX, interpolate, project

f4 = np.float32

HALF = 4
SAMPLES = (2 * HALF + 1) ** 2
"""Samples of a patch: 9 x 9, one step apart."""

_LEAST_VARIANCE = 4.0
"""Windows of less grey variance carry no texture."""
_MAX_SLOPE = 1.2
_SLOPE_PRIOR = 0.3
_GAIN_STEPS = 12

MEASURED, UNSEEN, UNLIKE, SINGULAR, STRAYED, STEEP = 1, 0, -1, -2, -3, -4
"""Outcome of a patch; every value but MEASURED is a failure."""


@njit(parallel=True, fastmath=True, cache=True, nogil=True)
def measure_patches(
    coefficients, crops, factor, views, seen_by, vertices, axes, quadric, step_mm, rounds, state
):
    """Measure every patch.

    seen_by   (n, c) int32, photos of each patch, -1 = none
    axes      (n, 3, 3): two tangents and the normal, rows
    quadric   (n, 3): height = (q0 u^2 + 2 q1 u v + q2 v^2) / 2, 1/mm
    step_mm   (n,) sample distance
    state     (n, 3) start values, mm and slopes; changed in place
    Returns (n, 5) float32: outcome, formal sigma of d (mm), noise (grey levels), mean
    correlation, photos used.
    """
    count, most = seen_by.shape
    report = np.zeros((count, 5), np.float32)
    blocks = (count + 63) // 64
    for block in prange(blocks):
        value = np.empty((most, SAMPLES), np.float32)
        slope = np.empty((most, SAMPLES), np.float32)
        texture = np.empty(SAMPLES, np.float32)
        texture_slope = np.empty(SAMPLES, np.float32)
        weights = window_weights()
        effective = f4(0)
        for k in range(SAMPLES):
            effective += weights[k] * weights[k]
        effective = f4(1) / effective
        gains = np.empty(most)
        gram = np.empty((most, most))
        scratch = np.empty(most)
        mean = np.empty(most)
        photo_of = np.empty(most, np.int64)
        normal = np.empty(9)
        for p in range(block * 64, min(count, block * 64 + 64)):
            for turn in range(rounds + 1):
                used, per_mm = sample_windows(
                    coefficients, crops, factor, views, seen_by[p], vertices[p], axes[p],
                    quadric[p], step_mm[p], state[p], weights, value, slope, mean, photo_of,
                    _LEAST_VARIANCE,
                )  # fmt: skip
                if used < 2:
                    report[p, 0] = UNSEEN
                    break
                gram_of(value, weights, used, gram)
                if not leading_gains(gram, used, gains, scratch):
                    report[p, 0] = UNLIKE
                    break
                total = 0.0
                for i in range(used):
                    total += gram[i, i]
                energy = _mean_texture(value, slope, weights, gains, used, texture, texture_slope)
                _normal_equations(
                    value, slope, weights, gains, used, texture, texture_slope, energy,
                    step_mm[p], normal,
                )  # fmt: skip
                freedom = (used - 1) * (effective - 2) - 3
                noise2 = max((total - energy) * effective / max(freedom, 1.0), 0.0)
                prior = max(noise2, 0.5) / (effective * _SLOPE_PRIOR**2)
                step_d, step_a, step_b, cofactor = _solve(normal, prior, state[p])
                if not cofactor > 0:
                    report[p, 0] = SINGULAR
                    break
                report[p, 1] = math.sqrt(noise2 / effective * cofactor)
                report[p, 2] = math.sqrt(noise2)
                report[p, 3] = (energy / total * used - 1) / (used - 1)
                report[p, 4] = used
                report[p, 0] = MEASURED
                if turn == rounds:
                    break
                if not abs(step_d) * per_mm < 6:
                    report[p, 0] = STRAYED
                    break
                damping = 1.0 / max(1.0, abs(step_d) * per_mm / 1.5)
                state[p, 0] += damping * step_d
                state[p, 1] += damping * step_a
                state[p, 2] += damping * step_b
                if abs(state[p, 1]) > _MAX_SLOPE or abs(state[p, 2]) > _MAX_SLOPE:
                    report[p, 0] = STEEP
                    break
                reach = (abs(step_a) + abs(step_b)) * HALF * step_mm[p]
                if abs(step_d) * per_mm < 0.01 and reach * per_mm < 0.03:
                    break
    return report


@njit(cache=True)
def window_weights():
    """Gaussian over the patch, sum 1."""
    weights = np.empty(SAMPLES, np.float32)
    side = 2 * HALF + 1
    for k in range(SAMPLES):
        u, v = k % side - HALF, k // side - HALF
        weights[k] = math.exp(-0.5 * (u * u + v * v) / (0.75 * HALF) ** 2)
    return weights / weights.sum()


@njit(fastmath=True, cache=True)
def sample_windows(
    coefficients, crops, factor, views, seen_by, vertex, axes, quadric, step, state,
    weights, value, slope, mean, photo_of, least_variance,
):  # fmt: skip
    """Windows of all photos (weighted mean taken off) and their change per mm along the normal.

    Returns the number of photos with a whole, textured window, and the mean pixels per mm.
    """
    side = 2 * HALF + 1
    shift = 0.5 * factor - 0.5
    used = 0
    per_mm = 0.0
    x = vertex[0] + state[0] * axes[2, 0]
    y = vertex[1] + state[0] * axes[2, 1]
    z = vertex[2] + state[0] * axes[2, 2]
    for photo in seen_by:
        if photo < 0:
            break
        u, v, depth, ux, uy, uz, vx, vy, vz = project(views[photo], x, y, z)
        if not depth > 0:
            continue
        start, width, height = crops[photo, 0], crops[photo, 3], crops[photo, 4]
        cx, cy = u * factor + shift - crops[photo, 1], v * factor + shift - crops[photo, 2]
        nx = (ux * axes[2, 0] + uy * axes[2, 1] + uz * axes[2, 2]) * factor
        ny = (vx * axes[2, 0] + vy * axes[2, 1] + vz * axes[2, 2]) * factor
        ax = ((ux * axes[0, 0] + uy * axes[0, 1] + uz * axes[0, 2]) * factor + state[1] * nx) * step
        ay = ((vx * axes[0, 0] + vy * axes[0, 1] + vz * axes[0, 2]) * factor + state[1] * ny) * step
        bx = ((ux * axes[1, 0] + uy * axes[1, 1] + uz * axes[1, 2]) * factor + state[2] * nx) * step
        by = ((vx * axes[1, 0] + vy * axes[1, 1] + vz * axes[1, 2]) * factor + state[2] * ny) * step
        bend = 0.5 * step * step
        highest = bend * HALF * HALF * (abs(quadric[0]) + 2 * abs(quadric[1]) + abs(quadric[2]))
        reach_x = HALF * (abs(ax) + abs(bx)) + highest * abs(nx) + MARGIN_PX
        reach_y = HALF * (abs(ay) + abs(by)) + highest * abs(ny) + MARGIN_PX
        if not (
            cx > reach_x and cy > reach_y and cx + reach_x < width - 1 and cy + reach_y < height - 1
        ):
            continue
        level = f4(0)
        for k in range(SAMPLES):
            i, j = k % side - HALF, k // side - HALF
            lift = bend * (quadric[0] * i * i + 2 * quadric[1] * i * j + quadric[2] * j * j)
            grey, along_x, along_y = interpolate(
                coefficients, start, width,
                cx + ax * i + bx * j + nx * lift, cy + ay * i + by * j + ny * lift,
            )  # fmt: skip
            value[used, k] = grey
            slope[used, k] = along_x * f4(nx) + along_y * f4(ny)
            level += weights[k] * grey
        variance = f4(0)
        for k in range(SAMPLES):
            value[used, k] -= level
            variance += weights[k] * value[used, k] * value[used, k]
        if variance < least_variance:
            continue
        mean[used] = level
        photo_of[used] = photo
        used += 1
        per_mm += math.sqrt(nx * nx + ny * ny)
    return used, per_mm / max(used, 1)


@njit(fastmath=True, cache=True)
def gram_of(value, weights, used, gram):
    """Weighted products of the windows with each other."""
    for i in range(used):
        for j in range(i + 1):
            product = f4(0)
            for k in range(SAMPLES):
                product += weights[k] * value[i, k] * value[j, k]
            gram[i, j] = product
            gram[j, i] = product


@njit(fastmath=True, cache=True)
def leading_gains(gram, used, gains, scratch):
    """Leading unit eigenvector of the Gram matrix; False if a photo shows something else."""
    for i in range(used):
        gains[i] = math.sqrt(gram[i, i])
    for _ in range(_GAIN_STEPS):
        length = 0.0
        for i in range(used):
            row = 0.0
            for j in range(used):
                row += gram[i, j] * gains[j]
            scratch[i] = row
            length += row * row
        length = 1.0 / math.sqrt(length)
        for i in range(used):
            gains[i] = scratch[i] * length
    alike = True
    for i in range(used):
        alike = alike and gains[i] > 0.02
    return alike


@njit(fastmath=True, cache=True)
def _mean_texture(value, slope, weights, gains, used, texture, texture_slope):
    """The common texture and its change with d; returns the texture's weighted energy."""
    energy = f4(0)
    for k in range(SAMPLES):
        grey, change = f4(0), f4(0)
        for i in range(used):
            grey += f4(gains[i]) * value[i, k]
            change += f4(gains[i]) * slope[i, k]
        texture[k], texture_slope[k] = grey, change
        energy += weights[k] * grey * grey
    return energy


@njit(fastmath=True, cache=True)
def _normal_equations(
    value, slope, weights, gains, used, texture, texture_slope, energy, step, normal
):
    """Upper triangle (6) and right side (3) for d and the slopes.

    With windows G = gains texture^T, H_j their change by parameter j, a and t the unit gains and
    texture: texture and gains are eliminated by (I - a a^T) H_j (I - t t^T), means by weighted
    centring. The residual is orthogonal to both, so the right side needs no projection.
    """
    side = 2 * HALF + 1
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
            u, v = f4((k % side - HALF) * step), f4((k // side - HALF) * step)
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


@njit(cache=True)
def _solve(normal, prior, state):
    """Steps of d and the slopes, and the cofactor of d; slopes are held by a weak prior."""
    m00, m01, m02 = normal[0], normal[1], normal[2]
    m11, m12, m22 = normal[3] + prior, normal[4], normal[5] + prior
    r0, r1, r2 = normal[6], normal[7] - prior * state[1], normal[8] - prior * state[2]
    q00, q01, q02 = m11 * m22 - m12 * m12, m02 * m12 - m01 * m22, m01 * m12 - m02 * m11
    determinant = m00 * q00 + m01 * q01 + m02 * q02
    if not determinant > 1e-12 * m00 * m11 * m22:
        return 0.0, 0.0, 0.0, 0.0
    q11, q12, q22 = m00 * m22 - m02 * m02, m01 * m02 - m00 * m12, m00 * m11 - m01 * m01
    return (
        (q00 * r0 + q01 * r1 + q02 * r2) / determinant,
        (q01 * r0 + q11 * r1 + q12 * r2) / determinant,
        (q02 * r0 + q12 * r1 + q22 * r2) / determinant,
        q00 / determinant,
    )
