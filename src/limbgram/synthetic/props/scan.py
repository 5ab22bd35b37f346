"""Scans: the shape of a file as rings of radii, of which a Limb is built.

In      a shape file of any format that is read, and its unit if the file lacks it.
Out     a Scan: radii by height and angle about the long axis, and over the closed end by elevation;
        of it a Limb, standing upright with the closed end up, as all limbs here do.
Method  The largest component is stood on its long axis. Level rays are cast from the axis, and
        from the centre of the end's dome a fan of rays up to the pole; each takes its outermost
        crossing, so that of a socket the outside is taken. Ragged rows of the open end are left
        out, holes are filled by the smoothest radii, and facets are smoothed by half an edge
        length. The limb built of these radii, not the file, is what is photographed, and the truth.
        A surface whose rays cross the outside several times, as a foot's with its shank, is taken
        as a bent shape (bent.py) where it has an open end.
Fails   ShapeFileError: no long axis, rays that cross the outside several times and no open end,
        large holes, or a size that the room does not take.
Frame   as the limb's: z up along the axis, millimetres; nothing is mirrored.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float64
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import gaussian_filter1d
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import KDTree

from limbgram.core.errors import MeasureError, ShapeFileError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.axis import fit_axis
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges, largest_piece
from limbgram.findings import Finding, note
from limbgram.formats.reading import ShapeFile, read_shape
from limbgram.synthetic.props.bent import BentShape, rotation_to_upright, stand_on_rim
from limbgram.synthetic.props.details import PLAIN, SkinDetails
from limbgram.synthetic.props.limb import (
    Limb,
    Relief,
    limb_of_skin,
    with_relief,
)

_STEP_MM = 1.5
"""Distance between rays on the surface of a limb of average width."""
_LONGEST_MM, _SHORTEST_MM = 450.0, 50.0
_WIDEST_MM = 150.0
"""Largest radius that stands clear of the board on the table."""
_NEAR_BOARD_MM = 60.0
"""Height below which a bent shape must keep to `_WIDEST_MM`; above, it hides the board from one
side only."""
_BENDS = frozenset({"made.scan.no_axis", "made.scan.folded", "made.scan.steep"})
"""Refusals of shapes that have no rings round a straight axis."""
_USUAL_HEIGHT_MM = 250.0
"""Height of a limb that is whole in nearly every photo from the usual distance."""
_NEAREST_SHARE = 0.85
"""Least share of the usual distance: from nearer the board would leave the photo."""
_DISTANCES_MM = (500.0, 2500.0)
_WIDEST_HOLE_MM = 40.0
_MOST_MISSING = 0.1
"""Largest share of rays that meet a hole."""
_FOLD_MM = 3.0
"""Outer crossings of a ray farther apart are two surfaces."""
_MOST_FOLDED = 0.02
"""Largest share of such rays."""
_STEEPEST = 2.0
"""Slope, change of radius per step across the rays, beyond which rays chart a surface badly."""
_MOST_STEEP = 0.005
"""Largest share of steeper steps: seven limbs have none, a foot has 0.018."""
_MOST_SMOOTHING_MM = 3.0
_OPEN_RATIO = 2.0
"""Least ratio of the open edges' lengths at the two ends that tells the open end."""
_THINNER = 0.98
"""Ratio of the two ends' widths below which the thinner end counts as the closed one."""


@dataclass(frozen=True, kw_only=True)
class Scan:
    """A limb's shape as radii; compared by hash, unit and side."""

    sha256: str
    """Of the file."""
    mm_per_unit: float
    side: Literal["left", "right", "none"]
    """As the file says it."""
    height_mm: float = field(compare=False)
    """From the lowest row to the pole."""
    tube_mm: float = field(compare=False)
    """Height of the dome's centre above the lowest row."""
    tube_rows: int = field(compare=False)
    """Number of rows of level rays; the others fan out from the dome's centre to the pole."""
    radii_mm: Float64[np.ndarray, "rows columns"] = field(compare=False)
    """From the axis, then from the dome's centre; columns at equal angles from +x."""
    anterior_rad: float = field(compare=False)
    notes: tuple[Finding, ...] = field(compare=False)
    """What was left out or filled."""


