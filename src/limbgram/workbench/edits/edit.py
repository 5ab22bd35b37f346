"""An edit: one adjustment of a limb, and all that recipes, ledger, forms and help know of it.

A kind of edit is one file of this folder:

    @edit(group="ends", order=1, effect=Effect(), example={"length_mm": 20.0})
    class Extension(Edit):
        \"\"\"Raise the brim along the limb's axis to a level edge.\"\"\"

        length_mm: AboveZeroMm
        \"\"\"From the highest point of the brim as it is to the new, level edge.\"\"\"

        words = spoken(
            en=Words(name="Raise the brim", title="The extension"),
            de=Words(name="Rand erhöhen", title="Die Randerhöhung", does=..., labels=..., help=...),
        )

        def apply(self, limb: Limb) -> Limb: ...

`editing.py` finds it there. Recipes call it by its class in small letters: PlaneCut is "plane-cut".
The docstring says what it does, and the text under each field what that parameter means. Ranges
that stand beside a field's type, lengths that no limb has, the surface that is left, and landmarks
are `do_edit`'s work.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import Field, dataclass, field
from functools import cache
from typing import Annotated, Any, ClassVar, Final, Literal, TypeVar, dataclass_transform, get_args

from limbgram.core.request_fields import Within, declared, purpose_of
from limbgram.findings import LANGUAGES
from limbgram.workbench.anatomy.kind import strings_in
from limbgram.workbench.limb import KIND_NAMED, Kind, KindName, Limb

RESIDUAL_LIMBS: Final[tuple[KindName | None, ...]] = (
    None,
    *(name for name, kind in KIND_NAMED.items() if kind.round_ended),
)
"""Kinds that end round, as a residual limb does, and the limb whose kind nobody said."""
LONGEST_MM = 2000.0
"""No limb is longer, and nothing on it is."""
AboveZeroMm = Annotated[float, Within(0, LONGEST_MM, above=True)]
FromZeroMm = Annotated[float, Within(0, LONGEST_MM)]

Group = Literal[
    "scan", "areas", "orthosis", "levels", "surface", "ends", "cuts", "solids", "learned"
]
"""In the order in which help and forms list them."""
GROUP_NAMES: Mapping[str, Mapping[Group, str]] = {
    "en": {
        "scan": "The scan",
        "areas": "Areas",
        "orthosis": "Orthoses",
        "levels": "By levels",
        "surface": "The whole surface",
        "ends": "Brim and distal end",
        "cuts": "Cuts",
        "solids": "Holes, wall, side",
        "learned": "Learned",
    },
    "de": {
        "scan": "Der Scan",
        "areas": "Bereiche",
        "orthosis": "Orthesen",
        "levels": "Nach Höhe",
        "surface": "Die ganze Fläche",
        "ends": "Rand und distales Ende",
        "cuts": "Schnitte",
        "solids": "Löcher, Wand, Seite",
        "learned": "Gelernt",
    },
}


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What an edit does to a positive, as far as the ledger has to know it."""

    moves_skin: bool = False
    """The ledger counts it where the limb bears no pressure: pressure there, or room."""
    at_place: Literal["carves", "builds"] | None = None
    """What it does at a place that somebody chooses (`at`), to a stated depth (`depth_mm`): there a
    depth beyond the usual has to be meant, and, of what carves, a place that bears no pressure."""
    reports_displacement: bool = True
    """The ledger says how far the surface moved. That means nothing where all of it moved, or where
    parts were only added or taken away: the cover of a cut lies deep inside, but presses not."""
    volume: Literal["compares", "cuts", "becomes"] = "compares"
    """How volumes before and after compare: all that lies between the same heights; not what is
    cut away, though the cut be closed by a cover; or not at all, as a wall encloses its material
    and no longer the limb."""
    start: Literal["stays", "follows", "anew"] = "stays"
    """The skin from which depths count: it stays, the edit is done to it too, or it is what the
    edit made."""


@dataclass(frozen=True, kw_only=True)
class Words:
    """The words for people of a kind of edit, in one language."""

    name: str = ""
    """In lists and forms: "Raise the brim"."""
    title: str = ""
    """What sentences begin with: "The extension"."""
    does: str = ""
    """What it does; in English its docstring."""
    labels: Mapping[str, str] = field(default_factory=dict[str, str])
    """What its parameters are called; in English their names, where nothing is said."""
    help: Mapping[str, str] = field(default_factory=dict[str, str])
    """What they mean; in English the text under them."""
    choices: Mapping[str, str] = field(default_factory=dict[str, str])
    """What words to choose from are called."""


