"""Landmarks: the places by the kind of limb, where they tell the limb to face, and picking them.

What a name means, in any language, `kinds/names` tells. A name that no kind knows is kept as it is;
it does not turn the limb. A limb's mesh is put in its limb frame, and back, here too.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from types import MappingProxyType

import numpy as np

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.known_words import likeliest
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import Finding, doubt
from limbgram.workbench.anatomy.kind import Place
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.names import (
    identity_of,
    known_identity,
    landmark_named,
    names_of,
    normalised_name,
)
from limbgram.workbench.limb import KINDS, AnyLimb, KindName, Landmark, Limb

ALIKE = 0.8
"""Names that share so much of their letters are one, with a slip of the pen (difflib's ratio)."""
_FARTHEST_PICK_MM = 10.0
"""How far from the surface a place may be picked."""
NAMES: Mapping[KindName, tuple[Place, ...]] = MappingProxyType(
    {name: kind.asked for name, kind in KIND_NAMED.items()}
)
"""The places that are asked for of each kind of limb."""


def landmark(limb: Limb, name: str) -> Landmark:
    """The limb's landmark of that name.

    Raises:
        MeasureError: the limb has none of that name.
    """
    found = landmark_named(name, limb.landmarks)
    if found is not None:
        return found
    names = tuple(mark.name for mark in limb.landmarks)
    raise MeasureError(
        "landmark.none", name=name, names=names or None, meant=likeliest(name, names)
    )


def with_landmarks(limb: AnyLimb, picked: Sequence[Landmark]) -> AnyLimb:
    """The limb with more landmarks, each moved to the nearest place on the surface.

    One of a name that the limb has already takes its place.

    Raises:
        OptionsError: a name without letters, or twice.
        MeasureError: a place far from the surface.
    """
    if not picked:
        return limb
    names = [mark.name.strip() for mark in picked]
    if not all(names) or len(set(names)) < len(names):
        raise OptionsError("landmark.names", names=tuple(names))
    tree = tree_on(limb.mesh)
    closest = tree.closest(np.stack([mark.position_mm for mark in picked]).astype(np.float64))
    for name, mark, off_mm in zip(names, picked, closest.distances_mm):
        if not off_mm <= _FARTHEST_PICK_MM:
            raise MeasureError(
                "landmark.off_surface",
                name=name,
                point_mm=tuple(mark.position_mm.tolist()),
                off_mm=float(off_mm),
                most_mm=_FARTHEST_PICK_MM,
            )
    kept = tuple(mark for mark in limb.landmarks if mark.name not in names)
    snapped = tuple(
        replace(mark, name=name, position_mm=place.copy())
        for name, mark, place in zip(names, picked, closest.points_mm)
    )
    return replace(limb, landmarks=kept + snapped)


def unconfirmed_finding(limb: Limb, used: Iterable[str] | None = None) -> Finding | None:
    """A doubt about used landmarks that nobody has confirmed; None if there are none.

    Args:
        used: Names of the landmarks that it goes by; None for all of the limb's.
    """
    meant = None if used is None else {identity_of(name) for name in used}
    names = tuple(
        mark.name
        for mark in limb.landmarks
        if not mark.confirmed and (meant is None or identity_of(mark.name) in meant)
    )
    return doubt("landmark.unconfirmed", names=names) if names else None


def notes_but_unconfirmed(limb: Limb) -> tuple[Finding, ...]:
    """The limb's notes without those of unconfirmed landmarks.

    What is made of the limb says itself which of these it relies on.
    """
    return tuple(one for one in limb.notes if one.code != "landmark.unconfirmed")


def with_confirmed(limb: AnyLimb, names: Sequence[str]) -> AnyLimb:
    """The limb after somebody has looked at proposals, and says that they stand where they should.

    Raises:
        MeasureError: the limb has no landmark of such a name.
    """
    meant = {id(landmark(limb, name)) for name in names}
    return replace(
        limb,
        landmarks=tuple(
            replace(mark, confirmed=True) if id(mark) in meant else mark for mark in limb.landmarks
        ),
    )


def known_name(name: str, kind: KindName) -> Place | None:
    """The kind's place that a name means, in any language."""
    return next((row for row in NAMES[kind] if row.identity == known_identity(name)), None)


def known_anywhere(name: str, kind: KindName | None) -> Place | None:
    """The kind's place that a name means, or else any kind's.

    A place of one name lies on the same side of every kind of limb, at another level.
    """
    first = () if kind is None else (kind,)
    found = (known_name(name, one) for one in (*first, *KINDS))
    return next((row for row in found if row is not None), None)


def likely_meant(name: str, kind: KindName | None) -> str | None:
    """The known place whose name, in any language, was probably misspelt."""
    if known_anywhere(name, kind) is not None:
        return None
    kinds = KINDS if kind is None else (kind,)
    names = names_of(row.identity for one in kinds for row in NAMES[one])
    near = get_close_matches(" ".join(normalised_name(name)), names, n=1, cutoff=ALIKE)
    return names[near[0]] if near else None
