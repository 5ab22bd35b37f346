"""The comparison finds the errors that were put in, and only those."""

import numpy as np
import pytest

from limbgram.cli.demo import comparison_lines
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut, level_segments
from limbgram.report.alignment import Truth
from limbgram.report.comparison import area_mm2, compare_with_truth, girth_mm

RNG = np.random.default_rng(4)
CENTRES_MM = RNG.normal(size=(12, 3)) * [900, 900, 200]
WORLD = Rigid.from_rotation_vector(np.array([0.2, -0.1, 2.0]), np.array([300.0, -40.0, 11.0]))


def limb(swell_mm: float = 0.0, rings: int = 160, spokes: int = 200) -> Mesh:
    """A lumpy closed tube, 300 mm long, its wall moved outwards by about `swell_mm`."""
    azimuth, height = np.meshgrid(np.arange(spokes) * 2 * np.pi / spokes, np.linspace(0, 1, rings))
    radius = (55 + 8 * np.cos(2 * azimuth + 3 * height) + 6 * np.sin(9 * height)) * np.sin(
        0.25 + height * (np.pi - 0.5)
    ) ** 0.4 + swell_mm
    wall = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), 300 * height], axis=-1)
    vertices = np.concatenate([wall.reshape(-1, 3), [[0, 0, 0], [0, 0, 300.0]]])
    grid = np.arange(rings * spokes, dtype=np.int32).reshape(rings, spokes)
    a, b = grid[:-1], np.roll(grid, -1, axis=1)[:-1]
    c, d = np.roll(grid, -1, axis=1)[1:], grid[1:]
    ends = [
        np.stack([np.roll(grid[0], -1), grid[0], np.full(spokes, rings * spokes)], -1),
        np.stack([grid[-1], np.roll(grid[-1], -1), np.full(spokes, rings * spokes + 1)], -1),
    ]
    sides = [np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    return Mesh(vertices_mm=vertices, faces=np.concatenate([*sides, *ends]).astype(np.int32))


def truth() -> Truth:
    mesh = limb()
    seen = (mesh.vertices_mm[:, 2] > 10) & (mesh.vertices_mm[:, 2] < 290)
    return Truth(vertices_mm=mesh.vertices_mm, faces=mesh.faces, seen=seen, centres_mm=CENTRES_MM)


def moved(mesh: Mesh, scale: float = 1.0) -> Mesh:
    return mesh.with_vertices(WORLD.apply(scale * mesh.vertices_mm))


def test_the_truth_itself_has_no_error() -> None:
    result = compare_with_truth(moved(limb()), WORLD.apply(CENTRES_MM), truth())
    assert result.rms_mm < 1e-6
    assert abs(result.scale_error) < 1e-9
    assert result.covered == 1.0
    assert abs(result.volume_error) < 1e-9
    assert max(map(abs, result.girth_errors_mm)) < 1e-6
    seen_mm = limb().vertices_mm[truth().seen, 2]
    low, high = np.quantile(seen_mm, [0.02, 0.98])
    fifths = [low + (high - low) * share for share in (0.2, 0.4, 0.6, 0.8)]
    assert result.girth_heights_mm == pytest.approx(fifths)
    girths = next(line for line in comparison_lines(result) if "girths" in line)
    assert [f"at {height:.1f}" in girths for height in fifths] == [True] * 4


def test_a_wrong_scale_is_found_and_not_aligned_away() -> None:
    centres = WORLD.apply(1.002 * CENTRES_MM + RNG.normal(size=CENTRES_MM.shape) * 0.5)
    result = compare_with_truth(moved(limb(), 1.002), centres, truth())
    assert result.scale_error == pytest.approx(0.002, rel=0.05)
    assert 0.05 < result.rms_mm < 0.2
    # Between fixed heights two of three dimensions grow, and a little more where it tapers.
    assert 0.0038 < result.volume_error < 0.0050


def test_swelling_shows_in_mean_girth_and_volume() -> None:
    result = compare_with_truth(moved(limb(swell_mm=0.2)), WORLD.apply(CENTRES_MM), truth())
    assert result.mean_mm == pytest.approx(0.2, abs=0.02)
    assert result.girth_errors_mm == pytest.approx([2 * np.pi * 0.2] * 4, abs=0.06)
    assert 0.004 < result.volume_error < 0.01


def test_noise_shows_in_rms_and_half_a_surface_in_coverage() -> None:
    whole = limb(rings=320)
    noisy = whole.with_vertices(whole.vertices_mm + RNG.normal(size=(len(whole), 3)) * 0.1)
    low = noisy.faces[(noisy.vertices_mm[noisy.faces][:, :, 2] < 150).all(1)]
    lower = moved(Mesh(vertices_mm=noisy.vertices_mm, faces=low))
    used = np.unique(low)
    compact = np.full(len(lower), -1)
    compact[used] = np.arange(len(used))
    half = Mesh(vertices_mm=lower.vertices_mm[used], faces=compact[low].astype(np.int32))
    result = compare_with_truth(half, WORLD.apply(CENTRES_MM), truth())
    assert 0.45 < result.covered < 0.53
    assert np.isnan(result.girth_errors_mm).tolist() == [False, False, True, True]
    result = compare_with_truth(moved(noisy), WORLD.apply(CENTRES_MM), truth())
    assert 0.07 < result.rms_mm < 0.11
    assert 0.15 < result.p95_mm < 0.22


@pytest.mark.parametrize("torn", [False, True])
def test_girths_are_of_one_of_two_limbs(torn: bool) -> None:
    """Two legs, the other half as wide: a tape round both would read 400 mm more."""
    one = limb()
    small = one.with_vertices(one.vertices_mm * [0.5, 0.5, 1] + [200, 0, 0])
    faces = np.concatenate([one.faces, small.faces + len(one)]).astype(np.int32)
    both = Mesh(vertices_mm=np.concatenate([one.vertices_mm, small.vertices_mm]), faces=faces)
    known = Truth(
        vertices_mm=both.vertices_mm,
        faces=faces,
        seen=np.concatenate([truth().seen, np.zeros(len(small), bool)]),
        centres_mm=CENTRES_MM,
    )
    ours = limb(swell_mm=0.2)
    measured = both.with_vertices(np.concatenate([ours.vertices_mm, small.vertices_mm]))
    if torn:  # a slit up the front, away from the widest places
        middles = measured.vertices_mm[faces].mean(1)
        slit = (np.abs(middles[:, 1] - 4) < 3) & (middles[:, 0] > 0) & (middles[:, 0] < 100)
        measured = Mesh(vertices_mm=measured.vertices_mm, faces=faces[~slit])
    result = compare_with_truth(moved(measured), WORLD.apply(CENTRES_MM), known)
    assert result.girth_errors_mm == pytest.approx([2 * np.pi * 0.2] * 4, abs=0.3 if torn else 0.06)


def test_sections_of_a_cylinder() -> None:
    angle = np.arange(360) * 2 * np.pi / 360
    rim = np.stack([30 * np.cos(angle), 30 * np.sin(angle)], axis=1)
    vertices = np.concatenate([np.column_stack([rim, np.full(360, z)]) for z in (0.0, 10.0)])
    a = np.arange(360)
    b = np.roll(a, -1)
    faces = np.concatenate([np.stack(t, 1) for t in ((a, b, b + 360), (a, b + 360, a + 360))])
    tube = Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))
    segments = level_segments(tube, np.array([4.0])).at(0)
    assert len(segments) == 720
    along, inwards = segments[:, 1] - segments[:, 0], -segments[:, 0]
    assert (along[:, 0] * inwards[:, 1] > along[:, 1] * inwards[:, 0]).all()
    assert girth_mm(cut(tube, [4.0])) == pytest.approx(2 * np.pi * 30, rel=1e-4)
    assert area_mm2(segments) == pytest.approx(np.pi * 900, rel=1e-3)
