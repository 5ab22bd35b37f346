"""Undistorted photos with a COLMAP model of pinhole cameras, for programs without lens distortion.

In      the photos, the metric scene made of them.
Out     a folder: images/ with every placed photo without distortion and skew, sparse/ with the
        model, its image points undistorted too, and transforms.json.
Method  focal lengths, principal point and size stay; pixels that the photo does not show are black.
"""

from collections import Counter
from dataclasses import replace
from itertools import count
from pathlib import Path, PurePath

import cv2
import numpy as np
from PIL import Image

from limbgram.core.errors import ExportError
from limbgram.core.files import written_whole
from limbgram.core.geometry.lens import Camera
from limbgram.core.run import track
from limbgram.formats.colmap import write_colmap
from limbgram.formats.transforms import write_transforms
from limbgram.formats.writing import target
from limbgram.reconstruction.mapping.colours import point_colours
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.decoding import load_colour
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene

_ROWS = 256
"""Rows of a photo at a time: the map of source pixels takes many times a photo's memory."""
_JPEG_QUALITY = 95


def write_undistorted(
    photos: PhotoSet, metric: MetricScene, path: Path, *, unscaled: bool = False
) -> Path:
    """Write photos and model into a new folder.

    Raises:
        ExportError: something lies there already, or there is no scale and `unscaled` is not set.
    """
    path = target(path, metric.scale.unit, unscaled=unscaled)
    if path.exists():
        raise ExportError("export.folder_taken", path=str(path))
    undistorted = _undistorted_scene(metric.scene)
    with written_whole(path) as beside:
        (beside / "images").mkdir(parents=True)
        for photo_idx in track(metric.scene.placed):
            picture = load_colour(photos.photos[photo_idx])
            pixels = _undistorted(picture, metric.scene.camera(photo_idx))
            file = beside / "images" / undistorted.names[photo_idx]
            Image.fromarray(pixels).save(file, "JPEG", quality=_JPEG_QUALITY, subsampling=0)
        colours = point_colours(photos, metric.scene)
        model = replace(metric, scene=undistorted)
        write_colmap(model, beside / "sparse", colours=colours, unscaled=unscaled)
        write_transforms(model, beside / "transforms.json", "images", unscaled=unscaled)
    return path


def _undistorted_scene(scene: Scene) -> Scene:
    """The scene as pinhole cameras would have observed it; a camera for each photo."""
    observations = scene.observations
    xy_px = observations.xy_px.copy()
    for photo_idx in scene.placed:
        rows, camera = observations.photo_idx == photo_idx, scene.camera(photo_idx)
        normalised = camera.normalize(xy_px[rows])
        xy_px[rows] = normalised * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    return replace(
        scene,
        names=_jpeg_names(scene.names),
        cameras=tuple(scene.camera(idx).pinhole for idx in range(len(scene.names))),
        camera_idx=tuple(range(len(scene.names))),
        observations=replace(observations, xy_px=xy_px),
        own=None,
    )


def _jpeg_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """A name for each photo's JPEG: its stem, with a number where photos share their stem."""
    stems = [PurePath(name).stem for name in names]
    uses = Counter(stem.casefold() for stem in stems)
    taken = {stem for stem, count in uses.items() if count == 1}
    found: list[str] = []
    for idx, stem in enumerate(stems, 1):
        if uses[stem.casefold()] > 1:
            numbered = (f"{stem}-{number}" for number in count(idx))
            stem = next(name for name in numbered if name.casefold() not in taken)
            taken.add(stem.casefold())
        found.append(f"{stem}.jpg")
    return tuple(found)


def _undistorted(picture: np.ndarray, camera: Camera) -> np.ndarray:
    pixels = np.zeros_like(picture)
    x = (np.arange(camera.width_px) - camera.cx) / camera.fx
    for start in range(0, camera.height_px, _ROWS):
        rows = np.arange(start, min(start + _ROWS, camera.height_px))
        across, down = np.meshgrid(x, (rows - camera.cy) / camera.fy)
        rays = np.stack([across.ravel(), down.ravel(), np.ones(across.size)], axis=1)
        xy_px = np.nan_to_num(camera.project(rays), nan=-1e4).astype(np.float32)
        x_map, y_map = xy_px.T.reshape(2, *across.shape)
        pixels[rows] = cv2.remap(picture, x_map.copy(), y_map.copy(), cv2.INTER_CUBIC)
    return pixels
