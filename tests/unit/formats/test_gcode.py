"""The program as a controller reads it: units, header, safe moves, and what it carves."""

import itertools
import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from limbgram.core.errors import CarveError, ExportError, MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, told
from limbgram.formats.gcode import writing as program
from limbgram.formats.gcode.control import Control
from limbgram.formats.gcode.machine import Machine, read_machine, write_machine
from limbgram.formats.gcode.rules import require_taken
from limbgram.formats.gcode.writing import GcodeReport, write_gcode
from limbgram.formats.reading import read_limb
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

OPTIONS = CarveOptions(scallop_mm=0.2, tool_diameter_mm=16.0, rough_depth_mm=25, feed_mm_min=1000.0)
COARSE = replace(OPTIONS, scallop_mm=0.8, tolerance_mm=0.04)
"""Half as many turns, of longer moves."""


@pytest.fixture(scope="module")
def limb() -> Limb:
    """A short cylinder with a bump at the patient's right."""
    thetas = np.arange(0, 360, 2.0)
    radii = 30 + 4 * np.exp(-(((thetas - 90) / 25) ** 2))
    body = RadiusMap(
        thetas_deg=thetas, z_mm=np.array([0.0, 15, 30]), radii_mm=np.tile(radii, (3, 1))
    )
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    return AlignedLimb(mesh=body.surface(), frame=frame)


@pytest.fixture(scope="module")
def carved(tmp_path_factory: pytest.TempPathFactory, limb: Limb) -> GcodeReport:
    return write_gcode(limb, tmp_path_factory.mktemp("carved") / "limb.gcode", OPTIONS)


@pytest.mark.parametrize("a_turns", ["tool", "work"])
def test_the_program_carves_the_limb(
    tmp_path: Path, limb: Limb, carved: GcodeReport, a_turns: str
) -> None:
    report = carved
    if a_turns == "work":
        report = write_gcode(limb, tmp_path / "limb.gcode", replace(OPTIONS, a_turns=a_turns))
    assert report.check.gouge_mm < 0.02
    assert report.check.rapid_hits == 0
    text = report.path.read_text("ascii")
    for line in ("( UNIT: MM, DEGREES )", "( SIDE: RIGHT )", report.shape_sha256):
        assert line in text
    assert text.endswith("M5\nM30\n")
    # Where the tool stays farthest out is the bump: at the patient's right, A = -90 for a tool
    # that turns counter-clockwise.
    words = re.findall(r"^G1 X(\S+) A(\S+) Z(\S+) F", text.split("( finishing )")[1], re.M)
    moves = np.array(words, float)
    wall = moves[(moves[:, 0] > 10) & (moves[:, 0] < 25)]
    farthest = wall[wall[:, 2].argmax(), 1] % 360
    assert farthest == pytest.approx(270 if a_turns == "tool" else 90, abs=2)
    assert wall[:, 2].max() == pytest.approx(34, abs=0.03)
    assert wall[:, 2].min() == pytest.approx(30, abs=0.03)


@pytest.mark.parametrize("a_turns", ["tool", "work"])
def test_what_stays_above_the_last_row_is_told_with_its_place(
    tmp_path: Path, limb: Limb, carved: GcodeReport, a_turns: str
) -> None:
    """A brim that is 1.8 mm higher at the patient's right than at the left."""
    vertices = limb.mesh.vertices_mm.copy()
    brim = vertices[:, 2] > 29
    thetas = np.arctan2(vertices[brim, 0], vertices[brim, 1])
    vertices[brim, 2] = 30 + 0.9 * (1 + np.sin(thetas))
    slanted = replace(limb, mesh=limb.mesh.with_vertices(vertices))
    report = write_gcode(slanted, tmp_path / "limb.nc", replace(COARSE, a_turns=a_turns))
    over = report.above
    assert over.last_mm == pytest.approx(30.0, abs=0.03)
    assert over.rise_mm == pytest.approx(1.8, abs=0.03)
    assert over.side == "right"
    whole_mm2 = np.linalg.norm(slanted.mesh.face_normals(), axis=1).sum() / 2
    # the mean of 0.9 mm all round, and of the bump's 4 mm more radius most at its highest
    assert 0.9 * 2 * np.pi * 30 < over.share * whole_mm2 < 0.9 * 2 * np.pi * 32
    assert report.standing.code == "carver.stays_in_blank"
    assert report.standing.values["rise_mm"] == over.rise_mm
    assert "reaches up to 1.8 mm higher, farthest at the right: " in told(report.standing)
    at = -90 if a_turns == "tool" else 90
    line = f"LAST ROW: X 30.0, the shape reaches 1.8 mm beyond it, farthest at A {at}, which"
    assert line in report.path.read_text("ascii")
    assert carved.above.rise_mm < 0.03
    assert told(carved.standing) == "Carved up to the limb's end, at 30.0 mm."


