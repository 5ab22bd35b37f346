"""Decimation: fewer triangles, with the deviation that they cost.

In      a manifold Mesh.
Out     a Decimated: the smaller mesh, as manifold as the given one, and its measured deviation.
Method  quadric error collapses (Garland and Heckbert 1997) by pycolmap, on files in a temporary
        folder; where those leave no manifold, the spot is cut out and closed again.
Fails   SurfaceError: the mesh is not a manifold, or cannot be made small.
"""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from limbgram.errors import OptionsError, SurfaceError
from limbgram.geometry.arrays import Faces, Points3
from limbgram.surface.mesh import Mesh
from limbgram.surface.repair.cleaning import drop_flat_and_double, settle
from limbgram.surface.repair.filling import fill_holes
from limbgram.surface.resampling.deviation import Deviation, measure_deviation
from limbgram.surface.topology import boundary_loops, is_edge_manifold, taking_vertices, with_faces


@dataclass(frozen=True, kw_only=True)
class DecimateOptions:
    """How small, or how true: exactly one of the two."""

    max_faces: int | None = 50_000
    """Number of triangles to come down to."""
    max_deviation_mm: float | None = None
    """Largest distance from the given surface, either way: as few triangles as keep to it."""


DEFAULTS = DecimateOptions()
_FEWEST_FACES = 200
_TRIES = 6


@dataclass(frozen=True, kw_only=True)
class Decimated:
    """A smaller mesh and what it lost."""

    mesh: Mesh
    deviation: Deviation


def decimate(mesh: Mesh, options: DecimateOptions = DEFAULTS) -> Decimated:
    """Take triangles away where they matter least."""
    if not is_edge_manifold(mesh.faces):
        raise SurfaceError("Only a manifold mesh can be made smaller; repair it first.")
    match options:
        case DecimateOptions(max_faces=int(count), max_deviation_mm=None):
            return _to_count(mesh, count)
        case DecimateOptions(max_faces=None, max_deviation_mm=float(limit_mm)):
            return _to_deviation(mesh, limit_mm)
        case _:
            raise OptionsError("Give either max_faces or max_deviation_mm, and None for the other.")


def _to_count(mesh: Mesh, count: int) -> Decimated:
    if count >= len(mesh.faces):
        return Decimated(mesh=mesh, deviation=Deviation(max_mm=0.0, rms_mm=0.0))
    smaller = _simplify(mesh, count / len(mesh.faces))
    return Decimated(mesh=smaller, deviation=measure_deviation(mesh, smaller))


def _to_deviation(mesh: Mesh, limit_mm: float) -> Decimated:
    """Halve between the smallest number of faces that is true enough and one that is not."""
    best = Decimated(mesh=mesh, deviation=Deviation(max_mm=0.0, rms_mm=0.0))
    low, high = np.log(_FEWEST_FACES), np.log(len(mesh.faces))
    for _ in range(_TRIES):
        middle = 0.5 * (low + high)
        tried = _to_count(mesh, int(np.exp(middle)))
        if tried.deviation.max_mm <= limit_mm:
            best, high = tried, middle
        else:
            low = middle
    return best


def _simplify(mesh: Mesh, ratio: float) -> Mesh:
    import pycolmap  # a quarter of a second together, which most commands do without
    import trimesh
    from trimesh.exchange.ply import export_ply

    settings = pycolmap.MeshSimplificationOptions()
    settings.target_face_ratio = ratio
    settings.interpolate_colors = False
    settings.num_threads = 1
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    centre = mesh.vertices_mm.mean(0)
    with tempfile.TemporaryDirectory(prefix="limbgram-") as name:
        given, made = Path(name, "given.ply"), Path(name, "made.ply")
        # About the centre: the files carry single precision.
        plain = trimesh.Trimesh(mesh.vertices_mm - centre, mesh.faces, process=False)
        given.write_bytes(export_ply(plain, vertex_normal=False))
        pycolmap.simplify_mesh(given, made, settings)
        small = trimesh.load(made, file_type="ply", process=False)
    if not isinstance(small, trimesh.Trimesh) or len(small.faces) < 4:
        raise SurfaceError(f"No surface is left at {ratio:.2%} of the triangles; ask for more.")
    vertices = np.asarray(small.vertices, np.float64) + centre
    made_whole = _make_whole(vertices, np.asarray(small.faces, np.int32), mesh.faces)
    nearest = KDTree(mesh.vertices_mm).query(made_whole.vertices_mm)[1]
    known = taking_vertices(mesh, np.asarray(nearest))
    return replace(
        known, vertices_mm=made_whole.vertices_mm, faces=made_whole.faces, repairs=mesh.repairs
    )


def _make_whole(vertices: Points3, faces: Faces, given: Faces) -> Mesh:
    """Manifold, with as many openings as the given faces have, the longest ones staying open."""
    faces = settle(vertices, drop_flat_and_double(vertices, faces))
    plain = with_faces(Mesh(vertices_mm=vertices, faces=faces), faces)
    stay_open = len(boundary_loops(given))
    loops = sorted(boundary_loops(plain.faces), key=lambda loop: -_length(plain.vertices_mm[loop]))
    return fill_holes(plain.vertices_mm, plain.faces, loops[stay_open:])


def _length(loop: Points3) -> float:
    return float(np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).sum())