def read_scan(path: Path | str, mm_per_unit: float | None = None) -> Scan | BentShape:
    """Read a shape as radii or, if it bends, as a foot with its shank, as a BentShape.

    Args:
        mm_per_unit: None takes the file's unit or, if it has none, millimetres if the size is that
            of a limb.

    Raises:
        ShapeFileError: the file cannot be read, or its shape has no rings.
    """
    path = Path(path)
    shape = read_shape(path, mm_per_unit)
    mesh, parts_out = largest_piece(shape.limb.mesh)
    apart = (note("made.scan.pieces_left_out", pieces=parts_out),) if parts_out else ()
    try:
        return _straight(shape, mesh, apart, path.name)
    except ShapeFileError as error:
        if error.finding.code not in _BENDS or not len(boundary_half_edges(mesh.faces)):
            raise
    return _bent(shape, mesh, apart, path.name)


def _straight(shape: ShapeFile, mesh: Mesh, apart: tuple[Finding, ...], name: str) -> Scan:
    limb_from_mesh = shape.limb.known_limb_from_mesh
    world_from_mesh = _upright(mesh, limb_from_mesh, name)
    standing = mesh.moved(world_from_mesh)
    rays = _cast_all(standing, name)
    rings = _rings(rays, _edge_mm(mesh), name)
    notes = list(apart)
    if rings.cut_mm > _STEP_MM:
        notes.append(note("made.scan.end_left_out", cut_mm=rings.cut_mm))
    if rings.missing > 0:
        notes.append(note("made.scan.filled", share=rings.missing))
    return Scan(
        sha256=shape.sha256,
        mm_per_unit=shape.mm_per_unit,
        side=shape.limb.side,
        height_mm=rings.tube_mm + float(rings.radii_mm[-1, 0]),
        tube_mm=rings.tube_mm,
        tube_rows=rings.tube_rows,
        radii_mm=rings.radii_mm,
        anterior_rad=_anterior_rad(world_from_mesh, limb_from_mesh),
        notes=tuple(notes),
    )


def _bent(shape: ShapeFile, mesh: Mesh, apart: tuple[Finding, ...], name: str) -> BentShape:
    bent = stand_on_rim(mesh, name)
    vertices = bent.mesh.vertices_mm
    low = vertices[vertices[:, 2] < _NEAR_BOARD_MM, :2]
    _require_size(float(vertices[:, 2].max()), float(np.linalg.norm(low, axis=1).max()), name)
    limb_from_mesh = shape.limb.known_limb_from_mesh
    cut_off = bent.cut_mm > _STEP_MM
    return BentShape(
        sha256=shape.sha256,
        name=name,
        mm_per_unit=shape.mm_per_unit,
        side=shape.limb.side,
        mesh=bent.mesh,
        pole=bent.pole,
        anterior_rad=_anterior_rad(bent.world_from_mesh, limb_from_mesh),
        notes=(*apart, *((note("made.scan.end_left_out", cut_mm=bent.cut_mm),) if cut_off else ())),
    )


def _anterior_rad(world_from_mesh: Rigid, limb_from_mesh: Rigid | None) -> float:
    """Azimuth of the anterior direction by the file's limb frame; +y without one."""
    anterior = np.array([0.0, 1.0, 0.0])
    if limb_from_mesh is not None:
        anterior = world_from_mesh.rotation @ limb_from_mesh.rotation.T @ anterior
    return float(np.arctan2(anterior[1], anterior[0]))


