"""The description of the API that the client is built against."""

from pathlib import Path

from limbgram.app.document import document, text_of

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
