"""Paint: the limb's white sock and the fabric paint on it, as a texture of its chart.

In      a Limb, how much of it is painted, round spots of one colour, a seed, a texel's size.
Out     a texture (rows, columns, 4): sRGB and gloss.
Method  Dabs of 0.4 to 8 mm radius, with equal area in every octave, are painted in space and not
        in the chart, so that the pole looks like the rest; large ones first, spots last.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Bool, Float64, UInt8
from scipy.ndimage import map_coordinates

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.kernels import njit
from limbgram.core.run import in_parallel
from limbgram.formats.sheets.sock import SockPattern, sock_pattern
from limbgram.synthetic.props.limb import Limb

MAGENTA = (235, 20, 200)
"""A colour that no dab has."""
_LOWEST, _HIGHEST = 0.25, 0.85
_GOLDEN = 0.381966


@dataclass(frozen=True, kw_only=True)
class SockSpot:
    """A disc on the skin."""

    around: float = 0.5
    """Share of the way round the limb, 0 to 1."""
    height: float = 0.5
    """Share of the limb's height, 0 at the cut and 1 at the distal end."""
    colour: tuple[int, int, int] = MAGENTA
    diameter_mm: float = 9.0
    near_mm: tuple[float, float, float] | None = None
    """In place of these two, a place in the world: the chart's nearest one is the spot's. On a limb
    that lies or is bent, a height is met more than once on the way along it."""


def scattered_spots(count: int) -> tuple[SockSpot, ...]:
    """Spots spread evenly round the limb and along it."""
    heights = np.linspace(_LOWEST, _HIGHEST, count)
    return tuple(
        SockSpot(around=(k * _GOLDEN) % 1.0, height=float(height))
        for k, height in enumerate(heights)
    )


def chart_place(limb: Limb, spot: SockSpot) -> tuple[int, int]:
    """Row and column in the chart of the centre of a spot."""
    columns = limb.grid_mm.shape[1] - 1
    if spot.near_mm is not None:
        away = np.linalg.norm(limb.grid_mm[1:-1, :columns] - np.array(spot.near_mm), axis=2)
        row, column = np.unravel_index(int(away.argmin()), away.shape)
        return int(row) + 1, int(column)
    column = int(spot.around * columns) % columns
    skin = np.flatnonzero(np.diff(limb.grid_mm[:, column, 2]) > 0)
    heights = limb.grid_mm[skin, column, 2] - limb.base_mm
    return int(skin[np.argmin(np.abs(heights - spot.height * limb.height_mm))]), column


def places_mm(limb: Limb, spots: Sequence[SockSpot]) -> tuple[Vector3, ...]:
    """Centres of the spots on the true surface, in the world."""
    at = (chart_place(limb, spot) for spot in spots)
    return tuple(limb.grid_mm[row, column].astype(np.float64) for row, column in at)


_SMALLEST_MM, _LARGEST_MM = 0.4, 8.0
_HARMONICS = 3
_LEAST_STRETCH = 0.65
_OUTERMOST = 1.5
"""Bound on the edge of a dab, in its radii."""
_NARROW_MM = 1e-4
"""Far below a texel and far above rounding."""
_MEAN_STRETCH = (1 + _LEAST_STRETCH) / 2
_STRIP_ROWS = 256
_PATCH_MM, _PATCH_WAVES = 60.0, 12
"""Wavelengths from which bare patches are made; the patches are about half as wide."""
_CAP_ROUND = 0.75
"""Share of the tube's girth below which the distal end has the sewn cap."""
_PALETTE = np.array(
    [
        (203, 32, 44),
        (240, 120, 20),
        (246, 210, 30),
        (30, 140, 66),
        (38, 160, 160),
        (40, 70, 190),
        (110, 40, 150),
        (214, 70, 120),
        (110, 70, 48),
        (34, 34, 38),
    ],
    float,
)


class Paint(Enum):
    """What is on the sock."""

    DABS = "dabs"
    PRINT = "print"
    """A knitted tube with the printed pattern of `formats/sheets/sock`, made for the camera, and a
    cap of the same fabric sewn on over the distal end."""
    NONE = "none"


