"""Compiled loops of the renderer. Everything is in the camera frame; rays are (x, y, 1).

Sample (i, j) of a buffer that begins at pixel (left, top) and has `fine` samples a pixel side
lies at pixel x = left + (j + 0.5) / fine - 0.5: pixel centres are whole numbers.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

_UNDISTORT_STEPS = 30
_TOLERANCE = 1e-11
_SHINE = 24.0


class Panels(NamedTuple):
    """Rectangles: rows of origin, unit right, unit down, normal out of the front, width, height."""

    rows: np.ndarray
    bounds: np.ndarray
    """x0, y0, x1, y1 of each on the ideal plane."""
    kinds: np.ndarray
    """First texel, texture height and width; height 0 for a printed board."""
    texels: np.ndarray
    cells: np.ndarray
    """Print of the board, 1 white, by square and by cell of its marker."""
    square_mm: float
    marker_mm: float
    margin_mm: float


class Triangles(NamedTuple):
    """The mesh as this camera sees it."""

    screen: np.ndarray
    """Distorted pixels of every vertex."""
    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    painted: int
    """Faces before this one are the limb's, the others the stand's."""
    chart: np.ndarray
    skin: np.ndarray
    skin_fine: int


class Light(NamedTuple):
    """Lamps, relative to a white page that faces the flash at its reference distance."""

    up: np.ndarray
    lamp: np.ndarray
    flash: np.ndarray
    ambient: float
    lamp_strength: float
    flash_strength: float
    flash_mm: float
    linear: np.ndarray
    """Linear light of the 256 sRGB values."""


@njit(cache=True, nogil=True, error_model="numpy")
def rasterise(nearness, face, left, top, fine, screen, points, faces):
    """Draw front faces: 1 / depth and face number of the nearest one, by sample."""
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
                near = np.float32(wa * za + wb * zb + wc * zc)
                if near > nearness[y, x]:
                    nearness[y, x] = near
                    face[y, x] = k


@njit(cache=True, nogil=True, error_model="numpy")
def shade(picture, top, fine, left, nearness, face, lens, panels, triangles, light):
    """Fill the rows of `picture`, which begins at pixel row `top`; buffers begin at `left`."""
    rows, columns = picture.shape[0], picture.shape[1]
    hit = np.empty((rows + 2, columns + 2), np.int32)
    for y in range(rows + 2):
        for x in range(columns + 2):
            ix, iy = _ideal(x - 1.0, top + y - 1.0, lens)
            hit[y, x] = _nearest(ix, iy, panels)
    for y in range(rows):
        for x in range(columns):
            k = hit[y + 1, x + 1]
            if _is_plain(hit, x, y, k, panels) and not _is_drawn(face, x - left, y, fine):
                ix, iy = _ideal(float(x), float(top + y), lens)
                red, green, blue = _panel_light(ix, iy, k, panels, light)
                picture[y, x, 0], picture[y, x, 1], picture[y, x, 2] = red, green, blue
                continue
            for i in range(fine * fine):
                px = x + (i % fine + 0.5) / fine - 0.5
                py = y + (i // fine + 0.5) / fine - 0.5
                ix, iy = _ideal(px, top + py, lens)
                k = _nearest(ix, iy, panels)
                row, column = y * fine + i // fine, (x - left) * fine + i % fine
                drawn = 0 <= column < face.shape[1] and face[row, column] >= 0
                if drawn and k >= 0:
                    drawn = nearness[row, column] * _depth(ix, iy, panels.rows[k]) > 1.0
                if drawn:
                    red, green, blue = _mesh_light(
                        px, top + py, face[row, column], triangles, light
                    )
                else:
                    red, green, blue = _panel_light(ix, iy, k, panels, light)
                picture[y, x, 0] += red / (fine * fine)
                picture[y, x, 1] += green / (fine * fine)
                picture[y, x, 2] += blue / (fine * fine)


@njit(cache=True, nogil=True, error_model="numpy")
def _ideal(x, y, lens):
    """Ideal normalized coordinates of a pixel; `lens` in the order of camera.PARAMETERS."""
    yd = (y - lens[3]) / lens[1]
    xd = (x - lens[2] - lens[4] * yd) / lens[0]
    u, v = xd, yd
    for _ in range(_UNDISTORT_STEPS):
        r2 = u * u + v * v
        radial = 1 + r2 * (lens[5] + r2 * (lens[6] + r2 * lens[9]))
        du = xd - (u * radial + 2 * lens[7] * u * v + lens[8] * (r2 + 2 * u * u))
        dv = yd - (v * radial + lens[7] * (r2 + 2 * v * v) + 2 * lens[8] * u * v)
        u += du
        v += dv
        if abs(du) + abs(dv) < _TOLERANCE:
            break
    return u, v


@njit(cache=True, nogil=True, error_model="numpy")
def _depth(x, y, row):
    """Depth at which the ray (x, y, 1) meets a panel's plane; negative from behind."""
    facing = row[9] * x + row[10] * y + row[11]
    if facing >= 0:
        return -1.0
    return (row[9] * row[0] + row[10] * row[1] + row[11] * row[2]) / facing