def limb_of_scan(
    scan: Scan,
    seed: int,
    step_mm: float,
    base_mm: float,
    relief: Relief,
    details: SkinDetails = PLAIN,
) -> Limb:
    """Build the limb, with relief and details."""
    rows, columns = scan.radii_mm.shape
    angle = 2 * np.pi * np.arange(columns) / columns
    wrapped = np.concatenate([angle - 2 * np.pi, angle, angle + 2 * np.pi])
    surface = RectBivariateSpline(np.arange(rows), wrapped, np.tile(scan.radii_mm, (1, 3)))
    fine = np.linspace(0, rows - 1, 20 * rows)
    radius, rise = _placed(scan, fine, np.interp(fine, np.arange(rows), scan.radii_mm.mean(1)))
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(radius), np.diff(rise)))])
    at = np.interp(np.linspace(0, length[-1], round(length[-1] / step_mm) + 1), length, fine)
    around = 2 * np.pi * np.arange(round(2 * np.pi * radius.max() / step_mm))
    around /= len(around)
    away, height = _placed(scan, at[:, None], surface(at, around))
    directions = np.stack([np.cos(around), np.sin(around)], -1)
    skin = np.concatenate([away[..., None] * directions, height[..., None]], -1)
    skin = with_relief(skin, relief, np.random.default_rng((seed, 1)))
    side = "left" if scan.side == "left" else "right"
    return limb_of_skin(skin, details, seed, base_mm, side, scan.anterior_rad)


def distance_for(scan: Scan | BentShape, usual_mm: float) -> float:
    """Distance at which the limb fills the photo as ours does from the usual distance."""
    share = max(_NEAREST_SHARE, scan.height_mm / _USUAL_HEIGHT_MM)
    return float(np.clip(share * usual_mm, *_DISTANCES_MM))


def _edge_mm(mesh: Mesh) -> float:
    corners = mesh.vertices_mm[mesh.faces]
    return float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))


def _upright(mesh: Mesh, limb_from_mesh: Rigid | None, name: str) -> Rigid:
    """world_from_mesh that stands the shape on its long axis, the closed end up."""
    try:
        axis = fit_axis(mesh)
    except MeasureError as error:
        raise ShapeFileError("made.scan.no_axis", name=name) from error
    up = axis.direction * _sense(mesh, axis.point_mm, axis.direction, limb_from_mesh)
    rotation = rotation_to_upright(up)
    return Rigid(rotation, -rotation @ axis.point_mm)


def _sense(mesh: Mesh, point: Vector3, direction: Vector3, limb_from_mesh: Rigid | None) -> float:
    """1.0 if the closed end lies along the direction, -1.0 if against it.

    The closed end is told by, in this order: the length of open edges, the file's limb frame, the
    thinner end, the axes of the file.
    """
    along = (mesh.vertices_mm - point) @ direction
    low, high = float(along.min()), float(along.max())
    ends = boundary_half_edges(mesh.faces)
    open_mm = np.linalg.norm(np.diff(mesh.vertices_mm[ends], axis=1)[:, 0], axis=1)
    upper = along[ends].mean(1) > (low + high) / 2
    above, below = float(open_mm[upper].sum()), float(open_mm[~upper].sum())
    if max(above, below) > _OPEN_RATIO * min(above, below):
        return 1.0 if below > above else -1.0
    if limb_from_mesh is not None:
        proximal = limb_from_mesh.rotation.T @ np.array([0.0, 0.0, 1.0])
        return -1.0 if float(proximal @ direction) > 0 else 1.0
    share = (along - low) / (high - low)
    aside = np.linalg.norm((mesh.vertices_mm - point) - np.outer(along, direction), axis=1)
    first = _width_between(share, aside, 0.05, 0.3)
    last = _width_between(share, aside, 0.7, 0.95)
    if min(first, last) < _THINNER * max(first, last):
        return 1.0 if last < first else -1.0
    return 1.0 if direction[np.argmax(np.abs(direction))] > 0 else -1.0


def _width_between(
    share: Float64[np.ndarray, " n"], aside: Float64[np.ndarray, " n"], low: float, high: float
) -> float:
    """Mean distance from the axis of the vertices of one part of the length.

    Of all vertices if the part has none, as a cylinder of long triangles.
    """
    within = (share >= low) & (share <= high)
    return float(aside[within].mean() if within.any() else aside.mean())


