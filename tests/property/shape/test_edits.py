"""Any edit that is not refused leaves a manifold, and its ledger tells what a look would find."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import (
    boundary_loops,
    is_edge_manifold,
    is_vertex_manifold,
    volume_mm3,
)
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.request_fields import declared
from limbgram.findings import note
from limbgram.workbench.edits.clean import Clean
from limbgram.workbench.edits.cutting import ON_CUT_MM
from limbgram.workbench.edits.distal_end import DistalEnd
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.edits.extension import Extension
from limbgram.workbench.edits.fill import Fill
from limbgram.workbench.edits.flare import Flare
from limbgram.workbench.edits.from_template import FromTemplate
from limbgram.workbench.edits.increase import Increase
from limbgram.workbench.edits.liner import Liner
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.smoothing import Smoothing
from limbgram.workbench.edits.sock import Sock
from limbgram.workbench.edits.sock_ply import SockPly
from limbgram.workbench.edits.trimline import Trimline
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.frame.landmarks import with_landmarks
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.recipe.file import encode_recipe, make_edit, parse_recipe
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay
from limbgram.workbench.templates.chart_field import ANGLES, node_heights
from limbgram.workbench.templates.files import encode_template
from limbgram.workbench.templates.template import Template, TemplateMark

SPOKES = 36
REFERENCE = "mark in front"


def stump() -> Mesh:
    """Half a sphere of 40 mm below height 0, and a tube from there to 125 mm, open at its top."""
    angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
    rows = [(40 * np.sin(p), -40 * np.cos(p)) for p in np.linspace(0, np.pi / 2, 10)[1:]]
    rows += [(40.0, z) for z in np.linspace(0, 125, 19)[1:]]
    rings = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle + z]) for r, z in rows
    ]
    here = 1 + np.arange(SPOKES)
    ahead = np.roll(here, -1)
    faces = [np.column_stack([0 * here, ahead, here])]
    for row in range(len(rows) - 1):
        a, b = here + row * SPOKES, ahead + row * SPOKES
        faces += [np.column_stack([a, b, b + SPOKES]), np.column_stack([a, b + SPOKES, a + SPOKES])]
    return Mesh(
        vertices_mm=np.concatenate([[[0.0, 0.0, -40.0]], *rings]),
        faces=np.concatenate(faces).astype(np.int32),
    )


BASE = stump()


def bumpy(seed: int) -> Limb:
    """The stump with bumps of some millimetres, in a mesh frame of its own."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform([-40, -40, 0], [40, 40, 120], (6, 3))
    away = np.linalg.norm(BASE.vertices_mm[:, None] - centres, axis=2)
    bumps = (np.exp(-(away**2) / 300) * rng.uniform(-3, 3, 6)).sum(1)
    points = BASE.vertices_mm + bumps[:, None] * BASE.vertex_normals()
    motion = Rigid.from_rotation_vector(rng.normal(size=3), rng.normal(size=3) * 50)
    front = points[np.linalg.norm(points - [0, 40, 100], axis=1).argmin()]
    return AlignedLimb(
        mesh=BASE.with_vertices(motion.inverse.apply(points)),
        frame=LimbFrame(limb_from_mesh=motion, side="left"),
        landmarks=(Landmark(name=REFERENCE, position_mm=motion.inverse.apply(front[None])[0]),),
    )


def template() -> str:
    """Carves in by 2 mm in front, half way up, and nothing else."""
    up = node_heights(1.2)
    angles = 2 * np.pi * np.arange(ANGLES) / ANGLES
    hollow = np.exp(-((up[:, None] - 0.5) ** 2) / 0.02 - (1 - np.cos(angles)[None]) / 0.2)
    made = Template(
        name="made",
        pairs=1,
        sided=True,
        reference=REFERENCE,
        marks=(TemplateMark(name=REFERENCE, height=1.0, angle_deg=0.0),),
        heights=up,
        displacement_mm=np.round(-2 * hollow, 2) + 0.0,
        spread_mm=np.full(hollow.shape, np.nan),
        known_pairs=np.ones(hollow.shape, np.int64),
    )
    return encode_template(made).decode()


def place(turn: float, height: float) -> tuple[float, float, float]:
    return (40 * float(np.sin(turn)), 40 * float(np.cos(turn)), height)


