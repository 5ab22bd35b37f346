"""Comparisons of real limb scans whose relation is known."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid
from limbgram.formats.reading import read_limb
from limbgram.workbench.compare.comparison import compare
from limbgram.workbench.compare.messages import verdict
from limbgram.workbench.compare.registration import by_shape


@pytest.fixture(scope="module")
def scans(data_folder: Path) -> Path:
    return data_folder / "shapes" / "ampscan"


def test_a_scan_and_its_radius_map_are_one_limb(scans: Path) -> None:
    """5 degrees by 2.6 mm of spokes cost some tenths of a millimetre, and no size."""
    found = compare(read_limb(scans / "stl_file.stl"), read_limb(scans / "stl_file.aop"))
    assert found.radial is not None
    assert abs(found.radial.mre_mm) < 0.1
    assert 0.02 < found.deviation.on_first.figures.rms_mm < 0.4
    assert verdict(found).grade in ("alike", "differs in places")


@pytest.mark.parametrize("seed", [1, 2])
def test_another_scan_lands_at_the_same_place_from_anywhere(scans: Path, seed: int) -> None:
    first, second = read_limb(scans / "stl_file.stl"), read_limb(scans / "stl_file_2.stl")
    lying = Rigid(Rotation.random(random_state=seed).as_matrix(), np.array([80.0, -30, 200]))
    moved = second.with_mesh(second.mesh.with_vertices(lying.apply(second.mesh.vertices_mm)))
    near = by_shape(first, second).first_from_second
    far = by_shape(first, moved).first_from_second @ lying
    off = near.apply(second.mesh.vertices_mm) - far.apply(second.mesh.vertices_mm)
    assert np.abs(off).max() < 0.02
