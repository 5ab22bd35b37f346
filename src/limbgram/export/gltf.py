"""GLB: the surface for viewers, with colour and sigma.

glTF knows one unit, the metre, and calls +Y up. The file holds metres (millimetres / 1000) about
the same axes; its one node turns +Z to +Y, so that viewers show the limb standing. The attribute
_SIGMA has each vertex's standard deviation in metres, -1 where it was filled (no NaN in glTF).
"""

from pathlib import Path
from typing import BinaryIO

import numpy as np
from jaxtyping import Float32

from limbgram.export.writing import (
    Unit,
    require,
    require_same_triangles,
    single_precision,
    target,
    write_file,
)
from limbgram.surface.mesh import Mesh

_METRE = 0.001
_SIGMA = "_SIGMA"
_VIEWER_FROM_WORLD = np.array(
    [[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]], float
)


def write_glb(mesh: Mesh, path: Path, unit: Unit, *, unscaled: bool = False) -> Path:
    """Write a binary glTF in metres, and read it back in units of the mesh."""
    import trimesh  # a fifth of a second, which most commands do without
    from trimesh.exchange.gltf import export_glb

    path = target(path, unit, unscaled=unscaled)
    sigma = None if mesh.sigma_mm is None else _finite_metres(mesh.sigma_mm)

    def encode(stream: BinaryIO) -> None:
        surface = trimesh.Trimesh(
            mesh.vertices_mm * _METRE, mesh.faces, vertex_colors=mesh.colours, process=False
        )
        if sigma is not None:
            surface.vertex_attributes[_SIGMA] = sigma
        scene = trimesh.Scene(metadata={"source_unit": unit})
        scene.add_geometry(surface, node_name="surface", transform=_VIEWER_FROM_WORLD)
        stream.write(export_glb(scene))

    def check(written: Path) -> None:
        scene = trimesh.load_scene(written, file_type="glb", process=False)
        require(len(scene.geometry) == 1, f"{path.name}: {len(scene.geometry)} surfaces")
        read = scene.to_mesh()
        world_from_viewer = _VIEWER_FROM_WORLD[:3, :3].T
        places = np.asarray(read.vertices, np.float64) @ world_from_viewer.T / _METRE
        tolerance = 2 * single_precision(mesh)
        require_same_triangles(path.name, places[read.faces], mesh, tolerance)
        if mesh.colours is not None:
            colours = np.asarray(read.visual.vertex_colors)[:, :3]
            require(np.array_equal(colours, mesh.colours), f"{path.name}: other colours")
        if sigma is not None:
            (kept,) = scene.geometry.values()
            again = np.asarray(kept.vertex_attributes.get(_SIGMA, ())).ravel()
            require(np.array_equal(again, sigma), f"{path.name}: other sigmas")

    return write_file(path, encode, check)


def _finite_metres(sigma_mm: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
    """Sigmas in metres; what has none is negative."""
    return np.where(np.isfinite(sigma_mm), sigma_mm * _METRE, -1.0).astype(np.float32)
