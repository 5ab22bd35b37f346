"""Lenses: which lenses of single photos, and which file of a camera, are told as facts.

In      a scene with the lenses that the adjustment gave to single photos, the calibrations, and
        what a millimetre is.
Out     Explanations: each kind of deviation that is free, and the focal length of each camera file.
Method  What the adjustment freed stays in the null model of everything else, and is told only where
        it stands the rules of any other term. A kind is drawn anew for each photo: the likelihood
        of the spread that the capture shows, over that of none, the other kinds' spread found in
        both. What all photos of a camera have alike is the camera's lens, and free. Where no board
        calibrated the lens, what it does beyond its model differs from photo to photo as well,
        since the points lie elsewhere in each: a spread is no fact there.
        A rolling shutter is solved for as if all lay equally far away. What is left of a strong
        one looks like another kind, which is no fact beside it.
        A kind matters where its effect surely does, or where its spread is beyond that of usual
        cameras: what is usual is told where it matters alone.
        A kind's effect is how far a photo would show the limb's points from where they are if it
        had its camera's lens, once its pose is fitted to them (root mean square); that of a focal
        length is its share.
Limits  Fewer than six photos tell nothing: every number is a part of their poses.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import POSE_SIZE, View
from limbgram.core.interval import chi_square_tail, length_within
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.bodies import FLOOR, FLOOR_MM
from limbgram.reconstruction.mapping.lens_deviations import FEWEST_PHOTOS
from limbgram.reconstruction.mapping.lens_evidence import (
    FOCAL_FLOOR,
    MOST,
    OWN,
    USUAL,
    LensEvidence,
    lens_basis,
    other_focal,
    place_of,
)
from limbgram.reconstruction.mapping.scene import Deviation, Explanation, Rule, Scene
from limbgram.reconstruction.mapping.score_tests import (
    MIN_SPREAD,
    SIGNIFICANCE_LEVEL,
    SPREAD_MARGIN,
    NormalEquations,
    ScoreTest,
    SpreadEstimate,
    estimate_spread,
)

_ROLLING: Deviation = "rolling shutter"
_MOST_POINTS = 300
_STEP = 1e-6


def lens_explanations(
    scene: Scene, priors: Sequence[Calibration], limb: Points3, mm: float | None = None
) -> tuple[Explanation, ...]:
    """What lenses of single photos explain, and whether the camera files are theirs.

    Args:
        limb: Points of what the cameras aim at.
        mm: A millimetre in the scene's unit; None where no board tells it.
    """
    filed = [k for k, one in enumerate(priors) if one.source == "board"]
    if len(scene.placed) < FEWEST_PHOTOS or not (filed or scene.own):
        return ()
    evidence = LensEvidence.of(scene, priors)
    found: list[Explanation | None] = [
        _file(evidence, camera) for camera in filed if (evidence.camera == camera).any()
    ]
    if scene.own is not None:
        distances = [
            np.linalg.norm(view.centre_in_world - limb.mean(axis=0)) for view in scene.views
        ]
        floor = FLOOR * float(np.median(distances)) if mm is None else FLOOR_MM * mm
        free = evidence.seen.eliminating(evidence.common())
        every = estimate_spread(free, USUAL, MOST, least=MIN_SPREAD * USUAL)
        rolling = _ROLLING in scene.own.deviations
        strong = rolling and _beyond_usual(free, every, place_of(_ROLLING))
        calibrated = all(one.source == "board" for one in priors)
        for kind in scene.own.deviations:
            if kind == "focal length":
                to_effect, least = [np.eye(1)] * len(scene.placed), FOCAL_FLOOR
            else:
                to_effect, least = [_on_limb(scene, k, kind, limb) for k in scene.placed], floor
            one = _drawn(evidence, free, every, kind, to_effect, least, calibrated)
            if one is not None and kind != _ROLLING and strong:
                one = replace(one, failed=("lens", *one.failed))
            found.append(one)
    shown = (one for one in found if one is not None and one.chance <= SIGNIFICANCE_LEVEL)
    return tuple(sorted(shown, key=lambda one: -one.score))


def _file(evidence: LensEvidence, camera: int) -> Explanation:
    """That the photos of a camera have another focal length than its file."""
    term = other_focal(evidence, camera)
    return Explanation(
        bodies="lenses",
        kind="camera file",
        photos=tuple(np.array(evidence.photos)[evidence.camera == camera].tolist()),
        numbers=1,
        score=term.score,
        chance=term.p_value,
        effect=term.value,
        low=term.low,
        high=term.high,
        variance_before=term.variance_before,
        variance_after=term.variance_after,
        failed=term.failed,
        floor=FOCAL_FLOOR,
    )


def _drawn(
    evidence: LensEvidence,
    free: NormalEquations,
    every: SpreadEstimate,
    kind: Deviation,
    to_effect: Sequence[Float64[np.ndarray, "e q"]],
    floor: float,
    calibrated: bool,
) -> Explanation | None:
    """A kind of deviation of which every photo has its own, unless chance explains it.

    Args:
        every: The likeliest spread of all kinds.
        to_effect: By photo, from the numbers of the kind to their effect.
    """
    numbers = place_of(kind)
    photos = len(evidence.photos)
    size = numbers.stop - numbers.start
    gain = every.likelihood_ratio - _of_spread(free, numbers, most=MIN_SPREAD).likelihood_ratio
    chance = chi_square_tail(gain, size)
    if chance > SIGNIFICANCE_LEVEL:
        return None
    normal = free.normal.copy()
    normal[np.diag_indices_from(normal)] += 1.0 / np.tile(every.spread, photos) ** 2
    covariance = np.linalg.inv(normal)
    values = covariance @ free.right
    effects: list[tuple[float, float, float]] = []
    for rank, matrix in enumerate(to_effect):
        own = slice(OWN * rank + numbers.start, OWN * rank + numbers.stop)
        effects.append(_effect(matrix, values[own], covariance[own, own]))
    effect, low, high = max(effects, key=lambda one: one[1])
    own_falls = [
        ScoreTest.of(free.restricted_to(evidence.of_photo(rank, numbers))).statistic
        for rank in range(photos)
    ]
    less = free.eliminating(evidence.of_photo(int(np.argmax(own_falls))))
    wider = np.minimum(SPREAD_MARGIN * every.spread, MOST)
    held: dict[Rule, bool] = {
        "model": calibrated,
        "size": low >= floor or _beyond_usual(free, every, numbers),
        "one photo": _still_shown(less, numbers, size, USUAL * MIN_SPREAD),
        "lenses of photos": _still_shown(free, numbers, size, wider),
    }
    shown = tuple(photo for photo, one in zip(evidence.photos, effects) if one[1] >= floor)
    left = evidence.left(np.where(_is_of(numbers), MIN_SPREAD * USUAL, every.spread))
    alone = ScoreTest.of(left.restricted_to(np.kron(np.eye(photos), np.eye(OWN)[:, numbers])))
    return Explanation(
        bodies="lenses",
        kind=kind,
        photos=shown or evidence.photos,
        numbers=size,
        score=float(gain - size * np.log(evidence.facts)),
        chance=chance,
        effect=effect,
        low=low,
        high=high,
        variance_before=alone.variance_factor,
        variance_after=1.0,
        failed=tuple(rule for rule, holds in held.items() if not holds),
        floor=floor,
    )


def _beyond_usual(seen: NormalEquations, every: SpreadEstimate, numbers: slice) -> bool:
    """Whether chance alone does not make this spread of what is usual."""
    gain = every.likelihood_ratio - _of_spread(seen, numbers, most=1.0).likelihood_ratio
    return chi_square_tail(gain, numbers.stop - numbers.start) <= SIGNIFICANCE_LEVEL


def _is_of(numbers: slice) -> np.ndarray:
    return np.isin(np.arange(OWN), np.arange(OWN)[numbers])


def _of_spread(
    seen: NormalEquations,
    numbers: slice,
    others: Float64[np.ndarray, "9"] | None = None,
    most: float = np.inf,
) -> SpreadEstimate:
    """The likeliest spread.

    Args:
        others: Least spread of the other kinds.
        most: Spread that this kind has at most, in parts of the usual one.
    """
    own, nothing = _is_of(numbers), MIN_SPREAD * USUAL
    least = nothing if others is None else np.where(own, nothing, np.maximum(others, nothing))
    return estimate_spread(
        seen, USUAL, np.where(own, np.minimum(most * USUAL, MOST), MOST), least=least
    )


def _still_shown(
    seen: NormalEquations, numbers: slice, size: int, others: Float64[np.ndarray, "9"]
) -> bool:
    with_it = _of_spread(seen, numbers, others)
    without = _of_spread(seen, numbers, others, most=MIN_SPREAD)
    return (
        chi_square_tail(with_it.likelihood_ratio - without.likelihood_ratio, size)
        <= SIGNIFICANCE_LEVEL
    )


def _effect(
    to_effect: Float64[np.ndarray, "e q"],
    values: Float64[np.ndarray, " q"],
    covariance: Float64[np.ndarray, "q q"],
) -> tuple[float, float, float]:
    """Size of an effect, and its interval of 95 %."""
    moved = to_effect @ values
    spread = to_effect @ covariance @ to_effect.T
    return length_within(moved, spread)


def _on_limb(
    scene: Scene, photo: int, kind: Deviation, limb: Points3
) -> Float64[np.ndarray, "q q"]:
    """From a photo's numbers of a kind to how far it shows the limb's points elsewhere, in root
    mean square and the scene's unit, once its pose is fitted to them."""
    view = scene.view(photo)
    points = limb[view.shows(limb)]
    numbers = place_of(kind)
    if len(points) < POSE_SIZE:
        return np.zeros((numbers.stop - numbers.start,) * 2)
    points = points[:: 1 + len(points) // _MOST_POINTS]
    columns = lens_basis(scene.cameras[scene.camera_idx[photo]])[:, numbers]
    depth = view.camera_from_world.apply(points)[:, 2]
    at, typical = view.project(points), float(np.median(depth))

    def slope(other: View) -> Float64[np.ndarray, " m"]:
        return ((other.project(points) - at) * depth[:, None] / view.camera.fx).ravel() / _STEP

    camera = view.camera
    by_lens = np.column_stack(
        [
            slope(
                View(
                    view.name,
                    camera.with_parameters(camera.packed + _STEP * one),
                    view.camera_from_world,
                )
            )
            for one in columns.T
        ]
    )
    by_pose = np.column_stack(
        [
            slope(
                View(
                    view.name,
                    camera,
                    Rigid.from_rotation_vector(_STEP * one[:3], _STEP * typical * one[3:])
                    @ view.camera_from_world,
                )
            )
            for one in np.eye(POSE_SIZE)
        ]
    )
    left = by_lens - by_pose @ np.linalg.lstsq(by_pose, by_lens, rcond=1e-9)[0]
    values, vectors = np.linalg.eigh(left.T @ left / len(points))
    return np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
