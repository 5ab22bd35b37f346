"""Stage cache: a run that keeps the product of every stage, and reuses it.

A product is reused if its key (inputs, options, code) is the wanted one and its files are intact;
otherwise the stage runs. Resuming a run and recomputing only what changed are thus the same.

stage.json holds the hashes of the product's two files and is sealed: a changed byte in any of the
three is noticed.
"""

import inspect
import json
import typing
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np

from limbgram.cases.encoding import from_tree, sealed, to_tree, unsealed
from limbgram.cases.fingerprint import Fingerprints, file_sha256
from limbgram.cases.folder import CaseFolder, with_disk_advice
from limbgram.core.files import written_whole
from limbgram.core.run import Run, Timing
from limbgram.core.typed import Mismatch

P = ParamSpec("P")
T = TypeVar("T")

_SCHEMA = "limbgram-stage/2"
_PRODUCT, _ARRAYS, _STAGE = "product.json", "arrays.npz", "stage.json"


@dataclass
class CachingRun(Run):
    """A run whose products are kept in a case folder."""

    case: CaseFolder = field(kw_only=True)
    reused: list[str] = field(default_factory=list)
    """Stages whose kept product was reused."""
    keys: dict[str, str] = field(default_factory=dict)
    """Key of each stage's product, in the order in which they were called."""
    _fingerprints: Fingerprints = field(default_factory=Fingerprints)

    def __call__(self, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        name = self._fresh_name(stage)
        folder = self.case.stages / name
        bound = inspect.signature(stage).bind(*args, **kwargs)
        bound.apply_defaults()
        key = self._fingerprints.key(stage, tuple(bound.arguments.values()))
        hint = typing.get_type_hints(stage)["return"]
        self.keys[name] = key
        self._stage = stage.__name__.replace("_", " ")
        self.report(0, 0)
        with suppress(LookupError):
            kept, timing = read_product(folder, key, hint, self.case.root)
            self.timings.append(timing)
            self.reused.append(name)
            self.report(1, 1)
            return cast(T, kept)
        product = super().__call__(stage, *args, **kwargs)
        options = _options_tree(bound.arguments.get("options"), self.case.root)
        with with_disk_advice(self.case):
            write_product(folder, key, product, hint, self.timings[-1], options, self.case.root)
        return product

    def unkept(self, stage: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Run a stage without keeping its product: it is cheap, or kept elsewhere."""
        return super().__call__(stage, *args, **kwargs)

    def _fresh_name(self, stage: Callable[..., object]) -> str:
        name = stage.__name__
        count = sum(known.split("-")[0] == name for known in self.keys)
        return name if count == 0 else f"{name}-{count + 1}"


def write_product(
    folder: Path,
    key: str,
    product: object,
    hint: Any,
    timing: Timing,
    options: object,
    root: Path,
) -> None:
    """Write a product under a temporary name, sync it, and rename it.

    Raises:
        TypeError: the product is not of the type that its stage promises.
    """
    arrays: list[np.ndarray] = []
    tree = to_tree(product, arrays, lambda path: _relative(path, root))
    try:
        from_tree(tree, hint, arrays, root)
    except Mismatch as error:
        raise TypeError(f"{folder.name} made a product that cannot be kept: {error}") from error
    folder.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(folder) as beside:
        beside.mkdir()
        (beside / _PRODUCT).write_text(json.dumps(tree), encoding="utf-8")
        np.savez(beside / _ARRAYS, *arrays)
        stage = {
            "schema": _SCHEMA,
            "key": key,
            "sha256": {name: file_sha256(beside / name) for name in (_PRODUCT, _ARRAYS)},
            "timing": to_tree(timing, [], str),
            "options": options,
        }
        (beside / _STAGE).write_text(_text(stage), encoding="utf-8")


def read_product(folder: Path, key: str, hint: Any, root: Path) -> tuple[object, Timing]:
    """The kept product and the timing of its stage.

    Raises:
        LookupError: there is none with this key, or it is damaged.
    """
    try:
        stage = _read((folder / _STAGE).read_text("utf-8"))
        if stage["schema"] != _SCHEMA or stage["key"] != key:
            raise LookupError(f"{folder.name} was made from other inputs")
        for name in (_PRODUCT, _ARRAYS):
            if file_sha256(folder / name) != stage["sha256"][name]:
                raise LookupError(f"{folder / name} is not whole")
        with np.load(folder / _ARRAYS, allow_pickle=False) as kept:
            arrays = [kept[f"arr_{k}"] for k in range(len(kept.files))]
        tree = json.loads((folder / _PRODUCT).read_text("utf-8"))
        product = from_tree(tree, hint, arrays, root)
        return product, from_tree(stage["timing"], Timing, [], root)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile) as error:
        raise LookupError(f"{folder.name} is not kept, or not whole") from error


def _text(stage: dict[str, Any]) -> str:
    """The text of a sealed stage.json."""
    return json.dumps(sealed(stage), indent=1)


def _read(text: str) -> dict[str, Any]:
    """The content of a stage.json.

    Raises:
        LookupError: the text differs from what was written.
    """
    stage = unsealed(json.loads(text))
    if _text(stage) != text:
        raise LookupError("stage.json is not whole")
    return stage


def _relative(path: Path, root: Path) -> str:
    """A path inside the case relative to it, so that the case can be moved; else absolute."""
    resolved = path.resolve()
    inside = resolved.is_relative_to(root.resolve())
    return resolved.relative_to(root.resolve()).as_posix() if inside else str(resolved)


def _options_tree(options: object, root: Path) -> object:
    return None if options is None else to_tree(options, [], lambda path: _relative(path, root))
