"""Which vertices have a patch, and what is known of the photos after a small move."""

import math

import numpy as np
import pytest

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.joint import GAIN, MEAN
from limbgram.reconstruction.measuring.measurement_pass import (
    ResidualOptions,
    independent_set,
    joint_equations,
    observe_surface,
    photometry_after,
    photometry_at,
    signal_share,
)
from limbgram.reconstruction.measuring.thin_plate import thin_plate_of

SIDE, EDGE_MM = 12, 1.5


def sheet(height_mm: float = 0.0) -> Mesh:
    """A rhomb of equilateral triangles round the middle of the painted plane."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(SIDE), np.arange(SIDE)))
    xy = EDGE_MM * np.column_stack([i + 0.5 * j, math.sqrt(3) / 2 * j])
    at = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    return Mesh(
        vertices_mm=np.column_stack([xy - xy.mean(0), np.full(len(xy), height_mm)]),
        faces=np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32),
    )


def test_patches_have_no_neighbours_and_leave_no_gap() -> None:
    neighbours = thin_plate_of(sheet()).neighbours
    chosen = independent_set(neighbours.indptr, neighbours.indices)
    beside = neighbours @ chosen.astype(float)
    assert not beside[chosen].any()
    assert beside[~chosen].all()
    assert 0.2 < chosen.mean() < 0.4


@pytest.mark.parametrize(("move_mm", "looks_again"), [(0.05, False), (0.3, True)])
def test_light_drifts_with_small_moves_and_is_looked_at_after_large_ones(
    painted, move_mm: float, looks_again: bool
) -> None:
    """A pixel of these photos is about a millimetre."""
    seen_by = np.tile(np.arange(5, dtype=np.int32), (SIDE * SIDE, 1))
    everywhere = np.arange(SIDE * SIDE)
    lights = []
    for mesh in (sheet(), sheet(move_mm)):
        seen = observe_surface(mesh, painted.imagery, painted.views, seen_by)
        lights.append(photometry_at(mesh, painted.imagery, seen, everywhere))
    before, fresh = lights
    moves_mm = np.full(SIDE * SIDE, move_mm)
    after = photometry_after(before, mesh, painted.imagery, seen, moves_mm)
    assert (fresh[..., GAIN] > 0).mean() > 0.9
    if looks_again:
        np.testing.assert_array_equal(after, fresh)
        return
    stays, drifts = (
        np.sqrt(np.mean((light[..., MEAN] - fresh[..., MEAN]) ** 2)) for light in (before, after)
    )
    assert drifts < 0.2 * stays
    np.testing.assert_array_equal(after[..., GAIN], before[..., GAIN])


def test_texture_that_photos_share_holds_and_noise_of_each_does_not(painted) -> None:
    """Photos of pure noise have slopes as steep as those of paint, and agree on nothing."""
    seen_by = np.tile(np.arange(5, dtype=np.int32), (SIDE * SIDE, 1))
    mesh = sheet()
    random = np.random.default_rng(3)
    found = painted.imagery.coefficients
    noise = (np.mean(found) + np.std(found) * random.normal(size=len(found))).astype(np.float32)
    shares = []
    for imagery in (painted.imagery, painted.imagery._replace(coefficients=noise)):
        seen = observe_surface(mesh, imagery, painted.views, seen_by)
        light = np.zeros((SIDE * SIDE, 5, 4), np.float32)
        light[..., GAIN], light[..., MEAN] = 1.0, np.mean(found)
        if imagery is painted.imagery:
            light = photometry_at(mesh, imagery, seen, np.arange(SIDE * SIDE))
        shares.append(signal_share(mesh, imagery, seen, light, ResidualOptions()))
    paint, bare = shares
    assert np.median(paint) > 0.7
    assert np.median(bare) < 0.35


def test_the_plate_is_as_stiff_where_most_of_the_limb_is_bare(painted) -> None:
    """Bare skin says little, of which the relief knows nothing."""
    seen_by = np.tile(np.arange(5, dtype=np.int32), (SIDE * SIDE, 1))
    mesh, options = sheet(), ResidualOptions()
    seen = observe_surface(mesh, painted.imagery, painted.views, seen_by)
    light = photometry_at(mesh, painted.imagery, seen, np.arange(SIDE * SIDE))
    signal = signal_share(mesh, painted.imagery, seen, light, options)
    whole = joint_equations(mesh, painted.imagery, seen, light, signal, options)
    bare = mesh.vertices_mm[:, 0] > np.quantile(mesh.vertices_mm[:, 0], 0.4)
    light[bare] = 0.0
    sparse = joint_equations(mesh, painted.imagery, seen, light, signal, options)
    usual = np.median(whole.weights), np.median(sparse.weights)
    assert usual[1] < 0.05 * usual[0]
    stiff = np.median(sparse.stiffness[sparse.stiffness > 0])
    assert 0.15 < stiff / np.median(whole.stiffness[whole.stiffness > 0]) < 2