class _Rays(NamedTuple):
    """Outermost crossings, and where rays of one row start."""

    radii_mm: Float64[np.ndarray, "rows columns"]
    """NaN where nothing is met."""
    tube_rows: int
    middle_mm: float
    """Height of the dome's middle; level rays lie below it, a step apart."""
    lowest_mm: float
    """Of the shape."""


def _cast_all(mesh: Mesh, name: str) -> _Rays:
    """Level rays from the axis, then the fan over the closed end.

    Raises:
        ShapeFileError: many rays cross the outside more than once.
    """
    heights = mesh.vertices_mm[:, 2]
    low, high = float(heights.min()), float(heights.max())
    aside = np.linalg.norm(mesh.vertices_mm[:, :2], axis=1)
    _require_size(high - low, float(aside.max()), name)
    wide = float(np.median(aside[aside > 0.3 * aside.max()]))
    middle = high - min(wide, 0.5 * (high - low))
    tube_rows = max(2, int((middle - low) / _STEP_MM))
    fan_rows = max(8, round(0.5 * np.pi * wide / _STEP_MM))
    columns = max(48, round(2 * np.pi * wide / _STEP_MM))
    angles = 2 * np.pi * np.arange(columns) / columns
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(columns)], -1)
    corners = mesh.vertices_mm[mesh.faces]
    bottom, top = corners[..., 2].min(1), corners[..., 2].max(1)
    rows: list[_RowHits] = []
    for height in middle - _STEP_MM * np.arange(tube_rows, 0, -1):
        near = corners[(bottom <= height) & (top >= height)]
        rows.append(_cast(near - np.array([0.0, 0.0, height]), level))
    fanned = corners - np.array([0.0, 0.0, middle])
    cap = _caps(fanned)
    for elevation in np.linspace(0, 0.5 * np.pi, fan_rows):
        near = fanned[np.abs(cap.elevation_rad - elevation) <= cap.reach_rad]
        up = np.array([0.0, 0.0, np.sin(elevation)])
        rows.append(_cast(near, level * np.cos(elevation) + up))
    folded = float(np.mean([row.folded for row in rows]))
    if folded > _MOST_FOLDED:
        raise ShapeFileError("made.scan.folded", name=name, share=folded)
    return _Rays(np.stack([row.radii_mm for row in rows]), tube_rows, middle, low)


def _require_size(height_mm: float, radius_mm: float, name: str) -> None:
    if _SHORTEST_MM <= height_mm <= _LONGEST_MM and radius_mm <= _WIDEST_MM:
        return
    raise ShapeFileError(
        "made.scan.size",
        name=name,
        height_mm=height_mm,
        radius_mm=radius_mm,
        shortest_mm=_SHORTEST_MM,
        longest_mm=_LONGEST_MM,
        widest_mm=_WIDEST_MM,
    )


class _RowHits(NamedTuple):
    """What the rays of one row hit."""

    radii_mm: Float64[np.ndarray, " columns"]
    folded: Bool[np.ndarray, " columns"]
    """Rays that leave the shape at two places more than `_FOLD_MM` apart."""


def _cast(
    corners: Float64[np.ndarray, "n 3 3"], rays: Float64[np.ndarray, "columns 3"]
) -> _RowHits:
    """The outermost crossing at which each ray from the origin leaves the surface.

    A ray leaves through a triangle a, b, c that is counter-clockwise seen from outside where all of
    ray . (b x c), ray . (c x a) and ray . (a x b) are positive.
    """
    if len(corners) == 0:
        return _RowHits(np.full(len(rays), np.nan), np.zeros(len(rays), bool))
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = [np.cross(one, other) for one, other in ((b, c), (c, a), (a, b))]
    volume = (a * sides[0]).sum(1)
    on = [_dots(rays, side) for side in sides]
    total = on[0] + on[1] + on[2]
    slack = -1e-9 * np.abs(total)
    leaves = (on[0] >= slack) & (on[1] >= slack) & (on[2] >= slack) & (total > 0) & (volume > 0)
    far = np.divide(volume, total, out=np.full(total.shape, np.nan), where=leaves)
    farthest, nearest = np.fmax.reduce(far, axis=1), np.fmin.reduce(far, axis=1)
    return _RowHits(farthest, np.nan_to_num(farthest - nearest) > _FOLD_MM)


