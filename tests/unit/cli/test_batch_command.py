"""`limbgram batch` plans before it computes, and says what is wrong with which capture."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from typer.testing import CliRunner

from limbgram.cli.main import app


def batch(*words: object) -> Result:
    return CliRunner().invoke(app, ["batch", *(str(word) for word in words)])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three captures without photos that could be used."""
    folder = tmp_path / "in"
    for name in ("P1", "P2", "P3"):
        (folder / name).mkdir(parents=True)
    return folder


def planned(folder: Path, *words: object) -> tuple[int, dict[str, Any]]:
    done = batch(folder, "-o", folder.parent / "out", "--dry-run", "--json", *words)
    return done.exit_code, json.loads(done.stdout)


def test_a_dry_run_computes_nothing_and_names_what_would_be_done(folder: Path) -> None:
    (folder / "batch.toml").write_text('side = "left"\n[align]\naxis = "+z"\n[measure]\n')
    (folder / "P2" / "capture.toml").write_text('camera = "none.json"')
    (folder / "P3" / "capture.toml").write_text('camra = "none.json"')
    code, told = planned(folder)
    assert code == 2
    assert [one["steps"] for one in told["captures"]] == [["align", "measure"], [], []]
    assert "none.json is not there" in told["captures"][1]["refusal"]
    assert "camra" in told["captures"][2]["refusal"]
    german = {"LIMBGRAM_LANGUAGE": "de"}
    words = ["batch", str(folder), "-o", str(folder.parent / "out"), "--dry-run"]
    assert "none.json ist nicht da." in CliRunner().invoke(app, words, env=german).stdout
    assert not (folder.parent / "out").exists()


def test_jobs_that_share_the_work_leave_none_out_and_do_none_twice(folder: Path) -> None:
    names = [
        one["name"]
        for number in (1, 2)
        for one in planned(folder, "--part", f"{number}/2")[1]["captures"]
    ]
    assert names == ["P1", "P3", "P2"]
    assert planned(folder, "--part", "5/5")[1]["captures"] == []


@pytest.mark.parametrize("part", ["0/2", "3/2", "1", "a/b", "-1/2", "1/2/3"])
def test_a_part_that_is_none_is_refused(folder: Path, part: str) -> None:
    code, told = planned(folder, f"--part={part}")
    assert code == 2
    assert "--part" in told["error"]["message"]


@pytest.mark.parametrize(
    ("text", "words", "told"),
    [
        ("[capture.P9]\npart = 1", (), "P9: no capture has this name"),
        ("", ("--only", "P9"), "P9: no capture has this name"),
        ("box = 3", (), "box"),
    ],
)
def test_a_slip_in_the_settings_of_all_stops_all(
    folder: Path, text: str, words: tuple[str, ...], told: str
) -> None:
    (folder / "batch.toml").write_text(text)
    code, answer = planned(folder, *words)
    assert code == 2
    assert told in answer["error"]["message"]


def test_captures_without_photos_are_refused_one_by_one(folder: Path) -> None:
    (folder / "a.jpg").write_bytes(b"\xff\xd8\xff")
    out = folder.parent / "out"
    done = batch(folder, "-o", out, "--only", "P1", "--json")
    assert done.exit_code == 3, done.output
    told = json.loads(done.stdout)
    assert [(one["name"], one["state"]) for one in told["captures"]] == [("P1", "refused")]
    assert "There are no photos" in told["captures"][0]["message"]
    assert "belong to no capture" in told["notes"][0]
    assert batch(folder, "-o", out, "--part", "2/3").exit_code == 3
    kept = json.loads((out / "batch.json").read_text())
    assert [one["name"] for one in kept["captures"]] == ["P1"]


def test_the_example_is_what_is_taken(folder: Path) -> None:
    done = batch("--example")
    assert done.exit_code == 0
    (folder / "batch.toml").write_text(done.stdout)
    code, told = planned(folder)
    assert code == 2  # of the files that it names none is there
    assert all("camera.json is not there" in one["refusal"] for one in told["captures"])


def test_without_folders_it_says_how_it_is_called() -> None:
    done = batch()
    assert done.exit_code == 2
    assert "limbgram batch CAPTURES -o CASES" in done.output