@dataclass(frozen=True, kw_only=True)
class About:
    """What the program knows of a kind of edit besides its parameters."""

    group: Group
    order: int
    """Within its group."""
    effect: Effect
    everyday: bool
    """The app offers it to everybody, not to experts alone."""
    rarely: tuple[str, ...]
    """Parameters for which the app asks experts alone."""
    guarded: bool
    """`do_edit` refuses a surface that it folds, tears or pushes through itself. False where it
    looks itself, against the triangles that it made finer first, or turns the whole surface."""
    kinds: tuple[KindName | None, ...]
    """The kinds of limb that it is for, None for one that nobody said; empty: for all."""
    example: Mapping[str, Any]
    """Parameters with which it does something to a limb, as a recipe has them: tests try these."""


class Edit(ABC):
    """A kind of edit, with its parameters."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    about: ClassVar[About]
    title: ClassVar[str]
    """What messages call it."""
    words: ClassVar[Mapping[str, Words]]
    """By language; `words_in` adds what the source says, and what a base class has."""

    def check(self) -> None:  # noqa: B027 - most have nothing to add
        """Refuse numbers that make sense on no limb beyond their ranges, before there is one.

        Raises:
            EditError: says which.
        """

    def repeated(self, after: Limb) -> "Edit":  # noqa: ARG002 - most do the same to any skin
        """The edit that moves another skin of the limb as this one moved what became `after`."""
        return self

    def places_of(self, kind: Kind) -> Iterable[str]:  # noqa: ARG002 - most name theirs
        """Names of the landmarks, directions and joints that its work on a kind of limb goes by.

        Those are in its parameters, among other words; an edit that goes by others says so.
        """
        return strings_in(self)

    @abstractmethod
    def apply(self, limb: Limb) -> Limb:
        """The limb after the edit, whose numbers have been checked; see `editing.do_edit`.

        Raises:
            EditError: the edit makes no sense on this limb, or would spoil its surface.
        """


EditType = TypeVar("EditType", bound=type[Edit])


@dataclass_transform(frozen_default=True, kw_only_default=True)
def edit(
    *,
    group: Group,
    order: int,
    effect: Effect,
    everyday: bool = False,
    rarely: tuple[str, ...] = (),
    guarded: bool = True,
    kinds: tuple[KindName | None, ...] = (),
    example: Mapping[str, Any],
) -> Callable[[EditType], EditType]:
    """Make a class a kind of edit: a frozen dataclass that knows what `About` says.

    Raises:
        TypeError: it has a depth at a chosen place, and does not say whether it carves or builds up
            there; or the other way round.
    """

    def decorated(kind: EditType) -> EditType:
        dataclass(frozen=True, kw_only=True)(kind)
        if ({"at", "depth_mm"} <= kind.__dataclass_fields__.keys()) != (
            effect.at_place is not None
        ):
            raise TypeError(
                f"{kind.__name__}: Effect.at_place goes with the fields at and depth_mm"
            )
        kind.about = About(
            group=group,
            order=order,
            effect=effect,
            everyday=everyday,
            rarely=rarely,
            guarded=guarded,
            kinds=kinds,
            example=example,
        )
        kind.title = kind.words[LANGUAGES[0]].title
        return kind

    return decorated


def spoken(*, en: Words, de: Words) -> Mapping[str, Words]:
    """Words by language."""
    return {"en": en, "de": de}


def name_of(kind: type[Edit]) -> str:
    """The name by which recipes call it."""
    return re.sub(r"(?<!^)([A-Z])", r"-\1", kind.__name__).lower()


def sort_key(kind: type[Edit]) -> tuple[int, int, str]:
    """The key by which edits are sorted."""
    return get_args(Group).index(kind.about.group), kind.about.order, kind.__name__


@cache
def words_in(kind: type[Edit], language: str) -> Words:
    """All words for people of a kind of edit; where a language lacks one, the English one."""
    spoken = _declared_words(kind, language)
    if language == LANGUAGES[0]:
        source = {one.name: one.meaning for one in declared(kind)}
        plain = {name: _plain_label(name) for name in source}
        first = Words(does=purpose_of(kind), labels=plain, help=source)
    else:
        first = words_in(kind, LANGUAGES[0])
    return _merged_words(first, spoken)


def _declared_words(kind: type[Edit], language: str) -> Words:
    """The words that a class and its base classes declare in a language."""
    found = Words()
    for decorated in reversed(kind.__mro__):
        words: Mapping[str, Words] = vars(decorated).get("words", {})
        found = _merged_words(found, words.get(language, Words()))
    return found


def _merged_words(first: Words, second: Words) -> Words:
    """The second words, and the first ones where the second have none."""
    return Words(
        name=second.name or first.name,
        title=second.title or first.title,
        does=second.does or first.does,
        labels={**first.labels, **second.labels},
        help={**first.help, **second.help},
        choices={**first.choices, **second.choices},
    )


def _plain_label(name: str) -> str:
    """A parameter's name in words: "Height" of `height_mm`."""
    return re.sub(r"_(mm|deg)$", "", name).replace("_", " ").capitalize()
