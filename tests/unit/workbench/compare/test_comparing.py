"""Radial errors, levels and verdicts of shapes whose differences are known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.topology import with_faces
from limbgram.findings import told
from limbgram.workbench.compare.comparison import CompareOptions, compare
from limbgram.workbench.compare.levels import changes_by_level, shared_heights_mm
from limbgram.workbench.compare.messages import verdict
from limbgram.workbench.compare.radial import radial_errors, spoke_radii
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.limb import LimbFrame

AS_IS = CompareOptions(registration=RegistrationOptions(way="as-is"))
FACET_MM = 0.02


def straight(z: np.ndarray, a: np.ndarray) -> np.ndarray:
    return 50.0 + 0 * z * a


def test_spokes_read_the_radius_where_front_and_right_are(make_limb) -> None:
    uneven = make_limb(spokes=360, rows=200)
    heights, angles = np.arange(60.0, 200, 10), np.arange(0.0, 360, 15)
    spokes = spoke_radii(uneven.mesh, heights, 24)
    corner = uneven.mesh.vertices_mm
    for k, angle in enumerate(np.radians(angles)):
        near = np.abs(np.arctan2(corner[:, 0], corner[:, 1]) - angle + 2 * np.pi) % (2 * np.pi)
        rib = corner[np.minimum(near, 2 * np.pi - near) < 1e-6]
        rib = rib[np.argsort(rib[:, 2])]
        expected = np.interp(heights, rib[:, 2], np.hypot(rib[:, 0], rib[:, 1]))
        np.testing.assert_allclose(spokes.radii_mm[:, k], expected, atol=1e-6)
    assert (spokes.facing > 0.9).all()


def test_spokes_cross_every_face_round_the_axis_once(make_limb) -> None:
    """Low in the dome the faces are narrow and one vertex lies on the axis."""
    spokes = spoke_radii(make_limb().mesh, np.array([0.05, 1.0, 5.0]), 212)
    assert np.isfinite(spokes.radii_mm).all()
    missing = spoke_radii(make_limb().mesh, np.array([-1.0, 300.0]), 4)
    assert np.isnan(missing.radii_mm).all()


def test_a_wider_wall_is_its_own_radial_error(make_limb) -> None:
    first, second = make_limb(straight), make_limb(lambda z, a: straight(z, a) + 0.3 * (z > 45))
    found = radial_errors(first.mesh, second.mesh, 5.0)
    wall = found.errors_mm[found.heights_mm > 50]
    np.testing.assert_allclose(wall[np.isfinite(wall)], 0.3, atol=1e-3)
    assert np.isfinite(wall).mean() > 0.9


def test_a_shift_is_shape_and_not_size(make_limb) -> None:
    """Shifted by e the errors are e cos(angle) - (e sin(angle))^2 / 2 r: quartiles +-e / sqrt2."""
    first = make_limb(straight, spokes=707)
    second = first.mesh.with_vertices(first.mesh.vertices_mm + np.array([0.6, 0, 0]))
    found = radial_errors(first.mesh, second, 5.0)
    wall = found.errors_mm[(found.heights_mm > 50) & (found.heights_mm < 210)]
    assert wall.mean() == pytest.approx(-(0.6**2) / (4 * 50), abs=1e-3)
    spread = np.quantile(wall, 0.75) - np.quantile(wall, 0.25)
    assert spread == pytest.approx(2 * 0.6 / np.sqrt(2), rel=0.03)
    right = wall[:, np.argmin(np.abs(found.angles_deg - 90))]
    np.testing.assert_allclose(right, 0.6, atol=1e-2)


def test_shapes_beside_the_axis_have_no_radial_error(make_limb) -> None:
    first = make_limb(straight)
    aside = first.mesh.with_vertices(first.mesh.vertices_mm + np.array([0, 0, 900.0]))
    with pytest.raises(MeasureError, match="spokes"):
        radial_errors(first.mesh, aside, 5.0)


def test_one_ply_of_volume_is_one_ply(make_limb) -> None:
    first = make_limb(straight)
    vertices = first.mesh.vertices_mm * [np.sqrt(1.011), np.sqrt(1.011), 1]
    heights = shared_heights_mm(first.mesh, first.mesh, 20.0)
    assert heights == (20, 40, 60, 80, 100, 120, 140, 160, 180, 200)
    found = changes_by_level(first.mesh, first.mesh.with_vertices(vertices), heights)
    assert found.plies == pytest.approx(1.0, abs=1e-9)
    assert found.from_mm is None
    assert found.to_mm == 200
    for level in found.levels:  # smoothing has a scale of its own: 2e-7 of the girth
        assert level.measures["tape_mm"].share == pytest.approx(np.sqrt(1.011) - 1, abs=1e-6)
        assert level.measures["area_mm2"].share == pytest.approx(0.011, abs=1e-9)
        assert level.since_last.share == pytest.approx(0.011, abs=1e-9)
    whole = sum(level.since_last.difference for level in found.levels)
    assert whole == pytest.approx(found.volume.difference)


def test_sigmas_of_both_scans_make_that_of_the_change(make_limb) -> None:
    first = make_limb(straight)
    known = replace(first.mesh, sigma_mm=np.full(len(first.mesh), 0.1, np.float32))
    change = changes_by_level(known, known, (100.0, 150.0)).volume
    assert change.sigma == pytest.approx(np.hypot(change.first.sigma, change.second.sigma))
    assert change.sigma > 0
    assert changes_by_level(known, first.mesh, (100.0, 150.0)).volume.sigma is None


def test_what_one_scan_lost_is_no_difference(make_limb) -> None:
    """Both girths are the limb's, or both the surface's: a scan and its own STL are the same."""
    bare = make_limb().mesh
    sigma = np.full(len(bare), 0.01, np.float32)
    lost = np.tile(np.float32([1e-3, 1e-4]), (len(bare), 1))
    scan = replace(bare, sigma_mm=sigma, lost_length=lost)
    upright = np.tile(np.float32([0.0, 0.0, 1e-3]), (len(bare), 1))  # folds that girths run along
    told = replace(scan, lost_across=upright)
    heights = (100.0, 150.0)
    own = changes_by_level(told, told, heights).levels[0].measures["contour_mm"]
    older = changes_by_level(told, scan, heights).levels[0].measures["contour_mm"]
    assert abs(older.difference) < 1e-9  # a scan from before which way was kept
    assert own.first.value < older.first.value
    for second, more in ((bare, 0.0), (scan, 1e-3)):
        measures = changes_by_level(scan, second, heights).levels[0].measures
        own = changes_by_level(bare, bare, heights).levels[0].measures["contour_mm"].first.value
        assert abs(measures["contour_mm"].difference) < 1e-9
        assert measures["contour_mm"].first.value == pytest.approx((1 + more) * own)


def test_lost_folds_are_turned_with_a_scan_that_lies_elsewhere(make_limb) -> None:
    """Folds across the axis, which girths run along, are so however the file lies."""
    bare = make_limb().mesh
    told = replace(
        bare,
        sigma_mm=np.full(len(bare), 0.01, np.float32),
        lost_length=np.tile(np.float32([1e-3, 1e-4]), (len(bare), 1)),
        lost_across=np.tile(np.float32([0.0, 0.0, 1e-3]), (len(bare), 1)),
    )
    (level,) = changes_by_level(told, told, (100.0,)).levels
    pose = Rigid.from_rotation_vector(np.array([1.2, 0.3, -0.4]), np.array([90.0, -20, 40]))
    frame = LimbFrame(limb_from_mesh=pose, side="right")
    lying = make_limb().with_mesh(told.moved(pose.inverse)).with_frame(frame)
    (found,) = (
        one
        for one in compare(lying, lying, CompareOptions(spacing_mm=100)).levels.levels
        if one.height_mm == 100
    )
    girth, own = (one.measures["contour_mm"].first.value for one in (found, level))
    assert girth == pytest.approx(own, abs=1e-3)


def test_a_hole_is_said_and_not_passed_over(make_limb) -> None:
    first = make_limb(straight)
    holed = replace(first.mesh, faces=np.delete(first.mesh.faces, 3000, axis=0))
    low, high = sorted(holed.vertices_mm[first.mesh.faces[3000]][:, 2])[::2]
    heights = (low - 10, (low + high) / 2, high + 10)
    found = changes_by_level(first.mesh, holed, heights)
    assert found.volume is None
    assert found.reason is not None
    assert found.reason.code == "measure.volume.open"
    assert [level.reason is None for level in found.levels] == [True, False, True]


def test_one_level_above_an_open_end_has_no_volume(make_limb) -> None:
    tube = make_limb(straight).mesh
    tube = with_faces(tube, tube.faces[tube.vertices_mm[tube.faces][:, :, 2].min(1) > 60])
    found = changes_by_level(tube, tube, (120.0,))
    assert found.volume is None
    assert found.plies is None
    assert found.reason is not None
    assert found.reason.code == "compare.levels.one_shared"
    assert found.levels[0].measures["tape_mm"].difference == 0


def test_a_body_inside_takes_no_part(limb) -> None:
    """A bone of the limb's own shape at 0.4 of its size, in both."""
    small = limb.mesh.vertices_mm * 0.4 + np.array([0, 0, 60.0])
    inner = limb.mesh.faces[limb.mesh.vertices_mm[limb.mesh.faces][:, :, 2].max(1) < 1e9]
    cap = np.concatenate([inner, _closing(limb)]) + len(small)
    mesh = replace(
        limb.mesh,
        vertices_mm=np.concatenate([limb.mesh.vertices_mm, small]),
        faces=np.concatenate([limb.mesh.faces, cap]).astype(np.int32),
    )
    found = compare(limb, limb.with_mesh(mesh), AS_IS)
    assert found.levels.volume.difference == pytest.approx(0.0, abs=1e-6)
    assert any("1 body inside" in told(note) for note in found.notes)


