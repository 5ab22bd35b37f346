"""Limb in photos: where it lies in each, and how sharp, exposed and textured it is there.

In      the photos at full size, small copies of them, and the scene that these gave.
Out     each photo with its figures on the limb, not on the room.
Fails   RegionError: too few points lie where the photos look, or two objects could be meant.
"""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int64

from limbgram.core.geometry.arrays import GreyImage, Points3
from limbgram.core.run import in_parallel
from limbgram.reconstruction.dense.region import (
    FLOOR_CLEARANCE,
    aimed_at,
    limb_among,
    refuse_few,
)
from limbgram.reconstruction.features.detection import (
    Features,
)
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.masks import load_mask
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.photos.quality import (
    brightest_luma,
    burnt_share,
    edge_width_px,
    exposure_mask,
)
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.visibility import aim_of

_FEWEST_LIMB_POINTS = 50
_ABOVE_FLOOR_MM = 3.0
_BLOCKS_ACROSS = 240
_SAME_BOX = 0.05
"""Of its sides: a limb that lies no further off in a photo than this was looked at already."""
_LOOKING_BYTES = 40
"""Bytes a pixel while the sharpness of a part of a photo is looked at."""


@dataclass(frozen=True)
class InspectedPhoto:
    """A photo with its sharpness, exposure and texture where the limb lies in it."""

    photo: Photo
    placed: bool
    features_per_cm2: float
    slopes: "Slopes | None" = None


@dataclass(frozen=True)
class Slopes:
    """Mean square of the grey slope in blocks of a full-size photo, grey levels a pixel."""

    energy: Float32[np.ndarray, "h w"]
    block_px: tuple[float, float]
    """Width and height of a block, full-size pixels."""

    @classmethod
    def of(cls, luma: GreyImage) -> "Slopes":
        across = cv2.Sobel(luma, cv2.CV_32F, 1, 0, ksize=1, scale=0.5)
        down = cv2.Sobel(luma, cv2.CV_32F, 0, 1, ksize=1, scale=0.5)
        height, width = luma.shape
        side_px = max(1.0, width / _BLOCKS_ACROSS)
        columns, rows = max(1, round(width / side_px)), max(1, round(height / side_px))
        energy = cv2.resize(
            across * across + down * down, (columns, rows), interpolation=cv2.INTER_AREA
        )
        block_px = width / columns, height / rows
        return cls(cv2.blur(energy, (3, 3)).astype(np.float32), block_px)

    def at(self, xy_px: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, " n"]:
        """RMS grey slope round full-size pixels; 0 outside the photo."""
        rows, columns = self.energy.shape
        known = np.isfinite(xy_px).all(axis=1)
        x, y = (np.where(known, xy_px.T, -1.0) + 0.5) / np.array(self.block_px)[:, None]
        inside = known & (x >= 0) & (y >= 0) & (x < columns) & (y < rows)
        # beside the lens a place may lie farther off than an integer holds
        row, column = np.clip(y, 0, rows - 1).astype(int), np.clip(x, 0, columns - 1).astype(int)
        return np.where(inside, np.sqrt(self.energy[row, column].astype(np.float64)), 0.0)


@dataclass(frozen=True)
class InspectionCache:
    """Results kept of a full-size photo, so that it need not be decoded again for the same box."""

    box: tuple[int, int, int, int]
    seen: Photo
    slopes: Slopes


def known_by(small: Photo) -> str:
    """Key of what is known of a photo: its content, its reduced copy, and the mask of that.

    A copy of a photo of sixteen bits a sample is made anew once another photo uses more of them.
    """
    return f"{small.sha256} {small.path} {small.mask_path or ''}"


