"""`limbgram export`: every format from one command, and no carver's file without a sure side."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.export import reply_of
from limbgram.cli.main import app
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.folds import find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.aop.cost import AopReport
from limbgram.formats.aop.writing import write_aop
from limbgram.formats.gcode.machine import read_machine
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import read_limb, read_shape
from limbgram.services import export as exporting
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

RUNNER = CliRunner()
COARSE = ("--scallop", "0.8", "--preset", "fast")
"""Of a carver's program, for tests that ask for its words and not for its ways."""


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A short limb that lies on its side in its own file."""
    thetas = np.arange(0, 360, 3.0)
    radii = np.tile(30 + 4 * np.cos(np.radians(thetas - 90)), (4, 1))
    body = RadiusMap(thetas_deg=thetas, z_mm=np.linspace(0, 60, 4), radii_mm=radii)
    lying = Rigid.from_rotation_vector(np.array([np.pi / 2, 0, 0]), np.array([5.0, 6, 7]))
    mesh = body.surface()
    mesh = mesh.with_vertices(lying.inverse.apply(mesh.vertices_mm))
    frame = LimbFrame(limb_from_mesh=lying, side="left")
    return write_limb(AlignedLimb(mesh=mesh, frame=frame), tmp_path / "scan.ply")


def exported(scan: Path, *words: str) -> dict[str, object]:
    answer = RUNNER.invoke(app, ["export", str(scan), *words, "--json"])
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout)


def refused(scan: Path, *words: str) -> str:
    answer = RUNNER.invoke(app, ["export", str(scan), *words, "--json"])
    assert answer.exit_code in (2, 4, 5)
    assert sorted(path.name for path in scan.parent.iterdir()) == ["scan.limb.json", "scan.ply"]
    return str(json.loads(answer.stdout)["error"]["message"])


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "glb"])
def test_meshes_stand_in_the_limb_frame(scan: Path, kind: str) -> None:
    content = exported(scan, "--to", kind)
    read = read_limb(Path(str(content["written"])))
    low, high = read.mesh.vertices_mm.min(0), read.mesh.vertices_mm.max(0)
    np.testing.assert_allclose((low[2], high[2]), (0, 60), atol=1e-3)
    assert high[0] == pytest.approx(34, abs=0.01)  # the patient's right
    assert read.frame.side == "left"


FRAME = LimbFrame(limb_from_mesh=Rigid.identity(), side="left")


def straight() -> Mesh:
    """A tube of 30 mm and 60 mm."""
    thetas = np.arange(0, 360, 6.0)
    return RadiusMap(
        thetas_deg=thetas,
        z_mm=np.linspace(0, 60, 21),
        radii_mm=np.full((21, len(thetas)), 30.0),
    ).surface()


def folded_in(folder: Path) -> Path:
    """The tube, of which one vertex lies over its neighbour, 3 mm away."""
    body = straight()
    wall = int(np.abs(body.vertices_mm - [30, 0, 30]).sum(1).argmin())
    vertices = body.vertices_mm.copy()
    vertices[wall, 2] += 7.0
    limb = AlignedLimb(mesh=body.with_vertices(vertices), frame=FRAME)
    return write_limb(limb, folder / "folded.ply")


@pytest.mark.parametrize("door", ["edit", "fit"])
@pytest.mark.parametrize("kind", ["stl", "obj", "3mf", "glb", "ply"])
def test_no_other_door_lets_a_fold_out_without_a_word(tmp_path: Path, door: str, kind: str) -> None:
    """For other programs it goes back; where work goes on with the file it is told."""
    folded, recipe, out = folded_in(tmp_path), tmp_path / "own.toml", tmp_path / f"out.{kind}"
    if door == "edit":
        assert RUNNER.invoke(app, ["edit", "new", str(recipe)]).exit_code == 0
        words = ["edit", "apply", str(folded), str(recipe), "-o", str(out)]
    else:
        words = ["measure", str(folded), "--height", "10", "--tape", "10=188", "--fit", str(out)]
    answer = RUNNER.invoke(app, [*words, "--json"])
    assert answer.exit_code == 0, answer.output
    told = json.loads(answer.stdout)
    codes = [one["code"] for one in (told if door == "edit" else told["fit"])["notes"]]
    left = find_folds(read_limb(out).mesh)
    if kind == "ply":
        assert ("export.folds_kept" in codes, len(left) > 0) == (True, True)
    else:
        assert ("export.folds_laid_back" in codes, len(left)) == (True, 0)


@pytest.mark.usefixtures("blank_mirror_checks")
@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "glb", "vtp", "dxf", "aop", "gcode"])
def test_a_folded_shape_leaves_unfolded_and_a_crossed_one_not_at_all(
    tmp_path: Path, kind: str
) -> None:
    body, folded = straight(), folded_in(tmp_path)
    coarse = COARSE if kind == "gcode" else ()
    content = exported(folded, "--to", kind, "--side", "left", *coarse)
    notes = content["notes"]
    assert isinstance(notes, list)
    assert "went back among their neighbours, by up to 7.0 mm" in str(notes[-1])
    if kind in ("stl", "ply", "obj", "glb"):
        read = read_limb(Path(str(content["written"]))).mesh
        assert not len(find_folds(read))
        np.testing.assert_allclose(
            np.sort(read.vertices_mm, axis=0), np.sort(body.vertices_mm, axis=0), atol=0.5
        )
    inner = body.with_vertices(body.vertices_mm * [0.5, 1.5, 0.5] + [0, 0, 15])
    crossed = Mesh(
        vertices_mm=np.concatenate([body.vertices_mm, inner.vertices_mm]),
        faces=np.concatenate([body.faces, inner.faces + np.int32(len(body))]),
    )
    (tmp_path / "other").mkdir()
    scan = write_limb(AlignedLimb(mesh=crossed, frame=FRAME), tmp_path / "other" / "scan.ply")
    assert "folds over or through itself" in refused(scan, "--to", kind, "--side", "left")


def test_the_natural_name_is_taken(scan: Path) -> None:
    """scan.ply to scan.stl: the limb file of the one is no reason to refuse the other."""
    before = scan.with_name("scan.limb.json").read_bytes()
    wanted = scan.with_name("scan.stl")
    exported(scan, "--to", "stl", "-o", str(wanted))
    read = read_limb(wanted)
    assert read.notes == ()
    assert read.frame.side == "left"
    np.testing.assert_allclose(np.ptp(read.mesh.vertices_mm[:, 2]), 60, atol=1e-3)
    assert scan.with_name("scan.limb.json").read_bytes() == before
    assert isinstance(read_limb(scan), AlignedLimb)


@pytest.mark.parametrize("height", ["0.0001", "0.5", "5.9"])
def test_less_than_the_tool_is_no_carving(scan: Path, height: str) -> None:
    """A sliver has no ring of rays, and its picture no pixel."""
    words = ("--to", "gcode", "--side", "left", "--tool", "12", "--to-mm", height)
    assert "not carved" in refused(scan, *words)


def test_aop_and_its_mirror_check(scan: Path) -> None:
    content = exported(scan, "--to", "aop", "--side", "left", "--spokes", "120", "--line-end", "cr")
    read = read_limb(Path(str(content["written"])))
    assert read.mesh.vertices_mm[:, 0].max() == pytest.approx(34, abs=0.01)
    assert content["written"] == str(scan.with_suffix(".aop"))
    assert content["unit"] == "mm"
    assert content["side"] == "left"
    assert b"\n" not in Path(str(content["written"])).read_bytes()
    picture = Path(str(content["mirror_check"]))
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.usefixtures("blank_mirror_checks")
def test_default_names_of_all_kinds_stand_side_by_side(scan: Path) -> None:
    """Limb files and mirror checks too: none takes another's place."""
    kinds = ("stl", "obj", "glb", "ply", "vtp", "dxf", "aop", "gcode")
    more = {"aop": ("--side", "left"), "gcode": ("--side", "left", *COARSE)}
    contents = [exported(scan, "--to", kind, *more.get(kind, ())) for kind in kinds]
    written = {str(content["written"]) for content in contents}
    pictures = {str(content["mirror_check"]) for content in contents[6:]}
    assert len(written) == len(kinds)
    assert {Path(picture).name for picture in pictures} == {
        "scan.aop-mirror-check.png",
        "scan.gcode-mirror-check.png",
    }
    for content in contents[:4]:
        assert isinstance(read_limb(Path(str(content["written"]))), AlignedLimb)


