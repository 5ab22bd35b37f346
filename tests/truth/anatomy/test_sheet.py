"""Sheets on bodies whose landmarks are exact, and on shapes with closed forms."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from scipy.special import ndtri

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.uncertainty import filled_sigma_mm
from limbgram.workbench.anatomy.landmark import USUAL
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.cranial import cranial_figures
from limbgram.workbench.measures.levels import area_mm2, level_at
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.measures.propagation import Subject
from limbgram.workbench.measures.sheet import MeasuringSheet, SheetOptions, measuring_sheet

MakeLimb = Callable[..., Limb]
ANGLES = (
    "ankle_deg",
    "dorsiflexion_deg",
    "shank_to_vertical_deg",
    "hindfoot_deg",
    "forefoot_deg",
    "forefoot_adduction_deg",
    "toe_out_deg",
)

BY_SURFACE = ("hindfoot_deg", "forefoot_deg", "forefoot_adduction_deg")
CALCANEUS = ("achilles insertion", "medial calcaneus", "lateral calcaneus")


def only(limb: Limb, *names: str, options: SheetOptions | None = None) -> MeasuringSheet:
    return measuring_sheet(limb, replace(options or SheetOptions(), only=names))


def turned(
    limb: Limb, names: tuple[str, ...], axis: np.ndarray, deg: float, at: np.ndarray
) -> Limb:
    """The limb with some landmarks turned about an axis."""
    motion = Rigid.from_rotation_vector(np.radians(deg) * axis, np.zeros(3))
    marks = tuple(
        replace(one, position_mm=motion.apply((one.position_mm - at)[None])[0] + at)
        if one.name in names
        else one
        for one in limb.landmarks
    )
    return replace(limb, landmarks=marks)


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(
    ("names", "about", "figure", "right_sign"),
    [
        (("fibula head", "medial tibial condyle"), "lateral", "dorsiflexion_deg", -1),
        (("fibula head", "medial tibial condyle"), "lateral", "ankle_deg", 1),
        (("fibula head", "medial tibial condyle"), "foot", "hindfoot_deg", -1),
        (("lateral malleolus",), "plantar", "toe_out_deg", 1),
    ],
)
def test_an_angle_follows_the_joint_with_one_sign_on_both_sides(
    foot_of: MakeLimb,
    left: bool,
    names: tuple[str, ...],
    about: str,
    figure: str,
    right_sign: int,
) -> None:
    limb = foot_of(left=left)
    axis = limb.axis(about).direction
    at = limb.axis("ankle" if about == "plantar" else "shank").point_mm
    # What lies distal of the shank stays where the turned landmarks tell it not.
    before = only(limb, figure)[figure].value
    sense = right_sign * (-1 if left else 1)
    after = only(turned(limb, names, axis, 7.0 * sense, at), figure)[figure].value
    assert after - before == pytest.approx(7.0, abs=1e-6)


@pytest.mark.parametrize("left", [False, True])
def test_a_heel_that_was_turned_over_leans_by_that_more(foot_of: MakeLimb, left: bool) -> None:
    """Surface and landmarks of the heel turned about the foot's axis; the frame stays."""
    limb = foot_of(left=left)
    axis, at = limb.axis("foot").direction, limb.landmark("heel").position_mm
    over = turned(limb, CALCANEUS, axis, -7.0 if left else 7.0, at)
    motion = Rigid.from_rotation_vector(np.radians(-7.0 if left else 7.0) * axis, np.zeros(3))
    over = over.with_mesh(limb.mesh.with_vertices(motion.apply(limb.mesh.vertices_mm - at) + at))
    before, after = (only(one, "hindfoot_deg")["hindfoot_deg"].value for one in (limb, over))
    assert after - before == pytest.approx(7.0, abs=0.25)


@pytest.mark.parametrize("body", ["adult_female", "adult_male", "child"])
def test_angles_told_by_the_surface_hardly_hang_on_where_a_mark_was_made(
    foot_of: MakeLimb, body: str
) -> None:
    """A line from the calcaneus to the insertion of the tendon would turn three times as far."""
    limb = foot_of(body)
    sides = [limb.landmark(f"{one} calcaneus").position_mm for one in ("medial", "lateral")]
    way = limb.landmark("achilles insertion").position_mm - np.mean(sides, axis=0)
    by_line = np.degrees(1.0 / (way @ limb.axis("plantar").direction))
    assert by_line > 1.9
    marks = tuple(replace(one, sigma_mm=1.0) for one in limb.landmarks)
    for row in only(replace(limb, landmarks=marks), *BY_SURFACE).rows:
        assert row.placing_sigma is not None
        assert 0.02 < row.placing_sigma < by_line / 3


def test_a_left_foot_has_the_figures_of_its_mirror_image(foot_of: MakeLimb) -> None:
    names = (*ANGLES, "foot_length_mm", "ball_girth_mm", "navicular_height_mm", "heel_width_mm")
    right = only(foot_of(sigma_mm=0.2), *names)
    left = only(foot_of(left=True, sigma_mm=0.2), *names)
    for name in names:
        assert left[name].value == pytest.approx(right[name].value, abs=1e-4)
        assert left[name].sigma == pytest.approx(right[name].sigma, rel=2e-3)


def test_a_heeled_shoe_inclines_the_shank(foot_of: MakeLimb) -> None:
    limb = foot_of()
    flat = only(limb, "shank_to_vertical_deg")["shank_to_vertical_deg"].value
    shoe = SheetOptions(shoe_heel_mm=25.0, shoe_sole_mm=10.0)
    raised = only(limb, "shank_to_vertical_deg", options=shoe)["shank_to_vertical_deg"].value
    heel = limb.landmark("heel").position_mm
    ball = (
        limb.landmark("first metatarsal head").position_mm
        + limb.landmark("fifth metatarsal head").position_mm
    ) / 2
    asked = np.degrees(np.arctan(15.0 / np.linalg.norm(ball - heel)))
    assert raised - flat == pytest.approx(asked, abs=1e-9)