def test_a_bone_inside_the_limb_is_told_and_changes_nothing(tmp_path: Path, limb: Limb) -> None:
    skin = limb.mesh
    middle = np.array([0.0, 0.0, 15.0])
    bone_mm = (skin.vertices_mm - middle) * 0.5 + middle
    both = Mesh(
        vertices_mm=np.concatenate([skin.vertices_mm, bone_mm]),
        faces=np.concatenate([skin.faces, skin.faces + len(skin)]),
    )
    with_bone = write_gcode(replace(limb, mesh=both), tmp_path / "bone.gcode", COARSE)
    alone = write_gcode(limb, tmp_path / "alone.gcode", COARSE)
    assert (with_bone.bodies_left_out, alone.bodies_left_out) == (1, 0)
    programs = [report.path.read_text("ascii").splitlines() for report in (with_bone, alone)]
    assert with_bone.lines == alone.lines
    different = [one for one, two in zip(*programs, strict=True) if one != two]
    assert [line[:15] for line in different] == ["( SHAPE SHA256:"]


def test_it_does_not_turn_back_between_passes(carved: GcodeReport) -> None:
    text = carved.path.read_text()
    angles = np.array(re.findall(r" A(-?\d\S*)", text.split("M3")[1]), float)
    assert np.abs(np.diff(angles)).max() < 180


def test_feed_holds_over_the_surface(carved: GcodeReport) -> None:
    strip = carved.toolpath.strips[-1]
    radius = strip.centre_mm
    way = np.hypot(
        np.hypot(np.diff(strip.x_mm), np.diff(radius)),
        np.radians(np.diff(strip.a_deg)) * (radius[1:] + radius[:-1]) / 2,
    )
    text = carved.path.read_text().split("( finishing )")[1]
    inverse = np.array(re.findall(r"^G1 X.* F(\S+)$", text, re.M), float)
    outer = radius[1:] > 30
    np.testing.assert_allclose((way * inverse)[outer], 1000, rtol=1e-3)
    turning = np.diff(strip.a_deg) * inverse
    assert turning.max() < OPTIONS.turn_deg_min * 1.001


def test_a_program_that_gouges_is_not_kept(
    tmp_path: Path, limb: Limb, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = program.plan_toolpath

    def too_deep(*args: object) -> object:
        path = plan(*args)  # type: ignore[arg-type]
        strips = tuple(replace(one, centre_mm=one.centre_mm - 0.2) for one in path.strips)
        return replace(path, strips=strips)

    monkeypatch.setattr(program, "plan_toolpath", too_deep)
    with pytest.raises(CarveError, match=r"cuts 0\.\d+ mm into the shape"):
        write_gcode(limb, tmp_path / "limb.gcode", COARSE)
    assert not (tmp_path / "limb.gcode").exists()


def test_foreign_words_are_not_passed_over() -> None:
    for line in ("G2 X1", "G1 Y3", "G20"):
        with pytest.raises(ExportError, match="the word"):
            program.read_moves(f"G21 G90 G94\nG0 Z50\n{line}\n", OPTIONS, Control())


def test_only_an_aligned_limb(tmp_path: Path, limb: Limb) -> None:
    with pytest.raises(MeasureError, match="align"):
        write_gcode(limb.unaligned(), tmp_path / "limb.gcode", OPTIONS)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stl_file.stl", "stl_file_2.stl"])
def test_real_limbs_are_not_cut_into(tmp_path: Path, data_folder: Path, name: str) -> None:
    limb = read_limb(data_folder / "shapes" / "ampscan" / name)
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="none")
    report = write_gcode(replace(limb, frame=frame), tmp_path / "limb.gcode", CarveOptions())
    assert report.check.gouge_mm < 0.05
    assert 0.03 < report.check.scallop_mm < 0.07
    assert report.check.left_share < 0.01


