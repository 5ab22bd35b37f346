"""Pictures of comparisons, courses and templates show what changed where it changed."""

from datetime import date
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import note
from limbgram.report.drawings.devices import device_drawing
from limbgram.report.drawings.differences import difference_pictures, paint_of
from limbgram.report.drawings.drawing import Drawing, png
from limbgram.report.drawings.mirror_check import mirror_check
from limbgram.report.drawings.time_course import course_drawing, unrolled_template
from limbgram.report.record.views import four_sides_of_limb
from limbgram.workbench.compare.comparison import CompareOptions, compare
from limbgram.workbench.compare.over_time import FollowOptions, Visit, follow
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.devices.making import FinishedDevice
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.templates.chart_field import ANGLES, node_heights
from limbgram.workbench.templates.template import Template, TemplateMark

AS_IS = CompareOptions(registration=RegistrationOptions(way="as-is"))


@pytest.fixture(scope="module")
def stump() -> Limb:
    """A paraboloid of revolution of 150 mm, open above, in its limb frame."""
    rise, angles = np.linspace(0, 1, 60)[1:], 2 * np.pi * np.arange(72) / 72
    z, a = np.meshgrid(150 * rise**2, angles, indexing="ij")
    r = 50 * np.sqrt(z / 150)
    wall = np.stack([r * np.cos(a), r * np.sin(a), z], axis=-1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(58), np.arange(72), indexing="ij"))
    here, beside = i * 72 + j, i * 72 + (j + 1) % 72
    k = np.arange(72)
    faces = np.concatenate(
        [
            np.column_stack([here, beside, beside + 72]),
            np.column_stack([here, beside + 72, here + 72]),
            np.column_stack([(k + 1) % 72, k, np.full(72, 59 * 72)]),
        ]
    )
    mesh = Mesh(vertices_mm=np.concatenate([wall, [[0.0, 0, 0]]]), faces=faces.astype(np.int32))
    return AlignedLimb(
        mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"), name="a.ply"
    )


def bulged(limb: Limb, towards: list[float], size_mm: float) -> Limb:
    vertices = limb.mesh.vertices_mm
    near = np.exp(-(((vertices - [*towards]) / 15) ** 2).sum(1))
    return limb.with_mesh(
        limb.mesh.with_vertices(vertices + size_mm * near[:, None] * limb.mesh.vertex_normals())
    )


def panels_of(limb: Limb, other: Limb) -> dict[str, np.ndarray]:
    """The pictures of the difference by the name of their side."""
    drawing = difference_pictures(compare(limb, other, AS_IS))
    return {
        axes.get_title(): np.asarray(axes.get_images()[0].get_array(), float)
        for axes in drawing.figure.subfigs[0].axes
        if axes.get_images()
    }


def redness(panel: np.ndarray) -> float:
    """Sum of red over blue where something is drawn."""
    return float(((panel[..., 0] - panel[..., 2]) * (panel[..., 3] > 0)).clip(40).sum())


@pytest.mark.parametrize(
    ("place", "side", "opposite"),
    [
        ([0, 42, 110], "front", "back"),
        ([42, 0, 110], "patient's right", "patient's left"),
    ],
)
def test_what_bulges_on_a_side_is_red_in_the_picture_of_that_side(
    stump, place, side, opposite
) -> None:
    panels = panels_of(stump, bulged(stump, place, 4.0))
    assert redness(panels[side]) == max(redness(panel) for panel in panels.values())
    assert redness(panels[opposite]) == min(redness(panel) for panel in panels.values())
    assert redness(panels[side]) > redness(panels[opposite])


def test_places_without_a_figure_are_grey() -> None:
    paint = paint_of(np.array([np.nan, 1.0]), ScalarMappable(Normalize(0, 1), "Reds"))
    np.testing.assert_array_equal(paint[0], [150, 150, 150])
    assert paint[1, 0] > paint[1, 2]


def test_a_course_and_its_words(stump) -> None:
    visits = [
        Visit(limb=bulged(stump, [0, 42, 110], 3.0 * k), day=date(2026, 1, 1 + 7 * k))
        for k in range(3)
    ]
    drawing = course_drawing(follow(visits, FollowOptions(compare=AS_IS)))
    assert drawing.caption.startswith(("The limb", "No trend"))
    assert len(png(drawing.figure)) > 10_000


def test_a_template_is_drawn_front_in_the_middle() -> None:
    heights = node_heights(1.0)
    moved = np.zeros((len(heights), ANGLES))
    moved[20, 0] = -5.0
    template = Template(
        name="dent",
        pairs=1,
        sided=True,
        reference="mid patella",
        marks=(TemplateMark(name="mid patella", height=1.0, angle_deg=0.0),),
        heights=heights,
        displacement_mm=moved,
        spread_mm=np.full(moved.shape, np.nan),
        known_pairs=np.ones(moved.shape, np.int64),
    )
    drawing = unrolled_template(template)
    drawn = np.asarray(drawing.figure.axes[0].collections[0].get_array()).reshape(len(heights), -1)
    row, column = np.unravel_index(int(np.argmin(drawn)), drawn.shape)
    assert row == 20
    assert column == ANGLES // 2
    assert "-5.0" in drawing.caption