def placed_anew(limb: Limb, sigma_mm: float, random: np.random.Generator) -> Limb:
    """Landmarks as a clinician places them: off along the surface by a known error."""
    places = np.stack([one.position_mm for one in limb.landmarks])
    nearest = KDTree(limb.mesh.vertices_mm).query(places)[1]
    normals = limb.mesh.vertex_normals()[nearest]
    step = random.normal(0, sigma_mm, places.shape)
    step -= normals * (step * normals).sum(1)[:, None]
    return replace(
        limb,
        landmarks=tuple(
            replace(one, position_mm=at.copy(), sigma_mm=sigma_mm)
            for one, at in zip(limb.landmarks, places + step, strict=True)
        ),
    )


def misses(limb: Limb, draws: int) -> np.ndarray:
    """Errors of the seven angles in their sigmas, with landmarks placed anew by each draw."""
    stature = float(np.ptp(limb.mesh.vertices_mm[:, 2]))
    truth = only(limb, *ANGLES)
    found: list[float] = []
    for seed in range(draws):
        random = np.random.default_rng(seed)
        for row in only(placed_anew(limb, 0.002 * stature, random), *ANGLES).rows:
            assert row.figure is not None
            assert row.placing_sigma is not None
            found.append((row.figure.value - truth[row.name].value) / row.placing_sigma)
    assert len(found) == 7 * draws
    return np.array(found)


def test_angles_err_with_their_landmarks_as_their_sigmas_say(foot_of: MakeLimb) -> None:
    """105 angles, some of which share landmarks: they know the ratio to some 10 %."""
    assert 0.8 < np.sqrt(np.mean(misses(foot_of("adult_male"), 15) ** 2)) < 1.2


@pytest.mark.slow  # the one above tells the same of one body, and takes a tenth
def test_angles_lie_within_their_intervals_as_often_as_these_say(foot_of: MakeLimb) -> None:
    """Four bodies, 40 seeds, seven angles: 1120 intervals of landmarks placed by hand."""
    bodies = ("adult_female", "adult_male", "child", "baby")
    held = np.abs(np.concatenate([misses(foot_of(body), 40) for body in bodies])) <= 1.96
    assert len(held) == 1120
    assert 0.93 <= np.mean(held) <= 0.97


def test_a_girth_errs_with_its_landmarks_as_its_sigma_says(foot_of: MakeLimb) -> None:
    limb = foot_of("adult_male")
    random = np.random.default_rng(5)
    name = "instep_girth_mm"
    told = only(placed_anew(limb, 1e-6, random), name).rows[0]
    truth = only(limb, name)[name].value
    assert told.figure is not None
    assert told.figure.value == pytest.approx(truth, abs=1e-3)
    marks = tuple(replace(one, sigma_mm=1.0) for one in limb.landmarks)
    row = only(replace(limb, landmarks=marks), name).rows[0]
    offs = [only(placed_anew(limb, 1.0, random), name)[name].value - truth for _ in range(30)]
    assert row.placing_sigma is not None
    assert 0.75 < np.std(offs) / row.placing_sigma < 1.33  # 30 draws know it to 13 %


def test_a_surface_that_grew_shifts_girths_by_what_their_gradient_says(foot_of: MakeLimb) -> None:
    limb = foot_of(sigma_mm=0.2)
    shared = np.full((len(limb.mesh), 1), 0.2, np.float32)
    limb = limb.with_mesh(replace(limb.mesh, shared_mm=shared))
    marks = tuple(replace(one, sigma_mm=0.0) for one in limb.landmarks)
    limb = replace(limb, landmarks=marks)
    name = "calf_girth_mm"
    figure = only(limb, name)[name]
    grown = limb.mesh.with_vertices(limb.mesh.vertices_mm + 0.2 * limb.mesh.vertex_normals())
    more = only(limb.with_mesh(grown), name)[name].value - figure.value
    assert more == pytest.approx(figure.sigma, rel=0.05)
    assert more == pytest.approx(2 * np.pi * 0.2, rel=0.05)


def test_a_missing_landmark_is_named_in_its_row(foot_of: MakeLimb) -> None:
    limb = foot_of()
    left = tuple(one for one in limb.landmarks if one.name != "navicular")
    rows = {row.name: row for row in measuring_sheet(replace(limb, landmarks=left)).rows}
    reason = rows["navicular_height_mm"].reason
    assert reason is not None
    assert reason.code == "anatomy.missing"
    assert reason.values["names"] == ("navicular",)
    assert rows["navicular_height_per_cent"].figure is None
    assert rows["ankle_deg"].figure is not None


PLANTAR = (
    "plantar heel",
    "plantar first metatarsal head",
    "plantar fifth metatarsal head",
)


def without(limb: Limb, *names: str) -> Limb:
    return replace(limb, landmarks=tuple(one for one in limb.landmarks if one.name not in names))


@pytest.mark.parametrize("lacking", [PLANTAR[:1], PLANTAR[1:], PLANTAR[2:], PLANTAR])
def test_one_place_under_the_foot_not_marked_tilts_no_plane(
    foot_of: MakeLimb, lacking: tuple[str, ...]
) -> None:
    """Through under the heel and the metatarsal heads themselves it would lean by 10 degrees."""
    limb = foot_of("child")
    before = only(limb, "ankle_deg")["ankle_deg"].value
    after = only(without(limb, *lacking), "ankle_deg")["ankle_deg"].value
    by_others = only(without(limb, *PLANTAR), "ankle_deg")["ankle_deg"].value
    assert after == pytest.approx(by_others, abs=1e-9)
    assert abs(after - before) < 6.0


@pytest.mark.parametrize("lacking", PLANTAR)
def test_heights_over_the_sole_need_the_places_under_it(foot_of: MakeLimb, lacking: str) -> None:
    """From the heel's back to the navicular an adult has 20 mm, from under it 43 mm."""
    names = ("navicular_height_mm", "lateral_malleolus_height_mm", "arch_height_mm", "toes_up_deg")
    for row in only(without(foot_of(), lacking), *names).rows:
        assert row.figure is None
        assert row.reason is not None
        assert row.reason.values["names"] == (lacking,)


