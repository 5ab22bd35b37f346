"""Pressure on what bears none, and unusual depths: refused without a word, marked with it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import EditError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import told
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.edits.edit import Edit, Effect, edit
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.edits.oval import Oval, move_oval
from limbgram.workbench.edits.pad import Pad
from limbgram.workbench.edits.pressing import USUAL_DEPTH_MM
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.room import Room
from limbgram.workbench.edits.sock import Sock
from limbgram.workbench.frame.landmarks import known_anywhere
from limbgram.workbench.frame.sensitive import SENSITIVE, sensitive_place
from limbgram.workbench.limb import KINDS, AlignedLimb, Landmark, Limb, LimbFrame
from limbgram.workbench.measures.sheet import SheetOptions, measuring_sheet
from limbgram.workbench.recipe.consent import concerns_of, not_accepted, words_for
from limbgram.workbench.recipe.file import encode_recipe, parse_recipe
from limbgram.workbench.recipe.ledger import lines_of
from limbgram.workbench.recipe.recipe import Entry, Recipe, accepted, added, replay, replay_as_it_is

RADIUS_MM = 50.0
HEAD = (RADIUS_MM, 0.0, 0.0)
WORD = "load on fibula head"


def limb() -> Limb:
    """An egg of radius 50 mm with a fibula head at its right and a tendon in front."""
    made = trimesh.creation.icosphere(4, RADIUS_MM)
    made.apply_scale([1, 1, 2])
    return AlignedLimb(
        mesh=Mesh(vertices_mm=np.asarray(made.vertices), faces=made.faces.astype(np.int32)),
        landmarks=(
            Landmark(name="fibula head", position_mm=np.array(HEAD)),
            Landmark(name="patellar tendon", position_mm=np.array([0.0, RADIUS_MM, 0.0])),
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"),
        kind="transtibial",
    )


def recipe(*edits: Edit, accept: tuple[str, ...] = ()) -> Recipe:
    return Recipe(name="x", entries=tuple(Entry(edit=edit, accept=accept) for edit in edits))


def beside(arc_mm: float) -> tuple[float, float, float]:
    """A place so far from the head round the limb, towards the front."""
    angle = arc_mm / RADIUS_MM
    return (RADIUS_MM * float(np.cos(angle)), RADIUS_MM * float(np.sin(angle)), 0.0)


ON_HEAD = Load(at="fibula head", depth_mm=5.0, falloff_mm=18.0)
ON_TENDON = Load(at="patellar tendon", depth_mm=5.0, falloff_mm=18.0)


@pytest.mark.parametrize(
    "name",
    ["fibula head", "Fibula Head", "fibular head", "fibula haed", "left fibula head",
     "peroneal nerve", "common_peroneal-nerve", "Fibulakopf", "Wadenbeinköpfchen rechts"],
)  # fmt: skip
def test_a_named_load_on_the_peroneal_nerve_needs_a_word(name: str) -> None:
    edit = replace(ON_HEAD, at=name)
    with pytest.raises(OptionsError, match=r"nerve.*--accept \"load on fibula head\""):
        added(recipe(), edit)
    (entry,) = added(recipe(), edit, accept=("Load on the  FIBULAR head",)).entries
    assert entry.accept == (WORD,)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("patellar tendon", "transtibial"), ("popliteal crease", "transtibial"),
     ("medial tibial condyle", "transtibial"), ("ischial tuberosity", "transfemoral"),
     ("heel", "foot"), ("patellar tendon bar", None), ("medial tibial flare", None)],
)  # fmt: skip
def test_what_is_meant_to_bear_needs_none(name: str, kind: str | None) -> None:
    assert sensitive_place(name, next((one for one in KINDS if one == kind), None)) is None
    added(recipe(), replace(ON_TENDON, at=name))


def test_a_load_on_a_name_that_nobody_knows_is_asked_about() -> None:
    edit = replace(ON_HEAD, at="blue dot")
    with pytest.raises(OptionsError, match=r"in no table.*--accept \"load on unknown place\""):
        added(recipe(), edit)
    (entry,) = added(recipe(), edit, accept=("load on unknown place",)).entries
    assert entry.accept == ("load on unknown place",)


@pytest.mark.parametrize(
    ("name", "place"), [("Fibulakopf", "fibula head"), ("P1", "unknown place")]
)
def test_a_load_beside_such_a_landmark_is_asked_about(name: str, place: str) -> None:
    head, tendon = limb().landmarks
    named = replace(limb(), landmarks=(replace(head, name=name), tendon))
    edit = Load(at=beside(9.0), positions_in="mesh", depth_mm=4.0, falloff_mm=15.0)
    with pytest.raises(EditError, match=f"on the {place}"):
        replay(recipe(edit), named)


@pytest.mark.parametrize(
    ("name", "place"),
    [("Distal Tibia", "tibia end"), ("Tibial Crest", "tibial crest"), ("patella", "mid patella"),
     ("medial malleolus", "medial malleolus"), ("greater trochanter", "greater trochanter"),
     ("adductor longus tendon", "adductor longus tendon"), ("neuroma behind", "marked place"),
     ("Anna's scar", "marked place"), ("where she is sore", "marked place")],
)  # fmt: skip
def test_bone_tendon_and_what_hurts_are_known(name: str, place: str) -> None:
    found = sensitive_place(name, None)
    assert found is not None
    assert found.name == place


def test_every_sensitive_landmark_is_found_under_its_own_name() -> None:
    for kind in KINDS:
        for place in SENSITIVE[kind]:
            assert sensitive_place(place.name, kind) == place
            assert place.reach_mm > 0
    assert known_anywhere("fibula head", "transtibial") is not None


def test_a_recipe_that_presses_on_the_nerve_is_not_done() -> None:
    with pytest.raises(EditError, match=r"Edit 1 .*`limbgram edit accept RECIPE 1` \"load on fib"):
        replay(recipe(ON_HEAD), limb())


def test_with_the_word_it_is_done_and_marked() -> None:
    done = replay(recipe(ON_HEAD, accept=(WORD,)), limb())
    (line,) = done.ledger.lines
    (concern,) = line.concerns
    assert concern.accepted
    assert concern.word == WORD
    assert concern.finding.code == "recipe.presses"
    assert concern.finding.values["place"] == "fibula head"
    assert concern.finding.values["depth_mm"] == pytest.approx(5.0, abs=0.05)
    assert done.ledger.places_mm == {"fibula head": pytest.approx(-5.0, abs=0.05)}
    told = lines_of(done.ledger)
    assert any("! presses 5.0 mm on the fibula head" in text for text in told)
    assert any("accepted: load on fibula head" in text for text in told)
    assert "fibula head -5.0 mm" in told[-1]


@pytest.mark.parametrize(("arc_mm", "presses"), [(12.0, True), (30.0, True), (70.0, False)])
def test_a_place_by_coordinates_near_the_nerve_counts(arc_mm: float, presses: bool) -> None:
    """At 30 mm the landmark itself is not moved, and the nerve below the head is."""
    edit = Load(at=beside(arc_mm), positions_in="mesh", depth_mm=4.0, falloff_mm=15.0)
    if not presses:
        assert replay(recipe(edit), limb()).ledger.lines[0].concerns == ()
        return
    with pytest.raises(EditError, match="on the fibula head"):
        replay(recipe(edit), limb())
    (concern,) = replay_as_it_is(recipe(edit), limb()).ledger.lines[0].concerns
    assert not concern.accepted


def test_a_load_beside_the_landmark_counts_in_the_sum() -> None:
    """All edits together press on the nerve as far as the one line says that its load does."""
    edit = Load(at=beside(30.0), positions_in="mesh", depth_mm=4.0, falloff_mm=15.0)
    ledger = replay_as_it_is(recipe(edit), limb()).ledger
    depth_mm = ledger.lines[0].concerns[0].finding.values["depth_mm"]
    assert isinstance(depth_mm, float)
    assert 1.0 < depth_mm < 4.0
    assert ledger.places_mm["fibula head"] == pytest.approx(-depth_mm, abs=1e-6)
    assert f"fibula head -{depth_mm:.1f} mm" in lines_of(ledger)[-1]


def test_loads_beside_each_other_do_not_add_up_and_room_does_not_hide_them() -> None:
    one, other = (
        Load(at=beside(arc_mm), positions_in="mesh", depth_mm=3.0, falloff_mm=12.0)
        for arc_mm in (16.0, -16.0)
    )
    room = Relieve(at="fibula head", depth_mm=5.0, falloff_mm=3.0)
    done = replay_as_it_is(recipe(one, other, room), limb())
    assert done.ledger.places_mm["fibula head"] == pytest.approx(-3.0, abs=0.05)
    twice = replay_as_it_is(recipe(one, one, room), limb())
    assert twice.ledger.places_mm["fibula head"] == pytest.approx(-6.0, abs=0.1)
    mirrored = replay_as_it_is(recipe(one, Mirror(confirmed_side="left"), one), limb())
    assert mirrored.ledger.places_mm["fibula head"] == pytest.approx(-3.0, abs=0.05)
    back = Relieve(at=beside(16.0), positions_in="mesh", depth_mm=3.0, falloff_mm=12.0)
    taken_back = replay_as_it_is(recipe(one, back), limb())
    assert taken_back.ledger.places_mm["fibula head"] > -0.25


def test_pads_on_one_place_are_one_depth() -> None:
    six = Pad(at="patellar tendon", depth_mm=6.0, width_mm=40.0, height_mm=40.0)
    replay(recipe(six), limb())
    with pytest.raises(EditError, match=r"Edit 2 .*1\d\.\d mm inside the scan.*depth to 1[1-3] mm"):
        replay(recipe(six, six), limb())
    room = Room(at="patellar tendon", depth_mm=6.0, width_mm=40.0, height_mm=40.0)
    with pytest.raises(EditError, match=r"Edit 2 .*1\d\.\d mm outside the scan"):
        replay(recipe(room, room), limb())


def test_what_sets_a_depth_at_a_place_says_whether_it_carves() -> None:
    """So that no edit presses on a bone without a word because nobody thought of it."""
    of = {"at": "fibula head", "depth_mm": 3.0, "width_mm": 20.0, "height_mm": 20.0}

    def made(effect: Effect) -> type[Oval]:
        class Groove(Oval):
            """Carve a groove."""

            def apply(self, limb: Limb) -> Limb:
                return move_oval(limb, self, -1.0)

        return edit(group="areas", order=99, effect=effect, example=of)(Groove)

    with pytest.raises(TypeError, match="at_place"):
        made(Effect(moves_skin=True))
    for way in ("carves", "builds"):  # what it does counts, whatever it says
        groove = made(Effect(moves_skin=True, at_place=way))(**of)
        with pytest.raises(EditError, match="fibula head"):
            replay(recipe(groove), limb())


def test_a_region_over_the_nerve_counts() -> None:
    turns = 2 * np.pi * np.arange(8) / 8
    ring = tuple(
        (*beside(float(18 * np.cos(turn)))[:2], float(18 * np.sin(turn))) for turn in turns
    )
    edit = Load(within=ring, positions_in="mesh", depth_mm=3.0, falloff_mm=8.0)
    with pytest.raises(EditError, match="on the fibula head"):
        replay(recipe(edit), limb())


def test_a_limb_without_landmarks_is_not_guessed_at() -> None:
    bare = replace(limb(), landmarks=())
    edit = Load(at=HEAD, positions_in="mesh", depth_mm=4.0, falloff_mm=15.0)
    assert replay(recipe(edit), bare).ledger.lines[0].concerns == ()


@pytest.mark.parametrize("kind", [Load, Relieve])
def test_a_depth_beyond_the_limit_needs_its_own_word(kind: type[Load] | type[Relieve]) -> None:
    assert USUAL_DEPTH_MM == 10.0
    at = "patellar tendon"
    added(recipe(), kind(at=at, depth_mm=10.0, falloff_mm=40.0))
    deep = kind(at=at, depth_mm=12.5, falloff_mm=40.0)
    with pytest.raises(OptionsError, match="depth to 13 mm"):
        added(recipe(), deep)
    with pytest.raises(OptionsError, match="depth to 13 mm"):
        added(recipe(), deep, accept=("depth to 12 mm", "load on fibula head"))
    (entry,) = added(recipe(), deep, accept=("Depth to 12.5mm",)).entries
    done = replay(Recipe(name="x", entries=(entry,)), limb())
    (concern,) = done.ledger.lines[0].concerns
    assert concern.accepted
    assert concern.finding.code == "recipe.deep"
    assert concern.finding.values["depth_mm"] == 12.5
    deeper = Entry(edit=replace(deep, depth_mm=40.0), accept=entry.accept)
    with pytest.raises(EditError, match="depth to 40 mm"):
        replay(Recipe(name="x", entries=(deeper,)), limb())


def test_two_loads_on_one_place_are_one_depth() -> None:
    six = replace(ON_TENDON, depth_mm=6.0, falloff_mm=30.0)
    replay(recipe(six), limb())
    with pytest.raises(EditError, match=r"Edit 2 .*12\.\d mm inside the scan.*depth to 1[23] mm"):
        replay(recipe(six, six), limb())
    replay(recipe(six, Relieve(at="patellar tendon", depth_mm=6, falloff_mm=30), six), limb())


def test_a_sock_taken_off_and_a_mirror_are_no_depth() -> None:
    nine = replace(ON_TENDON, depth_mm=9.8, falloff_mm=40.0)
    done = replay(recipe(Sock(thickness_mm=2.0), Mirror(confirmed_side="left"), nine), limb())
    assert [line.concerns for line in done.ledger.lines] == [(), (), ()]
    assert done.ledger.places_mm.get("fibula head", 0.0) == pytest.approx(0.0, abs=1e-6)


def test_what_presses_all_round_is_told_and_needs_no_word() -> None:
    tighter = Reduction(heights_mm=(0.0,), per_cent=(4.0,), of="girth")
    done = replay(recipe(tighter, Offset(distance_mm=-1.0)), limb())
    for line, depth in zip(done.ledger.lines, (2.0, 1.0), strict=True):
        (concern,) = line.concerns
        assert (concern.word, concern.accepted) == ("", True)
        assert concern.finding.code == "recipe.presses_on"
        assert f"fibula head {depth:.1f} mm" in told(concern.finding)
    assert done.ledger.places_mm["fibula head"] == pytest.approx(-3.0, abs=0.05)


def test_room_asks_for_nothing() -> None:
    done = replay(recipe(Relieve(at="fibula head", depth_mm=4, falloff_mm=18)), limb())
    assert done.ledger.lines[0].concerns == ()
    assert done.ledger.places_mm["fibula head"] == pytest.approx(4.0, abs=0.05)


def test_an_edit_that_is_off_asks_for_nothing() -> None:
    off = Recipe(name="x", entries=(Entry(edit=ON_HEAD, on=False), Entry(edit=ON_TENDON)))
    assert [line.number for line in replay(off, limb()).ledger.lines] == [2]


def test_words_stand_in_the_recipe_s_file() -> None:
    made = accepted(recipe(ON_HEAD), 1, ("load on the fibula head", "depth to 12.0 mm"))
    text = encode_recipe(made).decode()
    assert 'accept = ["load on fibula head", "depth to 12 mm"]' in text
    assert parse_recipe(text, "a.toml") == made
    for wrong in ("yes", "load on patellar tendon", "depth to many mm", "load on "):
        with pytest.raises(OptionsError, match="accepts nothing"):
            accepted(recipe(ON_HEAD), 1, (wrong,))
        with pytest.raises(OptionsError, match="accepts nothing"):
            parse_recipe(text.replace("load on fibula head", wrong), "a.toml")


def test_an_old_recipe_s_relief_on_the_nerve_is_not_done_in_silence() -> None:
    old = (
        'format = "limbgram recipe"\nversion = 1\n[[edit]]\ndo = "relief"\nat = "fibula head"\n'
        "depth_mm = 5\nfalloff_mm = 18\n"
    )
    with pytest.raises(EditError, match="load on fibula head"):
        replay(parse_recipe(old, "old.toml"), limb())


def test_the_command_refuses_takes_the_word_and_marks_it(tmp_path: Path) -> None:
    def edit(*words: str | Path, code: int = 0, language: str = "") -> str:
        spoken = {"LIMBGRAM_LANGUAGE": language}
        answer = CliRunner().invoke(app, ["edit", *map(str, words)], env=spoken)
        assert answer.exit_code == code, answer.output
        return answer.output

    scan, made, out = tmp_path / "scan.ply", tmp_path / "a.toml", tmp_path / "out.ply"
    write_limb(limb(), scan)
    edit("new", made)
    parameters = ["load", "at=fibula head", "depth_mm=5", "falloff_mm=18"]
    assert "--accept" in " ".join(edit("add", made, *parameters, code=2).split())
    assert "load at" not in made.read_text()
    edit("add", made, *parameters, "--accept", WORD)
    made.write_text(made.read_text().replace(f'accept = ["{WORD}"]\n', ""))
    edit("apply", scan, made, "-o", out, code=4)
    assert not out.exists()
    edit("accept", made, "1", WORD)
    answer = json.loads(edit("apply", scan, made, "-o", out, "--json"))
    (concern,) = answer["ledger"]["lines"][0]["concerns"]
    assert concern["word"] == WORD
    assert concern["accepted"] is True
    assert answer["ledger"]["places_mm"]["fibula head"] == pytest.approx(-5, abs=0.05)
    assert "presses 5.0 mm on" in edit("apply", scan, made, "-o", out)
    german = edit("apply", scan, made, "-o", tmp_path / "aus.ply", language="de")
    assert "! Sie drückt 5,0 mm auf: Wadenbeinköpfchen" in german


@pytest.mark.parametrize(("depth_mm", "needs"), [(10.0, ()), (10.1, ("depth to 11 mm",))])
def test_ten_millimetres_are_the_usual_depth(depth_mm: float, needs: tuple[str, ...]) -> None:
    load = Load(at="patellar tendon", depth_mm=depth_mm, falloff_mm=20.0)
    found = concerns_of(load, ())
    assert words_for(not_accepted(found)) == needs


def test_the_word_that_is_asked_for_is_taken_on_every_kind() -> None:
    for kind in KINDS:
        for place in SENSITIVE[kind]:
            load = replace(ON_HEAD, at=place.name)
            asked = words_for(concerns_of(load, (), kind))
            said = accepted(recipe(load), 1, asked).entries[0].accept
            assert not not_accepted(concerns_of(load, said, kind)), (kind, place.name)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("place", ["iliac spine", "iliac crest", "axilla", "trochanter"])
def test_the_word_that_is_asked_for_without_a_limb_is_taken_on_the_limb(
    side: str, place: str
) -> None:
    """`edit add` knows no limb; several kinds have a place of that name or beside it."""
    load = replace(ON_HEAD, at=f"{side} {place}")
    asked = words_for(concerns_of(load, ()))
    (entry,) = added(recipe(), load, accept=asked).entries
    assert not not_accepted(concerns_of(load, entry.accept, "torso")), asked


def test_a_word_for_one_side_of_a_trunk_is_none_for_the_other() -> None:
    load = replace(ON_HEAD, at="left iliac spine")
    (said,) = accepted(recipe(load), 1, ("load on right iliac spine",)).entries[0].accept
    assert words_for(not_accepted(concerns_of(load, (said,), "torso"))) == (
        "load on left iliac spine",
    )


def test_another_kind_s_name_of_a_place_is_understood() -> None:
    load = replace(ON_HEAD, at="iliac crest")
    (said,) = accepted(recipe(load), 1, ("load on right iliac spine",)).entries[0].accept
    for kind in ("torso", "transfemoral"):
        assert not not_accepted(concerns_of(load, (said,), kind))


def test_a_load_on_a_trunk_s_iliac_spine_is_done_with_its_word() -> None:
    head, _ = limb().landmarks
    spine = replace(head, name="right iliac spine")
    trunk = replace(limb(), landmarks=(spine,), kind="torso")
    load = replace(ON_HEAD, at="right iliac spine")
    meant = accepted(recipe(load), 1, ("load on right iliac spine",))
    assert replay(meant, trunk).ledger.lines[0].concerns[0].accepted


def test_a_joint_set_to_an_angle_after_a_load_hides_no_depth() -> None:
    """The skin from which depths count turns by as much as the limb does."""
    back = {"sacrum": -80.0, "third lumbar vertebra": -20.0, "twelfth thoracic vertebra": 20.0}
    places = {name: np.array([0.0, -60.0, z]) for name, z in back.items()}
    places |= {
        "seventh cervical vertebra": np.array([0.0, -20.0, 95.0]),
        "right iliac spine": np.array([50.0, 30.0, -70.0]),
        "left iliac spine": np.array([-50.0, 30.0, -70.0]),
        "gluteal fold": np.array([0.0, -25.0, 85.0]),
    }
    mesh = limb().mesh
    nearest = tree_on(mesh).closest(np.stack(list(places.values()))).points_mm
    trunk = replace(
        limb(),
        kind="torso",
        landmarks=tuple(
            Landmark(name=name, position_mm=at) for name, at in zip(places, nearest, strict=True)
        ),
    )
    load = Load(at="twelfth thoracic vertebra", depth_mm=8.0, falloff_mm=30.0)
    asked = SheetOptions(only=("lordosis_deg",))
    now_deg = measuring_sheet(trunk, asked)["lordosis_deg"].value
    turn = Repose(joint="extension", to_deg=now_deg + 2.0, band_mm=60.0, beyond=True)
    high = Relieve(at="gluteal fold", depth_mm=2.0, falloff_mm=10.0)
    done = replay_as_it_is(recipe(load, turn, high), trunk)
    assert done.ledger.lines[2].concerns == ()


@pytest.mark.parametrize("kind", [Load, Relieve])
def test_only_what_carves_is_said_to_press(kind: type[Load] | type[Relieve]) -> None:
    deep = kind(at="patellar tendon", depth_mm=12.0, falloff_mm=40.0)
    with pytest.raises(OptionsError) as not_added:
        added(recipe(), deep)
    with pytest.raises(EditError) as not_done:
        replay(recipe(deep), limb())
    for refused in (not_added, not_done):
        presses = "presses there; for room use relieve" in str(refused.value)
        assert presses == (kind is Load)
        assert ("has room there" in str(refused.value)) == (kind is Relieve)