def test_gcode(scan: Path) -> None:
    content = exported(scan, "--to", "gcode", "--side", "left", "--tool", "16", "--scallop", "0.2")
    assert content["gouge_mm"] < 0.02  # type: ignore[operator]
    assert "( SIDE: LEFT )" in Path(str(content["written"])).read_text()
    assert Path(str(content["mirror_check"])).is_file()


@pytest.mark.usefixtures("blank_mirror_checks")
def test_of_a_wall_it_is_said_that_its_outside_is_carved(tmp_path: Path) -> None:
    """A positive carved of an outward wall is larger all round by the wall's thickness."""
    dome = trimesh.creation.icosphere(4, radius=40.0)
    cup = Mesh(vertices_mm=np.asarray(dome.vertices, np.float64), faces=dome.faces.astype(np.int32))
    cup = keep_positive(cup, 25.0 - cup.vertices_mm[:, 2]).mesh
    bare = AlignedLimb(mesh=cup, frame=FRAME)
    shapes = {
        "bare": bare,
        "outward": do_edit(bare, Wall(thickness_mm=4.0, side="outward")),
        "inward": do_edit(bare, Wall(thickness_mm=4.0, side="inward")),
    }
    for name, limb in shapes.items():
        read = read_shape(write_limb(limb, tmp_path / f"{name}.ply"))
        ask = exporting.Gcode(scallop_mm=0.8, preset="fast")
        done = exporting.export(read, ask, tmp_path / f"{name}.nc", side="left")
        said = {one.code: one.values for one in done.said}
        assert ("exported.gcode.outside_of_wall" in said) == (name != "bare")
        assert 0.5 < done.figures["left_mm"] <= (done.surface_within_mm or 0)  # ridges of 0.8 mm
        if name != "bare":
            told = said["exported.gcode.outside_of_wall"]
            assert told["wall_mm"] == pytest.approx(4.0, abs=0.05)


