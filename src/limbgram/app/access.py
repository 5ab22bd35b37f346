"""Access: who may ask, and from where.

In      every request, before any route sees it.
Out     the request, passed on; or a refusal.
Method  A link that is shown on the machine itself holds a token that is good once; opening it sets
        a cookie that no script can read and no other site can make the browser send. Host and
        Origin must name this server in every request: a page of another site that resolves a name
        to this machine, or posts to it, is refused whatever cookies it has. Every answer says what
        a page may load: nothing from outside, no script within the page.
        On a network (`network`) people sign in by name and password instead; a session in which
        nobody did anything for a while is locked until its user gives the password again, and
        what is done is written down.
Fails   401 without a session, 403 from another place, 413 where a request is too large, 423 in a
        session that is locked.
"""

import asyncio
import hmac
import re
import secrets
import time
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any, Literal, Protocol

from limbgram.app.password_attempts import Attempts
from limbgram.app.replies import refused
from limbgram.cases.shelf import ID_PATTERN
from limbgram.core.errors import CaseError, disk_finding
from limbgram.findings import Finding, fault

COOKIE = "limbgram_session"
_OPEN_PATHS = ("/api/v1/session", "/start")
"""Routes of the API that answer without a session."""
_SIGN_IN_PATH = "/api/v1/session/sign-in"
"""Answers so too, on a network."""
_LOCKED_PATHS = ("/api/v1/session/unlock", _SIGN_IN_PATH, *_OPEN_PATHS)
"""Routes that answer in a session that is locked."""
_SESSION_S = 12 * 3600.0
"""A session without a request for this long ends."""
_LINK_S = 15 * 60.0
"""Validity of a start link."""
_MOST_BODY_BYTES = 8_000_000
"""Of a request that is no upload; uploads have limits of their own (`cases.uploads`)."""
_SILENCE_S = 60.0
"""A request is given up after this time without a byte."""
_SLOWEST_BYTES_S = 10_000.0
"""A request that comes slower than this in all is given up, too: a tenth of a phone's connection on
a bad day."""
_MOST_SESSIONS = 500
"""At a time; then the one that was used longest ago ends."""
_LOGGED_READS = frozenset(
    {
        "read_export",
        "read_recipe_file",
        "record_pdf",
        "record_page",
        "report_page",
        "read_file",
        "read_camera_file",
    }
)
"""GET routes that are logged: a file or a page leaves by them."""
_UNLOGGED_POSTS = frozenset(
    {"stay", "preview", "ask_point", "measure", "compare_with", "read_compared", "ask_check"}
)
"""POST routes that change nothing, and are logged as reads are."""
_SHOWS_LITTLE = frozenset({"read_thumbnail", "listen_to_case"})
"""Reads that open no case: what the list shows, and that something changed."""
_CASE_ID = re.compile(ID_PATTERN)
_CONTENT_RANGE = re.compile(r"bytes \d{1,15}-(\d{1,15})/(\d{1,15})")
_UPLOAD_PATH = re.compile(r"/api/v1/(cases|cameras)/[^/]+/(photos|shapes)/[^/]+")
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; worker-src 'self'; manifest-src 'self'; "
    "frame-src 'self'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": _POLICY,
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
}

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Asgi = Callable[[Scope, Receive, Send], Awaitable[None]]


Good = Callable[[], bool]
LogEntry = tuple[str, str, str, str, int]
"""User, address, act, case, status."""
SessionState = Literal["none", "open", "locked"]


class People(Protocol):
    """The users, who sign in by name and password (`users`)."""

    def is_right(self, name: str, password: str) -> bool: ...

    def known_as(self, name: str) -> str:
        """The user's name as registered, whatever the case of its letters; empty if unknown."""
        ...

    def stamp(self, name: str) -> str:
        """A stamp that changes with the password; empty if the name is unknown."""
        ...


class Diary(Protocol):
    """The access log (`journal`)."""

    def write(self, who: str, address: str, act: str, case: str = "", status: int = 0) -> None: ...