def test_a_figure_by_stand_ins_says_so(foot_of: MakeLimb) -> None:
    """A shank to the tubercle leans by 10 degrees more than one to the middle of the knee."""
    names = ("ankle_deg", "ball_width_mm", "calf_girth_mm")
    limb = foot_of(sigma_mm=0.1)
    assert not any(row.doubt for row in only(limb, *names).rows)
    rows = {row.name: row for row in only(without(limb, "medial tibial condyle"), *names).rows}
    for name in ("ankle_deg", "calf_girth_mm"):
        assert rows[name].stand_ins == ("tibial tubercle",)
        said = rows[name].doubt
        assert said is not None
        assert said.code == "measure.sheet.stand_ins"
        assert said.values["lacking"] == ("medial tibial condyle",)
    assert rows["ball_width_mm"].stand_ins == ()
    assert rows["ball_width_mm"].doubt is None


@pytest.mark.parametrize("lacking", [("medial tibial condyle",), PLANTAR])
def test_a_figure_by_stand_ins_has_no_interval_since_none_would_hold(
    foot_of: MakeLimb, lacking: tuple[str, ...]
) -> None:
    """By the surface and by placing alone it would be off by 3 to 20 sigmas."""
    limb = foot_of("child", sigma_mm=0.1)
    full = only(limb, "ankle_deg", "ball_width_mm")
    rows = only(without(limb, *lacking), "ankle_deg", "ball_width_mm").rows
    ankle, ball = rows
    assert ankle.figure is not None
    assert (ankle.figure.sigma, ankle.figure.interval, ankle.placing_sigma) == (None, None, None)
    among = ankle.among_alike
    assert among is not None
    assert among.sigma is not None
    assert abs(among.value - full["ankle_deg"].value) > 3 * among.sigma
    assert ball.figure == ball.among_alike == full["ball_width_mm"]
    assert ball.figure is not None
    assert ball.figure.sigma is not None


def test_a_foot_of_the_other_side_is_refused_by_a_landmark_that_tells_it(
    foot_of: MakeLimb,
) -> None:
    limb = foot_of().unaligned()
    frame = align(limb, AlignOptions(side="right")).frame
    up = frame.limb_from_mesh.rotation[2]
    np.testing.assert_allclose(up, limb.axis("shank").direction, atol=1e-9)
    with pytest.raises(MeasureError) as refused:
        align(limb, AlignOptions(side="left"))
    assert refused.value.finding.code == "align.landmark.elsewhere"
    assert refused.value.finding.values["name"] in ("medial malleolus", "lateral malleolus")
    with pytest.raises(MeasureError) as unsaid:
        measuring_sheet(limb)
    assert unsaid.value.finding.code == "anatomy.no_side"


def test_a_turned_chest_is_told_in_degrees(trunk_of: MakeLimb) -> None:
    limb = trunk_of()
    names = ("xiphoid_rotation_deg", "waist_rotation_deg", "xiphoid_girth_mm")
    before = only(limb, *names)
    axis = limb.axis("trunk")
    waist = (limb.landmark("right waist").position_mm - axis.point_mm) @ axis.direction
    motion = Rigid.from_rotation_vector(np.radians(8.0) * axis.direction, np.zeros(3))

    def twisted(points: np.ndarray) -> np.ndarray:
        high = (points - axis.point_mm) @ axis.direction > waist + 60
        return np.where(high[:, None], motion.apply(points - axis.point_mm) + axis.point_mm, points)

    mesh = limb.mesh.with_vertices(twisted(limb.mesh.vertices_mm))
    marks = tuple(
        replace(one, position_mm=twisted(one.position_mm[None])[0]) for one in limb.landmarks
    )
    after = only(replace(limb, mesh=mesh, landmarks=marks), *names)
    turn = after["xiphoid_rotation_deg"].value - before["xiphoid_rotation_deg"].value
    assert turn == pytest.approx(8.0, abs=1e-6)
    assert after["xiphoid_girth_mm"].value == pytest.approx(
        before["xiphoid_girth_mm"].value, abs=1e-6
    )
    assert after["waist_rotation_deg"].value == pytest.approx(
        before["waist_rotation_deg"].value, abs=1e-6
    )


def test_a_section_that_runs_into_the_brim_tells_its_height_in_the_limb(
    trunk_of: MakeLimb,
) -> None:
    """Though its plane is square to a line that leans, in a mesh whose origin lies elsewhere."""
    limb = trunk_of()
    low_mm = float(limb.mesh.vertices_mm[:, 2].min())
    limb = replace(
        limb,
        landmarks=tuple(
            replace(one, position_mm=np.array([*one.position_mm[:2], low_mm + 4.0]))
            if one.name.endswith("trochanter")
            else one
            for one in limb.landmarks
        ),
        frame=LimbFrame(
            limb_from_mesh=Rigid(np.eye(3), np.array([0.0, 0.0, -low_mm])), side="none"
        ),
    )
    (row,) = only(limb, "trochanter_girth_mm").rows
    assert row.reason is not None
    assert row.reason.code == "measure.level.open"
    assert row.reason.values["height_mm"] == pytest.approx(4.0, abs=1e-6)


HALF = np.array([70.0, 90.0, 80.0])
"""Of an ellipsoid: right, front, up."""