def _dots(
    rays: Float64[np.ndarray, "columns 3"], sides: Float64[np.ndarray, "n 3"]
) -> Float64[np.ndarray, "columns n"]:
    """Dot product of each ray with each side; written out, as sums over three terms are slower."""
    (x, y, z), (u, v, w) = rays.T[:, :, None], sides.T
    return x * u + y * v + z * w


class _Caps(NamedTuple):
    """Spherical cap of directions that bounds each triangle, seen from the origin."""

    elevation_rad: Float64[np.ndarray, " n"]
    """Of its centre."""
    reach_rad: Float64[np.ndarray, " n"]
    """Its angular radius."""


def _caps(corners: Float64[np.ndarray, "n 3 3"]) -> _Caps:
    distances = np.maximum(np.linalg.norm(corners, axis=2, keepdims=True), 1e-9)
    directions = corners / distances
    centre = directions.sum(1)
    length = np.linalg.norm(centre, axis=1)
    centre /= np.maximum(length, 1e-9)[:, None]
    least_cosine = (directions * centre[:, None]).sum(2).min(1)
    reach = np.arccos(np.clip(least_cosine, -1.0, 1.0)) + 1e-6
    unbounded = (length < 1e-6) | (reach >= 0.5 * np.pi)
    reach[unbounded] = np.pi
    return _Caps(np.arcsin(np.clip(centre[:, 2], -1.0, 1.0)), reach)


@dataclass(frozen=True, kw_only=True)
class _Rings:
    """Rings of radii without holes."""

    radii_mm: Float64[np.ndarray, "rows columns"]
    tube_rows: int
    tube_mm: float
    cut_mm: float
    """Height of the rows of the open end that were left out."""
    missing: float
    """Share of the radii that was filled."""


def _rings(rays: _Rays, edge_mm: float, name: str) -> _Rings:
    """Radii with ragged rows left out, holes filled and facets smoothed.

    Raises:
        ShapeFileError: too much is missing, or a hole is too wide.
    """
    first = _first_whole_row(rays)
    radii = rays.radii_mm[first:]
    tube_rows = rays.tube_rows - first
    known = np.isfinite(radii)
    missing = 1.0 - float(known.mean())
    if missing > _MOST_MISSING:
        raise ShapeFileError("made.scan.holes", name=name, share=missing, most_share=_MOST_MISSING)
    filled = _filled(radii, known)
    shape = _Rings(
        radii_mm=_smoothed(filled, edge_mm),
        tube_rows=tube_rows,
        tube_mm=tube_rows * _STEP_MM,
        cut_mm=rays.middle_mm - tube_rows * _STEP_MM - rays.lowest_mm,
        missing=missing,
    )
    steep = _steep(shape)
    if steep > _MOST_STEEP:
        raise ShapeFileError("made.scan.steep", name=name, share=steep)
    if missing > 0:
        points = _points(shape)
        off, _ = KDTree(points[known]).query(points[~known])
        wide_mm = 2 * float(np.max(off))
        if wide_mm > _WIDEST_HOLE_MM:
            raise ShapeFileError(
                "made.scan.hole", name=name, wide_mm=wide_mm, most_mm=_WIDEST_HOLE_MM
            )
    return shape


def _first_whole_row(rays: _Rays) -> int:
    """The lowest row that is as complete as those above it, and not narrower than half of them."""
    tube = rays.radii_mm[: rays.tube_rows]
    met = np.isfinite(tube).mean(1)
    wide = np.nan_to_num(np.nanmean(np.where(met[:, None] > 0, tube, 0.0), axis=1))
    whole = (met >= min(0.995, float(np.median(met)))) & (wide >= 0.5 * wide.max())
    return min(int(np.argmax(whole)), rays.tube_rows - 2)


