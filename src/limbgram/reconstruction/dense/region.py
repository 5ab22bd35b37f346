"""The region: the part of the world that is the limb.

In      the photos (for their masks), a MetricScene.
Out     a Region: cubes that hold the limb's surface with a margin; its footprint in each photo,
        which pixels can show it and between which depths.
Method  The sparse points that most photos look at, above the floor and within the photos' masks,
        are linked into clusters by their own spacing; the cluster that the cameras aim at is the
        limb. Its hollows and unseen sides are closed, and it is widened by a margin.
Fails   RegionError: too few points where the cameras look, or two objects that could be meant.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Float64, Int32
from scipy import ndimage
from scipy.spatial import KDTree

from limbgram.core.errors import OptionsError, RegionError
from limbgram.core.geometry.arrays import Mask, Points3, Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.kernels import njit
from limbgram.core.mesh.topology import components
from limbgram.core.run import track
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.visibility import Aim, aim_of, in_frame

_NEIGHBOURS = 6
_LINK_FACTOR = 3.0
"""Points are linked up to this many times their median distance to the sixth neighbour."""
_ATTACH_FACTOR = 2.0
"""Points within this many links of the limb and of each other are thinly covered
parts of it."""
_ATTACH_NEIGHBOURS = 3
"""Other such points that each of them needs round it."""
_WIDENINGS = (1.0, 2.0, 4.0)
_LEAST_LINK = 0.04
"""Gaps narrower than this share of the reach part nothing, however densely points lie."""
_MOST_LINK = 0.15
"""Longest link over a gap, in half frames."""
_RIVAL_SHARE = 0.6
"""A second object of more than this share of the first one's weight makes the choice ambiguous."""


@dataclass(frozen=True)
class LimbPoints:
    """Sparse points of the limb, and the gap over which they are one object."""

    points_mm: Points3
    link_mm: float
    chosen: Bool[np.ndarray, " all"]
    """Which of all the points that were asked about."""


def link_length(points: Points3) -> float:
    """Distance up to which neighbours on one surface are linked, from the points' own spacing."""
    distances = KDTree(points).query(points, k=_NEIGHBOURS + 1)[0]
    return _LINK_FACTOR * float(np.median(distances[:, -1]))


def limb_among(points: Points3, aim: Aim, least_points: int, gap_mm: float = 0.0) -> LimbPoints:
    """The points of the object that the cameras aim at; its pieces may lie `gap_mm` apart.

    Where two parts of similar weight lie apart, points are linked over wider gaps before the
    choice is refused as ambiguous: an object may be painted thinly in its middle.
    """
    spacing = max(link_length(points), _LEAST_LINK * aim.reach, gap_mm)
    off_aim = np.linalg.norm(points - aim.point, axis=1) / aim.reach
    weights = np.exp(-2 * off_aim**2)
    choice = None
    for widening in _WIDENINGS:
        link_mm = min(widening * spacing, max(spacing, _MOST_LINK * aim.reach))
        choice = _heaviest_cluster(points, weights, link_mm)
        if choice.rival_share <= _RIVAL_SHARE * choice.share:
            break
    if choice is None or choice.share == 0.0:
        raise RegionError("limbregion.scattered")
    if choice.rival_share > _RIVAL_SHARE * choice.share:
        raise RegionError(
            "limbregion.two_objects",
            share=float(choice.share),
            rival_share=float(choice.rival_share),
            points=len(points),
        )
    if choice.limb.sum() < least_points:
        raise RegionError(
            "limbregion.few_points", points=int(choice.limb.sum()), least=least_points
        )
    return LimbPoints(points[choice.limb], choice.link_mm, choice.limb)


@dataclass(frozen=True)
class _ClusterChoice:
    """The cluster taken for the limb, and its strongest rival."""

    limb: Bool[np.ndarray, " n"]
    link_mm: float
    share: float
    """Of all clusters' weight: what the limb's own cluster has."""
    rival_share: float
    """The same for the heaviest cluster of which most lies apart from the limb."""


def _heaviest_cluster(
    points: Points3, weights: Float64[np.ndarray, " n"], link_mm: float
) -> _ClusterChoice:
    """The heaviest cluster with its thinly covered parts, and the weight of the next one."""
    labels = clusters(points, link_mm)
    member = labels >= 0
    if not member.any():
        return _ClusterChoice(member, link_mm, 0.0, 0.0)
    shares = np.bincount(labels[member], weights[member]) / weights[member].sum()
    best = int(np.argmax(shares))
    limb = _with_thin_parts(points, labels == best, _ATTACH_FACTOR * link_mm)
    sizes = np.bincount(labels[member])
    attached = np.bincount(labels[member & limb], minlength=len(sizes)) > sizes / 2
    rival_share = float(np.where(attached, 0.0, shares).max())
    return _ClusterChoice(limb, link_mm, float(shares[best]), rival_share)


