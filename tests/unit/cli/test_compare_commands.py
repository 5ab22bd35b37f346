"""`limbgram compare` and `limbgram template`: from files to files, and refusals that write none."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame

RUNNER = CliRunner()
AS_IS = ("--align", "as-is")


def beaker(growth: float = 1.0, dent_mm: float = 0.0) -> Limb:
    """A half ball of 50 mm under a wall of 150 mm, made wider, with a dent in front at 120 mm."""
    bend = np.linspace(0, np.pi / 2, 16)[1:]
    radii = np.concatenate([50 * np.sin(bend), np.full(37, 50.0)])
    heights = np.concatenate([50 * (1 - np.cos(bend)), 50 + 4.0 * np.arange(1, 38)])
    turns = 2 * np.pi * np.arange(80) / 80
    wall = np.concatenate(
        [
            np.column_stack([growth * r * np.cos(turns), growth * r * np.sin(turns), 0 * turns + z])
            for r, z in zip(radii, heights)
        ]
    )
    i, j = (k.ravel() for k in np.meshgrid(np.arange(51), np.arange(80), indexing="ij"))
    here, beside = i * 80 + j, i * 80 + (j + 1) % 80
    k = np.arange(80)
    faces = np.concatenate(
        [
            np.column_stack([here, beside, beside + 80]),
            np.column_stack([here, beside + 80, here + 80]),
            np.column_stack([(k + 1) % 80, k, np.full(80, 52 * 80)]),
        ]
    )
    vertices = np.concatenate([wall, [[0.0, 0, 0]]])
    square = ((vertices - [0, 50, 120]) ** 2).sum(1)
    vertices[:, 1] -= dent_mm * np.exp(-square / (2 * 12**2))
    places = {"patellar tendon": [0, 50.0, 120], "fibula head": [50.0, 0, 110], "end": [0, 50, 60]}
    marks = tuple(
        Landmark(name=name, position_mm=np.array(at, float)) for name, at in places.items()
    )
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    mesh = Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, landmarks=marks, frame=frame)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of three shapes, as it is copied for each test."""
    folder = tmp_path_factory.mktemp("shapes")
    for name, limb in (
        ("first", beaker()),
        ("wide", beaker(1.01)),
        ("dented", beaker(dent_mm=5.0)),
    ):
        write_limb(limb, folder / f"{name}.ply")
    return folder


@pytest.fixture
def shapes(written: Path, tmp_path: Path) -> dict[str, str]:
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    return {name: str(tmp_path / f"{name}.ply") for name in ("first", "wide", "dented")}


def answered(*words: str) -> dict[str, Any]:
    answer = RUNNER.invoke(app, [*words, "--json"])
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout)


def refused(folder: Path, *words: str) -> str:
    before = sorted(folder.iterdir())
    answer = RUNNER.invoke(app, [*words, "--json"])
    assert answer.exit_code in (2, 3, 4), answer.output
    assert sorted(folder.iterdir()) == before
    return str(json.loads(answer.stdout)["error"]["message"])


def test_two_shapes(shapes, tmp_path: Path) -> None:
    picture = tmp_path / "difference.png"
    words = ("compare", shapes["first"], shapes["wide"], *AS_IS, "--picture", str(picture))
    found = answered(*words)
    assert found["format"] == "limbgram-comparison/2"
    assert found["grade"] == "size and shape differ" or found["grade"] == "size differs"
    assert found["radial"]["mean_radial_error_mm"] == pytest.approx(0.5, abs=0.05)
    assert found["volume"]["ml"]["share"] == pytest.approx(0.0201, abs=1e-4)
    assert found["volume"]["sock_plies"] == pytest.approx(0.0201 / 0.011, abs=0.01)
    tape = found["levels"][3]["tape_mm"]
    assert tape["difference"] == pytest.approx(0.01 * tape["first"], rel=1e-4)
    assert found["alignment"]["way"] == "as-is"
    assert picture.read_bytes().startswith(b"\x89PNG")
    spoken = RUNNER.invoke(app, ["compare", shapes["first"], shapes["wide"], *AS_IS])
    assert spoken.stdout.splitlines()[0] == found["verdict"]["sentence"]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (AS_IS, "Die Formen sind "),
        (("--day", "2026-03-02", "--day", "2026-03-16"), "Ein Verlauf ist nicht zu erkennen: "),
        (("--repeats",), "2 Aufnahmen: Zwei Volumen "),
    ],
)
def test_what_was_found_is_told_in_the_language_of_the_terminal(
    shapes, more: tuple[str, ...], said: str
) -> None:
    words = ["compare", shapes["first"], shapes["wide"], *more]
    answer = RUNNER.invoke(app, words, env={"LIMBGRAM_LANGUAGE": "de"})
    assert said in answer.stdout.splitlines()[0], answer.output


