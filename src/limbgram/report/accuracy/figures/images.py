"""Images: noise, sharpness and size of a pixel on the object, photo by photo."""

import cv2
import numpy as np

from limbgram.errors import PhotoError
from limbgram.geometry.arrays import GreyImage
from limbgram.photos.photo import Photo
from limbgram.photos.quality import remarks
from limbgram.photos.reading import load_luma
from limbgram.report.accuracy.evidence import Evidence, Json
from limbgram.report.drawings.charts import image_scales

_NOISE_PHOTOS = 2
_NOISE_SIDE_PX = 1000
_FLAT_SHARE = 0.5
"""Part of the pixels, those with the least slope, in which noise is looked for."""
_MIDDLE_GREY = (20, 235)


def image_figures(evidence: Evidence) -> Json:
    """What the photos are worth; NaN for the noise where their files are gone."""
    scene, photos = evidence.metric.scene, evidence.photos
    scales = {one.name: one for one in image_scales(photos, evidence.metric)}
    said: dict[str, list[str]] = {}
    for remark in remarks(photos):
        said.setdefault(remark.name, []).append(remark.text)
    rows: list[Json] = []
    stated: list[float] = []
    for photo, verdict in zip(photos.photos, scene.verdicts, strict=True):
        scale = scales.get(photo.name)
        if scale is not None and photo.exif.subject_m is not None:
            stated.append(scale.distance_mm / (1000 * photo.exif.subject_m))
        rows.append(
            {
                "name": photo.name,
                "placed": verdict.placed,
                "reason": verdict.reason,
                "remarks": said.get(photo.name, []),
                "points": verdict.points,
                "edge_width_px": photo.sharpness,
                "burnt_share": photo.burnt,
                "distance": float("nan") if scale is None else scale.distance_mm,
                "pixel": float("nan") if scale is None else scale.pixel_mm,
            }
        )
    return {
        "photos": len(rows),
        "placed": sum(bool(row["placed"]) for row in rows),
        "set_aside": [
            {"name": part.name, "reason": part.reason}
            for part in (*photos.set_aside, *evidence.metric.scale.set_aside)
        ],
        "pixel": _median([row["pixel"] for row in rows]),
        "distance": _median([row["distance"] for row in rows]),
        "distance_over_stated": _median(stated),
        "edge_width_px": _median([row["edge_width_px"] for row in rows]),
        "noise_grey": _noise(evidence),
        "by_photo": rows,
    }


def noise_grey(luma: GreyImage) -> float:
    """Standard deviation of a pixel in plain parts of the picture, grey levels of 256.

    The kernel of Immerkaer (1996) answers to noise and not to planes or edges; it is asked in the
    plainer half of the pixels. JPEG has smoothed away part of the noise before.
    """
    top, left = (max(0, (side - _NOISE_SIDE_PX) // 2) for side in luma.shape)
    grey = luma[top : top + _NOISE_SIDE_PX, left : left + _NOISE_SIDE_PX].astype(np.float32)
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    answer = np.abs(cv2.filter2D(grey, cv2.CV_32F, kernel))
    smooth = cv2.GaussianBlur(grey, (0, 0), 3.0)
    slope = np.hypot(
        cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=1), cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1)
    )
    lit = (smooth > _MIDDLE_GREY[0]) & (smooth < _MIDDLE_GREY[1])
    if lit.sum() < 100:
        return float("nan")
    plain = lit & (slope <= np.quantile(slope[lit], _FLAT_SHARE))
    return float(answer[plain].mean()) * np.sqrt(np.pi / 2) / 6.0


def _noise(evidence: Evidence) -> float:
    """Median of a few photos spread over the capture."""
    placed = [evidence.photos.photos[k] for k in evidence.metric.scene.placed]
    step = max(1, len(placed) // _NOISE_PHOTOS)
    return _median([_of_photo(photo) for photo in placed[::step][:_NOISE_PHOTOS]])


def _of_photo(photo: Photo) -> float:
    try:
        return noise_grey(load_luma(photo))
    except PhotoError:
        return float("nan")


def _median(values: list[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.median(known)) if known else float("nan")
