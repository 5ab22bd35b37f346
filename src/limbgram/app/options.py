"""Options: how the app is started, told before any of what it needs is imported."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from limbgram.core.request_fields import Flag, Panel, Within

LOCK_AFTER_MIN = 15.0
"""As health records are locked elsewhere: NIST SP 800-63B asks for 30 minutes at most, and clinics'
own rules for 10 to 15."""

_NETWORK = Panel("On a network")


@dataclass(frozen=True, kw_only=True)
class ServeOptions:
    """How the app is started."""

    cases: Path = Path("limbgram-cases")
    """Folder of the cases; made where there is none."""
    port: Annotated[int, Within(0, 65535)] = 0
    """Port on this machine; 0: any free one, 8443 on a network."""
    no_browser: bool = False
    """Only show the link, for a program or a browser."""
    jobs: Annotated[int, Within(1, 64)] = 1
    """Shapes computed at a time; others wait their turn."""


@dataclass(frozen=True, kw_only=True)
class NetworkOptions:
    """How the app stands on a network."""

    address: Annotated[str, _NETWORK] = ""
    """Address of this machine to answer at; 0.0.0.0 for all it has; without it the one by which it
    reaches others."""
    names: Annotated[tuple[str, ...], Flag("name"), _NETWORK] = ()
    """A name by which browsers reach this machine."""
    certificate: Annotated[Path | None, _NETWORK] = None
    """The clinic's own certificate, PEM; without it one is made here."""
    key: Annotated[Path | None, _NETWORK] = None
    """Its key, PEM, without a password."""
    lock_after_min: Annotated[float, Within(1, 240), Flag("lock-after"), _NETWORK] = LOCK_AFTER_MIN
    """Minutes without an act of its user until a page is locked."""
