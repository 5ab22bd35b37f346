"""Access: who may ask, and from where.

In      every request, before any route sees it.
Out     the request, passed on; or a refusal.
Method  A link that is shown on the machine itself holds a token that is good once; opening it sets
        a cookie that no script can read and no other site can make the browser send. Host and
        Origin must name this server in every request: a page of another site that resolves a name
        to this machine, or posts to it, is refused whatever cookies it has. Every answer says what
        a page may load: nothing from outside, no script within the page.
Fails   401 without a session, 403 from another place.
"""

import hmac
import re
import secrets
import time
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any

from limbgram.app.replies import refusal

COOKIE = "limbgram_session"
_OPEN_PATHS = ("/api/v1/session", "/start")
"""Routes of the API that answer without a session."""
_SESSION_S = 12 * 3600.0
"""Without a request for so long, a session ends."""
_LINK_S = 15 * 60.0
"""A start link is good for so long."""
_MOST_BYTES = 8_000_000
"""Of a request that is no file; files have limits of their own (`cases.intake`)."""
_FILES = re.compile(r"/api/v1/(cases|cameras)/[^/]+/(photos|shapes)/[^/]+")
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


@dataclass
class Access:
    """Sessions and start links of one server; nothing of it outlives the server."""

    hosts: frozenset[str]
    """What the header Host may say, with the port."""
    scheme: str = "http"
    clock: Callable[[], float] = time.monotonic
    _links: dict[str, float] = field(default_factory=dict[str, float])
    _sessions: dict[str, float] = field(default_factory=dict[str, float])

    def new_link_token(self) -> str:
        """A token for a start link."""
        self._forget_old()
        token = secrets.token_urlsafe(32)
        self._links[token] = self.clock()
        return token

    def open_session(self, token: str) -> str | None:
        """The cookie's value for a token, which is good no more; None for any other text."""
        self._forget_old()
        known = next((one for one in self._links if _same(one, token)), None)
        if known is None:
            return None
        del self._links[known]
        session = secrets.token_urlsafe(32)
        self._sessions[session] = self.clock()
        return session

    def close_session(self, session: str) -> None:
        self._sessions.pop(session, None)

    def is_open(self, session: str) -> bool:
        """Whether a cookie is that of a session; it lives on from now."""
        self._forget_old()
        known = next((one for one in self._sessions if _same(one, session)), None)
        if known is None:
            return False
        self._sessions[known] = self.clock()
        return True

    def fault(self, headers: dict[str, str], *, navigating: bool) -> str | None:
        """Why a request is refused for where it comes from; None where it is not.

        Args:
            navigating: A page is asked for, which a link elsewhere may lead to.
        """
        if headers.get("host", "").lower() not in self.hosts:
            return "The request names another machine than this one. Open the app by its own link."
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in self._origins:
            return "The request comes from a page of another place, and is not answered."
        site = headers.get("sec-fetch-site", "none")
        if site not in ("same-origin", "none") and not navigating:
            return "The request comes from a page of another place, and is not answered."
        return None

    @property
    def _origins(self) -> frozenset[str]:
        return frozenset(f"{self.scheme}://{host}" for host in self.hosts)

    def _forget_old(self) -> None:
        now = self.clock()
        self._links = {one: at for one, at in self._links.items() if now - at < _LINK_S}
        self._sessions = {one: at for one, at in self._sessions.items() if now - at < _SESSION_S}


@dataclass(frozen=True)
class Guard:
    """Stands before all routes."""

    inner: Asgi
    access: Access
    allows: Callable[[str, str], bool] = lambda _method, _path: True
    """Of a method and a path, whether this door answers it at all."""

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
        fault = self.access.fault(headers, navigating=not in_api and scope["method"] == "GET")
        session = session_in(headers.get("cookie", ""))
        if fault is not None:
            await refusal(403, "Elsewhere", fault)(scope, receive, _guarded(send))
        elif not self.allows(scope["method"], path):
            told = "This door takes photos of one case, and answers nothing else."
            await refusal(403, "Elsewhere", told)(scope, receive, _guarded(send))
        elif in_api and path not in _OPEN_PATHS and not self.access.is_open(session):
            await refusal(
                401,
                "NoSession",
                "Nobody is signed in here. Open the app by the link that `limbgram app` shows; it "
                "is good once.",
            )(scope, receive, _guarded(send))
        elif _FILES.fullmatch(path):
            await self.inner(scope, receive, _guarded(send))
        elif _length(headers) > _MOST_BYTES:
            told = "The request is larger than any that is answered. Send less at a time."
            await refusal(413, "TooLarge", told)(scope, receive, _guarded(send))
        else:
            await self.inner(scope, _bounded(receive), _guarded(send))


def session_in(cookies: str) -> str:
    """The session in the header Cookie; empty where there is none."""
    try:
        found = SimpleCookie(cookies).get(COOKIE)
    except CookieError:
        return ""
    return "" if found is None else found.value


def _length(headers: dict[str, str]) -> int:
    told = headers.get("content-length", "0")
    return int(told) if told.isdecimal() and len(told) < 16 else _MOST_BYTES + 1


def _bounded(receive: Receive) -> Receive:
    """A request that does not say its length is cut off where it becomes too long."""
    came = 0

    async def receive_bounded() -> Message:
        nonlocal came
        message = await receive()
        came += len(message.get("body", b""))
        return message if came <= _MOST_BYTES else {"type": "http.disconnect"}

    return receive_bounded


def _guarded(send: Send) -> Send:
    """Every answer says what a page may do; a route that says so itself is believed."""

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