@njit(cache=True, nogil=True, error_model="numpy")
def _within(x, y, depth, row):
    """Where on the panel the ray meets it, right and down from its origin, mm."""
    px, py, pz = x * depth - row[0], y * depth - row[1], depth - row[2]
    return (
        px * row[3] + py * row[4] + pz * row[5],
        px * row[6] + py * row[7] + pz * row[8],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(x, y, panels):
    """Number of the first panel on the ray, -1 for none."""
    best, found = np.inf, -1
    for k in range(len(panels.rows)):
        bounds = panels.bounds[k]
        if x < bounds[0] or y < bounds[1] or x > bounds[2] or y > bounds[3]:
            continue
        row = panels.rows[k]
        depth = _depth(x, y, row)
        if depth <= 0 or depth >= best:
            continue
        right, down = _within(x, y, depth, row)
        if 0 <= right <= row[12] and 0 <= down <= row[13]:
            best, found = depth, k
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _is_plain(hit, x, y, k, panels):
    """Whether one sample will do: the same panel all round, and no print."""
    if k >= 0 and panels.kinds[k, 1] == 0:
        return False
    for i in range(3):
        for j in range(3):
            if hit[y + i, x + j] != k:
                return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _is_drawn(face, x, y, fine):
    """Whether the mesh is in any sample of the pixel (x, y) of the buffer."""
    if x < 0 or (x + 1) * fine > face.shape[1]:
        return False
    for i in range(fine):
        for j in range(fine):
            if face[y * fine + i, x * fine + j] >= 0:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _panel_light(x, y, k, panels, light):
    """Light that a panel sends along the ray (x, y, 1)."""
    if k < 0:
        return 0.02, 0.02, 0.02
    row = panels.rows[k]
    depth = _depth(x, y, row)
    right, down = _within(x, y, depth, row)
    point = (x * depth, y * depth, depth)
    lit, shine = _lit(point, (row[9], row[10], row[11]), light)
    first, height, width = panels.kinds[k]
    if height == 0:
        tone = _printed(right - panels.margin_mm, down - panels.margin_mm, panels)
        return tone * lit, tone * lit, tone * lit
    u = min(max(right / row[12] * width - 0.5, 0.0), width - 1.001)
    v = min(max(down / row[13] * height - 0.5, 0.0), height - 1.001)
    i, j = int(v), int(u)
    at = first + i * width + j
    fu, fv = u - j, v - i
    red = green = blue = 0.02 * shine
    for step, share in (
        (0, (1 - fu) * (1 - fv)),
        (1, fu * (1 - fv)),
        (width, (1 - fu) * fv),
        (width + 1, fu * fv),
    ):
        red += share * lit * light.linear[panels.texels[at + step, 0]]
        green += share * lit * light.linear[panels.texels[at + step, 1]]
        blue += share * lit * light.linear[panels.texels[at + step, 2]]
    return red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def _printed(x, y, panels):
    """Reflectance of the board at x, y mm from the corner of its print."""
    column, row = int(np.floor(x / panels.square_mm)), int(np.floor(y / panels.square_mm))
    cells = panels.cells
    if column < 0 or row < 0 or row >= cells.shape[0] or column >= cells.shape[1]:
        return 0.80
    if (row + column) % 2 == 0:
        return 0.035
    if panels.marker_mm <= 0:
        return 0.80
    border = 0.5 * (panels.square_mm - panels.marker_mm)
    cell = panels.marker_mm / cells.shape[2]
    i = int(np.floor((y - row * panels.square_mm - border) / cell))
    j = int(np.floor((x - column * panels.square_mm - border) / cell))
    if i < 0 or j < 0 or i >= cells.shape[2] or j >= cells.shape[3]:
        return 0.80
    return 0.80 if cells[row, column, i, j] else 0.035


@njit(cache=True, nogil=True, error_model="numpy")
def _mesh_light(px, py, k, triangles, light):
    """Light of face k at a pixel: perspective-correct point, normal and chart position."""
    a, b, c = triangles.faces[k]
    s, p, n = triangles.screen, triangles.points, triangles.normals
    area = (s[b, 0] - s[a, 0]) * (s[c, 1] - s[a, 1]) - (s[b, 1] - s[a, 1]) * (s[c, 0] - s[a, 0])
    wa = ((s[b, 0] - px) * (s[c, 1] - py) - (s[b, 1] - py) * (s[c, 0] - px)) / area / p[a, 2]
    wb = ((s[c, 0] - px) * (s[a, 1] - py) - (s[c, 1] - py) * (s[a, 0] - px)) / area / p[b, 2]
    wc = ((s[a, 0] - px) * (s[b, 1] - py) - (s[a, 1] - py) * (s[b, 0] - px)) / area / p[c, 2]
    total = wa + wb + wc
    wa, wb, wc = wa / total, wb / total, wc / total
    point = (
        wa * p[a, 0] + wb * p[b, 0] + wc * p[c, 0],
        wa * p[a, 1] + wb * p[b, 1] + wc * p[c, 1],
        wa * p[a, 2] + wb * p[b, 2] + wc * p[c, 2],
    )
    nx = wa * n[a, 0] + wb * n[b, 0] + wc * n[c, 0]
    ny = wa * n[a, 1] + wb * n[b, 1] + wc * n[c, 1]
    nz = wa * n[a, 2] + wb * n[b, 2] + wc * n[c, 2]
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    lit, shine = _lit(point, (nx / size, ny / size, nz / size), light)
    if k >= triangles.painted:
        grey = 0.30 * lit + 0.05 * shine
        return grey, grey, grey
    chart = triangles.chart
    u = (wa * chart[k, 0, 0] + wb * chart[k, 1, 0] + wc * chart[k, 2, 0]) * triangles.skin_fine
    v = (wa * chart[k, 0, 1] + wb * chart[k, 1, 1] + wc * chart[k, 2, 1]) * triangles.skin_fine
    skin = triangles.skin
    j = min(max(int(u), 0), skin.shape[1] - 2)
    i = min(max(int(v), 0), skin.shape[0] - 2)
    fu, fv = u - j, v - i
    red = green = blue = 0.0
    for down, right, share in (
        (0, 0, (1 - fu) * (1 - fv)),
        (0, 1, fu * (1 - fv)),
        (1, 0, (1 - fu) * fv),
        (1, 1, fu * fv),
    ):
        texel = skin[i + down, j + right]
        gloss = shine * texel[3] / 1000.0
        red += share * (lit * light.linear[texel[0]] + gloss)
        green += share * (lit * light.linear[texel[1]] + gloss)
        blue += share * (lit * light.linear[texel[2]] + gloss)
    return red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def _lit(point, normal, light):
    """Diffuse light on a surface, and the shine of the flash towards the camera."""
    up = normal[0] * light.up[0] + normal[1] * light.up[1] + normal[2] * light.up[2]
    lit = light.ambient * (0.65 + 0.35 * up)
    facing, _ = _facing(point, normal, light.lamp)
    lit += light.lamp_strength * max(facing, 0.0)
    facing, far = _facing(point, normal, light.flash)
    fall = light.flash_strength * (light.flash_mm / far) ** 2
    return lit + fall * max(facing, 0.0), fall * max(facing, 0.0) ** _SHINE


@njit(cache=True, nogil=True, error_model="numpy")
def _facing(point, normal, lamp):
    """Cosine between the normal and the way to a lamp, and the distance to it."""
    x, y, z = lamp[0] - point[0], lamp[1] - point[1], lamp[2] - point[2]
    far = np.sqrt(x * x + y * y + z * z)
    return (x * normal[0] + y * normal[1] + z * normal[2]) / far, far