def ellipsoid(skew_deg: float, subdivisions: int = 5) -> Limb:
    """A head whose closed forms are known, turned about the vertical in its own base plane."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    turn = Rigid.from_rotation_vector(np.radians([0.0, 0.0, skew_deg]), np.zeros(3))
    vertices = turn.apply(np.asarray(ball.vertices) * HALF)
    mesh = Mesh(vertices_mm=vertices, faces=np.asarray(ball.faces, np.int32))
    places = {
        "sellion": (0, 90, 0),
        "right tragion": (70, 0, 0),
        "left tragion": (-70, 0, 0),
        "glabella": (0, 85, 20),
    }
    return AlignedLimb(
        mesh=mesh,
        landmarks=tuple(
            Landmark(name=name, position_mm=np.array(at, float)) for name, at in places.items()
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="none"),
        kind="head",
    )


@pytest.mark.parametrize("skew_deg", [0.0, 12.0, -12.0])
def test_a_heads_figures_have_closed_forms(skew_deg: float) -> None:
    sheet = measuring_sheet(ellipsoid(skew_deg))
    shrink = np.sqrt(1 - 0.3**2)
    a, b = HALF[:2] * shrink
    turn = np.radians(skew_deg)

    def reach(axis_deg: float) -> float:
        angle = np.radians(axis_deg) - turn
        return 2 / np.hypot(np.cos(angle) / a, np.sin(angle) / b)

    left, right = reach(120), reach(60)
    assert sheet["diagonal_left_front_mm"].value == pytest.approx(left, abs=0.1)
    assert sheet["diagonal_right_front_mm"].value == pytest.approx(right, abs=0.1)
    assert sheet["cva_mm"].value == pytest.approx(abs(left - right), abs=0.1)
    assert sheet["cva_signed_mm"].value == pytest.approx(left - right, abs=0.1)
    small, large = sorted((left, right))
    shorter, longer = sheet["cvai_shorter_per_cent"], sheet["cvai_longer_per_cent"]
    assert shorter.value == pytest.approx(100 * (large - small) / small, abs=0.1)
    assert longer.value == pytest.approx(100 * (large - small) / large, abs=0.1)
    width = 2 * np.hypot(a * np.cos(turn), b * np.sin(turn))
    length = 2 * np.hypot(a * np.sin(turn), b * np.cos(turn))
    assert sheet["width_mm"].value == pytest.approx(width, abs=0.1)
    assert sheet["cranial_ratio_per_cent"].value == pytest.approx(100 * width / length, abs=0.1)
    whole = 2 / 3 * np.pi * HALF.prod() / 1000
    quarters = [
        sheet[f"volume_{side}_{half}_ml"].value
        for side in ("right", "left")
        for half in ("front", "back")
    ]
    assert sum(quarters) == pytest.approx(whole, rel=2e-3)
    # Two radii of an ellipse, made a circle, hold the share of the angle between them.
    edges = [np.array([np.cos(at - turn) / a, np.sin(at - turn) / b]) for at in (np.pi / 2, np.pi)]
    between = np.arccos(edges[0] @ edges[1] / np.linalg.norm(edges[0]) / np.linalg.norm(edges[1]))
    share = between / (2 * np.pi)
    assert sheet["volume_left_front_ml"].value == pytest.approx(whole * share, rel=5e-3)
    assert sheet["symmetry_per_cent"].value == pytest.approx(100.0, abs=0.1)


def spread(limb: Limb, names: tuple[str, ...], draws: int) -> np.ndarray:
    """How far figures go off with landmarks placed anew, in their sigmas."""
    told = only(limb, *names)
    sigmas = [told[name].sigma or np.nan for name in names]
    found = [
        only(placed_anew(limb, 2.0, np.random.default_rng(seed)), *names) for seed in range(draws)
    ]
    offs = [[one[name].value - told[name].value for name in names] for one in found]
    return np.sqrt(np.mean(np.square(offs), axis=0)) / sigmas


def test_an_asymmetry_that_is_none_errs_as_much_as_any_other() -> None:
    """By differences to both sides of its kink it would err by a hundredth of that."""
    head = ellipsoid(0.0, 3)
    head = head.with_mesh(replace(head.mesh, sigma_mm=np.full(len(head.mesh), 0.05, np.float32)))
    off = spread(head, ("cva_mm", "symmetry_per_cent"), 8)
    assert ((off > 0.5) & (off < 1.6)).all()


@pytest.mark.parametrize("name", ["baby", "adult_female"])
def test_a_heads_circumference_errs_as_its_landmarks_are_placed(
    head_of: MakeLimb, name: str
) -> None:
    """By its slopes alone the woman's erred by 2.9 of its sigmas, and the baby's, whose level just
    misses the ears, by 12."""
    off = spread(head_of(name, sigma_mm=0.01), ("circumference_mm", "length_mm", "width_mm"), 12)
    assert ((off > 0.3) & (off < 1.7)).all()


def test_a_depth_between_places_that_stand_out_alike_errs_with_the_plane(
    trunk_of: MakeLimb,
) -> None:
    """Of a symmetric back, both halves of which lie equally far behind."""
    (off,) = spread(trunk_of(sigma_mm=0.05), ("axilla_ap_mm",), 10)
    assert 0.5 < off < 1.6


def test_a_heads_circumference_lies_in_the_plane_of_glabella_and_opisthocranion() -> None:
    """An ellipsoid's sections are ellipses; here the plane falls from front to back."""
    up_mm = 20.0
    ahead = HALF[1] * np.sqrt(1 - (up_mm / HALF[2]) ** 2)
    places = {"glabella": (0, ahead, up_mm), "opisthocranion": (0, -ahead, -up_mm)}
    head = ellipsoid(0.0)
    kept = tuple(one for one in head.landmarks if one.name not in places)
    marks = tuple(Landmark(name=one, position_mm=np.array(at)) for one, at in places.items())
    found = only(replace(head, landmarks=(*kept, *marks)), "head_circumference_mm")
    around = np.linspace(0, 2 * np.pi, 20001)
    ring = np.column_stack([HALF[0] * np.cos(around), np.hypot(ahead, up_mm) * np.sin(around)])
    length = float(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum())
    assert found["head_circumference_mm"].value == pytest.approx(length, abs=0.2)