def _closing(limb) -> np.ndarray:
    """A fan over the brim from its first vertex."""
    brim = np.flatnonzero(limb.mesh.vertices_mm[:, 2] > limb.mesh.vertices_mm[:, 2].max() - 1e-6)
    return np.column_stack([np.full(len(brim) - 2, brim[0]), brim[2:], brim[1:-1]])


@pytest.mark.parametrize(
    ("bulge_mm", "one_side_mm", "grade"),
    [
        (0.05, 0.0, "alike"),
        (0.6, 0.0, "size differs"),
        (0.0, 1.2, "shape differs"),
        (0.6, 1.2, "size and shape differ"),
    ],
)
def test_the_verdict_follows_the_limits(make_limb, bulge_mm, one_side_mm, grade) -> None:
    first = make_limb(straight)
    second = make_limb(lambda z, a: 50.0 + bulge_mm + one_side_mm * np.sin(a) + 0 * z)
    found = compare(first, second, AS_IS)
    assert verdict(found).grade == grade
    assert verdict(found).finding.values["how"] == found.alignment.how
    assert not found.notes


@pytest.mark.parametrize(
    ("place", "limit", "beyond", "grade"),
    [
        ("radial.mre_mm", 0.25, 0.251, "size differs"),
        ("radial.mre_mm", -0.25, -0.251, "size differs"),
        ("radial.iqr_mm", 0.40, 0.401, "shape differs"),
        ("deviation.on_first.figures.far_mm2", 99.9, 100.0, "differs in places"),
    ],
)
def test_the_grade_changes_at_its_limit(make_limb, place, limit, beyond, grade) -> None:
    same = make_limb(straight)
    found = compare(same, same, AS_IS)
    assert verdict(put(found, place, limit)).grade == "alike"
    assert verdict(put(found, place, beyond)).grade == grade


