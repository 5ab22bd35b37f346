"""Poisson: screened Poisson reconstruction, trimmed where there are no points.

In      a Cloud: merged points with outward normals.
Out     a Mesh: manifold, of even triangles, open where there were no points (`repair` fills holes).
Method  screened Poisson reconstruction (Kazhdan and Hoppe 2013) by pycolmap, on files in a
        temporary folder; then faces far from every point are removed.
Fails   SurfaceError: no surface came out.
"""

import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from limbgram.core.errors import SurfaceError
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.core.run import signal_handlers_kept
from limbgram.reconstruction.surface.pivoting import measure_spacing_mm

_CELL_IN_SPACINGS = 1.0
"""Finest cell, in typical distances between neighbours."""
_SUPPORT_IN_SPACINGS = 3.0
"""Surface farther than this from every point is removed."""


_POINT_WEIGHT = 1.0
"""Weight of the points themselves, relative to their normals."""

_MAX_DEPTH = 10
"""Depth of the octree, at most: each level quadruples time and memory."""
_BOX_SCALE = 1.1
"""Side of the solver's box over the cloud's extent."""


def poisson(cloud: Cloud) -> Mesh:
    """The zero set of screened Poisson reconstruction, where points support it."""
    import trimesh

    with signal_handlers_kept():
        import pycolmap  # both take a quarter of a second, which most commands save

    spacing_mm = measure_spacing_mm(cloud)
    extent = float(np.ptp(cloud.points_mm, axis=0).max())
    finest = np.log2(_BOX_SCALE * extent / (_CELL_IN_SPACINGS * spacing_mm))
    settings = pycolmap.PoissonMeshingOptions()
    settings.depth = int(np.clip(round(float(finest)), 4, _MAX_DEPTH))
    settings.point_weight = _POINT_WEIGHT
    settings.trim = 0.0
    settings.color = False
    settings.num_threads = 1
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    with tempfile.TemporaryDirectory(prefix="limbgram-") as name:
        points, surface = Path(name, "points.ply"), Path(name, "surface.ply")
        _write_points(points, cloud)
        pycolmap.poisson_meshing(points, surface, settings)
        solved = trimesh.load(surface, file_type="ply", process=False)
    if not isinstance(solved, trimesh.Trimesh) or not len(solved.faces):
        raise SurfaceError("surface.no_poisson", points=len(cloud))
    vertices = np.asarray(solved.vertices, np.float64)
    faces = np.asarray(solved.faces, np.int32)
    distance, nearest = KDTree(cloud.points_mm).query(vertices)
    supported = distance <= _SUPPORT_IN_SPACINGS * spacing_mm
    mesh = Mesh(vertices_mm=vertices, faces=faces, colours=cloud.colours[nearest])
    return with_faces(mesh, faces[supported[faces].all(1)])


def _write_points(path: Path, cloud: Cloud) -> None:
    names = ("x", "y", "z", "nx", "ny", "nz")
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(cloud)}",
        *(f"property float {name}" for name in names),
        "end_header\n",
    ]
    rows = np.concatenate([cloud.points_mm, cloud.normals], axis=1).astype("<f4")
    path.write_bytes("\n".join(header).encode() + rows.tobytes())
