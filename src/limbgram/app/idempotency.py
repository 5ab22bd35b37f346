"""Idempotency: a change sent again under its id is made once, and answered as it was first.

In      requests that change something, each with an id of its own in the header Act-Id.
Out     the answer. It is kept beside the case, so that a repeated request, whose first answer was
        lost or whose page was reloaded, gets it again and changes nothing. A repeated answer has
        the header Act-Replayed: what it says may be out of date.
Method  One request of an id at a time: the second waits for the first. An id is bound to its
        request: the same id with another body is refused. Answers on the shelf itself are deleted
        with the case that they are about. Refusals and files are not kept: they change nothing.
        The answer is kept after the change and before it is sent: if the program is killed between
        change and keeping, a repeated request changes it again.
"""

import asyncio
import hashlib
import json
import re
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from weakref import WeakValueDictionary

from limbgram.app.access import Asgi, Message, Receive, Scope, Send, is_upload
from limbgram.app.replies import refused
from limbgram.cases.shelf import Shelf
from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.findings import fault

ACT_ID = "^[0-9A-Za-z]{8,64}$"
_ID = re.compile(ACT_ID)
_CASE = re.compile(r"/api/v1/cases/([2-9A-HJKMNP-Z]{3}-[2-9A-HJKMNP-Z]{3})(?:/|$)")
_MOST = 100
"""Answers that are kept of a case; a page waits for each before it sends the next."""
_LARGEST_BYTES = 8_000_000


@dataclass(frozen=True)
class OnceEach:
    """ASGI middleware; requests without an id pass."""

    inner: Asgi
    shelf: Shelf
    _going: WeakValueDictionary[Path, asyncio.Lock] = field(default_factory=WeakValueDictionary)
    _without_room: dict[Path, dict[str, Any]] = field(default_factory=dict[Path, dict[str, Any]])
    """Answers that a full disk did not take; they are lost when the program ends."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        act = _id_of(scope)
        place = None if act is None else self._place(scope, act)
        if place is None:
            await self.inner(scope, receive, send)
            return
        receive, sent = await _sent(scope, receive)
        lock = self._going.setdefault(place, asyncio.Lock())
        async with lock:
            try:
                known = self._without_room.get(place) or await asyncio.to_thread(_kept, place)
            except CaseError as error:
                await refused(409, "CaseError", error.finding)(scope, receive, send)
                return
            if known is not None and known["of"] == _request(scope):
                scope["route"] = SimpleNamespace(name=known["act"])
                scope["path_params"] = {"case_id": known["case"]}
                if known.get("sent", sent) != sent:
                    await refused(409, "CaseError", fault("app.another_act"))(scope, receive, send)
                    return
                await _answer(send, known["status"], known["type"], known["body"].encode())
                return
            answer = _Answer()
            await self.inner(scope, receive, answer.take)
            if answer.can_be_kept and place.parent.parent.is_dir():
                content = _content(scope, sent, answer)
                try:
                    await asyncio.to_thread(_keep, place, content)
                except OSError:  # it is done: where no room is left, it is answered still
                    self._without_room[place] = content
                    for old in list(self._without_room)[:-_MOST]:
                        del self._without_room[old]
            await answer.pass_on(send)

    def _place(self, scope: Scope, act: str) -> Path | None:
        """The file of an answer: in its case, or on the shelf for creation and deletion."""
        path = str(scope["path"])
        found = _CASE.match(path)
        deletes = scope["method"] == "DELETE" and found is not None and path == found[0]
        root = self.shelf.root if found is None or deletes else self.shelf.root / found[1]
        return root / ".acts" / f"{act}.json" if root.is_dir() else None


def forget_acts(shelf: Shelf, case_id: str) -> None:
    """Delete the answers on the shelf that are about a deleted case: that of its creation."""
    for place in (shelf.root / ".acts").glob("*.json"):
        with suppress(CaseError):  # nobody can tell of which case it is
            known = _kept(place)
            if known is not None and known["case"] == case_id:
                place.unlink(missing_ok=True)


@dataclass
class _Answer:
    """A route's answer, collected until it is complete."""

    messages: list[Message] = field(default_factory=list[Message])

    async def take(self, message: Message) -> None:
        self.messages.append(message)

    async def pass_on(self, send: Send) -> None:
        for message in self.messages:
            await send(message)

    @property
    def status(self) -> int:
        return int(self.messages[0]["status"]) if self.messages else 0

    @property
    def can_be_kept(self) -> bool:
        """Whether it confirms a change: refusals change nothing, nor do answers with a file."""
        is_text = self.type.startswith(("application/json", "text/")) or not self.body
        return 200 <= self.status < 300 and is_text

    @property
    def type(self) -> str:
        headers = dict(self.messages[0].get("headers", []))
        return headers.get(b"content-type", b"").decode("latin-1")

    @property
    def body(self) -> bytes:
        return b"".join(message.get("body", b"") for message in self.messages)


def _id_of(scope: Scope) -> str | None:
    if scope["type"] != "http" or scope["method"] in ("GET", "HEAD"):
        return None
    given = dict(scope["headers"]).get(b"act-id", b"").decode("latin-1")
    return given if _ID.fullmatch(given) else None


def _request(scope: Scope) -> str:
    return f"{scope['method']} {scope['path']}"


def _kept(place: Path) -> dict[str, Any] | None:
    """The answer to an act; None of one that was not done.

    Raises:
        CaseError: it was done, and what was answered cannot be read: doing it again is no answer.
    """
    if not place.exists():
        return None
    try:
        return json_of(read_content(place, _LARGEST_BYTES, CaseError))
    except (CaseError, ValueError) as error:
        raise CaseError("app.act_unreadable") from error


async def _sent(scope: Scope, receive: Receive) -> tuple[Receive, str]:
    """The request to be read again, and the hash of its body; empty for an upload."""
    if is_upload(scope):
        return receive, ""
    messages = [await receive()]
    while messages[-1].get("more_body", False):
        messages.append(await receive())
    body = hashlib.sha256(b"".join(one.get("body", b"") for one in messages)).hexdigest()

    async def receive_again() -> Message:
        return messages.pop(0) if messages else await receive()

    return receive_again, body


def _content(scope: Scope, sent: str, answer: _Answer) -> dict[str, Any]:
    """The record of an act and its answer."""
    return {
        "of": _request(scope),
        "act": str(getattr(scope.get("route"), "name", "")),
        "sent": sent,
        "case": scope.get("state", {}).get("case", "")
        or scope.get("path_params", {}).get("case_id", ""),
        "status": answer.status,
        "type": answer.type,
        "body": answer.body.decode("utf-8"),
    }


def _keep(place: Path, content: dict[str, Any]) -> None:
    place.parent.mkdir(exist_ok=True)
    write_bytes(place, json.dumps(content).encode())
    kept = sorted(place.parent.glob("*.json"), key=lambda one: one.stat().st_mtime_ns)
    for old in kept[:-_MOST]:
        old.unlink(missing_ok=True)


async def _answer(send: Send, status: int, kind: str, body: bytes) -> None:
    headers = [(b"content-length", str(len(body)).encode()), (b"act-replayed", b"1")]
    if kind:
        headers.append((b"content-type", kind.encode("latin-1")))
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
