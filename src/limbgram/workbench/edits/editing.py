"""Editing: all kinds of edits, loaded from their files, and the function that does any of them."""

from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules
from typing import Final, cast

import numpy as np

from limbgram.core.errors import EditError, refusals_about
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.request_fields import declared
from limbgram.findings import LANGUAGES, doubt
from limbgram.findings.tell import add_terms
from limbgram.workbench import edits
from limbgram.workbench.edits.closing import closed_again
from limbgram.workbench.edits.cutting import ON_CUT_MM
from limbgram.workbench.edits.edit import LONGEST_MM, Edit, name_of, sort_key, words_in
from limbgram.workbench.edits.guard import require_sound
from limbgram.workbench.limb import Limb


def _load_edits() -> Iterator[type[Edit]]:
    """The kinds of edits that the files of this folder hold."""
    for file in iter_modules(edits.__path__):
        name = f"{edits.__name__}.{file.name}"
        if name == __name__:
            continue
        for one in vars(import_module(name)).values():
            if isinstance(one, type) and one.__module__ == name and "about" in vars(one):
                yield cast(type[Edit], one)


EDITS: Final[tuple[type[Edit], ...]] = tuple(sorted(_load_edits(), key=sort_key))
"""Every kind of edit, in the order in which help lists them; edit.py says what one consists of."""

EDIT_NAMED: Final[dict[str, type[Edit]]] = {name_of(kind): kind for kind in EDITS}
"""The same by the names that recipes use."""


def _terms(language: str) -> dict[str, str]:
    """Names and help of edits and their parameters in a language, by the English ones."""
    found: dict[str, str] = {}
    for kind in EDITS if language != LANGUAGES[0] else ():
        english, words = words_in(kind, LANGUAGES[0]), words_in(kind, language)
        found[english.title] = words.title
        found |= {label: words.labels[name] for name, label in english.labels.items()}
        found |= {text: words.help[name] for name, text in english.help.items() if text}
    return found


add_terms(_terms)


def require_valid(edit: Edit) -> None:
    """Refuse parameters that are invalid on every limb, before there is one.

    Raises:
        EditError: an amount out of its range, or lists of different lengths.
    """
    with refusals_about(edit.title):
        for field in declared(type(edit)):
            for number in _numbers(getattr(edit, field.name)):
                if field.within is not None and not field.within.holds(number):
                    raise EditError(
                        "edit.out_of_range",
                        name=field.name,
                        label=_label(edit, field.name),
                        number=number,
                        least=field.within.least,
                        most=field.within.most,
                        above=field.within.above,
                        unit=field.unit or None,
                        meaning=field.meaning or None,
                    )
                if field.name.endswith("_mm") and not abs(number) <= LONGEST_MM:
                    raise EditError(
                        "edit.longer_than_limb",
                        name=field.name,
                        label=_label(edit, field.name),
                        length_mm=number,
                    )
        edit.check()


def do_edit(limb: Limb, edit: Edit) -> Limb:
    """The limb after an edit; a landmark whose part of the surface is cut off goes with it.

    A solid stays one: what an edit opens of it is closed along the cut.

    Raises:
        EditError: the edit makes no sense on this limb, or would spoil its surface, or open a
            solid that cannot be closed again.
    """
    require_valid(edit)
    with refusals_about(edit.title):
        if edit.about.kinds and limb.kind not in edit.about.kinds:
            raise EditError(
                "edit.kind",
                kind=limb.kind,
                kinds=tuple(one for one in edit.about.kinds if one is not None),
            )
        after = edit.apply(limb)
        after = after.with_mesh(closed_again(limb.mesh, after.mesh))
        if edit.about.guarded:
            require_sound(limb.mesh, after.mesh)
    return _with_landmarks_on_surface(limb, after, moved=edit.about.effect.moves_skin)


def _label(edit: Edit, name: str) -> str:
    return words_in(type(edit), LANGUAGES[0]).labels[name]


def _numbers(value: object) -> tuple[float, ...]:
    """The numbers of a parameter: one, several, or none."""
    several = cast(tuple[object, ...], value) if isinstance(value, tuple) else (value,)
    return tuple(
        one for one in several if isinstance(one, int | float) and not isinstance(one, bool)
    )


def _with_landmarks_on_surface(before: Limb, after: Limb, *, moved: bool) -> Limb:
    """The limb with its landmarks on the surface.

    Those that an edit left in the air go back to the skin where it moved the skin; where it cut
    they are gone, and the notes name them.
    """
    if not after.landmarks:
        return after
    off_mm = {mark.name: 0.0 for mark in after.landmarks} | _landmark_distances_mm(before)
    left = _landmark_distances_mm(after)
    lost = [name for name, found_mm in left.items() if found_mm > off_mm[name] + ON_CUT_MM]
    if not lost:
        return after
    if moved:
        places = np.stack([mark.position_mm for mark in after.landmarks])
        nearest = tree_on(after.mesh).closest(places).points_mm
        glued = (
            replace(mark, position_mm=place.copy()) if mark.name in lost else mark
            for mark, place in zip(after.landmarks, nearest, strict=True)
        )
        return replace(after, landmarks=tuple(glued))
    kept = tuple(mark for mark in after.landmarks if mark.name not in lost)
    notes = tuple(doubt("edit.landmark.cut_off", name=name) for name in lost)
    return replace(after, landmarks=kept, notes=(*after.notes, *notes))


def _landmark_distances_mm(limb: Limb) -> dict[str, float]:
    """How far each landmark lies from the surface."""
    if not limb.landmarks:
        return {}
    places = np.stack([mark.position_mm for mark in limb.landmarks])
    found = tree_on(limb.mesh).closest(places).distances_mm
    return {mark.name: float(off) for mark, off in zip(limb.landmarks, found, strict=True)}
