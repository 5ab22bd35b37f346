"""What leaves a case is the shape that was asked for, whatever else is made at the same time."""

import json
import shutil
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from limbgram.app.shape_cache import ShapeCache
from limbgram.cases import case_export, shape_record
from limbgram.cases.case_export import (
    ExportOptions,
    export_shape,
    exported_files,
    unreadable_exports,
)
from limbgram.cases.shape_record import shape_record_of
from limbgram.cases.shelf import Shelf
from limbgram.cases.workspace import Work, Workspace
from limbgram.core.files import read_content
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb
from limbgram.formats.sidecar import limb_file_beside
from limbgram.report.record.record import RecordOptions
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.services.export import Aop
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.recipe.recipe import Entry

OFFSETS_MM = (-2.0, 1.0)
"""Of two shapes of one scan, which are made at the same time."""
ROUNDS = 3
STL = ExportOptions(kind="stl", side="left")

pytestmark = pytest.mark.usefixtures("blank_mirror_checks")


def capsule() -> Mesh:
    """Half a ball of 40 mm below a tube up to 160 mm."""
    polar = np.linspace(0, np.pi / 2, 16)
    z_mm = np.concatenate([40 * (1 - np.cos(polar)), np.linspace(40, 160, 21)[1:]])
    radii_mm = np.concatenate([40 * np.sin(polar), np.full(20, 40.0)])
    spokes = 72
    return RadiusMap(
        thetas_deg=360 / spokes * np.arange(spokes),
        z_mm=z_mm,
        radii_mm=np.tile(radii_mm[:, None], (1, spokes)),
    ).surface()


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    """An aligned case."""
    case = Shelf(tmp_path).new_case("transtibial", "left")
    case.folder.deliverables.mkdir()
    write_ply(capsule(), case.folder.deliverables / "surface.ply", "mm")
    workspace = Workspace(case)
    read, up, front = workspace.read(), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    workspace.save_limb(
        align(read.limb, AlignOptions(side="left", proximal=up, anterior=front)), read
    )
    return workspace


@pytest.fixture
def works(workspace: Workspace) -> tuple[Work, ...]:
    """The case with one recipe and with the other."""
    shape_cache = ShapeCache()

    def work(offset_mm: float) -> Work:
        entry = Entry(edit=Offset(distance_mm=offset_mm))
        with shape_cache.changing(workspace):
            workspace.save_recipe(replace(workspace.recipe(), entries=(entry,)))
            return shape_cache.work(workspace)

    return tuple(work(offset_mm) for offset_mm in OFFSETS_MM)


def in_two_threads(workspace: Workspace, act: Callable[[int], None]) -> None:
    """Do it for both works, again and again, always at the same time and from the start."""

    def clear() -> None:
        shutil.rmtree(workspace.files, ignore_errors=True)
        for derived in workspace.root.glob("rectified*"):
            derived.unlink()

    together = threading.Barrier(2, clear)

    def again(which: int) -> None:
        try:
            for _ in range(ROUNDS):
                together.wait(60)
                act(which)
        except Exception:
            together.abort()  # the other one does not wait
            raise

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(again, (0, 1)))


def test_two_shapes_that_are_exported_at_once_do_not_mix(
    workspace: Workspace, works: tuple[Work, ...]
) -> None:
    wanted = [volume_mm3(one.done.limb.mesh) for one in works]
    assert wanted[1] / wanted[0] > 1.05

    def export(which: int) -> None:
        exported = export_shape(workspace, works[which], STL)
        file = workspace.files / exported.name
        assert volume_mm3(read_limb(file).mesh) == pytest.approx(wanted[which], rel=1e-5)
        kept = json.loads((workspace.files / f"{exported.name}.json").read_text("utf-8"))
        assert kept["recipe_sha256"] == works[which].recipe_sha256

    in_two_threads(workspace, export)


