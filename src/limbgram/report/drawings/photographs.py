"""Drawings on photographs: feature points, and the matches of a pair."""

from typing import TYPE_CHECKING

import cv2
import numpy as np
from jaxtyping import UInt8

from limbgram.core.geometry.arrays import ColourImage, Points2
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.photos.decoding import halvings_to, load_colour
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.report.drawings.drawing import BLUE, GREEN, ORANGE, Drawing, blank

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN_WIDTH_PX = 1100
_SHOWN_MATCHES = 150
_GAP_PX = 16
_SHOWN_KEYPOINTS = 4000
_FAVOURED_ANGLE_DEG = 20.0


def keypoints_on_photo(photos: PhotoSet, features: Features, metric: MetricScene) -> Drawing:
    """All feature points of the photo that gave most points to the scene."""
    from matplotlib.collections import EllipseCollection

    points = [verdict.points for verdict in metric.scene.verdicts]
    idx = int(np.argmax(points))
    photo, keypoints = photos.photos[idx], features.keypoints[idx]
    image, xy_px = _upright(photo, keypoints.xy_px.astype(float))
    height, width = image.shape[:2]
    figure = blank(10, 10 * height / width)
    axes = _picture(figure.subplots(), image)
    step = max(1, len(keypoints) // _SHOWN_KEYPOINTS)
    diameters = 4.0 * keypoints.scale_px[::step] * width / _stored_width(photo)
    axes.add_collection(
        EllipseCollection(
            diameters,
            diameters,
            np.zeros(len(diameters)),
            offsets=xy_px[::step],
            units="xy",
            offset_transform=axes.transData,
            facecolors="none",
            edgecolors=ORANGE,
            linewidths=0.5,
        )
    )
    return Drawing(
        figure,
        f"{len(keypoints):,} SIFT feature points on {photo.name}{drawn_part(step)}; a circle's "
        f"size is the feature's. {points[idx]:,} of them became points of the scene.",
    )


def drawn_part(step: int) -> str:
    """Which of the points are drawn, behind their number; empty where all are."""
    return "" if step == 1 else f" (one in {step} is drawn)"


def matches_of_pair(photos: PhotoSet, pairs: Pairs) -> Drawing:
    """Matches of one well-joined pair, side by side."""
    from matplotlib.collections import LineCollection

    if not pairs.verified:
        return Drawing(blank(10, 1), "No pair of photos could be joined.")
    pair = max(pairs.verified, key=_instructive)
    first, second = photos.photos[pair.matches.first], photos.photos[pair.matches.second]
    left, from_px = _upright(first, pair.matches.xy_first_px)
    right, to_px = _upright(second, pair.matches.xy_second_px)
    both, offset_px = _side_by_side(left, right)
    to_px = to_px + np.array([offset_px, 0])
    figure = blank(10, 10 * both.shape[0] / both.shape[1])
    axes = _picture(figure.subplots(), both)
    step = max(1, len(pair.matches) // _SHOWN_MATCHES)
    lines = list(np.stack([from_px, to_px], axis=1)[::step])
    axes.add_collection(LineCollection(lines, colors=GREEN, linewidths=0.5, alpha=0.7))
    for xy_px in (from_px, to_px):
        axes.plot(*xy_px.T, ".", color=BLUE, ms=1.2)
        axes.plot(*xy_px[::step].T, ".", color=GREEN, ms=3)
    return Drawing(
        figure,
        f"{len(pair.matches):,} matches between {first.name} and {second.name} that obey one "
        f"epipolar geometry (residual {pair.rms_residual_px:.3f} px, rays meet at "
        f"{pair.median_angle_deg:.1f} degrees); {len(lines)} of them are joined by lines.",
    )


def _side_by_side(
    left: ColourImage, right: UInt8[np.ndarray, "h2 w2 3"]
) -> tuple[UInt8[np.ndarray, "rows columns 3"], int]:
    """Two pictures on white, and where the right one begins."""
    offset_px = left.shape[1] + _GAP_PX
    height, width = max(left.shape[0], right.shape[0]), offset_px + right.shape[1]
    both = np.full((height, width, 3), 255, np.uint8)
    both[: left.shape[0], : left.shape[1]] = left
    both[: right.shape[0], offset_px:] = right
    return both, offset_px


def _instructive(pair: VerifiedPair) -> float:
    """Many matches, and rays that meet at a good angle."""
    return len(pair.matches) * min(1.0, pair.median_angle_deg / _FAVOURED_ANGLE_DEG)


def _picture(axes: "Axes", image: ColourImage) -> "Axes":
    axes.imshow(image)
    axes.set_axis_off()
    return axes


def _upright(photo: Photo, xy_px: Points2) -> tuple[ColourImage, Points2]:
    """A reduced photo as people hold it, and points of the stored photo on it."""
    image = load_colour(photo, halvings_to(photo.width_px, _SHOWN_WIDTH_PX))
    factor = min(1.0, _SHOWN_WIDTH_PX / photo.width_px)
    size = round(photo.width_px * factor), round(photo.height_px * factor)
    image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    xy_px = (xy_px + 0.5) * factor - 0.5
    for _ in range(photo.exif.quarter_turns % 4):
        height = image.shape[0]
        image = np.rot90(image, -1)
        xy_px = np.stack([height - 1 - xy_px[:, 1], xy_px[:, 0]], axis=1)
    return np.ascontiguousarray(image), xy_px


def _stored_width(photo: Photo) -> int:
    """Width in pixels of the stored photo as people hold it."""
    return photo.height_px if photo.exif.quarter_turns % 2 else photo.width_px
