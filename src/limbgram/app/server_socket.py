"""Server socket: the socket and HTTP settings of the program's servers.

In      the routes, a socket, on a network a certificate.
Out     answers, until it is told to end.
Method  uvicorn with h11. A connection that does not send a whole request head within 20 s is
        closed, so that nobody can hold the server by beginning requests and never ending them;
        `access.Guard` does the same for what follows the head. More than 500 connections at a time
        are answered by 503.
"""

import asyncio
import logging
import socket
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from limbgram.app.access import Asgi

_KEEP_ALIVE_S = 30
_END_S = 3
"""Open answers, such as streams of events, get so long to end."""
_HEAD_S = 20.0
_MOST_CONNECTIONS = 500
_RECEIVED = 1 << 16
"""Receive buffer of a connection (the system reserves twice this): sixty photos that arrive at once
need no more memory each."""


@dataclass(frozen=True)
class Tls:
    """Files of a certificate and its key."""

    certificate: Path
    key: Path


class ImpatientProtocol(H11Protocol):
    """HTTP that closes a connection whose request head does not arrive in time."""

    head_s = _HEAD_S
    _head_due: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        super().connection_made(transport)
        self._await_head()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self._is_answering:
            self._forget_head()
        elif self._head_due is None:  # the first bytes of the next request
            self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        self._forget_head()
        super().connection_lost(exc)

    @property
    def _is_answering(self) -> bool:
        cycle = self.cycle
        return cycle is not None and not cycle.response_complete  # pyright: ignore[reportUnnecessaryComparison]

    def _await_head(self) -> None:
        self._head_due = self.loop.call_later(self.head_s, self._give_up)

    def _forget_head(self) -> None:
        if self._head_due is not None:
            self._head_due.cancel()
            self._head_due = None

    def _give_up(self) -> None:
        self._head_due = None
        if not self._is_answering and not self.transport.is_closing():
            self.transport.close()


def prompt_socket() -> socket.socket:
    """A socket whose connections send each answer at once (TCP_NODELAY).

    asyncio sets the option only if the socket names its protocol. Without it the end of an answer
    waits up to 40 ms for the browser to acknowledge the beginning.
    """
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVED)
    return made


def configured(routes: Asgi, tls: Tls | None, lifespan: Literal["on", "off"]) -> uvicorn.Config:
    """The uvicorn settings of a server."""
    return uvicorn.Config(
        routes,  # pyright: ignore[reportArgumentType]
        http=ImpatientProtocol,
        ws="none",
        log_level=logging.WARNING,
        access_log=False,
        server_header=False,
        timeout_keep_alive=_KEEP_ALIVE_S,
        timeout_graceful_shutdown=_END_S,
        limit_concurrency=_MOST_CONNECTIONS,
        lifespan=lifespan,
        ssl_certfile=None if tls is None else tls.certificate,
        ssl_keyfile=None if tls is None else str(tls.key),
    )
