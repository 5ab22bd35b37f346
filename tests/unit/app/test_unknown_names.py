"""Names that a request gives and no route has: refused, never passed over."""

from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from limbgram.app.openapi import document

API = "/api/v1"


@pytest.fixture
def case(client: TestClient) -> str:
    return f"{API}/cases/{client.post(f'{API}/cases', json={}).json()['id']}"


@pytest.mark.parametrize(
    ("path", "body", "place", "name", "meant"),
    [
        ("job", {"board": {"squre_mm": 25.0}}, "board", "squre_mm", "square_mm"),
        ("job", {"board": {"ruler": {"drawn": 250}}}, "board.ruler", "drawn", "drawn_mm"),
        ("job", {"tapes": [{"girth_mm": 300, "hight_mm": 90}]}, "tapes.0", "hight_mm", "height_mm"),
        ("job", {"distances": [{"length": 5}]}, "distances.0", "length", "length_mm"),
        ("job", {"unscald": True}, None, "unscald", "unscaled"),
        ("check", {"kameras": ["a"]}, None, "kameras", "cameras"),
        ("measures", {"every_mm": 5}, None, "every_mm", None),
        ("measures", {"spacing": 5}, None, "spacing", "spacing_mm"),
        ("limb/align", {"Side": "left"}, None, "Side", "side"),
        ("compare", {"other_limb_of_ghost": 1}, None, "other_limb_of_ghost", None),
    ],
)  # fmt: skip
def test_a_field_that_there_is_not_is_refused_with_the_one_that_was_meant(
    client: TestClient, case: str, path: str, body: Any, place: str | None, name: str, meant: Any
) -> None:
    refused = client.post(f"{case}/{path}", json=body)
    assert refused.status_code == 422
    found = refused.json()["finding"]
    assert found["code"] == "app.unknown_field"
    assert (found["values"]["place"], found["values"]["name"]) == (place, name)
    assert found["values"]["meant"] == meant
    assert meant is None or meant in found["values"]["known"]
    assert name not in found["values"]["known"]
    assert refused.json()["where"].endswith(name)
    assert repr(name) in refused.json()["message"]


def test_a_slip_in_a_name_that_is_needed_says_the_slip_and_not_that_one_is_missing(
    client: TestClient,
) -> None:
    values = client.post(f"{API}/cameras", json={"nam": "front"}).json()["finding"]["values"]
    assert (values["name"], values["meant"], values["known"]) == ("nam", "name", ["name"])


@pytest.mark.parametrize(
    ("path", "query", "meant"),
    [
        ("surface", "Of=rectified", "of"),
        ("photos/one.jpg/picture", "widht=200", "width"),
        ("job", "most=10", None),
        ("", "find=x", None),
    ],
)
def test_a_query_parameter_that_there_is_not_is_refused(
    client: TestClient, case: str, path: str, query: str, meant: str | None
) -> None:
    refused = client.get(f"{case}/{path}?{query}" if path else f"{case}?{query}")
    assert refused.status_code == 422
    found = refused.json()["finding"]
    assert (found["code"], found["values"]["meant"]) == ("app.unknown_query", meant)
    assert found["values"]["name"] == query.partition("=")[0]


def test_what_pages_ask_with_is_taken(client: TestClient, case: str) -> None:
    for known in ("photos/one.jpg/picture?width=200&of=0123abcd", "thumbnail?drawn=1f"):
        assert client.get(f"{case}/{known}").status_code == 404  # there is none: it was read
    assert client.get("/case/anything?from=mail").status_code == 200  # the client's own


def test_every_body_of_the_api_refuses_what_it_does_not_have() -> None:
    described = document()
    defined = described["components"]["schemas"]
    reached: set[str] = set()
    for methods in described["paths"].values():
        for route in methods.values():
            for content in route.get("requestBody", {}).get("content", {}).values():
                _follow(content["schema"], defined, reached)
    assert {"JobOptions", "BoardSpec", "Ruler", "KnownDistance", "Reading"} <= reached
    with_fields = [name for name in reached if "properties" in defined[name]]
    open_ones = [name for name in with_fields if defined[name].get("additionalProperties", True)]
    assert open_ones == []


def _follow(schema: Any, defined: dict[str, Any], reached: set[str]) -> None:
    for name in _references(schema):
        if name not in reached:
            reached.add(name)
            _follow(defined[name], defined, reached)


def _references(schema: Any) -> Iterator[str]:
    match schema:
        case {"$ref": str(reference)}:
            yield reference.rpartition("/")[2]
        case dict():
            for value in schema.values():
                yield from _references(value)
        case list():
            for value in schema:
                yield from _references(value)
        case _:
            pass
