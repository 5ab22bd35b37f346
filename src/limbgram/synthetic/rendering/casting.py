"""Compiled kernels: which surface each sample of a picture shows, and its light.

In a buffer that begins at pixel (left, top), with `fine` samples along a pixel's side, column j
lies at x = left + (j + 0.5) / fine - 0.5: pixel centres are integers. The mesh is rasterised with
a z-buffer of inv_z depths; panels are ray cast.
"""

import numpy as np

from limbgram.core.geometry.lens import ideal_from_pixel
from limbgram.core.kernels import njit
from limbgram.synthetic.rendering.shading import (
    Light,
    Panels,
    Triangles,
    depth_on,
    mesh_light,
    panel_light,
    printed,
    within,
)

_UNDISTORT_STEPS = 30
_TOLERANCE = 1e-11


@njit(cache=True, nogil=True, error_model="numpy")
def rasterise(
    inverse_depth: np.ndarray,
    face: np.ndarray,
    left: int,
    top: int,
    fine: int,
    screen: np.ndarray,
    points: np.ndarray,
    faces: np.ndarray,
):
    """Draw front faces: fill inverse depth and index of the nearest face at each sample."""
    for k in range(len(faces)):
        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
        ax = (screen[a, 0] - left + 0.5) * fine - 0.5
        ay = (screen[a, 1] - top + 0.5) * fine - 0.5
        bx = (screen[b, 0] - left + 0.5) * fine - 0.5
        by = (screen[b, 1] - top + 0.5) * fine - 0.5
        cx = (screen[c, 0] - left + 0.5) * fine - 0.5
        cy = (screen[c, 1] - top + 0.5) * fine - 0.5
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not area < 0:
            continue
        x0 = max(0, int(np.ceil(min(ax, bx, cx) - 1e-9)))
        x1 = min(face.shape[1] - 1, int(np.floor(max(ax, bx, cx) + 1e-9)))
        y0 = max(0, int(np.ceil(min(ay, by, cy) - 1e-9)))
        y1 = min(face.shape[0] - 1, int(np.floor(max(ay, by, cy) + 1e-9)))
        za, zb, zc = 1 / points[a, 2], 1 / points[b, 2], 1 / points[c, 2]
        for y in range(y0, y1 + 1):
            for x in range(x0, x1 + 1):
                wa = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                wb = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                wc = 1 - wa - wb
                if wa < -1e-9 or wb < -1e-9 or wc < -1e-9:
                    continue
                inv_z = np.float32(wa * za + wb * zb + wc * zc)
                if inv_z > inverse_depth[y, x]:
                    inverse_depth[y, x] = inv_z
                    face[y, x] = k


@njit(cache=True, nogil=True, error_model="numpy")
def shade(
    picture: np.ndarray,
    top: int,
    fine: int,
    left: int,
    inverse_depth: np.ndarray,
    face: np.ndarray,
    lens: np.ndarray,
    panels: Panels,
    triangles: Triangles,
    light: Light,
):
    """Fill the rows of `picture`, which begins at pixel row `top`; buffers begin at `left`."""
    rows, columns = picture.shape[0], picture.shape[1]
    hit = np.empty((rows + 2, columns + 2), np.int32)
    ideal = np.empty((rows + 2, columns + 2, 2))
    for y in range(rows + 2):
        for x in range(columns + 2):
            ix, iy = ideal_from_pixel(x - 1.0, top + y - 1.0, lens, _UNDISTORT_STEPS, _TOLERANCE)
            ideal[y, x, 0], ideal[y, x, 1] = ix, iy
            hit[y, x] = _first_panel(ix, iy, panels)
    for y in range(rows):
        for x in range(columns):
            uniform = _is_uniform(hit, x, y)
            if uniform and not _shows_mesh(face, x - left, y, fine):
                ix, iy = ideal[y + 1, x + 1, 0], ideal[y + 1, x + 1, 1]
                red, green, blue = panel_light(ix, iy, hit[y + 1, x + 1] // 2, panels, light)
                picture[y, x, 0], picture[y, x, 1], picture[y, x, 2] = red, green, blue
                continue
            for i in range(fine * fine):
                px = x + (i % fine + 0.5) / fine - 0.5
                py = top + y + (i // fine + 0.5) / fine - 0.5
                row, column = y * fine + i // fine, (x - left) * fine + i % fine
                k = face[row, column] if 0 <= column < face.shape[1] else -1
                inv_z = inverse_depth[row, column] if k >= 0 else np.float32(0)
                ix, iy = ideal[y + 1, x + 1, 0], ideal[y + 1, x + 1, 1]
                behind = hit[y + 1, x + 1] // 2
                if not uniform or k < 0:
                    ix, iy = ideal_from_pixel(px, py, lens, _UNDISTORT_STEPS, _TOLERANCE)
                    behind = _first_panel(ix, iy, panels) // 2
                if k >= 0 and (behind < 0 or inv_z * depth_on(ix, iy, panels.rows, behind) > 1.0):
                    red, green, blue = mesh_light(px, py, k, triangles, light)
                else:
                    red, green, blue = panel_light(ix, iy, behind, panels, light)
                picture[y, x, 0] += red / (fine * fine)
                picture[y, x, 1] += green / (fine * fine)
                picture[y, x, 2] += blue / (fine * fine)


@njit(cache=True, nogil=True, error_model="numpy")
def _first_panel(x: float, y: float, panels: Panels):
    """Twice the index of the first panel on the ray, plus 1 on white print; -2 for none."""
    best, found, white = np.inf, -1, 0
    rows, bounds = panels.rows, panels.bounds
    for k in range(len(rows)):
        if x < bounds[k, 0] or y < bounds[k, 1] or x > bounds[k, 2] or y > bounds[k, 3]:
            continue
        depth = depth_on(x, y, rows, k)
        if depth <= 0 or depth >= best:
            continue
        right, down = within(x, y, depth, rows, k)
        if 0 <= right <= rows[k, 12] and 0 <= down <= rows[k, 13]:
            best, found, white = depth, k, 0
            if panels.kinds[k, 1] == 0 and printed(right, down, k, panels) > 0.5:
                white = 1
    return 2 * found + white


@njit(cache=True, nogil=True, error_model="numpy")
def _is_uniform(hit: np.ndarray, x: int, y: int):
    """Whether one sample suffices: the pixel and its eight neighbours hit the same."""
    for i in range(3):
        for j in range(3):
            if hit[y + i, x + j] != hit[y + 1, x + 1]:
                return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _shows_mesh(face: np.ndarray, x: int, y: int, fine: int):
    """Whether any sample of the buffer's pixel (x, y) shows the mesh."""
    if x < 0 or (x + 1) * fine > face.shape[1]:
        return False
    for i in range(fine):
        for j in range(fine):
            if face[y * fine + i, x * fine + j] >= 0:
                return True
    return False
