"""The description of the API that the client is built against."""

from pathlib import Path

from limbgram.app.client_figures import text_of_figures
from limbgram.app.openapi import document, text_of
from limbgram.app.recipe import list_kinds
from limbgram.findings import LANGUAGES
from limbgram.workbench.edits.editing import EDIT_NAMED

KEPT = Path(__file__).parents[3] / "web" / "openapi.json"


def test_the_kept_description_is_that_of_the_server() -> None:
    assert KEPT.read_text("utf-8") == text_of(document()), (
        "web/openapi.json is old: python -m limbgram.app.openapi web/openapi.json"
    )


def test_the_client_draws_and_judges_by_the_servers_figures() -> None:
    kept = KEPT.parent / "src" / "api" / "figures.json"
    assert kept.read_text("utf-8") == text_of_figures(), (
        f"{kept.name} is old: python -m limbgram.app.client_figures web/src/api/figures.json"
    )


def test_every_route_is_under_the_version_and_says_what_it_is() -> None:
    for path, methods in document()["paths"].items():
        assert path.startswith("/api/v1/")
        for told in methods.values():
            assert told["description"]


def test_the_app_tells_of_every_edit_what_its_form_needs_in_every_language() -> None:
    told = {one.kind: one for one in list_kinds()}
    assert list(told) == list(EDIT_NAMED)
    sock = told["sock"]
    (thickness,) = sock.parameters
    assert (thickness.unit, thickness.least, thickness.most, thickness.above) == ("mm", 0, 20, True)
    assert (thickness.default, thickness.needed) == (0.3, False)
    assert {one.name: one.choices for one in told["mirror"].parameters} == {
        "confirmed_side": ["left", "right"]
    }
    assert sock.words["de"].name == "Strumpf abziehen"
    assert sock.words["de"].labels == {"thickness_mm": "Dicke"}
    assert sock.words["en"].help == {"thickness_mm": thickness.meaning}
    for one in told.values():
        names = {field.name for field in one.parameters}
        for spoken in LANGUAGES:
            words = one.words[spoken]
            assert words.name
            assert words.does
            assert words.group
            assert set(words.labels) == set(words.help) == names
