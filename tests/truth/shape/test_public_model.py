"""Four limbs of a public shape model, torn as they are, through a whole rectification."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges, face_components
from limbgram.formats.reading import read_limb
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.wall import Wall
from limbgram.workbench.limb import Limb
from limbgram.workbench.recipe.recipe import Recipe, replay

NAMES = ("102m", "102p", "1m20", "1p20")
MM_PER_UNIT = 383.0
EDITS = (
    ("clean",),
    ("relieve", "at=fibula head", "depth_mm=3", "falloff_mm=18"),
    ("load", "at=patellar tendon", "depth_mm=4", "falloff_mm=20"),
    ("reduction", "heights_mm=[20,160]", "per_cent=[3,0]", "of=girth"),
    ("smoothing", "passes=3"),
)


def reply_of(*words: object) -> Any:
    done = CliRunner().invoke(app, [*map(str, words), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def crossings(mesh: Mesh) -> int:
    every = np.ones(len(mesh.faces), np.bool_)
    return len(find_crossings(mesh.vertices_mm, mesh.faces, every))


def outermost(mesh: Mesh, share: float, direction: tuple[float, float]) -> str:
    """A place on the skin at a share of the height, farthest in a direction."""
    places = mesh.vertices_mm
    low, high = places[:, 2].min(), places[:, 2].max()
    ring = places[np.abs(places[:, 2] - low - share * (high - low)) < 4]
    return ",".join(f"{value:.3f}" for value in ring[(ring[:, :2] @ direction).argmax()])


@pytest.mark.parametrize("name", NAMES)
def test_a_torn_model_goes_the_whole_way(data_folder: Path, tmp_path: Path, name: str) -> None:
    scan = tmp_path / "scan.stl"
    scan.write_bytes((data_folder / "shapes" / "openlimb_TT" / f"{name}.stl").read_bytes())
    mesh = read_limb(scan, MM_PER_UNIT).mesh
    tendon, fibula = outermost(mesh, 0.75, (0, -1)), outermost(mesh, 0.7, (-1, 0))
    aligned = reply_of(
        "align", scan, "--unit", MM_PER_UNIT, "--side", "right", "--kind", "transtibial",
        "--anterior", "-y", "--landmark", f"patellar tendon={tendon}",
        "--landmark", f"fibula head={fibula}",
    )  # fmt: skip
    scraps = next(note for note in aligned["notes"] if note["code"] == "limb.scraps")
    assert scraps["values"]["count"] == 4
    height = aligned["size_mm"][2]

    levels = reply_of("measure", scan, "--every", 20)["levels"]
    below_brim = [row for row in levels if row["from_reference_mm"] < height - 30]
    assert len(below_brim) >= 8
    for row in below_brim:
        assert not row["reasons"]
        assert row["volume_below_ml"]["value"] > 0

    recipe, positive = tmp_path / "a.toml", tmp_path / "positive.ply"
    reply_of("edit", "new", recipe, "--for", scan)
    for words in (*EDITS, ("plane-cut", f"height_mm={0.8 * height:.0f}")):
        reply_of("edit", "add", recipe, *words)
    ledger = reply_of("edit", "apply", scan, recipe, "-o", positive)["ledger"]
    assert [line["number"] for line in ledger["lines"]] == [1, 2, 3, 4, 5, 6]
    made = read_limb(positive)
    assert crossings(made.mesh) == 0
    assert face_components(made.mesh.faces).max() == 0

    closing = tmp_path / "closing.toml"
    reply_of("edit", "new", closing)
    reply_of("edit", "add", closing, "fill", "brim=true")
    reply_of("edit", "apply", positive, closing, "-o", tmp_path / "closed.ply")
    assert len(boundary_half_edges(read_limb(tmp_path / "closed.ply").mesh.faces)) == 0

    walling, sock = tmp_path / "walling.toml", tmp_path / "sock.ply"
    reply_of("edit", "new", walling)
    reply_of("edit", "add", walling, "wall", "thickness_mm=4")
    reply_of("edit", "apply", positive, walling, "-o", sock)
    solid = read_limb(sock)
    assert crossings(solid.mesh) == 0
    assert face_components(solid.mesh.faces).max() == 0

    printed = reply_of("export", sock, "--to", "stl", "-o", tmp_path / "sock.stl")
    assert printed["bodies_left_out"] == 0
    assert read_limb(tmp_path / "sock.stl").notes == ()
    carved = reply_of("export", positive, "--to", "aop", "--side", "right")
    assert carved["max_mm"] < 3
    reply_of("export", positive, "--to", "gcode", "--side", "right", "--tool", 19)
    record = reply_of(
        "report", positive, "--against", scan, "--recipe", recipe, "-o", tmp_path / "r"
    )
    assert record["written"]


@pytest.mark.parametrize("name", NAMES)
def test_a_wall_over_a_torn_model_is_one_body(data_folder: Path, name: str) -> None:
    """Each torn triangle once became a body of its own, through the wall of the skin."""
    path = data_folder / "shapes" / "openlimb_TT" / f"{name}.stl"
    limb = replay(Recipe(name="", entries=()), read_limb(path, MM_PER_UNIT)).limb
    assert crossings(limb.mesh) == 0
    walled = do_edit(Limb(mesh=limb.mesh), Wall(thickness_mm=4, least_mm=1e-6))
    assert crossings(walled.mesh) == 0
    assert face_components(walled.mesh.faces).max() == 0