def clusters(points: Points3, link_mm: float) -> Int32[np.ndarray, " n"]:
    """Cluster of each point, -1 for stray ones: DBSCAN (Ester et al. 1996)."""
    neighbour_counts = np.asarray(
        KDTree(points).query_ball_point(points, link_mm, return_length=True)
    )
    dense = np.flatnonzero(neighbour_counts > _NEIGHBOURS)
    labels = np.full(len(points), -1, np.int32)
    if not len(dense):
        return labels
    pairs = KDTree(points[dense]).query_pairs(link_mm, output_type="ndarray")
    labels[dense] = components(pairs, len(dense))
    return labels


def _with_thin_parts(
    points: Points3, limb: Bool[np.ndarray, " n"], reach_mm: float
) -> Bool[np.ndarray, " n"]:
    """The limb with the points near it that have others of their kind round them."""
    others = np.flatnonzero(~limb)
    if not len(others):
        return limb
    candidates = others[KDTree(points[limb]).query(points[others])[0] <= reach_mm]
    neighbour_counts = KDTree(points[others]).query_ball_point(
        points[candidates], reach_mm, return_length=True
    )
    attached = limb.copy()
    attached[candidates[np.asarray(neighbour_counts) > _ATTACH_NEIGHBOURS]] = True
    return attached


@dataclass(frozen=True, kw_only=True)
class Region:
    """A grid of cubes, true where the limb's surface may be.

    Cube (i, j, k) spans origin_mm + cell_mm * (i..i+1, j..j+1, k..k+1), world axes.
    """

    origin_mm: Vector3
    cell_mm: float
    occupied: Bool[np.ndarray, "i j k"]

    @property
    def box_mm(self) -> tuple[Vector3, Vector3]:
        """Lowest and highest corner of what is occupied."""
        cells = np.argwhere(self.occupied)
        low = self.origin_mm + self.cell_mm * cells.min(0)
        return low, self.origin_mm + self.cell_mm * (cells.max(0) + 1)

    def contains(self, points_mm: Points3) -> Bool[np.ndarray, " n"]:
        """Which points lie in occupied cubes."""
        cells = np.floor((points_mm - self.origin_mm) / self.cell_mm).astype(np.int64)
        inside = np.all((cells >= 0) & (cells < self.occupied.shape), axis=-1)
        cells = np.where(inside[..., None], cells, 0)
        return inside & self.occupied[cells[..., 0], cells[..., 1], cells[..., 2]]

    def centres_mm(self, cells: Bool[np.ndarray, "i j k"]) -> Points3:
        """Centres of the cubes that `cells` marks."""
        return self.origin_mm + self.cell_mm * (np.argwhere(cells) + 0.5)

    def boundary(self) -> Bool[np.ndarray, "i j k"]:
        """Occupied cubes that share a side with an empty one or with the grid's border."""
        return self.occupied & ~ndimage.binary_erosion(self.occupied)

    @cached_property
    def boundary_mm(self) -> Points3:
        """Centres of the boundary's cubes."""
        return self.centres_mm(self.boundary())


_LEAST_PIECE = 0.01
"""Pieces of the region smaller than this share of the largest are noise."""

_LEAST_MARGIN = 1.5
"""In cubes: a point's cube and all that touch its sides and edges."""


def closed_region(points: Points3, radius_mm: float, margin_mm: float, cell_mm: float) -> Region:
    """The region of points, closed with balls of `radius_mm`, filled and widened by the margin.

    It is widened by no less than the nearest ring of cubes, whatever the margin.
    """
    margin_mm = max(margin_mm, _LEAST_MARGIN * cell_mm)
    border_mm = radius_mm + margin_mm + 2 * cell_mm
    origin = points.min(0) - border_mm
    shape = np.ceil((points.max(0) + border_mm - origin) / cell_mm).astype(int)
    seeds = np.zeros(shape, bool)
    seeds[tuple(np.floor((points - origin) / cell_mm).astype(int).T)] = True
    body = _enclosed(_distance_to(seeds) * cell_mm <= radius_mm)
    body = _distance_to(~body) * cell_mm > radius_mm
    occupied = _distance_to(body | seeds) * cell_mm <= margin_mm
    return Region(origin_mm=origin, cell_mm=cell_mm, occupied=_without_islands(occupied))