def test_a_red_surface_among_them_is_named_first(shapes, tmp_path: Path) -> None:
    red = write_limb(beaker(1.01), tmp_path / "surface-RED.ply")
    words = ("compare", shapes["first"], str(red), *AS_IS)
    assert "verdict is RED" in RUNNER.invoke(app, list(words)).stdout.splitlines()[0]
    (said,) = answered(*words)["doubts"]
    assert (said["code"], said["values"]["name"]) == ("compare.red_shape", "surface-RED.ply")
    assert said["values"]["doubt"]["code"] == "verdict.red_shape"
    assert answered("compare", shapes["first"], shapes["wide"], *AS_IS)["doubts"] == []


def test_a_shape_made_from_the_other_is_taken_as_it_lies(shapes) -> None:
    """1.0201 times the volume; laid by shape the wider dome rises on the other one."""
    words = ("compare", shapes["first"], shapes["wide"])
    found, by_shape = answered(*words), answered(*words, "--align", "icp")
    assert found["alignment"]["way"] == "as-is"
    assert "one was made from the other" in found["verdict"]["sentence"]
    assert found["volume"]["ml"]["share"] == pytest.approx(0.0201, abs=1e-4)
    assert by_shape["alignment"]["way"] == "icp"
    assert by_shape["alignment"]["slid_from_frames_mm"] > 0.1
    spoken = RUNNER.invoke(app, list(words)).stdout
    assert "ML change  AP change  mL since last" in spoken
    slabs = [level["volume_since_last_level_ml"]["second"] for level in found["levels"]]
    assert sum(slabs) == pytest.approx(found["volume"]["ml"]["second"])
    assert all("volume_below_ml" not in level for level in found["levels"])


def test_what_was_exported_lies_as_it_was_made(tmp_path: Path) -> None:
    """From a scan that lies on its side: edited, then exported in the limb's axes, each anew."""
    lying = Rigid.from_rotation_vector(np.array([1.2, 0.4, 0]), np.array([30.0, -20, 10]))
    limb = beaker()
    mesh = limb.mesh.with_vertices(lying.inverse.apply(limb.mesh.vertices_mm))
    framed = LimbFrame(limb_from_mesh=lying, side="right")
    scan = str(write_limb(AlignedLimb(mesh=mesh, frame=framed), tmp_path / "scan.ply"))
    recipe, edited = str(tmp_path / "a.toml"), str(tmp_path / "edited.ply")
    answered("edit", "new", recipe)
    answered("edit", "add", recipe, "reduction", "heights_mm=[0]", "per_cent=[3]", "of=girth")
    answered("edit", "apply", scan, recipe, "-o", edited)
    sent = answered("export", edited, "--to", "stl")["written"]
    plain = answered("export", scan, "--to", "obj")["written"]
    for first, second in ((scan, sent), (plain, sent), (plain, edited)):
        found = answered("compare", first, second)
        assert "name one file that both come from" in found["verdict"]["sentence"]
        assert found["volume"]["ml"]["share"] == pytest.approx(0.97**2 - 1, abs=1e-4)
        for level in found["levels"]:
            assert level["tape_mm"]["share"] == pytest.approx(-0.03, abs=1e-4)


def test_one_limb_over_time(shapes, tmp_path: Path) -> None:
    days = ("--day", "2026-02-01", "--day", "2026-01-04", "--repeatability", "0.1")
    picture = tmp_path / "course.png"
    words = (shapes["first"], shapes["wide"], *AS_IS, *days, "--picture", str(picture))
    found = answered("compare", *words)
    assert [visit["name"] for visit in found["visits"]] == ["wide.ply", "first.ply"]
    assert found["volume_per_week_share"] == pytest.approx(-0.0197 / 4, rel=0.01)
    assert found["volume_trend_ml"]["told"]
    assert "shrinks" in found["verdict"]["sentence"]
    assert picture.exists()


