"""An AOP that is read, aligned and written keeps its axis, its origin and its radii."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.formats.aop.reading import read_aop
from limbgram.formats.reading import read_limb, read_shape
from limbgram.workbench.carving.radius_map import RadiusMap

pytestmark = pytest.mark.usefixtures("blank_mirror_checks")
RUNNER = CliRunner()
ROUNDING_MM = 0.0005 + 5e-6
"""Three decimals; the end slices are cut a millionth of a millimetre inside."""


def answered(*words: object) -> dict[str, Any]:
    answer = RUNNER.invoke(app, [*map(str, words), "--json"])
    assert answer.exit_code == 0, answer.output
    return json.loads(answer.stdout)


def bent_map(spokes: int = 50) -> RadiusMap:
    """A limb whose long axis is not the file's: it leans, and has a flat distal disc."""
    thetas = 360.0 / spokes * np.arange(spokes)
    z = np.concatenate([np.arange(0, 12, 1.5), np.arange(12, 180, 3.1)])
    angles = np.radians(thetas)
    radii = (
        25
        + 25 * np.sqrt(z / z[-1])[:, None]
        + 4 * np.cos(3 * angles)
        + np.outer(6 * z / z[-1], np.sin(angles - 0.7))
    )
    return RadiusMap(thetas_deg=thetas, z_mm=z, radii_mm=np.round(radii, 3))


def file_of(found: RadiusMap, first_mm: float = 0.0, thetas_listed: bool = False) -> str:
    """As a shop's program writes it: landmarks in inches, heights listed."""
    angles = [f"{theta:.6f}" for theta in found.thetas_deg]
    lines = ["AAOP1", "AAOP1", "END COMMENTS", "CYLINDRICAL", "RIGHT", "2"]
    for name, theta, slice_idx in (("Fibula Head", 10, 40), ("Knee Center", 0, 45)):
        radius = found.radii_mm[slice_idx, theta]
        lines += [name, "1", f"{radius / 25.4:.3f}", angles[theta], f"{found.z_mm[slice_idx]:.2f}"]
    spokes = len(found.thetas_deg)
    lines += [str(spokes), "0" if thetas_listed else f"{360 / spokes:.6f}"]
    lines += angles if thetas_listed else []
    lines += [str(len(found.z_mm)), "0", *(f"{z + first_mm:.4f}" for z in found.z_mm)]
    lines += [f"{radius:.3f}" for radius in found.radii_mm.ravel()]
    return "\r".join([*lines, ""])


@pytest.mark.parametrize(
    ("spokes", "first_mm", "listed"), [(50, 0.0, False), (49, 0.0, False), (72, 12.5, True)]
)
def test_radii_axis_and_origin_are_kept_and_a_second_writing_is_the_same(
    tmp_path: Path, spokes: int, first_mm: float, listed: bool
) -> None:
    own = tmp_path / "shop.aop"
    own.write_text(file_of(bent_map(spokes), first_mm, listed))
    aligned = answered("align", own, "--side", "right")
    np.testing.assert_array_equal(aligned["limb_from_mesh"]["rotation"], np.eye(3))
    assert aligned["limb_from_mesh"]["translation_mm"] == [0, 0, 0]
    assert not aligned["notes"]
    once, twice = tmp_path / "once.aop", tmp_path / "twice.aop"
    told = answered("export", own, "--to", "aop", "--side", "right", "-o", once)
    assert told["own_grid"]
    assert told["rays_mended"] == 0
    before, after = (read_aop(path.read_bytes(), path.name) for path in (own, once))
    assert np.abs(after.radius_map.radii_mm - before.radius_map.radii_mm).max() < ROUNDING_MM
    np.testing.assert_allclose(after.radius_map.z_mm, before.radius_map.z_mm, atol=1e-6)
    np.testing.assert_allclose(after.radius_map.thetas_deg, before.radius_map.thetas_deg, atol=1e-3)
    for one, two in zip(before.landmarks, after.landmarks, strict=True):
        np.testing.assert_allclose(one.position_mm, two.position_mm, atol=1.1e-3)
    answered("align", once, "--side", "right")
    answered("export", once, "--to", "aop", "--side", "right", "-o", twice)
    assert twice.read_bytes() == once.read_bytes()


