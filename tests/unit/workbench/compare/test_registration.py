"""Poses that are known beforehand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.compare.counterparts import CounterpartSurface
from limbgram.workbench.compare.frames import mesh_in_frame
from limbgram.workbench.compare.icp import IcpOptions, measured_samples, run_icp
from limbgram.workbench.compare.registration import (
    RegistrationOptions,
    as_is,
    by_landmarks,
    by_shape,
    slide_to_volume,
)
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame


def uneven(height_mm: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """A radius of which no two sides are alike, mm."""
    crest = 0.04 * np.exp(4 * (np.cos(angle) - 1)) * np.sin(height_mm / 60)
    flat = 0.05 * np.cos(2 * angle) + 0.03 * np.cos(3 * angle + 0.4)
    return (45 + 0.06 * height_mm) * (1 + flat + crest)


def pose_of(seed: int) -> Rigid:
    shift = np.random.default_rng(seed).normal(0, 150, 3)
    return Rigid(Rotation.random(random_state=seed).as_matrix(), shift)


def nearly_told(limb: Limb, pose: Rigid) -> Limb:
    """The limb lying elsewhere, aligned to some degrees and millimetres, so one start is enough."""
    slip = Rigid.from_rotation_vector(np.array([0.04, -0.05, 0.09]), np.array([4.0, -3, 6]))
    mesh = limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=slip @ pose.inverse, side="right"))


def worst_mm(found: Rigid, true: Rigid, limb: Limb) -> float:
    """Largest distance of a vertex from where it belongs."""
    off = found.apply(true.apply(limb.mesh.vertices_mm)) - limb.mesh.vertices_mm
    return float(np.linalg.norm(off, axis=1).max())


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_copy_that_lies_anywhere_comes_back(limb, move, seed: int) -> None:
    true = pose_of(seed)
    found = by_shape(limb, move(limb, true))
    assert worst_mm(found.first_from_second, true, limb) < 1e-4
    assert found.rms_mm < 1e-4
    assert not found.notes


def test_other_triangles_of_the_same_shape_cost_their_facets_and_no_more(make_limb, limb) -> None:
    true = pose_of(4)
    other = make_limb(spokes=77, rows=61, turn=0.03)
    found = by_shape(limb, nearly_told(other, true))
    assert 1e-6 < worst_mm(found.first_from_second, true, limb) < 0.05
    assert 1e-3 < found.rms_mm < 0.1


def test_a_fifth_of_the_surface_that_changed_does_not_turn_the_rest(limb) -> None:
    vertices = limb.mesh.vertices_mm
    near = np.exp(-(((vertices - [48, 0, 120]) / 28) ** 2).sum(1))
    swollen = limb.with_mesh(
        limb.mesh.with_vertices(vertices + 6 * near[:, None] * limb.mesh.vertex_normals())
    )
    true = pose_of(5)
    found = by_shape(limb, nearly_told(swollen, true))
    assert worst_mm(found.first_from_second, true, limb) < 0.05
    assert found.rms_mm > 0.3


def test_a_shorter_scan_is_found_on_a_longer_one(limb) -> None:
    vertices = limb.mesh.vertices_mm
    kept = limb.mesh.faces[(vertices[limb.mesh.faces][:, :, 2] < 150).all(1)]
    used, faces = np.unique(kept, return_inverse=True)
    short = Mesh(vertices_mm=vertices[used], faces=faces.reshape(-1, 3).astype(np.int32))
    true = pose_of(6)
    found = by_shape(limb, nearly_told(Limb(mesh=short), true))
    assert worst_mm(found.first_from_second, true, limb) < 1e-4


def test_a_turn_that_the_shape_does_not_tell_is_named(make_limb) -> None:
    round_limb = make_limb(lambda z, a: 45 + 0.1 * z + 0 * a)
    open_motions = [
        one for one in by_shape(round_limb, round_limb).notes if one.code == "compare.shape.open"
    ]
    assert [one.values["turning"] for one in open_motions] == [True]


def test_shapes_that_hardly_meet_are_refused(limb) -> None:
    """Of a whole limb a narrow ring shows a twentieth; a ring within its brim shows nothing."""
    low = limb.mesh.vertices_mm[limb.mesh.faces][:, :, 2].min(1)
    ring = limb.with_mesh(replace(limb.mesh, faces=limb.mesh.faces[(low > 80) & (low < 92)]))
    with pytest.raises(MeasureError, match="do not overlap"):
        by_shape(ring, limb, RegistrationOptions(brim_mm=1.0))
    with pytest.raises(MeasureError, match="no measured surface"):
        by_shape(limb, ring, RegistrationOptions(brim_mm=20.0))


def test_shapes_that_stay_far_apart_are_pointed_out(limb) -> None:
    twice = limb.with_mesh(limb.mesh.with_vertices(1.15 * limb.mesh.vertices_mm))
    assert "compare.shape.far" in [note.code for note in by_shape(limb, twice).notes]
    assert not by_shape(limb, limb).notes


PLACES = {
    "patellar tendon": [0.0, 50, 180],
    "fibula head": [52.0, 0, 170],
    "tibia end": [10.0, 30, 30],
    "popliteal crease": [0.0, -50, 185],
}


def sized(limb: Limb, factor: float) -> Limb:
    """The limb lying elsewhere, of another size."""
    grown = limb.with_mesh(limb.mesh.with_vertices(limb.mesh.vertices_mm * factor))
    return nearly_told(grown, pose_of(6))


@pytest.mark.parametrize(("factor", "word"), [(0.7, "30% narrower"), (1.3, "30% wider")])
def test_limbs_of_grossly_different_sizes_are_refused(limb, factor: float, word: str) -> None:
    with pytest.raises(MeasureError, match=f"{word}.*--align landmarks"):
        by_shape(limb, sized(limb, factor))


@pytest.mark.parametrize("width_mm", [55, pytest.param(150, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("factor", "word"),
    [pytest.param(0.82, "18% narrower", marks=pytest.mark.slow), (1.2, "20% wider")],
)
def test_sizes_are_judged_by_the_width_of_the_limb(limb, width_mm, factor, word) -> None:
    """The limb is 102 mm wide; a child's or an arm gets the same answer as a thigh."""
    other = limb.with_mesh(limb.mesh.with_vertices(limb.mesh.vertices_mm * (width_mm / 102)))
    with pytest.raises(MeasureError, match=word):
        by_shape(other, sized(other, factor))
    nearly = by_shape(other, sized(other, 0.88 if factor < 1 else 1.12))
    assert "compare.shape.other_size" in [note.code for note in nearly.notes]


