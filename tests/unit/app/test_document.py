"""The description of the API that the client is built against."""

import json
import re
from pathlib import Path

from limbgram.app.document import document, text_of
from limbgram.app.recipe import list_kinds

KEPT = Path(__file__).parents[3] / "web" / "openapi.json"


def test_the_kept_description_is_that_of_the_server() -> None:
    assert KEPT.read_text("utf-8") == text_of(document()), (
        "web/openapi.json is old: python -m limbgram.app.document web/openapi.json"
    )


def test_every_route_is_under_the_version_and_says_what_it_is() -> None:
    for path, methods in document()["paths"].items():
        assert path.startswith("/api/v1/")
        for told in methods.values():
            assert told["description"]


def test_what_the_page_says_of_edits_is_what_the_server_says() -> None:
    """The page has these sentences in every language; its English ones are held against these."""
    texts = (Path(__file__).parents[3] / "web" / "src" / "texts.ts").read_text("utf-8")
    rows = dict(re.findall(r'^  "((?:does|how)\.[^"]+)": \[\s*("(?:[^"\\]|\\.)*"),', texts, re.M))
    said = {f"does.{kind.kind}": kind.does for kind in list_kinds()} | {
        f"how.{kind.kind}.{one.name}": one.meaning
        for kind in list_kinds()
        for one in kind.parameters
        if one.meaning and one.name != "positions_in"
    }
    assert {key: json.loads(text) for key, text in rows.items()} == said