def test_a_heads_ratio_and_signed_asymmetry_between_landmarks() -> None:
    """Places known to the millimetre, each placed with its own error."""
    places = {
        "glabella": (0, 85, 20),
        "opisthocranion": (0, -85, 20),
        "right eurion": (68, -20, 10),
        "left eurion": (-68, -20, 10),
        "right frontozygoma": (40, 68, 10),
        "left frontozygoma": (-44, 68, 10),
    }
    names = ("eurion_width_mm", "glabella_length_mm", "cephalic_index_per_cent")
    oblique = ("oblique_left_front_mm", "oblique_right_front_mm", "oblique_cva_mm")
    head = ellipsoid(0.0)
    kept = tuple(one for one in head.landmarks if one.name not in places)
    marks = tuple(
        Landmark(name=one, position_mm=np.array(at, float), sigma_mm=1.0)
        for one, at in places.items()
    )
    found = only(replace(head, landmarks=(*kept, *marks)), *names, *oblique)
    assert found["cephalic_index_per_cent"].value == pytest.approx(100 * 136 / 170)
    left, right = np.hypot(112, 88), np.hypot(108, 88)
    assert found["oblique_cva_mm"].value == pytest.approx(left - right)
    rows = {row.name: row for row in found.rows}
    parts = [rows[one].placing_sigma or np.nan for one in oblique[:2]]
    assert rows["oblique_cva_mm"].placing_sigma == pytest.approx(np.hypot(*parts))
    assert set(rows["oblique_cva_mm"].places) == {*places} - {"glabella", "opisthocranion"}


def test_two_landmarks_in_one_point_have_no_ratio() -> None:
    head = ellipsoid(0.0)
    names = ("glabella", "opisthocranion", "right eurion", "left eurion")
    marks = tuple(
        Landmark(name=one, position_mm=np.array([0.0, 85.0, 20.0]), sigma_mm=1.0) for one in names
    )
    kept = tuple(one for one in head.landmarks if one.name not in names)
    (row,) = only(replace(head, landmarks=(*kept, *marks)), "cephalic_index_per_cent").rows
    assert row.figure is None
    assert row.reason is not None
    assert row.reason.code == "measure.sheet.no_whole"


@pytest.mark.parametrize(("open_to_mm", "whole"), [(-3.0, True), (4.0, False)])
def test_a_head_that_is_open_above_its_base_plane_lacks_volumes_alone(
    open_to_mm: float, whole: bool
) -> None:
    head = ellipsoid(12.0)
    high = head.mesh.vertices_mm[head.mesh.faces].mean(1)[:, 2] > open_to_mm
    used, faces = np.unique(head.mesh.faces[high], return_inverse=True)
    mesh = Mesh(
        vertices_mm=head.mesh.vertices_mm[used], faces=faces.reshape(-1, 3).astype(np.int32)
    )
    closed, found = (measuring_sheet(one) for one in (head, replace(head, mesh=mesh)))
    for name in ("width_mm", "length_mm", "cva_mm", "radial_symmetry_mm"):
        assert found[name].value == pytest.approx(closed[name].value, abs=1e-9)
    row = next(one for one in found.rows if one.name == "volume_left_back_ml")
    assert (row.figure is not None) == whole
    if not whole:
        assert row.reason is not None
        assert row.reason.code == "measure.sheet.open_above"
        assert row.reason.values["height_mm"] == pytest.approx(open_to_mm, abs=4.0)


@pytest.mark.parametrize("at", [(8.0, 87.0), pytest.param((14.0, 85.0), marks=pytest.mark.slow)])
def test_a_heads_length_holds_though_a_fill_lies_beside_its_foremost_place(
    at: tuple[float, float],
) -> None:
    """30 true heads, whose forehead bulges by what nobody measured there; landmarks are exact.

    What a bulge changes grows with it: heads whose bulges lie between those asked are held too.
    """
    limb = ellipsoid(0.0, subdivisions=4)
    marks = tuple(replace(one, sigma_mm=1e-6) for one in limb.landmarks)
    limb = replace(limb, landmarks=marks)
    level_mm = 0.3 * HALF[2]
    middle = np.array([*np.array(at) * np.sqrt(1 - 0.3**2), level_mm])
    filled = np.linalg.norm(limb.mesh.vertices_mm - middle, axis=1) < 14.0
    sigma = np.where(filled, np.nan, 0.05).astype(np.float32)
    measured = replace(limb.mesh, sigma_mm=sigma, filled=filled, correlation_mm=2.0)
    names = ("length_mm", "cranial_ratio_per_cent")
    told = only(limb.with_mesh(measured), *names)
    bulge = filled_sigma_mm(measured, filled)[:, None] * measured.vertex_normals()
    asked = (0, 1, 2, 14, 27, 28, 29)
    held = dict.fromkeys(names, 30 - len(asked))
    for size in ndtri((np.array(asked) + 0.5) / 30):
        true = only(
            limb.with_mesh(limb.mesh.with_vertices(limb.mesh.vertices_mm + size * bulge)), *names
        )
        for name in names:
            reach = told[name].interval
            assert reach is not None
            held[name] += abs(true[name].value - told[name].value) <= reach.above
    assert all(0.93 <= count / 30 <= 0.97 for count in held.values()), held


def test_a_head_without_a_tragion_says_so() -> None:
    limb = ellipsoid(0.0)
    left = tuple(one for one in limb.landmarks if one.name != "left tragion")
    row = measuring_sheet(replace(limb, landmarks=left)).rows[0]
    assert row.reason is not None
    assert "left tragion" in row.reason.values["names"]  # type: ignore[operator]


def test_a_head_s_refused_level_is_told_by_its_height_in_the_limb_s_frame() -> None:
    """As every other height is: not over the base plane, which lies 100 mm over the origin."""
    head = ellipsoid(0.0)
    level_mm = 0.3 * HALF[2]
    middles = head.mesh.vertices_mm[head.mesh.faces].mean(1)
    hole = (np.abs(middles[:, 2] - level_mm) < 6.0) & (middles[:, 0] > 60.0)
    lifted = LimbFrame(limb_from_mesh=Rigid(np.eye(3), np.array([0.0, 0.0, 100.0])), side="none")
    torn = replace(head.mesh, faces=head.mesh.faces[~hole])
    (row,) = only(replace(head, mesh=torn, frame=lifted), "width_mm").rows
    assert row.reason is not None
    assert row.reason.code == "measure.level.open"
    assert row.reason.values["height_mm"] == pytest.approx(100.0 + level_mm, abs=0.1)


