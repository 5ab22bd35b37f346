"""Fingerprints: what a product depends on, as one short text.

A product's key is the hash of its inputs (their content, files included), its options and the
source code that makes it. Equal keys, equal product: nothing is computed twice.
"""

import ast
import hashlib
import json
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np

import limbgram
from limbgram.cases.keeping.encoding import to_tree

_PACKAGE = Path(limbgram.__file__).parent


@dataclass
class Fingerprints:
    """Hashes of values; a product or a file that was hashed is not hashed again."""

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


@cache
def code_version(module: str) -> str:
    """Hash of a module's source and of all limbgram modules that it imports, and theirs."""
    if not module.startswith("limbgram"):
        return module
    waiting, sources = [module], dict[str, bytes]()
    while waiting:
        name = waiting.pop()
        file = _source_file(name)
        if name in sources or file is None:
            continue
        sources[name] = file.read_bytes()
        waiting.extend(_imported(sources[name]))
    digest = hashlib.sha256()
    for name in sorted(sources):
        digest.update(name.encode() + b"\0" + sources[name] + b"\0")
    return digest.hexdigest()


def _source_file(module: str) -> Path | None:
    place = _PACKAGE.joinpath(*module.split(".")[1:])
    candidates = (place.with_suffix(".py"), place / "__init__.py")
    return next((file for file in candidates if file.is_file()), None)


def _imported(source: bytes) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("limbgram"):
            yield str(node.module)
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.startswith("limbgram."))