def test_repeated_captures(shapes) -> None:
    found = answered("compare", shapes["first"], shapes["wide"], *AS_IS, "--repeats")
    first, second = (capture["volume_ml"] for capture in found["captures"])
    within = abs(first - second) / np.sqrt(2)
    assert found["volume"]["within_sd_ml"] == pytest.approx(within)
    student = 12.706205  # two captures leave one degree of freedom
    assert found["volume"]["coefficient_ml"] == pytest.approx(student * np.sqrt(2) * within)
    assert found["bland_altman_mm"]["bias"] == pytest.approx(np.pi, rel=0.1)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("first",), "cannot be compared"),
        (("first", "wide", "dented"), "say what they are"),
        (("first", "wide", "--day", "2026-01-01"), "1 days are given for 2"),
        (("first", "wide", "--day", "yesterday", "--day", "2026-01-01"), "no day"),
        (("first", "wide", "--repeats", "--picture", "x.png"), "no picture"),
        (("first", "wide", "--picture", "x.jpg"), "end in .png"),
        (("first", "wide", "--weight", "end=1"), "read with --align landmarks only"),
        (("first", "wide", "--align", "landmarks", "--weight", "end"), "no weight"),
        (("first", "wide", "--brim", "-1"), "cannot be"),
    ],
)
def test_questions_that_cannot_be_answered_are_refused(shapes, tmp_path, words, message) -> None:
    told = [shapes.get(word, word) for word in words]
    assert message in refused(tmp_path, "compare", *told)


def test_a_template_is_learned_shown_and_applied(shapes, tmp_path: Path) -> None:
    kept, made = tmp_path / "dent.json", tmp_path / "made.ply"
    pair = (shapes["first"], shapes["dented"])
    learned = answered("template", "learn", *pair, "-o", str(kept), *AS_IS)
    assert learned["most_inward_mm"] == pytest.approx(-5, abs=0.2)
    assert learned["reference"] == "patellar tendon"
    assert "limb frame on limb frame" in learned.pop("notes")[0]["sentence"]
    shown = answered("template", "show", str(kept), "--picture", str(tmp_path / "t.png"))
    assert shown == {**learned, "written": [str(tmp_path / "t.png")]}
    half = ("--strength", "0.5")
    applied = answered("template", "apply", shapes["wide"], str(kept), "-o", str(made), *half)
    assert applied["most_inward_mm"] == pytest.approx(-2.5, abs=0.15)
    assert applied["volume_change_ml"] < 0
    beside = json.loads(made.with_name("made.limb.json").read_text())
    assert beside["side"] == "right"
    found = answered("compare", shapes["wide"], str(made), *AS_IS)
    assert found["surface"]["on_first"]["largest_mm"] == pytest.approx(2.5, abs=0.15)


def test_a_template_learns_what_was_taken_off_where_the_shape_lies(shapes, tmp_path: Path) -> None:
    learned = answered(
        "template", "learn", shapes["first"], shapes["wide"], "-o", f"{tmp_path}/w.json"
    )
    assert "taken as they lie" in learned["notes"][0]["sentence"]
    assert learned["most_outward_mm"] == pytest.approx(0.5, abs=0.05)
    assert len(learned["notes"]) == 1


def test_templates_that_cannot_be_are_refused(shapes, tmp_path: Path) -> None:
    out = ("-o", str(tmp_path / "t.json"))
    assert "no pairs" in refused(tmp_path, "template", "learn", shapes["first"], *out)
    pair = (shapes["first"], shapes["dented"])
    wrong = ("-o", str(tmp_path / "t.txt"))
    assert ".json" in refused(tmp_path, "template", "learn", *pair, *wrong, *AS_IS)
    assert "cannot be read" in refused(tmp_path, "template", "show", str(tmp_path / "none.json"))
    answered("template", "learn", *pair, *out, *AS_IS)
    same = ("template", "apply", shapes["wide"], str(tmp_path / "t.json"), "-o", shapes["wide"])
    assert "take the place of the shape" in refused(tmp_path, *same)
    bare = replace(beaker(), landmarks=())
    unmarked = str(write_limb(bare, tmp_path / "unmarked.ply"))
    words = ("template", "apply", unmarked, str(tmp_path / "t.json"), "-o", str(tmp_path / "o.ply"))
    assert "patellar tendon" in refused(tmp_path, *words)
