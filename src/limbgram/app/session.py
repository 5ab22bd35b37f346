"""Session: signing in, by a start link or by name and password, and what the client has to know."""

import math
import re
from importlib.metadata import version
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse
from pydantic import BaseModel, Field

from limbgram.app.access import Access, People
from limbgram.app.forms import RequestBody
from limbgram.app.replies import Refusal, refused
from limbgram.app.state import AppStateHere, SessionHere
from limbgram.cases.shelf import ID_PATTERN
from limbgram.core.errors import OptionsError
from limbgram.core.run import machine_mb, worker_count
from limbgram.findings import fault

_PHONE_PAGE = re.compile(f"phone/{ID_PATTERN.strip('^$')}")
router = APIRouter(tags=["session"])
start_router = APIRouter()

_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>limbgram</title>
<meta http-equiv="refresh" content="0; url=PAGE"></head>
<body><p><a href="PAGE">Open limbgram</a></p>
</body></html>"""
_REFUSED_PASSWORD: dict[int | str, dict[str, Any]] = {
    401: {"model": Refusal, "description": "The name or the password is not right."},
    429: {"model": Refusal, "description": "Too many were wrong: wait, as Retry-After says."},
}
_REFUSED = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>limbgram</title>
</head><body><h1>This link is not good any more</h1><p>A start link opens the app once, within 15
minutes. Start the app again by <code>limbgram app</code> and open the link that it shows.</p>
</body></html>"""


class Session(BaseModel):
    """Whether somebody is signed in, and what this program is."""

    open: bool = Field(description="Whether this browser is signed in.")
    version: str
    local: bool = Field(default=True, description="Photos and shapes stay on this machine.")
    network: bool = Field(default=False, description="Whether users sign in by name and password.")
    user: str = Field(default="", description="Who is signed in; empty on the machine itself.")
    locked: bool = Field(default=False, description="Whether the password is asked for again.")
    lock_after_s: float | None = Field(
        default=None, description="Without an act for so long, it is locked; null: never."
    )
    processors: int = 0
    memory_mb: float = 0.0


class Link(BaseModel):
    """A start link for one more browser, or program, on this machine."""

    url: str = Field(description="Good once, within 15 minutes.")


class Token(RequestBody):
    """What a start link holds."""

    token: str = Field(max_length=200)


class Credentials(RequestBody):
    """Who signs in, on a network."""

    name: str = Field(max_length=80)
    password: str = Field(max_length=400)


class Password(RequestBody):
    """Of the user who is signed in."""

    password: str = Field(max_length=400)


@router.get("/session")
def read_session(app_state: AppStateHere, request: Request, session: SessionHere) -> Session:
    """Say whether this browser is signed in; answers without a session."""
    access = app_state.access_of(request)
    found = _session(access, session)
    if found.open:
        found.processors, found.memory_mb = worker_count(), machine_mb()
    return found


@router.post(
    "/session",
    response_model=Session,
    responses={401: {"model": Refusal, "description": "The token is not good."}},
)
def open_session(app_state: AppStateHere, given: Token, response: Response) -> Session | Response:
    """Sign a program in by the token of a start link; answers without a session."""
    opened = app_state.access.open_session(given.token)
    if opened is None:
        return refused(401, "NoSession", fault("app.token_used"))
    _set_cookie(response, app_state.access, opened)
    return _session(app_state.access, opened)


@router.post("/session/sign-in", response_model=Session, responses=_REFUSED_PASSWORD)
def sign_in(
    app_state: AppStateHere, request: Request, given: Credentials, response: Response
) -> Session | Response:
    """Sign in by name and password, on a network; answers without a session."""
    people = _people(app_state.access)
    who = people.known_as(given.name)
    request.state.who = who or "unknown"  # what was typed may be a password
    refused = _password_refusal(app_state.access, people, request, given.name, given.password)
    if refused is not None:
        return refused
    opened = app_state.access.begin(who)
    _set_cookie(response, app_state.access, opened)
    return _session(app_state.access, opened)


@router.post("/session/unlock", response_model=Session, responses=_REFUSED_PASSWORD)
def unlock(
    app_state: AppStateHere,
    request: Request,
    given: Password,
    session: SessionHere,
) -> Session | Response:
    """Go on in a session that is locked; what was begun in the page is still there."""
    people = _people(app_state.access)
    signed = app_state.access.signed(session)
    refused = _password_refusal(
        app_state.access, people, request, signed.who if signed else "", given.password
    )
    if refused is not None:
        return refused
    app_state.access.act(session)
    return _session(app_state.access, session)


@router.post("/session/stay", status_code=204)
def stay(app_state: AppStateHere, session: SessionHere) -> None:
    """Say that somebody looks at the page and moves in it, so that it is not locked."""
    app_state.access.act(session)


@router.post("/session/lock", status_code=204)
def lock(app_state: AppStateHere, session: SessionHere) -> None:
    """Lock this session until its user gives the password again; on a network alone."""
    app_state.access.lock(session)


@router.delete("/session", status_code=204)
def close_session(app_state: AppStateHere, response: Response, session: SessionHere) -> None:
    """Sign out."""
    app_state.access.close_session(session)
    response.delete_cookie(app_state.access.cookie)


@router.post("/session/links", status_code=201)
def new_link(app_state: AppStateHere, session: SessionHere) -> Link:
    """Make a start link for one more browser, or program, that works under the same name."""
    signed = app_state.access.signed(session)
    token = app_state.access.new_link_token("" if signed is None else signed.who)
    return Link(url=f"{app_state.origin()}/start?token={token}")


@start_router.get("/start", include_in_schema=False)
def start(app_state: AppStateHere, request: Request, token: str = "", to: str = "") -> HTMLResponse:
    """Open a session by a start link, and go on to the app, or to a phone's page."""
    access = app_state.access_of(request)
    opened = access.open_session(token)
    if opened is None:
        return HTMLResponse(_REFUSED, status_code=401)
    page = f"/#/{to}" if _PHONE_PAGE.fullmatch(to) else "/"
    response = HTMLResponse(_PAGE.replace("PAGE", page))
    _set_cookie(response, access, opened)
    return response


def _session(access: Access, session: str) -> Session:
    state, signed = access.state(session), access.signed(session)
    return Session(
        open=access.is_open(session),
        version=version("limbgram"),
        network=access.people is not None,
        user="" if signed is None else signed.who,
        locked=state == "locked",
        lock_after_s=access.lock_after_s,
    )


def _people(access: Access) -> People:
    if access.people is None:
        raise OptionsError("app.no_users")
    return access.people


def _password_refusal(
    access: Access, people: People, request: Request, name: str, password: str
) -> Response | None:
    """The refusal of a password; None if it is right."""
    address = request.client.host if request.client else ""
    wait_s = math.ceil(access.attempts.wait_s(name, address))
    if wait_s:
        answer = refused(429, "TooMany", fault("app.too_many_passwords", wait_s=wait_s))
        answer.headers["retry-after"] = str(wait_s)
        return answer
    access.attempts.failed(name, address)  # first: attempts at the same time count each other
    if not people.is_right(name, password):
        return refused(401, "NotRight", fault("app.password_wrong"))
    access.attempts.passed(name, address)
    return None


def _set_cookie(response: Response, access: Access, session: str) -> None:
    secure = access.scheme == "https"
    response.set_cookie(
        access.cookie, session, httponly=True, samesite="strict", secure=secure, path="/"
    )
