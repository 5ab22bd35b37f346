"""Fixtures that many tests share; and array shapes are checked while the tests run.

Every function, method and dataclass of limbgram whose annotations name an array is checked by
beartype when it is called: kinds of numbers and shapes, a letter meaning one length throughout a
call. Of a list one item is looked at, chosen at random. Not checked: compiled functions, which are
no Python functions; generators, whose bodies run later; what runs in another process.

jaxtyping's own import hook does the same, but refuses `Self` and decorates what numba compiles.
Loading the whole package takes a second longer, the tests themselves a few per cent.

Hypothesis does not stop a test for the time that it takes: the first example may compile a kernel,
and on a busy machine every one is slow. What the examples have to show stays as it is.

Linear algebra takes one thread, as in the programs: those of two workers on two cores wait for each
other, and the check of a capture took twice as long.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is loaded

import functools
import gc
import importlib.abc
import importlib.machinery
import inspect
import sys
import types
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Self

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
    function.__annotations__ = {name: owner if h is Self else h for name, h in hints.items()}
    asked = beartype(function, conf=_WHOLE_FOR_FLOAT)

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        with jaxtyped("context"):  # letters keep their lengths until this call returns
            return asked(*args, **kwargs)

    return checked


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