def test_a_record_is_of_one_shape_and_its_own_recipe(
    workspace: Workspace, works: tuple[Work, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the same case is exported after another recipe, which is the present one by then."""
    wanted = [volume_mm3(one.done.limb.mesh) for one in works]
    filed: list[tuple[ShapeSource, ShapeSource, RecipeSource]] = []

    def file(
        shape: ShapeSource,
        scan: ShapeSource,
        recipe: RecipeSource,
        _case: CaseSource | None,
        _options: RecordOptions,
    ) -> None:
        filed.append((shape, scan, recipe))

    monkeypatch.setattr(shape_record, "record_of", file)

    def act(which: int) -> None:
        if which:
            export_shape(workspace, works[1], STL)
        else:
            shape_record_of(workspace, works[0])

    in_two_threads(workspace, act)
    assert len(filed) == ROUNDS
    for shape, scan, recipe in filed:
        assert volume_mm3(shape.limb.mesh) == pytest.approx(wanted[0], rel=1e-5)
        assert scan.sha256 == works[0].scan.sha256
        assert recipe.recipe == works[0].recipe
        assert recipe.sha256 == works[0].recipe_sha256 != works[1].recipe_sha256


def test_files_that_were_asked_for_otherwise_have_other_names(
    workspace: Workspace, works: tuple[Work, ...]
) -> None:
    def aop(spokes: int, spacing_mm: float) -> ExportOptions:
        ask = Aop(spokes=spokes, spacing_mm=spacing_mm)
        return ExportOptions(kind="aop", side="left", ask=ask)

    asked = [aop(60, 4.0), aop(72, 4.0), aop(60, 5.0)]
    made = [export_shape(workspace, works[0], options) for options in asked]
    assert len({one.name for one in made}) == 3
    assert [one.said[0].values["spokes"] for one in made] == [60, 72, 60]
    before = {file: file.stat().st_mtime_ns for file in workspace.files.iterdir()}
    assert [export_shape(workspace, works[0], options) for options in asked] == made
    assert {file: file.stat().st_mtime_ns for file in workspace.files.iterdir()} == before
    assert {one.name for one in exported_files(workspace)} == {one.name for one in made}


def test_what_cannot_be_read_of_a_file_is_told_and_kept_beside_the_new_one(
    workspace: Workspace, works: tuple[Work, ...]
) -> None:
    signed = replace(STL, signed_by="A. Meier, by the tape")
    made = export_shape(workspace, works[0], signed)
    told = workspace.files / f"{made.name}.json"
    whole = told.read_bytes()
    assert unreadable_exports(workspace) == ()
    told.write_bytes(whole[:-9])
    (unread,) = unreadable_exports(workspace)
    assert (unread.code, unread.values["file"]) == ("kept.unreadable", told.name)
    again = export_shape(workspace, works[0], signed)
    assert replace(again, made=made.made) == made
    (aside,) = workspace.files.glob("*.unreadable-*.json")
    assert aside.read_bytes() == whole[:-9]
    assert [one.values["file"] for one in unreadable_exports(workspace)] == [aside.name]
    assert exported_files(workspace) == (again,)


def test_what_was_read_back_of_a_file_is_read_again_only_where_it_changed(
    workspace: Workspace, works: tuple[Work, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = export_shape(workspace, works[0], STL)
    told = workspace.files / f"{made.name}.json"
    assert exported_files(workspace) == (made,)
    read: list[str] = []

    def counted(path: Path, *given: Any) -> bytes:
        read.append(path.name)
        return read_content(path, *given)

    monkeypatch.setattr(case_export, "read_content", counted)
    for _ in range(3):
        assert unreadable_exports(workspace) == ()
        assert exported_files(workspace) == (made,)
    assert read == []
    told.write_bytes(told.read_bytes() + b"\n")
    assert exported_files(workspace) == (made,)
    assert read == [told.name]


def rectified(workspace: Workspace) -> set[str]:
    return {one.name for one in workspace.root.glob("rectified-*.ply")}


def test_shapes_of_before_go_but_those_that_files_were_made_of(
    workspace: Workspace, works: tuple[Work, ...]
) -> None:
    first, second = (one.done.limb for one in works)
    tried = workspace.rectified(first)
    present = workspace.rectified(second)
    assert rectified(workspace) == {present.name}, "nothing was made of the first"
    assert not limb_file_beside(tried).exists()
    exported = export_shape(workspace, works[0], STL)
    assert exported.shape == tried.name
    assert rectified(workspace) == {tried.name}
    workspace.rectified(second)
    assert rectified(workspace) == {tried.name, present.name}, "the file is made of the first"

    other = second.with_mesh(second.mesh.with_vertices(second.mesh.vertices_mm + 1.0))
    later = workspace.rectified(other)
    assert rectified(workspace) == {tried.name, later.name}, "nothing was made of the second"
    later.unlink()
    present = workspace.rectified(second)

    # What was written before the shape was cited may be made of any that is there.
    file = workspace.files / f"{exported.name}.json"
    tree = json.loads(file.read_text("utf-8"))
    del tree["shape"]
    file.write_text(json.dumps(tree), "utf-8")
    present.unlink()
    workspace.rectified(second)
    assert rectified(workspace) == {tried.name, present.name}


@pytest.mark.parametrize("lost", ["shape", "limb file"])
def test_a_shape_that_was_lost_is_written_again(
    workspace: Workspace, works: tuple[Work, ...], lost: str
) -> None:
    path = workspace.rectified(works[0].done.limb)
    both = [path, limb_file_beside(path)]
    whole = [one.read_bytes() for one in both]
    both[lost != "shape"].unlink()
    assert workspace.rectified(works[0].done.limb) == path
    assert [one.read_bytes() for one in both] == whole


def test_a_file_that_was_damaged_is_made_again(
    workspace: Workspace, works: tuple[Work, ...]
) -> None:
    made = export_shape(workspace, works[0], STL)
    (workspace.files / made.name).write_bytes(b"solid")
    again = export_shape(workspace, works[0], STL)
    assert (again.name, again.sha256) == (made.name, made.sha256)
    assert (workspace.files / made.name).stat().st_size == made.bytes
