"""Propagation of sigmas against drawn errors and closed forms."""

import numpy as np
import pytest
import trimesh

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.uncertainty import extra_extremum_variance_mm2, filled_sigma_mm, propagate

REACH_MM = 1.7
SIGMA_MM = 0.05


def grid(side: int, **known: object) -> Mesh:
    """A flat square of `side` x `side` vertices, 1 mm apart, facing up."""
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    at = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], 1)
    sigma = np.full(len(vertices), SIGMA_MM, np.float32)
    return Mesh(**{"vertices_mm": vertices, "faces": faces, "sigma_mm": sigma, **known})


def drawn(mesh: Mesh, count: int) -> np.ndarray:
    """Errors of the local kind, (count, n)."""
    apart = np.linalg.norm(mesh.vertices_mm[:, None] - mesh.vertices_mm[None], axis=2)
    alike = np.exp(-((apart / REACH_MM) ** 2)) + 1e-9 * np.eye(len(mesh))
    random = np.random.default_rng(3).normal(size=(count, len(mesh)))
    return SIGMA_MM * random @ np.linalg.cholesky(alike).T


def test_without_sigmas_there_is_no_answer() -> None:
    mesh = grid(4, sigma_mm=None)
    assert propagate(mesh, np.ones(len(mesh))) is None


def test_a_line_and_a_square_scatter_as_drawn_errors_do() -> None:
    mesh = grid(18, correlation_mm=REACH_MM)
    errors = drawn(mesh, 4000)
    line = np.where(mesh.vertices_mm[:, 1] == 9, np.sin(mesh.vertices_mm[:, 0]) + 1, 0.0)
    for gradient in (line, np.ones(len(mesh))):
        told = propagate(mesh, gradient)
        assert told is not None
        assert told / (errors @ gradient).std() == pytest.approx(1.0, abs=0.05)


def test_a_large_even_support_has_the_area_of_its_reach() -> None:
    mesh = grid(90, correlation_mm=REACH_MM)
    told = propagate(mesh, np.ones(len(mesh)))
    assert told == pytest.approx(SIGMA_MM * 90 * np.sqrt(np.pi) * REACH_MM, rel=0.03)


def test_shared_errors_add_up_with_their_signs() -> None:
    shared = np.zeros((16, 2), np.float32)
    shared[:, 0], shared[:8, 1], shared[8:, 1] = 0.05, 0.03, -0.03
    sigma = np.sqrt((shared**2).sum(1))
    mesh = grid(4, sigma_mm=sigma.astype(np.float32), shared_mm=shared, correlation_mm=0.1)
    assert propagate(mesh, np.ones(16)) == pytest.approx(16 * 0.05, rel=1e-3)
    halves = np.where(np.arange(16) < 8, 1.0, -1.0)
    assert propagate(mesh, halves) == pytest.approx(16 * 0.03, rel=1e-3)


def test_a_filled_patch_is_wrong_as_one_piece_and_by_its_size() -> None:
    mesh = _ball_with_a_patch(12.0)
    filled = np.isnan(mesh.sigma_mm) if mesh.sigma_mm is not None else np.zeros(0, bool)
    sigma = filled_sigma_mm(mesh, filled)
    assert sigma.max() == pytest.approx(12.0**2 / 2 / 40.0, rel=0.1)  # h^2 / 2 R
    assert sigma[~filled].max() == 0
    assert propagate(mesh, filled.astype(float)) == pytest.approx(sigma.sum(), rel=1e-6)
    smaller = _ball_with_a_patch(6.0)
    assert 0.2 < filled_sigma_mm(smaller, np.isnan(smaller.sigma_mm)).max() / sigma.max() < 0.3


def test_two_patches_do_not_add_up() -> None:
    mesh = _ball_with_a_patch(8.0, both_ends=True)
    filled = np.isnan(mesh.sigma_mm) if mesh.sigma_mm is not None else np.zeros(0, bool)
    sigma = filled_sigma_mm(mesh, filled)
    above = sigma[mesh.vertices_mm[:, 2] > 0].sum()
    below = sigma[mesh.vertices_mm[:, 2] < 0].sum()
    assert propagate(mesh, filled.astype(float)) == pytest.approx(np.hypot(above, below), rel=1e-6)


def test_a_filled_tip_is_as_unsure_as_what_is_round_it_bends() -> None:
    """A toe of 8 mm beside a body of 60 mm: each tip by the bend round it."""
    toe, body = trimesh.creation.icosphere(4, 8.0), trimesh.creation.icosphere(5, 60.0)
    toe.apply_translation((0, 0, 100.0))
    both = trimesh.util.concatenate([toe, body])
    vertices = np.array(both.vertices)
    tips = {8.0: vertices - [0, 0, 108.0], 60.0: vertices - [0, 0, -60.0]}
    away_mm = {radius: np.linalg.norm(off, axis=1) for radius, off in tips.items()}
    filled = np.min([*away_mm.values()], axis=0) < 5.0
    sigma = np.where(filled, np.nan, 0.0).astype(np.float32)
    mesh = Mesh(vertices_mm=vertices, faces=np.array(both.faces, np.int32), sigma_mm=sigma)
    told = filled_sigma_mm(mesh, filled)
    assert told[away_mm[8.0] < 5.0].max() == pytest.approx(5.0**2 / 2 / 8.0, rel=0.15)
    of_body = told[away_mm[60.0] < 5.0].max()  # the toe shifts the middle: the whole is 1 / 45
    assert 5.0**2 / 2 / 60.0 * 0.9 < of_body < 5.0**2 / 2 / 40.0


