"""Verdicts: what became of every photo, why, and what to do about it.

That all photos are placed proves nothing: a scene can be folded over and still have small
residuals. So every placed photo is asked whether its turn against its neighbours is the one that
its pairs, each solved by itself with the cheirality test, found.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.features.keypoints import Features
from limbgram.geometry.rigid import angle_between_deg
from limbgram.mapping.scene import PhotoVerdict, Scene
from limbgram.twoview.pairs import Pairs

_FEW_KEYPOINTS = 200
_CONTRADICTION_DEG = 15.0


def contradicted(scene: Scene, pairs: Pairs) -> Bool[np.ndarray, " p"]:
    """Photos whose pose contradicts the pairs that hold most of their matches.

    Planes are not asked: each allows two poses.
    """
    agreeing, all_matches = np.zeros(len(scene.names)), np.zeros(len(scene.names))
    for pair in pairs.verified:
        first, second = pair.matches.first, pair.matches.second
        placed = scene.camera_from_world[first], scene.camera_from_world[second]
        if pair.kind != "general" or pair.second_from_first is None:
            continue
        if placed[0] is None or placed[1] is None:
            continue
        turn = placed[1].rotation @ placed[0].rotation.T
        agrees = angle_between_deg(turn, pair.second_from_first.rotation) < _CONTRADICTION_DEG
        for photo in (first, second):
            all_matches[photo] += len(pair.matches)
            agreeing[photo] += len(pair.matches) * agrees
    return agreeing < 0.5 * all_matches


def photo_points(scene: Scene) -> Float64[np.ndarray, "p 2"]:
    """Per photo: scene points seen in it, and the RMS distance of their pixels."""
    seen = scene.observations.photo_idx
    squares = np.nansum(scene.residuals_px() ** 2, axis=1)
    count = np.bincount(seen, minlength=len(scene.names)).astype(float)
    total = np.bincount(seen, weights=squares, minlength=len(scene.names))
    return np.column_stack([count, np.sqrt(total / np.maximum(count, 1.0))])


def judge(
    scene: Scene,
    features: Features,
    pairs: Pairs,
    others: Sequence[Scene],
    dropped: dict[int, str],
) -> tuple[PhotoVerdict, ...]:
    """A verdict for every photo.

    Args:
        others: Smaller scenes that could not be joined to this one.
        dropped: Reasons for photos that had a pose and lost it.
    """
    figures = photo_points(scene)
    verdicts: list[PhotoVerdict] = []
    for photo, name in enumerate(scene.names):
        placed = scene.camera_from_world[photo] is not None
        reason = "" if placed else dropped.get(photo) or _why(photo, features, pairs, others)
        verdicts.append(
            PhotoVerdict(
                name=name,
                placed=placed,
                points=int(figures[photo, 0]),
                rms_px=float(figures[photo, 1]) if placed else float("nan"),
                reason=reason,
            )
        )
    return tuple(verdicts)


def _why(photo: int, features: Features, pairs: Pairs, others: Sequence[Scene]) -> str:
    found = len(features.keypoints[photo])
    if found < _FEW_KEYPOINTS:
        return (
            f"Only {found} feature points were found: it is blurred, dark, or the surface is "
            "plain. Take it again in better light, or paint more spots on the sock."
        )
    for other in others:
        if photo in other.placed:
            names = ", ".join(other.names[k] for k in other.placed if k != photo)
            return (
                f"It joins only with {names}, and this group has no firm link to the others. "
                "Take photos that bridge the gap, in steps of 20 degrees or less."
            )
    own = [pair for pair in pairs.verified if photo in (pair.matches.first, pair.matches.second)]
    if not own:
        return (
            "No other photo shows the same points: it lies too far from its neighbours or shows "
            "something else. Take photos between it and the next, in steps of 20 degrees or less."
        )
    if all(pair.kind == "rotation" for pair in own):
        return (
            "It was taken from the same spot as its neighbours, so it gives no depth. "
            "Step sideways between photos."
        )
    return (
        f"It matches {len(own)} photos but fits no pose among the placed ones: the object moved "
        "between the photos, or it is blurred. Take it again."
    )
