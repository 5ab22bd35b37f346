"""Every command on a shape takes its unit, and a shape in no likely unit is refused with advice."""

from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app

RUNNER = CliRunner()


@pytest.fixture
def in_metres(tmp_path: Path) -> str:
    path = tmp_path / "cone.stl"
    trimesh.creation.cone(0.05, 0.2).export(path)
    return str(path)


def test_a_recipe_is_begun_and_applied_in_the_unit_of_the_file(
    tmp_path: Path, in_metres: str
) -> None:
    recipe, out = str(tmp_path / "r.toml"), str(tmp_path / "out.ply")
    refused = RUNNER.invoke(app, ["edit", "new", recipe, "--for", in_metres])
    assert refused.exit_code == 3
    assert "--unit" in refused.output
    assert not Path(recipe).exists()
    for arguments in (
        ["edit", "new", recipe, "--for", in_metres, "--unit", "m"],
        ["edit", "add", recipe, "offset", "distance_mm=1"],
        ["edit", "apply", in_metres, recipe, "-o", out, "--unit", "m"],
    ):
        assert RUNNER.invoke(app, arguments).exit_code == 0
    assert trimesh.load_mesh(out).extents[2] == pytest.approx(200.0, abs=10.0)
    wrong = ["edit", "apply", in_metres, recipe, "-o", out, "--unit", "furlong"]
    assert RUNNER.invoke(app, wrong).exit_code == 2


def test_the_limb_file_keeps_the_unit_for_the_commands_that_follow(in_metres: str) -> None:
    align = ["align", in_metres, "--side", "none", "--axis", "+z", "--anterior", "+y"]
    assert RUNNER.invoke(app, [*align, "--unit", "m"]).exit_code == 0
    measured = RUNNER.invoke(app, ["measure", in_metres, "--height", "100", "--json"])
    assert measured.exit_code == 0
    assert RUNNER.invoke(app, ["measure", in_metres, "--unit", "cm"]).exit_code == 3


@pytest.mark.parametrize(
    "arguments",
    [
        ["measure", "--unaligned", "--csv", "other.stl"],
        ["measure", "--unaligned", "--picture", "other.stl"],
        ["export", "--to", "gcode", "--side", "left", "-o", "other.stl"],
        ["compare", "other.stl", "--picture", "other.stl"],
        ["measure", "--unaligned", "--tape", "100=200", "--fit", "cone.stl"],
        ["align", "--side", "left", "--axis", "+z", "--anterior", "+y", "--flexion", "nan"],
        ["export", "--to", "dxf", "--spacing", "-1"],
        ["export", "--to", "dxf", "--spacing", "nan", "--polyface"],
    ],
    ids=" ".join,
)
def test_what_cannot_be_is_refused_and_nothing_is_written(
    tmp_path: Path, in_metres: str, arguments: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other.stl").write_bytes(Path(in_metres).read_bytes())
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    command, *rest = arguments
    assert RUNNER.invoke(app, [command, "cone.stl", *rest, "--unit", "m"]).exit_code == 2
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("typed", "named"),
    [
        (["measure", "--height", "nan"], "--height: nan measures nothing."),
        (["measure", "--every", "inf"], "--every: inf measures nothing."),
        (["measure", "--sock", "1e-12"], "--sock: 1e-12 measures nothing."),
        (["export", "--to", "dxf", "--spacing", "nan"], "--spacing: nan measures nothing."),
    ],
    ids=lambda one: one if isinstance(one, str) else " ".join(one),
)
def test_a_number_that_measures_nothing_is_shown_as_it_was_typed(
    in_metres: str, typed: list[str], named: str
) -> None:
    """With the option's name as help has it, not that of the request's field."""
    command, *rest = typed
    refused = RUNNER.invoke(app, [command, in_metres, *rest])
    assert refused.exit_code == 2
    assert refused.output.startswith(named)
