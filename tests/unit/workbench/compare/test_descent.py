"""Shapes made from one another lie as they lie; where shape alone tells, its looseness is told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid
from limbgram.findings import note
from limbgram.workbench.compare.comparison import CompareOptions, compare
from limbgram.workbench.compare.levels import changes_by_level
from limbgram.workbench.compare.messages import comparison_lines
from limbgram.workbench.compare.registration import (
    Alignment,
    RegistrationOptions,
    alignment_as_made,
    as_is,
    by_shape,
)
from limbgram.workbench.limb import Landmark, Limb, LimbFrame, Origin

BY_SHAPE = CompareOptions(registration=RegistrationOptions(way="icp"))


def framed(limb: Limb, seed: int) -> Limb:
    """The limb lying in a mesh frame of its own."""
    pose = Rigid(Rotation.random(random_state=seed).as_matrix(), np.array([70.0, -20, 5]))
    mesh = limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm))
    return replace(limb, mesh=mesh, frame=LimbFrame(limb_from_mesh=pose.inverse, side="right"))


def scaled(limb: Limb, growth: np.ndarray) -> Limb:
    """Wider or narrower at each vertex, in its limb frame."""
    motion = limb.frame.limb_from_mesh
    inside = motion.apply(limb.mesh.vertices_mm)
    inside[:, :2] *= growth[:, None]
    return limb.with_mesh(limb.mesh.with_vertices(motion.inverse.apply(inside)))


def reduced(limb: Limb) -> Limb:
    """By 3 % of girth at 20 mm and less above, nothing from 160 mm; the tip stays."""
    heights = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)[:, 2]
    return scaled(limb, 1 - np.interp(heights, [20, 160], [0.03, 0.0]))


def ripple(limb: Limb, seed: int, size_mm: float) -> Limb:
    """Smooth waves of random direction along the normals, as a hand's or a limb's own changes."""
    rng = np.random.default_rng(seed)
    waves, phases = rng.normal(0, 1 / 25, (12, 3)), rng.uniform(0, 2 * np.pi, 12)
    off_mm = size_mm * np.sqrt(2 / 12) * np.cos(limb.mesh.vertices_mm @ waves.T + phases).sum(1)
    vertices = limb.mesh.vertices_mm + off_mm[:, None] * limb.mesh.vertex_normals()
    return limb.with_mesh(limb.mesh.with_vertices(vertices))


def stays(alignment: Alignment) -> bool:
    motion = alignment.first_from_second
    return bool(np.all(motion.rotation == np.eye(3)) and not motion.translation.any())


def test_what_was_taken_off_does_not_turn_into_a_slide(limb) -> None:
    """The reduction's volume, by the exact areas: known to the facets."""
    scan = framed(limb, 3)
    found = compare(scan, reduced(scan))
    assert found.alignment.way == "as-is"
    assert found.alignment.how.code == "compare.laid.made"
    girths = {level.height_mm: level.measures["tape_mm"].share for level in found.levels.levels}
    assert girths[20.0] == pytest.approx(-0.03, abs=1e-3)
    assert girths[100.0] == pytest.approx(-0.03 * 60 / 140, abs=1e-3)
    assert girths[180.0] == pytest.approx(0.0, abs=1e-6)
    assert not found.notes