def lines_of(tmp_path: Path, limb: Limb, control: Control, **more: object) -> list[str]:
    """A coarse program, as a control is given it."""
    options = replace(COARSE, **more)  # type: ignore[arg-type]
    return write_gcode(limb, tmp_path / "limb.nc", options, control).path.read_text().splitlines()


def test_the_words_of_each_dialect(tmp_path: Path, limb: Limb) -> None:
    start = "G21 G17 G40 G49 G54 G80 G90 G94"
    linuxcnc = lines_of(tmp_path, limb, Control(tool_number=3, coolant="flood"))
    at = linuxcnc.index(start)
    assert linuxcnc[at + 1 : at + 4] == ["G64 P0.040", "T3 M6", "G43 H3"]
    assert linuxcnc[at + 5 : at + 8] == ["S12000 M3", "G4 P3.0", "M8"]
    assert linuxcnc[-3:] == ["M9", "M5", "M30"]
    assert {line for line in linuxcnc if line.startswith("G9")} == {"G93", "G94"}
    fanuc = lines_of(tmp_path, limb, Control(dialect="fanuc", program_number=17))
    assert (fanuc[:2], fanuc[-2:]) == (["%", "O0017"], ["M30", "%"])
    assert "G4 P3000" in fanuc
    assert "(SIDE = RIGHT)" in fanuc
    grbl = lines_of(tmp_path, limb, Control(dialect="grbl"))
    assert start in grbl
    assert not any(line.startswith(("G93", "G43", "G64", "T")) for line in grbl)
    assert any(re.fullmatch(r"G1 X\S+ Y\S+ Z\S+ F\S+", line) for line in grbl)
    quiet = lines_of(tmp_path, limb, Control(spindle_start_s=0), spindle_rpm=0)
    assert not any(line.startswith(("M3", "G4 ", "M5")) and line != "M30" for line in quiet)


def test_stock_grbl_takes_the_whole_program_and_no_a_word(tmp_path: Path, limb: Limb) -> None:
    four_axes = Control(dialect="grbl", rotary_word="A")
    with_a = "\n".join(lines_of(tmp_path, limb, four_axes))
    require_taken(with_a, four_axes)
    with pytest.raises(CarveError) as refused:
        require_taken(with_a, Control(dialect="grbl"))
    assert why_of(refused.value).code == "carver.line.unknown"
    before = with_a.splitlines()[: int(str(refused.value.finding.values["line"])) - 1]
    assert "S12000 M3" in before  # the spindle would have been running
    path = tmp_path / "mist.nc"
    with pytest.raises(CarveError) as refused:
        write_gcode(limb, path, COARSE, Control(dialect="grbl", coolant="mist"))
    assert why_of(refused.value).values["word"] == "M7"
    assert not path.exists()


def why_of(error: CarveError) -> Finding:
    assert error.finding.code == "carver.refused"
    why = error.finding.values["why"]
    assert isinstance(why, Finding)
    return why


