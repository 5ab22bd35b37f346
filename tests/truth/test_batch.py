"""A capture in a batch becomes what it becomes alone, to the byte, killed on the way or not."""

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from typer.testing import CliRunner

from limbgram.batch import attempt as attempting
from limbgram.cases.child_process import Event
from limbgram.cases.job_supervision import Supervision
from limbgram.cli.main import app

SETTINGS = """
camera = "camera.json"
side = "left"
[align]
axis = "+z"
anterior = "+y"
[measure]
every_mm = 20
[[export]]
to = "obj"
"""
TIMED = ("case.json", "summary.json", "report.html", "stage.json", "log.txt", ".lock", "done.json")


def limbgram(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture(scope="module")
def folder(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Photos as a folder and as a zip, a camera, settings; and what they become alone."""
    folder = tmp_path_factory.mktemp("many")
    inside = folder / "in"
    inside.mkdir()
    shutil.copy(finished / "camera.json", inside)
    shutil.copytree(finished / "capture" / "images", inside / "Fuß 1")
    shutil.make_archive(str(inside / "P2"), "zip", finished / "capture", "images")
    (inside / "batch.toml").write_text(SETTINGS, "utf-8")
    alone = folder / "alone"
    shutil.copytree(finished / "case", alone)
    surface = alone / "deliverables" / "surface.ply"
    done = limbgram("align", surface, "--side", "left", "--axis=+z", "--anterior=+y")
    assert done.exit_code == 0, done.output
    done = limbgram("export", surface, "--to", "obj", "--side", "left", "-o", folder / "alone.obj")
    assert done.exit_code == 0, done.output
    return folder


def contents(case: Path) -> dict[str, str]:
    """Hashes of all files of a case, but of those that hold times and of what a batch adds."""
    return {
        path.relative_to(case).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(case.rglob("*"))
        if path.is_file() and path.name not in TIMED and path.relative_to(case).parts[0] != "batch"
    }


def outcomes(folder: Path) -> dict[str, Any]:
    kept = json.loads((folder / "out" / "batch.json").read_text("utf-8"))
    return {one["name"]: one for one in kept["captures"]}


@pytest.mark.slow
def test_alone_in_a_batch_and_killed_on_the_way_the_bytes_are_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    killed: list[str] = []

    class Killed(Supervision):
        """Kills the process of the first capture once, in the midst of a stage."""

        def wait(self) -> Any:
            plain = self.listener

            def heard(event: Event) -> None:
                plain(event)
                name = self.job.case.name
                if event.get("stage") == "estimate depth" and name == "Fuß 1" and not killed:
                    killed.append(name)
                    assert self._process is not None
                    self._process.kill()

            self.listener = heard
            return super().wait()

    monkeypatch.setattr(attempting, "Supervision", Killed)
    done = limbgram("batch", folder / "in", "-o", folder / "out", "--at-once", 2)
    assert done.exit_code == 0, done.output
    assert killed == ["Fuß 1"]
    found = outcomes(folder)
    assert {name: one["attempts"] for name, one in found.items()} == {"Fuß 1": 2, "P2": 1}
    alone = contents(folder / "alone")
    assert len(alone) > 50
    for name in found:
        assert contents(folder / "out" / name) == alone
        obj = folder / "out" / name / "batch" / "export-1-obj" / f"{name}-L.obj"
        assert obj.read_bytes() == (folder / "alone.obj").read_bytes()
    assert not list((folder / "out" / ".unpacked").iterdir())


@pytest.mark.slow
def test_a_second_run_computes_only_what_changed(folder: Path) -> None:
    words = ("batch", folder / "in", "-o", folder / "out")
    assert limbgram(*words, "--only", "P2").exit_code == 0
    assert limbgram(*words, "--only", "P2").exit_code == 0
    assert outcomes(folder)["P2"]["state"] == "unchanged"

    (folder / "in" / "batch.toml").write_text(SETTINGS.replace("20", "30"), "utf-8")
    before = contents(folder / "out" / "P2")
    assert limbgram(*words, "--only", "P2").exit_code == 0
    steps = {step["name"]: step["state"] for step in outcomes(folder)["P2"]["steps"]}
    assert steps == {"align": "kept", "measure": "done", "export-1-obj": "kept"}
    assert contents(folder / "out" / "P2") == before

    limb_file = folder / "out" / "P2" / "deliverables" / "surface.limb.json"
    surface = limb_file.with_name("surface.ply")
    by_hand = limbgram("align", surface, "--side", "left", "--axis=+z", "--anterior=+x")
    assert by_hand.exit_code == 0, by_hand.output
    corrected = limb_file.read_bytes()
    assert limbgram(*words, "--only", "P2").exit_code == 0
    steps = {step["name"]: step["state"] for step in outcomes(folder)["P2"]["steps"]}
    assert steps == {"align": "kept", "measure": "done", "export-1-obj": "done"}
    assert "by hand" in outcomes(folder)["P2"]["steps"][0]["message"]
    assert limb_file.read_bytes() == corrected

    assert limbgram(*words, "--only", "P2").exit_code == 0
    assert outcomes(folder)["P2"]["state"] == "unchanged"
    (folder / "out" / "P2" / "deliverables" / "surface.stl").write_bytes(b"damaged")
    assert limbgram(*words, "--only", "P2").exit_code == 0
    assert outcomes(folder)["P2"]["state"] == "finished"
    alone = (folder / "alone" / "deliverables" / "surface.stl").read_bytes()
    assert (folder / "out" / "P2" / "deliverables" / "surface.stl").read_bytes() == alone
