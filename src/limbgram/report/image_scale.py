"""Image scale: what a pixel and a residual of each photo are on the object.

The paper's uncertainty of a point in space: dX = m dx', m = h / c.
"""

from dataclasses import dataclass

import numpy as np

from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene


@dataclass(frozen=True, kw_only=True)
class ImageScale:
    """What one placed photo can tell of the object."""

    name: str
    distance_mm: float
    """Median distance along the optical axis of the points that it sees: h."""
    pixel_mm: float
    """Size of a pixel on the object: m times the pixel's size on the sensor."""
    scale_number: float
    """m = h / c by the nominal focal length; NaN where EXIF has none, or the scene no scale."""
    error_mm: float
    """dX = m dx' for the RMS residual of one coordinate."""


def image_scales(photos: PhotoSet, metric: MetricScene) -> tuple[ImageScale, ...]:
    """Image scale and expected accuracy of every placed photo."""
    scene = metric.scene
    scales: list[ImageScale] = []
    for idx in scene.placed:
        view = scene.view(idx)
        seen = scene.observations.point_idx[scene.observations.photo_idx == idx]
        points = scene.points_in_world[seen]
        if len(points) == 0:
            continue
        distance_mm = float(np.median(view.camera_from_world.apply(points)[:, 2]))
        focal_mm = photos.photos[idx].exif.focal_mm if metric.scale.unit == "mm" else None
        principal_mm = focal_mm or float("nan")
        pixel_mm = distance_mm / view.camera.fx
        scales.append(
            ImageScale(
                name=view.name,
                distance_mm=distance_mm,
                pixel_mm=pixel_mm,
                scale_number=distance_mm / principal_mm,
                error_mm=pixel_mm * scene.verdicts[idx].rms_px,
            )
        )
    return tuple(scales)
