"""Session: signing in by a start link, and what the client has to know of this program."""

import re
from importlib.metadata import version
from typing import Annotated

from fastapi import APIRouter, Cookie, Request, Response
from fastapi.responses import HTMLResponse
from pydantic import BaseModel, Field

from limbgram.app.access import COOKIE
from limbgram.app.clinic import ClinicHere
from limbgram.app.replies import Refusal, refusal
from limbgram.cases.shelf import ID_PATTERN
from limbgram.core.run import machine_mb, worker_count

_PHONE_PAGE = re.compile(f"phone/{ID_PATTERN.strip('^$')}")
router = APIRouter(tags=["session"])
start_router = APIRouter()

_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>limbgram</title>
<meta http-equiv="refresh" content="0; url=PAGE"></head>
<body><p><a href="PAGE">Open limbgram</a></p>
</body></html>"""
_REFUSED = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>limbgram</title>
</head><body><h1>This link is not good any more</h1><p>A start link opens the app once, within 15
minutes. Start the app again by <code>limbgram app</code> and open the link that it shows.</p>
</body></html>"""


class Session(BaseModel):
    """Whether somebody is signed in, and what this program is."""

    open: bool = Field(description="Whether this browser is signed in.")
    version: str
    local: bool = Field(default=True, description="Photos and shapes stay on this machine.")
    processors: int = 0
    memory_mb: float = 0.0


class Link(BaseModel):
    """A start link for one more browser, or program, on this machine."""

    url: str = Field(description="Good once, within 15 minutes.")


class Token(BaseModel):
    """What a start link holds."""

    token: str = Field(max_length=200)


@router.get("/session")
def read_session(
    clinic: ClinicHere, request: Request, limbgram_session: Annotated[str | None, Cookie()] = None
) -> Session:
    """Say whether this browser is signed in; answers without a session."""
    access = clinic.access_of(request)
    known = limbgram_session is not None and access.is_open(limbgram_session)
    found = Session(open=known, version=version("limbgram"))
    if known:
        found.processors, found.memory_mb = worker_count(), machine_mb()
    return found


@router.post(
    "/session",
    response_model=Session,
    responses={401: {"model": Refusal, "description": "The token is not good."}},
)
def open_session(clinic: ClinicHere, given: Token, response: Response) -> Session | Response:
    """Sign a program in by the token of a start link; answers without a session."""
    opened = clinic.access.open_session(given.token)
    if opened is None:
        return refusal(401, "NoSession", "The token is not good any more. Make another link.")
    _set(response, opened, secure=clinic.access.scheme == "https")
    return Session(open=True, version=version("limbgram"))


@router.delete("/session", status_code=204)
def close_session(
    clinic: ClinicHere, response: Response, limbgram_session: Annotated[str | None, Cookie()] = None
) -> None:
    """Sign out."""
    clinic.access.close_session(limbgram_session or "")
    response.delete_cookie(COOKIE)


@router.post("/session/links", status_code=201)
def new_link(clinic: ClinicHere) -> Link:
    """Make a start link for one more browser, or program, on this machine."""
    return Link(url=f"{clinic.origin()}/start?token={clinic.access.new_link_token()}")


@start_router.get("/start", include_in_schema=False)
def start(clinic: ClinicHere, request: Request, token: str = "", to: str = "") -> HTMLResponse:
    """Open a session by a start link, and go on to the app, or to a phone's page."""
    opened = clinic.access_of(request).open_session(token)
    if opened is None:
        return HTMLResponse(_REFUSED, status_code=401)
    page = f"/#/{to}" if _PHONE_PAGE.fullmatch(to) else "/"
    response = HTMLResponse(_PAGE.replace("PAGE", page))
    _set(response, opened, secure=clinic.access.scheme == "https")
    return response


def _set(response: Response, session: str, *, secure: bool) -> None:
    response.set_cookie(COOKIE, session, httponly=True, samesite="strict", secure=secure, path="/")
