"""Lens explanations: which lens deviations of single photos, and which camera files, are facts.

In      a scene with the lenses that the adjustment gave to single photos, the calibrations, and
        what a millimetre is.
Out     Explanations: each kind of deviation that is free, and the focal length of each camera file.
Method  What the adjustment freed stays in the null model of everything else, and is a fact only if
        it passes the rules of any other term. A kind is a random effect in each photo: its score is
        the likelihood ratio of the spread that the capture shows over a spread of zero, the other
        kinds' spread estimated in both. What all photos of a camera have in common is the camera's
        lens, and free. Where no board calibrated the lens, what it does beyond its model differs
        from photo to photo as well, since the points lie elsewhere in each: a spread is no fact
        there.
        A rolling shutter is solved for as if all points lay equally far away. What is left of a
        strong one looks like another kind, which is no fact beside it.
        A kind matters where its effect surely does, or where its spread is beyond that of usual
        cameras, kinds that are not free at their usual spread at most: a shift of the principal
        point is else a rolling shutter carried along its axis. What is usual is told where it
        matters alone.
        A kind's effect is how far a photo would show the limb's points from where they are if it
        had its camera's lens, once its pose is fitted to them (root mean square); that of a focal
        length is its relative change.
Limits  Fewer than six photos tell nothing: every parameter is absorbed by their poses.
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
from limbgram.reconstruction.hypotheses.accepted_terms import Effect
from limbgram.reconstruction.hypotheses.relative_motion import FLOOR_MM, RELATIVE_FLOOR
from limbgram.reconstruction.mapping.lens_deviations import FEWEST_PHOTOS
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    FOCAL_FLOOR,
    MAX_SPREAD,
    USUAL_SPREAD,
    LensEquations,
    deviation_slice,
    lens_basis,
    other_focal,
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
        limb: Points of the object that the cameras aim at.
        mm: A millimetre in the scene's unit; None where no board tells it.
    """
    filed = [k for k, one in enumerate(priors) if one.source == "board"]
    if len(scene.placed) < FEWEST_PHOTOS or not (filed or scene.own):
        return ()
    equations = LensEquations.of(scene, priors)
    found: list[Explanation | None] = [
        _camera_file_term(equations, camera)
        for camera in filed
        if (equations.camera == camera).any()
    ]
    if scene.own is not None:
        distances = [
            np.linalg.norm(view.centre_in_world - limb.mean(axis=0)) for view in scene.views
        ]
        floor = RELATIVE_FLOOR * float(np.median(distances)) if mm is None else FLOOR_MM * mm
        free = equations.of_deviations.eliminating(equations.columns_of_cameras())
        every = estimate_spread(free, USUAL_SPREAD, MAX_SPREAD, least=MIN_SPREAD * USUAL_SPREAD)
        freed = [deviation_slice(kind) for kind in scene.own.deviations]
        most = np.where(_mask(*freed), MAX_SPREAD, USUAL_SPREAD)
        beyond = _beyond_usual(free, scene.own.deviations, most)
        calibrated = all(one.source == "board" for one in priors)
        for kind in scene.own.deviations:
            to_effect, least = [np.eye(1)] * len(scene.placed), FOCAL_FLOOR
            if kind != "focal length":
                to_effect = [_displacement_on_limb(scene, k, kind, limb) for k in scene.placed]
                least = floor
            one = _deviation_term(
                equations, free, every, kind, to_effect, least, calibrated, kind in beyond
            )
            if one is not None and kind != _ROLLING and _ROLLING in beyond:
                one = replace(one, failed=("lens", *one.failed))
            found.append(one)
    shown = (one for one in found if one is not None and one.chance <= SIGNIFICANCE_LEVEL)
    return tuple(sorted(shown, key=lambda one: -one.score))


