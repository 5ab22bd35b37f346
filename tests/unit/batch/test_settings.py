"""A batch file is taken strictly, and what comes with a capture cannot reach outside it."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from limbgram.batch.settings import (
    EXAMPLE,
    Align,
    ExportUse,
    RecipeUse,
    Settings,
    read_batch,
    read_settings,
    require_complete,
)
from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import declared
from limbgram.services.export import EXPORTS, Aop, Triangles
from limbgram.services.measure import MeasureRequest
from limbgram.services.reconstruct import ReconstructRequest
from limbgram.workbench.anatomy.known_kinds import KINDS


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "batch.toml"
    path.write_text(text, "utf-8")
    return path


def test_the_example_is_taken_and_shows_every_setting(tmp_path: Path) -> None:
    batch = read_batch(written(tmp_path, EXAMPLE))
    assert batch.of_all.export == (
        ExportUse(to="aop", ask=Aop()),
        ExportUse(to="stl", ask=Triangles()),
    )
    bare = re.sub(r"(?m)^# (?=[a-z_]+ = |\[)", "", EXAMPLE)
    everything = read_batch(written(tmp_path, bare))
    shown = everything.of_all
    assert [one.name for one in fields(Settings) if getattr(shown, one.name) is None] == []
    assert set(shown.reconstruct) == {one.name for one in declared(ReconstructRequest)}
    assert set(everything.of_one) == {"P07"}
    for word, names in (("kind = ", KINDS), ("[[export]]", EXPORTS)):
        line = next(line for line in EXAMPLE.splitlines() if line.startswith(word))
        assert set(names) <= set(re.findall(r"\w+", line))
    for table in (shown.align, shown.measure, shown.report, shown.recipe):
        assert table is not None
        assert all(getattr(table, one.name) != one.default for one in fields(table) if one.name
                   not in ("unaligned", "flexion_deg", "every_mm"))  # fmt: skip


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('camra = "c.json"', "camra"),
        ("part = true", "part must be a whole number"),
        ('[[export]]\nto = "igs"', r"export\[0\].to"),
        ('[align]\nsticker = "a"', "align has no sticker"),
        ("[capture.P1]\ntriangles = 5", "capture.P1.triangles"),
        ("[capture.P1]\nsides = 'left'", "capture.P1 has no sides"),
        ("capture = 3", "capture must be a table"),
        ("memory_gb = 0.1", "memory_gb must lie between 0.5 and 4096"),
        ("box_mm = [0, 0, 9, 5, 5, 5]", "box_mm has a lowest corner"),
        ("reconstruct = {part = 2}", "it has no reconstruct"),
        ("captures = 'P*'", "captures must be a list"),
        ("[measure]\nevery_mm = nan", "measure.every_mm"),
        ("a = ", "cannot be taken"),
    ],
)
def test_what_has_no_place_is_refused_with_its_place(tmp_path: Path, text: str, place: str) -> None:
    with pytest.raises(OptionsError, match=place):
        read_batch(written(tmp_path, text))


@pytest.mark.parametrize(
    "text",
    [
        'camera = "../../other.json"',
        'camera = ["ok.json", "/etc/passwd"]',
        'photos = ".."',
        'board = "C:\\\\board.json"',
        '[align]\nstickers = "a/../../b.json"',
        '[recipe]\nfile = "/r.toml"',
        '[[export]]\nto = "gcode"\nmachine = "../m.toml"',
    ],
)
def test_settings_in_a_capture_name_nothing_outside_it(tmp_path: Path, text: str) -> None:
    with pytest.raises(OptionsError, match="outside its capture"):
        read_settings(written(tmp_path, text))
    read_batch(written(tmp_path, text))  # who starts the batch may name any file


def test_later_settings_go_over_earlier_ones() -> None:
    said = {"part": 2, "triangles": 20_000}
    first = Settings(side="left", reconstruct=said, align=Align(axis="+z", anterior="+y"))
    later = Settings(side="right", reconstruct={"triangles": 30_000}, align=Align(axis="fit"))
    now = {"part": 2, "triangles": 30_000}
    assert first.overlaid(later) == Settings(side="right", reconstruct=now, align=Align(axis="fit"))


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (Settings(align=Align()), "never guessed"),
        (Settings(align=Align(), side="left", reconstruct={"unscaled": True}), "unknown size"),
        (Settings(measure=MeasureRequest()), "[measure]"),
        (Settings(recipe=RecipeUse(file="r")), "[recipe]"),
        (Settings(export=(ExportUse(to="aop", ask=Aop()),)), "aop or gcode"),
    ],
)
def test_a_step_without_what_it_needs_is_refused_before_anything_runs(
    settings: Settings, told: str
) -> None:
    with pytest.raises(OptionsError, match=re.escape(told)):
        require_complete(settings)


def test_steps_that_need_no_axes_need_no_alignment() -> None:
    require_complete(
        Settings(
            measure=MeasureRequest(unaligned=True), export=(ExportUse(to="stl", ask=Triangles()),)
        )
    )


def test_the_request_is_what_is_typed_with_files_where_they_were_found(tmp_path: Path) -> None:
    text = """
camera = "a.json"
board = "board.json"
known_distances = ["d.json", "e.json"]
tapes = ["widest=354"]
box_mm = [-80, -80, 5, 80, 80, 400]
memory_gb = 8
"""
    settings = read_settings(written(tmp_path, text))
    assert settings.request(lambda name: tmp_path / name) == ReconstructRequest(
        camera=(tmp_path / "a.json",),
        board=str(tmp_path / "board.json"),
        known_distances=(tmp_path / "d.json", tmp_path / "e.json"),
        tapes=("widest=354",),
        box_mm=((-80, -80, 5), (80, 80, 400)),
        memory_gb=8,
    )