turns = st.floats(0, 6.28)
heights = st.floats(20, 90)
places = st.builds(place, turns, heights)
amounts = st.floats(0.5, 6)
rings = st.builds(
    lambda turn, height, width: tuple(
        place(turn + width * float(np.cos(a)), height + 30 * width * float(np.sin(a)))
        for a in 2 * np.pi * np.arange(8) / 8
    ),
    turns,
    heights,
    st.floats(0.3, 0.6),
)
lines = st.builds(
    lambda height, rise: tuple(
        place(float(a), height + rise * float(np.cos(2 * a)))
        for a in 2 * np.pi * np.arange(14) / 14
    ),
    heights,
    st.floats(0, 15),
)
levels = {"heights_mm": st.just((10.0, 90.0)), "of": st.sampled_from(["girth", "volume"])}
per_cent = st.tuples(st.floats(0, 10), st.floats(0, 10))
names = st.sampled_from(["iceross-original", "alpha-3mm", "alpha-6mm", "alpha-9mm"])
BY_HAND: dict[type[Edit], st.SearchStrategy[Any]] = {
    Clean: st.builds(Clean, spikes=st.booleans()),
    Relieve: st.builds(Relieve, at=places, depth_mm=amounts, falloff_mm=st.floats(10, 40)),
    Load: st.builds(Load, within=rings, depth_mm=amounts, falloff_mm=st.floats(5, 20)),
    Reduction: st.builds(Reduction, per_cent=per_cent, **levels),
    Increase: st.builds(Increase, per_cent=per_cent, **levels),
    Liner: st.builds(Liner, name=names, share=st.floats(0, 1)),
    Sock: st.builds(Sock, thickness_mm=st.floats(0.1, 5)),
    SockPly: st.builds(SockPly, plies=st.floats(-5, 5)),
    Offset: st.builds(Offset, distance_mm=st.floats(-3, 3)),
    Smoothing: st.builds(Smoothing, passes=st.integers(1, 6), leave=st.tuples(places)),
    Extension: st.builds(Extension, length_mm=st.floats(1, 40)),
    Flare: st.builds(Flare, depth_mm=amounts, height_mm=st.floats(8, 30)),
    DistalEnd: st.builds(
        DistalEnd,
        height_mm=st.floats(15, 50),
        lengthen_mm=st.floats(-5, 15),
        roundness=st.floats(0, 1),
    ),
    PlaneCut: st.builds(
        PlaneCut,
        height_mm=st.floats(10, 70),
        forward_deg=st.floats(-20, 20),
        right_deg=st.floats(-20, 20),
        keep=st.sampled_from(["distal", "proximal"]),
        capped=st.booleans(),
    ),
    Trimline: st.builds(Trimline, through=lines, keep=st.sampled_from(["distal", "proximal"])),
    Fill: st.just(Fill(brim=True)),
    Wall: st.builds(Wall, thickness_mm=amounts, side=st.sampled_from(["outward", "inward"])),
    Mirror: st.just(Mirror(confirmed_side="right")),
    FromTemplate: st.builds(FromTemplate, learned=st.just(template()), strength=st.floats(0.2, 2)),
}
"""For those that are tried in more ways than round their own example."""


def round_its_example(kind: type[Edit]) -> st.SearchStrategy[Edit]:
    """An edit by what it declares: its numbers near those of its example, any of its choices."""
    given: dict[str, st.SearchStrategy[Any]] = {}
    for one in declared(kind):
        value = kind.about.example.get(one.name)
        if one.choices:
            given[one.name] = st.sampled_from(one.choices)
        elif one.hint is bool:
            given[one.name] = st.booleans()
        elif one.hint is float and value is not None:
            ends = sorted((value / 4, value * 2))
            if one.within is not None:
                ends = [max(ends[0], one.within.least), min(ends[1], one.within.most)]
            given[one.name] = st.floats(*ends, exclude_min=ends[0] == 0)
        elif value is not None:
            given[one.name] = st.just(value)
    return st.fixed_dictionaries(given).map(
        lambda values: make_edit(name_of(kind), values, "tried")
    )