LINUXCNC, GRBL, MACH, FANUC = (
    Control(dialect=name, rotary_word="A") for name in ("linuxcnc", "grbl", "mach", "fanuc")
)
BY_BOTH = [
    ("G1 X1", "no_feed"),
    ("G93\nG1 X1 F2\nG1 X2", "no_feed"),  # in inverse time each move has its own
    ("F100\nG93\nG94\nG1 X1", "no_feed"),
    ("G1 X1 F0", "no_feed"),
    ("G80 X1", "no_motion"),
    ("G0 G1 X1", "two_of_a_group"),
    ("M3 M5", "two_of_a_group"),
    ("G93 G94", "two_of_a_group"),
    ("G0 X1 X2", "twice"),
    ("G77 X1", "unknown"),
    ("M77", "unknown"),
    ("X1", "no_motion"),  # G80 holds since the beginning
    ("G4", "dwell"),
    ("G92", "offset"),
    ("G0 X1 S-5", "negative"),
    ("G4 P-1", "negative"),
    ("G0 X1,5", "form"),
    ("P1", "unused"),
    ("G0 X0" + 255 * "0" + "1", "too_long"),
]
"""Grbl 1.1h, compiled, and rs274 of LinuxCNC 2.9 refuse each of these."""
BY_ONE = [
    (GRBL, "G64 P0.01", "unknown"),
    (GRBL, "T1 M6", "unknown"),
    (GRBL, "G43 H1", "unknown"),
    (GRBL, "M7", "unknown"),
    (GRBL, "G0 X" + 79 * "1", "too_long"),
    (LINUXCNC, "H1", "unused"),
    (LINUXCNC, "G0 X1 ( open", "form"),
    (LINUXCNC, "G0 X1 ( a ( b ) )", "form"),
    (LINUXCNC, "G92 G0 A1", "offset"),
    (MACH, "G92 X1", "offset"),  # of ours: nothing but the axis that turns is counted anew
    (MACH, "S900 M3\nM5\nG1 X1 F100", "spindle"),  # no control minds, but the tool would
    (replace(LINUXCNC, winding="rollover"), "G0 A360", "whole_turn"),
    (FANUC, "G0 X100", "no_point"),
    (FANUC, "g0 X1.", "small_letters"),
    (FANUC, "%", "form"),
]
SAFE = "G21 G17 G40 G49 G54 G80 G90 G94"


def framed(line: str, control: Control) -> str:
    """A program of a line."""
    before, after = ("%\nO0001\n", "\n%") if control.habits.percent else ("", "")
    return f"{before}{SAFE}\n{line}\nM5\nM30{after}\n"


@pytest.mark.parametrize(
    ("control", "line", "why"),
    [(control, *row) for control in (LINUXCNC, MACH, GRBL) for row in BY_BOTH] + BY_ONE,
)
def test_a_line_that_a_control_refuses_is_not_kept(control: Control, line: str, why: str) -> None:
    with pytest.raises(CarveError) as refused:
        require_taken(framed(line, control), control)
    assert why_of(refused.value).code == f"carver.line.{why}"


@pytest.mark.parametrize("control", [LINUXCNC, MACH, GRBL, FANUC])
@pytest.mark.parametrize(
    "line",
    [
        "( A COMMENT OF WHATEVER LENGTH" + 80 * " X" + " )",
        "G1 X1. F100.\nG1 A2.5",
        "G93\nG1 X1. F2.\nG94\nG0 A-.5",
        "G92 A0.\nG4 P1",
    ],
)
def test_a_line_that_every_control_takes_is_kept(control: Control, line: str) -> None:
    require_taken(framed(line, control), control)


@pytest.mark.parametrize(
    ("control", "program", "code"),
    [
        (LINUXCNC, f"{SAFE}\nM3 S900\nM30\n", "carver.no_end"),
        (LINUXCNC, f"{SAFE}\n", "carver.no_end"),
        (LINUXCNC, f"{SAFE}\nM30\nG0 X1\n", "carver.line.after_end"),
        (LINUXCNC, "G17 G40 G49 G54 G80 G90 G94\nG0 X1\nM30\n", "carver.line.untold"),
        (FANUC, f"{SAFE}\nM30\n", "carver.line.frame"),
        (FANUC, f"%\n{SAFE}\nM30\n%\n", "carver.line.frame"),
        (FANUC, f"%\nO0001\n{SAFE}\nM30\n", "carver.line.frame"),
    ],
)
def test_a_program_has_its_beginning_and_its_end(control: Control, program: str, code: str) -> None:
    with pytest.raises(CarveError) as refused:
        require_taken(program, control)
    found = refused.value.finding
    assert code in (found.code, getattr(found.values.get("why"), "code", ""))


def test_whole_turns_are_taken_off_in_time(tmp_path: Path, limb: Limb) -> None:
    control = Control(winding="reset", a_limit_deg=1000)
    lines = lines_of(tmp_path, limb, control, scallop_mm=0.2)
    words = [float(word) for word in re.findall(r"G1 .* A(\S+)", "\n".join(lines))]
    assert 900 < max(words) <= 1000
    taken = [line for line in lines if line.startswith("G92")]
    assert len(taken) > 3
    assert all(abs(float(line.removeprefix("G92 A"))) < 360 for line in taken)


MACHINE = Machine(
    control=Control(dialect="fanuc", winding="rollover", feed="per-minute", tool_number=4),
    carving=CarveOptions(tool_diameter_mm=19, plunge_mm_min=500, spindle_rpm=8000, pattern="rings"),
)


