"""Stopping: one stop flag for everything that runs in a batch."""

import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field

from limbgram.core.errors import Cancelled


@dataclass
class Stopping:
    """Whether the user asked to stop, and what is told so."""

    _asked: threading.Event = field(default_factory=threading.Event)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _calls: dict[int, Callable[[], None]] = field(default_factory=dict[int, Callable[[], None]])

    @property
    def asked(self) -> bool:
        return self._asked.is_set()

    def ask(self) -> None:
        """Stop everything; safe from another thread."""
        with self._lock:
            self._asked.set()
            calls = list(self._calls.values())
        for call in calls:
            call()

    def check(self) -> None:
        """Raise Cancelled once stopping was asked for."""
        if self.asked:
            raise Cancelled("batch.stopped_before")

    @contextmanager
    def calling(self, call: Callable[[], None]) -> Generator[None]:
        """Meanwhile `call` ends what is under way; at once where stopping was asked for before."""
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
