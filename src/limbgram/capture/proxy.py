"""Proxy: a rough surface of the limb in cells, before the limb is measured.

In      points of the limb, as the placing of small photos gives them; or a plan's plain form.
Out     a LimbProxy: a tube of cells by azimuth and height, with a cap over its upper end.
Method  The tube stands on a straight axis: upright, or along the points where they are clearly
        longest in another direction. Its middle is a circle through each slice (Kasa 1976), a line
        through the middles. Radii are means of the points near each cell, weighted by a Gaussian;
        where there are none, wider means go on. The cap is the height of the points near it.
Fails   never: RegionError where too few points are known is raised by who looks for them.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial import KDTree

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import axis_across
from limbgram.core.mesh.mesh import Mesh

COLUMNS = 24
"""Cells round the limb, of 15 degrees."""
ROWS = 9
"""Cells along its side."""
_CAP_RINGS = (0.66, 0.33)
"""Rings of the cap, as shares of the radius under it; its pole is one more cell."""
_MOST_POINTS = 4000
ENDS = 0.01
"""Share of the points beyond either end of the tube: strays."""
_SIDE = 0.9
"""Share of the length that is side; the cap covers the rest."""
_ELONGATED, _UPRIGHT_DEG = 1.6, 40.0
"""The points' own long axis is taken where it is so much longer than the next one, and leans over
by more than this. A standing cast or a standing leg is described from above."""
_SLICE_POINTS = 12
_WIDE = 6.0
"""How much wider means reach where no points are near."""
_DOME_WEIGHT = 2.0
"""Points that a rounded end counts for, where the cap is; fewer points than"""
_CAP_POINTS = 1.0
"""this leave it open whether the limb goes on there."""
_HIGHEST, _MOST_ASIDE, _MOST_CROWN = 0.03, 0.95, 1.2
_FAINT = 1e-3
"""Weight of those wider means."""


@dataclass(frozen=True, kw_only=True)
class CoarseSkin:
    """A coarse mesh of a limb's skin, with the area of each place and whether it counts."""

    mesh: Mesh
    middle: Vector3
    known: Bool[np.ndarray, " n"]
    """Vertices that count."""
    area_mm2: Float64[np.ndarray, " n"]


@dataclass(frozen=True, kw_only=True)
class LimbProxy(CoarseSkin):
    """A limb's proxy in cells: each vertex of the mesh is the centre of a cell.

    Rows of the side from below, rings of the cap, the pole. All of the side is known, and of the
    cap what points lie on.
    """

    axis: Vector3
    """Unit, towards the upper end."""
    first: Vector3
    """Unit, across the axis: where azimuth is 0."""

    @property
    def rows(self) -> int:
        """Rows of cells that have an azimuth; the pole has none."""
        return (len(self.mesh) - 1) // COLUMNS

    @property
    def side_rows(self) -> int:
        return self.rows - len(_CAP_RINGS)

    @property
    def length(self) -> float:
        along = (self.mesh.vertices_mm - self.middle) @ self.axis
        return float(np.ptp(along))

    @property
    def radius(self) -> float:
        """Mean distance of the side from the axis."""
        side = self.mesh.vertices_mm[: self.side_rows * COLUMNS] - self.middle
        return float(np.linalg.norm(side - np.outer(side @ self.axis, self.axis), axis=1).mean())

    def by_row(self, values: np.ndarray) -> np.ndarray:
        """Values of all cells but the pole, rows from below upwards."""
        return values[:-1].reshape(self.rows, COLUMNS)


