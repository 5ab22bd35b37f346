"""Kernels: functions that numba compiles, and a cache that knows all that they were compiled from.

numba keeps compiled code beside the file of its function, and compiles anew where that file has
changed. But a kernel holds more: the functions that it calls or inlines and the constants that it
names, from whatever file they come. `njit` adds a stamp of them all to the key of what is kept.
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
    """A plain function, which numpy may call, and part of every kernel that calls it."""
    return register_jitable(inline="always")(function)


def njit(*, cache: bool = False, **options: Any) -> Callable[[Function], Function]:
    """numba's `njit`, whose cache also follows what a kernel takes from other files."""

    def compiled(function: Function) -> Function:
        kernel: Any = numba.njit(**options)(function)  # noqa: TID251
        if cache:
            kernel._cache = _Cache(function)  # what numba's `cache=True` does with its own
        return kernel

    return compiled


class _Cache(FunctionCache):
    """numba's cache of one kernel; code of another stamp is not found."""

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), stamp(self._py_func))


def stamp(function: FunctionType) -> str:
    """Hash of a function and of all that it takes from its package, directly or through others.

    That is functions, as bytecode with the options of their kernels, and the values of constants;
    of other packages the names alone.
    """
    hashed = hashlib.sha256()
    for part in _parts(function, function.__module__.partition(".")[0], set()):
        hashed.update(part.encode() + b"\0")
    return hashed.hexdigest()


def _parts(value: object, package: str, met: set[FunctionType]) -> Iterator[str]:
    """What a value is made of, as texts; a function that was met before is told by its name."""
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
            told = repr(value)
            if " at 0x" in told:  # where it lies in memory, which tells nothing of what it is
                raise TypeError(f"a kernel names {told}: whether it has changed cannot be told")
            yield told


def _used(function: FunctionType, package: str) -> Iterator[object]:
    """What a function takes from its module, and from modules of the package that it names."""
    names = list(_names(function.__code__))
    scopes = [function.__globals__]
    for name in names:
        found = function.__globals__.get(name)
        if isinstance(found, ModuleType) and _within(found.__name__, package):
            scopes.append(vars(found))
    yield from (scope[name] for scope in scopes for name in names if name in scope)


def _names(code: CodeType) -> Iterator[str]:
    """Names of globals and attributes in a function and in those inside it."""
    yield from code.co_names
    for inside in code.co_consts:
        if isinstance(inside, CodeType):
            yield from _names(inside)


def _within(module: str, package: str) -> bool:
    return module.partition(".")[0] == package
