"""Clients: our files in the programs that they are made for.

    python benchmarks/clients.py -o benchmarks/results/clients.json [--python OTHER/bin/python]

writes clients.json: a row for each program and file, with what the program says of it: whether it
opens, the size of its box, whether it is closed, its colours, its scalar field, its unit. Truth is
the shape that was written, an ellipsoid of 160 x 160 x 240 mm with a colour and a sigma at each
vertex; three cameras look at it. A program that is not there is skipped, and the table says so;
what an earlier run in the same file saw of it stays, with that run's commit. Libraries of Python
are tried in this interpreter, then in those given by --python. Stock Grbl 1.1h is Grbl's own
source, built with grbl-sim: its `gvalidate` has to be on the path. CuraEngine needs Cura's
definitions of printers (CURA_ENGINE_SEARCH_PATH names another folder), and FreeCAD's legacy
importer its library, which FreeCAD fetches into its folder of user data.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from harness import asking, machine, made_on, write
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.spreadsheet import Table, csv_of, xlsx_of
from limbgram.formats.colmap import write_colmap
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import ShapeFile
from limbgram.formats.transforms import write_transforms
from limbgram.formats.vtp import write_vtp
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.report.record.sources import ShapeSource
from limbgram.services.export import Aop, Drawing, Gcode, export
from limbgram.services.report import ReportRequest, Subject, report
from limbgram.workbench.limb import Landmark, Limb, LimbFrame

RADIUS_MM, HALF_HEIGHT_MM = 80.0, 120.0
SIZE_MM = (2 * RADIUS_MM, 2 * RADIUS_MM, 2 * HALF_HEIGHT_MM)
COLOUR = (200, 150, 100)
"""Of all vertices; as linear light 147, 78, 33 of 255."""
SIGMA_MM = (0.05, 0.25)
"""From the lower end to the upper."""
TABLE = Table(title="levels", columns=("height_mm", "tape_mm"), rows=((65.213, 354.25),))
CARVED = Gcode(
    preset="fast", dialect="linuxcnc", tool_reach_mm=300.0, blank_diameter_mm=200.0,
    blank_length_mm=320.0, to_mm=100.0,
)  # fmt: skip
ON_GRBL = replace(CARVED, dialect="grbl")
CAMERA = Camera(
    width_px=2000, height_px=1500, fx=2400.0, fy=2410.0, cx=990.0, cy=760.0, k1=-0.1, p1=1e-3
)  # fmt: skip
AWAY_MM = 700.0
"""Of the cameras."""
PHOTOS = ("a.jpg", "b.jpg", "c.jpg")
OTHERS = (
    "cad.dxf", "r12.dxf", "polyface.dxf", "carve.ngc", "grbl.nc", "ampscan.aop", "table.xlsx",
    "comma.csv", "colmap", "pinhole", "transforms.json", "report.pdf",
)  # fmt: skip
_SECONDS = 300
_LAYER_MM, _LINE_MM = 5.0, 0.4
_WRONG_LINES = (
    "G80 X1", "G0 G1 X1", "G0 X1 X2", "G77 X1", "M3 M5", "G4", "G0 X1 S-5", "G0 X1,5", "P1",
)  # fmt: skip
"""Of which our own rules let none pass either (tests/unit/formats/test_gcode.py)."""
_CURA_PRINTERS = "/usr/share/cura/resources/definitions"
_DPI, _WHITE = 200, 254
_GERMAN = "de_DE.UTF-8"


@dataclass(frozen=True, kw_only=True)
class Seen:
    """One file in one program; None where the program, or the format, does not tell."""

    program: str
    file: str
    opens: bool
    size: str | None = None
    closed: bool | None = None
    colours: str | None = None
    scalar: str | None = None
    units: str | None = None
    note: str = ""


def main() -> None:
    asked = asking(__doc__.splitlines()[0])
    asked.add_argument("--python", action="append", default=[], help="another interpreter")
    given = asked.parse_args()
    with tempfile.TemporaryDirectory() as name:
        files = written(Path(name))
        seen: list[Seen] = []
        skipped: dict[str, str] = {}
        for program, suffixes, look in PROGRAMS:
            for file in files:
                if not file.name.endswith(suffixes):
                    continue
                try:
                    seen.append(look(program, file, [sys.executable, *given.python]))
                except LookupError as missing:
                    skipped[program] = str(missing)
    here = machine()
    kept = _kept(given.out, set(skipped))
    rows = [{**asdict(one), "commit": here["commit"]} for one in seen] + kept
    order = [program for program, _, _ in PROGRAMS]
    found = {
        "machine": here,
        "truth": {"size_mm": SIZE_MM, "sigma_mm": SIGMA_MM, "colour": COLOUR},
        "seen": sorted(rows, key=lambda row: order.index(row["program"])),
        "skipped": skipped,
    }
    write(given.out, found)


def _kept(out: Path, skipped: set[str]) -> list[dict[str, Any]]:
    """What an earlier run saw of programs that are not here."""
    if not out.is_file():
        return []
    before = json.loads(out.read_text())
    return [
        {"commit": before["machine"]["commit"], **row}
        for row in before["seen"]
        if row["program"] in skipped
    ]


def written(folder: Path) -> list[Path]:
    """A file of each kind."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    vertices = np.asarray(ball.vertices) * (RADIUS_MM, RADIUS_MM, HALF_HEIGHT_MM)
    share = (vertices[:, 2] / HALF_HEIGHT_MM + 1) / 2
    mesh = Mesh(
        vertices_mm=vertices,
        faces=np.asarray(ball.faces, np.int32),
        colours=np.full((len(vertices), 3), COLOUR, np.uint8),
        sigma_mm=(SIGMA_MM[0] + share * (SIGMA_MM[1] - SIGMA_MM[0])).astype(np.float32),
        filled=np.zeros(len(vertices), np.bool_),
    )
    marks = (Landmark(name="fibula head", position_mm=np.array([RADIUS_MM, 0.0, 0.0])),)
    limb = Limb(mesh=mesh, landmarks=marks)
    shape = ShapeFile(limb=limb, sha256="", mm_per_unit=1.0)
    meshes = [
        write_limb(limb, folder / f"limb.{kind}") for kind in ("stl", "3mf", "ply", "obj", "glb")
    ]
    meshes.append(write_vtp(mesh, folder / "limb.vtp", "mm"))
    export(shape, Drawing(spacing_mm=40.0), folder / "cad.dxf")
    standing = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    aligned = replace(shape, limb=limb.with_frame(standing))
    export(aligned, CARVED, folder / "carve.ngc", "right")
    export(aligned, ON_GRBL, folder / "grbl.nc", "right")
    export(aligned, Aop(profile="ampscan"), folder / "ampscan.aop", "right")
    source = ShapeSource(limb=aligned.limb, sha256="0" * 64, kind="PLY", limb_file_sha256=None)
    report(Subject(shape=source), ReportRequest(), folder)
    export(shape, Drawing(spacing_mm=40.0, r12=True), folder / "r12.dxf")
    export(shape, Drawing(spacing_mm=40.0, polyface=True), folder / "polyface.dxf")
    (folder / "table.xlsx").write_bytes(xlsx_of([TABLE]))
    (folder / "comma.csv").write_text(csv_of(TABLE, "comma"), "utf-8")
    _write_cameras(vertices, folder)
    return [*meshes, *(folder / one for one in OTHERS)]