def test_a_head_s_circumference_has_the_relief_that_the_surface_lost() -> None:
    """As the same tape has in a table."""
    head = ellipsoid(0.0)
    count = len(head.mesh)
    mesh = replace(
        head.mesh,
        sigma_mm=np.full(count, 0.05, np.float32),
        lost_length=np.tile(np.array([0.006, 0.001], np.float32), (count, 1)),
    )
    head = head.with_mesh(mesh)
    table = measure_limb(head, LimbMeasureOptions(heights_mm=(0.3 * HALF[2],)))
    tape = table.rows[0].figures["tape_mm"]
    assert tape is not None
    assert only(head, "circumference_mm")["circumference_mm"].value == pytest.approx(
        tape.value, abs=0.05
    )


def test_a_head_s_girth_follows_its_highest_place() -> None:
    """The measuring level lies at three tenths of it."""
    subject = Subject.of(ellipsoid(0.0), USUAL)
    girth = cranial_figures(subject)["girth"]
    assert girth.by_vertex is not None
    level_mm = 0.3 * HALF[2]
    by_height = -girth.value * level_mm / (HALF[2] ** 2 - level_mm**2)
    assert girth.by_vertex[subject.sigmas.mesh.vertices_mm[:, 2].argmax()] == pytest.approx(
        0.3 * by_height, rel=0.05
    )


def calf(top_mm: float, *, ripple_mm: float = 0.0, seed: int = 0) -> Limb:
    """A shank of revolution, 320 mm long, thickest at a known height over the ankle axis."""
    heights, around = np.linspace(-10.0, 320.0, 166), 2 * np.pi * np.arange(72) / 72
    radii = 42 - 6e-4 * (heights - top_mm) ** 2
    rng = np.random.default_rng(seed)
    radii = radii[:, None] + ripple_mm * rng.normal(size=(len(heights), 1))
    rings = np.stack(
        [radii * np.cos(around), radii * np.sin(around), np.repeat(heights[:, None], 72, 1)], -1
    )
    ids = np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    after = np.roll(ids, -1, axis=1)
    faces = [np.stack([ids[:-1], after[:-1], after[1:]], -1),
             np.stack([ids[:-1], after[1:], ids[1:]], -1)]  # fmt: skip
    mesh = Mesh(
        vertices_mm=rings.reshape(-1, 3),
        faces=np.concatenate(faces).reshape(-1, 3).astype(np.int32),
        sigma_mm=np.full(rings[..., 0].size, max(ripple_mm, 1e-3), np.float32),
    )
    places = {
        "medial malleolus": (-20.0, 0.0, 0.0),
        "lateral malleolus": (20.0, 0.0, 0.0),
        "fibula head": (30.0, 0.0, 300.0),
        "medial tibial condyle": (-30.0, 0.0, 300.0),
    }
    marks = tuple(
        Landmark(name=one, position_mm=np.array(at), sigma_mm=0.0) for one, at in places.items()
    )
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="foot")


@pytest.mark.parametrize("top_mm", [170.0, 191.3])
def test_the_height_of_the_calfs_largest_girth_is_that_of_its_top(top_mm: float) -> None:
    found = only(calf(top_mm), "calf_girth_height_mm", "calf_girth_mm")
    assert found["calf_girth_height_mm"].value == pytest.approx(top_mm, abs=0.02)
    assert found["calf_girth_mm"].value == pytest.approx(2 * np.pi * 42, abs=0.3)


@pytest.mark.parametrize(("forward", "width_mm"), [((0, 1, 0), 84.0), ((-1, 0, 0), 84.0 * 1.2)])
def test_a_calfs_width_is_taken_across_the_foot_where_its_girth_is_largest(
    forward: tuple[int, int, int], width_mm: float
) -> None:
    round_one = calf(191.3)
    vertices = round_one.mesh.vertices_mm * [1.0, 1.2, 1.0]
    across = np.cross(forward, [0, 0, 1]) * 30.0
    toe = 200.0 * np.array(forward)
    places = {
        "heel": -0.2 * toe,
        "second toe": toe,
        "first metatarsal head": 0.7 * toe - across,
        "fifth metatarsal head": 0.7 * toe + across,
    }
    down = np.array([0.0, 0.0, -60.0])
    marks = tuple(
        Landmark(name=one, position_mm=at + down, sigma_mm=0.0) for one, at in places.items()
    )
    limb = replace(round_one, landmarks=(*round_one.landmarks, *marks))
    limb = limb.with_mesh(limb.mesh.with_vertices(vertices))
    names = ("calf_width_mm", "calf_trim_width_mm", "calf_trim_girth_mm")
    found = only(limb, *names)
    assert found["calf_width_mm"].value == pytest.approx(width_mm, abs=0.15)
    lower = 1 - 6e-4 * (300 - 22 - 191.3) ** 2 / 42
    assert found["calf_trim_width_mm"].value == pytest.approx(width_mm * lower, abs=0.15)
    around = np.linspace(0, 2 * np.pi, 20001)
    ring = 42 * lower * np.column_stack([np.cos(around), 1.2 * np.sin(around)])
    length = float(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum())
    assert found["calf_trim_girth_mm"].value == pytest.approx(length, abs=0.3)


def marks_at(
    places: Mapping[str, tuple[float, float, float]], sigmas_mm: Mapping[str, float]
) -> tuple[Landmark, ...]:
    """Landmarks, exact but for those with a sigma."""
    return tuple(
        Landmark(name=name, position_mm=np.array(at), sigma_mm=sigmas_mm.get(name, 0.0))
        for name, at in places.items()
    )