def test_a_machine_file_comes_back_as_it_was(tmp_path: Path) -> None:
    path = write_machine(MACHINE, tmp_path / "shop.toml")
    assert read_machine(path) == MACHINE
    text = path.read_text()
    assert "to_mm" not in text, "what belongs to one job stays out"
    assert write_machine(read_machine(path), tmp_path / "again.toml").read_text() == text
    path.write_text(text, "utf-8-sig")  # as an editor may save it
    assert read_machine(path) == MACHINE
    assert write_machine(MACHINE, path).read_text() == text
    part = tmp_path / "part.toml"
    part.write_text('format = "limbgram machine"\nversion = 1\n[carving]\nplunge_mm_min = 333\n')
    assert read_machine(part).carving == CarveOptions(plunge_mm_min=333.0)


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("version = 1", "version = 2", "no machine file of this version"),
        ("version = 1", "version = 1\nspeed = 3", "no machine file of this version"),
        ("plunge_mm_min = 500.0", "plunge = 500", "carving has no plunge. It has"),
        (
            "plunge_mm_min = 500.0",
            'plunge_mm_min = "500"',
            "mm_min must be a number, not '500'",
        ),
        ("plunge_mm_min = 500.0", "plunge_mm_min = true", "must be a number, not True"),
        ("plunge_mm_min = 500.0", "plunge_mm_min = nan", "must be a number within reason"),
        ("plunge_mm_min = 500.0", "plunge_mm_min = 1e9", "cannot be"),
        ("plunge_mm_min = 500.0", "plunge_mm_min = 1" + 400 * "0", "beyond all measure"),
        ("spindle_rpm = 8000", "spindle_rpm = 8000.5", "must be a whole number, not 8000.5"),
        ('"fanuc"', '"heidenhain"', "dialect must be one of linuxcnc, mach, fanuc, grbl"),
        ('"fanuc"', '"mach"', "not written for mach"),
        (
            '"per-minute"',
            '"per-hour"',
            "feed must be one of .*, not 'per-hour'",
        ),
        ('"rings"', '"spiral"', "pattern must be one of helix, rings"),
        ("[carving]", "carving = 3\n[other]", "no machine file"),
        ("[carving]", "[carving]\nto_mm = 3.0", "no to_mm: each job has its own"),
        ("[carving]", "[carving", "no machine file"),
    ],
)
def test_a_machine_file_is_read_strictly(
    tmp_path: Path, before: str, after: str, says: str
) -> None:
    path = write_machine(MACHINE, tmp_path / "shop.toml")
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after))
    with pytest.raises(OptionsError, match=says):
        read_machine(path)


def test_a_machine_file_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "large.toml").write_bytes(b"#" * 70_000)
    (tmp_path / "odd.toml").write_bytes(b"\xff\xfe")
    for name, says in (("none", "cannot be read"), ("large", "too large"), ("odd", "no machine")):
        with pytest.raises(OptionsError, match=says):
            read_machine(tmp_path / f"{name}.toml")


@pytest.mark.parametrize("dialect", ["linuxcnc", pytest.param("fanuc", marks=pytest.mark.slow)])
def test_rings_within_a_turn_go_back_to_nothing_and_stay_there(
    tmp_path: Path, limb: Limb, dialect: Literal["linuxcnc", "fanuc"]
) -> None:
    """A ring that is gone back ends at 0, which is written as a little; to name 0 again from there
    would be a whole turn where the sign is the way."""
    control = Control(dialect=dialect, winding="rollover")
    report = write_gcode(
        limb, tmp_path / "l.nc", replace(OPTIONS, pattern="rings", scallop_mm=0.8), control
    )
    assert report.check.gouge_mm < 0.02
    words = [float(word) for word in re.findall(r" A(-?[\d.]+)", report.path.read_text("ascii"))]
    # From one place to the next it turns by a few degrees, never nearly all the way round.
    ways = [
        (to - abs(start)) % 360 if to >= 0 or dialect == "fanuc" else (abs(start) + to) % 360
        for start, to in itertools.pairwise(words)
    ]
    assert max(min(way, 360 - way) if dialect == "fanuc" else way for way in ways) < 20