def test_another_axis_is_taken_when_asked_for_and_told(tmp_path: Path) -> None:
    own = tmp_path / "shop.aop"
    own.write_text(file_of(bent_map()))
    fitted = answered("align", own, "--side", "right", "--axis", "fit")
    (note,) = fitted["notes"]
    motion = fitted["limb_from_mesh"]
    tilt_deg = np.degrees(np.arccos(motion["rotation"][2][2]))
    assert tilt_deg > 0.5
    assert note["code"] == "align.axis.not_kept"
    assert note["values"]["tilted_deg"] == pytest.approx(tilt_deg, abs=1e-6)
    assert note["values"]["along_mm"] == pytest.approx(motion["translation_mm"][2], abs=1e-6)
    sent = answered("export", own, "--to", "aop", "--side", "right", "-o", tmp_path / "new.aop")
    assert not sent["own_grid"]


def test_what_asks_for_other_radii_gets_them(tmp_path: Path) -> None:
    own = tmp_path / "shop.aop"
    own.write_text(file_of(bent_map()))
    to = ("export", own, "--to", "aop", "--side", "right", "-o", tmp_path / "new.aop")
    for words, spokes in ((("--spokes", "90"), 90), (("--spacing", "4"), 120)):
        sent = answered(*to, *words)
        assert not sent["own_grid"]
        assert sent["spokes"] == spokes
        assert sent["max_mm"] < 1.0


def test_a_front_and_a_flexion_turn_about_the_files_own_origin(tmp_path: Path) -> None:
    own = tmp_path / "shop.aop"
    own.write_text(file_of(bent_map()).replace("Fibula Head", "mark 1"))
    for words in (("--anterior", "0.3,1,0"), ("--flexion", "7")):
        told = answered("align", own, "--side", "right", *words)
        assert told["limb_from_mesh"]["translation_mm"] == pytest.approx([0, 0, 0], abs=1e-12)
        up = told["limb_from_mesh"]["rotation"][2]
        tilt_deg = 7.0 if "--flexion" in words else 0.0
        assert np.degrees(np.arccos(min(up[2], 1.0))) == pytest.approx(tilt_deg, abs=1e-4)
        own.with_name("shop.limb.json").unlink()


def test_a_file_with_a_fitted_axis_keeps_that_axis(tmp_path: Path) -> None:
    own = tmp_path / "shop.aop"
    own.write_text(file_of(bent_map()))
    fitted, once, twice = (tmp_path / f"{name}.aop" for name in ("fitted", "once", "twice"))
    to = ("--to", "aop", "--side", "right")
    answered("export", own, *to, "--axis", "fit", "-o", fitted)
    answered("align", fitted, "--side", "right")
    frame, declared = read_limb(fitted).frame, read_shape(fitted).declared
    assert declared is not None
    np.testing.assert_array_equal(
        frame.limb_from_mesh.matrix_3x4, declared.limb_from_mesh.matrix_3x4
    )
    answered("export", fitted, *to, "-o", once)
    answered("export", once, *to, "-o", twice)
    assert once.read_bytes() == twice.read_bytes() == fitted.read_bytes()


@pytest.mark.parametrize("name", ["Example.AOP", "stl_file.aop", "stl_file_2.aop"])
def test_files_of_the_trade_are_kept(tmp_path: Path, data_folder: Path, name: str) -> None:
    """An early ampscan file is a mirror image as it stands, and so is written the other way."""
    own = tmp_path / name
    own.write_bytes((data_folder / "shapes" / "ampscan" / name).read_bytes())
    side = read_aop(own.read_bytes(), name).frame.side
    side = "right" if side == "none" else side
    front = ("--anterior=+y",) if name.startswith("stl_file") else ()  # ampscan leaves it open
    aligned = answered("align", own, "--side", side, *front)
    assert aligned["limb_from_mesh"]["translation_mm"] == [0, 0, 0]
    once, twice = tmp_path / "once.aop", tmp_path / "twice.aop"
    answered("export", own, "--to", "aop", "--side", side, "-o", once)
    before, after = (read_aop(path.read_bytes(), path.name).radius_map for path in (own, once))
    assert np.abs(after.radii_mm - before.radii_mm).max() < ROUNDING_MM
    np.testing.assert_allclose(after.z_mm, before.z_mm, atol=1e-6)
    answered("align", once, "--side", side)
    answered("export", once, "--to", "aop", "--side", side, "-o", twice)
    assert twice.read_bytes() == once.read_bytes()