@pytest.mark.parametrize(
    ("factor", "word"),
    [
        pytest.param(0.92, "smaller", marks=pytest.mark.slow),
        pytest.param(0.95, "smaller", marks=pytest.mark.slow),
        (1.05, "larger"),
        pytest.param(1.08, "larger", marks=pytest.mark.slow),
    ],
)
def test_a_difference_in_size_that_lets_shapes_slide_is_told(limb, factor, word) -> None:
    (note,) = (
        one
        for one in by_shape(limb, sized(limb, factor)).notes
        if one.code == "compare.shape.other_size"
    )
    assert note.values["larger"] == (word == "larger")
    assert abs(100 * note.values["share"] - 100 * abs(factor - 1)) < 0.6


@pytest.mark.parametrize("factor", [pytest.param(1.015, marks=pytest.mark.slow), 0.985])
def test_a_usual_change_in_size_is_no_reason_to_warn(limb, factor: float) -> None:
    assert not by_shape(limb, sized(limb, factor)).notes


def marked(limb: Limb, pose: Rigid, off: dict[str, np.ndarray] | None = None) -> Limb:
    places = {name: np.array(place) + (off or {}).get(name, 0.0) for name, place in PLACES.items()}
    marks = tuple(
        Landmark(name=name, position_mm=pose.apply(place[None])[0])
        for name, place in places.items()
    )
    return replace(limb, landmarks=marks)


def test_exact_landmarks_give_the_exact_pose(limb) -> None:
    true = pose_of(7)
    found = by_landmarks(marked(limb, Rigid.identity()), marked(limb, true), {})
    assert worst_mm(found.first_from_second, true, limb) < 1e-9


def test_a_slipped_landmark_counts_by_its_weight(limb) -> None:
    true = pose_of(8)
    first, second = marked(limb, Rigid.identity()), marked(limb, true, {"tibia end": [9.0, 0, 0]})
    errors = [
        worst_mm(by_landmarks(first, second, {"tibia end": w}).first_from_second, true, limb)
        for w in (1.0, 0.1, 0.0)
    ]
    assert errors[0] > 1.5 * errors[1] > 1.0
    assert errors[2] < 1e-9
    laid = by_landmarks(first, second, {})
    assert laid.how.values["rms_mm"] == laid.rms_mm
    assert 1.0 < laid.rms_mm < 9.0 / np.sqrt(len(PLACES))


