"""What a surface knows of its errors goes into files and comes back."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.glb import write_glb
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb


def uncertain(mesh: Mesh) -> Mesh:
    random = np.random.default_rng(5)
    sigma = random.uniform(0.01, 0.2, len(mesh)).astype(np.float32)
    sigma[3] = np.nan
    shared = random.normal(size=(len(mesh), 3)).astype(np.float32)
    lost = random.uniform(0, 1e-3, (len(mesh), 2)).astype(np.float32)
    across = random.normal(0, 1e-3, (len(mesh), 3)).astype(np.float32)
    return replace(
        mesh,
        sigma_mm=sigma,
        shared_mm=shared,
        correlation_mm=1.0 / 3.0,
        lost_length=lost,
        lost_across=across,
    )


def test_ply_keeps_sigmas_shared_errors_and_their_reach(mesh: Mesh, tmp_path: Path) -> None:
    known = uncertain(mesh)
    read = read_limb(write_ply(known, tmp_path / "limb.ply", "mm")).mesh
    assert read.sigma_mm is not None
    assert read.shared_mm is not None
    assert known.sigma_mm is not None
    np.testing.assert_array_equal(read.sigma_mm, known.sigma_mm)
    np.testing.assert_array_equal(read.shared_mm, known.shared_mm)
    assert read.correlation_mm == known.correlation_mm
    np.testing.assert_array_equal(read.lost_length, known.lost_length)
    np.testing.assert_array_equal(read.lost_across, known.lost_across)


def test_glb_keeps_sigmas(mesh: Mesh, tmp_path: Path) -> None:
    known = uncertain(mesh)
    read = read_limb(write_glb(known, tmp_path / "limb.glb", "mm")).mesh
    assert read.sigma_mm is not None
    assert known.sigma_mm is not None
    np.testing.assert_allclose(read.sigma_mm, known.sigma_mm, rtol=1e-6)
    assert np.isnan(read.sigma_mm[3])
