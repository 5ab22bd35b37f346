"""What the app says: steps and buttons for commands and options, and no folder of the server."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

import limbgram
from limbgram.app.app_wording import plain
from limbgram.app.state import AppState
from limbgram.findings.tell import all_words

SOURCES = Path(limbgram.__file__).parent
OF_THE_COMMAND_LINE = re.compile(r"(?<![\w-])--?[a-z]|`|\blimbgram [a-z]")
SPOKEN = re.compile(r"(?<![\w-])--[a-z]|`limbgram ")
ROOT = Path("/srv/the limbs/cases")


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        (
            "The limb is not aligned, so nobody knows where its axis runs. Run `limbgram align` "
            "first.",
            "The limb is not aligned, so nobody knows where its axis runs. Use the step Align "
            "first.",
        ),
        (
            "Pick it with `limbgram align --landmark`, or choose another.",
            "Pick it with the step Align, or choose another.",
        ),
        (
            "Say it by --proximal, such as --proximal +z.",
            "Say it by the proximal direction.",
        ),
        (
            "Check it on the patient, and say --side left, right or none.",
            "Check it on the patient, and say the side left, right or none.",
        ),
        (
            "State the axis itself, pointing to the body: --axis=0,0,1 or --axis=0,0,-1.",
            "State the axis itself, pointing to the body: the axis 0,0,1 or the axis 0,0,-1.",
        ),
        (
            "It is damaged. `limbgram align` gives it one.",
            "It is damaged. The step Align gives it one.",
        ),
        (
            "The case /srv/the limbs/cases/K7Q-4F2 is interrupted; see "
            "/srv/the limbs/cases/K7Q-4F2/log.txt.",
            "The case K7Q-4F2 is interrupted; see K7Q-4F2/log.txt.",
        ),
        ("/tmp/made/scan.ply cannot be read.", "scan.ply cannot be read."),
        (r"C:\Users\me\scan.ply cannot be read.", "scan.ply cannot be read."),
        (
            "Write 1/2 or and/or 24/12/2026; open http://127.0.0.1:8000/start/now, -3.5 mm -- no.",
            "Write 1/2 or and/or 24/12/2026; open http://127.0.0.1:8000/start/now, -3.5 mm -- no.",
        ),
    ],
)
def test_sentences_of_the_library_are_said_in_the_words_of_the_app(said: str, meant: str) -> None:
    assert plain(said, ROOT) == meant


def test_no_sentence_of_the_library_keeps_a_word_of_the_command_line() -> None:
    sentences = list(spoken())
    assert sentences
    kept = {said: plain(said) for said in sentences if OF_THE_COMMAND_LINE.search(plain(said))}
    assert not kept


def test_answers_name_no_folder_of_the_server_and_leave_what_people_wrote(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post("/api/v1/cases", json={"note": "as --side says"}).json()["id"]
    assert client.get(f"/api/v1/cases/{case_id}").json()["note"] == "as --side says"
    (app_state.shelf.root / case_id / "work").write_text("a file in the place of a folder")
    refused = client.patch(f"/api/v1/cases/{case_id}/tape", json={"height_mm": 1, "girth_mm": 300})
    assert refused.status_code in (409, 422, 507)
    assert str(app_state.shelf.root.parent) not in refused.text


def spoken() -> Iterator[str]:
    """Texts in the sources and among the words of findings that name commands or options."""
    for code, words in all_words("en").items():
        if code.partition(".")[0] in (
            "ask",
            "batch",
            "dask",
            "options",
        ):  # of the command line alone
            continue
        yield from (text for text in (words.says, words.advice("app")) if SPOKEN.search(text))
    for path in SOURCES.rglob("*.py"):
        room = path.relative_to(SOURCES).parts
        if room[0] in ("cli", "synthetic", "app") or room[:2] == ("cases", "batch"):
            continue
        tree = ast.parse(path.read_text("utf-8"))
        alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.JoinedStr):
                parts = node.values
                alone.update(id(part) for part in parts)
                text = "".join(
                    str(one.value) if isinstance(one, ast.Constant) else "X" for one in parts
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = "" if id(node) in alone else node.value
            else:
                continue
            if SPOKEN.search(text):
                yield text