@dataclass
class Signed:
    """A session: one browser or program that is signed in."""

    who: str
    """The user; empty: whoever opened the start link on this machine."""
    good: "Good"
    """Whether its user may still work: not removed, password unchanged."""
    asked: float
    """Time of the last request."""
    acted: float
    """Time of the last act of the user; what a page asks by itself is no act."""
    opened: set[str] = field(default_factory=set[str])
    """Cases that were opened: the log has the first time alone."""


@dataclass(frozen=True)
class _StartLink:
    made: float
    who: str
    good: Good | None


@dataclass
class Access:
    """Sessions and start links of one server; nothing of it outlives the server."""

    hosts: frozenset[str]
    """Values that the header Host may have, with the port."""
    scheme: str = "http"
    clock: Callable[[], float] = time.monotonic
    people: People | None = None
    """On a network: who may sign in."""
    lock_after_s: float | None = None
    """Time without an act after which a session is locked; None: never."""
    attempts: Attempts = field(default_factory=Attempts)
    _links: dict[str, "_StartLink"] = field(default_factory=dict[str, "_StartLink"])
    _sessions: dict[str, Signed] = field(default_factory=dict[str, Signed])

    @property
    def cookie(self) -> str:
        """Name of the cookie, with the port: browsers send a machine's cookies to all its ports."""
        ports = sorted({host.rpartition(":")[2] for host in self.hosts if ":" in host})
        return "_".join([COOKIE, *ports[:1]])

    def vouched(self, who: str) -> Good:
        """A check whether a user still exists, with the password of now."""
        people = self.people
        if people is None:
            return lambda: True
        stamp = people.stamp(who) if who else ""
        return lambda: bool(stamp) and people.stamp(who) == stamp

    def new_link_token(self, who: str = "", good: Good | None = None) -> str:
        """A token for a start link; who opens it works under that name.

        Args:
            good: Checks whether the session may go on; None: whether the user still exists.
        """
        self._forget_old()
        token = secrets.token_urlsafe(32)
        self._links[token] = _StartLink(self.clock(), who, good)
        return token

    def open_session(self, token: str) -> str | None:
        """The cookie of a new session for a token, which is used up; None for an unknown token."""
        self._forget_old()
        known = next((one for one in list(self._links) if _same(one, token)), None)
        if known is None:
            return None
        link = self._links.pop(known, None)  # None where another request opened it just now
        return None if link is None else self.begin(link.who, link.good)

    def begin(self, who: str, good: Good | None = None) -> str:
        """The cookie's value of a new session."""
        session, now = secrets.token_urlsafe(32), self.clock()
        good = good or self.vouched(who)
        self._sessions[session] = Signed(who=who, good=good, asked=now, acted=now)
        oldest_first = sorted(self._sessions.items(), key=lambda one: one[1].asked)
        for key, _ in oldest_first[:-_MOST_SESSIONS]:
            self._sessions.pop(key, None)
        return session

    def close_session(self, session: str) -> None:
        self._sessions.pop(session, None)

    def is_open(self, session: str) -> bool:
        """Whether a cookie belongs to a session that is not locked; counts as a request."""
        signed = self.signed(session)
        if signed is None:
            return False
        signed.asked = self.clock()
        return self.state(session) == "open"

    def state(self, session: str) -> SessionState:
        """The state of a session; asking does not count as a request."""
        signed = self.signed(session)
        if signed is None:
            return "none"
        idle = self.lock_after_s is not None and self.clock() - signed.acted >= self.lock_after_s
        return "locked" if idle else "open"

    def signed(self, session: str) -> Signed | None:
        """The session of a cookie; None if it is unknown, or its user was removed."""
        self._forget_old()
        sessions = list(self._sessions.items())  # routes in other threads sign in and out
        known = next(((one, signed) for one, signed in sessions if _same(one, session)), None)
        if known is None:
            return None
        key, signed = known
        if not signed.good():
            self._sessions.pop(key, None)
            return None
        return signed

    def act(self, session: str) -> None:
        """Note an act of the user, which postpones the lock."""
        signed = self.signed(session)
        if signed is not None:
            signed.acted = self.clock()

    def lock(self, session: str) -> None:
        """Lock a session at once."""
        signed = self.signed(session)
        if signed is not None and self.lock_after_s is not None:
            signed.acted = self.clock() - self.lock_after_s

    def fault(self, headers: dict[str, str], *, navigating: bool) -> Finding | None:
        """The refusal of a request that comes from another site; None if it does not.

        Args:
            navigating: The request is for a page, to which another site may link.
        """
        if headers.get("host", "").lower() not in self.hosts:
            return fault("app.other_machine")
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in self._origins:
            return fault("app.other_page")
        site = headers.get("sec-fetch-site", "none")
        if site not in ("same-origin", "none") and not navigating:
            return fault("app.other_page")
        return None

    @property
    def _origins(self) -> frozenset[str]:
        return frozenset(f"{self.scheme}://{host}" for host in self.hosts)

    def _forget_old(self) -> None:
        now = self.clock()
        for token, link in list(self._links.items()):
            if now - link.made >= _LINK_S:
                self._links.pop(token, None)
        for session, signed in list(self._sessions.items()):
            if now - signed.asked >= _SESSION_S:
                self._sessions.pop(session, None)


