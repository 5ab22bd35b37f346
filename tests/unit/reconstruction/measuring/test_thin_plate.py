"""The thin plate's operators against loops over faces and vertices, and against closed forms."""

import math
from itertools import combinations

import numpy as np
import pytest
import scipy.sparse as sp

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.thin_plate import (
    PlainPlates,
    bending_force,
    bending_matrix,
    curvature_of,
    quadrics,
    smoothed_moves,
    stiffness_of,
    tangent_axes,
    thin_plate_of,
)


def lattice(side: int, seed: int | None = None, bend: float = 0.0) -> Mesh:
    """Triangles about 1 mm a side, laid flat or on the paraboloid z = bend (x^2 + y^2)."""
    i, j = np.meshgrid(np.arange(side), np.arange(side))
    xy = np.column_stack([(i + 0.5 * j).ravel(), (math.sqrt(3) / 2 * j).ravel()]).astype(float)
    z = np.zeros(len(xy))
    if seed is not None:
        random = np.random.default_rng(seed)
        xy += random.uniform(-0.2, 0.2, xy.shape)
        z = random.uniform(-0.3, 0.3, len(xy))
    xy -= xy.mean(0)
    at = np.arange(side * side).reshape(side, side)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([b, d, c], -1)], 2).reshape(-1, 3)
    heights = z + bend * (xy**2).sum(1)
    return Mesh(vertices_mm=np.column_stack([xy, heights]), faces=faces.astype(np.int32))


