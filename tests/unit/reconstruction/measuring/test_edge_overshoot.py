"""Lips at a sharp edge are laid back and told; bulges and edges stay."""

from dataclasses import replace

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.edge_overshoot import without_overshoot

RADIUS_MM, HEIGHT_MM, STEP_MM, COLUMNS = 30.0, 60.0, 3.0, 63


def cut_cast() -> Mesh:
    """A closed cylinder with two sharp edges, well measured but for the edges."""
    inner = np.arange(STEP_MM, RADIUS_MM, STEP_MM)
    levels = np.arange(0.0, HEIGHT_MM + 1e-9, STEP_MM)
    radius = np.concatenate([inner, np.full(len(levels), RADIUS_MM), inner[::-1]])
    height = np.concatenate([0 * inner, levels, 0 * inner + HEIGHT_MM])
    angle = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    rings = np.stack(
        [
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
            np.repeat(height[:, None], COLUMNS, 1),
        ],
        axis=-1,
    ).reshape(-1, 3)
    row, column = np.mgrid[: len(radius) - 1, :COLUMNS]
    here, there = row * COLUMNS + column, row * COLUMNS + (column + 1) % COLUMNS
    quads = np.stack([here, there, there + COLUMNS, here + COLUMNS], -1).reshape(-1, 4)
    low, high = len(rings), len(rings) + 1
    around, last = np.arange(COLUMNS), (len(radius) - 1) * COLUMNS
    following = (around + 1) % COLUMNS
    faces = np.concatenate(
        [
            quads[:, [0, 1, 2]],
            quads[:, [0, 2, 3]],
            np.stack([np.full(COLUMNS, low), following, around], -1),
            np.stack([np.full(COLUMNS, high), last + around, last + following], -1),
        ]
    )
    vertices = np.concatenate([rings, [[0.0, 0.0, 0.0], [0.0, 0.0, HEIGHT_MM]]])
    off_edge_mm = np.hypot(
        np.hypot(vertices[:, 0], vertices[:, 1]) - RADIUS_MM,
        np.minimum(vertices[:, 2], HEIGHT_MM - vertices[:, 2]),
    )
    sigma = np.where(off_edge_mm < 2.1 * STEP_MM, 0.3, 0.05).astype(np.float32)
    return Mesh(
        vertices_mm=vertices,
        faces=faces.astype(np.int32),
        filled=np.zeros(len(vertices), np.bool_),
        sigma_mm=sigma,
    )


def with_lip(mesh: Mesh) -> Mesh:
    """A tenth of the upper edge stands up by 5 mm, and what lies inside of it by half of that."""
    x, y, z = mesh.vertices_mm.T
    beside = (z == HEIGHT_MM) & (np.abs(np.arctan2(y, x)) < 0.3)
    at_edge = beside & (np.hypot(x, y) > RADIUS_MM - 0.1)
    inside = beside & ~at_edge & (np.hypot(x, y) > RADIUS_MM - 1.1 * STEP_MM)
    raised = mesh.vertices_mm.copy()
    raised[at_edge, 2] += 5.0
    raised[inside, 2] += 2.5
    return mesh.with_vertices(raised)


def test_a_lip_goes_back_to_the_cut_and_is_told_as_filled() -> None:
    flat = cut_cast()
    standing = with_lip(flat)
    out = standing.vertices_mm[:, 2] > HEIGHT_MM + 1.0
    assert out.sum() > 10

    laid = without_overshoot(standing)
    assert laid.filled is not None
    assert laid.sigma_mm is not None
    off_mm = np.linalg.norm(laid.vertices_mm - flat.vertices_mm, axis=1)
    assert laid.vertices_mm[:, 2].max() < HEIGHT_MM + 0.8
    assert off_mm.max() < STEP_MM  # along the cut; what stood out stood out by 5 mm
    assert laid.filled[out].all()
    assert np.array_equal(np.isnan(laid.sigma_mm), laid.filled)
    same = ~laid.filled
    assert np.array_equal(laid.vertices_mm[same], standing.vertices_mm[same])
    assert laid.filled.sum() < 3 * out.sum()


def test_a_sharp_edge_without_a_lip_stays_as_it_was_measured() -> None:
    flat = cut_cast()
    assert without_overshoot(flat) is flat


def test_a_round_bulge_that_was_measured_roughly_stays() -> None:
    flat = cut_cast()
    x, y, z = flat.vertices_mm.T
    away_mm = np.hypot(y, z - HEIGHT_MM / 2)
    bulge = (x > 0) & (away_mm < 12.0)
    raised = flat.vertices_mm.copy()
    raised[bulge, 0] += 2.0 * np.cos(away_mm[bulge] / 12.0 * np.pi / 2)
    assert flat.sigma_mm is not None
    sigma = np.where(bulge, np.float32(0.3), flat.sigma_mm)
    bulging = replace(flat.with_vertices(raised), sigma_mm=sigma)
    assert without_overshoot(bulging) is bulging


def test_what_stands_out_far_is_no_lip() -> None:
    flat = cut_cast()
    raised = with_lip(flat).vertices_mm
    out = raised[:, 2] > HEIGHT_MM + 1.0
    raised[out, 2] += 10.0
    far = flat.with_vertices(raised)
    assert without_overshoot(far) is far
