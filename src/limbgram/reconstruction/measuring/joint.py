"""Joint matching: normal equations of all vertices' offsets along their normals (compiled).

Samples lie about a pixel apart on the faces; every photo that sees all three corners of a face
shows the sample's grey value times its own local gain plus its own local mean. The grey value is
eliminated per sample, so that no photo is the reference and no photo's noise is shared by all.
Gains, means, and the change of the means as the surface moves come from a wider window round each
vertex. Vu, Labatut, Pons and Keriven 2012 refine a mesh with all its photos similarly, by pairs.
"""

import math
from typing import NamedTuple

import numpy as np

from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import in_parallel
from limbgram.reconstruction.measuring.imagery import Imagery
from limbgram.reconstruction.measuring.sampling import (
    MARGIN_PX,
    SAMPLES,
    Patches,
    drop_inconsistent_photos,
    empty_windows,
    fill_gram,
    interpolate,
    leading_gains,
    project,
    sample_windows,
)

f4 = np.float32

_BLOCK = 2048
"""Vertices, or faces, per block of a thread."""
_GAIN_PRIOR = 25.0
"""Grey variance that regularises gains towards the ratio of the means, for windows of low
texture."""
_MIN_CURVATURE = 0.1
"""Lower limit: a robust cost may have negative curvature where residuals are large."""


GAIN, MEAN, MEAN_PER_MM, LIFT = range(4)
"""Photometric parameters of a photo at a vertex: gain of its grey values (0: not used), mean,
change of the mean per millimetre that the surface moves, and displacement by blur, mm."""


class NoiseModel(NamedTuple):
    """Noise of grey values, and the robust limit of residuals."""

    noise_grey: float
    """Sensor noise, grey levels."""
    noise_px: float
    """Unmodelled errors, as a shift in pixels."""
    robust: float
    """Residuals beyond this many sigmas are down-weighted."""


class FaceEquations(NamedTuple):
    """Normal equations of the three offsets of each of f faces."""

    matrix: np.ndarray
    """(f, 6): upper triangle 00 01 02 11 12 22."""
    right: np.ndarray
    """(f, 3): right-hand side."""
    right_by_photo: np.ndarray
    """(f, c): share of each photo that sees a face's first vertex in the sum of the right-hand
    side."""
    curvature: np.ndarray
    """(f,): curvature of the robust cost over that of the weighted matrix: it is lower where
    residuals exceed `NoiseModel.robust`."""

    def rows(self, chosen: slice) -> "FaceEquations":
        """Those of some faces, as views."""
        return FaceEquations(*(one[chosen] for one in self))


class _Surface(NamedTuple):
    """Vertices with their unit normals, and faces with their barycentric sample points."""

    vertices: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    points: np.ndarray


def local_gains(
    imagery: Imagery,
    seen_by: np.ndarray,
    patches: Patches,
    noise_grey: float,
    photometry: np.ndarray,
) -> None:
    """Fill GAIN (mean square 1 over the photos used), MEAN and MEAN_PER_MM of `photometry`.

    photometry (n, c, 4), zeros; photos as in seen_by (n, c)
    """

    def block(first: int) -> None:
        rows = slice(first, first + _BLOCK)
        _gains_block(imagery, seen_by[rows], patches.rows(rows), noise_grey, photometry[rows])

    in_parallel(block, range(0, len(seen_by), _BLOCK))


