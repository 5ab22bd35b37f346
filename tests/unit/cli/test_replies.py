"""What a command says at its end: refusals without traceback, and nothing that a terminal obeys."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.cli.replies import Reply, advised, answered
from limbgram.core.errors import PhotoError, printable, with_full_stop
from limbgram.findings import note

HOSTILE = "a\x1b[2J\x1b]0;owned\x07\u202egpj\r\x9b1m\udcff.jpg"


def test_what_the_system_says_is_a_refusal(capsys: pytest.CaptureFixture[str]) -> None:
    @answered
    def command() -> Reply:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), "/media/card/camera.json")

    with pytest.raises(typer.Exit) as ended:
        command()
    assert ended.value.exit_code == 3
    said = capsys.readouterr().err
    assert "/media/card/camera.json lies on a disk that may only be read. Use a folder" in said


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal between programs")
@pytest.mark.parametrize(
    "asked", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_a_system_ends_a_command_as_ctrl_c_does(asked: signal.Signals) -> None:
    """Also once a library is loaded that would print a stack trace and abort."""
    program = """
import time, typer
from limbgram.cli.replies import answered
from limbgram.reconstruction.mapping import colmap
@answered
def command():
    print("at work", flush=True)
    time.sleep(60)
typer.run(command)
"""
    begin = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    with subprocess.Popen(
        [sys.executable, "-P", "-c", f"{begin}{program}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "at work\n"
        process.send_signal(asked)
        _, told = process.communicate(timeout=30)
    assert process.returncode == 130
    assert told == "Stopped. Run the same command again to continue.\n"


@pytest.mark.parametrize("text", ["a note", "a note."])
def test_a_note_ends_with_one_full_stop(text: str) -> None:
    assert with_full_stop(text) == "a note."


def test_a_fault_of_ours_crashes() -> None:
    @answered
    def command() -> Reply:
        raise OSError("image file is cut off")

    with pytest.raises(OSError, match="cut off"):
        command()


def test_a_reply_and_a_refusal_have_no_escapes(capsys: pytest.CaptureFixture[str]) -> None:
    @answered
    def reply() -> Reply:
        return Reply((f"{HOSTILE}: blurred",), {})

    @answered
    def refuse() -> Reply:
        raise PhotoError(f"{HOSTILE} is broken.\nCopy it again.")

    reply()
    with pytest.raises(typer.Exit):
        refuse()
    told = capsys.readouterr()
    shown = r"a\x1b[2J\x1b]0;owned\x07\u202egpj\r\x9b1m\udcff.jpg"
    assert told.out == f"{shown}: blurred\n"
    assert told.err == f"{shown} is broken.\nCopy it again.\n"


@pytest.mark.parametrize(
    "words", [["measure", "--" + HOSTILE[:20]], ["measure", "x.stl", HOSTILE[:20]], [HOSTILE[:20]]]
)
def test_words_that_make_no_sense_are_quoted_without_escapes(words: list[str]) -> None:
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 2
    assert "\x1b[2J" not in answer.output
    assert "\x07" not in answer.output
    assert "x1b" in answer.output


def test_letters_of_all_kinds_stay() -> None:
    text = "Fuß 右足 ساق 📷 IMG 1\u202f(2).jpg"
    assert printable(text) == text
    assert printable("a\tb\nc") == "a\tb\nc"
    assert printable("a\tb\nc", keep="") == r"a\tb\nc"


@pytest.mark.parametrize("as_json", [False, True])
def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path, as_json: bool) -> None:
    (tmp_path / "file").write_text("no folder")
    words = ["demo", "-o", str(tmp_path / "file" / "demo")]
    answer = CliRunner().invoke(app, [*words, *(["--json"] if as_json else [])])
    assert answer.exit_code == 5, answer.output
    told = json.loads(answer.stdout)["error"]["message"] if as_json else answer.stderr
    assert "cannot be made: Not a directory" in told


@pytest.mark.parametrize(
    ("language", "said"),
    [("de", "Eine weitere nennen."), ("de_DE.UTF-8", "Eine weitere nennen."),
     ("", "Name another one."), ("xx", "Name another one.")],
)  # fmt: skip
def test_the_terminal_speaks_the_language_that_is_asked_for(
    tmp_path: Path, language: str, said: str
) -> None:
    words = ["compare", str(tmp_path / "one.stl")]
    answer = CliRunner().invoke(app, words, env={"LIMBGRAM_LANGUAGE": language})
    assert (answer.exit_code, said in answer.stderr) == (2, True), answer.output
    in_json = CliRunner().invoke(app, [*words, "--json"], env={"LIMBGRAM_LANGUAGE": language})
    error = json.loads(in_json.stdout)["error"]
    assert error["message"].endswith("Name another one.")
    assert error["finding"]["code"] == "options.compare.one_shape"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("measure limb.ply --sheet-csv a.txt", "a.txt ist kein Name für ein Maßblatt."),
        ("measure limb.ply --walls a.txt", "a.txt ist kein Name für eine Karte."),
        ("template learn a.ply b.ply -o t.txt", "t.txt ist kein Name für eine Vorlage."),
        ("template show t.json --picture t.txt", "t.txt ist kein Name für ein Bild."),
        ("edit new r.stl", "geschrieben wird ein Rezept."),
        ("export limb.ply --to gcode -o a.stl", "geschrieben wird ein Programm für eine Fräse."),
        ("export limb.ply --to gcode -o a.nc --write-machine m.txt",
         "m.txt ist kein Name für eine Maschinendatei."),
    ],
)  # fmt: skip
def test_what_is_written_is_named_in_the_language_of_the_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, words.split(), env={"LIMBGRAM_LANGUAGE": "de"})
    assert (answer.exit_code, said in answer.stderr) == (2, True), answer.output


def test_a_finding_without_advice_has_no_arrow() -> None:
    """A kit that passed stands among what is to be checked before a shape is made."""
    passed = {"artefact": "Bar 3", "made": "2026-11-02", "months": 0, "certificate": "0a1b2c3d"}
    assert advised(note("kit.passed", **passed)).count("\n") == 0
    told, todo = advised(note("record.surface.no_sock")).split("\n")
    assert told.startswith("  No sock")
    assert todo.startswith("    -> If one was worn")
