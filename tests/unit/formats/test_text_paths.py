"""The verbs of the library that take a path take it as a text too."""

from inspect import isfunction, signature
from pathlib import Path

import numpy as np
import pytest

import limbgram as lg

VERBS = [
    (name, par.annotation)
    for name in sorted(lg.__all__)
    if isfunction(verb := getattr(lg, name)) and name.startswith(("read_", "write_", "make_"))
    for par in signature(verb).parameters.values()
    if par.name in ("path", "mesh_path", "folder")
]


@pytest.mark.parametrize(("name", "annotation"), VERBS)
def test_each_says_that_it_takes_a_text(name: str, annotation: object) -> None:
    assert annotation == Path | str, name


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_a_shape_is_written_and_read(ending: str, mesh: lg.Mesh, tmp_path: Path) -> None:
    path = f"{tmp_path}/shape.{ending}"
    write = getattr(lg, f"write_{ending}")
    assert write(mesh, path, "mm") == Path(path)
    found = lg.read_limb(path).mesh
    assert len(found.faces) == len(mesh.faces)
    assert np.ptp(found.vertices_mm) == pytest.approx(np.ptp(mesh.vertices_mm), rel=1e-4)


def test_a_limb_and_its_record_are_written_and_read(mesh: lg.Mesh, tmp_path: Path) -> None:
    path = f"{tmp_path}/limb.ply"
    lg.write_limb(lg.Limb(mesh=mesh), path)
    lg.write_limb_file(lg.Limb(mesh=mesh, sock_mm=1.5), path)
    assert lg.read_shape(path).limb.sock_mm == 1.5


def test_sections_are_written(mesh: lg.Mesh, tmp_path: Path) -> None:
    assert lg.write_dxf(mesh, f"{tmp_path}/a.dxf", "mm") == tmp_path / "a.dxf"


def test_a_machine_is_written_and_read(tmp_path: Path) -> None:
    machine = lg.Machine(control=lg.Control(), carving=lg.CarveOptions())
    lg.write_machine(machine, f"{tmp_path}/machine.toml")
    assert lg.read_machine(f"{tmp_path}/machine.toml") == machine


@pytest.mark.parametrize("name", ["read_camera", "read_machine", "read_recipe", "read_template"])
def test_what_is_not_there_is_refused_by_its_name(name: str, tmp_path: Path) -> None:
    with pytest.raises(lg.LimbgramError, match="none cannot be read"):
        getattr(lg, name)(f"{tmp_path}/none")


def test_a_capture_takes_no_place_of_another_folder(tmp_path: Path) -> None:
    with pytest.raises(lg.LimbgramError, match="there already"):
        lg.make_capture(str(tmp_path))
