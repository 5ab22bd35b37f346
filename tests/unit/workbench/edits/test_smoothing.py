"""Smoothing: noise goes, the shape and its volume stay, and so does what is to be left alone."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.sparse import csr_array

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges, volume_mm3
from limbgram.formats.reading import read_limb
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.regions import neighbour_averaging, on_open_edge, roughness_mm
from limbgram.workbench.edits.smoothing import Smoothing, taubin_smoothed
from limbgram.workbench.limb import Limb

NOISE_MM = 0.2


def test_noise_on_a_sphere_falls_to_a_third_and_the_sphere_stays() -> None:
    ball = trimesh.creation.icosphere(4, 50.0)
    normals = np.array(ball.vertices) / 50
    noise = np.random.default_rng(1).normal(0, NOISE_MM, (len(normals), 1))
    noisy = Mesh(vertices_mm=normals * (50 + noise), faces=np.array(ball.faces, np.int32))
    calm = taubin_smoothed(noisy, np.ones(len(noisy)), 20)
    radius = np.linalg.norm(calm.vertices_mm, axis=1)
    assert 0.1 * NOISE_MM < radius.std() < 0.4 * NOISE_MM
    assert radius.mean() == pytest.approx(50, abs=0.01)
    assert volume_mm3(calm) / volume_mm3(noisy) == pytest.approx(1, abs=1e-10)


def test_the_brim_and_marked_places_stay_to_the_bit(limb: Limb) -> None:
    noise = np.random.default_rng(2).normal(0, NOISE_MM, (len(limb.mesh), 1))
    noise[:500] = 0  # the thin triangles round the tip
    rough = limb.with_mesh(
        limb.mesh.with_vertices(limb.mesh.vertices_mm + noise * limb.mesh.vertex_normals())
    )
    calm = do_edit(rough, Smoothing(passes=8, brim_mm=6, leave=("right",), leave_mm=20))
    still = (calm.mesh.vertices_mm == rough.mesh.vertices_mm).all(1)
    place = rough.landmarks[1].position_mm
    marked = np.linalg.norm(rough.mesh.vertices_mm - place, axis=1) < 17
    assert still[marked].all()
    assert still[on_open_edge(rough.mesh)].all()
    assert marked.sum() > 20
    assert still.mean() < 0.4
    assert roughness_mm(calm.mesh) < 0.7 * roughness_mm(rough.mesh)
    assert volume_mm3(calm.mesh) / volume_mm3(rough.mesh) == pytest.approx(1, abs=1e-10)


@pytest.mark.parametrize(
    ("made", "passes", "told"),
    [
        (trimesh.creation.box((80.0, 80.0, 200.0)), 10, "fold triangles over wherever it is free"),
        (trimesh.creation.box((80.0, 80.0, 200.0)), 500, "fold triangles over wherever it is free"),
        (trimesh.creation.icosahedron(), 10, r"would change the volume by \+57.* mL"),
    ],
)
def test_a_shape_of_few_triangles_is_refused(made: trimesh.Trimesh, passes: int, told: str) -> None:
    """They have nothing but edges: what pulls at those turns the shape inside out."""
    mesh = Mesh(vertices_mm=np.asarray(made.vertices) * 40, faces=made.faces.astype(np.int32))
    with pytest.raises(EditError, match=told):
        do_edit(Limb(mesh=mesh), Smoothing(passes=passes))


def test_nothing_to_move_keeps_no_volume() -> None:
    ball = trimesh.creation.icosphere(2, 50.0)
    mesh = Mesh(vertices_mm=np.asarray(ball.vertices), faces=ball.faces.astype(np.int32))
    with pytest.raises(EditError, match="to keep the volume"):
        taubin_smoothed(mesh, np.zeros(len(mesh)), 3)


def test_twenty_passes_on_a_scan_keep_its_volume_and_calm_it(data_folder: Path) -> None:
    scan = read_limb(data_folder / "shapes" / "ampscan" / "stl_file.stl")
    calm = do_edit(scan, Smoothing(passes=20))
    assert abs(volume_mm3(calm.mesh) / volume_mm3(scan.mesh) - 1) < 5e-4
    assert roughness_mm(calm.mesh) < 0.5 * roughness_mm(scan.mesh)
    bias = ((calm.mesh.vertices_mm - scan.mesh.vertices_mm) * scan.mesh.vertex_normals()).sum(1)
    assert abs(bias.mean()) < 0.01


def test_mean_over_neighbours_is_that_of_the_sparse_sum_of_both_directions() -> None:
    ball = trimesh.creation.icosphere(3, 50.0)
    loose = np.concatenate([np.array(ball.vertices), [[0.0, 0.0, 0.0]]])
    mesh = Mesh(vertices_mm=loose, faces=np.array(ball.faces, np.int32))
    ends = find_edges(mesh.faces).ends
    sizes = np.linalg.norm(loose[ends[:, 0]] - loose[ends[:, 1]], axis=1)
    half = csr_array((1 / sizes, (ends[:, 0], ends[:, 1])), shape=(len(mesh), len(mesh)))
    both = csr_array(half + half.T)
    mean = both.multiply(1 / np.maximum(both.sum(1), 1e-30)[:, None]).tocsr()
    found = neighbour_averaging(mesh)
    np.testing.assert_array_equal(found.indptr, mean.indptr)
    np.testing.assert_array_equal(found.indices, mean.indices)
    np.testing.assert_allclose(found.data, mean.data, rtol=1e-15)
    whole = np.ones(len(mesh))
    whole[-1] = 0.0  # a vertex without a face has no neighbours
    np.testing.assert_allclose(found @ np.ones(len(mesh)), whole, rtol=1e-14)
