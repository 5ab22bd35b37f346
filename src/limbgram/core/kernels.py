"""Kernels: functions compiled by numba, with a cache that follows all their dependencies.

numba caches compiled code by the file of its function alone. A kernel also depends on the functions
that it calls or inlines and on the constants that it names, in any file: `njit` adds a hash of them
all, the stamp, to the cache key.
"""

import hashlib
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.extending import register_jitable  # noqa: TID251

Function = TypeVar("Function", bound=Callable[..., Any])


def inlined(function: Function) -> Function:
    """A plain function, callable from Python, that is inlined in every kernel that calls it."""
    return register_jitable(inline="always")(function)


def njit(*, cache: bool = False, **options: Any) -> Callable[[Function], Function]:
    """numba's `njit`, whose cache follows dependencies in other files too."""

    def compiled(function: Function) -> Function:
        kernel: Any = numba.njit(**options)(function)  # noqa: TID251
        if cache:
            kernel._cache = _Cache(function)  # as numba's own `cache=True`
        return kernel

    return compiled


class _Cache(FunctionCache):
    """numba's cache of one kernel, with the stamp as part of the key."""

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), stamp(self._py_func))


def stamp(function: FunctionType) -> str:
    """Hash of a function and of its transitive dependencies inside its package.

    Functions count by bytecode and kernel options, constants by value, other packages by name.
    """
    hashed = hashlib.sha256()
    for part in _parts(function, function.__module__.partition(".")[0], set()):
        hashed.update(part.encode() + b"\0")
    return hashed.hexdigest()


def _parts(value: object, package: str, met: set[FunctionType]) -> Iterator[str]:
    """A value and its dependencies as texts to hash; a function is expanded only once."""
    match value:
        case Dispatcher():
            yield from _parts(value.targetoptions, package, met)
            yield from _parts(value.py_func, package, met)
        case FunctionType() if _within(value.__module__, package) and value not in met:
            met.add(value)
            yield value.__qualname__
            yield from _parts(value.__defaults__, package, met)
            yield from _parts(value.__code__, package, met)
            for cell in value.__closure__ or ():
                yield from _parts(cell.cell_contents, package, met)
            for used in _used(value, package):
                yield from _parts(used, package, met)
        case CodeType():
            yield value.co_code.hex()
            yield repr(value.co_names)
            yield from _parts(value.co_consts, package, met)
        case type() | FunctionType():
            yield f"{value.__module__}.{value.__qualname__}{getattr(value, '_fields', '')}"
        case ModuleType():
            yield value.__name__
        case np.ndarray():
            yield f"{value.dtype.str}{value.shape}{value.tobytes().hex()}"
        case tuple() | list():
            yield f"{type(value).__name__} of {len(value)}"
            for item in value:
                yield from _parts(item, package, met)
        case set() | frozenset():
            yield from _parts(sorted(map(repr, value)), package, met)
        case dict():
            for name, item in sorted(value.items()):
                yield name
                yield from _parts(item, package, met)
        case _:
            text = repr(value)
            if " at 0x" in text:  # an address, which says nothing of the value
                raise TypeError(f"a kernel names {text}: whether it has changed cannot be told")
            yield text


def _used(function: FunctionType, package: str) -> Iterator[object]:
    """The globals that a function names, in its module and in modules of the package."""
    names = list(_names(function.__code__))
    scopes = [function.__globals__]
    for name in names:
        found = function.__globals__.get(name)
        if isinstance(found, ModuleType) and _within(found.__name__, package):
            scopes.append(vars(found))
    yield from (scope[name] for scope in scopes for name in names if name in scope)


def _names(code: CodeType) -> Iterator[str]:
    """Names of globals and attributes in a function and its nested functions."""
    yield from code.co_names
    for inside in code.co_consts:
        if isinstance(inside, CodeType):
            yield from _names(inside)


def _within(module: str, package: str) -> bool:
    return module.partition(".")[0] == package
