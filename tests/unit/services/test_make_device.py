"""A device by one act: its files, each told, and the same from its own order."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from tests.unit.workbench.devices.shapes import make_foot, make_stump
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import EditError, ExportError, LimbgramError, OptionsError
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import told
from limbgram.formats.format import MeshWriter
from limbgram.formats.glb import write_glb
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import ShapeFile, read_limb, read_mesh, read_shape
from limbgram.formats.stl import write_stl
from limbgram.services.make_device import MakeDeviceRequest, bed_from, make, preview
from limbgram.services.parse_text import ZONE
from limbgram.workbench.devices.device import Fabrication, WallZone
from limbgram.workbench.devices.order import encode_order, parse_order, read_order
from limbgram.workbench.edits.mirror import Mirror
from limbgram.workbench.frame.landmarks import landmark
from limbgram.workbench.limb import AlignedLimb
from limbgram.workbench.recipe.file import encode_recipe
from limbgram.workbench.recipe.recipe import Entry, Recipe


@pytest.fixture(scope="module")
def foot(tmp_path_factory: pytest.TempPathFactory) -> ShapeFile:
    path = write_limb(make_foot(size=0.7), tmp_path_factory.mktemp("limb") / "foot.ply")
    return read_shape(path)


ASK = MakeDeviceRequest(
    device="foot-orthosis", values=(("cup_mm", 16.0),), made="printed", lettering="R 11/26"
)


def test_all_files_are_there_and_say_that_nothing_is_tested(
    foot: ShapeFile, tmp_path: Path
) -> None:
    done = make(foot, ASK, tmp_path / "out")
    names = {path.name for path in done.written}
    assert names == {
        "foot-orthosis-R.3mf",
        "foot-orthosis-R.stl",
        "foot-orthosis-positive-R.ply",
        "foot-orthosis-drawing-R.png",
        "foot-orthosis-R.toml",
    }
    with zipfile.ZipFile(tmp_path / "out" / "foot-orthosis-R.3mf") as archive:
        model = archive.read("3D/3dmodel.model").decode()
    assert "Not strength tested" in model
    assert "claims no correction" in model
    printed = read_mesh(tmp_path / "out" / "foot-orthosis-R.3mf", 1.0)
    assert np.abs(printed.vertices_mm.min(0)).max() < 1e-4  # on the bed's corner
    assert volume_mm3(printed) / 1000 == pytest.approx(done.figures["volume_ml"], rel=1e-4)
    positive = read_limb(tmp_path / "out" / "foot-orthosis-positive-R.ply")
    assert {one.name for one in positive.landmarks} == {one.name for one in foot.limb.landmarks}
    json.dumps(done.figures, allow_nan=False)
    assert done.figures["strength_tested"] is False
    assert done.figures["watertight"] is True
    (holds,) = (told(one) for one in done.said if one.code == "edit.enclosed")
    assert holds == f"watertight: yes; volume {done.figures['volume_ml']:.1f} mL."

    again = preview(foot, MakeDeviceRequest(order=tmp_path / "out" / "foot-orthosis-R.toml"))
    ordered = done.made.preview
    assert (again.values, again.made) == (ordered.values, ordered.made)
    assert again.layout.positive.vertices_mm.tobytes() == (
        ordered.layout.positive.vertices_mm.tobytes()
    )
    np.testing.assert_array_equal(again.layout.thickness_mm, ordered.layout.thickness_mm)


def test_a_device_on_a_mirrored_positive_says_the_side_that_it_fits(
    foot: ShapeFile, tmp_path: Path
) -> None:
    mirrored = Recipe(name="", entries=(Entry(edit=Mirror(confirmed_side="left")),))
    (tmp_path / "mirror.toml").write_bytes(encode_recipe(mirrored))
    done = make(foot, replace(ASK, recipe=tmp_path / "mirror.toml"), tmp_path / "out")
    assert {path.stem[-2:] for path in done.written} == {"-L"}
    assert done.figures["side"] == "left"
    with zipfile.ZipFile(tmp_path / "out" / "foot-orthosis-L.3mf") as archive:
        assert "Foot orthosis, left" in archive.read("3D/3dmodel.model").decode()


@pytest.mark.slow
def test_from_its_order_a_device_is_made_to_the_byte(foot: ShapeFile, tmp_path: Path) -> None:
    done = make(foot, ASK, tmp_path / "out")
    order = tmp_path / "out" / "foot-orthosis-R.toml"
    again = make(foot, MakeDeviceRequest(order=order), tmp_path / "again")
    for path in done.written:
        if path.suffix in (".3mf", ".stl", ".toml"):
            assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()
    assert again.figures == done.figures


def test_a_folder_that_cannot_be_made_is_refused_before_the_work(
    foot: ShapeFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def worked(*_: object) -> NoReturn:
        raise AssertionError

    monkeypatch.setattr("limbgram.services.make_device.make_device", worked)
    in_the_way = tmp_path / "out"
    in_the_way.write_text("a file")
    for folder in (in_the_way, in_the_way / "deeper"):
        with pytest.raises(ExportError) as refused:
            make(foot, ASK, folder)
        assert refused.value.finding.code == "export.disk.no_folder"
        assert refused.value.finding.values["folder"] == str(folder)
    with pytest.raises(AssertionError):
        make(foot, ASK, tmp_path / "new" / "deeper")
    assert not (tmp_path / "new").exists()


def test_a_draped_sheet_takes_no_lettering(foot: ShapeFile, tmp_path: Path) -> None:
    ask = MakeDeviceRequest(device="foot-orthosis", made="draped", lettering="R")
    with pytest.raises(LimbgramError, match="draped") as refused:
        make(foot, ask, tmp_path / "out")
    assert refused.value.finding.code == "device.lettering.draped"
    assert not (tmp_path / "out").exists()


HEEL_ZONE = WallZone(at="heel", add_mm=2.0, reach_mm=15.0)


@pytest.mark.slow
def test_a_zone_of_the_wall_is_as_thick_as_ordered_and_nothing_else_changes(
    foot: ShapeFile, tmp_path: Path
) -> None:
    ask = replace(ASK, values=(("cup_mm", 25.0),), zones=(HEEL_ZONE,), lettering=None)
    layout = preview(foot, ask).layout
    assert isinstance(foot.limb, AlignedLimb)
    heel_mm = foot.limb.landmark_in_limb_mm(landmark(foot.limb, "heel"))
    away_mm = np.linalg.norm(layout.positive.vertices_mm - heel_mm, axis=1)
    wall_mm = 3.5
    # Ways over the surface are longer than straight ones, by little on a heel.
    assert np.allclose(layout.thickness_mm[away_mm < 13.0], wall_mm + 2.0)
    assert np.allclose(layout.thickness_mm[away_mm > 25.0], wall_mm)
    assert ((away_mm < 13.0) & (layout.beyond_mm < 0)).sum() > 20

    done = make(foot, ask, tmp_path / "out")
    assert done.made.wall.off_mm < 0.05
    assert "device.zone" in {one.code for one in done.said}
    order = tmp_path / "out" / "foot-orthosis-R.toml"
    kept = read_order(order)
    assert kept.zones == (HEEL_ZONE,)
    assert parse_order(encode_order(kept).decode(), "") == kept
    again = preview(foot, MakeDeviceRequest(order=order)).layout
    assert np.array_equal(again.thickness_mm, layout.thickness_mm)
    gone = MakeDeviceRequest(order=order, zones=(replace(HEEL_ZONE, add_mm=0.0),))
    assert np.allclose(preview(foot, gone).layout.thickness_mm, wall_mm)


@pytest.mark.parametrize(
    ("zone", "made", "code"),
    [
        (HEEL_ZONE, "draped", "device.zone.draped"),
        (replace(HEEL_ZONE, add_mm=-2.0), "printed", "device.zone.thin"),
        (replace(HEEL_ZONE, at="lateral malleolus"), "printed", "device.zone.outside"),
        (replace(HEEL_ZONE, at="nowhere"), "printed", "edit.landmark.none"),
    ],
)
def test_a_zone_that_cannot_be_is_refused(
    foot: ShapeFile, zone: WallZone, made: Fabrication, code: str
) -> None:
    values = (("cup_mm", 25.0),)
    ask = MakeDeviceRequest(device="foot-orthosis", values=values, made=made, zones=(zone,))
    with pytest.raises(EditError) as refused:
        preview(foot, ask)
    assert refused.value.finding.code == code


def test_a_zone_is_written_as_it_is_read() -> None:
    assert ZONE.read("heel=2:15", "") == HEEL_ZONE
    assert ZONE.read(ZONE.write(HEEL_ZONE), "") == HEEL_ZONE
    for text in ("heel=2", "=2:15", "heel=2:1", "heel=nan:15", "heel=13:15"):
        with pytest.raises(OptionsError, match="no zone"):
            ZONE.read(text, "")


def test_a_preview_has_handles_with_ranges(foot: ShapeFile) -> None:
    seen = preview(foot, ASK)
    named = [one for one in seen.handles if one.measure is not None]
    assert len(named) > 5
    assert all(one.least <= one.value <= one.most for one in named)  # type: ignore[operator]
    assert seen.values["cup_mm"] == 16.0
    assert len(seen.layout.thickness_mm) == len(seen.layout.positive)


def test_an_order_for_another_limb_is_refused(foot: ShapeFile, tmp_path: Path) -> None:
    order = tmp_path / "a.toml"
    order.write_text(
        'format = "limbgram device"\nversion = 1\ndevice = "ucbl"\nlimb_sha256 = "00"\n'
    )
    with pytest.raises(OptionsError) as refused:
        preview(foot, MakeDeviceRequest(order=order))
    assert refused.value.finding.code == "device.file.other_limb"
    with pytest.raises(OptionsError) as refused:
        preview(foot, MakeDeviceRequest())
    assert refused.value.finding.code == "device.none_asked"


@pytest.mark.parametrize(("kind", "write"), [("stl", write_stl), ("glb", write_glb)])
def test_a_body_without_a_plate_is_refused_and_nothing_is_written(
    foot: ShapeFile, tmp_path: Path, kind: str, write: MeshWriter
) -> None:
    lock = write(make_stump().mesh, tmp_path / f"lock.{kind}", "mm")
    ask = MakeDeviceRequest(device="foot-orthosis", join=(lock,))
    with pytest.raises(LimbgramError) as refused:
        make(foot, ask, tmp_path / "out")
    assert refused.value.finding.code == "device.part.no_plate"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("bed", ["standing", "upside-down", "lying"])
def test_it_lies_on_the_bed_unmirrored(bed: str) -> None:
    mesh = make_stump().mesh
    motion = bed_from(mesh, bed)  # type: ignore[arg-type]
    assert np.linalg.det(motion.rotation) == pytest.approx(1.0)
    assert np.abs(motion.apply(mesh.vertices_mm).min(0)).max() < 1e-9


def test_the_command_lists_devices_and_their_measures() -> None:
    told = CliRunner().invoke(app, ["device", "--list", "--device", "solid-afo"])
    assert told.exit_code == 0
    assert "ankle_lateral_mm" in told.stdout
    assert "5 to 15" in told.stdout
    every = CliRunner().invoke(app, ["device", "--list", "--json"])
    assert len(json.loads(every.stdout)["devices"]) >= 15
    refused = CliRunner().invoke(app, ["device"])
    assert refused.exit_code == 2
