"""Serving: the app on this machine: a socket on loopback, the start link, the browser.

In      a folder for cases, a port.
Out     the app, until it is told to end; what runs then is interrupted and can be continued.
Fails   OptionsError: the port is taken, or below 1024. CaseError: the folder cannot be used.
"""

import logging
import socket
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from limbgram.app.access import Access
from limbgram.app.clinic import Clinic
from limbgram.app.server import guarded
from limbgram.cases.shelf import Shelf
from limbgram.core.errors import OptionsError
from limbgram.core.run import no_search_for_garbage

LOOPBACK = "127.0.0.1"
_KEEP_ALIVE_S = 30
_END_S = 3
"""Open answers, such as streams of events, get so long to end."""


@dataclass(frozen=True, kw_only=True)
class ServeOptions:
    """How the app is started."""

    cases: Path
    port: int = 0
    """0: any that is free."""
    browser: bool = True
    """Open the default browser."""


def serve(options: ServeOptions, on_ready: Callable[[str], None]) -> None:
    """Serve until Ctrl-C, or until the process is asked to end.

    Args:
        on_ready: Called with the start link once requests are answered.

    Raises:
        OptionsError: the port cannot be had.
        CaseError: the folder of cases cannot be used.
    """
    listening = _socket(options.port)
    port: int = listening.getsockname()[1]
    access = Access(frozenset({f"{LOOPBACK}:{port}", f"localhost:{port}"}))
    origin = f"http://{LOOPBACK}:{port}"
    clinic = Clinic(Shelf(options.cases.absolute()), access, origin=lambda: origin)
    clinic.shelf.open()
    with no_search_for_garbage():
        routes = guarded(clinic)
    config = uvicorn.Config(
        routes,
        log_level=logging.WARNING,
        access_log=False,
        server_header=False,
        timeout_keep_alive=_KEEP_ALIVE_S,
        timeout_graceful_shutdown=_END_S,
        lifespan="on",
    )
    server = uvicorn.Server(config)
    link = f"{origin}/start?token={access.new_link_token()}"

    def tell() -> None:
        while not server.started and not server.should_exit:
            threading.Event().wait(0.02)
        if server.started:
            on_ready(link)
            if options.browser:
                webbrowser.open(link)

    threading.Thread(target=tell, name="ready", daemon=True).start()
    with listening:
        server.run(sockets=[listening])


def _socket(port: int) -> socket.socket:
    """A socket on loopback that nothing else has."""
    if port and not 1024 <= port <= 65535:
        raise OptionsError(f"Port {port} cannot be used. Choose one from 1024 to 65535.")
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.bind((LOOPBACK, port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        raise OptionsError(
            f"Port {port} is taken: another program uses it, or the app runs already. Close that "
            "one, choose another by --port, or leave --port out."
        ) from error
    return listening
