"""A capture and the case that the command line makes of it, which several files try."""

import io
import json
import os
import shutil
import signal
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np
import pytest
from typer.testing import CliRunner

from limbgram.cases import job_supervision
from limbgram.cases.child_process import NO_MORE, Event
from limbgram.cases.job_messages import read_job
from limbgram.cases.job_worker import Events, work
from limbgram.cli.main import app
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.options import SMALL

FINISHED = replace(SMALL, photos=14, width_px=600, height_px=400)
"""A pixel is 1.0 mm of the limb."""
_LONGEST_S = 900.0


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders capture and case, and camera.json; spaces and umlauts in its name.

    It is made once for all processes that run tests. What changes it works on a copy.
    """
    root = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent
    return _made_once(root / "finished" / "Fuß links0", _finish)


@pytest.fixture(scope="module")
def folder(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of it for the tests of one file, in a folder of the same name."""
    return shutil.copytree(finished, tmp_path_factory.mktemp("copy") / finished.name)


@pytest.fixture
def jobs_in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs are done in the process of the tests: a process of their own costs 2.5 s to start."""
    monkeypatch.setattr(job_supervision, "ChildProcess", _JobInProcess)


@pytest.fixture(scope="session")
def lens_of() -> Callable[[Capture], Calibration]:
    """Of a capture: its true lens, as a calibration board would have told it."""

    def told(capture: Capture) -> Calibration:
        covariance = np.diag([1.0, 1.0, 1.0, 1.0, 0.0, 1e-6, 1e-6, 1e-8, 1e-8, 0.0])
        camera = capture.truth.views[0].camera
        return Calibration(camera=camera, covariance=covariance, source="board")

    return told


class _JobInProcess:
    """A job done at once, and all its events; stands for `ChildProcess` and for its process."""

    pid = os.getpid()

    def __init__(self, _command: Sequence[str], order: str, _errors: IO[bytes]) -> None:
        before = signal.getsignal(signal.SIGTERM)
        stop, _ = os.pipe()  # stays open: the end of it would end this process
        told = io.StringIO()
        self._code = work(read_job(json.loads(order), Path.cwd()), Events(told), stop)
        signal.signal(signal.SIGTERM, before)
        self._events = iter([json.loads(line) for line in told.getvalue().splitlines()])
        self.process = self

    def event(self, _within_s: float) -> Event:
        return next(self._events, NO_MORE)

    def wait(self) -> int:
        return self._code

    def kill(self) -> None:
        """It has ended."""


def _finish(folder: Path) -> None:
    make_capture(folder / "capture", FINISHED)
    camera = folder / "camera.json"
    board = ("--board", "14x10", "--square", "10")
    calibration, images = (str(folder / "capture" / name) for name in ("calibration", "images"))
    for words in (
        ("calibrate", calibration, *board, "-o", str(camera)),
        ("reconstruct", images, "--camera", str(camera), "-o", str(folder / "case")),
    ):
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 0, result.output


def _made_once(folder: Path, make: Callable[[Path], None]) -> Path:
    """A folder that the first process makes; the others wait for it."""
    made = folder.with_name(f"{folder.name}, made")
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        deadline = time.monotonic() + _LONGEST_S
        while not made.exists():
            assert time.monotonic() < deadline, f"nobody made {folder}"
            time.sleep(0.2)
    else:
        try:
            make(folder)
        except BaseException:
            made.write_text(traceback.format_exc(), "utf-8")
            raise
        made.touch()
    assert (failure := made.read_text("utf-8")) == "", failure
    return folder
