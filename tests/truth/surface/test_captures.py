"""From points of a captured limb's true surface, with the noise of good depth maps, to a mesh."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
)
from limbgram.reconstruction.surface.parts import tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.repair import repair

NOISE_MM = 0.07
CUT_MM = 1.5
"""The lowest part of the limb that no point shows."""


@pytest.fixture(scope="module")
def truth(data_folder: Path) -> trimesh.Trimesh:
    return trimesh.load_mesh(data_folder / "rendered/limb_ring15/truth/mesh.ply", process=False)


@pytest.fixture(scope="module")
def mesh(truth: trimesh.Trimesh) -> Mesh:
    rng = np.random.default_rng(0)
    points, faces = trimesh.sample.sample_surface(truth, 300_000, seed=0)
    _, even = np.unique(np.floor(points / 0.9).astype(int), axis=0, return_index=True)
    even = even[points[even, 2] > truth.bounds[0, 2] + CUT_MM]
    normals = truth.face_normals[faces[even]]
    noisy = points[even] + NOISE_MM * rng.standard_normal((len(even), 1)) * normals
    tilted = normals + 0.15 * rng.standard_normal(normals.shape)
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    cloud = Cloud(
        points_mm=noisy.astype(np.float32),
        normals=tilted.astype(np.float32),
        colours=np.full((len(even), 3), 128, np.uint8),
        views=np.full(len(even), 4, np.uint16),
        spacing_mm=0.9,
    )
    return repair(tell_parts(pivot(cloud), cloud), cloud)


def test_one_manifold_piece_with_one_brim(mesh: Mesh, truth: trimesh.Trimesh) -> None:
    assert is_edge_manifold(mesh.faces)
    assert is_vertex_manifold(mesh.faces)
    assert not face_components(mesh.faces).any()
    (brim,) = boundary_loops(mesh.faces)
    assert mesh.vertices_mm[brim, 2].max() < truth.bounds[0, 2] + CUT_MM + 3


def test_no_worse_and_no_better_than_the_points(mesh: Mesh, truth: trimesh.Trimesh) -> None:
    tree = TriangleTree.of(np.asarray(truth.vertices, float), truth.faces.astype(np.int32))
    rms = np.sqrt((tree.closest(mesh.vertices_mm).distances_mm ** 2).mean())
    assert 0.95 * NOISE_MM < rms < 1.05 * NOISE_MM


def test_complete(mesh: Mesh, truth: trimesh.Trimesh) -> None:
    points, _ = trimesh.sample.sample_surface(truth, 30_000, seed=1)
    points = points[points[:, 2] > truth.bounds[0, 2] + CUT_MM + 1.5]
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    assert (tree.closest(points).distances_mm < 0.25).mean() > 0.995
