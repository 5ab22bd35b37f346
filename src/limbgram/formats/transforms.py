"""transforms.json: cameras and poses as nerfstudio and instant-ngp take them.

Poses are world from camera with the camera looking along -Z and its +Y up (OpenGL); pixels count
from the corner of the first one, as in COLMAP: its centre is 0.5. Every photo has its own numbers
of the lens, so that photos of several cameras and lenses stand in one file. instant-ngp passes over
k3, and neither knows skew: the file beside undistorted photos needs none of them.
"""

from pathlib import Path
from typing import Any

import numpy as np

from limbgram.core.errors import ExportError
from limbgram.core.geometry.lens import FROM_CORNER_PX, Camera, View
from limbgram.formats.writing import target, write_poses_tree
from limbgram.reconstruction.scale.metric import MetricScene

_KNOWN = ("k1", "k2", "k3", "p1", "p2")
_OPENGL_FROM_OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])


def write_transforms(
    metric: MetricScene, path: Path, photos: str, *, unscaled: bool = False
) -> Path:
    """Write the file, and read it back.

    Args:
        photos: Where the photos lie, from the file's folder.
    """
    path = target(path, metric.scale.unit, unscaled=unscaled)
    tree = {
        "camera_model": "OPENCV",
        "unit": metric.scale.unit,
        "frames": [_frame(view, photos) for view in metric.scene.views],
    }
    return write_poses_tree(tree, path)


def _frame(view: View, photos: str) -> dict[str, Any]:
    pose = view.camera_from_world.inverse
    world_from_camera = np.eye(4)
    world_from_camera[:3, :3], world_from_camera[:3, 3] = pose.rotation, pose.translation
    return {
        "file_path": f"{photos}/{view.name}",
        **_lens(view.camera),
        "transform_matrix": (world_from_camera @ _OPENGL_FROM_OPENCV).tolist(),
    }


def _lens(camera: Camera) -> dict[str, float]:
    """All that these programs know of a lens."""
    return {
        "w": camera.width_px,
        "h": camera.height_px,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + FROM_CORNER_PX,
        "cy": camera.cy + FROM_CORNER_PX,
        **dict(zip(_KNOWN, camera.coefficients("nerfstudio", _KNOWN, ExportError), strict=True)),
    }