def _filled(
    radii_mm: Float64[np.ndarray, "rows columns"], known: Bool[np.ndarray, "rows columns"]
) -> Float64[np.ndarray, "rows columns"]:
    """Radii with holes filled so that the sum of squared second differences is least."""
    if known.all():
        return radii_mm
    rows, columns = radii_mm.shape
    ids = np.arange(rows * columns).reshape(rows, columns)
    triples = [
        (np.roll(ids, 1, 1), ids, np.roll(ids, -1, 1)),
        (ids[:-2], ids[1:-1], ids[2:]),
    ]
    before, at, after = (np.concatenate([one[k].ravel() for one in triples]) for k in range(3))
    count = len(at)
    weights = np.repeat([1.0, -2.0, 1.0], count)
    row, column = np.tile(np.arange(count), 3), np.concatenate([before, at, after])
    second_differences = csc_array(coo_array((weights, (row, column)), (count, rows * columns)))
    unknown, given = np.flatnonzero(~known), np.flatnonzero(known)
    free = csc_array(second_differences[:, unknown])
    held = second_differences[:, given] @ radii_mm.ravel()[given]
    filled = radii_mm.copy().ravel()
    filled[unknown] = spsolve(csc_array(free.T @ free), -(free.T @ held))
    return filled.reshape(rows, columns)


def _smoothed(
    radii_mm: Float64[np.ndarray, "rows columns"], edge_mm: float
) -> Float64[np.ndarray, "rows columns"]:
    """Radii smoothed over half an edge of the file's triangles; the pole is one point."""
    sigma = min(0.5 * edge_mm, _MOST_SMOOTHING_MM) / _STEP_MM
    along = gaussian_filter1d(radii_mm, sigma, axis=0, mode="nearest")
    smooth = gaussian_filter1d(along, sigma, axis=1, mode="wrap")
    smooth[-1] = smooth[-1].mean()
    return smooth


def _steep(rings: _Rings) -> float:
    """Share of steps from ray to ray that are steeper than `_STEEPEST`."""
    radii = rings.radii_mm
    rows, columns = radii.shape
    around = np.abs(radii - np.roll(radii, 1, axis=1))[:-1] / (radii[:-1] * 2 * np.pi / columns)
    fan_rad = 0.5 * np.pi / (rows - rings.tube_rows - 1)
    step = np.full((rows - 1, 1), _STEP_MM) * np.ones(columns)
    step[rings.tube_rows :] = radii[rings.tube_rows + 1 :] * fan_rad
    along = np.abs(np.diff(radii, axis=0)) / step
    # Towards the pole columns converge, and a step round it is foreshortened.
    around[rings.tube_rows :] *= np.cos(np.arange(rows - 1 - rings.tube_rows) * fan_rad)[:, None]
    return float(np.mean((around > _STEEPEST) | (along > _STEEPEST)))


def _points(rings: "_Rings | Scan") -> Float64[np.ndarray, "rows columns 3"]:
    rows, columns = rings.radii_mm.shape
    away, height = _placed(rings, np.arange(rows, dtype=float)[:, None], rings.radii_mm)
    angle = 2 * np.pi * np.arange(columns) / columns
    return np.stack([away * np.cos(angle), away * np.sin(angle), height], -1)


def _placed(
    rings: "_Rings | Scan", row: Float64[np.ndarray, "..."], radii_mm: Float64[np.ndarray, "..."]
) -> tuple[Float64[np.ndarray, "..."], Float64[np.ndarray, "..."]]:
    """Distance from the axis and height above the lowest row of radii at these rows."""
    fan = len(rings.radii_mm) - rings.tube_rows - 1
    elevation = np.clip((row - rings.tube_rows) / fan, 0.0, 1.0) * 0.5 * np.pi
    start = np.minimum(row / rings.tube_rows, 1.0) * rings.tube_mm
    return radii_mm * np.cos(elevation), start + radii_mm * np.sin(elevation)
