"""Shape cache: the edited shapes, in memory as long as their files do not change."""

import threading
from collections import OrderedDict
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from limbgram.cases.workspace import CaseLocks, Work, Workspace
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.formats.reading import ShapeFile
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import Measures, measure_limb
from limbgram.workbench.recipe.recipe import Recipe, ReplayCache, Replayed, replay

_MOST_OPEN = 3
"""Shapes in memory; one of 250,000 triangles with its edits takes 150 MB."""

Key = tuple[tuple[str, int, int], ...]


@dataclass
class OpenShape:
    """A scan in memory, and the cached results of its recipes."""

    file: ShapeFile
    key: Key
    kept: ReplayCache
    lock: threading.RLock = field(default_factory=threading.RLock)
    """Held while a recipe is replayed."""

    @property
    def limb(self) -> Limb:
        return self.file.limb

    @cached_property
    def tree(self) -> TriangleTree:
        """For closest points on it."""
        return tree_on(self.limb.mesh)

    @cached_property
    def measures(self) -> Measures:
        """Of the scan as it lies here, which every tape reading is held against.

        Raises:
            MeasureError: the limb is not aligned.
        """
        return measure_limb(self.limb)

    def replayed(self, recipe: Recipe) -> Replayed:
        """The shape after a recipe; only edits that changed are computed."""
        with self.lock:
            return replay(recipe, self.limb, self.kept)


@dataclass
class ShapeCache:
    """The shapes that were used last."""

    made: dict[Path, tuple[str | None, str]] = field(
        default_factory=dict[Path, tuple[str | None, str]]
    )
    """By work folder: id of the act that changed the recipe last, and that recipe's mark."""
    _open: "OrderedDict[Path, OpenShape]" = field(default_factory=lambda: OrderedDict())
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _changing: CaseLocks = field(default_factory=CaseLocks)
    _reading: CaseLocks = field(default_factory=CaseLocks)

    @contextmanager
    def changing(self, workspace: Workspace) -> Generator[None]:
        """Lock a case from reading its recipe or landmarks until the change is saved.

        Without it, of two changes at once the second would undo the first. The lock belongs to the
        case, not to the cached shape, which is replaced when its files change. Deleting the case
        takes it too.

        Raises:
            LookupError: the case was deleted meanwhile.
        """
        with self._changing.of(workspace.root):
            workspace.case.require_here()
            yield

    def work(self, workspace: Workspace) -> Work:
        """A snapshot of a case's work, from which a file or a record is made."""
        with self.changing(workspace):
            shape, recipe = self.shape(workspace), workspace.recipe()
            recipe_sha256, beside = (
                workspace.recipe_sha256(),
                limb_file_beside(workspace.scan_file()),
            )
            limb_file_sha256 = hash_of(beside.read_bytes()) if beside.is_file() else None
        return Work(
            scan=shape.file,
            limb_file_sha256=limb_file_sha256,
            recipe=recipe,
            recipe_sha256=recipe_sha256,
            done=shape.replayed(recipe),
        )

    def shape(self, workspace: Workspace) -> OpenShape:
        """The scan of a case, read again if its files changed; other cases do not wait."""
        with self._reading.of(workspace.root):
            place = workspace.scan_file()
            key = _key(place)
            with self._lock:
                known = self._open.get(place)
            if known is None or known.key != key:
                read = workspace.read()
                known = OpenShape(read, key, ReplayCache(read.limb))
            with self._lock:
                self._open[place] = known
                self._open.move_to_end(place)
                while len(self._open) > _MOST_OPEN:
                    self._open.popitem(last=False)
            return known

    def forget(self, workspace: Workspace) -> None:
        """Remove a case's shape from the cache."""
        with self._lock:
            for place in [place for place in self._open if place.parent == workspace.root]:
                del self._open[place]


def _key(place: Path) -> Key:
    """A key that changes when the shape's file or its limb file is written."""
    files = (place, limb_file_beside(place))
    statuses = ((file, file.stat()) for file in files if file.is_file())
    return tuple((file.name, status.st_mtime_ns, status.st_size) for file, status in statuses)
