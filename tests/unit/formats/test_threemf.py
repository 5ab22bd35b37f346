"""3MF: what is written lies as told and opens without repair; what is read is what is printed."""

import shutil
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.formats.reading import read_limb
from limbgram.formats.threemf import Told, read_3mf, write_3mf

BOX = trimesh.creation.box((100.0, 80.0, 200.0))
MESH = Mesh(vertices_mm=np.asarray(BOX.vertices), faces=BOX.faces.astype(np.int32))
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
START = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
OBJECT = (
    "<mesh><vertices>"
    + "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in BOX.vertices)
    + "</vertices><triangles>"
    + "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in BOX.faces)
    + "</triangles></mesh>"
)

BEYOND = OBJECT.replace('v1="', 'v1="9', 1)
FAR_BEYOND = OBJECT.replace('v1="', f'v1="{2**70}', 1)


def archive(model: str, **others: str) -> bytes:
    """A file of another program."""
    stream = BytesIO()
    relation = f'<Relationship Target="/3D/a.model" Id="r" Type="{START}"/>'
    with zipfile.ZipFile(stream, "w") as made:
        made.writestr("_rels/.rels", f'<Relationships xmlns="x">{relation}</Relationships>')
        made.writestr("3D/a.model", model)
        for name, content in others.items():
            made.writestr(f"3D/{name}.model", content)
    return stream.getvalue()


def model(objects: str, build: str, given: str = "") -> str:
    return (
        f'<model xmlns="{CORE}" {given}><resources>{objects}</resources>'
        f"<build>{build}</build></model>"
    )