def test_what_the_limb_files_name_lies_as_it_was_made_in_any_axes(limb) -> None:
    """Both made from one scan, one of them moved to axes of its own and made of fewer parts."""
    scan = framed(limb, 3)
    edited = reduced(scan)
    turn = Rigid(Rotation.random(random_state=7).as_matrix(), np.array([1.0, 2, 3]))
    moved = edited.with_mesh(edited.mesh.with_vertices(turn.apply(edited.mesh.vertices_mm)))
    own = Origin(sha256="scan", mm_per_unit=1.0, mesh_from_origin=Rigid.identity())
    scan = replace(scan, origins=(own,))
    other = Origin(sha256="edited", mm_per_unit=1.0, mesh_from_origin=turn)
    through = replace(own, mesh_from_origin=turn)
    moved = replace(moved.unaligned(), origins=(other, through))
    found = compare(scan, moved)
    assert found.alignment.way == "as-is"
    assert found.alignment.exact
    np.testing.assert_allclose(
        found.alignment.first_from_second.matrix_3x4, turn.inverse.matrix_3x4, atol=1e-12
    )
    girths = {level.height_mm: level.measures["tape_mm"].share for level in found.levels.levels}
    assert girths[20.0] == pytest.approx(-0.03, abs=1e-3)
    assert girths[180.0] == pytest.approx(0.0, abs=1e-6)
    back = alignment_as_made(moved, replace(edited.unaligned(), origins=(own,)))
    assert back is not None
    np.testing.assert_allclose(back.first_from_second.matrix_3x4, turn.matrix_3x4, atol=1e-12)
    # Read in another unit it is another shape.
    inches = replace(scan, origins=(replace(own, mm_per_unit=25.4),))
    assert alignment_as_made(inches, moved) is None


def test_frames_told_apart_from_how_a_shape_was_made_are_not_exact(limb) -> None:
    scan = framed(limb, 5)
    own = Origin(sha256="scan", mm_per_unit=1.0, mesh_from_origin=Rigid.identity())
    scan = replace(scan, origins=(own,))
    slip = Rigid.from_rotation_vector(np.zeros(3), np.array([0.0, 0, 1]))
    again = LimbFrame(limb_from_mesh=slip @ scan.frame.limb_from_mesh, side="right")
    assert as_is(scan, reduced(scan)).exact
    assert not as_is(scan, replace(reduced(scan), frame=again)).exact


def test_one_frame_to_the_last_digit_tells_descent_though_every_vertex_moved(make_limb) -> None:
    scan, other = framed(make_limb(), 3), framed(make_limb(spokes=77, rows=61, turn=0.03), 3)
    assert stays(alignment_as_made(scan, other))
    assert alignment_as_made(scan, framed(other, 4)) is None


def test_a_frame_along_the_files_own_axes_tells_nothing_by_itself(make_limb) -> None:
    """Files of some formats all carry the same one."""
    one, two = make_limb(), make_limb(spokes=77, rows=61, turn=0.03)
    assert alignment_as_made(one, two) is None
    mark = Landmark(name="fibula head", position_mm=np.array([50.0, 0, 170]))
    slipped = replace(mark, position_mm=mark.position_mm + 0.5)
    assert (
        alignment_as_made(replace(one, landmarks=(mark,)), replace(two, landmarks=(slipped,)))
        is None
    )
    assert (
        alignment_as_made(replace(one, landmarks=(mark,)), replace(two, landmarks=(mark,)))
        is not None
    )


def test_shared_vertices_tell_descent_whatever_frames_say(limb) -> None:
    """Aligned anew after the edit, or not at all: the files' coordinates are still the same."""
    scan = framed(limb, 5)
    slip = Rigid.from_rotation_vector(np.array([0.02, 0, 0.01]), np.array([0.0, 1, 4]))
    again = LimbFrame(limb_from_mesh=slip @ scan.frame.limb_from_mesh, side="right")
    for edited in (replace(reduced(scan), frame=again), reduced(scan).unaligned()):
        found = compare(scan, edited)
        assert stays(found.alignment)
        assert found.levels.levels[0].measures["tape_mm"].share == pytest.approx(-0.03, abs=1e-3)


def test_laid_by_shape_the_uncertainty_holds_the_slide(limb) -> None:
    """The reduction slides the limb; what the figures are off must lie within their sigmas."""
    scan = framed(limb, 3)
    known = replace(scan.mesh, sigma_mm=np.full(len(scan.mesh), 0.1, np.float32))
    scan = scan.with_mesh(known)
    true, slid = compare(scan, reduced(scan)), compare(scan, reduced(scan), BY_SHAPE)
    assert abs(slid.alignment.slid_mm) > 0.4
    assert "compare.shape.slides" in [note.code for note in slid.notes]
    volumes = true.levels.volume, slid.levels.volume
    off = volumes[1].difference - volumes[0].difference
    assert abs(off) > 5 * volumes[0].sigma, "sensor noise alone does not explain it"
    assert abs(off) < 3 * volumes[1].sigma
    assert volumes[1].sigma < 0.02 * volumes[1].first.value, "nor is everything allowed"