def proxy_of(points: Points3, towards: Vector3) -> LimbProxy:
    """A proxy through points of the limb.

    Args:
        towards: A place in the direction of azimuth 0: the first photo.
    """
    points = points[:: max(1, len(points) // _MOST_POINTS)]
    axis = _axis_of(points)
    first, second = _across(axis, towards - np.median(points, axis=0))
    local = np.column_stack([points @ first, points @ second, points @ axis])
    low, high = np.quantile(local[:, 2], (ENDS, 1 - ENDS))
    local = local[(local[:, 2] >= low) & (local[:, 2] <= high)]
    line = _centre_line(local, low, high)
    aside = local[:, :2] - line(local[:, 2])
    radius, turn = np.hypot(*aside.T), np.arctan2(aside[:, 1], aside[:, 0])
    heights = low + (high - low) * _SIDE * (np.arange(ROWS) + 0.5) / ROWS
    angles = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    step = (high - low) * _SIDE / ROWS
    radii = np.array(
        [[_radius_at(radius, turn, local[:, 2], phi, z, step) for phi in angles] for z in heights]
    )
    across = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [
        np.column_stack([line(np.full(COLUMNS, z)) + r[:, None] * across, np.full(COLUMNS, z)])
        for z, r in zip(heights, radii)
    ]
    known = [np.ones(COLUMNS, bool)] * ROWS
    top, edge = heights[-1], radii[-1]
    reach = 0.5 * float(edge.mean())
    crown = _crown_height(local, radius, high, top, float(edge.mean()))
    for share in (*_CAP_RINGS, 0.0):
        flat = line(np.full(COLUMNS, top)) + share * edge[:, None] * across
        near = np.exp(-0.5 * (_distances(flat, local[:, :2]) / (0.4 * reach)) ** 2)
        near *= (local[:, 2] > top - step)[None, :]
        weight = near.sum(1)
        dome = top + crown * np.sqrt(1 - share**2)
        height = (near @ local[:, 2] + _DOME_WEIGHT * dome) / (weight + _DOME_WEIGHT)
        rings.append(np.column_stack([flat, np.maximum(height, top)]))
        known.append(weight > _CAP_POINTS)
    vertices = np.concatenate([*rings[:-1], rings[-1].mean(0, keepdims=True)])
    seen = np.concatenate([*known[:-1], known[-1][:1]])
    frame = np.stack([first, second, axis])
    return _proxy_of_rings(vertices @ frame, seen, axis, first)


_SPREAD = 1 / 3
"""Of the way to a cell's neighbours: spots that stand for the cell."""
_NEAREST = 12


def gaps_mm(proxy: LimbProxy, points: Points3) -> Float64[np.ndarray, " c"]:
    """Distance along the skin from each cell to the nearest of these points.

    It counts for a spot in the middle half of the cell.

    Points lie beside the proxy, because it is rough: what counts is how far they lie along it.
    """
    mesh = proxy.mesh
    cells, normals = mesh.vertices_mm, mesh.vertex_normals()
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    edges = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    own = np.concatenate([np.arange(len(cells)), edges[:, 0]])
    spots = np.concatenate(
        [cells, cells[edges[:, 0]] + _SPREAD * (cells[edges[:, 1]] - cells[edges[:, 0]])]
    )
    _, near = KDTree(points).query(spots, k=min(_NEAREST, len(points)))
    off = points[np.asarray(near).reshape(len(spots), -1)] - spots[:, None]
    along = off - (off * normals[own][:, None]).sum(2, keepdims=True) * normals[own][:, None]
    gap_mm = np.linalg.norm(along, axis=2).min(axis=1)
    order = np.argsort(own, kind="stable")
    parts = np.split(gap_mm[order], np.flatnonzero(np.diff(own[order])) + 1)
    return np.array([np.median(part) for part in parts])


def plain_tube(
    heights: Float64[np.ndarray, " k"], radii: Float64[np.ndarray, " k"], dome_mm: float
) -> LimbProxy:
    """A plain limb: radii by height, upright, with a rounded end so high; its middle at 0."""
    points: list[np.ndarray] = []
    around = 2 * np.pi * np.arange(4 * COLUMNS) / (4 * COLUMNS)
    ring = np.column_stack([np.cos(around), np.sin(around)])
    for z in np.linspace(heights[0], heights[-1], 60):
        r = float(np.interp(z, heights, radii))
        points.append(np.column_stack([r * ring, np.full(len(ring), z)]))
    for rise in np.linspace(0.02, np.pi / 2, 24):
        r, z = radii[-1] * np.cos(rise), heights[-1] + dome_mm * np.sin(rise)
        points.append(np.column_stack([r * ring, np.full(len(ring), z)]))
    cloud = np.concatenate(points)
    cloud[:, 2] -= (cloud[:, 2].min() + cloud[:, 2].max()) / 2
    return proxy_of(cloud, np.array([1e6, 0.0, 0.0]))


def _crown_height(
    local: Points3, radius: Float64[np.ndarray, " n"], high: float, top: float, edge: float
) -> float:
    """Height of the ellipsoid over the side that passes through the highest points.

    Photos from the side see a rounded end only as far as it does not turn away.
    """
    highest = local[:, 2] >= np.quantile(local[:, 2], 1 - _HIGHEST)
    aside = min(float(radius[highest].mean()) / max(edge, 1e-12), _MOST_ASIDE)
    return min((high - top) / np.sqrt(1 - aside**2), _MOST_CROWN * edge)


def _axis_of(points: Points3) -> Vector3:
    """The axis of points: upright, or the long axis if they lie."""
    up = np.array([0.0, 0.0, 1.0])
    values, vectors = np.linalg.eigh(np.cov((points - np.median(points, axis=0)).T))
    longest = vectors[:, 2] if vectors[2, 2] >= 0 else -vectors[:, 2]
    leans_deg = np.degrees(np.arccos(np.clip(longest[2], -1, 1)))
    lies = values[2] > _ELONGATED**2 * max(values[1], 1e-12) and leans_deg > _UPRIGHT_DEG
    return longest if lies else up


def _across(axis: Vector3, towards: Vector3) -> tuple[Vector3, Vector3]:
    """Two directions across the axis, the first one as near to `towards` as that is."""
    first = towards - (towards @ axis) * axis
    if np.linalg.norm(first) < 1e-6 * np.linalg.norm(towards):
        first = axis_across(axis)
        first = first - (first @ axis) * axis
    first = first / np.linalg.norm(first)
    return first, np.cross(axis, first)


class _AxisLine:
    """The axis's position by height."""

    def __init__(self, at: np.ndarray, slope: np.ndarray) -> None:
        self._at, self._slope = at, slope

    def __call__(self, heights: np.ndarray) -> Float64[np.ndarray, "n 2"]:
        return self._at + heights[:, None] * self._slope


def _centre_line(local: Points3, low: float, high: float) -> _AxisLine:
    """A line through the circles of the slices; upright where too few slices have one."""
    edges = np.linspace(low, low + _SIDE * (high - low), ROWS + 1)
    found: list[tuple[float, np.ndarray]] = []
    whole = _circle_centre(local[:, :2])
    spread = float(np.linalg.norm(np.std(local[:, :2], axis=0)))
    for start, end in pairwise(edges):
        part = local[(local[:, 2] >= start) & (local[:, 2] < end), :2]
        if len(part) >= _SLICE_POINTS:
            middle = _circle_centre(part)
            if np.linalg.norm(middle - whole) < spread:
                found.append(((start + end) / 2, middle))
    if len(found) < 3:
        return _AxisLine(whole, np.zeros(2))
    z, middles = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    terms = np.column_stack([np.ones(len(z)), z])
    at, slope = np.linalg.lstsq(terms, middles, rcond=None)[0]
    return _AxisLine(at, slope)


def _circle_centre(points: np.ndarray) -> Float64[np.ndarray, "2"]:
    """Centre of the circle nearest to points: x^2 + y^2 = 2 a x + 2 b y + c, by least squares."""
    origin = points.mean(0)
    x, y = (points - origin).T
    terms = np.column_stack([2 * x, 2 * y, np.ones(len(x))])
    a, b, _ = np.linalg.lstsq(terms, x * x + y * y, rcond=None)[0]
    return origin + np.array([a, b])


def _radius_at(
    radius: np.ndarray, turn: np.ndarray, z: np.ndarray, phi: float, height: float, step: float
) -> float:
    """Mean radius of the points near a cell."""
    around = np.angle(np.exp(1j * (turn - phi))) / (2 * np.pi / COLUMNS)
    apart2 = around**2 + ((z - height) / step) ** 2
    near = np.exp(-0.5 * apart2) + _FAINT * np.exp(-0.5 * apart2 / _WIDE**2)
    near += _FAINT**3
    return float(near @ radius / near.sum())


def _distances(places: np.ndarray, points: np.ndarray) -> Float64[np.ndarray, "n m"]:
    return np.linalg.norm(places[:, None, :] - points[None, :, :], axis=2)


def _proxy_of_rings(
    vertices: Points3, known: np.ndarray, axis: Vector3, first: Vector3
) -> LimbProxy:
    """The proxy of rings joined to a mesh, open below."""
    rings = (len(vertices) - 1) // COLUMNS
    ids = np.arange(rings * COLUMNS).reshape(rings, COLUMNS)
    a, b = ids[:-1], np.roll(ids[:-1], -1, 1)
    c, d = np.roll(ids[1:], -1, 1), ids[1:]
    last = ids[-1]
    pole = np.full(COLUMNS, len(vertices) - 1)
    faces = np.concatenate(
        [
            np.stack([a, b, c], -1).reshape(-1, 3),
            np.stack([a, c, d], -1).reshape(-1, 3),
            np.stack([last, np.roll(last, -1), pole], -1),
        ]
    ).astype(np.int32)
    mesh = Mesh(vertices_mm=vertices, faces=faces)
    return LimbProxy(
        mesh=mesh,
        middle=vertices.mean(0),
        axis=axis,
        first=first,
        known=known,
        area_mm2=mesh.vertex_areas_mm2(),
    )