def arched(apex_mm: float, height_mm: float, heel_sigma_mm: float = 0.0) -> Limb:
    """A block of 200 x 60 x 80 mm, hollowed from below by a parabola, 80 mm long, across it."""
    x, y = np.meshgrid(np.linspace(0, 200, 201), np.linspace(-30, 30, 31), indexing="ij")
    hollow = height_mm * (1 - ((x - apex_mm) / 40) ** 2)
    under = np.stack([x, y, np.maximum(hollow, 0.0)], -1)
    over = np.stack([x, y, np.full_like(x, 80.0)], -1)
    ids = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]))
    top = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    rim = np.concatenate([ids[:-1, 0], ids[-1, :-1], ids[:0:-1, -1], ids[0, :0:-1]])
    after = np.roll(rim, -1)
    wall = np.concatenate([np.stack([rim, after, after + x.size], -1),
                           np.stack([rim, after + x.size, rim + x.size], -1)])  # fmt: skip
    mesh = Mesh(
        vertices_mm=np.concatenate([under.reshape(-1, 3), over.reshape(-1, 3)]),
        faces=np.concatenate([top[:, ::-1], top + x.size, wall]).astype(np.int32),
        sigma_mm=np.full(2 * x.size, 1e-3, np.float32),
    )
    places = {
        "plantar heel": (20.0, 0.0, 0.0),
        "plantar first metatarsal head": (150.0, -10.0, 0.0),
        "plantar fifth metatarsal head": (140.0, 25.0, 0.0),
        "medial malleolus": (40.0, -30.0, 70.0),
        "lateral malleolus": (30.0, 30.0, 65.0),
    }
    marks = marks_at(places, {"plantar heel": heel_sigma_mm})
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="foot")


@pytest.mark.parametrize(("apex_mm", "height_mm"), [(80.0, 18.0), (91.3, 6.0)])
def test_an_arch_has_its_apex_where_its_parabola_has(apex_mm: float, height_mm: float) -> None:
    found = only(arched(apex_mm, height_mm), "arch_height_mm", "heel_to_arch_apex_mm")
    assert found["arch_height_mm"].value == pytest.approx(height_mm, abs=0.05)
    slant = np.hypot(130, 10) / 130
    assert found["heel_to_arch_apex_mm"].value == pytest.approx((apex_mm - 20) * slant, abs=0.2)


def test_a_heel_marked_beside_its_place_moves_the_way_to_the_arch_alone() -> None:
    found = only(arched(80.0, 18.0, heel_sigma_mm=2.0), "arch_height_mm", "heel_to_arch_apex_mm")
    rows = {row.name: row for row in found.rows}
    assert rows["heel_to_arch_apex_mm"].placing_sigma == pytest.approx(2.0, rel=0.05)
    assert rows["arch_height_mm"].placing_sigma == pytest.approx(0.0, abs=0.05)


def test_the_height_of_an_arch_moves_with_the_skin_as_its_sigma_says() -> None:
    limb = arched(80.0, 18.0)
    x, _, z = limb.mesh.vertices_mm.T
    bump = 0.2 * np.exp(-(((x - 85) / 15) ** 2)) * (z < 40)
    told = only(
        limb.with_mesh(replace(limb.mesh, shared_mm=bump[:, None].astype(np.float32))),
        "arch_height_mm",
        "heel_to_arch_apex_mm",
    )
    out = limb.mesh.vertices_mm + bump[:, None] * limb.mesh.vertex_normals()
    back = limb.mesh.vertices_mm - bump[:, None] * limb.mesh.vertex_normals()
    moved = [only(limb.with_mesh(limb.mesh.with_vertices(one)), "arch_height_mm",
                  "heel_to_arch_apex_mm") for one in (out, back)]  # fmt: skip
    for name in ("arch_height_mm", "heel_to_arch_apex_mm"):
        change = abs(moved[0][name].value - moved[1][name].value) / 2
        assert told[name].sigma == pytest.approx(change, rel=0.15), name


def test_a_flat_sole_has_no_arch() -> None:
    row = only(arched(80.0, 0.0), "arch_height_mm").rows[0]
    assert row.reason is not None
    assert row.reason.code == "measure.sheet.no_arch"


def test_a_rough_calf_keeps_the_height_of_its_top() -> None:
    """Rings in and out by 0.05 mm: girths differ by 0.3, as they do within 9 mm of the top.

    Through twenty of them the parabola's top is known to 0.9 mm (0.3 / (sqrt(20) 11) / 0.0075).
    """
    name = "calf_girth_height_mm"
    offs = [only(calf(191.3, ripple_mm=0.05, seed=k), name)[name].value - 191.3 for k in range(6)]
    assert 0.3 < np.sqrt(np.mean(np.square(offs))) < 2.0


def test_the_height_of_a_girth_moves_with_the_skin_as_its_sigma_says() -> None:
    limb = calf(191.3)
    off_mm = limb.mesh.vertices_mm[:, 2] - 200.0
    bump = 0.1 * np.exp(-((off_mm / 12) ** 2))
    shared = bump[:, None].astype(np.float32)
    told = only(limb.with_mesh(replace(limb.mesh, shared_mm=shared)), "calf_girth_height_mm")
    moved = [
        only(
            limb.with_mesh(
                limb.mesh.with_vertices(
                    limb.mesh.vertices_mm + step * bump[:, None] * limb.mesh.vertex_normals()
                )
            ),
            "calf_girth_height_mm",
        )["calf_girth_height_mm"].value
        for step in (1.0, -1.0)
    ]
    assert 0.5 * (moved[0] - moved[1]) > 0.2
    sigma = told["calf_girth_height_mm"].sigma
    assert sigma == pytest.approx(0.5 * (moved[0] - moved[1]), rel=0.15)


