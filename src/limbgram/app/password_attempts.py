"""Password attempts: how long to wait after wrong passwords.

In      wrong and right passwords, each with the name and the address that it came from.
Out     seconds until the next one is tried.
Method  Five wrong ones are free. From then on each doubles the wait: for an address up to five
        minutes; for a name, from any address, up to 30 s, so that nobody can lock a user out for
        long. After a quarter of an hour without a wrong one the count starts again.
"""

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

_FREE = 5
_LONGEST_S = {"address": 300.0, "name": 30.0}
_FORGOTTEN_S = 15 * 60.0
_MOST_KEPT = 10_000
"""Names and addresses; then the one with the oldest wrong attempt is dropped."""

Key = tuple[str, str]
"""address or name, and which."""


@dataclass
class Attempts:
    """Wrong passwords, by name and by address."""

    clock: Callable[[], float] = time.monotonic
    _wrong: "OrderedDict[Key, tuple[int, float]]" = field(default_factory=lambda: OrderedDict())
    """Number of wrong ones, and time of the last."""

    def wait_s(self, name: str, address: str) -> float:
        """Time until the next password is tried; 0: now."""
        return max(self._wait_s(key) for key in _keys(name, address))

    def failed(self, name: str, address: str) -> None:
        """A wrong password came."""
        now = self.clock()
        for key in _keys(name, address):
            count, _ = self._known(key)
            self._wrong[key] = count + 1, now
            self._wrong.move_to_end(key)
        while len(self._wrong) > _MOST_KEPT:
            self._wrong.popitem(last=False)

    def passed(self, name: str, address: str) -> None:
        """A right one came."""
        for key in _keys(name, address):
            self._wrong.pop(key, None)

    def _wait_s(self, key: Key) -> float:
        count, last = self._known(key)
        if count < _FREE:
            return 0.0
        wait = min(2.0 ** (count - _FREE), _LONGEST_S[key[0]])
        return max(0.0, last + wait - self.clock())

    def _known(self, key: Key) -> tuple[int, float]:
        count, last = self._wrong.get(key, (0, 0.0))
        return (0, 0.0) if self.clock() - last > _FORGOTTEN_S else (count, last)


def _keys(name: str, address: str) -> tuple[Key, Key]:
    return ("name", name.strip().casefold()[:80]), ("address", address)