def extended_to_floor(region: Region, depth_mm: float, floor_z_mm: float) -> Region:
    """The region extended downwards, where hardly a photo sees, and cut at the floor."""
    cells = round(depth_mm / region.cell_mm)
    occupied = np.pad(region.occupied, ((0, 0), (0, 0), (cells, 0)))
    origin = region.origin_mm - (0.0, 0.0, cells * region.cell_mm)
    for _ in range(cells):
        occupied[:, :, :-1] |= occupied[:, :, 1:]
    tops = origin[2] + region.cell_mm * np.arange(1, occupied.shape[2] + 1)
    return Region(origin_mm=origin, cell_mm=region.cell_mm, occupied=occupied & (tops > floor_z_mm))


def _distance_to(cells: Bool[np.ndarray, "i j k"]) -> Float64[np.ndarray, "i j k"]:
    """Distance of each cube's centre from the nearest marked one's, in cubes."""
    return np.asarray(ndimage.distance_transform_edt(~cells))


def _without_islands(occupied: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    """The cubes without pieces that are tiny beside the largest one."""
    labels = np.zeros(occupied.shape, np.int32)
    ndimage.label(occupied, output=labels)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return (sizes > _LEAST_PIECE * sizes.max())[labels]


def _enclosed(body: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    """The body with every cube that it surrounds in five of the six directions of the axes.

    An open brim, a sole that no photo sees and the hollow inside are closed by this.
    """
    sides = np.zeros(body.shape, np.int8)
    for axis in range(3):
        sides += np.maximum.accumulate(body, axis)
        sides += np.flip(np.maximum.accumulate(np.flip(body, axis), axis), axis)
    return body | (sides >= 5)


_REDUCTION = 4
_ALLOWED_OUTSIDE = 0.1
"""Share of the masked photos that may contradict the others: a slip in one mask of many."""


@dataclass(frozen=True)
class MaskedView:
    """A placed photo and how far each of its pixels lies from the mask."""

    view: View
    """Of the photo reduced by _REDUCTION."""
    outside_px: Float32[np.ndarray, "h w"]
    """Distance from the nearest pixel of the limb; 0 on the limb. Reduced pixels."""


def masked_views(photos: PhotoSet, scene: Scene) -> tuple[MaskedView, ...]:
    """The placed photos that have a mask, or were cut out."""
    return tuple(_masked_views(photos, scene))


def _masked_views(photos: PhotoSet, scene: Scene) -> Iterator[MaskedView]:
    for photo_idx in track(scene.placed):
        photo = photos.photos[photo_idx]
        mask = load_mask(photo)
        if mask is not None:
            view = scene.view(photo_idx)
            camera = view.camera.scaled(1 / _REDUCTION)
            reduced = View(view.name, camera, view.camera_from_world)
            yield MaskedView(reduced, _distance_outside(mask, (camera.width_px, camera.height_px)))


def inside_masks(
    masked: tuple[MaskedView, ...], points: Points3, slack_mm: float
) -> Bool[np.ndarray, " n"]:
    """Points that hardly any mask excludes; they may lie `slack_mm` outside it."""
    outside = np.zeros(len(points))
    for one in masked:
        framed = in_frame([one.view], points)[0]
        column, row = np.round(one.view.project(points[framed])).astype(int).T
        depth = one.view.camera_from_world.apply(points[framed])[:, 2]
        slack_px = one.view.camera.fx * slack_mm / depth + 0.5
        outside[framed] += one.outside_px[row, column] > slack_px
    return outside <= _ALLOWED_OUTSIDE * len(masked)


def carve(region: Region, masked: tuple[MaskedView, ...], slack_mm: float) -> Region:
    """The region without the cubes that the masks exclude."""
    slack_mm += region.cell_mm * float(np.sqrt(3)) / 2
    occupied = region.occupied.copy()
    occupied[occupied] = inside_masks(masked, region.centres_mm(region.occupied), slack_mm)
    return Region(origin_mm=region.origin_mm, cell_mm=region.cell_mm, occupied=occupied)


def _distance_outside(mask: Mask, size: tuple[int, int]) -> Float32[np.ndarray, "rows columns"]:
    touched = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0
    distance = cv2.distanceTransform(
        (~touched).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
    )
    # OpenCV's last digit depends on where in memory the mask lies; squares of distances are whole.
    return np.sqrt(np.rint(np.square(distance, dtype=np.float64))).astype(np.float32)


LEAST_POINTS = 60
_MOST_AIM_DISTANCE = 2.0
"""Points farther from the aim than this many half frames are not of the limb."""
_MASKED_SHARE = 0.5
"""Where this share of the placed photos has masks, they alone say what the limb is."""
_MOST_CLOSING = 0.15
"""Hollows wider than twice this share of the limb's longest side are never bridged."""
_UNDERSIDE = 0.07
"""How far below its lowest points the limb is expected, as a fraction of its longest side."""

_FLATTEST = 0.08
"""Spread of the limb's points across, as a fraction of the spread along."""


_MARGIN = 0.03
"""How far the region is widened, as a fraction of the limb's longest side."""


FLOOR_CLEARANCE = 0.025
"""What counts as floor: this far above its plane, as a fraction of half the frame's side."""
_LEAST_VIEWS = 0.6
"""Share of the photos that must have a point in their frame for it to count."""


@dataclass(frozen=True, kw_only=True)
class RegionOptions:
    """Where to look for the limb; lengths are in the scene's unit, mm once it is metric."""

    box_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    """Two opposite corners of a box in the world: it is taken as the region as it is."""
    gap_mm: float = 0.0
    """Pieces of one object may lie so far apart, as the spheres of a ball bar do."""


DEFAULTS = RegionOptions()
_CUBES = 80
"""Along the limb's longest side."""


def find_region(photos: PhotoSet, metric: MetricScene, options: RegionOptions = DEFAULTS) -> Region:
    """The part of the world that is the limb."""
    if options.box_mm is not None:
        return _from_box(options.box_mm)
    masked = masked_views(photos, metric.scene)
    masks_decide = len(masked) >= _MASKED_SHARE * len(metric.scene.placed)
    floor_z_mm = None if masks_decide else metric.floor_z_mm
    aim = aim_of(metric.scene.views, metric.scene.points_in_world)
    candidates = _points_looked_at(metric, aim, masked, floor_z_mm)
    if masks_decide:
        limb = LimbPoints(candidates, link_length(candidates), np.ones(len(candidates), bool))
    else:
        limb = limb_among(candidates, aim, LEAST_POINTS, options.gap_mm)

    _refuse_flat(limb.points_mm)
    size_mm = float(np.ptp(limb.points_mm, axis=0).max())
    margin_mm = _MARGIN * size_mm
    closing_mm = min(limb.link_mm, _MOST_CLOSING * size_mm)
    region = closed_region(limb.points_mm, closing_mm, margin_mm, size_mm / _CUBES)
    if floor_z_mm is not None:
        region = extended_to_floor(region, _UNDERSIDE * size_mm, floor_z_mm)
    return carve(region, masked, margin_mm) if masked else region


def _points_looked_at(
    metric: MetricScene,
    aim: Aim,
    masked: tuple[MaskedView, ...],
    floor_z_mm: float | None,
) -> Points3:
    """Sparse points near the aim, in most frames, inside the masks and off the floor."""
    points = metric.scene.points_in_world
    usable = aimed_at(metric.scene, aim)
    if floor_z_mm is not None:
        usable &= points[:, 2] > floor_z_mm + FLOOR_CLEARANCE * aim.reach
    if masked:
        usable &= inside_masks(masked, points, slack_mm=0.0)
    refuse_few(int(usable.sum()), LEAST_POINTS)
    return points[usable]


def aimed_at(scene: Scene, aim: Aim) -> Bool[np.ndarray, " n"]:
    """Scene points near the aim that most photos have in their frames."""
    points = scene.points_in_world
    near = np.linalg.norm(points - aim.point, axis=1) < _MOST_AIM_DISTANCE * aim.reach
    return near & (in_frame(scene.views, points).mean(0) >= _LEAST_VIEWS)


def refuse_few(points: int, needed: int) -> None:
    """Refuse a scene of which too little can be the limb."""
    if points < needed:
        raise RegionError("limbregion.few_in_view", points=int(points), least=needed)


def _refuse_flat(points_mm: Points3) -> None:
    """Refuse points that lie in a plane: a sheet or a table top is no limb."""
    spreads = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(points_mm.T)), 0))
    if spreads[0] < _FLATTEST * spreads[2]:
        raise RegionError("limbregion.flat")