def test_landmarks_that_tell_no_pose_are_refused(limb) -> None:
    first = marked(limb, Rigid.identity())
    with pytest.raises(MeasureError, match="2 landmarks"):
        by_landmarks(first, replace(first, landmarks=first.landmarks[:2]), {})
    line = replace(
        first,
        landmarks=tuple(
            Landmark(name=f"p{k}", position_mm=np.array([0, 50.0, 40 * k])) for k in range(4)
        ),
    )
    with pytest.raises(MeasureError, match="one line"):
        by_landmarks(line, line, {})
    with pytest.raises(OptionsError, match="elbow"):
        by_landmarks(first, first, {"elbow": 2.0})


def test_as_is_takes_limb_frame_to_limb_frame(limb) -> None:
    true = pose_of(9)
    other = replace(
        limb.with_mesh(limb.mesh.with_vertices(true.apply(limb.mesh.vertices_mm))),
        frame=LimbFrame(limb_from_mesh=true.inverse, side="right"),
    )
    assert worst_mm(as_is(limb, other).first_from_second, true, limb) < 1e-9
    with pytest.raises(MeasureError, match="Only one"):
        as_is(limb, other.unaligned())


def beaker(radius_mm: float) -> Mesh:
    """A cylinder of 200 mm, closed below, open above, in 60 corners."""
    angles = 2 * np.pi * np.arange(60) / 60
    ring = radius_mm * np.column_stack([np.cos(angles), np.sin(angles)])
    wall = np.concatenate(
        [
            np.column_stack([ring, np.full(60, 0.0)]),
            np.column_stack([ring, np.full(60, 200.0)]),
            [[0, 0, 0]],
        ]
    )
    k, after = np.arange(60), (np.arange(60) + 1) % 60
    faces = np.concatenate(
        [
            np.column_stack([k, after, after + 60]),
            np.column_stack([k, after + 60, k + 60]),
            np.column_stack([after, k, np.full(60, 120)]),
        ]
    )
    return Mesh(vertices_mm=wall, faces=faces.astype(np.int32))


def test_a_thinner_cylinder_sinks_until_it_holds_as_much() -> None:
    """q (h - s) = h with q = (49 / 50)^2 and h = 200 + s gives s."""
    slide = slide_to_volume(beaker(50.0), beaker(49.0))
    q = (49 / 50) ** 2
    assert slide.shift_mm == pytest.approx(200 * (1 - 1 / q) * q, abs=0.01)
    assert slide.height_mm == pytest.approx(200 + slide.shift_mm, abs=0.01)


def test_volume_alignment_asks_for_a_closed_end(limb) -> None:
    tube = mesh_in_frame(limb.mesh, Rigid.identity())
    tube = replace(tube, faces=tube.faces[tube.vertices_mm[tube.faces][:, :, 2].min(1) > 60])
    with pytest.raises(MeasureError, match="open"):
        slide_to_volume(tube, tube)


def test_the_brim_takes_no_part(limb) -> None:
    """A flared brim of 4 mm height moves nothing if 5 mm are left out."""
    vertices = limb.mesh.vertices_mm.copy()
    flared = vertices[:, 2] > 216
    vertices[flared, :2] *= 1.2
    true = pose_of(10)
    second = nearly_told(limb.with_mesh(limb.mesh.with_vertices(vertices)), true)
    kept = by_shape(limb, second, RegistrationOptions(brim_mm=8.0))
    assert worst_mm(kept.first_from_second, true, limb) < 1e-4


@pytest.mark.parametrize("count", [3, 4, 6, 12])
def test_landmarks_lay_a_shape_within_what_they_say_95_times_of_100(limb, count: int) -> None:
    """Each is marked 1.5 mm off, by the same spread in all directions; so few tell that badly."""
    rng = np.random.default_rng(count)
    angle, height = 2.4 * np.arange(count), np.linspace(20, 150, count)
    places = np.column_stack([45 * np.cos(angle), 45 * np.sin(angle), height])

    def marked(places_mm: np.ndarray) -> Limb:
        marks = (Landmark(name=f"{k}", position_mm=one) for k, one in enumerate(places_mm))
        return replace(limb, landmarks=tuple(marks))

    first, held = marked(places), []
    for _ in range(600):
        found = by_landmarks(first, marked(places + rng.normal(0, 1.5, places.shape)), {})
        assert found.pose_covariance is not None
        middle = found.pose_covariance.middle_mm
        off = found.first_from_second.apply(middle[None])[0] - middle
        held.append(np.abs(off) < 1.96 * np.sqrt(np.diag(found.pose_covariance.covariance_mm2)))
    assert 0.93 < np.mean(held) < 0.97