@njit(fastmath=True, cache=True, nogil=True)
def _gains_block(
    imagery: Imagery,
    seen_by: np.ndarray,
    patches: Patches,
    noise_grey: float,
    photometry: np.ndarray,
):
    """Fill `photometry` of the patches' vertices."""
    windows = empty_windows(seen_by.shape[1])
    mean, gram = windows.mean, windows.gram
    zero_state, noise = np.zeros(3), noise_grey * noise_grey
    for p in range(len(seen_by)):
        used, _ = sample_windows(imagery, seen_by[p], patches, p, zero_state, 0.0, windows)
        if used < 2:
            continue
        fill_gram(windows, used)
        used = drop_inconsistent_photos(windows, used, noise)
        if used == 0:
            continue
        prior = _GAIN_PRIOR / (mean[0] * mean[0] + 1.0)
        for i in range(used):
            for j in range(used):
                gram[i, j] += prior * mean[i] * mean[j]
        if not leading_gains(windows, used):
            continue
        for i in range(used):
            slot = 0
            while seen_by[p, slot] != windows.photo_of[i]:
                slot += 1
            photometry[p, slot, GAIN] = windows.gains[i] * math.sqrt(used)
            photometry[p, slot, MEAN] = mean[i]
            change = f4(0)
            for k in range(SAMPLES):
                change += windows.weights[k] * windows.slope[i, k]
            photometry[p, slot, MEAN_PER_MM] = change


@njit(cache=True, forceinline=True)
def _common_photos(
    seen_by: np.ndarray, photometry: np.ndarray, i0: int, i1: int, i2: int, slots: np.ndarray
):
    """Fill `slots` (c, 3) of the photos used at all three vertices; returns their number."""
    found = 0
    for s0 in range(seen_by.shape[1]):
        photo = seen_by[i0, s0]
        if photo < 0:
            break
        if photometry[i0, s0, GAIN] <= 0:
            continue
        for s1 in range(seen_by.shape[1]):
            if seen_by[i1, s1] == photo and photometry[i1, s1, GAIN] > 0:
                for s2 in range(seen_by.shape[1]):
                    if seen_by[i2, s2] == photo and photometry[i2, s2, GAIN] > 0:
                        slots[found, 0], slots[found, 1], slots[found, 2] = s0, s1, s2
                        found += 1
    return found


def assemble(
    imagery: Imagery,
    seen_by: np.ndarray,
    photometry: np.ndarray,
    mesh: Mesh,
    normals: np.ndarray,
    points: np.ndarray,
    noise_model: NoiseModel,
) -> FaceEquations:
    """Normal equations of the three offsets of every face.

    photometry  (n, c, 4) GAIN, MEAN, MEAN_PER_MM and LIFT of the photos in seen_by (n, c)
    points      (s, 3) barycentric sample points of a face
    """
    count = len(mesh.faces)
    equations = FaceEquations(
        np.zeros((count, 6)),
        np.zeros((count, 3)),
        np.zeros((count, seen_by.shape[1]), np.float32),
        np.ones(count),
    )

    def block(first: int) -> None:
        rows = slice(first, first + _BLOCK)
        surface = _Surface(mesh.vertices_mm, normals, mesh.faces[rows], points)
        _assemble_block(imagery, seen_by, photometry, surface, noise_model, equations.rows(rows))

    in_parallel(block, range(0, count, _BLOCK))
    return equations