def cotangent_laplacian(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Pinkall and Polthier's, by the angle at each corner; and the area of each vertex."""
    count = len(mesh)
    graph, area = np.zeros((count, count)), np.zeros(count)
    for face in mesh.faces:
        for turn in range(3):
            i, j, k = np.roll(face, -turn)
            one, two = (
                mesh.vertices_mm[i] - mesh.vertices_mm[k],
                mesh.vertices_mm[j] - mesh.vertices_mm[k],
            )
            angle = math.acos(one @ two / np.linalg.norm(one) / np.linalg.norm(two))
            half = min(max(1 / math.tan(angle), 0.05), 5.0) / 2
            graph[i, j] += half
            graph[j, i] += half
            area[k] += np.linalg.norm(np.cross(one, two)) / 6
    area = np.maximum(area, 0.02 * np.median(area))
    return (graph - np.diag(graph.sum(1))) / area[:, None], area


@pytest.mark.parametrize("seed", range(3))
def test_operators_are_those_of_the_formula(seed: int) -> None:
    mesh = lattice(7, seed)
    thin_plate = thin_plate_of(mesh)
    laplacian, area = cotangent_laplacian(mesh)
    np.testing.assert_allclose(thin_plate.laplacian.toarray(), laplacian, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(thin_plate.area_mm2, area, rtol=1e-12)
    edges = {pair for face in mesh.faces for pair in combinations(sorted(face.tolist()), 2)}
    uses = {e: sum(set(e) <= set(face.tolist()) for face in mesh.faces) for e in edges}
    rim = {vertex for edge, count in uses.items() if count == 1 for vertex in edge}
    assert set(np.flatnonzero(thin_plate.is_boundary).tolist()) == rim
    neighbours = thin_plate.neighbours.toarray()
    assert {tuple(e) for e in np.argwhere(np.triu(neighbours)).tolist()} == edges
    assert set(np.unique(neighbours)) == {0.0, 1.0}


def test_the_laplacian_of_a_paraboloid_is_its_curvature() -> None:
    """On a regular lattice that of z = b (x^2 + y^2) is 4 b; of what is straight it is nought."""
    flat, bend = lattice(9), 0.02
    thin_plate = thin_plate_of(flat)
    inside = ~thin_plate.is_boundary
    heights = bend * (flat.vertices_mm[:, :2] ** 2).sum(1)
    np.testing.assert_allclose((thin_plate.laplacian @ heights)[inside], 4 * bend, rtol=1e-9)
    np.testing.assert_allclose((thin_plate.laplacian @ flat.vertices_mm)[inside], 0, atol=1e-12)


def test_quadrics_find_a_known_bend() -> None:
    """Rings of an exact quadric give it back but for the small ridge that steadies them."""
    mesh = lattice(9)
    xy, uu, uv, vv = mesh.vertices_mm[:, :2], 0.03, -0.01, 0.02
    height = 0.5 * uu * xy[:, 0] ** 2 + uv * xy[:, 0] * xy[:, 1] + 0.5 * vv * xy[:, 1] ** 2
    mesh = mesh.with_vertices(np.column_stack([xy, height]))
    middle = int(np.argmin((xy**2).sum(1)))
    axes = np.tile(np.eye(3), (len(mesh), 1, 1))
    found = quadrics(mesh, thin_plate_of(mesh), axes)[middle]
    np.testing.assert_allclose(found, [uu, uv, vv], rtol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_quadrics_are_least_squares_over_two_rings(seed: int) -> None:
    mesh = lattice(6, seed)
    axes = tangent_axes(mesh.vertex_normals())
    found = quadrics(mesh, thin_plate_of(mesh), axes)
    beside = [
        {int(v) for face in mesh.faces if k in face for v in face} - {k} for k in range(len(mesh))
    ]
    for centre, ring in enumerate(beside):
        others = sorted(set().union(ring, *(beside[k] for k in ring)) - {centre})
        u, v, height = axes[centre] @ (mesh.vertices_mm[others] - mesh.vertices_mm[centre]).T
        terms = np.column_stack([u, v, u * u / 2, u * v, v * v / 2])
        normal = terms.T @ terms
        normal += np.diag(1e-4 * np.diag(normal) + 1e-9)
        expected = np.linalg.solve(normal, terms.T @ height)[2:]
        np.testing.assert_allclose(found[centre], expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_axes_are_right_handed_frames(seed: int) -> None:
    normals = np.random.default_rng(seed).normal(size=(50, 3))
    normals[:2] = [[0, 0, 1], [0, 0, -1]]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    axes = tangent_axes(normals)
    np.testing.assert_allclose(
        axes @ axes.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1, rtol=1e-12)
    np.testing.assert_array_equal(axes[:, 2], normals)


def test_bending_is_the_energy_of_the_curvature() -> None:
    """x' B L x = sum of length^4 (weight over area) area (L x)^2, the rim left out."""
    mesh, length_mm = lattice(6, 4), 1.7
    random = np.random.default_rng(4)
    thin_plate, weights = thin_plate_of(mesh), random.uniform(1, 3, len(mesh))
    moves = random.normal(size=len(mesh))
    laplacian, area = cotangent_laplacian(mesh)
    density = float(np.median(weights / area))
    bending = bending_force(thin_plate, stiffness_of(thin_plate, density, length_mm))
    energy = float(moves @ (bending @ thin_plate.laplacian @ moves))
    expected = 0.0
    for k in range(len(mesh)):
        if not thin_plate.is_boundary[k]:
            expected += length_mm**4 * density * area[k] * float(laplacian[k] @ moves) ** 2
    np.testing.assert_allclose(energy, expected, rtol=1e-9)


def test_moves_balance_the_data_against_bending() -> None:
    """No move near by has less energy than the one found: data, bending and rim together."""
    mesh, length_mm = lattice(8, 5), 1.2
    random = np.random.default_rng(5)
    thin_plate, weights = thin_plate_of(mesh), random.uniform(50, 80, len(mesh))
    data = sp.csr_matrix(sp.diags(weights))
    wanted = random.normal(0, 0.1, len(mesh))
    right = weights * wanted
    laplacian, area = cotangent_laplacian(mesh)
    stiff = stiffness_of(thin_plate, float(np.median(weights / area)), length_mm)
    moves = smoothed_moves(mesh, thin_plate, weights, data, right, stiff, length_mm)

    inside = ~thin_plate.is_boundary
    stiffness = inside * length_mm**4 * np.median(weights / area) * area
    bent = curvature_of(mesh, thin_plate, length_mm)
    beside = thin_plate.neighbours.toarray()

    def energy(x: np.ndarray) -> float:
        rim = [x[k] - x[beside[k] > 0].mean() for k in np.flatnonzero(~inside)]
        return float(
            weights @ x**2
            - 2 * right @ x
            + stiffness @ (laplacian @ x + bent) ** 2
            + 8 * np.median(weights) * np.sum(np.square(rim))
        )

    least = energy(moves)
    assert least < energy(wanted) - 1
    assert least < energy(np.zeros(len(mesh))) - 1
    for _ in range(20):
        aside = random.normal(0, 0.02, len(mesh))
        assert energy(moves + aside) > least
        assert energy(moves - aside) > least


def test_a_fold_keeps_its_curvature_and_noise_does_not() -> None:
    """Seen over rings a ridge bends one way; a plane's own noise bends both."""
    ridge = lattice(14)
    x = ridge.vertices_mm[:, 0]
    ridge = ridge.with_vertices(np.column_stack([x, ridge.vertices_mm[:, 1], -3 * np.abs(x)]))
    for mesh, kept in ((ridge, False), (lattice(14, 6, 0.0), True)):
        thin_plate = thin_plate_of(mesh)
        bend = np.einsum("ij,ij->i", mesh.vertex_normals(), thin_plate.laplacian @ mesh.vertices_mm)
        rows = np.abs(bend) > 0.3
        rows &= ~thin_plate.is_boundary & (thin_plate.fold_curvature != 0)
        share = curvature_of(mesh, thin_plate, 1.0)[rows] / bend[rows]
        assert rows.sum() > 5
        assert (np.median(share) > 0.2) == kept


@pytest.mark.parametrize("length_mm", [0.5, 1.0, 2.5])
def test_plates_of_any_length_solve_their_own_equations(length_mm: float) -> None:
    """Against equations that are put together for that length alone, solved directly."""
    mesh = lattice(9, seed=3, bend=0.02)
    thin_plate = thin_plate_of(mesh)
    stiffness = stiffness_of(thin_plate, 1.0, length_mm)
    system = bending_matrix(thin_plate, stiffness).toarray() + np.diag(thin_plate.area_mm2)
    force = bending_force(thin_plate, stiffness) @ curvature_of(mesh, thin_plate, length_mm)
    heights = np.random.default_rng(5).standard_normal(len(mesh))
    rights = [force, thin_plate.area_mm2 * heights]
    found = PlainPlates.of(mesh, thin_plate).removed(length_mm, [heights])
    for one, right in zip(found, rights, strict=True):
        assert np.abs(one).max() > 1e-3
        assert np.linalg.norm(system @ one - right) <= 1.01e-3 * np.linalg.norm(right)