def numbers_by_view(drawing: Drawing) -> dict[str, set[str]]:
    """Numbers of the landmarks in each view of a mirror check."""
    return {
        axes.get_title(): {text.get_text() for text in axes.texts if text.get_text().isdigit()}
        for axes in drawing.figure.axes
        if axes.get_images()
    }


def test_a_mirror_check_shows_each_landmark_only_where_it_can_be_seen(stump) -> None:
    radius = 50 * np.sqrt(100 / 150)
    places = {
        "front": [0, 1],
        "patient's right": [1, 0],
        "patient's left": [-1, 0],
        "back": [0, -1],
    }
    marks = tuple(
        Landmark(name=f"on the {side}", position_mm=np.array([radius * x, radius * y, 100.0]))
        for side, (x, y) in places.items()
    )
    drawing = mirror_check(stump.mesh, marks, "left", "a.aop")
    assert numbers_by_view(drawing) == {
        "seen from the front": {"1"},
        "seen from the patient's right": {"2"},
        "seen from the patient's left": {"3"},
    }
    key = drawing.figure.get_supxlabel()
    assert "3 on the patient's left " in f"{key} "
    assert "4 on the back (out of sight)" in key
    assert key.count("out of sight") == 1


def test_a_mirror_check_says_in_the_corners_of_every_picture_what_lies_there(stump) -> None:
    """Sections as the trade draws them: from above, front up, the patient's right to the right."""
    right = stump.mesh.vertices_mm.copy()
    right[:, 0] = np.where(right[:, 0] > 0, 1.5 * right[:, 0], right[:, 0])
    drawing = mirror_check(stump.mesh.with_vertices(right), (), "right", "a.aop")
    said = [
        {one.get_text(): one.get_position()[0] for one in axes.texts if one.get_text().isupper()}
        for axes in drawing.figure.axes
    ]
    assert said == [
        {"LEFT": 0.0, "FRONT": 0.5, "RIGHT": 1.0},
        {"RIGHT": 0.0, "LEFT": 1.0},
        {"BACK": 0.0, "FRONT": 1.0},
        {"FRONT": 0.0, "BACK": 1.0},
    ]
    png(drawing.figure)
    sections = drawing.figure.axes[0]
    drawn = np.concatenate([np.asarray(line.get_xydata()) for line in sections.lines])
    assert drawn[:, 0].max() == pytest.approx(1.5 * -drawn[:, 0].min(), rel=0.02)
    assert not sections.xaxis_inverted()
    assert not sections.yaxis_inverted()
    for axes in drawing.figure.axes:
        for one in axes.texts:
            if one.get_text().isupper():
                high_px = one.get_window_extent().height
                assert high_px > 0.012 * drawing.figure.bbox.width  # 10 px of 850 in the app


def test_the_views_of_a_mirror_check_have_one_scale_though_the_limb_is_deeper_than_wide(
    stump,
) -> None:
    deep = stump.mesh.with_vertices(stump.mesh.vertices_mm * [0.5, 1.0, 1.0])
    drawing = mirror_check(deep, (), "left", "a.aop")
    png(drawing.figure)
    views = [axes for axes in drawing.figure.axes if axes.get_images()]
    heights = []
    for axes in views:
        drawn = np.asarray(axes.get_images()[0].get_array())[..., 3] > 0
        per_pixel = axes.get_window_extent().height / abs(np.diff(axes.get_ylim())[0])
        heights.append(np.ptp(np.flatnonzero(drawn.any(1))) * per_pixel)
    assert len(heights) == 3
    np.testing.assert_allclose(heights, heights[0], rtol=0.01)


def test_every_view_of_the_record_says_in_its_corners_what_lies_there(stump) -> None:
    said = [
        {one.get_text(): one.get_position()[0] for one in axes.texts if one.get_text() in "RLFB"}
        for axes in four_sides_of_limb(stump).figure.axes
    ]
    assert said == [  # anterior, the patient's right, posterior, the patient's left
        {"R": 0.02, "L": 0.98},
        {"B": 0.02, "F": 0.98},
        {"L": 0.02, "R": 0.98},
        {"F": 0.02, "B": 0.98},
    ]


def test_a_zone_at_a_landmark_with_dollar_signs_is_drawn(stump: Limb) -> None:
    device = SimpleNamespace(en="AFO", measures=lambda _made: ())
    made = SimpleNamespace(
        preview=SimpleNamespace(device=device, values={}, made="printed"),
        solid=stump.mesh,
        thickness_mm=np.full(len(stump.mesh), 4.0),
        findings=(note("device.zone", place="$__$", add_mm=1.0, reach_mm=20.0),),
    )
    drawn = png(device_drawing(cast(FinishedDevice, made), "right").figure)
    assert drawn.tobytes().startswith(b"\x89PNG")
