"""What the app says: steps and buttons for commands and options, and no folder of the server."""

import re
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from limbgram.app.app_wording import without_folders
from limbgram.app.state import AppState
from limbgram.findings import LANGUAGES
from limbgram.findings.tell import all_words

COMMAND = re.compile(r"(?<![\w-])--[a-z]|`limbgram ")
OF_THE_COMMAND_LINE = ("ask", "batch", "dask", "options")
"""Topics of findings that no answer of the app has."""
ROOT = Path("/srv/the limbs/cases")


@pytest.mark.parametrize(
    ("said", "meant"),
    [
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
def test_sentences_name_files_without_their_folders(said: str, meant: str) -> None:
    assert without_folders(said, ROOT) == meant


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_the_app_says_names_no_command_and_no_option(language: str) -> None:
    naming = {
        code: words.sentence
        for code, words in all_words(language).items()
        if code.partition(".")[0] not in OF_THE_COMMAND_LINE and COMMAND.search(words.sentence)
    }
    assert not naming


@pytest.mark.parametrize("code", ["photo.too_few", "case.no_photos"])
def test_who_has_too_few_photos_in_the_app_is_asked_for_photos_and_for_no_folder(code: str) -> None:
    for language, folder in (("en", "folder"), ("de", "Ordner")):
        words = all_words(language)[code]
        assert folder in words.advice("command")
        assert folder not in words.advice("app")
        assert "JPEG" in words.advice("app")


def test_answers_name_no_folder_of_the_server_and_leave_what_people_wrote(
    client: TestClient, app_state: AppState
) -> None:
    case_id = client.post("/api/v1/cases", json={"note": "as --side says"}).json()["id"]
    assert client.get(f"/api/v1/cases/{case_id}").json()["note"] == "as --side says"
    (app_state.shelf.root / case_id / "work").write_text("a file in the place of a folder")
    refused = client.patch(f"/api/v1/cases/{case_id}/tape", json={"height_mm": 1, "girth_mm": 300})
    assert refused.status_code in (409, 422, 507)
    assert str(app_state.shelf.root.parent) not in refused.text