def put(tree: object, place: str, value: float) -> Any:
    """The tree with another value at a place such as `radial.mre_mm`."""
    first, _, rest = place.partition(".")
    return replace(tree, **{first: put(getattr(tree, first), rest, value) if rest else value})


def test_a_small_place_that_moved_by_much_is_not_called_alike(limb) -> None:
    """A dent of 4 mm and 2 cm: the mean and the quartiles of all spokes do not see it."""
    vertices = limb.mesh.vertices_mm
    off = np.linalg.norm(
        vertices - vertices[np.argmax(vertices[:, 1] - np.abs(vertices[:, 2] - 150))], axis=1
    )
    moved = -4 * np.exp(-((off / 10) ** 2))[:, None] * limb.mesh.vertex_normals()
    found = compare(limb, limb.with_mesh(limb.mesh.with_vertices(vertices + moved)), AS_IS)
    judged = verdict(found)
    assert abs(found.radial.mre_mm) < 0.25
    assert found.radial.iqr_mm < 0.4
    assert judged.grade == "differs in places"
    expected_cm2 = np.pi * np.log(4) * 10**2 / 100
    assert found.deviation.on_first.figures.far_mm2 / 100 == pytest.approx(expected_cm2, rel=0.15)
    assert "cm2 differ by more than 1 mm" in told(judged.finding)