@njit(fastmath=True, cache=True, nogil=True)
def _assemble_block(
    imagery: Imagery,
    seen_by: np.ndarray,
    photometry: np.ndarray,
    surface: _Surface,
    noise_model: NoiseModel,
    equations: FaceEquations,
):
    """Fill the normal equations of the surface's faces."""
    coefficients, crops, factor, views = imagery
    vertices, normals, faces, points = surface
    noise_grey, noise_px, robust = noise_model
    matrix, right, right_by_photo, curvature = equations
    most = seen_by.shape[1]
    shift = 0.5 * factor - 0.5
    slots = np.empty((most, 3), np.int64)
    slot_of = np.empty(most, np.int64)
    grey = np.empty(most, np.float32)
    change = np.empty(most, np.float32)
    scale = np.empty(most, np.float32)
    for f in range(len(faces)):
        i0, i1, i2 = faces[f, 0], faces[f, 1], faces[f, 2]
        weight_sum = curvature_sum = 0.0
        common = _common_photos(seen_by, photometry, i0, i1, i2, slots)
        for s in range(len(points)):
            a, b, c = points[s, 0], points[s, 1], points[s, 2]
            x = a * vertices[i0, 0] + b * vertices[i1, 0] + c * vertices[i2, 0]
            y = a * vertices[i0, 1] + b * vertices[i1, 1] + c * vertices[i2, 1]
            z = a * vertices[i0, 2] + b * vertices[i1, 2] + c * vertices[i2, 2]
            n0 = a * normals[i0, 0] + b * normals[i1, 0] + c * normals[i2, 0]
            n1 = a * normals[i0, 1] + b * normals[i1, 1] + c * normals[i2, 1]
            n2 = a * normals[i0, 2] + b * normals[i1, 2] + c * normals[i2, 2]
            used = 0
            sum_aa = sum_ag = sum_ah = gradient2 = f4(0)
            for j in range(common):
                at0, at1 = photometry[i0, slots[j, 0]], photometry[i1, slots[j, 1]]
                at2 = photometry[i2, slots[j, 2]]
                k = seen_by[i0, slots[j, 0]]
                u, v, _, ux, uy, uz, vx, vy, vz = project(views[k], x, y, z)
                nx, ny = ux * n0 + uy * n1 + uz * n2, vx * n0 + vy * n1 + vz * n2
                lift = a * at0[LIFT] + b * at1[LIFT] + c * at2[LIFT]
                u = (u + lift * nx) * factor + shift - crops[k, 1]
                v = (v + lift * ny) * factor + shift - crops[k, 2]
                if not (
                    u > MARGIN_PX
                    and v > MARGIN_PX
                    and u < crops[k, 3] - 1 - MARGIN_PX
                    and v < crops[k, 4] - 1 - MARGIN_PX
                ):
                    continue
                intensity, along_x, along_y = interpolate(
                    coefficients, crops[k, 0], crops[k, 3], u, v
                )
                scale[used] = a * at0[GAIN] + b * at1[GAIN] + c * at2[GAIN]
                grey[used] = intensity - (a * at0[MEAN] + b * at1[MEAN] + c * at2[MEAN])
                change[used] = factor * (along_x * nx + along_y * ny) - (
                    a * at0[MEAN_PER_MM] + b * at1[MEAN_PER_MM] + c * at2[MEAN_PER_MM]
                )
                sum_aa += scale[used] * scale[used]
                sum_ag += scale[used] * grey[used]
                sum_ah += scale[used] * change[used]
                gradient2 += along_x * along_x + along_y * along_y
                slot_of[used] = slots[j, 0]
                used += 1
            if used < 2:
                continue
            texture, texture_change = sum_ag / sum_aa, sum_ah / sum_aa
            hh = hr = rr = f4(0)
            for k in range(used):
                residual = grey[k] - scale[k] * texture
                slope = change[k] - scale[k] * texture_change
                hh += slope * slope
                hr -= residual * slope
                rr += residual * residual
            variance = noise_grey * noise_grey + noise_px * noise_px * gradient2 / used
            chi2 = rr / variance
            limit = (used - 1) * robust * robust
            weight = 1 / (variance * (1 + chi2 / limit))
            for k in range(used):
                residual = grey[k] - scale[k] * texture
                slope = change[k] - scale[k] * texture_change
                right_by_photo[f, slot_of[k]] -= weight * residual * slope
            weight_sum += weight * hh
            curvature_sum += weight * hh - 2 * weight * weight * hr * hr / limit
            hh *= weight
            hr *= weight
            matrix[f, 0] += a * a * hh
            matrix[f, 1] += a * b * hh
            matrix[f, 2] += a * c * hh
            matrix[f, 3] += b * b * hh
            matrix[f, 4] += b * c * hh
            matrix[f, 5] += c * c * hh
            right[f, 0] += a * hr
            right[f, 1] += b * hr
            right[f, 2] += c * hr
        if weight_sum > 0:
            curvature[f] = min(max(curvature_sum / weight_sum, _MIN_CURVATURE), 1.0)