TRIED = {kind: BY_HAND[kind] if kind in BY_HAND else round_its_example(kind) for kind in EDITS}
AT_A_PLACE: dict[type[Edit], Edit] = {
    Relieve: Relieve(at=place(1, 60), depth_mm=5, falloff_mm=20),
    Load: Load(at=place(1, 60), depth_mm=4, falloff_mm=20),
    Trimline: Trimline(through=tuple(place(a, 70) for a in range(6))),
    FromTemplate: FromTemplate(learned=template()),
}
"""Of those whose example names what this limb has not."""
EDIT = st.one_of(*TRIED.values())


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_an_edit_does_its_example_or_says_why_not(kind: type[Edit]) -> None:
    """Every kind there is, also one that nobody has thought of here.

    What was said of the limb before goes on being said of it.
    """
    edit = make_edit(name_of(kind), kind.about.example, "its example")
    before = note("said.as_is", message="two bodies were left out")
    limb = replace(bumpy(1), notes=(before,))
    refusal = None
    try:
        done = do_edit(limb, edit)
    except EditError as error:
        done, refusal = None, error.finding.code
    assert refusal in (None, "edit.kind", "edit.landmark.none", "edit.template.unreadable")
    if done is not None:
        moved = done.mesh.vertices_mm.tobytes() != limb.mesh.vertices_mm.tobytes()
        assert done.notes[0] == before, "it drops what was said"
        assert moved or done.notes[1:], "it does nothing and says nothing"


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_landmarks_are_on_the_surface_or_gone_with_a_word_after_every_edit(
    kind: type[Edit],
) -> None:
    limb = bumpy(1)
    spread = np.random.default_rng(4).choice(len(limb.mesh), 40, replace=False)
    marks = [
        Landmark(name=f"no. {k}", position_mm=limb.mesh.vertices_mm[vertex])
        for k, vertex in enumerate(spread)
    ]
    limb = with_landmarks(limb, [*limb.landmarks, *marks])
    edit = AT_A_PLACE.get(kind) or make_edit(name_of(kind), kind.about.example, "its example")
    try:
        after = do_edit(limb, edit)
    except EditError as error:
        assert error.finding.code == "edit.kind"  # noqa: PT017 - others are done
        return
    places = np.stack([mark.position_mm for mark in after.landmarks])
    assert tree_on(after.mesh).closest(places).distances_mm.max() < ON_CUT_MM
    gone = {mark.name for mark in limb.landmarks} - {mark.name for mark in after.landmarks}
    told = [one for one in after.notes if one.code == "edit.landmark.cut_off"]
    assert {one.values["name"] for one in told} == gone


@settings(max_examples=20)
@given(seed=st.integers(0, 20), edit=EDIT)
def test_manifold_in_manifold_out(seed: int, edit: Edit) -> None:
    limb = bumpy(seed)
    try:
        after = do_edit(limb, edit).mesh
    except EditError:
        return  # how often that happens is looked at below
    assert is_edge_manifold(after.faces)
    assert is_vertex_manifold(after.faces)
    assert np.isfinite(after.vertices_mm).all()
    assert not len(find_crossings(after.vertices_mm, after.faces))
    assert volume_mm3(after) > 0
    if isinstance(edit, Fill | Wall):
        assert not boundary_loops(after.faces)
    if after.filled is not None:
        assert len(after.filled) == len(after)


@pytest.mark.parametrize(
    "edit",
    [
        Relieve(at=place(1, 60), depth_mm=5, falloff_mm=20),
        Load(within=tuple(place(0.4 * np.cos(a), 60 + 12 * np.sin(a)) for a in range(6)),
               depth_mm=4, falloff_mm=10),
        Offset(distance_mm=-2),
        Trimline(through=tuple(place(a, 70 + 10 * float(np.cos(2 * a))) for a in range(6))),
        Wall(thickness_mm=4),
        Extension(length_mm=20),
        FromTemplate(learned=template()),
        PlaneCut(height_mm=60, forward_deg=10, capped=True),
    ],
    ids=lambda edit: type(edit).__name__,
)  # fmt: skip
def test_edits_of_every_day_are_not_refused(edit: Edit) -> None:
    for seed in range(2):
        do_edit(bumpy(seed), edit)


@settings(max_examples=4)
@given(seed=st.integers(0, 20), edits=st.lists(EDIT, min_size=1, max_size=3))
def test_the_ledger_tells_what_a_look_finds_and_replay_repeats(
    seed: int, edits: list[Edit]
) -> None:
    recipe = Recipe(name="any", entries=tuple(Entry(edit=edit) for edit in edits))
    assert parse_recipe(encode_recipe(recipe).decode(), "any") == recipe
    limb = bumpy(seed)
    try:
        first = replay(recipe, limb)
    except EditError:
        return
    step = limb
    for line, edit in zip(first.ledger.lines, edits, strict=True):
        assert line.before.volume_ml == pytest.approx(volume_mm3(step.mesh) / 1000, abs=1e-9)
        after = do_edit(step, edit)
        assert line.after.volume_ml == pytest.approx(volume_mm3(after.mesh) / 1000, abs=1e-9)
        if line.displacement is not None and len(after.mesh) == len(step.mesh):
            ways = np.linalg.norm(after.mesh.vertices_mm - step.mesh.vertices_mm, axis=1)
            assert abs(line.displacement.largest_mm) <= ways.max() + 1e-9
            assert abs(line.displacement.mean_mm) <= line.displacement.mean_size_mm + 1e-12
        step = after
    again = replay(recipe, limb)
    assert again.limb.mesh.vertices_mm.tobytes() == first.limb.mesh.vertices_mm.tobytes()
    assert again.limb.mesh.faces.tobytes() == first.limb.mesh.faces.tobytes()
    assert again.ledger == first.ledger
