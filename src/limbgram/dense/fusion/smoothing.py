"""Moving least squares: points go to the curved surface that their neighbours agree on (compiled).

Round each point a quadric, height over the tangent plane = c0 + c1 u + c2 v + c3 u^2/2 + c4 u v
+ c5 v^2/2, is fitted to the measured points with weights that fall with distance and with
residual; the point moves by c0 along the normal, the normal turns by the slopes (Levin 1998;
Guennebaud and Gross 2007). The quadratic terms keep a curved surface from shrinking, and tell by
how much flat correlation windows placed it too deep.
"""

import math

import numpy as np
from numba import njit

from limbgram.dense.fusion.grid import span_of

_UNKNOWNS = 6
_LEAST_NEIGHBOURS = 8
_BEND_PRIOR = 0.001
"""Weight of the wish for a plane, as a fraction of the neighbours' weight: it decides only where
the neighbours lie on a line or to one side."""
_ROUNDS = 3
_FACING = 0.5
"""Neighbours whose normals turn away by more than 60 degrees belong to another side."""


@njit(cache=True, nogil=True, error_model="numpy")
def project_to_surface(
    points, normals, weights, windows, low, cell, keys, spans, radius, noise, seeds, moved, turned
):
    """Move seeds[k] to the surface of their neighbours, into moved[k] and turned[k].

    points, normals, weights   all measured points, in the grid's order (cell >= radius)
    windows   (n,) mean squared reach of the correlation windows on the surface, mm^2
    noise     residuals of this size lose half of their weight, mm
    Returns for each seed its neighbours' total weight, 0 where there are too few for a surface.
    """
    support = np.zeros(len(seeds), np.float32)
    system = np.empty((_UNKNOWNS, _UNKNOWNS + 1))
    axes = np.empty((3, 3))
    coefficients = np.zeros(_UNKNOWNS)
    for s in range(len(seeds)):
        p = seeds[s]
        x, y, z = float(points[p, 0]), float(points[p, 1]), float(points[p, 2])
        axes[2, 0], axes[2, 1], axes[2, 2] = normals[p, 0], normals[p, 1], normals[p, 2]
        sunk = 0.0
        solved = False
        for _ in range(_ROUNDS):
            _tangents(axes)
            coefficients[:] = 0.0
            total, count, sunk_window = _gather(
                points, normals, weights, windows, low, cell, keys, spans, radius, noise,
                x, y, z, axes, system,
            )  # fmt: skip
            solved = count >= _LEAST_NEIGHBOURS and _solve(system, total, radius, coefficients)
            if not solved or abs(coefficients[0]) > radius:
                solved = False
                break
            support[s] = total
            step, along_u, along_v = coefficients[0], coefficients[1], coefficients[2]
            x += step * axes[2, 0]
            y += step * axes[2, 1]
            z += step * axes[2, 2]
            length = math.sqrt(1 + along_u**2 + along_v**2)
            for i in range(3):
                axes[2, i] = (axes[2, i] - along_u * axes[0, i] - along_v * axes[1, i]) / length
            sunk = -0.5 * (coefficients[3] + coefficients[5]) * sunk_window
        if not solved:
            support[s] = 0.0
            continue
        moved[s, 0] = x + sunk * axes[2, 0]
        moved[s, 1] = y + sunk * axes[2, 1]
        moved[s, 2] = z + sunk * axes[2, 2]
        turned[s, 0], turned[s, 1], turned[s, 2] = axes[2, 0], axes[2, 1], axes[2, 2]
    return support


@njit(cache=True, error_model="numpy")
def _tangents(axes):
    """Two unit vectors across axes[2], which is made unit too."""
    n = axes[2]
    n /= math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if abs(n[0]) > 0.7:
        axes[0, 0], axes[0, 1], axes[0, 2] = -n[2], 0.0, n[0]
    else:
        axes[0, 0], axes[0, 1], axes[0, 2] = 0.0, n[2], -n[1]
    t = axes[0]
    t /= math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    axes[1, 0] = n[1] * t[2] - n[2] * t[1]
    axes[1, 1] = n[2] * t[0] - n[0] * t[2]
    axes[1, 2] = n[0] * t[1] - n[1] * t[0]


@njit(cache=True, error_model="numpy")
def _gather(
    points, normals, weights, windows, low, cell, keys, spans, radius, noise,
    x, y, z, axes, system,
):  # fmt: skip
    """Normal equations (upper triangle and right side) of the neighbours of (x, y, z).

    Returns their weight, their number, and their mean window.
    """
    system[:] = 0.0
    row = np.empty(_UNKNOWNS)
    total, window, count = 0.0, 0.0, 0
    i, j, k = int((x - low[0]) / cell), int((y - low[1]) / cell), int((z - low[2]) / cell)
    for neighbour in range(27):
        first, last = span_of(
            keys, spans, i + neighbour // 9 - 1, j + neighbour // 3 % 3 - 1, k + neighbour % 3 - 1
        )
        for q in range(first, last):
            dx, dy, dz = points[q, 0] - x, points[q, 1] - y, points[q, 2] - z
            near = 1 - (dx * dx + dy * dy + dz * dz) / (radius * radius)
            if near <= 0:
                continue
            alike = (
                normals[q, 0] * axes[2, 0] + normals[q, 1] * axes[2, 1] + normals[q, 2] * axes[2, 2]
            )
            if alike < _FACING:
                continue
            u = dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2]
            v = dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2]
            h = dx * axes[2, 0] + dy * axes[2, 1] + dz * axes[2, 2]
            off = h / (noise + 0.15 * (abs(u) + abs(v)))
            weight = weights[q] * near * near * alike / (1 + off * off)
            row[0], row[1], row[2] = 1.0, u, v
            row[3], row[4], row[5] = 0.5 * u * u, u * v, 0.5 * v * v
            for a in range(_UNKNOWNS):
                scaled = weight * row[a]
                for b in range(a, _UNKNOWNS):
                    system[a, b] += scaled * row[b]
                system[a, _UNKNOWNS] += scaled * h
            total += weight
            window += weight * windows[q]
            count += 1
    return total, count, window / max(total, 1e-30)


@njit(cache=True, error_model="numpy")
def _solve(system, total, radius, coefficients):
    """Solve the normal equations in place (Cholesky); False where they have no answer."""
    for a in range(1, _UNKNOWNS):
        reach = radius if a < 3 else 0.5 * radius * radius
        system[a, a] += _BEND_PRIOR * total * reach * reach * (0.01 if a < 3 else 1.0)
    for a in range(_UNKNOWNS):
        for c in range(a):
            system[a, a] -= system[c, a] * system[c, a]
        if not system[a, a] > 1e-12 * total:
            return False
        system[a, a] = math.sqrt(system[a, a])
        for b in range(a + 1, _UNKNOWNS + 1):
            for c in range(a):
                system[a, b] -= system[c, a] * system[c, b]
            system[a, b] /= system[a, a]
    for a in range(_UNKNOWNS - 1, -1, -1):
        value = system[a, _UNKNOWNS]
        for b in range(a + 1, _UNKNOWNS):
            value -= system[a, b] * coefficients[b]
        coefficients[a] = value / system[a, a]
    return True