@dataclass(frozen=True)
class Painting:
    """What is painted on the sock, and how much of it."""

    paint: Paint
    coverage: float = 0.0
    """Share of the sock that dabs hide."""
    spots: tuple[SockSpot, ...] = ()
    bare: float = 0.0
    """Share of the dabs that is left out in patches."""
    uneven: float = 0.0
    """Share of the dabs that is left out on one side, falling to none on the other."""


@dataclass(frozen=True)
class _Dabs:
    """All dabs in the order of painting."""

    chart: Float64[np.ndarray, "n 3"]
    """Column and row of the centre in the chart, and rows per mm there."""
    centre_mm: Points3
    frame: Float64[np.ndarray, "n 3 3"]
    """Two tangents of the skin and its normal."""
    shape: Float64[np.ndarray, "n 8"]
    """Radius in mm, aspect ratio, then amplitude and phase of the edge's harmonics."""
    colour: Float64[np.ndarray, "n 4"]
    """sRGB and opacity."""


def bake(
    limb: Limb, painting: Painting, seed: int, texel_mm: float, pixel_mm: float = 0.3
) -> UInt8[np.ndarray, "rows columns 4"]:
    """Paint the texture; texel (r, c) lies at row r / fine, column c / fine of the chart.

    Args:
        pixel_mm: Footprint of a pixel of the camera for which a printed pattern is made.
    """
    grid = limb.grid_mm
    step = float(np.linalg.norm(np.diff(grid[-200:, 0], axis=0), axis=1).mean())
    fine = max(1, round(step / texel_mm))
    rows, columns = (grid.shape[0] - 1) * fine + 1, (grid.shape[1] - 1) * fine + 1
    texture = np.empty((rows, columns, 4), np.uint8)
    count = _dab_count(limb, painting.coverage) if painting.paint is Paint.DABS else 0
    dabs = _scatter(limb, count, np.random.default_rng((seed, 2)))
    if painting.bare > 0 and count:
        dabs = _in_patches(dabs, painting.bare, np.random.default_rng((seed, 4)))
    if painting.uneven > 0 and count:
        dabs = _thinned(dabs, painting.uneven, np.random.default_rng((seed, 44)))
    dabs = _with_spots(dabs, limb, painting.spots)
    seeds = np.random.default_rng((seed, 3)).integers(0, 2**31, rows)

    printed = _printed(limb, pixel_mm, seed) if painting.paint is Paint.PRINT else None

    def lay_on(start: int) -> None:
        stop = min(start + _STRIP_ROWS, rows)
        _sock(texture, start, stop, seeds)
        if printed is not None:
            printed.lay_on(texture[start:stop, :, :3], start, fine)
        _lay_on(
            texture,
            start,
            stop,
            fine,
            grid,
            dabs.chart,
            dabs.centre_mm,
            dabs.frame,
            dabs.shape,
            dabs.colour,
        )

    in_parallel(lay_on, range(0, rows, _STRIP_ROWS))
    texture[:, -1] = texture[:, 0]
    return texture


@dataclass(frozen=True)
class _Print:
    """A printed fabric on the chart."""

    pattern: SockPattern
    x_mm: Float64[np.ndarray, "rows columns"]
    """Position on the fabric of each point of the chart, with `y_mm`."""
    y_mm: Float64[np.ndarray, "rows columns"]
    cap: Bool[np.ndarray, " rows"]
    """Rows of the sewn cap, whose fabric is cut across the tube's."""

    def lay_on(self, colours: UInt8[np.ndarray, "r c 3"], start: int, fine: int) -> None:
        """Print the rows of the texture from `start` on."""
        high, wide = colours.shape[:2]
        row = np.minimum((start + np.arange(high)) / fine, len(self.cap) - 1.0)
        column = np.minimum(np.arange(wide) / fine, self.x_mm.shape[1] - 1.0)
        at = np.stack(np.meshgrid(row, column, indexing="ij")).reshape(2, -1)
        x, y = (map_coordinates(one, at, order=1) for one in (self.x_mm, self.y_mm))
        ink = self.pattern.colours_at(x, y).reshape(high, wide, 3)
        # Between tube and cap lies the seam, at which positions on the fabric jump.
        near = np.floor(row).astype(int)
        seam = self.cap[near] != self.cap[np.minimum(near + 1, len(self.cap) - 1)]
        shade = np.asarray(colours, np.float32) / 255
        colours[~seam] = np.rint(np.asarray(ink, np.float32) * shade)[~seam]


