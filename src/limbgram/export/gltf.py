"""GLB: the surface for viewers, with colour.

glTF knows one unit, the metre, and calls +Y up. The file holds metres (millimetres / 1000) about
the same axes; its one node turns +Z to +Y, so that viewers show the limb standing.
"""

from pathlib import Path
from typing import BinaryIO

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb

from limbgram.export.writing import (
    require,
    require_same_triangles,
    single_precision,
    target,
    write_file,
)
from limbgram.scale.metric import Scale
from limbgram.surface.mesh import Mesh

_METRE = 0.001
_VIEWER_FROM_WORLD = np.array(
    [[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]], float
)


def write_glb(mesh: Mesh, path: Path, scale: Scale, *, unscaled: bool = False) -> Path:
    """Write a binary glTF in metres, and read it back in units of the mesh."""
    path = target(path, scale, unscaled=unscaled)

    def encode(stream: BinaryIO) -> None:
        surface = trimesh.Trimesh(
            mesh.vertices_mm * _METRE, mesh.faces, vertex_colors=mesh.colours, process=False
        )
        scene = trimesh.Scene(metadata={"source_unit": scale.unit})
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

    return write_file(path, encode, check)
