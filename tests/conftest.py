"""Fixtures that many tests share; and array shapes are checked while the tests run.

Every function, method and dataclass of limbgram whose annotations name an array is checked by
beartype when it is called: kinds of numbers and shapes, a letter meaning one length throughout a
call. Of a list one item is looked at, chosen at random. Not checked: compiled functions, which are
no Python functions; generators, whose bodies run later; what runs in another process.

jaxtyping's own import hook does the same, but refuses `Self` and decorates what numba compiles.
What a check finds hangs on kinds and shapes alone: a call that took and gave the same ones as an
earlier call of the function is not checked again. To check each call cost up to 40 % of a test.

Hypothesis does not stop a test for the time that it takes: the first example may compile a kernel,
and on a busy machine every one is slow. What the examples have to show stays as it is.

Linear algebra takes one thread, as in the programs: those of two workers on two cores wait for each
other, and the check of a capture took twice as long.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is loaded

import builtins
import functools
import gc
import importlib.abc
import importlib.machinery
import inspect
import itertools
import sys
import threading
import types
from collections.abc import Callable, Collection, Hashable, Sequence
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from beartype import BeartypeConf, beartype
from hypothesis import HealthCheck, settings
from jaxtyping import jaxtyped

_PACKAGE = "limbgram"
_WHOLE_FOR_FLOAT = BeartypeConf(is_pep484_tower=True)
"""A whole number may stand for a float, as pyright allows."""


class _Finder(importlib.abc.MetaPathFinder):
    """Finds the package's modules as Python does."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if name.partition(".")[0] != _PACKAGE:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, importlib.machinery.SourceFileLoader):
            spec.loader = _Loader(name, spec.loader.path)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    """Replaces the functions of a module by checked ones before anybody imports them."""

    def exec_module(self, module: types.ModuleType) -> None:
        super().exec_module(module)
        for name, thing in list(vars(module).items()):
            if getattr(thing, "__module__", None) != module.__name__:
                continue
            if isinstance(thing, types.FunctionType):
                setattr(module, name, _checked(thing))
            elif isinstance(thing, type):
                _check_methods(thing)


def _check_methods(owner: type) -> None:
    for name, method in list(vars(owner).items()):
        match method:
            case types.FunctionType():
                setattr(owner, name, _checked(method, owner))
            case classmethod() | staticmethod():
                setattr(owner, name, type(method)(_checked(method.__func__, owner)))
            case property(fget=getter) if getter is not None:
                setattr(owner, name, property(_checked(getter, owner), doc=method.__doc__))


def _checked(function: Callable[..., Any], owner: type | None = None) -> Callable[..., Any]:
    hints = inspect.get_annotations(function)
    if inspect.isgeneratorfunction(function) or not any(
        "jaxtyping" in f"{h}" for h in hints.values()
    ):
        return function
    function.__annotations__ = {
        name: owner if h is Self else _known(h, function) for name, h in hints.items()
    }
    check = _Check(function, any("Literal[" in f"{h}" for h in hints.values()))
    kind, plain, known = check.kind, check.plain, check.known

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        """Every call passes here: kinds that most arguments have are told without a call."""
        try:
            taken = [
                (one.dtype, one.shape)
                if (its := type(one)) is np.ndarray
                else its
                if its in plain
                else kind(one)
                for one in (*args, *kwargs.values())
            ]
            given_before = known.get(key := (len(args), *kwargs, *taken))
        except _Unforeseen:
            return check.asked(*args, **kwargs)
        if given_before is None:
            return check.first(key, args, kwargs)
        given = function(*args, **kwargs)
        if (its := type(given)) is np.ndarray:
            its = given.dtype, given.shape
        elif its not in plain:
            try:
                its = kind(given)
            except _Unforeseen:
                its = None
        if its in given_before:
            return given
        return check.of_another_kind(key, given, args, kwargs)

    return checked