@pytest.mark.usefixtures("blank_mirror_checks")
def test_a_spindle_of_0_is_left_to_the_operator(scan: Path) -> None:
    words = ("--to", "gcode", "--side", "left", *COARSE, "--spindle", "0")
    place = scan.with_name("still.nc")
    exported(scan, *words, "-o", str(place))
    program = place.read_bytes()
    assert b"G1" in program
    assert b" M3\n" not in program


@pytest.mark.usefixtures("blank_mirror_checks")
def test_a_machine_file_is_kept_and_taken(scan: Path) -> None:
    """What is typed goes over the preset, and that over the machine file."""
    kept = scan.with_name("shop.toml")
    carve = ("--to", "gcode", "--side", "left", "--scallop", "0.3", "--dialect", "grbl")
    rates = ("--plunge", "444", "--spindle", "7000", "--rough-depth", "30", "--turn-rate", "5000")
    content = exported(
        scan,
        *carve,
        *rates,
        "--preset",
        "fast",
        "--write-machine",
        str(kept),
        "-o",
        str(scan.with_name("one.nc")),
    )
    assert content["dialect"] == "grbl"
    assert content["machine"] == str(kept)
    machine = read_machine(kept)
    assert machine.carving.scallop_mm == 0.3
    assert machine.carving.tool_diameter_mm == 19
    assert machine.carving.spindle_rpm == 7000
    again = exported(
        scan,
        "--to",
        "gcode",
        "--side",
        "left",
        "--machine",
        str(kept),
        "-o",
        str(scan.with_name("two.nc")),
    )
    one, two = (scan.with_name(f"{name}.nc").read_bytes() for name in ("one", "two"))
    assert one == two
    assert again["rotary_deg"] == content["rotary_deg"]
    assert b"F444.0" in one


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--dialect", "grbl", "--winding", "rollover"), "turn back a whole turn"),
        (("--write-machine", "x.json"), "end in .toml"),
        (("--machine", "none.toml"), "cannot be read"),
        (("--mandrel", "66"), "stand out of the shape"),
        (("--winding", "continuous", "--a-limit", "720"), "would wind up"),
    ],
)
def test_a_machine_that_cannot_be_is_refused(scan: Path, words: tuple[str, ...], says: str) -> None:
    coarse = ("--scallop", "0.4", "--tool", "16")
    assert says in refused(scan, "--to", "gcode", "--side", "left", *coarse, *words)
    assert "--machine: for gcode only" in refused(scan, "--to", "stl", "--machine", "x.toml")


