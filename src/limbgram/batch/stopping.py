"""Stopping: one stop flag for everything that runs in a batch."""

import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field

from limbgram.core.errors import Cancelled


@dataclass
class Stopping:
    """A stop flag, and the callbacks that end what is running."""

    _asked: threading.Event = field(default_factory=threading.Event)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _calls: dict[int, Callable[[], None]] = field(default_factory=dict[int, Callable[[], None]])

    @property
    def asked(self) -> bool:
        return self._asked.is_set()

    def ask(self) -> None:
        """Set the flag and end what is running; safe from another thread."""
        with self._lock:
            self._asked.set()
            calls = list(self._calls.values())
        for call in calls:
            call()

    def check(self) -> None:
        """Raise Cancelled once the flag is set."""
        if self.asked:
            raise Cancelled("batch.stopped_before")

    @contextmanager
    def calling(self, call: Callable[[], None]) -> Generator[None]:
        """Let `call` end what runs inside, as soon as the flag is set; at once if it is already."""
        with self._lock:
            self._calls[id(call)] = call
            late = self.asked
        if late:
            call()
        try:
            yield
        finally:
            with self._lock:
                del self._calls[id(call)]