def test_where_the_uncertainty_leaves_the_alignment_out_it_says_so(limb) -> None:
    """Frames that were aligned each by itself err; a shape made from the other does not."""
    scan = framed(limb, 3)
    scan = scan.with_mesh(replace(scan.mesh, sigma_mm=np.full(len(scan.mesh), 0.1, np.float32)))
    other = framed(limb, 4)
    other = other.with_mesh(replace(other.mesh, sigma_mm=scan.mesh.sigma_mm))
    as_is = CompareOptions(registration=RegistrationOptions(way="as-is"))
    left_out = note("compare.within.of_scans")
    assert left_out in compare(scan, other, as_is).notes
    for options in (as_is, CompareOptions()):
        assert left_out not in compare(scan, reduced(scan), options).notes
    assert left_out not in compare(scan, other, BY_SHAPE).notes


def test_the_slide_is_off_by_what_is_told(limb) -> None:
    """Smooth ripples of 0.3 mm: errors of the place along the axis over their sigmas."""
    off: list[float] = []
    for seed in range(8):
        laid = by_shape(limb, ripple(limb, seed, 0.3))
        middle = laid.pose_covariance.middle_mm[None]
        slid = (laid.first_from_second.apply(middle) - middle)[0, 2]
        off.append(slid / np.sqrt(laid.pose_covariance.covariance_mm2[2, 2]))
    assert 0.3 < np.sqrt(np.mean(np.square(off))) < 1.6


def test_a_slide_goes_into_girths_and_volumes_by_closed_forms(make_limb) -> None:
    """A cone r = 30 + 0.2 z: the tape grows by 2 pi 0.2 a millimetre, the volume by the area."""
    cone = make_limb(lambda z, a: 30 + 0.2 * z + 0 * a, spokes=360, rows=200).mesh
    known = replace(cone, sigma_mm=np.full(len(cone), 1e-6, np.float32))
    sigma_mm, heights = 1.5, (60.0, 100.0, 140.0)
    found = changes_by_level(known, known, heights, sigma_mm)
    tape = found.levels[1].measures["tape_mm"]
    assert tape.sigma == pytest.approx(2 * np.pi * 0.2 * sigma_mm, rel=1e-2)
    areas = np.pi * (30 + 0.2 * np.array(heights)) ** 2
    assert found.volume.sigma == pytest.approx(areas[2] * sigma_mm, rel=1e-2)
    slab = found.levels[2].since_last
    assert slab.sigma == pytest.approx((areas[2] - areas[1]) * sigma_mm, rel=1e-2)
    assert changes_by_level(known, known, heights).volume.sigma < 1.0
    assert changes_by_level(cone, cone, heights, sigma_mm).volume.sigma is None


def test_a_mirror_image_is_pointed_out_and_a_changed_limb_is_not(make_limb) -> None:
    limb = make_limb(lambda z, a: 45 + 0.06 * z + 4 * np.sin(a + z / 40) + 3 * np.cos(2 * a))
    mesh = limb.mesh
    image = limb.with_mesh(
        replace(mesh, vertices_mm=mesh.vertices_mm * [-1.0, 1, 1], faces=mesh.faces[:, ::-1].copy())
    )
    assert "compare.shape.mirrored" in [one.code for one in by_shape(limb, image).notes]
    changed = ripple(limb, 2, 1.5)
    assert "compare.shape.mirrored" not in [one.code for one in by_shape(limb, changed).notes]


def test_columns_say_that_they_are_changes_and_slabs(limb) -> None:
    found = compare(limb, limb)
    heading = next(line for line in comparison_lines(found) if "tape mm" in line)
    for words in ("ML change", "AP change", "mL since last"):
        assert words in heading
    slabs = [level.since_last.second.value for level in found.levels.levels]
    assert sum(slabs) == pytest.approx(found.levels.volume.second.value)
