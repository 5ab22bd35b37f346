"""Local server: the app on this machine: a socket on loopback, the start link, the browser.

In      a folder for cases, a port.
Out     the app, until it is told to end; what runs then is interrupted and can be continued.
Fails   OptionsError: the port is taken, or below 1024. CaseError: the folder cannot be used.
"""

import errno
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable, Generator
from contextlib import contextmanager

import uvicorn
from uvicorn.server import HANDLED_SIGNALS

from limbgram.app.access import Access
from limbgram.app.options import ServeOptions
from limbgram.app.server import guarded
from limbgram.app.server_socket import Tls, configured, prompt_socket
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf
from limbgram.core.errors import OptionsError, printable
from limbgram.core.run import garbage_collection_paused

LOOPBACK = "127.0.0.1"


def serve(options: ServeOptions, on_ready: Callable[[str], None]) -> None:
    """Serve until Ctrl-C, or until the process is asked to end.

    Args:
        on_ready: Called with the start link once requests are answered.

    Raises:
        OptionsError: the port cannot be had.
        CaseError: the folder of cases cannot be used.
    """
    listening = socket_at(LOOPBACK, options.port)
    port: int = listening.getsockname()[1]
    access = Access(frozenset({f"{LOOPBACK}:{port}", f"localhost:{port}"}))
    origin = f"http://{LOOPBACK}:{port}"
    app_state = AppState(
        Shelf(options.cases.absolute()), access, origin=lambda: origin, jobs_at_once=options.jobs
    )
    app_state.shelf.open()

    def ready() -> str:
        link = f"{origin}/start?token={access.new_link_token()}"
        on_ready(link)
        return link

    serve_app(app_state, listening, None, ready, browser=not options.no_browser)


def serve_app(
    app_state: AppState,
    listening: socket.socket,
    tls: Tls | None,
    ready: Callable[[], str],
    *,
    browser: bool,
) -> None:
    """Answer on a socket until the process is asked to end.

    Args:
        ready: Called once requests are answered; gives the address for the browser.
    """
    with garbage_collection_paused():
        routes = guarded(app_state)
    server = EndingServer(configured(routes, tls, lifespan="on"), app_state)

    def tell() -> None:
        while not server.started and not server.should_exit:
            threading.Event().wait(0.02)
        if server.started:
            link = ready()
            if browser:
                webbrowser.open(link)

    threading.Thread(target=tell, name="ready", daemon=True).start()
    with listening:
        server.run(sockets=[listening])


class EndingServer(uvicorn.Server):
    """A server that ends when it is asked to, and then lets the program end by itself.

    Libraries that are loaded later install signal handlers of their own (glog, part of pycolmap,
    prints a stack trace and aborts): the server installs its own again once a second. Event streams
    never end by themselves: the app ends them before the server waits for open answers.
    """

    def __init__(self, config: uvicorn.Config, app_state: AppState) -> None:
        super().__init__(config)
        self._app_state = app_state

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._app_state.closing = True
        await super().shutdown(sockets)

    @contextmanager
    def capture_signals(self) -> Generator[None]:
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {one: signal.getsignal(one) for one in HANDLED_SIGNALS}
        self._listen_to_signals()
        try:
            yield
        finally:
            for one, handler in before.items():
                signal.signal(one, handler)

    async def on_tick(self, counter: int) -> bool:
        if counter % 10 == 0 and threading.current_thread() is threading.main_thread():
            self._listen_to_signals()
        return await super().on_tick(counter)

    def _listen_to_signals(self) -> None:
        for one in HANDLED_SIGNALS:
            signal.signal(one, self.handle_exit)


def socket_at(address: str, port: int) -> socket.socket:
    """A listening socket on an address and port of this machine.

    Raises:
        OptionsError: the port is taken or below 1024, or the address is none of this machine.
    """
    if port and not 1024 <= port <= 65535:
        raise OptionsError("app.port_out_of_range", port=port, least=1024, most=65535)
    listening = prompt_socket()
    try:
        listening.bind((address, port))
        listening.listen(128)
    except (OSError, UnicodeError) as error:
        listening.close()
        if isinstance(error, UnicodeError) or error.errno != errno.EADDRINUSE:
            raise OptionsError(
                "app.no_address", address=printable(address, keep="")[:60]
            ) from error
        raise OptionsError("app.port_taken", port=port) from error
    return listening