def _known(hint: Any, function: Callable[..., Any]) -> Any:
    """A hint; `object` for a quoted one that only type checkers can read: of a late import."""
    if not isinstance(hint, str):
        return hint
    scope = vars(builtins) | vars(sys.modules[function.__module__])
    names = compile(hint, "hint", "eval").co_names
    return hint if all(name in scope for name in names) else object


class _Check:
    """Calls a function, and checks what it takes and gives where these are of new kinds."""

    def __init__(self, function: Callable[..., Any], by_value: bool) -> None:
        """By value where a hint names values: kinds of numbers and strings do not suffice then."""
        self._function = function
        self.plain = _PLAIN[by_value]
        self.known: dict[Any, set[Any]] = {}
        """Kinds of what was given, by the kinds of what was taken."""
        self._given = threading.local()

    def first(self, taken: Hashable, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        """Of kinds that were not taken before."""
        given = self.asked(*args, **kwargs)
        known = self.known[taken] = set()
        with suppress(_Unforeseen):
            known.add(self.kind(given))
        return given

    def of_another_kind(
        self, taken: Hashable, given: Any, args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Any:
        """What was given, where that was of no kind that was given before."""
        self._given.value = given
        self._asked_of_given(*args, **kwargs)
        with suppress(_Unforeseen):
            self.known[taken].add(self.kind(given))
        return given

    @functools.cached_property
    def asked(self) -> Callable[..., Any]:
        return _asked(self._function)

    @functools.cached_property
    def _asked_of_given(self) -> Callable[..., Any]:
        """The same checks, of what the function gave just now."""

        @functools.wraps(self._function)
        def told(*_: Any, **__: Any) -> Any:
            return self._given.value

        return _asked(told)

    def kind(self, value: Any) -> Hashable:
        """All that a check can see of a value."""
        kind: Any = type(value)
        if kind is np.ndarray:
            return value.dtype, value.shape
        if kind in self.plain:
            return kind
        if kind is str or kind is int:
            return kind, value
        if kind in (tuple, list, dict, set, frozenset) or issubclass(kind, tuple):
            if len(value) > _MOST_ITEMS:  # of which one is looked at, chosen anew each time
                raise _Unforeseen
            items = itertools.chain(*value.items()) if kind is dict else value
            return kind, *[self.kind(one) for one in items]
        if isinstance(value, type):
            return value
        if issubclass(kind, Enum):
            return kind, value
        if issubclass(kind, Collection) and not issubclass(kind, bytes):
            raise _Unforeseen
        for plain in _PLAIN.values():
            plain.add(kind)
        return kind


_MOST_ITEMS = 16
_PLAIN: dict[bool, set[type]] = {False: {int, str}, True: set()}
"""Types of which a check sees no more than the type; and whether it sees values of numbers."""


class _Unforeseen(Exception):
    """A value of which a check may find something else each time."""


def _asked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, checked at every call."""
    asked = beartype(function, conf=_WHOLE_FOR_FLOAT)

    def within(*args: Any, **kwargs: Any) -> Any:
        with jaxtyped("context"):  # letters keep their lengths until this call returns
            return asked(*args, **kwargs)

    return within


sys.meta_path.insert(0, _Finder())

settings.register_profile(
    "limbgram", settings(), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("limbgram")

gc.disable()


def pytest_collection_finish() -> None:
    """From here on there is garbage to search for; modules and collected tests are none."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of captures with truth, named by LIMBGRAM_DATA."""
    name = os.environ.get("LIMBGRAM_DATA")
    if not name:
        pytest.skip("LIMBGRAM_DATA is not set: no captures with truth to compare with")
    return Path(name)


@pytest.fixture
def blank_mirror_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside an export a blank file: to draw the mirror check takes most of an export's time."""
    drawings = "limbgram.report.drawings"
    undrawn = types.SimpleNamespace(figure=None)
    monkeypatch.setattr(f"{drawings}.mirror_check.mirror_check", lambda *_: undrawn)
    monkeypatch.setattr(f"{drawings}.drawing.png", lambda _: np.zeros(8, np.uint8))
