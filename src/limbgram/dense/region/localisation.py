"""Localisation: where in the scene the limb is.

In      the photos (for their masks), a MetricScene.
Out     a Region: cubes that hold the limb's surface with a margin.
Method  the sparse points that most photos look at, above the floor and within the photos' masks,
        are linked into clusters by their own spacing; the cluster that the cameras aim at is the
        limb. Its hollows and unseen sides are closed, and it is widened by a margin.
Fails   RegionError: too few points where the cameras look, or two objects that could be meant.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limbgram.dense.region.clusters import LimbPoints, limb_among, link_length
from limbgram.dense.region.cubes import Region
from limbgram.dense.region.filling import down_to_floor, solid
from limbgram.dense.region.masking import MaskedView, carve, inside_masks, masked_views
from limbgram.errors import OptionsError, RegionError
from limbgram.geometry.arrays import Points3
from limbgram.photos.photo import PhotoSet
from limbgram.scale.metric import MetricScene
from limbgram.scale.sight import Aim, aim_of, in_frame

LEAST_POINTS = 60
_NEAR = 2.0
"""Points farther from the aim than this many half frames are not the limb's."""
_DECIDING_SHARE = 0.5
"""Where this share of the placed photos has masks, they alone say what the limb is."""
_MOST_CLOSING = 0.15
"""Hollows wider than twice this share of the limb's longest side are never bridged."""
_UNDERSIDE = 0.07
"""How far below its lowest points the limb is expected, as a fraction of its longest side."""

_FLATTEST = 0.08
"""Spread of the limb's points across, as a fraction of the spread along."""


@dataclass(frozen=True, kw_only=True)
class RegionOptions:
    """Where to look for the limb; lengths are in the scene's unit, mm once it is metric."""

    box_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    """Two opposite corners of a box in the world: it is taken as the region as it is."""
    cubes: int = 80
    """Cubes along the limb's longest side."""
    margin: float = 0.03
    """How far the region is widened, as a fraction of the limb's longest side."""
    floor_clearance: float = 0.025
    """What counts as floor: this far above its plane, as a fraction of half the frame's side."""
    least_views: float = 0.6
    """Share of the photos that must have a point in their frame for it to count."""


DEFAULTS = RegionOptions()


def find_region(photos: PhotoSet, metric: MetricScene, options: RegionOptions = DEFAULTS) -> Region:
    """The part of the world that is the limb."""
    if options.box_mm is not None:
        return _from_box(options.box_mm, options.cubes)
    masked = masked_views(photos, metric.scene)
    masks_decide = len(masked) >= _DECIDING_SHARE * len(metric.scene.placed)
    floor_z_mm = None if masks_decide else metric.floor_z_mm
    aim = aim_of(metric.scene.views, metric.scene.points_in_world)
    candidates = _points_looked_at(metric, aim, masked, floor_z_mm, options)
    if masks_decide:
        limb = LimbPoints(candidates, link_length(candidates))
    else:
        limb = limb_among(candidates, aim, LEAST_POINTS)

    _refuse_flat(limb.points_mm)
    size_mm = float(np.ptp(limb.points_mm, axis=0).max())
    margin_mm = options.margin * size_mm
    closing_mm = min(limb.link_mm, _MOST_CLOSING * size_mm)
    region = solid(limb.points_mm, closing_mm, margin_mm, size_mm / options.cubes)
    if floor_z_mm is not None:
        region = down_to_floor(region, _UNDERSIDE * size_mm, floor_z_mm)
    return carve(region, masked, margin_mm) if masked else region


def _points_looked_at(
    metric: MetricScene,
    aim: Aim,
    masked: tuple[MaskedView, ...],
    floor_z_mm: float | None,
    options: RegionOptions,
) -> Points3:
    """Sparse points near the aim, in most frames, inside the masks and off the floor."""
    points = metric.scene.points_in_world
    usable = np.linalg.norm(points - aim.point, axis=1) < _NEAR * aim.reach
    usable &= in_frame(metric.scene.views, points).mean(0) >= options.least_views
    if floor_z_mm is not None:
        usable &= points[:, 2] > floor_z_mm + options.floor_clearance * aim.reach
    if masked:
        usable &= inside_masks(masked, points, slack_mm=0.0)
    if usable.sum() < LEAST_POINTS:
        raise RegionError(
            f"Only {usable.sum()} scene points lie where the photos look, above the floor and "
            f"within the masks; {LEAST_POINTS} are needed to tell the limb from its "
            "surroundings. Aim all photos at the limb, paint it more densely, or give a box or "
            "photo masks."
        )
    return points[usable]


def _refuse_flat(points_mm: Points3) -> None:
    """A sheet or a table top is no limb: better no surface than that one."""
    spreads = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(points_mm.T)), 0))
    if spreads[0] < _FLATTEST * spreads[2]:
        raise RegionError(
            "What the photos look at is flat: a table or a printed sheet was taken for the limb. "
            "Lay a scale board beside the limb, so that the floor is known, or give a box or "
            "photo masks."
        )


def _from_box(corners: Sequence[tuple[float, float, float]], cubes: int) -> Region:
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    if not np.all(np.isfinite(high - low)) or np.any(high - low <= 0):
        raise OptionsError(
            f"The box from {tuple(corners[0])} to {tuple(corners[1])} has no volume. Give two "
            "opposite corners as x, y, z in millimetres."
        )
    cell_mm = float((high - low).max()) / cubes
    shape = np.maximum(1, np.ceil((high - low) / cell_mm - 1e-9)).astype(int)
    return Region(origin_mm=low, cell_mm=cell_mm, occupied=np.ones(shape, bool))