def _write_cameras(points: np.ndarray, folder: Path) -> None:
    """Three cameras that see all these points: with their lens, and as pinhole cameras."""
    up = np.array([0.0, 0.0, 1.0])
    poses = tuple(
        Rigid.looking_at(AWAY_MM * np.array([np.cos(turn), np.sin(turn), 0.2]), np.zeros(3), up)
        for turn in (0.0, 0.5, 1.0)
    )
    metric, seen = _taken(CAMERA, poses, points)
    colours = np.full((len(points), 3), COLOUR, np.uint8)
    write_colmap(metric, folder / "colmap", colours=colours)
    straight, _ = _taken(CAMERA.pinhole, poses, points)
    (folder / "pinhole" / "images").mkdir(parents=True)
    write_colmap(straight, folder / "pinhole" / "sparse", colours=colours)
    for name in PHOTOS:
        photo = Image.new("RGB", (CAMERA.width_px, CAMERA.height_px))
        photo.save(folder / name)
        photo.save(folder / "pinhole" / "images" / name)
    write_transforms(metric, folder / "transforms.json", ".")
    np.savetxt(folder / "points.txt", np.hstack([points, *seen]))


def _taken(
    camera: Camera, poses: tuple[Rigid, ...], points: np.ndarray
) -> tuple[MetricScene, list[np.ndarray]]:
    """A scene of these points by a camera, and where each photo shows them."""
    seen = [camera.project(pose.apply(points)) for pose in poses]
    scene = Scene(
        names=PHOTOS,
        cameras=(camera,),
        camera_idx=(0, 0, 0),
        camera_from_world=poses,
        points_in_world=points,
        observations=Observations(
            np.repeat(np.arange(3, dtype=np.int32), len(points)),
            np.tile(np.arange(len(points), dtype=np.int32), 3),
            np.concatenate(seen),
        ),
        verdicts=(),
    )
    return MetricScene(
        scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=0.0)
    ), seen