def test_a_machine_file_takes_no_other_files_place(scan: Path, tmp_path: Path) -> None:
    """Recipes end in .toml too."""
    recipe = tmp_path / "first.toml"
    recipe.write_text("format = 'a recipe'\n")
    carve = ["export", str(scan), "--to", "gcode", "--side", "left"]
    for words, says in (
        (["--write-machine", str(recipe)], "is no machine file"),
        (
            ["--write-machine", str(tmp_path / "a.toml"), "-o", str(tmp_path / "a.toml")],
            "named for",
        ),
        (["--machine", str(recipe), "-o", str(recipe)], "no machine file"),
    ):
        answer = RUNNER.invoke(app, [*carve, *words, "--json"])
        assert answer.exit_code == 2
        assert says in json.loads(answer.stdout)["error"]["message"]
    assert recipe.read_text() == "format = 'a recipe'\n"
    assert sorted(tmp_path.glob("*.gcode*")) == []


def test_dxf_in_three_forms(scan: Path) -> None:
    for form in ((), ("--r12",)):
        written = ("-o", str(scan.with_name(f"form{len(form)}.dxf")))
        content = exported(scan, "--to", "dxf", "--spacing", "25", *form, *written)
        assert content["sections"] in (2, 3)
    again = str(scan.with_suffix(".dxf"))
    content = exported(scan, "--to", "dxf", "--polyface", "--spacing", "25", "-o", again)
    # At 25 and 50 mm, and at 0 if rounding leaves the end a little lower.
    assert content["sections"] in (2, 3)
    assert content["meshes"] == 1


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("open", "Layer TRIMLINE_MM: open edges, round 200 mm"),
        ("closed", "No layer TRIMLINE_MM: the surface has no open edge."),
        ("doubled", "No layer TRIMLINE_MM: its faces do not join to one surface."),
    ],
)
def test_a_dxf_says_what_its_trimline_is(tmp_path: Path, change: str, told: str) -> None:
    box = trimesh.creation.box((50.0, 50.0, 100.0))
    faces = box.faces.astype(np.int32)
    if change == "open":
        faces = faces[box.face_normals[:, 2] < 0.5]
    if change == "doubled":
        faces = np.concatenate([faces, faces[:1]])
    limb = Limb(mesh=Mesh(vertices_mm=np.asarray(box.vertices), faces=faces))
    asked = exporting.Drawing(spacing_mm=25.0)
    reply = reply_of(exporting._drawing(limb, tmp_path / "box.dxf", asked))
    assert told in reply.lines
    assert f"({reply.content['sections']} sections" in reply.lines[0].replace("mm; ", "")


