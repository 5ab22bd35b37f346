"""A COLMAP model folder, and poses.json: the cameras for other programs.

COLMAP's pixel centre is +0.5, its poses are camera from world, and its lens has no skew: image
points are written with the skew removed. Where photos have lenses of their own, every photo gets a
camera of its own. The binary form takes any photo name; the text form breaks names at a space.
"""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import UInt8
from scipy.spatial.transform import Rotation

from limbgram.core.errors import ExportError
from limbgram.core.files import other_count, require, write_folder
from limbgram.core.geometry.lens import FROM_CORNER_PX, OPENCV, PARAMETERS, Camera, without_skew
from limbgram.core.run import signal_handlers_kept
from limbgram.findings import fault
from limbgram.formats.writing import target, write_poses_tree
from limbgram.reconstruction.mapping.colours import GREY
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.scale.metric import MetricScene

_CONVENTION = {
    "pose": "x_camera = R x_world + t, camera from world",
    "camera": "x right, y down, z forward (OpenCV)",
    "pixel": "(0, 0) is the centre of the top left pixel",
    "lens": "pinhole with skew and Brown-Conrady distortion, as OpenCV has k1, k2, p1, p2, k3",
}
_PINHOLE, _OPENCV, _FULL_OPENCV = 1, 4, 6
"""COLMAP's camera model ids; most programs that read its files know the first two."""
_SEEN = np.dtype([("xy", "<f8", 2), ("point", "<i8")])


def write_poses(metric: MetricScene, path: Path, *, unscaled: bool = False) -> Path:
    """Write R and t (camera from world, mm) of every placed photo, and read them back."""
    path = target(path, metric.scale.unit, unscaled=unscaled)
    images = [
        {
            "name": view.name,
            "R": view.camera_from_world.rotation.tolist(),
            "t": view.camera_from_world.translation.tolist(),
            "lens": {
                "width_px": view.camera.width_px,
                "height_px": view.camera.height_px,
                **dict(zip(PARAMETERS, view.camera.packed.tolist(), strict=True)),
            },
        }
        for view in metric.scene.views
    ]
    poses = {"unit": metric.scale.unit, "convention": _CONVENTION, "images": images}
    return write_poses_tree(poses, path)


def write_colmap(
    metric: MetricScene,
    path: Path,
    *,
    colours: UInt8[np.ndarray, "n 3"] | None = None,
    unscaled: bool = False,
) -> Path:
    """Write cameras.bin, images.bin and points3D.bin, and read them back with pycolmap.

    Args:
        colours: Of the scene's points; grey without.
    """
    path = target(path, metric.scale.unit, unscaled=unscaled)
    scene = metric.scene
    files: dict[str, Callable[[BinaryIO], None]] = {
        "cameras.bin": lambda stream: _write_cameras(stream, scene),
        "images.bin": lambda stream: _write_images(stream, scene),
        "points3D.bin": lambda stream: _write_points(stream, scene, colours),
    }
    return write_folder(path, files, lambda written: _check(written, scene))


def _write_cameras(stream: BinaryIO, scene: Scene) -> None:
    alike = scene.own is None
    cameras = scene.cameras if alike else tuple(view.camera for view in scene.views)
    stream.write(struct.pack("<Q", len(cameras)))
    for idx, camera in enumerate(cameras, 1):
        centre = (camera.cx + FROM_CORNER_PX, camera.cy + FROM_CORNER_PX)
        model, lens = _model(camera)
        sizes = (camera.width_px, camera.height_px)
        stream.write(struct.pack("<iiQQ", idx, model, *sizes))
        stream.write(struct.pack("<4d", camera.fx, camera.fy, *centre))
        stream.write(struct.pack(f"<{len(lens)}d", *lens))


def _model(camera: Camera) -> tuple[int, tuple[float, ...]]:
    """COLMAP's simplest model that holds the lens, and its coefficients."""
    *four, k3 = camera.coefficients("COLMAP", OPENCV, ExportError)
    if k3:
        return _FULL_OPENCV, (*four, k3, 0.0, 0.0, 0.0)
    return (_OPENCV, tuple(four)) if any(four) else (_PINHOLE, ())