def patches_of(places: np.ndarray) -> np.ndarray:
    """Which patch each place is in: boxes as wide as half of the places' mean reach."""
    away = places - places.mean(0)
    cells = np.floor(away / (0.5 * np.sqrt(np.mean(np.sum(away**2, axis=1))))).astype(int)
    return np.unique(cells, axis=0, return_inverse=True)[1].ravel()


def spread_of(places: np.ndarray, ground: CounterpartSurface) -> np.ndarray:
    """Standard deviations of a turn, rad, and of a shift, mm, of places laid on a ground."""
    fit = run_icp(places, ground, Rigid.identity(), IcpOptions())
    assert fit.pose_covariance is not None
    return np.sqrt(np.diag(fit.pose_covariance.covariance))


@pytest.mark.slow
def test_a_shape_that_errs_by_patches_lies_within_what_it_says_95_times_of_100(make_limb) -> None:
    """Patches of a slender limb, of all sizes, err by 0.1 mm as a whole.

    Along the axis growth all round is taken for a shift, whose interval has room for that.
    """
    limb = make_limb(lambda height, angle: 0.5 * uneven(height, angle))
    ground, places = CounterpartSurface.of(limb.mesh, 3.0), measured_samples(limb, 300, 3.0)
    normals, patch = ground.counterparts(places).smooth_normals, patches_of(places)
    rng, held = np.random.default_rng(2), []
    for _ in range(600):
        off_mm = rng.normal(0, 0.1, patch.max() + 1)[patch]
        fit = run_icp(places + normals * off_mm[:, None], ground, Rigid.identity(), IcpOptions())
        assert fit.pose_covariance is not None
        middle, pose = fit.pose_covariance.middle_mm, fit.first_from_second
        turn = Rotation.from_matrix(pose.rotation).as_rotvec()
        moved = np.concatenate([turn, middle - pose.inverse.apply(middle[None])[0]])
        held.append(np.abs(moved) < 1.96 * np.sqrt(np.diag(fit.pose_covariance.covariance)))
    assert 0.93 < np.mean(np.array(held)[:, :5]) < 0.97


def test_places_that_err_alike_tell_no_more_where_ten_times_as_many_are_taken(make_limb) -> None:
    """The same 0.1 mm by patches at 300 and at 3000 places: as single errors, a third."""
    limb = make_limb(lambda height, angle: 0.5 * uneven(height, angle))
    ground, places = CounterpartSurface.of(limb.mesh, 3.0), measured_samples(limb, 3000, 3.0)
    normals, patch = ground.counterparts(places).smooth_normals, patches_of(places)
    rng, few, many = np.random.default_rng(4), [], []
    for _ in range(10):
        off_mm = rng.normal(0, 0.1, patch.max() + 1)[patch]
        moved = places + normals * off_mm[:, None]
        many.append(spread_of(moved, ground))
        few.append(spread_of(moved[::10], ground))
    assert np.mean(many, axis=0) / np.mean(few, axis=0) == pytest.approx(1.0, abs=0.25)


def test_growth_all_round_is_no_error_of_patches(make_limb) -> None:
    """1 mm lost all round neither turns a shape nor shifts it aside; 0.1 mm by patches do."""
    limb = make_limb(uneven)
    ground, places = CounterpartSurface.of(limb.mesh, 3.0), measured_samples(limb, 300, 3.0)
    normals, patch = ground.counterparts(places).smooth_normals, patches_of(places)
    rng, same, lost = np.random.default_rng(6), [], []
    for _ in range(5):
        off_mm = rng.normal(0, 0.1, patch.max() + 1)[patch]
        same.append(spread_of(places + normals * off_mm[:, None], ground))
        lost.append(spread_of(places + normals * (off_mm - 1.0)[:, None], ground))
    ratio = np.mean(lost, axis=0) / np.mean(same, axis=0)
    assert (ratio[:5] < 1.5).all(), "as ten times the error by patches, 10"
    assert ratio[5] > 5, "along the axis it is taken for a shift"