@pytest.mark.usefixtures("blank_mirror_checks")
def test_no_girth_change_where_no_section_was_compared(
    scan: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without_sections(*given: Any) -> AopReport:
        return replace(write_aop(*given), girths=(), bodies_left_out=1)

    monkeypatch.setattr(exporting, "write_aop", without_sections)
    asked = exporting.Aop()
    written = exporting.export(read_shape(scan), asked, scan.with_suffix(".aop"), "left")
    reply = reply_of(written)
    assert reply.content["girth_change_mm"] is None
    assert reply.content["girth_change"] is None
    assert "1 body inside the limb was left out." in reply.lines


@pytest.mark.parametrize("kind", ["aop", "gcode"])
def test_no_carver_without_a_sure_side(scan: Path, kind: str) -> None:
    assert "confirmed" in refused(scan, "--to", kind)
    assert "not sure" in refused(scan, "--to", kind, "--side", "right")


@pytest.mark.usefixtures("blank_mirror_checks")
@pytest.mark.parametrize("kind", ["aop", "gcode", "dxf", "stl", "ply", "obj", "glb", "vtp"])
def test_no_file_with_a_side_that_a_landmark_contradicts(scan: Path, kind: str) -> None:
    """A limb file that was written by hand: a left limb must not leave as a right one."""
    beside = scan.with_name("scan.limb.json")
    tree = json.loads(beside.read_bytes())
    lying = Rigid.from_rotation_vector(np.array([np.pi / 2, 0, 0]), np.array([5.0, 6, 7]))
    place = lying.inverse.apply(np.array([[-30.0, 0, 30]]))[0]
    tree["landmarks"] = [{"name": "fibula head", "position_mm": place.tolist()}]
    for side in ("right", "left"):
        beside.write_text(json.dumps({**tree, "side": side}))
        words = ("--to", kind, *(("--side", side) if kind in ("aop", "gcode") else ()))
        words += COARSE if kind == "gcode" else ()
        if side == "right":
            assert "180 degrees from where" in refused(scan, *words)
        else:
            assert exported(scan, *words)["written"]


def test_an_option_of_another_format_is_refused(scan: Path) -> None:
    assert "--tool: for gcode only" in refused(scan, "--to", "stl", "--tool", "3")
    assert "--line-end: for aop only" in refused(scan, "--to", "dxf", "--line-end", "cr")
    assert "--spacing: for dxf or aop only" in refused(scan, "--to", "ply", "--spacing", "3")


def test_heights_are_refused_along_a_fitted_axis(scan: Path) -> None:
    words = ("--to", "aop", "--side", "left", "--axis", "fit", "--from-mm", "10")
    assert "Leave out --from-mm and --to-mm" in refused(scan, *words)


def test_the_shape_itself_is_kept(scan: Path) -> None:
    assert "take the place of the shape" in refused(scan, "--to", "ply", "--out", str(scan))
    assert "does not end in" in refused(scan, "--to", "stl", "--out", str(scan.with_name("a.ply")))


@pytest.mark.usefixtures("blank_mirror_checks")
@pytest.mark.parametrize(
    ("kind", "name"), [("dxf", "scan.dxf"), ("aop", "scan.aop"), ("stl", "scan-export-stl.stl")]
)
def test_a_file_that_nobody_named_is_not_written_over(scan: Path, kind: str, name: str) -> None:
    """It may be the scanner's own AOP, or the drawing that a case came with."""
    there = scan.with_name(name)
    there.write_bytes(b"an original")
    words = ["export", str(scan), "--to", kind, *(["--side", "left"] if kind == "aop" else [])]
    answer = RUNNER.invoke(app, [*words, "--json"])
    assert answer.exit_code == 2
    message = json.loads(answer.stdout)["error"]["message"]
    assert name in message
    assert "-o" in message
    assert there.read_bytes() == b"an original"
    assert exported(scan, *words[2:], "-o", str(there))["written"] == str(there)
    assert there.read_bytes() != b"an original"


@pytest.mark.parametrize(("named", "taken_mm"), [("tool_diameter_mm = 16", 16.0), ("", 19.0)])
def test_the_fast_preset_takes_its_tool_where_the_machine_file_names_none(
    tmp_path: Path, named: str, taken_mm: float
) -> None:
    file = tmp_path / "shop.toml"
    file.write_text(f'format = "limbgram machine"\nversion = 1\n[carving]\n{named}\n')
    ask = exporting.Gcode(machine=file, preset="fast")
    assert ask.set_up().carving.tool_diameter_mm == taken_mm
    typed = exporting.Gcode(machine=file, preset="fast", tool_diameter_mm=8.0)
    assert typed.set_up().carving.tool_diameter_mm == 8.0
