"""Network server: the app for browsers of the clinic's network, encrypted, by name and password.

In      a folder for cases, users that were added on this machine, an address of this machine.
Out     the app at https://ADDRESS:PORT, until it is told to end; SHELF/access/log.jsonl says who
        did what.
Fails   OptionsError: nobody could sign in; the address, the port or the certificate cannot be used.
"""

import re
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from limbgram.app.access import Access
from limbgram.app.journal import Journal
from limbgram.app.local_server import LOOPBACK, serve_app, socket_at
from limbgram.app.options import NetworkOptions, ServeOptions
from limbgram.app.phone_port import PhonePorts, own_address
from limbgram.app.server_socket import Tls
from limbgram.app.state import AppState
from limbgram.app.tls_certificates import Certificate, given_certificate, own_certificate
from limbgram.app.users import ACCESS_FOLDER, Users
from limbgram.cases.shelf import Shelf
from limbgram.core.errors import OptionsError

PORT = 8443
_EVERYWHERE = "0.0.0.0"
_NAME = re.compile(r"(?=.{1,253}$)[a-z0-9]([a-z0-9-]{0,62})(\.[a-z0-9]([a-z0-9-]{0,62}))*")


@dataclass(frozen=True, kw_only=True)
class Reached:
    """How browsers reach the app."""

    links: tuple[str, ...]
    fingerprint: str
    own: bool
    """The certificate was made here: browsers do not know it."""
    users: int


def serve_on_network(
    options: ServeOptions, network: NetworkOptions, on_ready: Callable[[Reached], None]
) -> None:
    """Serve until Ctrl-C, or until the process is asked to end.

    Raises:
        OptionsError: see above.
        CaseError: the folder of cases cannot be used.
    """
    shelf = Shelf(options.cases.absolute())
    shelf.open()
    folder = shelf.root / ACCESS_FOLDER
    users = Users(folder)
    if not users.all():
        raise OptionsError("app.user.nobody", cases=str(options.cases))
    named = names_of(network)
    certificate = _certificate(network, folder, named)
    listening = socket_at(network.address or named[0], options.port or PORT)
    port: int = listening.getsockname()[1]
    hosts = frozenset(f"{name}:{port}" for name in named)
    access = Access(hosts, "https", people=users, lock_after_s=60 * network.lock_after_min)
    tls = Tls(certificate.file, certificate.key)
    links = tuple(f"https://{name}:{port}" for name in named)
    journal = Journal(folder)
    journal.begin()
    app_state = AppState(
        shelf,
        access,
        phone_ports=PhonePorts(tls=tls, diary=journal),
        origin=lambda: links[0],
        jobs_at_once=options.jobs,
    )
    reached = Reached(
        links=links,
        fingerprint=certificate.fingerprint,
        own=network.certificate is None,
        users=len(users.all()),
    )

    def ready() -> str:
        journal.write("this machine", "", "start_app")
        on_ready(reached)
        return links[0]

    try:
        serve_app(app_state, listening, tls, ready, browser=not options.no_browser)
    finally:  # also by Ctrl-C
        journal.write("this machine", "", "end_app")


def names_of(network: NetworkOptions) -> tuple[str, ...]:
    """Addresses and names by which browsers reach this machine, the first the one to be shown.

    Raises:
        OptionsError: a name is none, or this machine is in no network.
    """
    alone = network.address not in ("", _EVERYWHERE)
    address = network.address if alone else own_address()
    host = socket.gethostname().lower()
    found = [address]
    if not address.startswith("127."):
        found += [host] if "." in host else [host, f"{host}.local"]
    found += [LOOPBACK, "localhost"] if network.address == _EVERYWHERE else []
    found += [name.lower() for name in network.names]
    for name in found[1:]:
        if not _NAME.fullmatch(name) and name in network.names:
            raise OptionsError("app.no_machine_name", name=name)
    return tuple(dict.fromkeys(name for name in found if _NAME.fullmatch(name)))


def _certificate(network: NetworkOptions, folder: Path, named: tuple[str, ...]) -> Certificate:
    if network.certificate is None and network.key is None:
        return own_certificate(folder, named)
    if network.certificate is None or network.key is None:
        raise OptionsError("app.tls.one_alone")
    return given_certificate(network.certificate, network.key)