def _from_box(corners: Sequence[tuple[float, float, float]]) -> Region:
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    if not np.all(np.isfinite(high - low)) or np.any(high - low <= 0):
        low_mm, high_mm = (tuple(map(float, corner)) for corner in corners)
        raise OptionsError("limbregion.box_empty", low_mm=low_mm, high_mm=high_mm)
    cell_mm = float((high - low).max()) / _CUBES
    shape = np.maximum(1, np.ceil((high - low) / cell_mm - 1e-9)).astype(int)
    return Region(origin_mm=low, cell_mm=cell_mm, occupied=np.ones(shape, bool))


_DISC_SCALE = 1.1
"""How much larger a cube's disc is drawn than a pinhole images it: slant and lens distortion."""


@dataclass(frozen=True, kw_only=True)
class Footprint:
    """What a region covers in one reduced photo: a crop of pixels with depth bounds.

    Pixel (row r, column c) of the arrays is pixel (x0 + c, y0 + r) of the photo reduced by the
    factor that was asked for. No surface inside the region projects outside the mask, nor lies
    outside the bounds; both may be a cube too wide.
    """

    x0: int
    y0: int
    mask: Mask
    near_mm: Float32[np.ndarray, "h w"]
    """Least depth along the camera's z axis; NaN outside the mask."""
    far_mm: Float32[np.ndarray, "h w"]
    """Largest depth along the camera's z axis; NaN outside the mask."""

    def shows(self, xy_px: Float[np.ndarray, "k 2"]) -> Bool[np.ndarray, " k"]:
        """Which places of the reduced photo, to the nearest pixel, lie in the mask."""
        at = np.rint(xy_px).astype(np.int64) - (self.x0, self.y0)
        rows, columns = self.mask.shape
        within = (at >= 0).all(1) & (at < (columns, rows)).all(1)
        shown = np.zeros(len(at), bool)
        shown[within] = self.mask[at[within, 1], at[within, 0]]
        return shown