@dataclass(frozen=True)
class Guard:
    """ASGI middleware that checks every request before the routes."""

    inner: Asgi
    access: Access
    allows: Callable[[str, str], bool] = lambda _method, _path: True
    """Whether this port answers a method and path at all."""
    diary: Diary | None = None
    """The log of acts."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.inner(scope, receive, send)
            return
        if scope["type"] != "http":  # no route takes a socket
            await send({"type": "websocket.close", "code": 1008})
            return
        headers = {
            name.decode("latin-1").lower(): value.decode("latin-1")
            for name, value in scope["headers"]
        }
        path = str(scope["path"])
        in_api = path.startswith("/api/")
        is_file = is_upload(scope)
        elsewhere = self.access.fault(headers, navigating=not in_api and scope["method"] == "GET")
        session = session_in(headers.get("cookie", ""), self.access.cookie)
        if elsewhere is not None:
            await refused(403, "Elsewhere", elsewhere)(scope, receive, _guarded(send))
        elif not self.allows(scope["method"], path):
            await refused(403, "Elsewhere", fault("app.photos_only"))(
                scope, receive, _guarded(send)
            )
        elif in_api and not self._is_for_all(path) and self.access.signed(session) is None:
            await refused(401, "NoSession", self._how_to_sign_in)(scope, receive, _guarded(send))
        elif in_api and path not in _LOCKED_PATHS and not self.access.is_open(session):
            await refused(423, "Locked", fault("app.locked"))(scope, receive, _guarded(send))
        elif not is_file and _length(headers) > _MOST_BODY_BYTES:
            await refused(413, "TooLarge", fault("app.request_too_large"))(
                scope, receive, _guarded(send)
            )
        else:
            if in_api and scope["method"] not in ("GET", "HEAD") and path not in _LOCKED_PATHS:
                self.access.act(session)
            if scope["method"] not in ("GET", "HEAD"):
                receive = _bounded(receive, None if is_file else _MOST_BODY_BYTES)
            answering = self._logged(scope, headers, session, _guarded(send))
            await self.inner(scope, receive, answering)

    def _is_for_all(self, path: str) -> bool:
        return path in _OPEN_PATHS or (path == _SIGN_IN_PATH and self.access.people is not None)

    @property
    def _how_to_sign_in(self) -> Finding:
        if self.access.people is not None:
            return fault("app.not_signed_in")
        return fault("app.not_opened")

    def _logged(self, scope: Scope, headers: dict[str, str], session: str, send: Send) -> Send:
        """Log an act before its answer is sent; if that fails, a refusal is sent instead."""
        diary, access = self.diary, self.access
        if diary is None or not str(scope["path"]).startswith("/api/"):
            return send
        signed = access.signed(session)
        in_place = False

        async def send_written(message: Message) -> None:
            nonlocal in_place
            if in_place:
                return
            if message["type"] == "http.response.start":
                try:
                    for line in _log_entries(scope, headers, signed, int(message["status"])):
                        await asyncio.to_thread(diary.write, *line)
                        _note_opened(scope, line, signed)
                except (OSError, CaseError) as error:
                    in_place = True
                    why = disk_finding(error) if isinstance(error, OSError) else error.finding
                    found = fault("app.log_not_written", reason=why)
                    await refused(507, type(error).__name__, found)(scope, _nothing, send)
                    return
            await send(message)

        return send_written


def is_upload(scope: Scope) -> bool:
    """Whether a request sends a file, which may be larger than the memory."""
    return scope["method"] == "PUT" and _UPLOAD_PATH.fullmatch(str(scope["path"])) is not None


def session_in(cookies: str, name: str) -> str:
    """The session in the header Cookie; empty where there is none of that name."""
    try:
        found = SimpleCookie(cookies).get(name)
    except CookieError:
        return ""
    return "" if found is None else found.value


def _length(headers: dict[str, str]) -> int:
    told = headers.get("content-length", "0")
    return int(told) if told.isdecimal() and len(told) < 16 else _MOST_BODY_BYTES + 1


def _bounded(receive: Receive, most: int | None) -> Receive:
    """Cut a request off that exceeds its announced length, or comes too slowly."""
    came = 0
    waited_s = 0.0
    whole = False

    async def receive_bounded() -> Message:
        nonlocal came, waited_s, whole
        if whole:  # what may come now is the end of the connection
            return await receive()
        left_s = _SILENCE_S + came / _SLOWEST_BYTES_S - waited_s
        since_s = time.monotonic()
        try:
            async with asyncio.timeout(min(_SILENCE_S, left_s)):
                message = await receive()
        except TimeoutError:
            return {"type": "http.disconnect"}
        waited_s += time.monotonic() - since_s
        came += len(message.get("body", b""))
        whole = not message.get("more_body", False)
        return message if most is None or came <= most else {"type": "http.disconnect"}

    return receive_bounded


async def _nothing() -> Message:
    return {"type": "http.disconnect"}


def _log_entries(
    scope: Scope, headers: dict[str, str], signed: Signed | None, status: int
) -> list[LogEntry]:
    """The log entries of a request: of its case, and of each other one that it worked on.

    Reads are not logged, except the first read of a case, by whatever route, and all files that
    leave.
    """
    route = scope.get("route")
    act = str(getattr(route, "name", "")) or "unknown"
    state: dict[str, Any] = scope.get("state", {})
    case = str(state.get("case", "") or scope.get("path_params", {}).get("case_id", ""))
    case = case if _CASE_ID.fullmatch(case) else ""  # what a path says instead may be anything
    named = (case, *state.get("other_cases", ()))
    cases = [one for one in dict.fromkeys(named) if one] or [""]
    who = "" if signed is None else signed.who
    if is_upload(scope) and _has_more_pieces(headers):
        return []
    if _reads(scope, act) and act not in _LOGGED_READS:
        known = {"", *cases} if signed is None or act in _SHOWS_LITTLE else {"", *signed.opened}
        cases = [one for one in cases if one not in known]
    client = scope.get("client")
    by = str(state.get("who", who)), client[0] if client else "", act
    return [(*by, one, status) for one in cases]


def _reads(scope: Scope, act: str) -> bool:
    return scope["method"] in ("GET", "HEAD") or act in _UNLOGGED_POSTS


def _note_opened(scope: Scope, line: LogEntry, signed: Signed | None) -> None:
    """Note that the log has the first read of a case; a read that was refused is none."""
    _, _, act, case, status = line
    if signed is not None and case and _reads(scope, act) and status < 400:
        signed.opened.add(case)


def _has_more_pieces(headers: dict[str, str]) -> bool:
    """Whether more pieces of a file follow: only the last one is logged."""
    found = _CONTENT_RANGE.fullmatch(headers.get("content-range", "").strip())
    return found is not None and int(found[1]) + 1 < int(found[2])


def _guarded(send: Send) -> Send:
    """Add the security headers to an answer, unless its route set them."""

    async def send_guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            given = list(message.get("headers", []))
            names = {name.decode("latin-1").lower() for name, _ in given}
            own = [
                (name.encode(), value.encode())
                for name, value in _HEADERS.items()
                if name not in names
            ]
            cache = [] if "cache-control" in names else [(b"cache-control", b"no-store")]
            message["headers"] = [*given, *own, *cache]
        await send(message)

    return send_guarded


def _same(one: str, other: str) -> bool:
    return hmac.compare_digest(one.encode(), other.encode("utf-8", "surrogateescape"))
