"""Deliverables: no surface leaves a case that folds over or through itself."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import trimesh

from limbgram.cases.deliverables import deliver
from limbgram.core.errors import ExportError
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.pipeline import Reconstruction


def _ball() -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=50)
    return Mesh(vertices_mm=np.asarray(ball.vertices), faces=ball.faces.astype(np.int32))


def _with_a_thorn() -> Mesh:
    mesh = _ball()
    vertices = mesh.vertices_mm.copy()
    vertices[int(vertices[:, 0].argmax())] += (40.0, 0, 0)
    return mesh.with_vertices(vertices)


@pytest.mark.parametrize("part", ["the one that was meant", "another one"])
def test_a_folded_surface_is_not_delivered(tmp_path: Path, part: str) -> None:
    meshes = (
        (_with_a_thorn(), _ball())
        if part == "the one that was meant"
        else (_ball(), _with_a_thorn())
    )
    done = SimpleNamespace(mesh=meshes[0], others=(SimpleNamespace(mesh=meshes[1]),))
    with pytest.raises(ExportError, match=r"at 1 place, the first near \(90\.0, 0\.0, 0\.0\) mm"):
        deliver(cast(Reconstruction, done), tmp_path / "deliverables", unscaled=False)
    assert not (tmp_path / "deliverables").exists()
