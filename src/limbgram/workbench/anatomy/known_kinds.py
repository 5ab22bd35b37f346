"""Known kinds of limb by name, each from its file in `workbench/kinds`; the names as a type."""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Final, Literal

from limbgram.workbench import kinds
from limbgram.workbench.anatomy.kind import Kind


def _load_kinds() -> Iterator[Kind]:
    for file in iter_modules(kinds.__path__):
        one: Kind = import_module(f"{kinds.__name__}.{file.name}").KIND
        yield one


KIND_NAMED: Final[dict[str, Kind]] = {
    one.name: one for one in sorted(_load_kinds(), key=lambda kind: kind.order)
}
"""Every kind of limb by its name, in the order of lists."""
KINDS: Final[tuple[str, ...]] = tuple(KIND_NAMED)
"""Their names."""
if TYPE_CHECKING:
    KindName = str
else:
    KindName = Literal[KINDS]
    """What files, forms and the command line take: checked where they are read."""
