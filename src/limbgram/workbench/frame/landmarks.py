"""Landmarks: the places by the kind of limb, where they tell the limb to face, and picking them.

What a name means, in any language, `landmark_names` tells. A name that no template knows is kept as
it is; it does not turn the limb. A limb's mesh is put in its limb frame, and back, here too.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from types import MappingProxyType
from typing import Literal

import numpy as np

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.frame.landmark_names import known_identity, named, names_of, words_of
from limbgram.workbench.limb import KINDS, Kind, Landmark, Limb, LimbFrame, likeliest

Facing = Literal["anterior", "posterior", "medial", "lateral", "right", "left", "none"]
"""Side of the limb on which a landmark lies; medial and lateral need the limb's side."""
_ALIKE = 0.8
"""Names that share so much of their letters are one, with a slip of the pen (difflib's ratio)."""


@dataclass(frozen=True, kw_only=True)
class LandmarkName:
    """A place that clinicians know by name."""

    name: str
    """Its identity."""
    facing: Facing
    level: int
    """Order along the limb: one of higher level lies more proximal. Equal ones tell nothing."""


def _names(*rows: tuple[str, Facing, int]) -> tuple[LandmarkName, ...]:
    return tuple(
        LandmarkName(name=name, facing=facing, level=level) for name, facing, level in rows
    )


NAMES: Mapping[Kind, tuple[LandmarkName, ...]] = MappingProxyType(
    {
        "transtibial": _names(
            ("mid patella", "anterior", 5),
            ("patellar tendon", "anterior", 4),
            ("medial tibial condyle", "medial", 4),
            ("popliteal crease", "posterior", 4),
            ("tibial tubercle", "anterior", 3),
            ("fibula head", "lateral", 3),
            ("tibial crest", "anterior", 2),
            ("fibula end", "lateral", 1),
            ("tibia end", "anterior", 1),
            ("distal end", "none", 0),
        ),
        "transfemoral": _names(
            ("anterior superior iliac spine", "anterior", 5),
            ("greater trochanter", "lateral", 4),
            ("ischial tuberosity", "posterior", 3),
            ("adductor longus tendon", "medial", 3),
            ("perineum", "medial", 3),
            ("femur end", "none", 1),
            ("distal end", "none", 0),
        ),
        "foot": _names(
            ("tibial tubercle", "anterior", 5),
            ("fibula head", "lateral", 5),
            ("tibial crest", "anterior", 4),
            ("medial malleolus", "medial", 3),
            ("lateral malleolus", "lateral", 3),
            ("navicular", "medial", 2),
            ("heel", "posterior", 1),
            ("first metatarsal head", "anterior", 1),
            ("fifth metatarsal head", "anterior", 1),
            ("second toe", "anterior", 1),
        ),
        "torso": _names(
            ("seventh cervical vertebra", "posterior", 6),
            ("sternal notch", "anterior", 6),
            ("right axilla", "right", 5),
            ("left axilla", "left", 5),
            ("xiphoid", "anterior", 4),
            ("navel", "anterior", 3),
            ("right iliac spine", "anterior", 2),
            ("left iliac spine", "anterior", 2),
            ("sacrum", "posterior", 2),
            ("right trochanter", "right", 1),
            ("left trochanter", "left", 1),
            ("pubic symphysis", "anterior", 1),
        ),
    }
)


@dataclass(frozen=True, kw_only=True)
class PickOptions:
    """How far from the surface a place may be picked."""

    max_distance_mm: float = 10.0


DEFAULTS = PickOptions()


def landmark(limb: Limb, name: str) -> Landmark:
    """The limb's landmark of that name.

    Raises:
        MeasureError: the limb has none of that name.
    """
    found = named(name, limb.landmarks)
    if found is not None:
        return found
    names = tuple(mark.name for mark in limb.landmarks)
    raise MeasureError(
        "landmark.none", name=name, names=names or None, meant=likeliest(name, names)
    )


def with_landmarks(limb: Limb, picked: Sequence[Landmark], options: PickOptions = DEFAULTS) -> Limb:
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
        if not off_mm <= options.max_distance_mm:
            raise MeasureError(
                "landmark.off_surface",
                name=name,
                point_mm=tuple(mark.position_mm.tolist()),
                off_mm=float(off_mm),
                most_mm=options.max_distance_mm,
            )
    kept = tuple(mark for mark in limb.landmarks if mark.name not in names)
    snapped = tuple(
        Landmark(name=name, position_mm=place.copy())
        for name, place in zip(names, closest.points_mm)
    )
    return replace(limb, landmarks=kept + snapped)


def known_name(name: str, kind: Kind) -> LandmarkName | None:
    """What the template of a kind of limb knows of a name, in any language."""
    return next((row for row in NAMES[kind] if row.name == known_identity(name)), None)


def known_anywhere(name: str, kind: Kind | None) -> LandmarkName | None:
    """What the template of the kind knows of a name, or else any template.

    A place of one name lies on the same side of every kind of limb, at another level.
    """
    first = () if kind is None else (kind,)
    found = (known_name(name, one) for one in (*first, *KINDS))
    return next((row for row in found if row is not None), None)


def likely_meant(name: str, kind: Kind | None) -> str | None:
    """The known place for whose name, in any language, a name is a slip of the pen."""
    if known_anywhere(name, kind) is not None:
        return None
    kinds = KINDS if kind is None else (kind,)
    names = names_of(row.name for one in kinds for row in NAMES[one])
    near = get_close_matches(" ".join(words_of(name)), names, n=1, cutoff=_ALIKE)
    return names[near[0]] if near else None


def in_limb_frame(limb: Limb) -> Mesh:
    """The mesh with its vertices in the limb frame.

    Raises:
        MeasureError: the limb is not aligned.
    """
    return limb.mesh.with_vertices(frame_of(limb).limb_from_mesh.apply(limb.mesh.vertices_mm))


def with_vertices_in_limb(limb: Limb, vertices_in_limb_mm: Points3) -> Limb:
    """The limb with its vertices moved to places given in the limb frame."""
    mesh_from_limb = frame_of(limb).limb_from_mesh.inverse
    return limb.with_mesh(limb.mesh.with_vertices(mesh_from_limb.apply(vertices_in_limb_mm)))


def frame_of(limb: Limb) -> LimbFrame:
    """The limb's frame.

    Raises:
        MeasureError: the limb is not aligned.
    """
    if limb.frame is None:
        raise MeasureError("align.not_aligned")
    return limb.frame
