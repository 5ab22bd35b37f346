"""Shading: light from panels and mesh to the camera, by ambient light, lamp, flash and shadow.

Everything is in the camera frame; rays are (x, y, 1). Light is relative to a white page that faces
the flash at its reference distance. Diffuse light is Lambert's; the flash has a specular lobe.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.kernels import njit
from limbgram.reconstruction.photos.decoding import LINEAR_OF_SRGB

_WHITE, _BLACK = 0.80, 0.035


class Panels(NamedTuple):
    """Rectangles in the camera frame, for kernels."""

    rows: np.ndarray
    """Origin (3), unit right (3), unit down (3), normal out of the front (3), width, height, and
    `Panel.print_from_panel` (4)."""
    bounds: np.ndarray
    """x0, y0, x1, y1 of each in ideal coordinates."""
    kinds: np.ndarray
    """First texel, texture height and width; height 0 for a printed board."""
    texels: np.ndarray
    cells: np.ndarray
    """Print of the board by square and by cell of its marker; 1 is white."""
    square_mm: float
    marker_mm: float
    margin_mm: float


class Triangles(NamedTuple):
    """The mesh as this camera sees it."""

    screen: np.ndarray
    """Pixels of the vertices."""
    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    limb_faces: int
    """Number of the limb's faces, which come before the stand's."""
    chart: np.ndarray
    skin: np.ndarray
    skin_fine: int


class Light(NamedTuple):
    """Lamps, relative to a white page that faces the flash at its reference distance."""

    up: np.ndarray
    lamp: np.ndarray
    flash: np.ndarray
    edge: np.ndarray
    """Normal, towards the dark, of the plane through the lamp that bounds the shadow; 0: none."""
    ambient: float
    lamp_strength: float
    flash_strength: float
    flash_mm: float
    gloss: float
    polish: float
    linear: np.ndarray
    """Linear light of the 256 sRGB values."""


@njit(cache=True, nogil=True, error_model="numpy")
def panel_light(x: float, y: float, k: int, panels: Panels, light: Light):
    """Light that a panel sends along the ray (x, y, 1)."""
    if k < 0:
        return 0.02, 0.02, 0.02
    rows = panels.rows
    depth = depth_on(x, y, rows, k)
    across, along = within(x, y, depth, rows, k)
    point = (x * depth, y * depth, depth)
    lit, shine = _lit(point, (rows[k, 9], rows[k, 10], rows[k, 11]), light)
    first, height, width = panels.kinds[k, 0], panels.kinds[k, 1], panels.kinds[k, 2]
    if height == 0:
        tone = printed(across, along, k, panels)
        return tone * lit, tone * lit, tone * lit
    u = min(max(across / rows[k, 12] * width - 0.5, 0.0), width - 1.001)
    v = min(max(along / rows[k, 13] * height - 0.5, 0.0), height - 1.001)
    i, j = int(v), int(u)
    fu, fv = u - j, v - i
    red = green = blue = 0.02 * shine
    for corner in range(4):
        down, right = corner // 2, corner % 2
        share = (fv if down else 1 - fv) * (fu if right else 1 - fu) * lit
        at = first + (i + down) * width + j + right
        red += share * light.linear[panels.texels[at, 0]]
        green += share * light.linear[panels.texels[at, 1]]
        blue += share * light.linear[panels.texels[at, 2]]
    return red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def mesh_light(px: float, py: float, k: int, triangles: Triangles, light: Light):
    """Light of face k at a pixel; point, normal and texture are perspective-correct."""
    a, b, c = triangles.faces[k, 0], triangles.faces[k, 1], triangles.faces[k, 2]
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
    if k >= triangles.limb_faces:
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
    for corner in range(4):
        down, right = corner // 2, corner % 2
        share = (fv if down else 1 - fv) * (fu if right else 1 - fu)
        gloss = light.gloss * shine * skin[i + down, j + right, 3] / 1000.0
        red += share * (lit * light.linear[skin[i + down, j + right, 0]] + gloss)
        green += share * (lit * light.linear[skin[i + down, j + right, 1]] + gloss)
        blue += share * (lit * light.linear[skin[i + down, j + right, 2]] + gloss)
    return red, green, blue


@njit(cache=True, nogil=True, error_model="numpy")
def printed(x: float, y: float, k: int, panels: Panels):
    """Reflectance of the board at x, y mm from the corner of panel k."""
    x = panels.rows[k, 14] + panels.rows[k, 16] * x - panels.margin_mm
    y = panels.rows[k, 15] + panels.rows[k, 17] * y - panels.margin_mm
    column, row = int(np.floor(x / panels.square_mm)), int(np.floor(y / panels.square_mm))
    cells = panels.cells
    if column < 0 or row < 0 or row >= cells.shape[0] or column >= cells.shape[1]:
        return _WHITE
    if (row + column) % 2 == 0:
        return _BLACK
    if panels.marker_mm <= 0:
        return _WHITE
    border = 0.5 * (panels.square_mm - panels.marker_mm)
    cell = panels.marker_mm / cells.shape[2]
    i = int(np.floor((y - row * panels.square_mm - border) / cell))
    j = int(np.floor((x - column * panels.square_mm - border) / cell))
    if i < 0 or j < 0 or i >= cells.shape[2] or j >= cells.shape[3]:
        return _WHITE
    return _WHITE if cells[row, column, i, j] else _BLACK


@njit(cache=True, nogil=True, error_model="numpy")
def _lit(
    point: tuple[float, float, float], normal: np.ndarray | tuple[float, float, float], light: Light
):
    """Diffuse light on a surface, and the specular light of the flash towards the camera."""
    up = normal[0] * light.up[0] + normal[1] * light.up[1] + normal[2] * light.up[2]
    lit = light.ambient * (0.65 + 0.35 * up)
    facing, _ = _facing(point, normal, light.lamp)
    beyond = 0.0
    for axis in range(3):
        beyond += light.edge[axis] * (point[axis] - light.lamp[axis])
    if beyond <= 0:
        lit += light.lamp_strength * max(facing, 0.0)
    facing, distance = _facing(point, normal, light.flash)
    flash = light.flash_strength * (light.flash_mm / distance) ** 2
    facing = max(facing, 0.0)
    return lit + flash * facing, flash * facing**light.polish


@njit(cache=True, nogil=True, error_model="numpy")
def _facing(
    point: tuple[float, float, float],
    normal: np.ndarray | tuple[float, float, float],
    lamp: np.ndarray,
):
    """Cosine between the normal and the direction to a lamp, and the distance to it."""
    x, y, z = lamp[0] - point[0], lamp[1] - point[1], lamp[2] - point[2]
    distance = np.sqrt(x * x + y * y + z * z)
    return (x * normal[0] + y * normal[1] + z * normal[2]) / distance, distance


@njit(cache=True, nogil=True, error_model="numpy")
def depth_on(x: float, y: float, rows: np.ndarray, k: int):
    """Depth at which the ray (x, y, 1) meets a panel's plane; negative from behind."""
    facing = rows[k, 9] * x + rows[k, 10] * y + rows[k, 11]
    if facing >= 0:
        return -1.0
    along = rows[k, 9] * rows[k, 0] + rows[k, 10] * rows[k, 1] + rows[k, 11] * rows[k, 2]
    return along / facing


