"""Unknown names: a field or query parameter that a route does not have is refused by its name.

Passed over, a name with a slip of the pen would leave its default in the place of what was meant.
Which names there are, the description of the API says.
"""

from collections.abc import Iterable, Iterator
from typing import Any

from fastapi import Request

from limbgram.core.errors import OptionsError
from limbgram.core.known_words import likeliest
from limbgram.findings import Finding, fault

_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
"""What pydantic calls a name that a model or a dataclass does not have."""
Schema = dict[str, Any]


def refuse_unknown_query(request: Request) -> None:
    """Refuse query parameters that the route does not have.

    Raises:
        OptionsError: names the first one, those there are, and the one that was probably meant.
    """
    if not request.query_params:
        return
    stated = _operation(request).get("parameters", [])
    known = [one["name"] for one in stated if one["in"] == "query"]
    for name in request.query_params:
        if name not in known:
            there = tuple(known) or None
            meant = likeliest(name, known)
            raise OptionsError("app.unknown_query", name=name, known=there, meant=meant)


def is_unknown_name(error: Schema) -> bool:
    """Whether an error of pydantic is that a body has a name that is not known."""
    return error["type"] in _UNKNOWN and error["loc"][0] == "body"


def unknown_field(request: Request, error: Schema) -> Finding:
    """What to say of a field that the body of a request does not have."""
    _, *place, name = error["loc"]
    (content,) = _operation(request)["requestBody"]["content"].values()
    known = _names_at(content["schema"], place, request.app.openapi()["components"]["schemas"])
    return fault(
        "app.unknown_field",
        place=".".join(str(part) for part in place) or None,
        name=str(name),
        known=tuple(known),
        meant=likeliest(str(name), known),
    )


def _operation(request: Request) -> Schema:
    """What the description says of the route that a request has reached."""
    name = request.scope["endpoint"].__name__
    described = (one for path in request.app.openapi()["paths"].values() for one in path.values())
    return next(one for one in described if one["operationId"] == name)


def _names_at(body: Schema, place: Iterable[str | int], defined: Schema) -> list[str]:
    """Names of the fields at a place of a body."""
    here = list(_alternatives(body, defined))
    for part in place:
        inside = [found for one in here if (found := _part(one, part)) is not None]
        # pydantic also puts the name of an alternative into the place: it leads nowhere.
        here = [one for found in inside for one in _alternatives(found, defined)] or here
    return [name for one in here for name in one.get("properties", {})]


def _alternatives(schema: Schema, defined: Schema) -> Iterator[Schema]:
    """A schema, or each of those that it leaves to choose from."""
    if "$ref" in schema:
        yield from _alternatives(defined[schema["$ref"].rpartition("/")[2]], defined)
    elif "anyOf" in schema:
        for one in schema["anyOf"]:
            yield from _alternatives(one, defined)
    else:
        yield schema


def _part(schema: Schema, part: str | int) -> Schema | None:
    """The schema of a field, or of the items of a list."""
    return schema.get("items") if isinstance(part, int) else schema.get("properties", {}).get(part)