def test_where_the_malleoli_were_marked_counts_in_the_height_of_a_girth() -> None:
    limb = calf(191.3)
    marks = tuple(replace(one, sigma_mm=2.0) for one in limb.landmarks)
    row = only(replace(limb, landmarks=marks), "calf_girth_height_mm").rows[0]
    # Two marks on upright skin, each off by 2 mm along it.
    assert row.placing_sigma == pytest.approx(2.0 / np.sqrt(2), rel=0.05)


def lopsided_trunk(*, sacrum_sigma_mm: float = 0.0) -> Limb:
    """A tube 500 mm long whose sections are two half ellipses: 180 mm to the right, 150 to the
    left, 110 to the front and the back; wider by 20 and 40 mm all round at two heights."""
    heights, around = np.linspace(-20.0, 520.0, 271), 2 * np.pi * np.arange(720) / 720
    more = np.interp(heights, [300, 350, 360, 400, 430, 460], [0, 20, 20, 40, 40, 0])[:, None]
    side = np.where(np.cos(around) > 0, 180.0, 150.0)
    rings = np.stack(
        [
            (side + more) * np.cos(around),
            (110.0 + more) * np.sin(around),
            np.repeat(heights[:, None], 720, 1),
        ],
        -1,
    )
    ids = np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    after = np.roll(ids, -1, axis=1)
    faces = [np.stack([ids[:-1], after[:-1], after[1:]], -1),
             np.stack([ids[:-1], after[1:], ids[1:]], -1)]  # fmt: skip
    mesh = Mesh(
        vertices_mm=rings.reshape(-1, 3),
        faces=np.concatenate(faces).reshape(-1, 3).astype(np.int32),
        sigma_mm=np.full(rings[..., 0].size, 1e-3, np.float32),
    )
    places = {
        "sacrum": (0.0, -110.0, 0.0),
        "seventh cervical vertebra": (0.0, -110.0, 500.0),
        "right iliac spine": (110.0, 87.0, 60.0),
        "left iliac spine": (-110.0, 87.0, 60.0),
        "right waist": (180.0, 0.0, 200.0),
        "left waist": (-150.0, 0.0, 200.0),
        "right nipple": (80.0, 140.0, 415.0),
        "left nipple": (-80.0, 136.0, 415.0),
        "right inframammary fold": (80.0, 117.0, 355.0),
        "left inframammary fold": (-80.0, 113.0, 355.0),
    }
    marks = marks_at(places, {"sacrum": sacrum_sigma_mm})
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="none")
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame, kind="torso")


def test_the_halves_of_a_trunk_have_the_areas_of_half_ellipses() -> None:
    found = only(lopsided_trunk(), "waist_right_half_cm2", "waist_left_half_cm2")
    right, left = (found[f"waist_{one}_half_cm2"].value for one in ("right", "left"))
    assert right == pytest.approx(np.pi * 180 * 110 / 2 / 100, rel=1e-4)
    assert left == pytest.approx(np.pi * 150 * 110 / 2 / 100, rel=1e-4)
    assert next(one for one in found.rows if one.name == "waist_left_half_cm2").unit == "cm²"


def test_a_sacrum_marked_beside_its_place_moves_area_from_half_to_half() -> None:
    """At 200 of 500 mm the parting plane follows it by 3 / 5, over a depth of 220 mm."""
    for name in ("waist_right_half_cm2", "waist_left_half_cm2"):
        row = only(lopsided_trunk(sacrum_sigma_mm=2.0), name).rows[0]
        assert row.placing_sigma == pytest.approx(2.0 * 0.6 * 220 / 100, rel=0.01)


def test_girths_of_the_breast_and_under_it_are_those_of_ellipses() -> None:
    found = only(lopsided_trunk(), "breast_girth_mm", "under_breast_girth_mm")
    around = np.linspace(0, 2 * np.pi, 20001)
    for name, more in (("breast_girth_mm", 40.0), ("under_breast_girth_mm", 20.0)):
        side = np.where(np.cos(around) > 0, 180.0, 150.0) + more
        ring = np.column_stack([side * np.cos(around), (110 + more) * np.sin(around)])
        length = float(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum())
        assert found[name].value == pytest.approx(length, abs=0.3)


@pytest.mark.parametrize("body", ["adult_female", "adult_male", "child"])
def test_both_halves_are_the_whole_section_on_bodies(trunk_of: MakeLimb, body: str) -> None:
    """Of nearly symmetric bodies they are alike; their sum is the area of the section."""
    limb = trunk_of(body)
    found = only(limb, "waist_right_half_cm2", "waist_left_half_cm2")
    right, left = (found[f"waist_{one}_half_cm2"].value for one in ("right", "left"))
    assert right == pytest.approx(left, rel=0.03)
    waist = [limb.landmark(f"{one} waist").position_mm for one in ("right", "left")]
    up = limb.axis("trunk").direction
    upright = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0].as_matrix()
    turned_mesh = limb.mesh.moved(Rigid(upright, np.zeros(3)))
    x, y, z = (upright @ np.mean(waist, axis=0)).tolist()
    area_mm2_of_it = area_mm2(level_at(turned_mesh, z, (x, y))).value
    assert right + left == pytest.approx(area_mm2_of_it / 100, rel=1e-9)


def test_a_figure_names_the_unconfirmed_landmarks_that_it_goes_by(foot_of: MakeLimb) -> None:
    limb = foot_of()
    proposed = {"navicular", "tibial crest"}
    marks = tuple(replace(one, confirmed=one.name not in proposed) for one in limb.landmarks)
    sheet = only(
        replace(limb, landmarks=marks), "navicular_height_mm", "fibula_head_height_mm", "ankle_deg"
    )
    said = {row.name: row.doubt and row.doubt.values["names"] for row in sheet.rows}
    assert said["navicular_height_mm"] == ("navicular",)
    assert said["fibula_head_height_mm"] is None
    assert said["ankle_deg"] is None
    assert sheet.doubt is not None
    assert sheet.doubt.values["names"] == ("navicular",)  # nothing goes by the crest
    assert only(replace(limb, landmarks=marks), "ankle_deg").doubt is None