def test_it_says_its_unit_and_nothing_of_whom_or_when(tmp_path: Path) -> None:
    told = Told(title="Solid AFO", description="Not strength tested <5 %")
    path = write_3mf(MESH, tmp_path / "a.3mf", "mm", told=told)
    with zipfile.ZipFile(path) as written:
        assert {entry.date_time for entry in written.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        text = written.read("3D/3dmodel.model").decode()
    assert 'unit="millimeter"' in text
    assert text.count("<metadata ") == 3
    assert 'name="Description">Not strength tested &lt;5 %<' in text


def test_the_same_mesh_gives_the_same_bytes(tmp_path: Path) -> None:
    one = write_3mf(MESH, tmp_path / "a.3mf", "mm").read_bytes()
    assert one == write_3mf(MESH, tmp_path / "b.3mf", "mm").read_bytes()


def test_it_is_read_as_it_lies_on_the_bed(tmp_path: Path) -> None:
    motion = Rigid.from_rotation_vector(np.array([0.3, 0.2, -1.0]), np.array([5.0, 60.0, 7.0]))
    path = write_3mf(MESH, tmp_path / "a.3mf", "mm", told=Told(bed_from_mesh=motion))
    read = read_3mf(path.read_bytes(), "a").mesh
    np.testing.assert_allclose(read.vertices_mm, motion.apply(MESH.vertices_mm), atol=2e-6)


@pytest.mark.parametrize(
    ("unit", "mm"), [("micron", 0.001), ("inch", 25.4), ("foot", 304.8), ("meter", 1000.0)]
)
def test_units_of_other_programs_become_millimetres(unit: str, mm: float) -> None:
    build = '<item objectid="1"/>'
    content = archive(model(f'<object id="1">{OBJECT}</object>', build, f'unit="{unit}"'))
    read = read_3mf(content, "a").mesh
    np.testing.assert_allclose(volume_mm3(read), 1.6e6 * mm**3, rtol=1e-9)


@pytest.mark.parametrize("said_mm", [None, 25.4])
def test_who_says_the_files_own_unit_does_not_convert_it_twice(
    tmp_path: Path, said_mm: float | None
) -> None:
    build = '<item objectid="1" transform="0.025 0 0 0 0.025 0 0 0 0.025 0 0 0"/>'
    content = archive(model(f'<object id="1">{OBJECT}</object>', build, 'unit="inch"'))
    (tmp_path / "arm.3mf").write_bytes(content)
    limb = read_limb(tmp_path / "arm.3mf", said_mm)
    np.testing.assert_allclose(np.ptp(limb.mesh.vertices_mm, axis=0), [63.5, 50.8, 127.0])


def test_components_are_placed_and_a_mirrored_one_stays_outward() -> None:
    mirrored = "-1 0 0 0 1 0 0 0 1 300 0 0"
    objects = (
        f'<object id="1">{OBJECT}</object><object id="2"><components>'
        f'<component objectid="1"/><component objectid="1" transform="{mirrored}"/>'
        '</components></object><object id="3" type="support">' + OBJECT + "</object>"
    )
    build = '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 10"/><item objectid="3"/>'
    read = read_3mf(archive(model(objects, build)), "a").mesh
    assert len(read.faces) == 24
    np.testing.assert_allclose(volume_mm3(read), 3.2e6)
    low, high = read.vertices_mm.min(0), read.vertices_mm.max(0)
    np.testing.assert_allclose(low, [-40, -50, -90])  # x to y, and up by 10
    np.testing.assert_allclose(high, [40, 350, 110])


def test_an_item_that_a_slicer_leaves_out_is_none_of_the_surface() -> None:
    objects = f'<object id="1">{OBJECT}</object>'
    aside = '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 300 0 0" printable="{}"/>'
    for printable, size_mm in (("0", 100.0), ("false", 100.0), ("1", 400.0)):
        build = '<item objectid="1"/>' + aside.format(printable)
        read = read_3mf(archive(model(objects, build)), "a").mesh
        assert np.ptp(read.vertices_mm[:, 0]) == pytest.approx(size_mm)
    with pytest.raises(ShapeFileError, match="nothing that it prints"):
        read_3mf(archive(model(objects, aside.format("0"))), "a")


def test_parts_beside_the_first_are_read() -> None:
    production = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
    given = f'xmlns:p="{production}" requiredextensions="p"'
    objects = (
        '<object id="9"><components><component objectid="1" p:path="/3D/b.model"/>'
        "</components></object>"
    )
    content = archive(
        model(objects, '<item objectid="9"/>', given),
        b=model(f'<object id="1">{OBJECT}</object>', ""),
    )
    np.testing.assert_allclose(volume_mm3(read_3mf(content, "a").mesh), 1.6e6)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (archive(model(f'<object id="1">{OBJECT}</object>', "")), "file.3mf.empty"),
        (archive(model("", '<item objectid="7"/>')), "file.3mf.no_object"),
        (archive("<other/>"), "file.3mf.no_model"),
        (archive("<!DOCTYPE a>" + model("", "")), "file.3mf.doctype"),
        (
            archive(model("", "", 'xmlns:q="https://lattice" requiredextensions="q"')),
            "file.3mf.extension",
        ),
        (
            archive(
                model(
                    '<object id="1"><components><component objectid="1"/></components></object>',
                    '<item objectid="1"/>',
                )
            ),
            "file.3mf.deep",
        ),
        (
            archive(
                model(
                    f'<object id="1">{BEYOND}</object>',
                    '<item objectid="1"/>',
                )
            ),
            "file.face.vertex",
        ),
        (
            archive(model(f'<object id="1">{FAR_BEYOND}</object>', '<item objectid="1"/>')),
            "file.face.vertex",
        ),
        (archive(model(OBJECT, '<item objectid="1"/>')), "file.3mf.outside"),
        (b"PK\x03\x04 cut off", None),
    ],
)
def test_what_is_no_surface_is_refused(content: bytes, code: str | None) -> None:
    with pytest.raises(ShapeFileError) as refused:
        read_3mf(content, "a")
    assert refused.value.finding.code == "file.3mf.damaged"
    if code is not None:
        assert refused.value.finding.values["why"].code == code


@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="PrusaSlicer is not installed")
def test_prusaslicer_opens_it_without_a_repair(tmp_path: Path) -> None:
    path = write_3mf(MESH, tmp_path / "a.3mf", "mm", told=Told(title="A box"))
    done = subprocess.run(
        ["prusa-slicer", "--info", str(path)], capture_output=True, text=True, check=True
    )
    said = done.stdout
    assert "manifold = yes" in said
    assert "size_z = 200.000" in said
    assert "number_of_facets = 12" in said.replace("  ", " ")
    assert "repaired" not in said
