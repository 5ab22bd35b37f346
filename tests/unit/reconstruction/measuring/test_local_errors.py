"""The noise of photos that disagree, on a linear problem whose errors are drawn."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.rounds import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import (
    bending_of,
    quadrics,
    solve,
    tangent_axes,
    thin_plate_of,
)
from limbgram.reconstruction.measuring.uncertainty import local_errors

SIDE, EDGE_MM, PHOTOS = 60, 1.2, 5
LENGTH_MM = 0.8
NOISE_MM = 0.08
"""Of what one photo says about the offset of one face."""


@dataclass(frozen=True)
class Solved:
    mesh: Mesh
    seen: SeenSurface
    equations: JointEquations
    errors_mm: np.ndarray


def solved(common: float, seed: int, wave_mm: float = 0.0, shortest_mm: float = 4.0) -> Solved:
    """A flat surface (or one with waves of that amplitude) measured by photos that err alike."""
    mesh = _sheet()
    random = np.random.default_rng(seed)
    count = len(mesh.faces)
    shared, own = random.normal(size=(count, 1)), random.normal(size=(count, PHOTOS))
    noise = NOISE_MM * (np.sqrt(common) * shared + np.sqrt(1 - common) * own)
    true_mm = wave_mm * _waves(mesh.vertices_mm, random, shortest_mm)
    thin_plate = thin_plate_of(mesh)
    weight = 1 / NOISE_MM**2
    spread = sp.csr_matrix(
        (np.full(3 * count, 1 / 3), (np.repeat(np.arange(count), 3), mesh.faces.ravel())),
        (count, len(mesh)),
    )
    data = sp.csr_matrix(PHOTOS * weight * spread.T @ spread + 1e-3 * sp.eye(len(mesh)))
    told = noise + (spread @ true_mm)[:, None]
    right = weight * spread.T @ told.sum(1)
    system = sp.csr_matrix(
        data + bending_of(thin_plate, data.diagonal(), LENGTH_MM) @ thin_plate.laplacian
    )
    moved_mm = solve(system, right, np.zeros(len(mesh)))
    left = told - (spread @ moved_mm)[:, None]
    lifted = mesh.vertices_mm + moved_mm[:, None] * [0.0, 0.0, 1.0]
    mesh = mesh.with_vertices(lifted)
    axes = tangent_axes(np.tile([0.0, 0.0, 1.0], (len(mesh), 1)))
    seen = SeenSurface(
        thin_plate=thin_plate,
        axes=axes,
        quadric=0 * quadrics(mesh, thin_plate, axes),
        seen_by=np.tile(np.arange(PHOTOS, dtype=np.int32), (len(mesh), 1)),
        pixel_mm=np.full(len(mesh), EDGE_MM / 4.5),
    )
    equations = JointEquations(
        weights=data.diagonal(),
        soft=data,
        right=weight * spread.T @ left.sum(1),
        pull=(weight * left * np.sqrt(1 - 1 / PHOTOS)).astype(np.float32),  # texture takes one
        photos=np.full(len(mesh), PHOTOS),
        length_mm=LENGTH_MM,
    )
    return Solved(mesh, seen, equations, moved_mm - true_mm)


@pytest.mark.parametrize(("common", "low", "high"), [(0.0, 0.65, 0.82), (0.2, 0.8, 0.95)])
def test_noise_is_told_by_how_photos_disagree(common: float, low: float, high: float) -> None:
    """Whether photos err alike by nothing or by the most that captures showed, sigma is near.

    Errors of captures are alike by 0.05 to 0.2 (docs/method/uncertainty.md). A sheet without relief
    has no lost detail, so its sigma is somewhat wide.
    """
    ratios: list[float] = []
    for seed in range(4):
        found = solved(common, seed)
        sigma = np.sqrt(local_errors(found.mesh, found.seen, found.equations).variance_mm2)
        inside = _inside()
        ratios.append(float(np.sqrt(np.mean((found.errors_mm / sigma)[inside] ** 2))))
    assert low < np.mean(ratios) < high


def test_detail_that_the_thin_plate_takes_is_told() -> None:
    found = solved(0.1, 7, wave_mm=0.3)
    sigma = np.sqrt(local_errors(found.mesh, found.seen, found.equations).variance_mm2)
    inside = _inside()
    smooth = solved(0.1, 7)
    error, error_smooth = found.errors_mm[inside].std(), smooth.errors_mm[inside].std()
    assert error > 1.4 * error_smooth  # the waves were lost
    assert 0.7 < error / np.sqrt(np.mean(sigma[inside] ** 2)) < 1.4


@pytest.mark.parametrize(
    ("wave_mm", "shortest_mm"), [(0.3, 4.0), (0.3, 2.0), (0.1, 2.0), (0.0, 4.0)]
)
def test_a_line_gets_back_what_lost_relief_took_and_gives_what_noise_added(
    wave_mm: float, shortest_mm: float
) -> None:
    """Relief of 0.1 mm is half hidden in the noise: there the interval holds, no more."""
    truly: list[float] = []
    told: list[np.ndarray] = []
    for seed in range(3):
        found = solved(0.1, seed, wave_mm, shortest_mm)
        lift = found.mesh.vertices_mm[:, 2]
        inside = _inside()
        steep = [
            _squared_slope(found, one)[inside].mean() for one in (lift - found.errors_mm, lift)
        ]
        truly.append((steep[0] - steep[1]) / 4)
        lost = local_errors(found.mesh, found.seen, found.equations).lost_length
        told.append(lost[inside].mean(0))
    expected, sigma = np.mean(told, axis=0)
    assert abs(expected - np.mean(truly)) < 1.96 * sigma
    if wave_mm == 0.3:
        assert 0.6 < expected / np.mean(truly) < 2.2
        assert sigma < 0.6 * expected
    if wave_mm == 0:
        assert np.mean(truly) < 0
        assert expected < 0  # noise makes lines longer


def _squared_slope(found: Solved, lift: np.ndarray) -> np.ndarray:
    """Mean over each vertex's faces of the squared gradient, from the faces' corners."""
    mesh = found.mesh
    flat = mesh.vertices_mm[mesh.faces][:, :, :2]
    sides = flat[:, 1:] - flat[:, :1]
    rises = lift[mesh.faces][:, 1:] - lift[mesh.faces][:, :1]
    slopes = np.linalg.solve(sides, rises[..., None])[..., 0]
    square = np.repeat((slopes**2).sum(1), 3)
    corners = mesh.faces.ravel()
    count = np.maximum(np.bincount(corners, minlength=len(mesh)), 1)
    return np.bincount(corners, square, len(mesh)) / count


def test_a_vertex_of_a_single_photo_has_a_pixel() -> None:
    found = solved(0.1, 1)
    found.equations.photos[500] = 1
    sigma = np.sqrt(local_errors(found.mesh, found.seen, found.equations).variance_mm2)
    assert sigma[500] > EDGE_MM / 4.5 > 2 * np.median(sigma)


def test_what_goes_wild_in_one_place_makes_the_rest_no_less_sure() -> None:
    found = solved(0.1, 1)
    usual = np.sqrt(local_errors(found.mesh, found.seen, found.equations).variance_mm2)
    wild = (found.mesh.faces == 30 * SIDE + 30).any(1)
    found.equations.pull[wild] *= 1000
    sigma = np.sqrt(local_errors(found.mesh, found.seen, found.equations).variance_mm2)
    apart_mm = np.linalg.norm(
        found.mesh.vertices_mm - found.mesh.vertices_mm[30 * SIDE + 30], axis=1
    )
    far = _inside() & (apart_mm > 25)
    assert far.sum() > 500
    assert 0.98 < np.median(sigma[far] / usual[far]) < 1.05
    assert sigma[30 * SIDE + 30] > 1.5 * usual[30 * SIDE + 30]


def _sheet() -> Mesh:
    """A rhomb of equilateral triangles."""
    column, row = (part.ravel() for part in np.meshgrid(np.arange(SIDE), np.arange(SIDE)))
    at = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    x, y = EDGE_MM * (column + 0.5 * row), EDGE_MM * np.sqrt(3) / 2 * row
    return Mesh(
        vertices_mm=np.stack([x, y, np.zeros(len(x))], 1),
        faces=np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32),
    )


def _waves(points: np.ndarray, random: np.random.Generator, shortest_mm: float) -> np.ndarray:
    """Waves of up to 16 mm, the long ones higher; standard deviation 1."""
    lengths = np.geomspace(shortest_mm, 16.0, 20)
    heights = lengths**1.0
    heights *= np.sqrt(2) / np.linalg.norm(heights)
    total = np.zeros(len(points))
    for length, height in zip(lengths, heights, strict=True):
        turn, phase = random.uniform(0, 2 * np.pi, 2)
        along = points[:, 0] * np.cos(turn) + points[:, 1] * np.sin(turn)
        total += height * np.sin(2 * np.pi * along / length + phase)
    return total


def _inside() -> np.ndarray:
    """Vertices away from the rim."""
    place = np.arange(SIDE * SIDE)
    column, row = place % SIDE, place // SIDE
    return (np.minimum(column, row) > 6) & (np.maximum(column, row) < SIDE - 7)
