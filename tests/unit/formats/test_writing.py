"""A mesh that does not read back as it was is not written."""

import os
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import ExportError
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.stl import write_stl
from limbgram.formats.writing import require_same_triangles


def test_a_missing_folder_is_told(mesh: Mesh, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="Check that the folder exists"):
        write_stl(mesh, tmp_path / "nowhere" / "surface.stl", "mm")


def test_a_byte_changed_by_the_disk_is_found(
    mesh: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sync = os.fsync

    def spoil(handle: int) -> None:
        sync(handle)
        os.pwrite(handle, np.float32(0.5).tobytes(), 84 + 50 * 7 + 12)

    monkeypatch.setattr(os, "fsync", spoil)
    with pytest.raises(ExportError, match=r"surface\.stl: a corner lies"):
        write_stl(mesh, tmp_path / "surface.stl", "mm")
    assert not list(tmp_path.iterdir())


def test_triangles_out_of_order_or_moved_are_refused(mesh: Mesh) -> None:
    exact = mesh.vertices_mm[mesh.faces]
    require_same_triangles("x", exact, mesh, 1e-9)
    for wrong in (exact[::-1], exact + 1e-6, exact[:-1], exact * [1, 1, -1]):
        with pytest.raises(ExportError):
            require_same_triangles("x", wrong, mesh, 1e-7)