@njit(cache=True, nogil=True, error_model="numpy")
def within(x: float, y: float, depth: float, rows: np.ndarray, k: int):
    """Position at which a ray meets a panel, right and down from its origin, mm."""
    px, py, pz = x * depth - rows[k, 0], y * depth - rows[k, 1], depth - rows[k, 2]
    return (
        px * rows[k, 3] + py * rows[k, 4] + pz * rows[k, 5],
        px * rows[k, 6] + py * rows[k, 7] + pz * rows[k, 8],
    )


LAMP_IN_WORLD = np.array([900.0, -700.0, 1900.0])
_FLASH_IN_CAMERA = np.array([0.0, -90.0, 0.0])
_STEP_ASIDE_MM = 25.0


class Shadow(Enum):
    """What stands before the lamp: a straight edge that leaves half of the limb dark."""

    NONE = "none"
    STANDING = "standing"
    """A thing in the room: the same edge in every photo."""
    MOVING = "moving"
    """A person who walks about: another edge in every photo."""


@dataclass(frozen=True, kw_only=True)
class Lighting:
    """Strength of each light, relative to a white page that faces the flash."""

    ambient: float = 0.40
    lamp: float = 0.28
    flash: float = 0.42
    """The camera's own, 90 mm above the lens; it falls with the square of the distance."""
    gloss: float = 1.0
    """Strength of the specular lobe: 1 is fabric paint, 12 wet paint, which burns out."""
    polish: float = 24.0
    """Exponent of the specular lobe: the larger, the smaller the highlight."""
    lamp_colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Red, green and blue of the lamp against those of all other light. A warm bulb in a room lit
    by the sky: (1.35, 1.0, 0.55), 3000 K beside 6500 K."""
    shadow: Shadow = Shadow.NONE

    def __post_init__(self) -> None:
        shares = (self.ambient, self.lamp, self.flash, self.gloss, *self.lamp_colour)
        if min(shares) < 0 or self.polish < 1:
            raise OptionsError("made.light")


def shadow_edge(lighting: Lighting, middle_in_world: Vector3, seed: int, photo_idx: int) -> Vector3:
    """Normal, towards the dark, of the plane through the lamp that bounds the shadow; 0: none.

    The plane passes through the limb's middle or, if the shadow moves, up to 25 mm beside it.
    """
    if lighting.shadow is Shadow.NONE:
        return np.zeros(3)
    rng = np.random.default_rng((seed, 11))
    ray = middle_in_world - LAMP_IN_WORLD
    across = np.cross(ray, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    lean = np.radians(rng.uniform(-20, 20))
    aside_mm = 0.0
    if lighting.shadow is Shadow.MOVING:
        rng = np.random.default_rng((seed, 12, photo_idx))
        lean += np.radians(rng.uniform(-20, 20))
        aside_mm = rng.uniform(-_STEP_ASIDE_MM, _STEP_ASIDE_MM)
    upward = np.array([0.0, 0.0, 1.0]) * np.cos(lean) + across * np.sin(lean)
    normal = np.cross(ray + aside_mm * across, upward)
    return normal / np.linalg.norm(normal)


def light_of(
    lighting: Lighting, camera_from_world: Rigid, flash_mm: float, edge_in_world: Vector3
) -> Light:
    """The lights in the camera frame; `flash_mm` is the flash's reference distance."""
    return Light(
        up=camera_from_world.rotation[:, 2].copy(),
        lamp=camera_from_world.apply(LAMP_IN_WORLD),
        flash=_FLASH_IN_CAMERA,
        edge=camera_from_world.rotation @ edge_in_world,
        ambient=float(lighting.ambient),
        lamp_strength=float(lighting.lamp),
        flash_strength=float(lighting.flash),
        flash_mm=float(flash_mm),
        gloss=float(lighting.gloss),
        polish=float(lighting.polish),
        linear=LINEAR_OF_SRGB,
    )
