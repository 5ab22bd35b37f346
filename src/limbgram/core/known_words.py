"""Known words: a value that is one of several words is refused where it is made if it is another.

A type checker refuses it too; scripts and notebooks mostly run without one, and a word that no
branch knows would silently mean the last of them.
"""

import types
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from typing import Literal, Union, get_args, get_origin, get_type_hints

from limbgram.core.errors import OptionsError


def require_known_words(options: object) -> None:
    """Refuse a field of a dataclass whose type is a Literal and whose value is no word of it.

    Raises:
        OptionsError: names the field, its value and the words that are known.
    """
    for name, known in _words_of(type(options)).items():
        given = getattr(options, name)
        if given not in known:
            words = tuple(str(word) for word in known if word is not None)
            raise OptionsError(
                "options.word",
                option=name,
                given=str(given),
                known=words,
                meant=likeliest(str(given), words),
            )


def likeliest(name: str, known: Iterable[str]) -> str | None:
    """The name that was probably meant; None if none is like.

    Capitals do not count, and a slip of the pen leaves more than half of the letters (difflib).
    """
    by_small = {one.casefold(): one for one in known}
    near = get_close_matches(name.strip().casefold(), by_small, n=1)
    return by_small[near[0]] if near else None


@cache
def _words_of(kind: type) -> dict[str, tuple[object, ...]]:
    """The fields of a class that are a word of a list, or None, and that list."""
    found: dict[str, tuple[object, ...]] = {}
    for name, hint in get_type_hints(kind).items():
        several = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
        words = [get_args(one) for one in several if get_origin(one) is Literal]
        nothing = [(None,) for one in several if one is type(None)]
        if words and len(words) + len(nothing) == len(several):
            found[name] = tuple(word for part in (*words, *nothing) for word in part)
    return found