def _by_python(library: str, script: str) -> "Look":
    """A look by a library; the script has `path` and fills the dict `seen`."""

    def look(program: str, file: Path, interpreters: list[str]) -> Seen:
        for interpreter in interpreters:
            there = subprocess.run(
                [interpreter, "-c", f"import {library}"], capture_output=True, check=False
            )
            if there.returncode == 0:
                break
        else:
            raise LookupError(f"no Python here has {library}")
        begin = "import json, sys\npath, seen = sys.argv[1], {}\n"
        whole = begin + script + "\nprint('\\n' + json.dumps(seen))"
        return _told(program, file, _run([interpreter, "-c", whole, str(file)]))

    return look


def _told(program: str, file: Path, ended: subprocess.CompletedProcess[str]) -> Seen:
    """What a script printed last."""
    if ended.returncode:
        why = (ended.stderr.strip().splitlines() or ["no reason"])[-1]
        return Seen(program=program, file=file.name, opens=False, note=why[:100])
    tree: dict[str, Any] = json.loads(ended.stdout.strip().splitlines()[-1])
    size = tree.get("size")
    shown = None if size is None else " x ".join(f"{one:.4g}" for one in size)
    return Seen(program=program, file=file.name, opens=True, **{**tree, "size": shown})


def _run(
    words: list[str], folder: Path | None = None, **extra: str
) -> "subprocess.CompletedProcess[str]":
    bare = {key: value for key, value in os.environ.items() if not key.startswith("VIRTUAL")}
    around = {**bare, "QT_QPA_PLATFORM": "offscreen", **extra}
    try:
        return subprocess.run(
            words,
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=_SECONDS,
            env=around,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(words, 124, "", f"no answer in {_SECONDS} s")


def _need(*names: str) -> str:
    for name in names:
        place = shutil.which(name)
        if place is not None:
            return place
    raise LookupError(f"{names[0]} is not installed")


def _slicer(command: str) -> "Look":
    """PrusaSlicer, and Slic3r that it came of, tell alike."""

    def look(program: str, file: Path, _: list[str]) -> Seen:
        return _sliced(program, file, _run([_need(command), "--info", str(file)]))

    return look


def _sliced(program: str, file: Path, ended: subprocess.CompletedProcess[str]) -> Seen:
    told = dict(re.findall(r"(\w+) = +(\S+)", ended.stdout))
    if "size_x" not in told:
        return Seen(program=program, file=file.name, opens=False, note=ended.stderr[:100])
    return Seen(
        program=program,
        file=file.name,
        opens=True,
        size=" x ".join(f"{float(told[f'size_{axis}']):.4g}" for axis in "xyz"),
        closed=told.get("manifold") == "yes",
        units="takes mm",
    )


def _cura(program: str, file: Path, _: list[str]) -> Seen:
    """Cut into layers; the middle of the outer line lies half its width inside."""
    engine = _need("CuraEngine")
    folder = Path(
        os.environ.get("CURA_ENGINE_SEARCH_PATH", "/usr/share/cura/resources/definitions")
    )
    printer, out = folder / "fdmprinter.def.json", file.with_suffix(".cura")
    if not printer.is_file():
        raise LookupError("Cura's definitions of printers are not installed")
    settings = {
        **{f"machine_{one}": 2 * int(max(SIZE_MM)) for one in ("width", "depth", "height")},
        "machine_center_is_zero": "true",
        "center_object": "true",
        "adhesion_type": "none",
        "layer_height": _LAYER_MM,
        "layer_height_0": _LAYER_MM,
        "infill_line_distance": 0,
        "wall_line_width_0": _LINE_MM,
        "mesh_position_z": HALF_HEIGHT_MM,
    }
    asked = [word for name, value in settings.items() for word in ("-s", f"{name}={value}")]
    ended = _run(
        [engine, "slice", "-j", str(printer), *asked, "-l", str(file), "-o", str(out)],
        CURA_ENGINE_SEARCH_PATH=str(folder),
    )
    text = out.read_text() if out.is_file() else ""
    layers = text.count(";LAYER:")
    if ended.returncode or not layers:
        return Seen(program=program, file=file.name, opens=False, note="no layers")
    line = re.findall(r"^G[01] .*?X(\S+) Y(\S+).* E", text, re.MULTILINE)
    across = np.ptp(np.array(line, np.float64), axis=0) + _LINE_MM
    size = (*across, layers * _LAYER_MM)
    return Seen(
        program=program,
        file=file.name,
        opens=True,
        size=" x ".join(f"{one:.4g}" for one in size),
        units="takes mm",
        note=f"{layers} layers of {_LAYER_MM:g} mm",
    )


def _cloudcompare(program: str, file: Path, _: list[str]) -> Seen:
    out = file.with_suffix(".asc")
    words = ["-SILENT", "-AUTO_SAVE", "OFF", "-O", str(file), "-EXTRACT_VERTICES"]
    words += ["-C_EXPORT_FMT", "ASC", "-ADD_HEADER", "-SAVE_CLOUDS", "FILE", str(out)]
    ended = _run([_need("CloudCompare", "cloudcompare.CloudCompare"), *words])
    if not out.is_file():
        return Seen(program=program, file=file.name, opens=False, note=ended.stdout[-100:])
    head = out.read_text().splitlines()[0].removeprefix("//").split()
    rows = np.loadtxt(out, comments="//")
    out.unlink()
    scalar = [name for name in head if name not in {*"XYZRGB", "Nx", "Ny", "Nz", "A"}]
    reach = f" {rows[:, head.index(scalar[0])].min():.3g} to" if scalar else ""
    last = f" {rows[:, head.index(scalar[0])].max():.3g}" if scalar else ""
    return Seen(
        program=program,
        file=file.name,
        opens=True,
        size=" x ".join(f"{one:.4g}" for one in np.ptp(rows[:, :3], axis=0)),
        colours=" ".join(f"{one:.0f}" for one in rows[0, 3:6]) if "R" in head else "none",
        scalar=f"{scalar[0]}{reach}{last}" if scalar else "none",
    )


_FREECAD = """
import json, os
path, seen = os.environ["LIMBGRAM_FILE"], {}
if path.endswith("dxf"):
    import FreeCAD, Import
    document = FreeCAD.newDocument()
    Import.readDXF(path)
    box = FreeCAD.BoundBox()
    for one in document.Objects:
        if hasattr(one, "Shape"):
            box.add(one.Shape.BoundBox)
    faces = sum(len(one.Shape.Faces) for one in document.Objects if hasattr(one, "Shape"))
    seen = {"note": f"{len(document.Objects)} objects, {faces} faces", "units": "mm"}
else:
    import Mesh
    mesh = Mesh.Mesh(path)
    box = mesh.BoundBox
    seen = {"closed": bool(mesh.isSolid()), "units": "takes mm"}
seen["size"] = [box.XLength, box.YLength, box.ZLength]
print("\\nSEEN" + json.dumps(seen), flush=True)
os._exit(0)
"""
_FREECAD_LEGACY = """
import json, os, sys
import FreeCAD
sys.path.append(FreeCAD.ConfigGet("UserAppData"))
asked = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Draft")
asked.SetBool("dxfUseLegacyImporter", True)
asked.SetBool("dxfUseDraftVisGroups", False)  # its layers take no mesh
try:
    import dxfReader
except ImportError:
    print("\\nNO LIBRARY", flush=True)
    os._exit(0)
import importDXF
importDXF.open(os.environ["LIMBGRAM_FILE"])
meshes = [one.Mesh for one in FreeCAD.ActiveDocument.Objects if one.TypeId == "Mesh::Feature"]
seen = {"note": "curves alone", "units": "takes mm"}
if meshes:
    (mesh,) = meshes
    box = mesh.BoundBox
    seen["size"] = [box.XLength, box.YLength, box.ZLength]
    seen["closed"] = bool(mesh.isSolid())
    seen["note"] = f"a mesh of {mesh.CountFacets} triangles"
print("\\nSEEN" + json.dumps(seen), flush=True)
os._exit(0)
"""


def _freecad(script: str) -> "Look":
    """A look by its Python."""

    def look(program: str, file: Path, _: list[str]) -> Seen:
        macro = file.with_name("look.FCMacro.py")
        macro.write_text(script)
        command = _need("freecadcmd", "FreeCADCmd")
        ended = _run([command, str(macro)], LIMBGRAM_FILE=str(file))
        if "NO LIBRARY" in ended.stdout:
            raise LookupError("its legacy importer has not fetched its library")
        told = re.search(r"SEEN(\{.*\})", ended.stdout)
        if told is None:
            why = (ended.stderr.strip().splitlines() or ["no answer"])[-1]
            return Seen(program=program, file=file.name, opens=False, note=why[:100])
        return _told(program, file, subprocess.CompletedProcess([], 0, told[1], ""))

    return look


def _blender(program: str, file: Path, _: list[str]) -> Seen:
    script = file.with_name("look.blender.py")
    script.write_text(_BLENDER)
    ended = _run([_need("blender"), "-b", "--python", str(script), "--", str(file)])
    told = re.search(r"SEEN(\{.*\})", ended.stdout)
    if told is None:
        why = (ended.stderr.strip().splitlines() or ["no answer"])[-1]
        return Seen(program=program, file=file.name, opens=False, note=why[:100])
    return _told(program, file, subprocess.CompletedProcess([], 0, told[1], ""))


def _linuxcnc(program: str, file: Path, _: list[str]) -> Seen:
    """Interpreted to the end, without a machine; spoilt programs are not."""
    command, folder = _need("rs274"), file.with_name("linuxcnc")
    folder.mkdir()
    (folder / "parameters.var").touch()
    (folder / "look.ini").write_text(f"[RS274NGC]\nPARAMETER_FILE={folder}/parameters.var\n")

    def taken(one: Path) -> int | None:
        ended = _run([command, "-g", "-i", str(folder / "look.ini"), str(one)])
        whole = ended.returncode == 0 and "PROGRAM_END()" in ended.stdout
        return ended.stdout.count("STRAIGHT_FEED") if whole else None

    moves = taken(file)
    note = f"{moves} moves, to the end" if moves else "not to the end"
    return Seen(
        program=program, file=file.name, opens=bool(moves), note=f"{note}; {_spoilt(file, taken)}"
    )


def _grbl(program: str, file: Path, _: list[str]) -> Seen:
    """Grbl's own parser, line by line; it stops at the first line that it refuses."""
    command = _need("gvalidate", "gvalidate.exe")

    def taken(one: Path) -> int | None:
        ended = _run([command, str(one)], one.parent)  # keeps an EEPROM there
        lines = len(one.read_text("ascii").splitlines())
        return lines if ended.returncode == 0 and ended.stdout.count("ok") >= lines else None

    lines = taken(file)
    note = f"{lines} lines, all taken" if lines else "not all lines taken"
    return Seen(
        program=program,
        file=file.name,
        opens=bool(lines),
        units="G21",
        note=f"{note}; {_spoilt(file, taken)}",
    )


def _spoilt(file: Path, taken: Callable[[Path], int | None]) -> str:
    """How many programs with a line amiss in their middle are not taken to the end."""
    lines = file.read_text("ascii").splitlines()
    middle = len(lines) // 2
    refused = 0
    for wrong in _WRONG_LINES:
        one = file.with_name(f"spoilt{file.suffix}")
        one.write_text("\n".join([*lines[:middle], wrong, *lines[middle:], ""]), "ascii")
        refused += taken(one) is None
    return f"refuses {refused} of {len(_WRONG_LINES)} spoilt programs"


def _poppler(program: str, file: Path, _: list[str]) -> Seen:
    about = _run([_need("pdfinfo"), str(file)])
    told = dict(re.findall(r"^([\w ]+): +(.*)$", about.stdout, re.MULTILINE))
    rows = _run([_need("pdffonts"), str(file)]).stdout.splitlines()[2:]
    kinds = sorted({" ".join(row[37:54].split()) for row in rows})
    embedded = all(row.split()[-5] == "yes" for row in rows)
    note = (
        f"{told.get('Pages')} pages, tagged: {told.get('Tagged')}, title: {told.get('Title')}; "
        f"{len(rows)} fonts ({', '.join(kinds)}), {'all' if embedded else 'not all'} embedded"
    )
    good = told.get("Tagged") == "yes" and embedded and "Title" in told
    return Seen(program=program, file=file.name, opens=good, note=note)


def _librecad(program: str, file: Path, _: list[str]) -> Seen:
    """Drawn on paper in its true size, and measured there."""
    out = file.with_suffix(".pdf")
    words = [_need("librecad"), "dxf2pdf", "--center", "--grayscale", "--scale", "1", str(file)]
    ended = _run(words)
    if not out.is_file():
        return Seen(program=program, file=file.name, opens=False, note=ended.stderr[-100:])
    page = file.with_name("librecad")
    _run([_need("pdftoppm"), "-r", str(_DPI), "-gray", "-singlefile", str(out), str(page)])
    drawn = np.argwhere(np.asarray(Image.open(page.with_suffix(".pgm"))) < _WHITE)
    if not len(drawn):
        return Seen(program=program, file=file.name, opens=False, note="an empty page")
    down, across = np.ptp(drawn, axis=0) / _DPI * 25.4
    return Seen(
        program=program,
        file=file.name,
        opens=True,
        size=f"{across:.4g} x {down:.4g}",
        note="seen along z, with names beside landmarks" if file.stem == "cad" else "seen along z",
    )


def _libreoffice(program: str, file: Path, _: list[str]) -> Seen:
    import openpyxl

    folder = file.with_name(f"seen-{file.stem}")
    words = [_need("soffice"), f"-env:UserInstallation=file://{file.parent}/profile", "--headless"]
    if file.suffix == ".csv":
        words.append("--infilter=Text - txt - csv (StarCalc):59,34,76,1,,1031,false,true")
    words += ["--convert-to", "xlsx", "--outdir", str(folder), str(file)]
    ended = _run(words, LANG=_GERMAN, LC_ALL=_GERMAN)
    made = folder / f"{file.stem}.xlsx"
    if not made.is_file():
        return Seen(program=program, file=file.name, opens=False, note=ended.stderr[-100:])
    head, *rows = openpyxl.load_workbook(made).active.iter_rows(values_only=True)
    same = rows == [tuple(row) for row in TABLE.rows]
    note = "numbers as written" if same else f"other numbers: {rows[0]}"
    return Seen(program=program, file=file.name, opens=same, units=str(head[0]), note=note)


_BLENDER = """
import json, sys
import bmesh, bpy
path, seen = sys.argv[-1], {}
bpy.ops.wm.read_factory_settings(use_empty=True)
if path.endswith("glb"):
    bpy.ops.import_scene.gltf(filepath=path)
elif path.endswith("obj"):
    bpy.ops.wm.obj_import(filepath=path)
else:
    bpy.ops.import_mesh.stl(filepath=path)
(limb,) = [one for one in bpy.data.objects if one.type == "MESH"]
seen["size"] = list(limb.dimensions)
faces = bmesh.new()
faces.from_mesh(limb.data)
seen["closed"] = all(edge.is_manifold for edge in faces.edges)
layers = limb.data.color_attributes
seen["colours"] = "none"
if layers:
    linear = layers[0].data[0].color[:3]
    seen["colours"] = "linear " + " ".join(f"{255 * one:.0f}" for one in linear)
marks = [one.name for one in bpy.data.objects if one.type == "EMPTY"]
if marks:
    seen["note"] = f"landmarks: {', '.join(marks)}"
print("SEEN" + json.dumps(seen), flush=True)
"""
_TRIMESH = """
import trimesh
mesh = trimesh.load(path, process=path.endswith("stl"))
mesh = mesh if hasattr(mesh, "faces") else mesh.to_mesh()
seen["size"] = mesh.extents.tolist()
seen["closed"] = bool(mesh.is_watertight)
if mesh.visual.kind == "vertex":
    seen["colours"] = " ".join(str(one) for one in mesh.visual.vertex_colors[0][:3])
"""
_PYVISTA = """
import pyvista
mesh = pyvista.read(path)
mesh = mesh if isinstance(mesh, pyvista.PolyData) else mesh.combine().extract_surface()
low, high = mesh.bounds[::2], mesh.bounds[1::2]
seen["size"] = [b - a for a, b in zip(low, high)]
seen["closed"] = mesh.clean().n_open_edges == 0
named = [one for one in mesh.point_data if "sigma" in one.lower()]
reach = [f"{one} {mesh[one].min():.3g} to {mesh[one].max():.3g}" for one in named]
seen["scalar"] = reach[0] if reach else "none"
rgb = next((one for one in ("RGB", "RGBA", "COLOR_0") if one in mesh.point_data), None)
seen["colours"] = " ".join(f"{one:.3g}" for one in mesh[rgb][0][:3]) if rgb else "none"
if "unit" in mesh.field_data:
    seen["units"] = str(mesh.field_data["unit"][0])
"""
_MESHIO = """
import meshio
mesh = meshio.read(path)
seen["size"] = (mesh.points.max(0) - mesh.points.min(0)).tolist()
named = [one for one in mesh.point_data if "sigma" in one]
seen["scalar"] = named[0] if named else "none"
"""
_OPEN3D = """
import numpy, open3d
mesh = open3d.io.read_triangle_mesh(path)
if path.endswith("stl"):
    mesh.merge_close_vertices(1e-6)
assert len(mesh.triangles), "no triangles"
seen["size"] = mesh.get_axis_aligned_bounding_box().get_extent().tolist()
seen["closed"] = bool(mesh.is_watertight())
colours = numpy.asarray(mesh.vertex_colors)
seen["colours"] = " ".join(f"{255 * one:.0f}" for one in colours[0]) if len(colours) else "none"
"""
_PYMESHLAB = """
import pymeshlab
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(path)
if path.endswith("stl"):
    meshes.meshing_merge_close_vertices()
mesh = meshes.current_mesh()
box = mesh.bounding_box()
seen["size"] = (box.max() - box.min()).tolist()
seen["closed"] = meshes.get_topological_measures()["boundary_edges"] == 0
seen["scalar"] = "none"
if mesh.has_vertex_scalar():
    quality = mesh.vertex_scalar_array()
    seen["scalar"] = f"quality {quality.min():.3g} to {quality.max():.3g}"
if mesh.has_vertex_color():
    seen["colours"] = " ".join(f"{255 * one:.0f}" for one in mesh.vertex_color_matrix()[0][:3])
"""
_EZDXF = """
import ezdxf
from ezdxf import bbox, units
drawing = ezdxf.readfile(path)
found = bbox.extents(drawing.modelspace())
seen["size"] = list(found.size)
seen["units"] = units.unit_name(drawing.units)
kinds = sorted({one.dxftype() for one in drawing.modelspace()})
seen["note"] = f"{len(drawing.audit().errors)} errors; {', '.join(kinds)}"
"""
_PANDAS = """
import pandas
book = path.endswith("xlsx")
table = pandas.read_excel(path) if book else pandas.read_csv(path, sep=";", decimal=",")
assert table.iloc[0].tolist() == [65.213, 354.25], table
seen["note"] = "numbers as written"
seen["units"] = table.columns[0].strip()
"""
_OPENPYXL = """
import openpyxl
head, row = openpyxl.load_workbook(path).active.iter_rows(values_only=True)
assert row == (65.213, 354.25), row
seen["note"] = "numbers as written"
seen["units"] = head[0]
"""
_GMSH = """
import gmsh
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.merge(path)
box = gmsh.model.getBoundingBox(-1, -1)
seen["size"] = [high - low for low, high in zip(box[:3], box[3:])]
"""
_AMPSCAN = """
import numpy
from ampscan import AmpObject
limb = AmpObject(path)
seen["size"] = numpy.ptp(limb.vert, axis=0).tolist()
"""
_PYCOLMAP = """
import os, numpy, pycolmap
inside = os.path.join(path, "sparse")
model = pycolmap.Reconstruction(inside if os.path.isdir(inside) else path)
worst, places = 0.0, []
for point in model.points3D.values():
    places.append(point.xyz)
    for element in point.track.elements:
        image = model.images[element.image_id]
        camera = model.cameras[image.camera_id]
        there = camera.img_from_cam(image.cam_from_world() * point.xyz)
        seen_at = image.points2D[element.point2D_idx].xy
        worst = max(worst, float(numpy.abs(there - seen_at).max()))
seen["size"] = numpy.ptp(numpy.array(places), axis=0).tolist()
seen["colours"] = " ".join(str(one) for one in point.color)
seen["note"] = f"{camera.model.name}, {len(model.images)} photos, points within {worst:.2g} px"
"""
_NERFSTUDIO = """
import os, pathlib, numpy, torch
from nerfstudio.data.dataparsers.nerfstudio_dataparser import NerfstudioDataParserConfig
asked = NerfstudioDataParserConfig(
    data=pathlib.Path(path), orientation_method="none", center_method="none",
    auto_scale_poses=False, eval_mode="all", downscale_factor=1,
)
cameras = asked.setup().get_dataparser_outputs("train").cameras
rows = numpy.loadtxt(os.path.join(os.path.dirname(path), "points.txt"))
worst = 0.0
for idx in range(len(cameras)):
    across, down = rows[:, 3 + 2 * idx] + 0.5, rows[:, 4 + 2 * idx] + 0.5
    coords = torch.tensor(numpy.stack([down, across], 1), dtype=torch.float32)
    rays = cameras.generate_rays(camera_indices=idx, coords=coords)
    to_point = torch.tensor(rows[:, :3], dtype=torch.float32) - rays.origins
    beside = to_point - (to_point * rays.directions).sum(1, keepdim=True) * rays.directions
    worst = max(worst, float(beside.norm(dim=1).max()))
assert worst < 0.1, f"rays pass {worst:.3g} mm beside their points"
seen["note"] = f"{len(cameras)} photos, rays within {worst:.2g} mm of their points"
"""
Look = Callable[[str, Path, list[str]], Seen]
PROGRAMS: tuple[tuple[str, tuple[str, ...], Look], ...] = (
    ("PrusaSlicer", (".stl", ".obj", ".3mf"), _slicer("prusa-slicer")),
    ("Slic3r", (".stl", ".obj", ".3mf"), _slicer("slic3r")),
    ("CuraEngine", (".stl",), _cura),
    ("CloudCompare", (".ply", ".stl", ".obj"), _cloudcompare),
    ("MeshLab (pymeshlab)", (".ply", ".stl", ".obj", ".glb"), _by_python("pymeshlab", _PYMESHLAB)),
    ("Open3D", (".ply", ".stl", ".obj", ".glb"), _by_python("open3d", _OPEN3D)),
    ("pyvista", (".ply", ".stl", ".obj", ".glb", ".vtp"), _by_python("pyvista", _PYVISTA)),
    ("meshio", (".ply", ".stl", ".obj"), _by_python("meshio", _MESHIO)),
    ("trimesh", (".ply", ".stl", ".obj", ".glb"), _by_python("trimesh", _TRIMESH)),
    ("FreeCAD", (".ply", ".stl", ".obj", ".dxf"), _freecad(_FREECAD)),
    ("FreeCAD, legacy DXF", ("cad.dxf", "polyface.dxf"), _freecad(_FREECAD_LEGACY)),
    ("LibreCAD", (".dxf",), _librecad),
    ("ezdxf", (".dxf",), _by_python("ezdxf", _EZDXF)),
    ("LibreOffice, German", (".xlsx", ".csv"), _libreoffice),
    ("pandas", (".xlsx", ".csv"), _by_python("pandas", _PANDAS)),
    ("openpyxl", (".xlsx",), _by_python("openpyxl", _OPENPYXL)),
    ("Blender", (".stl", ".obj", ".glb"), _blender),
    ("LinuxCNC's interpreter", (".ngc",), _linuxcnc),
    ("Grbl 1.1h", (".nc",), _grbl),
    ("ampscan", (".aop",), _by_python("ampscan", _AMPSCAN)),
    ("gmsh", (".stl", ".ply"), _by_python("gmsh", _GMSH)),
    ("pycolmap", ("colmap", "pinhole"), _by_python("pycolmap", _PYCOLMAP)),
    ("nerfstudio", ("transforms.json",), _by_python("nerfstudio", _NERFSTUDIO)),
    ("poppler", (".pdf",), _poppler),
)
"""With the ends of the names of the files that each is for."""


def page(found: dict[str, Any]) -> str:
    """The table of a result."""
    columns = ("opens", "size", "closed", "colours", "scalar", "units", "note")
    lines = [
        "# Our files in other programs",
        "",
        f"- {made_on(found['machine'])}",
        f"- truth: {' x '.join(f'{one:g}' for one in SIZE_MM)} mm, closed, colour "
        f"{' '.join(map(str, COLOUR))} (as linear light 147 78 33), sigma {SIGMA_MM[0]} to "
        f"{SIGMA_MM[1]} mm. GLB is in metres with +Y up. FreeCAD and LibreCAD know no "
        "MESH: they show the curves, sections every 40 mm from -80 to 80. Of a DXF FreeCAD's usual "
        "importer takes no surface at all, its legacy one, without layers, a polyface. gmsh "
        "takes a binary PLY of single-precision places alone, none with colours or a scalar. "
        "CuraEngine cuts a layer at its middle.",
        "",
        f"| program | file | {' | '.join(columns)} |",
        "|---|---|" + "---|" * len(columns),
    ]
    for one in found["seen"]:
        cells = ["" if one[name] is None else _word(one[name]) for name in columns]
        lines.append(f"| {one['program']} | {one['file']} | {' | '.join(cells)} |")
    lines.append("")
    for name, why in found["skipped"].items():
        commits = sorted({one["commit"][:12] for one in found["seen"] if one["program"] == name})
        rows = f"; its rows are of commit {', '.join(commits)}" if commits else ""
        lines.append(f"- Skipped: {name}: {why}{rows}")
    return "\n".join(lines).rstrip() + "\n"


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value).replace("|", "/").replace("\n", " ")


if __name__ == "__main__":
    main()
