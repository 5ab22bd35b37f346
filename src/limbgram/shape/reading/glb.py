"""GLB: metres and +Y up by the format's own rule; turned to millimetres and +Z up."""

import io
from typing import Any

import numpy as np

from limbgram.errors import ShapeFileError
from limbgram.shape.reading.soup import Soup
from limbgram.surface.mesh import Mesh

_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
_FOREIGN = (ValueError, KeyError, IndexError, TypeError, AttributeError, NotImplementedError)
"""What the reader of the format raises on a damaged file."""


def read_glb(content: bytes, name: str) -> Soup:
    """All surfaces of the scene as one, in metres."""
    import trimesh  # a fifth of a second, which other files do without

    try:
        scene = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
        whole = scene.to_mesh()
        places = np.asarray(whole.vertices, np.float64) @ _Z_UP_FROM_Y_UP.T
        faces = np.asarray(whole.faces, np.int32)
        kind = getattr(whole.visual, "kind", None)
        colours = np.asarray(whole.visual.vertex_colors) if kind == "vertex" else None
    except _FOREIGN as error:
        raise ShapeFileError(
            f"{name} is no GLB file that can be read ({error}). Export it again, or as STL."
        ) from error
    if colours is not None:
        colours = colours[:, :3].astype(np.uint8)
    sigma = _sigma(list(scene.geometry.values()), len(places))
    return Soup(
        mesh=Mesh(vertices_mm=places, faces=faces, colours=colours, sigma_mm=sigma),
        stated_unit="m",
    )


def _sigma(surfaces: list[Any], count: int) -> np.ndarray | None:
    """Sigmas of our own files, in metres; NaN where they say that there is none."""
    parts = [getattr(part, "vertex_attributes", {}) for part in surfaces]
    if len(parts) != 1 or "_SIGMA" not in parts[0]:
        return None
    sigma = np.asarray(parts[0]["_SIGMA"], np.float32).ravel()
    return np.where(sigma < 0, np.nan, sigma).astype(np.float32) if len(sigma) == count else None
