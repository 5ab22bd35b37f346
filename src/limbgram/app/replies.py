"""Replies: a refusal of the library as an answer of the API, and what every route may answer."""

import re
from html import escape
from pathlib import Path
from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, Response
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException as StarletteHTTPException

from limbgram.app.app_wording import finding_for_app, sentences_for_app, without_folders
from limbgram.app.unknown_names import is_unknown_name, unknown_field
from limbgram.core.errors import (
    CaseError,
    ExportError,
    FoldedShapeError,
    LimbgramError,
    MissingError,
    OptionsError,
    disk_finding,
    printable,
)
from limbgram.findings import LANGUAGES, Finding, Gravity, Value


class FindingReply(BaseModel):
    """One thing that the program has to say, which words of its code tell (`/api/v1/words`)."""

    code: str = Field(description="Its topic and its name, such as tape.conflict.")
    gravity: Gravity
    values: dict[str, Any] = Field(description="What fills in the sentence, named with units.")
    sentence: str = Field(default="", description="In English.")

    @classmethod
    def of(cls, finding: Finding, root: Path | None = None) -> "FindingReply":
        """A finding without folders of the machine; the cases lie in the root."""
        return cls(**finding_for_app(finding, root))


class Refusal(BaseModel):
    """Why something was not done: what happened, the likely cause, what to do."""

    kind: str = Field(description="Name of the error, such as MeasureError; for experts.")
    message: str = Field(description="Plain sentences for people: what, why, what to do.")
    where: str = Field(default="", description="Which part of the request it is about, if one is.")
    finding: FindingReply | None = Field(default=None, description="The same as data.")


RESPONSES: dict[int | str, dict[str, Any]] = {
    401: {"model": Refusal, "description": "Nobody is signed in."},
    403: {"model": Refusal, "description": "The request comes from another place."},
    404: {"model": Refusal, "description": "There is no such thing."},
    409: {"model": Refusal, "description": "It does not fit what is there now."},
    422: {"model": Refusal, "description": "It cannot be done as it was asked for."},
}
"""What every route may answer beside its own."""

BYTES: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
"""What a route takes that reads the request as it comes."""
PICTURE: dict[int | str, dict[str, Any]] = {
    200: {"content": {"image/*": {"schema": {"type": "string", "format": "binary"}}}}
}
ADDRESS_ALONE = "Of the picture that is meant: browsers keep one for each address."
"""What is said of a parameter by which only the address differs."""
PAGE_POLICY = {
    "content-security-policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'; sandbox",
    "x-frame-options": "SAMEORIGIN",
}
"""Of pages that the program wrote: pictures and styles lie in them, and nothing may run."""
_REFUSED_PAGE = """<!doctype html><html lang="{language}"><head><meta charset="utf-8">
<title>limbgram</title><style>body {{ font: 16px/1.5 system-ui, sans-serif; margin: 32px;
max-width: 60ch; }}</style></head><body><p>{sentences}</p></body></html>"""
BINARY: dict[int | str, dict[str, Any]] = {
    200: {
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}
    },
    304: {"description": "It is what the caller has."},
}


def missing(code: str, /, **values: Value) -> MissingError:
    """The refusal where there is no such thing."""
    return MissingError(code, **values)


def refused(status: int, kind: str, finding: Finding, root: Path | None = None) -> JSONResponse:
    """A refusal of ours, of before or beside the routes."""
    found = FindingReply.of(finding, root)
    return refusal(status, kind, found.sentence, found=found)


def refusal(
    status: int, kind: str, message: str, where: str = "", found: FindingReply | None = None
) -> JSONResponse:
    said = printable(without_folders(message))
    content = Refusal(kind=kind, message=said, where=printable(where), finding=found)
    return JSONResponse(content.model_dump(), status_code=status)


def answer_refusal(request: Request, error: Exception) -> Response:
    """A refusal of the library: data, and where a browser opens a page, a page that says it."""
    assert isinstance(error, LimbgramError)
    if "text/html" in request.headers.get("accept", ""):
        return _refused_page(request, error)
    return refused(_status(error), type(error).__name__, error.finding, _root(request))


def _refused_page(request: Request, error: LimbgramError) -> HTMLResponse:
    """In the language that the browser likes best of those that there are."""
    liked = re.findall(r"(?:^|,)\s*([a-z]{2})", request.headers.get("accept-language", ""))
    language = next((one for like in liked for one in LANGUAGES if one == like), LANGUAGES[0])
    said = escape(sentences_for_app(error.finding, _root(request), language))
    page = _REFUSED_PAGE.format(language=language, sentences=said)
    return HTMLResponse(page, status_code=_status(error), headers=PAGE_POLICY)


def answer_http(_request: Request, error: Exception) -> JSONResponse:
    """No such route, method or thing."""
    assert isinstance(error, StarletteHTTPException)
    made = refusal(error.status_code, "HTTPException", str(error.detail))
    made.headers.update(error.headers or {})
    return made


def answer_invalid(request: Request, error: Exception) -> JSONResponse:
    """A request that does not fit the description."""
    assert isinstance(error, RequestValidationError)
    faults = error.errors() or [{"type": "", "loc": (), "msg": "it cannot be read"}]
    # A name with a slip of the pen first: it explains that another one is missing.
    first = next((one for one in faults if is_unknown_name(one)), faults[0])
    where = ".".join(str(part) for part in first["loc"])
    if is_unknown_name(first):
        found = FindingReply.of(unknown_field(request, first))
        return refusal(422, "ValidationError", found.sentence, where, found)
    return refusal(422, "ValidationError", f"The request cannot be read: {first['msg']}.", where)


def answer_missing(_request: Request, error: Exception) -> JSONResponse:
    """A case, photo or file of a name that nothing has."""
    if type(error) is not LookupError:  # KeyError, IndexError: a fault of ours
        raise error
    return refusal(404, "LookupError", str(error.args[0]) if error.args else "There is none.")


def answer_disk(request: Request, error: Exception) -> JSONResponse:
    """What the system says of a file."""
    assert isinstance(error, OSError)
    if error.errno is None:  # no answer of the system: a fault of ours
        raise error
    return refused(507, "OSError", disk_finding(error), _root(request))


def _root(request: Request) -> Path:
    """Where the cases lie, which nobody before the app need know."""
    root: Path = request.app.state.app_state.shelf.root
    return root


def _status(error: LimbgramError) -> int:
    match error:
        case MissingError():
            return 404
        case OptionsError():
            return 422
        case CaseError():
            return 409
        case FoldedShapeError():
            return 422
        case ExportError():
            return 507
        case _:
            return 422
