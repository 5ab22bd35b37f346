"""Warming up goes all the way to a measured surface and a carver's program: nothing may refuse."""

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.workbench.devices.shapes import make_stump

from limbgram.cli import warm_up, warm_up_worker
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.run import Run
from limbgram.reconstruction.matching.windows import follow
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import SMALL
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.limb import Limb

FEW = replace(SMALL, photos=9, calibration_photos=0)


@pytest.mark.slow
def test_the_second_process_measures_the_limb_and_carves_it(tmp_path: Path) -> None:
    truth = make_capture(tmp_path / "capture", FEW).truth.limb.mesh
    measured = warm_up_worker.compile_later_stages(tmp_path / "capture", tmp_path, Run(), FEW)
    assert measured is not None
    assert measured.sigma_mm is not None
    tree = TriangleTree.of(truth.vertices_mm, truth.faces)
    off_mm = tree.closest(measured.vertices_mm[np.isfinite(measured.sigma_mm)]).distances_mm
    assert 0.001 < np.median(off_mm) < 0.1  # lower: it was measured, not taken from the truth
    assert (tmp_path / "ahead.gcode").read_text("ascii").rstrip().endswith("M30")


def test_the_second_process_goes_on_where_no_capture_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm_up_worker, "_LONGEST_S", 0.0)
    monkeypatch.setattr(warm_up_worker, "work_on_shape", lambda *_: None)
    assert warm_up_worker.compile_later_stages(tmp_path / "capture", tmp_path, Run(), FEW) is None


def test_every_edit_is_tried_and_points_are_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kernels that only an edit has are compiled without anybody naming it here."""
    tried: list[type[Edit]] = []
    followed: list[float] = []

    def try_edit(limb: Limb, edit: Edit) -> Limb:
        tried.append(type(edit))
        return do_edit(limb, edit)

    def follow_points(*given: Any) -> np.ndarray:
        found = follow(*given)
        followed.extend(found[0])
        return found

    monkeypatch.setattr(warm_up_worker, "do_edit", try_edit)
    monkeypatch.setattr(warm_up_worker, "follow", follow_points)
    monkeypatch.setattr(warm_up_worker, "write_gcode", lambda *_: None)
    warm_up_worker.work_on_shape(Limb(mesh=make_stump().mesh), tmp_path / "carve.gcode")
    assert set(tried) == set(EDITS)
    np.testing.assert_allclose(followed, [64.0, 64.0, 1.0], atol=1e-3)
    assert b"POLYLINE" in (tmp_path / "carve.dxf").read_bytes()


def test_with_one_processor_there_is_no_second_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm_up, "worker_count", lambda: 1)
    monkeypatch.setattr(warm_up.subprocess, "Popen", None)
    with warm_up.second_process(tmp_path / "capture", tmp_path):
        pass


def test_the_second_process_is_gone_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[subprocess.Popen[bytes]] = []
    plain = subprocess.Popen
    monkeypatch.setattr(warm_up, "worker_count", lambda: 2)
    monkeypatch.setattr(
        warm_up.subprocess, "Popen", lambda *a, **k: started.append(plain(*a, **k)) or started[0]
    )
    with warm_up.second_process(tmp_path / "capture", tmp_path):
        assert started[0].poll() is None
    assert started[0].poll() is not None