@pytest.mark.parametrize("corner", [0, 1, 2])
def test_two_filled_vertices_on_one_edge_are_one_patch(corner: int) -> None:
    """Whichever side of its triangle that edge is. A measured triangle beside it gives the bend."""
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    vertices = np.array(
        [[0, 0, 0], [10, 0, 0], [5, 9, 0], [0, 0, 30], [10, 0, 30], [5, 9, 33]], float
    )
    sigma = np.full(6, SIGMA_MM, np.float32)
    sigma[[corner, (corner + 1) % 3]] = np.nan
    mesh = Mesh(vertices_mm=vertices, faces=faces, sigma_mm=sigma)
    filled = np.isnan(sigma)
    each_mm = filled_sigma_mm(mesh, filled)[filled]
    assert (each_mm > SIGMA_MM / 2).all()
    assert propagate(mesh, filled.astype(float)) == pytest.approx(each_mm.sum(), rel=1e-6)


@pytest.mark.parametrize(
    ("patch_at", "half_mm", "by_one_vertex"),
    [
        ((88.5, 5.0, 0.0), 6.0, (0.80, 0.92)),  # the foremost vertex is near the patch's rim
        ((87.0, 8.0, 0.0), 6.0, (0.80, 0.92)),  # it was measured, beside the patch
        ((85.0, 10.0, 0.0), 10.0, (0.55, 0.75)),
        ((90.0, 0.0, 0.0), 10.0, (0.92, 0.98)),  # it is the patch's middle
        ((20.0, 27.0, 0.0), 10.0, (0.93, 0.97)),  # the patch is far from both ends
    ],
)
def test_the_reach_of_a_shell_holds_though_another_place_is_foremost_in_truth(
    patch_at: tuple[float, float, float], half_mm: float, by_one_vertex: tuple[float, float]
) -> None:
    """2000 true shells about one measured one: 95 of 100 reaches lie in the stated interval.

    By the sigma of the foremost vertex alone, fewer do where a patch lies beside it.
    """
    shell = trimesh.creation.icosphere(5, 1.0)
    vertices = np.asarray(shell.vertices, float) * (90.0, 30.0, 25.0)
    filled = np.linalg.norm(vertices - patch_at, axis=1) < half_mm
    sigma = np.where(filled, np.nan, SIGMA_MM).astype(np.float32)
    faces = np.asarray(shell.faces, np.int32)
    mesh = Mesh(vertices_mm=vertices, faces=faces, sigma_mm=sigma, correlation_mm=REACH_MM)
    reach_mm, by_normal = vertices[:, 0], mesh.vertex_normals()[:, 0]
    first = int(reach_mm.argmax())
    one = propagate(mesh, np.where(np.arange(len(mesh)) == first, by_normal, 0.0))
    assert one is not None
    every = np.arange(len(mesh))[:, None]
    beyond = extra_extremum_variance_mm2(mesh, reach_mm, every, by_normal[:, None])
    stated = np.sqrt(one**2 + beyond)

    patch, near = filled_sigma_mm(mesh, filled), np.flatnonzero(reach_mm > 60.0)
    measured = near[(reach_mm > 85.0)[near] & ~filled[near]]
    apart = np.linalg.norm(vertices[measured, None] - vertices[measured], axis=2)
    alike = np.exp(-((apart / REACH_MM) ** 2)) + 1e-6 * np.eye(len(measured))
    random = np.random.default_rng(7)
    errors = random.normal(size=(2000, 1)) * patch  # the patch as one piece
    errors[:, measured] = (
        SIGMA_MM * random.normal(size=(2000, len(measured))) @ np.linalg.cholesky(alike).T
    )
    off = (reach_mm + errors * by_normal)[:, near].max(1) - reach_mm[first]
    assert 0.93 <= np.mean(np.abs(off) <= 1.96 * stated) <= 0.97
    low, high = by_one_vertex
    assert low <= np.mean(np.abs(off) <= 1.96 * one) <= high


def _ball_with_a_patch(half_mm: float, *, both_ends: bool = False) -> Mesh:
    """A ball of 40 mm; within `half_mm` of its pole nothing is known. Measured without error."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=5, radius=40.0)
    vertices = np.asarray(ball.vertices, float)
    height = np.abs(vertices[:, 2]) if both_ends else vertices[:, 2]
    away_mm = 40.0 * np.arccos(np.clip(height / 40.0, -1, 1))
    sigma = np.where(away_mm < half_mm, np.nan, 0.0).astype(np.float32)
    return Mesh(vertices_mm=vertices, faces=np.asarray(ball.faces, np.int32), sigma_mm=sigma)


@pytest.mark.parametrize(("shape", "radius_mm"), [("ball", 50.0), ("hollow", 50.0), ("tube", 40.0)])
def test_flat_faces_lie_inside_a_round_surface_by_their_chordal_deviation(
    shape: str, radius_mm: float
) -> None:
    if shape == "tube":
        heights = np.linspace(-100.0, 100.0, 81)
        made = trimesh.creation.revolve(
            np.column_stack([np.full(81, radius_mm), heights]), sections=96
        )
        lost_mm = radius_mm / 2 * (1 - np.sinc(2 / 96))  # a circle's area less a polygon's
    else:
        made = trimesh.creation.icosphere(4, radius_mm)
        lost_mm = (4 / 3 * np.pi * radius_mm**3 - made.volume) / made.area
    faces = made.faces[:, ::-1] if shape == "hollow" else made.faces
    mesh = Mesh(vertices_mm=np.array(made.vertices), faces=np.array(faces, np.int32))
    told = mesh.chordal_deviations_mm()[np.abs(mesh.vertices_mm[:, 2]) < 90]
    assert told.mean() == pytest.approx(-lost_mm if shape == "hollow" else lost_mm, rel=0.03)
