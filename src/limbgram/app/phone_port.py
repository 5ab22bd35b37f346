"""Phone ports: second listeners, for photos from phones of the clinic's network, open while wanted.

In      a case, the app's routes, the address of this machine in its network.
Out     a port that answers for this case alone: the page, the list of photos, the coach's answer,
        and uploads of photos. Nothing else can be read and nothing deleted.
Method  It closes on request, when the app ends, after half an hour, and when all who opened it
        were removed as users.
Fails   OptionsError: this machine is in no network.
"""

import asyncio
import re
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import uvicorn

from limbgram.app.access import Access, Asgi, Diary, Good, Guard
from limbgram.app.server_socket import Tls, configured, prompt_socket
from limbgram.cases.shelf import ShelvedCase
from limbgram.core.errors import CaseError, OptionsError

_OPEN_S = 30 * 60.0
_LOOK_S = 1.0
_SHUT_S = 2.0
"""Longest wait for a port to close; its server checks ten times a second."""


class PhonePortServer(uvicorn.Server):
    """A server that signals when it accepts nothing more."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.shut = threading.Event()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        # Done once the socket and all connections that wait are closed: before the first pause.
        asyncio.get_running_loop().call_soon(self.shut.set)
        await super().shutdown(sockets)


@dataclass
class PhonePort:
    """A listener of one case."""

    case_id: str
    access: Access
    server: PhonePortServer
    origin: str
    since: float = field(default_factory=time.monotonic)
    vouchers: list[Good] = field(default_factory=list[Good])
    """Of those who opened it."""

    @property
    def closes_s(self) -> float:
        """Time until it closes by itself."""
        if not self._is_wanted:
            return 0.0
        return max(0.0, _OPEN_S - (time.monotonic() - self.since))

    @property
    def _is_wanted(self) -> bool:
        try:
            return any(good() for good in self.vouchers)
        except CaseError:  # the list of users cannot be read
            return False

    def close(self) -> None:
        """Shut it; afterwards nothing comes in."""
        self.server.should_exit = True
        if self.server.started:
            self.server.shut.wait(_SHUT_S)


@dataclass
class PhonePorts:
    """The ports that are open, one a case."""

    tls: Tls | None = None
    """Certificate and key; None for plain HTTP."""
    diary: Diary | None = None
    _ports: dict[str, PhonePort] = field(default_factory=dict[str, PhonePort])
    _opening: threading.Lock = field(default_factory=threading.Lock)
    """Held while a port is opened: two for one case could not both be closed."""

    def of(self, case: ShelvedCase) -> PhonePort | None:
        port = self._ports.get(case.case_id)
        if port is not None and (port.server.should_exit or not port.closes_s):
            port.close()
            self._ports.pop(case.case_id, None)
            return None
        return port

    def open(
        self, case: ShelvedCase, inner: Asgi, address: Callable[[], str], good: Good
    ) -> PhonePort:
        """Open a case's port.

        Args:
            good: Checks whether the one who opens it is still a user.

        Raises:
            OptionsError: this machine is in no network.
        """
        with self._opening:
            known = self.of(case)
            if known is not None:
                known.vouchers.append(good)
                return known
            return self._opened(case, inner, address(), good)

    def _opened(self, case: ShelvedCase, inner: Asgi, host: str, good: Good) -> PhonePort:
        listening = prompt_socket()
        listening.bind((host, 0))
        listening.listen(32)
        at = f"{host}:{listening.getsockname()[1]}"
        scheme = "http" if self.tls is None else "https"
        access = Access(frozenset({at}), scheme)
        guard = Guard(inner, access, allows=_allowed(case.case_id), diary=self.diary)
        server = PhonePortServer(configured(guard, self.tls, lifespan="off"))
        port = PhonePort(case.case_id, access, server, f"{scheme}://{at}", vouchers=[good])
        self._ports[case.case_id] = port
        threading.Thread(target=_serve, args=(port, listening), name="phone", daemon=True).start()
        return port

    def access_at(self, host: str) -> Access | None:
        """The sessions of the port at this address; None for another one."""
        found = (one.access for one in list(self._ports.values()) if host in one.access.hosts)
        return next(found, None)

    def close(self, case: ShelvedCase) -> None:
        port = self._ports.pop(case.case_id, None)
        if port is not None:
            port.close()

    def close_all(self) -> None:
        for port in list(self._ports.values()):
            port.close()


def own_address() -> str:
    """This machine's address in its network; no packet is sent.

    Raises:
        OptionsError: it is in none.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        try:
            asking.connect(("192.0.2.1", 9))  # an address for documentation (RFC 5737)
            host: str = asking.getsockname()[0]
        except OSError as error:
            raise OptionsError("app.no_network") from error
    return host


def _allowed(case_id: str) -> Callable[[str, str], bool]:
    """A check of the requests that a phone may send, by method and path."""
    root = f"/api/v1/cases/{re.escape(case_id)}"
    reading = re.compile(rf"{root}(/photos|/photos/[^/]+/picture|/check|/events)?")
    sending = re.compile(rf"{root}/photos/[^/]+")
    checking = f"/api/v1/cases/{case_id}/check"

    def allows(method: str, path: str) -> bool:
        if not path.startswith("/api/") or path == "/api/v1/session":
            return method in ("GET", "HEAD")
        if method == "POST":
            return path == checking
        pattern = sending if method == "PUT" else reading
        return method in ("GET", "PUT") and pattern.fullmatch(path) is not None

    return allows


def _serve(port: PhonePort, listening: socket.socket) -> None:
    def watch() -> None:
        while port.closes_s and not port.server.should_exit:
            time.sleep(_LOOK_S)
        port.close()

    threading.Thread(target=watch, name="phone-watch", daemon=True).start()
    with listening:
        port.server.run(sockets=[listening])