def _write_images(stream: BinaryIO, scene: Scene) -> None:
    observed = scene.observations
    stream.write(struct.pack("<Q", len(scene.placed)))
    for photo_idx, lens_idx in zip(scene.placed, scene.lens_idx, strict=True):
        view = scene.view(photo_idx)
        pose = view.camera_from_world
        x, y, z, w = Rotation.from_matrix(pose.rotation).as_quat(canonical=True).tolist()
        stream.write(struct.pack("<I7d", photo_idx + 1, w, x, y, z, *pose.translation.tolist()))
        stream.write(struct.pack("<I", lens_idx + 1))
        stream.write(view.name.encode() + b"\0")
        rows = observed.photo_idx == photo_idx
        seen = np.zeros(int(rows.sum()), _SEEN)
        seen["xy"] = without_skew(view.camera, observed.xy_px[rows]) + FROM_CORNER_PX
        seen["point"] = observed.point_idx[rows] + 1
        stream.write(struct.pack("<Q", len(seen)) + seen.tobytes())


def _write_points(stream: BinaryIO, scene: Scene, colours: UInt8[np.ndarray, "n 3"] | None) -> None:
    """Points, each with its mean residual and its track."""
    observed = scene.observations
    used = np.flatnonzero(np.isin(observed.photo_idx, scene.placed))
    errors = np.linalg.norm(scene.residuals_px(), axis=1)
    tracks = np.zeros(len(used), np.dtype([("image", "<u4"), ("place", "<u4")]))
    photos = observed.photo_idx[used]
    tracks["image"] = photos + 1
    for photo_idx in scene.placed:
        rows = photos == photo_idx
        tracks["place"][rows] = np.arange(rows.sum())
    order = np.argsort(observed.point_idx[used], kind="stable")
    ids, starts = np.unique(observed.point_idx[used][order], return_index=True)
    tracks, errors = tracks[order], errors[used][order]
    if colours is None:
        colours = np.full((len(scene.points_in_world), 3), GREY, np.uint8)
    stream.write(struct.pack("<Q", len(ids)))
    for idx, start, end in zip(ids.tolist(), starts, [*starts[1:], len(order)], strict=True):
        place = scene.points_in_world[idx].tolist()
        error = float(errors[start:end].mean())
        stream.write(
            struct.pack("<Q3d3BdQ", idx + 1, *place, *colours[idx].tolist(), error, end - start)
        )
        stream.write(tracks[start:end].tobytes())


def _check(written: Path, scene: Scene) -> None:
    """Refuse a model whose points pycolmap projects elsewhere than our own cameras do."""
    with signal_handlers_kept():
        import pycolmap  # only where photos were placed

    read = pycolmap.Reconstruction(str(written))
    seen = np.unique(scene.observations.point_idx)
    photos, points = int(read.num_reg_images()), int(read.num_points3D())
    placed = len(scene.placed)
    require(photos == placed, other_count(written.name, "photos", photos, placed))
    require(points == len(seen), other_count(written.name, "points", points, len(seen)))
    for photo_idx in scene.placed:
        view, image = scene.view(photo_idx), read.images[photo_idx + 1]
        require(
            image.name == view.name, fault("export.other_photo", found=image.name, photo=view.name)
        )
        rows = np.flatnonzero(scene.observations.photo_idx == photo_idx)[:50]
        places = scene.points_in_world[scene.observations.point_idx[rows]]
        ours = without_skew(view.camera, view.project(places)) + FROM_CORNER_PX
        in_camera = image.cam_from_world() * places
        theirs = np.asarray(read.cameras[image.camera_id].img_from_cam(in_camera))
        apart = np.abs(ours - theirs)[np.isfinite(ours).all(1)].max(initial=0.0)
        require(apart < 1e-4, fault("export.projections", photo=view.name, apart_px=float(apart)))