def _printed(limb: Limb, pixel_mm: float, seed: int) -> _Print:
    """Fabric of which one tile goes round the limb, stretched to its girth."""
    grid = limb.grid_mm.astype(np.float64)
    round_mm = np.linalg.norm(np.diff(grid, axis=1), axis=2).sum(1)
    nominal_mm = float(np.median(round_mm))
    along = np.linalg.norm(np.diff(grid, axis=0), axis=2).mean(1)
    y_mm = np.concatenate([[0.0], np.cumsum(along)])
    pattern = sock_pattern(nominal_mm, float(np.ceil(y_mm[-1])), pixel_mm, seed)
    columns = grid.shape[1]
    x = np.broadcast_to(np.linspace(0, nominal_mm, columns), grid.shape[:2]).copy()
    y = np.broadcast_to(y_mm[:, None], grid.shape[:2]).copy()
    cap = (round_mm < _CAP_ROUND * nominal_mm) & (np.arange(len(grid)) > len(grid) / 2)
    x[cap], y[cap] = grid[cap, :, 0] + 0.37 * nominal_mm, grid[cap, :, 1] + 0.41 * y_mm[-1]
    return _Print(pattern, x, y, cap)


def _dab_count(limb: Limb, coverage: float) -> int:
    """Number of dabs that leave 1 - coverage of the area bare, their overlap included."""
    area = 0.5 * np.linalg.norm(limb.mesh.face_normals(), axis=1).sum()
    ratio = _LARGEST_MM / _SMALLEST_MM
    mean_square = 2 * np.log(ratio) / (1 - ratio**-2) * _SMALLEST_MM**2
    return round(-np.log(1 - coverage) * area / (np.pi * mean_square * _MEAN_STRETCH))


def _scatter(limb: Limb, count: int, rng: np.random.Generator) -> _Dabs:
    """Random dabs, uniform by area; radii have the density r^-3: equal area in every octave."""
    weighted = limb.mesh.face_normals()
    areas = np.linalg.norm(weighted, axis=1)
    face = rng.choice(len(areas), count, p=areas / areas.sum())
    share = rng.dirichlet([1.0, 1.0, 1.0], count)
    corners = limb.mesh.vertices_mm[limb.mesh.faces[face]]
    normal = weighted[face] / areas[face, None]
    first = np.cross(normal, rng.normal(size=(count, 3)))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    u = rng.random(count)
    radius = _SMALLEST_MM / np.sqrt(1 - u * (1 - (_SMALLEST_MM / _LARGEST_MM) ** 2))
    order = np.argsort(-radius * rng.uniform(0.4, 1.6, count), kind="stable")
    edge = np.stack(
        [rng.uniform(0, 0.16, (count, _HARMONICS)), rng.uniform(0, 6.28, (count, _HARMONICS))], -1
    ).reshape(count, 2 * _HARMONICS)
    colour = np.clip(_PALETTE[rng.integers(0, len(_PALETTE), count)], 0, 255)
    colour = np.clip(
        colour * rng.uniform(0.8, 1.15, (count, 1)) + rng.normal(0, 10, (count, 3)), 5, 250
    )
    chart = (limb.chart[face] * share[..., None]).sum(1)
    at = np.minimum(chart[:, 1].astype(int), len(limb.grid_mm) - 2)
    column = chart[:, 0].astype(int)
    steps = np.linalg.norm(limb.grid_mm[at + 1, column] - limb.grid_mm[at, column], axis=1)
    return _Dabs(
        np.column_stack([chart, 1.4 / steps])[order],
        (corners * share[..., None]).sum(1)[order],
        np.stack([first, np.cross(normal, first), normal], 1)[order],
        np.column_stack([radius, rng.uniform(_LEAST_STRETCH, 1.0, count), edge])[order],
        np.column_stack([colour, rng.uniform(0.8, 1.0, count)])[order],
    )


