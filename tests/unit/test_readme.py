"""What the README shows of Python runs as it stands there."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import limbgram.cases.camera_file
import limbgram.pipeline
from limbgram.scale.metric import Scale
from limbgram.surface import Mesh

README = Path(__file__).parents[2] / "README.md"


def test_its_program_writes_the_limb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    corner = Mesh(vertices_mm=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4)
    done = SimpleNamespace(mesh=corner, metric=SimpleNamespace(scale=scale))
    monkeypatch.setattr(limbgram.pipeline, "reconstruct", lambda _capture: done)
    monkeypatch.setattr(limbgram.cases.camera_file, "read_camera", lambda _path: object())
    monkeypatch.chdir(tmp_path)
    (program,) = re.findall(r"```python\n(.*?)```", README.read_text("utf-8"), re.DOTALL)
    exec(program, {})
    assert (tmp_path / "limb.stl").stat().st_size == 84 + 50
