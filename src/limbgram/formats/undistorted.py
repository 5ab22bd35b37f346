"""Undistorted photos with a COLMAP model of pinhole cameras, for programs that know no other lens.

In      the photos, the metric scene made of them.
Out     a folder: images/ with every placed photo as its camera without distortion and skew would
        have taken it, sparse/ with the model, its image points moved alike, and transforms.json.
Method  focal lengths, principal point and size stay; what the photo does not show is black.
"""

from dataclasses import replace
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
"""Of a photo at once: what the lens does to each pixel takes many times its memory."""
_QUALITY = 95


def write_undistorted(
    photos: PhotoSet, metric: MetricScene, path: Path, *, unscaled: bool = False
) -> Path:
    """Write photos and model into a new folder.

    Raises:
        ExportError: something lies there already, or there is no scale and nobody asked for that.
    """
    path = target(path, metric.scale.unit, unscaled=unscaled)
    if path.exists():
        raise ExportError("export.folder_taken", path=str(path))
    straight = _straight(metric.scene)
    with written_whole(path) as beside:
        (beside / "images").mkdir(parents=True)
        for photo_idx in track(metric.scene.placed):
            picture = load_colour(photos.photos[photo_idx])
            seen = _undistorted(picture, metric.scene.camera(photo_idx))
            place = beside / "images" / straight.names[photo_idx]
            Image.fromarray(seen).save(place, "JPEG", quality=_QUALITY, subsampling=0)
        colours = point_colours(photos, metric.scene)
        model = replace(metric, scene=straight)
        write_colmap(model, beside / "sparse", colours=colours, unscaled=unscaled)
        write_transforms(model, beside / "transforms.json", "images", unscaled=unscaled)
    return path


def _straight(scene: Scene) -> Scene:
    """The scene as cameras without distortion would have it; a camera for each photo."""
    seen = scene.observations
    xy = seen.xy_px.copy()
    for photo_idx in scene.placed:
        rows, camera = seen.photo_idx == photo_idx, scene.camera(photo_idx)
        ideal = camera.normalize(xy[rows])
        xy[rows] = ideal * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    return replace(
        scene,
        names=_jpeg_names(scene.names),
        cameras=tuple(scene.camera(idx).pinhole for idx in range(len(scene.names))),
        camera_idx=tuple(range(len(scene.names))),
        observations=replace(seen, xy_px=xy),
        own=None,
    )


def _jpeg_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the files that are written; two photos of one stem get their numbers."""
    stems = [PurePath(name).stem for name in names]
    return tuple(
        f"{stem}.jpg" if stems.count(stem) == 1 else f"{stem}-{number}.jpg"
        for number, stem in enumerate(stems, 1)
    )


def _undistorted(picture: np.ndarray, camera: Camera) -> np.ndarray:
    seen = np.zeros_like(picture)
    x = (np.arange(camera.width_px) - camera.cx) / camera.fx
    for start in range(0, camera.height_px, _ROWS):
        rows = np.arange(start, min(start + _ROWS, camera.height_px))
        across, down = np.meshgrid(x, (rows - camera.cy) / camera.fy)
        rays = np.stack([across.ravel(), down.ravel(), np.ones(across.size)], axis=1)
        xy = np.nan_to_num(camera.project(rays), nan=-1e4).astype(np.float32)
        x_map, y_map = xy.T.reshape(2, *across.shape)
        seen[rows] = cv2.remap(picture, x_map.copy(), y_map.copy(), cv2.INTER_CUBIC)
    return seen