def test_swapping_the_shapes_turns_every_sign(make_limb, limb) -> None:
    other = make_limb(lambda z, a: 47 + 0.05 * z + np.sin(a))
    there, back = compare(limb, other, AS_IS), compare(other, limb, AS_IS)
    assert there.radial.mre_mm == pytest.approx(-back.radial.mre_mm)
    assert there.levels.volume.difference == pytest.approx(-back.levels.volume.difference)
    np.testing.assert_array_equal(
        there.deviation.on_first.difference_mm, -back.deviation.on_second.difference_mm
    )


def test_a_larger_second_is_called_larger(make_limb) -> None:
    second = make_limb(lambda z, a: 50.5 + 0 * z * a)
    found = told(verdict(compare(make_limb(straight), second, AS_IS)).finding)
    assert "larger" in found
    assert "smaller" not in found
    assert "mean radial error +0." in found
    assert "2.0% larger" in found.replace("(2.0%)", "2.0%")


def test_by_volume_both_hold_the_same_below_the_brim(limb) -> None:
    thinner = limb.with_mesh(
        limb.mesh.with_vertices(limb.mesh.vertices_mm * np.array([0.99, 0.99, 1.0]))
    )
    by_volume = CompareOptions(registration=RegistrationOptions(way="volume"), spacing_mm=10)
    found = compare(limb, thinner, by_volume)
    assert found.alignment.way == "volume"
    assert found.alignment.how.code == "compare.laid.volume"
    top = found.levels.levels[-1].height_mm
    assert top > 190
    assert abs(found.levels.volume.share) < 0.004 < 1 - 0.99**2


def test_an_unaligned_first_shape_is_compared_along_its_fitted_axis(limb, move) -> None:
    lying = move(limb, Rigid.from_rotation_vector(np.array([0.9, 0.4, -1.1]), np.ones(3) * 50))
    found = compare(lying, lying, AS_IS)
    assert not found.axes.anatomical
    assert "compare.axes.fitted" in [note.code for note in found.notes]
    assert found.first_in_limb.vertices_mm[:, 2].min() == pytest.approx(0.0, abs=0.5)
    assert found.levels.levels[0].measures["tape_mm"].first.value > 200


def test_a_left_and_a_right_limb_are_pointed_out(limb) -> None:
    """Also where the second is the first's own mirror image, which lies as it was made."""
    image = do_edit(limb, Mirror(confirmed_side="left"))
    (said,) = (one for one in compare(limb, image).notes if one.code == "compare.sides.differ")
    assert said.values == {"first": "right", "second": "left"}
    back = do_edit(image, Mirror(confirmed_side="right"))
    assert not any(one.code == "compare.sides.differ" for one in compare(limb, back).notes)


def test_different_socks_are_pointed_out(limb) -> None:
    found = compare(limb, replace(limb, sock_mm=0.3), AS_IS)
    (said,) = (one for one in found.notes if one.code == "compare.socks.differ")
    assert said.values == {"first_mm": 0.0, "second_mm": 0.3, "apart_mm": 0.3}


def test_options_that_cannot_be_are_refused(limb) -> None:
    with pytest.raises(OptionsError, match="apart"):
        compare(limb, limb, CompareOptions(spacing_mm=0.0))
    with pytest.raises(OptionsError, match="brim"):
        compare(limb, limb, CompareOptions(registration=RegistrationOptions(brim_mm=-1.0)))


def test_levels_lie_a_millimetre_apart_at_least(limb) -> None:
    spacings = [CompareOptions(registration=AS_IS.registration, spacing_mm=s) for s in (1.0, 0.99)]
    small = limb.with_mesh(limb.mesh.with_vertices(0.25 * limb.mesh.vertices_mm))
    compare(small, small, spacings[0])
    with pytest.raises(OptionsError) as refused:
        compare(small, small, spacings[1])
    assert refused.value.finding.code == "compare.spacing.small"


@pytest.mark.parametrize(("sock_mm", "told"), [(0.009, False), (0.0101, True)])
def test_socks_that_differ_by_a_hundredth_of_a_millimetre_are_told(limb, sock_mm, told) -> None:
    found = compare(limb, replace(limb, sock_mm=limb.sock_mm + sock_mm), AS_IS)
    assert any("sock" in one.code for one in found.notes) == told