def _in_patches(dabs: _Dabs, bare: float, rng: np.random.Generator) -> _Dabs:
    """The dabs without a share of them, in contiguous patches."""
    directions = rng.normal(size=(_PATCH_WAVES, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    waves = 2 * np.pi / (_PATCH_MM * rng.uniform(0.7, 2.0, (_PATCH_WAVES, 1))) * directions
    field = np.sin(dabs.centre_mm @ waves.T + rng.uniform(0, 2 * np.pi, _PATCH_WAVES)).sum(1)
    return _chosen(dabs, field >= np.quantile(field, bare))


def _thinned(dabs: _Dabs, uneven: float, rng: np.random.Generator) -> _Dabs:
    """The dabs without a share that grows from 0 on one side to `uneven` on the other."""
    towards = rng.uniform(0, 2 * np.pi)
    aside = dabs.centre_mm[:, :2] - dabs.centre_mm[:, :2].mean(0)
    angle = np.arctan2(aside[:, 1], aside[:, 0]) - towards
    left_out = uneven * (0.5 + 0.5 * np.cos(angle))
    return _chosen(dabs, rng.random(len(left_out)) >= left_out)


def _chosen(dabs: _Dabs, kept: Bool[np.ndarray, " n"]) -> _Dabs:
    return _Dabs(
        dabs.chart[kept],
        dabs.centre_mm[kept],
        dabs.frame[kept],
        dabs.shape[kept],
        dabs.colour[kept],
    )


def _with_spots(dabs: _Dabs, limb: Limb, spots: Sequence[SockSpot]) -> _Dabs:
    """The dabs and, over them, round opaque spots."""
    for spot in spots:
        row, column = chart_place(limb, spot)
        grid = limb.grid_mm.astype(np.float64)
        across = grid[row, column + 1] - grid[row, column - 1 if column else -2]
        along = grid[row + 1, column] - grid[row - 1, column]
        normal = np.cross(across, along)
        normal /= np.linalg.norm(normal)
        first = across / np.linalg.norm(across)
        rows_per_mm = 2 * 1.4 / np.linalg.norm(along)
        frame = np.stack([first, np.cross(normal, first), normal])
        shape = np.array([spot.diameter_mm / 2, 1.0, *np.zeros(2 * _HARMONICS)])
        dabs = _Dabs(
            np.concatenate([dabs.chart, np.array([[column, row, rows_per_mm]])]),
            np.concatenate([dabs.centre_mm, grid[row, column][None]]),
            np.concatenate([dabs.frame, frame[None]]),
            np.concatenate([dabs.shape, shape[None]]),
            np.concatenate([dabs.colour, np.array([[*spot.colour, 1.0]])]),
        )
    return dabs


@njit(cache=True, nogil=True)
def _sock(texture: np.ndarray, start: int, stop: int, seeds: np.ndarray):
    """Off-white knit, with noise in every texel."""
    for r in range(start, stop):
        state = np.uint32(seeds[r])
        for c in range(texture.shape[1]):
            state = np.uint32(state * np.uint32(1664525) + np.uint32(1013904223))
            shade = 226 + np.int64(state >> np.uint32(28))
            texture[r, c, 0] = shade
            texture[r, c, 1] = shade
            texture[r, c, 2] = shade - 6
            texture[r, c, 3] = 20


@njit(cache=True, nogil=True)
def _lay_on(
    texture: np.ndarray,
    start: int,
    stop: int,
    fine: int,
    grid: np.ndarray,
    chart: np.ndarray,
    centres: np.ndarray,
    frames: np.ndarray,
    shapes: np.ndarray,
    colours: np.ndarray,
):
    """Paint all dabs, in order, on the texture rows [start, stop)."""
    columns = texture.shape[1] - 1
    for k in range(len(centres)):
        reach = shapes[k, 0] * _OUTERMOST
        column, row = chart[k, 0], chart[k, 1]
        rows = (reach * chart[k, 2] + 1.0) * fine
        for r in range(max(start, int(row * fine - rows)), min(stop, int(row * fine + rows) + 1)):
            i = min(r // fine, grid.shape[0] - 2)
            down = r / fine - i
            j = int(column)
            edge = grid[i, j + 1] - grid[i, j]
            width = np.sqrt(edge[0] ** 2 + edge[1] ** 2 + edge[2] ** 2) + 1e-6
            half = min(int((1.3 * reach / width + 1.0) * fine), columns // 2)
            offset = -half
            while offset <= half:  # one cell of the chart at a time
                c = (int(column * fine) + offset) % columns
                j = c // fine
                beyond = min((j + 1) * fine, c + half - offset + 1)
                offset += beyond - c
                low, high = _reached(grid, i, j, down, centres[k], frames[k], shapes[k])
                first = max(c, j * fine + int(np.ceil(low * fine)))
                beyond = min(beyond, j * fine + int(np.floor(high * fine)) + 1)
                for c in range(first, beyond):
                    right = c / fine - j
                    x = y = height = 0.0
                    for axis in range(3):
                        upper = grid[i, j, axis] * (1 - right) + grid[i, j + 1, axis] * right
                        lower = (
                            grid[i + 1, j, axis] * (1 - right) + grid[i + 1, j + 1, axis] * right
                        )
                        away = upper * (1 - down) + lower * down - centres[k, axis]
                        x += away * frames[k, 0, axis]
                        y += away * frames[k, 1, axis]
                        height += away * frames[k, 2, axis]
                    if abs(height) < 0.5 * reach + 0.5:
                        _blend(texture, r, c, x, y, shapes[k], colours[k])


@njit(cache=True, nogil=True)
def _reached(
    grid: np.ndarray,
    i: int,
    j: int,
    down: float,
    centre: np.ndarray,
    frame: np.ndarray,
    shape: np.ndarray,
):
    """Interval of a cell's width, at one height in it, that bounds a dab."""
    x = y = right = up = 0.0
    for axis in range(3):
        near = grid[i, j, axis] * (1 - down) + grid[i + 1, j, axis] * down
        far = grid[i, j + 1, axis] * (1 - down) + grid[i + 1, j + 1, axis] * down
        x += (near - centre[axis]) * frame[0, axis]
        y += (near - centre[axis]) * frame[1, axis] / shape[1]
        right += (far - near) * frame[0, axis]
        up += (far - near) * frame[1, axis] / shape[1]
    steep, half, rest = right**2 + up**2, x * right + y * up, x**2 + y**2
    if steep < _NARROW_MM**2:
        return 0.0, 1.0
    root = half**2 - steep * (rest - (_OUTERMOST * shape[0] + _NARROW_MM) ** 2)
    if root < 0:
        return 1.0, 0.0
    return (-half - np.sqrt(root)) / steep, (-half + np.sqrt(root)) / steep


@njit(cache=True, nogil=True)
def _blend(
    texture: np.ndarray, r: int, c: int, x: float, y: float, shape: np.ndarray, colour: np.ndarray
):
    """Blend the dab into one texel if it lies inside the dab's wavy edge."""
    y /= shape[1]
    away = np.sqrt(x * x + y * y)
    if away > _OUTERMOST * shape[0]:
        return
    edge = 1.0
    if away > 0.5 * shape[0]:
        angle = np.arctan2(y, x)
        for n in range(_HARMONICS):
            edge += shape[2 + 2 * n] * np.cos((n + 2) * angle + shape[3 + 2 * n])
    if away < edge * shape[0]:
        for band in range(3):
            old = texture[r, c, band]
            texture[r, c, band] = old + colour[3] * (colour[band] - old)
        texture[r, c, 3] = 90