def _camera_file_term(equations: LensEquations, camera: int) -> Explanation:
    """The explanation that the photos of a camera have another focal length than its file."""
    term = other_focal(equations, camera)
    return Explanation(
        bodies="lenses",
        kind="camera file",
        photos=tuple(np.array(equations.photos)[equations.camera == camera].tolist()),
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


def _deviation_term(
    equations: LensEquations,
    free: NormalEquations,
    every: SpreadEstimate,
    kind: Deviation,
    to_effect: Sequence[Float64[np.ndarray, "e q"]],
    floor: float,
    calibrated: bool,
    beyond_usual: bool,
) -> Explanation | None:
    """A kind of deviation as a random effect in each photo; None where it is not significant.

    Args:
        every: The estimated spread of all kinds.
        to_effect: By photo, the map from the parameters of the kind to their effect.
        beyond_usual: Whether its spread is beyond that of usual cameras.
    """
    numbers = deviation_slice(kind)
    photos = len(equations.photos)
    size = numbers.stop - numbers.start
    without_kind = _bounded_spread(free, numbers, most=MIN_SPREAD)
    ratio = every.likelihood_ratio - without_kind.likelihood_ratio
    p_value = chi_square_tail(ratio, size)
    if p_value > SIGNIFICANCE_LEVEL:
        return None
    effects = _effects(free, every, numbers, to_effect)
    largest = max(effects, key=lambda one: one.low)
    own_statistics = [
        ScoreTest.of(free.restricted_to(equations.columns_of_photo(rank, numbers))).statistic
        for rank in range(photos)
    ]
    without_largest = free.eliminating(equations.columns_of_photo(int(np.argmax(own_statistics))))
    wider = np.minimum(SPREAD_MARGIN * every.spread, MAX_SPREAD)
    passed: dict[Rule, bool] = {
        "model": calibrated,
        "size": largest.low >= floor or beyond_usual,
        "one photo": _is_significant_beside(
            without_largest, numbers, size, USUAL_SPREAD * MIN_SPREAD
        ),
        "lenses of photos": _is_significant_beside(free, numbers, size, wider),
    }
    shown = tuple(photo for photo, one in zip(equations.photos, effects) if one.low >= floor)
    return Explanation(
        bodies="lenses",
        kind=kind,
        photos=shown or equations.photos,
        numbers=size,
        score=float(ratio - size * np.log(equations.sample_size)),
        chance=p_value,
        effect=largest.size,
        low=largest.low,
        high=largest.high,
        variance_before=_variance_without(equations, every, numbers),
        variance_after=1.0,
        failed=tuple(rule for rule, passes in passed.items() if not passes),
        floor=floor,
    )


def _variance_without(equations: LensEquations, every: SpreadEstimate, numbers: slice) -> float:
    """Variance factor of a kind's parameters beside the others of this spread, and itself none."""
    remaining = equations.beside_random(
        np.where(_mask(numbers), MIN_SPREAD * USUAL_SPREAD, every.spread)
    )
    columns = np.kron(np.eye(len(equations.photos)), np.eye(DEVIATION_SIZE)[:, numbers])
    return ScoreTest.of(remaining.restricted_to(columns)).variance_factor


def _beyond_usual(
    free: NormalEquations, kinds: Sequence[Deviation], most: Float64[np.ndarray, "9"]
) -> set[Deviation]:
    """The kinds whose spread is significantly larger than the usual one.

    Args:
        most: Upper bound of each spread.
    """
    least = MIN_SPREAD * USUAL_SPREAD
    every = estimate_spread(free, USUAL_SPREAD, most, least=least)
    beyond: set[Deviation] = set()
    for kind in kinds:
        numbers = deviation_slice(kind)
        bound = np.where(_mask(numbers), USUAL_SPREAD, most)
        usual = estimate_spread(free, USUAL_SPREAD, bound, least=least)
        ratio = every.likelihood_ratio - usual.likelihood_ratio
        if chi_square_tail(ratio, numbers.stop - numbers.start) <= SIGNIFICANCE_LEVEL:
            beyond.add(kind)
    return beyond


def _mask(*numbers: slice) -> np.ndarray:
    """Which parameters of a deviation these are."""
    places = np.arange(DEVIATION_SIZE)
    return np.isin(places, [place for one in numbers for place in places[one]])


def _bounded_spread(
    free: NormalEquations,
    numbers: slice,
    others: Float64[np.ndarray, "9"] | None = None,
    most: float = np.inf,
) -> SpreadEstimate:
    """The estimated spread of all kinds where that of one is bounded.

    Args:
        others: Lower bound of the other kinds.
        most: Upper bound of this kind, as a multiple of the usual spread.
    """
    own, nothing = _mask(numbers), MIN_SPREAD * USUAL_SPREAD
    least = nothing if others is None else np.where(own, nothing, np.maximum(others, nothing))
    bound = np.where(own, np.minimum(most * USUAL_SPREAD, MAX_SPREAD), MAX_SPREAD)
    return estimate_spread(free, USUAL_SPREAD, bound, least=least)


def _is_significant_beside(
    free: NormalEquations, numbers: slice, size: int, others: Float64[np.ndarray, "9"]
) -> bool:
    """Whether a kind is significant where the others have at least this spread."""
    with_kind = _bounded_spread(free, numbers, others)
    without_kind = _bounded_spread(free, numbers, others, most=MIN_SPREAD)
    ratio = with_kind.likelihood_ratio - without_kind.likelihood_ratio
    return chi_square_tail(ratio, size) <= SIGNIFICANCE_LEVEL


def _effects(
    free: NormalEquations,
    every: SpreadEstimate,
    numbers: slice,
    to_effect: Sequence[Float64[np.ndarray, "e q"]],
) -> list[Effect]:
    """By photo, the posterior effect of a kind of deviation."""
    normal = free.normal.copy()
    normal[np.diag_indices_from(normal)] += 1.0 / np.tile(every.spread, len(to_effect)) ** 2
    covariance = np.linalg.inv(normal)
    values = covariance @ free.right
    effects: list[Effect] = []
    for rank, matrix in enumerate(to_effect):
        own = slice(DEVIATION_SIZE * rank + numbers.start, DEVIATION_SIZE * rank + numbers.stop)
        spread = matrix @ covariance[own, own] @ matrix.T
        effects.append(Effect(*length_within(matrix @ values[own], spread)))
    return effects


def _displacement_on_limb(
    scene: Scene, photo: int, kind: Deviation, limb: Points3
) -> Float64[np.ndarray, "q q"]:
    """Map from a photo's parameters of a kind to the displacement of the limb's points.

    Root mean square, in the scene's unit, once the photo's pose is fitted to the points.
    """
    view = scene.view(photo)
    points = limb[view.shows(limb)]
    numbers = deviation_slice(kind)
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
    residual = by_lens - by_pose @ np.linalg.lstsq(by_pose, by_lens, rcond=1e-9)[0]
    values, vectors = np.linalg.eigh(residual.T @ residual / len(points))
    return np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