def footprint(region: Region, view: View, factor: float = 1.0) -> Footprint:
    """The crop of a photo, reduced by `factor`, that shows the region.

    A region that the photo does not show gives a crop of no pixels.
    """
    camera = view.camera.scaled(factor)
    in_camera = view.camera_from_world.apply(region.boundary_mm)
    radius_mm = region.cell_mm * np.sqrt(3) / 2
    xy_px, depth_mm = camera.project(in_camera), in_camera[:, 2]
    shown = np.isfinite(xy_px).all(axis=1) & (depth_mm > 2 * radius_mm)
    xy_px, depth_mm = xy_px[shown], depth_mm[shown]
    radius_px = _DISC_SCALE * max(camera.fx, camera.fy) * radius_mm / (depth_mm - radius_mm) + 0.5

    seen = np.all(xy_px + radius_px[:, None] >= 0, axis=1) & np.all(
        xy_px - radius_px[:, None] <= (camera.width_px - 1, camera.height_px - 1), axis=1
    )
    if not seen.any():
        nothing = np.zeros((0, 0), np.float32)
        return Footprint(x0=0, y0=0, mask=nothing > 0, near_mm=nothing, far_mm=nothing)

    discs = np.column_stack([xy_px, radius_px, depth_mm])[seen]
    low = np.floor((discs[:, :2] - discs[:, 2:3]).min(0)).astype(int)
    high = np.ceil((discs[:, :2] + discs[:, 2:3]).max(0)).astype(int) + 1
    x0, y0 = np.maximum(low, 0)
    width, height = np.minimum(high, (camera.width_px, camera.height_px)) - (x0, y0)
    near = np.full((height, width), np.inf, np.float32)
    far = np.full((height, width), -np.inf, np.float32)
    discs[:, :2] -= (x0, y0)
    _draw_discs(discs, radius_mm, near, far)
    mask = far > 0
    near[~mask] = far[~mask] = np.nan
    return Footprint(x0=int(x0), y0=int(y0), mask=mask, near_mm=near, far_mm=far)


@njit(cache=True, nogil=True)
def _draw_discs(
    discs: Float64[np.ndarray, "n 4"],
    radius_mm: float,
    near: Float32[np.ndarray, "h w"],
    far: Float32[np.ndarray, "h w"],
) -> None:
    """Widen near and far by each cube's disc: x, y and radius in pixels, depth in mm."""
    height, width = near.shape
    for k in range(len(discs)):
        x, y, radius, depth = discs[k, 0], discs[k, 1], discs[k, 2], discs[k, 3]
        first = max(0, int(np.ceil(y - radius)))
        last = min(height - 1, int(np.floor(y + radius)))
        for row in range(first, last + 1):
            reach = np.sqrt(max(0.0, radius * radius - (row - y) * (row - y)))
            left = max(0, int(np.ceil(x - reach)))
            right = min(width - 1, int(np.floor(x + reach)))
            for column in range(left, right + 1):
                near[row, column] = min(near[row, column], np.float32(depth - radius_mm))
                far[row, column] = max(far[row, column], np.float32(depth + radius_mm))
