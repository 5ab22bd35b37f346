"""Templates recover what was done to limbs of other sizes, shapes, sides and poses."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.unit.file_sizes import require_takes_up_to
from tests.unit.workbench.devices.shapes import make_foot
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import MeasureError, OptionsError, ShapeFileError
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import Gravity, note, told
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.from_template import FromTemplate
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.limb import Landmark
from limbgram.workbench.recipe.ledger import lines_of
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay
from limbgram.workbench.templates.chart_field import evaluate_field, fit_field, node_heights
from limbgram.workbench.templates.charts import LimbChart, plain_chart, pulled_chart
from limbgram.workbench.templates.files import decode_template, encode_template, read_template
from limbgram.workbench.templates.learning import LearnOptions, Pair, learn
from limbgram.workbench.templates.template import apply_template, moves_at_marks

OF_FILE = note("said.as_is", message="two bodies were left out")
OTHER_FILE = note("said.as_is", message="a hole was closed")
AS_IS = LearnOptions(registration=RegistrationOptions(way="as-is"))
BUILDS = [
    {},
    {"size": 1.08, "tall": 1.05, "squeeze": 0.02, "turn": 0.15},
    {"size": 0.93, "tall": 0.95, "squeeze": -0.02, "turn": -0.12},
    {"size": 1.04, "tall": 0.97, "squeeze": 0.01, "turn": 0.10},
    {"size": 0.97, "tall": 1.06, "squeeze": -0.01, "turn": -0.10},
]


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def below_brim(limb) -> np.ndarray:
    heights = limb.mesh.vertices_mm[:, 2]
    return heights < heights.max() - 15


def pairs_of(bench, noise_mm: float) -> list[Pair]:
    pairs: list[Pair] = []
    for k, build in enumerate(BUILDS):
        limb = bench.limb_of(bench.build(**build), "left" if k % 2 else "right")
        done = bench.rectification(limb) + bench.ripple(limb, k, noise_mm)
        pairs.append(
            Pair(before=bench.lying(limb, k), after=bench.lying(bench.after(limb, done), 100 + k))
        )
    return pairs


@pytest.fixture(scope="module")
def own(bench):
    limb = bench.limb_of(bench.build())
    done = bench.after(limb, bench.rectification(limb))
    return learn([Pair(before=limb, after=done)], "own", AS_IS).template


@pytest.fixture(scope="module")
def learned(bench):
    return learn(pairs_of(bench, 0.4), "learned", AS_IS).template


def test_one_pair_gives_back_what_was_done_to_it(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    error = apply_template(limb, own).moved_mm - bench.rectification(limb)
    assert rms(error[below_brim(limb)]) < 0.03
    assert np.abs(error[below_brim(limb)]).max() < 0.15
    assert own.displacement_mm.min() == pytest.approx(-6, abs=0.1)


@pytest.mark.parametrize(
    ("build", "side"),
    [({"size": 1.02, "tall": 1.02, "turn": 0.03}, "right"), ({"size": 0.95, "turn": -0.1}, "left")],
)
def test_noisy_pairs_recover_the_rectification_on_another_limb(bench, learned, build, side) -> None:
    """5 pairs, ripples of 0.4 mm: the mean keeps 0.4 / sqrt(5) and what landmarks cannot tell."""
    limb = bench.limb_of(bench.build(**build), side)
    true = bench.rectification(limb)
    applied = apply_template(bench.lying(limb, 55), learned)
    error = (applied.moved_mm - true)[below_brim(limb)]
    assert 0.02 < rms(error) < 0.25
    core = np.abs(true[below_brim(limb)]) > 1
    assert rms(error[core]) < 0.25 * rms(true[below_brim(limb)][core])
    assert not applied.notes


def test_the_spread_is_that_of_the_pairs(learned) -> None:
    assert np.nanmedian(learned.spread_mm) == pytest.approx(0.4, rel=0.35)
    assert learned.pairs == 5
    assert learned.known_pairs.max() == 5


def test_three_pairs_are_enough_for_what_stands_out(bench) -> None:
    found = learn(pairs_of(bench, 0.4)[:3], "three", AS_IS).template
    assert found.displacement_mm.min() == pytest.approx(-6, abs=0.6)
    assert found.displacement_mm.max() == pytest.approx(4, abs=0.6)
    assert (found.displacement_mm != 0).mean() < 0.35


def test_where_nothing_was_done_alike_there_is_no_template(bench) -> None:
    pairs = []
    for k, build in enumerate(BUILDS):
        limb = bench.limb_of(bench.build(**build))
        pairs.append(Pair(before=limb, after=bench.after(limb, bench.ripple(limb, 20 + k, 0.4))))
    with pytest.raises(MeasureError, match="Nothing was done alike"):
        learn(pairs, "nothing", AS_IS)
    same = [Pair(before=pair.before, after=pair.before) for pair in pairs]
    with pytest.raises(MeasureError, match=r"0\.1 mm or more"):
        learn(same[:2], "nothing", AS_IS)


def test_one_spoilt_pair_of_five_hardly_counts(bench) -> None:
    pairs = pairs_of(bench, 0.0)
    limb = bench.limb_of(bench.build())
    wrong = bench.after(limb, bench.rectification(limb, {"tibial crest": 8.0}))
    spoilt = learn([*pairs[1:], Pair(before=limb, after=wrong)], "spoilt", AS_IS).template
    applied = apply_template(limb, spoilt)
    crest = next(m.position_mm for m in limb.landmarks if m.name == "tibial crest")
    near = np.linalg.norm(limb.mesh.vertices_mm - crest, axis=1) < 5
    assert np.abs(applied.moved_mm[near]).max() < 0.5 < 8 / 5


def test_pairs_may_lie_anywhere_if_laid_by_shape(bench) -> None:
    limb = bench.limb_of(bench.build())
    done = bench.after(limb, bench.rectification(limb)).unaligned()
    found = learn([Pair(before=bench.lying(limb, 3), after=bench.lying(done, 4))], "laid").template
    error = apply_template(limb, found).moved_mm - bench.rectification(limb)
    assert rms(error[below_brim(limb)]) < 0.1


def test_strength_scales_and_landmarks_ride_along(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    full, half = apply_template(limb, own), apply_template(limb, own, 0.5)
    np.testing.assert_allclose(half.moved_mm, 0.5 * full.moved_mm, atol=1e-12)
    moved = full.limb.landmarks[0].position_mm - limb.landmarks[0].position_mm
    assert np.linalg.norm(moved) == pytest.approx(6, abs=0.2)
    assert full.limb.frame == limb.frame
    with pytest.raises(OptionsError, match="strength"):
        apply_template(limb, own, 0.0)


def test_a_template_tells_where_it_presses_on_bone(bench, own, tmp_path) -> None:
    """Under another name the place of the load is one that bears none."""
    limb = bench.limb_of(bench.build())
    moves = moves_at_marks(own)
    name = min(moves, key=lambda mark: moves[mark])
    assert moves[name] < -1
    assert apply_template(limb, own).pressures == ()
    called = {name: "neuroma"}

    def renamed(marks):
        return tuple(replace(mark, name=called.get(mark.name, mark.name)) for mark in marks)

    template = replace(
        own, marks=renamed(own.marks), reference=called.get(own.reference, own.reference)
    )
    applied = apply_template(replace(limb, landmarks=renamed(limb.landmarks)), template)
    (pressure,) = applied.pressures
    assert pressure.place == "marked place"
    assert pressure.depth_mm == pytest.approx(-applied.moved_mm.min(), abs=0.3)
    (pressing,) = (one for one in applied.notes if one.code == "template.presses")
    assert pressing.values["place"] == "marked place"
    assert "sore" in told(pressing)
    path = tmp_path / "own.json"
    path.write_bytes(encode_template(template))
    answer = CliRunner().invoke(app, ["template", "show", str(path)])
    assert "! presses on the marked place" in answer.output


def test_a_left_limb_gets_the_mirror_image(bench, own) -> None:
    right, left = bench.limb_of(bench.build()), bench.limb_of(bench.build(), "left")
    moved = apply_template(right, own).moved_mm
    np.testing.assert_allclose(apply_template(left, own).moved_mm, moved, atol=1e-6)
    fibula = next(m.position_mm for m in left.landmarks if m.name == "fibula head")
    assert fibula[0] < 0


def test_a_limb_without_side_gets_no_sided_template(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    bare = replace(limb, frame=replace(limb.frame, side="none"))
    with pytest.raises(MeasureError, match="lateral"):
        apply_template(bare, own)
    with pytest.raises(OptionsError, match="side"):
        learn([Pair(before=bare, after=bare), Pair(before=limb, after=limb)], "mixed", AS_IS)


def test_a_mirror_is_no_rectification(bench) -> None:
    limb = bench.limb_of(bench.build())
    other = "left" if limb.frame.side == "right" else "right"
    image = do_edit(limb, Mirror(confirmed_side=other))
    with pytest.raises(OptionsError, match="a mirror, no rectification"):
        learn([Pair(before=limb, after=image)], "mirrored", LearnOptions())


def test_missing_landmarks_and_frames_are_named(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    without = tuple(mark for mark in limb.landmarks if mark.name != own.reference)
    with pytest.raises(MeasureError, match=own.reference):
        apply_template(replace(limb, landmarks=without), own)
    other = tuple(mark for mark in limb.landmarks if mark.name != "fibula head")
    (lacking,) = apply_template(replace(limb, landmarks=other), own).notes
    assert lacking == note("template.marks_missing", names=("fibula head",))
    with pytest.raises(MeasureError, match="not aligned"):
        apply_template(limb.unaligned(), own)
    bare = replace(limb, landmarks=())
    with pytest.raises(MeasureError, match="share no landmark"):
        learn([Pair(before=bare, after=limb)], "none", AS_IS)
    with pytest.raises(OptionsError, match="No pair"):
        learn([], "none", AS_IS)


def test_what_a_template_says_reaches_the_ledger(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    lacking = tuple(mark for mark in limb.landmarks if mark.name != "fibula head")
    limb = replace(limb, landmarks=lacking, notes=(OF_FILE,))
    said = apply_template(limb, own).notes
    assert said[0] == note("template.marks_missing", names=("fibula head",))
    edit = FromTemplate(learned=encode_template(own).decode())
    done = replay(Recipe(name="x", entries=(Entry(edit=edit),)), limb)
    assert done.limb.notes == (OF_FILE, *said)
    (line,) = done.ledger.lines
    assert line.told[:-1] == done.limb.notes[1:]
    assert line.told[-1].code == "edit.enclosed"
    assert any("lacks fibula head" in text for text in lines_of(done.ledger))


def test_what_was_odd_about_a_pair_s_files_is_said_of_the_template(bench) -> None:
    limb = bench.limb_of(bench.build())
    after = replace(bench.after(limb, bench.rectification(limb)), notes=(OTHER_FILE,))
    before = replace(limb, notes=(OF_FILE,))
    notes = learn([Pair(before=before, after=after)], "one", AS_IS).notes
    assert {OF_FILE, OTHER_FILE} <= set(notes)


def test_a_landmark_on_the_wrong_side_is_refused(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    swapped = tuple(
        replace(mark, position_mm=mark.position_mm * [-1, 1, 1])
        if mark.name == "fibula head"
        else mark
        for mark in limb.landmarks
    )
    with pytest.raises(MeasureError, match="fibula head"):
        apply_template(replace(limb, landmarks=swapped), own)


def test_the_chart_puts_landmarks_where_the_template_has_them(bench) -> None:
    limb = bench.limb_of(bench.build(turn=0.2))
    wanted = {"fibula head": np.array([0.8, 1.3]), "tibial crest": np.array([0.4, 0.0])}
    plain = plain_chart(limb, "patellar tendon", "axis")
    chart = pulled_chart(limb, plain, wanted)
    for mark in limb.landmarks:
        if mark.name in wanted:
            place = chart.places(mark.position_mm[None])[0]
            np.testing.assert_allclose(place, wanted[mark.name], atol=1e-5)
    tip = plain.unpulled(np.zeros((1, 3)))[0, 0]
    assert tip == pytest.approx(-0.4)


def test_no_chart_that_is_accepted_folds(bench) -> None:
    """Random landmarks and templates: every accepted chart keeps turning the same way round.

    The truth is the chart itself: no small triangle of places, anywhere, comes out turned over.
    """
    limb = bench.limb_of(bench.build())
    plain = plain_chart(limb, "patellar tendon", "axis")
    draw = np.random.default_rng(4)
    heights, angles = np.arange(-0.4, 2.5, 0.03), np.arange(-np.pi, np.pi, 0.07)
    grid = np.stack(np.meshgrid(heights, angles, indexing="ij"), axis=-1)
    accepted = refused = 0
    for _ in range(200):
        count = draw.integers(4, 9)
        own = np.column_stack([draw.uniform(0, 1.1, count), draw.uniform(-np.pi, np.pi, count)])
        moves = draw.uniform(0.1, 0.4) * draw.normal(size=(count, 2)) * [0.4, 1.0]
        marks = marked(plain, own)
        wanted = {mark.name: place + move for mark, place, move in zip(marks, own, moves)}
        try:
            chart = pulled_chart(replace(limb, landmarks=marks), plain, wanted)
        except MeasureError:
            refused += 1
            continue
        accepted += 1
        pulled = chart.with_pull(grid.reshape(-1, 2)).reshape(grid.shape)
        up, round_ = np.diff(pulled, axis=0)[:, :-1], np.diff(pulled, axis=1)[:-1]
        turned = up[..., 0] * round_[..., 1] - up[..., 1] * round_[..., 0]
        assert turned.min() > 0
    assert accepted > 100
    assert refused > 10


def test_a_pull_that_turns_the_chart_over_askew_is_refused(bench) -> None:
    """A cross of landmarks: those beside go up and down by 0.5 radii, those above and below round
    by 0.7. Along each axis nothing comes nearer, but askew the chart folds (determinant -0.4).
    """
    limb = bench.limb_of(bench.build())
    plain = plain_chart(limb, "patellar tendon", "axis")
    own = np.array([[0.5, -0.5], [0.5, 0.5], [0.3, 0.0], [0.7, 0.0]])
    moves = np.array([[-0.2, 0.0], [0.2, 0.0], [0.0, -0.7], [0.0, 0.7]])
    marks = marked(plain, own)
    limb = replace(limb, landmarks=marks)

    def pulled(share: float) -> LimbChart:
        places = own + share * moves
        return pulled_chart(
            limb, plain, {mark.name: place for mark, place in zip(marks, places, strict=True)}
        )

    middle = np.array([[0.5, 0.0]])
    assert 0.2 < pulled(0.5).least_stretch(middle)[0] < 0.5
    with pytest.raises(MeasureError, match="another order"):
        pulled(1.0)


def marked(plain: LimbChart, own: np.ndarray) -> tuple[Landmark, ...]:
    """Landmarks of a limb that stands in its limb frame, at these places of its chart."""
    height = plain.dome_mm + own[:, 0] * (plain.reference_mm - plain.dome_mm)
    x, y = 50 * plain.lateral * np.sin(own[:, 1]), 50 * np.cos(own[:, 1])
    places = np.column_stack([x, y, height])
    return tuple(Landmark(name=f"mark {k}", position_mm=one) for k, one in enumerate(places))


def test_a_field_gives_back_a_smooth_function() -> None:
    rng = np.random.default_rng(2)
    heights = node_heights(1.2)
    places = np.column_stack([rng.uniform(-0.4, 1.2, 40_000), rng.uniform(-np.pi, np.pi, 40_000)])

    def truth(at: np.ndarray) -> np.ndarray:
        return np.sin(3 * at[:, 0]) * np.clip(at[:, 0] + 0.4, 0, 1) * np.cos(2 * at[:, 1] + 0.3)

    field = fit_field(places, truth(places), heights)
    error = evaluate_field(field, heights, places) - truth(places)
    assert rms(error) < 0.005
    seam = np.column_stack([np.full(50, 0.5), np.linspace(np.pi - 0.1, np.pi + 0.1, 50)])
    assert np.abs(np.diff(evaluate_field(field, heights, seam))).max() < 0.01


def test_a_file_reads_back_and_stays_short(learned, own, tmp_path) -> None:
    for template in (learned, own):
        path = tmp_path / "t.json"
        path.write_bytes(encode_template(template))
        again = read_template(path)
        assert encode_template(again) == path.read_bytes()
        assert path.stat().st_size < 60_000
        np.testing.assert_allclose(
            again.displacement_mm, template.displacement_mm, atol=0.00501, rtol=0
        )
        np.testing.assert_array_equal(again.known_pairs, template.known_pairs)
        assert [mark.name for mark in again.marks] == [mark.name for mark in template.marks]


@pytest.mark.parametrize(
    "spoil",
    [
        {"version": 99},
        {"displacement_mm": ["0.0 0.0"]},
        {"top": 40.0},
        {"sided": "yes"},
        {"name": ""},
        {"landmarks": [{"name": "x", "height": float("nan"), "angle_deg": 0}]},
    ],
)
def test_a_damaged_file_is_refused(own, tmp_path, spoil) -> None:
    tree = json.loads(encode_template(own))
    path = tmp_path / "t.json"
    path.write_text(json.dumps({**tree, **spoil}))
    with pytest.raises(ShapeFileError, match="no template"):
        read_template(path)


def test_enormous_displacements_in_a_file_are_refused(own) -> None:
    tree = json.loads(encode_template(own))
    tree["displacement_mm"][3] = tree["displacement_mm"][3].replace("0.00", "1e9", 1)
    with pytest.raises(ValueError, match="cannot be"):
        decode_template(json.dumps(tree).encode())


@pytest.mark.parametrize(
    ("key", "last", "beyond"),
    [
        ("pairs", 100_000, 100_001),
        ("name", "n" * 80, "n" * 81),
        ("reference", "n" * 80, "n" * 81),
        ("landmarks", [{"name": "x", "height": 100.0, "angle_deg": 0.0}],
         [{"name": "x", "height": 100.1, "angle_deg": 0.0}]),
    ],
    ids=["pairs", "name", "reference", "height"],
)  # fmt: skip
def test_a_template_holds_so_much_and_no_more(own, key, last, beyond) -> None:
    tree = json.loads(encode_template(own))
    decode_template(json.dumps(tree | {key: last}).encode())
    with pytest.raises(ValueError, match=r"cannot be|no name|without a place"):
        decode_template(json.dumps(tree | {key: beyond}).encode())


@pytest.mark.parametrize("field", ["displacement_mm", "spread_mm"])
def test_no_rectification_moves_a_limb_by_more_than_60_mm(own, field) -> None:
    tree = json.loads(encode_template(own))
    row = tree[field][3].split()
    for first in ("60.00", "60.01"):
        rows = [" ".join([first, *row[1:]]) if k == 3 else one for k, one in enumerate(tree[field])]
        content = json.dumps(tree | {field: rows}).encode()
        if first == "60.00":
            decode_template(content)
        else:
            with pytest.raises(ValueError, match="cannot be"):
                decode_template(content)


def test_a_template_is_read_up_to_2_mb(tmp_path) -> None:
    require_takes_up_to(read_template, tmp_path / "t.json", 2_000_000)


def test_two_limbs_are_no_rectification(bench) -> None:
    """25 % wider: more than 10 mm off all round."""
    limb, other = bench.limb_of(bench.build()), bench.limb_of(bench.build(size=1.25, squeeze=0.1))
    done = bench.after(limb, bench.rectification(limb))
    (warned,) = (
        one
        for one in learn([Pair(before=limb, after=other)], "two", AS_IS).notes
        if one.code == "template.pair.unlike"
    )
    assert warned.gravity is Gravity.DOUBT
    usual = learn([Pair(before=limb, after=done)], "one", AS_IS).notes
    assert not any(one.code == "template.pair.unlike" for one in usual)


def test_a_pair_that_does_not_meet_is_refused(bench) -> None:
    """Told to lie as its files do, and half a metre apart."""
    limb = bench.limb_of(bench.build())
    done = bench.after(limb, bench.rectification(limb))
    away = done.with_mesh(done.mesh.with_vertices(done.mesh.vertices_mm + np.array([500.0, 0, 0])))
    pairs = [Pair(before=limb, after=done), Pair(before=limb, after=away)]
    with pytest.raises(MeasureError) as refused:
        learn(pairs, "two", AS_IS)
    assert refused.value.finding.code == "compare.surface.no_counterpart"


def test_a_crumb_below_the_limb_does_not_shift_a_template(bench, own) -> None:
    limb = bench.limb_of(bench.build())
    corners = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]]) - [1, 1, 40]
    count = len(limb.mesh)
    sides = count + np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    mesh = replace(
        limb.mesh,
        vertices_mm=np.concatenate([limb.mesh.vertices_mm, corners]),
        faces=np.concatenate([limb.mesh.faces, sides]).astype(np.int32),
    )
    clean, beside = (apply_template(one, own).moved_mm for one in (limb, limb.with_mesh(mesh)))
    np.testing.assert_allclose(beside[:count], clean, atol=1e-9)


def test_by_default_a_pair_is_taken_as_it_lies(bench) -> None:
    """3 % of girth off the lower half: by shape the limb would slide and hide a part of it."""
    limb = bench.lying(bench.limb_of(bench.build()), 7)
    inside = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    inside[:, :2] *= 1 - np.interp(inside[:, 2], [20, 160], [0.03, 0.0])[:, None]
    done = limb.with_mesh(limb.mesh.with_vertices(limb.frame.limb_from_mesh.inverse.apply(inside)))
    learned = learn([Pair(before=limb, after=done)], "reduction")
    assert any("taken as they lie" in told(one) for one in learned.notes)
    applied = apply_template(limb, learned.template).limb
    true_mm3, found_mm3 = (
        volume_mm3(shape.mesh) - volume_mm3(limb.mesh) for shape in (done, applied)
    )
    assert found_mm3 == pytest.approx(true_mm3, rel=0.03)


def test_what_was_done_to_a_foot_finds_its_place_whatever_the_ankle_s_angle() -> None:
    """A build-up of 4 mm over the navicular, on a foot that is then put down by 12 degrees."""
    foot = replace(make_foot(), name="foot")
    middle = foot.landmark("navicular").position_mm
    away_mm = np.linalg.norm(foot.mesh.vertices_mm - middle, axis=1)
    built_mm = 4.0 * np.exp(-((away_mm / 14.0) ** 2))
    built = foot.mesh.vertices_mm + built_mm[:, None] * foot.mesh.vertex_normals()
    after = foot.with_mesh(foot.mesh.with_vertices(built))
    template = learn([Pair(before=foot, after=after)], "navicular", AS_IS).template
    assert template.along == "centreline"
    posed = do_edit(foot, Repose(joint="ankle", by_deg=-12.0, beyond=True))
    for limb in (foot, posed):
        error_mm = apply_template(limb, template).moved_mm - built_mm
        assert np.abs(error_mm).max() < 0.6  # nodes of the chart lie 6 mm apart
        assert rms(error_mm[built_mm > 1.0]) < 0.2
    by_axis = replace(template, along="axis")
    with pytest.raises(MeasureError, match="lies"):  # its heights mean another thing there
        apply_template(posed, by_axis)


def test_a_file_says_what_its_heights_count_along(own) -> None:
    bent = replace(own, along="centreline")
    assert decode_template(encode_template(bent)).along == "centreline"
    assert json.loads(encode_template(bent))["version"] == 2  # older programs refuse it
    assert json.loads(encode_template(own))["version"] == 1
    tree = json.loads(encode_template(bent)) | {"version": 1}
    with pytest.raises(ValueError, match="curve"):
        decode_template(json.dumps(tree).encode())


def test_a_foot_without_the_landmarks_of_its_centreline_is_refused_by_name() -> None:
    foot = make_foot()
    lacking = replace(
        foot, landmarks=tuple(one for one in foot.landmarks if one.name != "second toe")
    )
    with pytest.raises(MeasureError, match="second toe"):
        plain_chart(lacking, "fibula head", "centreline")