def limb_points(metric: MetricScene) -> Int64[np.ndarray, " n"]:
    """Which scene points lie on the object that the cameras aim at, above the floor.

    Raises:
        RegionError: too few points lie where the photos look, or two objects could be meant.
    """
    scene = metric.scene
    points = scene.points_in_world
    aim = aim_of(scene.views, points)
    usable = aimed_at(scene, aim)  # as the reconstruction will ask
    if metric.floor_z_mm is not None:
        # without a size there is no board either, and the floor's own points lie about its plane
        in_mm = metric.scale.unit == "mm"
        above = _ABOVE_FLOOR_MM if in_mm else FLOOR_CLEARANCE * aim.reach
        usable &= points[:, 2] > metric.floor_z_mm + above
    refuse_few(int(usable.sum()), _FEWEST_LIMB_POINTS)
    return np.flatnonzero(usable)[limb_among(points[usable], aim, _FEWEST_LIMB_POINTS).chosen]


def inspect_limb(
    photos: PhotoSet,
    small: PhotoSet,
    features: Features,
    metric: MetricScene,
    limb: Points3,
    known: dict[str, "InspectionCache"],
) -> list[InspectedPhoto]:
    """Sharpness and exposure at full size where the limb lies, and how dense its texture is.

    Args:
        known: What was seen earlier, by `known_by`; it is added to.
    """
    scene = metric.scene

    def inspect(idx: int) -> InspectedPhoto:
        photo = photos.photos[idx]
        if scene.camera_from_world[idx] is None:
            return InspectedPhoto(photo, False, math.nan)
        view = scene.view(idx)
        xy_px = view.project(limb)
        inside = np.isfinite(xy_px).all(axis=1) & view.camera.contains(xy_px)
        if inside.sum() < 3:
            return InspectedPhoto(photo, True, math.nan)
        hull = cv2.convexHull(xy_px[inside].astype(np.float32))
        factor = photo.width_px / small.photos[idx].width_px
        left, top, width, height = (
            round(side * factor) for side in cv2.boundingRect(np.round(hull).astype(np.int32))
        )
        box = (max(left, 0), max(top, 0), left + width, top + height)
        key = known_by(small.photos[idx])
        looked = known.get(key)
        if looked is None or not _nearly_same_box(looked.box, box):
            looked = known[key] = _at_full_size(photo, (hull + 0.5) * factor - 0.5, box)
        seen = replace(
            photo,
            sharpness=looked.seen.sharpness,
            burnt=looked.seen.burnt,
            brightest=looked.seen.brightest,
        )
        within = [
            cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0
            for x, y in features.keypoints[idx].xy_px
        ]
        density = math.nan
        if metric.scale.unit == "mm":
            away_mm = float(np.linalg.norm(view.centre_in_world - np.median(limb, axis=0)))
            pixel_cm = 0.1 * away_mm / view.camera.fx
            density = sum(within) / max(cv2.contourArea(hull) * pixel_cm**2, 1e-9)
        return InspectedPhoto(seen, True, density, looked.slopes)

    each_mb = in_flight_mb(photos.photos, _LOOKING_BYTES)
    return in_parallel(inspect, range(len(photos.photos)), each_mb=each_mb)


def _at_full_size(
    photo: Photo, hull_px: Float32[np.ndarray, "h 1 2"], box: tuple[int, int, int, int]
) -> InspectionCache:
    """Sharpness and exposure inside the outline of the limb's points."""
    luma, mask = load_luma(photo), load_mask(photo)
    limb_at = np.zeros(luma.shape, np.uint8)
    cv2.fillConvexPoly(limb_at, np.round(hull_px).astype(np.int32), 1)
    # the outline of a bent limb spans a part of what lies behind it
    on_limb = limb_at > 0
    where = on_limb & exposure_mask(luma, mask)
    part = slice(box[1], box[3]), slice(box[0], box[2])
    seen = replace(
        photo,
        sharpness=edge_width_px(luma[part], None if mask is None else mask[part], on_limb[part]),
        burnt=burnt_share(luma[part], where[part]),
        brightest=brightest_luma(luma[part], where[part]),
    )
    return InspectionCache(box, seen, Slopes.of(luma))


def _nearly_same_box(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> bool:
    """Whether two boxes (left, top, right, bottom) hold nearly the same."""
    sides = max(one[2] - one[0], 1), max(one[3] - one[1], 1)
    return all(abs(one[k] - other[k]) <= _SAME_BOX * sides[k % 2] for k in range(4))
