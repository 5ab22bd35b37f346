"""Fingerprints: cache keys of products: hashes of their inputs, options, code and libraries.

A product's key is the hash of its inputs (their content, files included), its options, the source
code of its stage and the versions of the libraries that this code can use. Products with equal keys
are equal.
"""

import ast
import hashlib
import json
import platform
import re
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, is_dataclass
from functools import cache
from importlib.metadata import packages_distributions, version
from pathlib import Path
from typing import Any, cast

import numpy as np

import limbgram
from limbgram.cases.encoding import to_tree
from limbgram.core.syntax import PARSING

_PACKAGE = Path(limbgram.__file__).parent
_BEHIND = {
    "numba": ("llvmlite",),
    "trimesh": ("embreex", "numpy", "scipy"),
    "cv2": ("numpy",),
    "pycolmap": ("numpy",),
    "matplotlib": ("numpy",),
}
"""Libraries that another library computes with, though our code does not import them."""
_IMPORT = re.compile(
    rb"^[ \t]*(?:from[ \t]+\S+[ \t]+)?import[ \t]+(?:\([^)]*\)|[^(\n]*)", re.MULTILINE
)
"""An import statement; each has a line of its own in this project."""


@dataclass
class Fingerprints:
    """Hashes of values and files, each computed once."""

    _values: dict[int, tuple["weakref.ref[Any]", str]] = field(default_factory=dict)
    _files: dict[tuple[Path, int, int], str] = field(default_factory=dict)

    def key(self, stage: Callable[..., object], inputs: Sequence[object]) -> str:
        """Key of the product that a stage makes of its inputs."""
        parts = [code_version(stage.__module__), *(self.of(item) for item in inputs)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    def of(self, value: object) -> str:
        """Hash of a value's content; of a path, its name and what the file holds."""
        if isinstance(value, tuple | list):
            items = [self.of(item) for item in cast(Sequence[object], value)]
            return hashlib.sha256(("sequence:" + ",".join(items)).encode()).hexdigest()
        if not is_dataclass(value):
            return self._hashed(value)
        known = self._values.get(id(value))
        if known is None or known[0]() is not value:
            known = weakref.ref(value), self._hashed(value)
            self._values[id(value)] = known
        return known[1]

    def of_file(self, path: Path) -> str:
        """SHA-256 of a file's bytes; of a folder, that of its files' names and bytes."""
        if path.is_dir():
            files = sorted(file for file in path.rglob("*") if file.is_file())
            inside = [f"{file.relative_to(path).as_posix()} {self.of_file(file)}" for file in files]
            return hashlib.sha256("\n".join(inside).encode()).hexdigest()
        stat = path.stat()
        identity = (path, stat.st_mtime_ns, stat.st_size)
        if identity not in self._files:
            self._files[identity] = file_sha256(path)
        return self._files[identity]

    def _hashed(self, value: object) -> str:
        arrays: list[np.ndarray] = []
        tree = to_tree(value, arrays, lambda path: f"{path.name} {self.of_file(path)}")
        digest = hashlib.sha256(json.dumps(tree, sort_keys=True).encode())
        for array in arrays:
            digest.update(f"{array.dtype.str}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
        return digest.hexdigest()


def file_sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def sha256_if_readable(path: Path) -> str:
    """SHA-256 of a file's bytes, or "unreadable": whoever needs the file reports why."""
    try:
        return file_sha256(path)
    except OSError:
        return "unreadable"


@cache
def code_version(module: str) -> str:
    """Hash of a module's source and of all limbgram modules that it imports, and theirs.

    The versions of Python and of the libraries that they import are in it.
    """
    if not module.startswith("limbgram"):
        return module
    waiting, sources, libraries = [module], dict[str, _Source](), set[str]()
    while waiting:
        name = waiting.pop()
        source = None if name in sources else _source(name)
        if source is not None:
            sources[name] = source
            waiting.extend(source.ours)
            libraries |= source.libraries
    digest = hashlib.sha256(platform.python_version().encode())
    for library, found in library_versions(frozenset(libraries)).items():
        digest.update(f"{library} {found}\n".encode())
    for name in sorted(sources):
        digest.update(name.encode() + b"\0" + sources[name].content + b"\0")
    return digest.hexdigest()


def library_versions(imported: frozenset[str]) -> dict[str, str]:
    """Version of each library among imported modules and behind them; "none": not installed."""
    used = imported | {one for name in imported for one in _BEHIND.get(name, ())}
    return {name: _library_version(name) for name in sorted(used - sys.stdlib_module_names)}


@cache
def _library_version(module: str) -> str:
    found = sorted(set(_distributions(module)))
    return ", ".join(f"{one} {version(one)}" for one in found) or "none"


def _distributions(module: str) -> list[str]:
    return _all_distributions().get(module, [])


@cache
def _all_distributions() -> dict[str, list[str]]:
    """Installed distributions by the modules that they provide."""
    return {name: list(found) for name, found in packages_distributions().items()}


@dataclass(frozen=True)
class _Source:
    """A module's source and what it imports."""

    content: bytes
    ours: frozenset[str]
    libraries: frozenset[str]


@cache
def _source(module: str) -> _Source | None:
    """A limbgram module's source; None: there is no such module. Many stages share it."""
    file = _source_file(module)
    if file is None:
        return None
    content = file.read_bytes()
    imported = set(_imported(content))
    ours = {name for name in imported if name.partition(".")[0] == _PACKAGE.name}
    return _Source(
        content, frozenset(ours), frozenset(name.partition(".")[0] for name in imported - ours)
    )


def _source_file(module: str) -> Path | None:
    place = _PACKAGE.joinpath(*module.split(".")[1:])
    candidates = (place.with_suffix(".py"), place / "__init__.py")
    return next((file for file in candidates if file.is_file()), None)


def _imported(source: bytes) -> Iterator[str]:
    """Modules that a source imports, by name in a call of import_module too."""
    for node in ast.walk(_imports(source)):
        match node:
            case ast.ImportFrom(module=str(module), level=0):
                yield module
                yield from (f"{module}.{alias.name}" for alias in node.names)
            case ast.Import():
                yield from (alias.name for alias in node.names)
            case ast.Call(func=ast.Name("import_module"), args=[ast.Constant(str(module))]):
                yield module
            case _:
                pass


def _imports(source: bytes) -> ast.Module:
    """The parsed import statements of a source; the whole source if their lines do not parse.

    Parsing whole files takes ten times as long.
    """
    with PARSING:
        if b"import_module(" not in source:
            with suppress(SyntaxError):  # lines of a text that look like imports
                return ast.parse(b"\n".join(line.lstrip() for line in _IMPORT.findall(source)))
        return ast.parse(source)
