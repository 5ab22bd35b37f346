"""Known distances: two points, each picked in two or more photos, a typed length apart.

Coded marks are found in the photos instead of picked by hand: `marks` makes distances of them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int32
from scipy.special import chdtri

from limbgram.core.errors import ScaleError
from limbgram.core.geometry.arrays import Matrix3, Points2, Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import Triangulated, triangulate
from limbgram.core.interval import widening
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import SetAside, left_out
from limbgram.reconstruction.scale.ruler import (
    Ruler,
    RulerLength,
    points_by_cameras,
    size_by_cameras,
)
from limbgram.reconstruction.scale.stated_lengths import PRINTED, KnownDistance, Pick

_FEWEST_PICKS = 2
"""Fewest photos: two rays meet in a point."""
_LEAST_ANGLE_DEG = 2.0
_LEAST_RESIDUAL_PX = 1.0
_MOST_RESIDUAL = 0.002
"""Largest accepted distance of a pick from the common point, as a share of the photo's width."""
_MAX_CONTRADICTING_SHARE = 0.25
"""Largest share of a mark's photos that may contradict the others."""
_DIFFER = 0.05
"""Significance level of the test whether lengths differ by more than their sigmas."""


@dataclass(frozen=True)
class _LocatedEnd:
    """One end of a known distance, triangulated from its picks."""

    point_in_world: Vector3
    covariance: Matrix3
    """For picks with a standard deviation of 1 px."""
    photos: tuple[str, ...]
    """Photos with picks of it that agree."""
    squares_px2: float
    """Sum of the squared residuals of its picks."""
    dof: int
    contradicting: tuple[SetAside, ...] = ()
    """Photos that contradict the others."""


def measure_distances(
    scene: Scene, distances: Sequence[KnownDistance], pick_sigma_px: float, *, all_check: bool
) -> Ruler:
    """The distances as a ruler: alternately one sets the scale and the next checks it.

    The best known ones come first (`_roles`). With `all_check` every one checks, and the ruler's
    own scale is only for comparison.

    Raises:
        ScaleError: none could be measured, or the picks of one point do not meet.
    """
    lengths: list[RulerLength] = []
    set_aside: list[SetAside] = []
    for distance in distances:
        ends = [
            _locate(scene, distance, name, picks)
            for name, picks in zip(distance.ends, (distance.first, distance.second), strict=True)
        ]
        missing = tuple(end for end in ends if isinstance(end, Finding))
        located = [end for end in ends if isinstance(end, _LocatedEnd)]
        set_aside += [one for end in located for one in end.contradicting]
        if missing:
            set_aside.append(SetAside(distance.label, note("scale.ends_missing", ends=missing)))
        else:
            first, second = located
            length = _length(distance, first, second, pick_sigma_px)
            lengths.append(replace(length, by_cameras=_by_cameras(scene, first, second)))
    if not lengths:
        raise ScaleError("scale.none_measured", left_out=left_out(set_aside))
    if not all_check:
        roles = zip(lengths, _roles(lengths), strict=True)
        lengths = [replace(one, role=role) for one, role in roles]
    return ruler_of(lengths, tuple(set_aside))


def _roles(lengths: Sequence[RulerLength]) -> list[Literal["control", "check"]]:
    """Alternately control and check, those first whose own length is known best.

    Where a print is seen, what was measured by hand checks, as it does beside a board: it is read
    and picked less well, and only on another piece does it tell that the printer was wrong.
    """
    roles: list[Literal["control", "check"]] = ["check"] * len(lengths)
    printed = [k for k, one in enumerate(lengths) if one.between in PRINTED]
    best_first = sorted(
        printed or range(len(lengths)),
        key=lambda k: lengths[k].stated_sigma_mm / lengths[k].known_mm,
    )
    for k in best_first[::2]:
        roles[k] = "control"
    return roles


def _locate(
    scene: Scene, distance: KnownDistance, name: str, picks: Sequence[Pick]
) -> _LocatedEnd | Finding:
    """One end triangulated in the scene, or the finding why it cannot be."""
    label = distance.label
    unknown = [pick.photo for pick in picks if pick.photo not in scene.names]
    if unknown:
        raise ScaleError("scale.unknown_photo", label=label, photo=unknown[0])
    views = {scene.names[k]: scene.view(k) for k in scene.placed}
    usable = [pick for pick in picks if pick.photo in views]
    if len(usable) < _FEWEST_PICKS:
        return note("scale.end.unseen", end=name, photos=len(usable))
    seen = [views[pick.photo] for pick in usable]
    xy_px = np.array([(pick.x_px, pick.y_px) for pick in usable])
    kept = np.arange(len(seen), dtype=np.int32)
    if distance.sigma_px is not None:
        kept = _agreeing(seen, xy_px)
    contradicting = tuple(
        SetAside(usable[k].photo, doubt("scale.end.elsewhere", end=name, label=label))
        for k in sorted({*range(len(seen))} - {*kept.tolist()})
    )
    believed = kept.tolist()
    usable, seen = [usable[k] for k in believed], [seen[k] for k in believed]
    xy_px = xy_px[kept]
    located = _intersection(seen, xy_px)
    point = located.points_in_world[0]
    directions = np.array([view.centre_in_world - point for view in seen])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    narrowest = float((directions @ directions.T).min())
    if not np.isfinite(point).all() or narrowest > np.cos(np.radians(_LEAST_ANGLE_DEG)):
        return note("scale.end.narrow", end=name, least_deg=_LEAST_ANGLE_DEG)
    _check_residuals(
        label,
        usable,
        [view.camera.width_px for view in seen],
        np.array([view.project(point[None])[0] for view in seen]) - xy_px,
    )
    squares_px2 = float(located.rms_px[0] ** 2 * len(seen))
    photos = tuple(pick.photo for pick in usable)
    return _LocatedEnd(
        point, located.covariance[0], photos, squares_px2, 2 * len(seen) - 3, contradicting
    )


def _intersection(views: Sequence[View], xy_px: Points2) -> Triangulated:
    order = np.arange(len(views), dtype=np.int32)
    return triangulate(views, order, np.zeros(len(views), np.int32), xy_px, 1)


def _agreeing(views: Sequence[View], xy_px: Points2) -> Int32[np.ndarray, " k"]:
    """The photos that agree on a mark, without a few that misread it."""
    kept = np.arange(len(views), dtype=np.int32)
    while len(kept) - 1 >= max(3, (1 - _MAX_CONTRADICTING_SHARE) * len(views)):
        chosen = [views[k] for k in kept.tolist()]
        point = _intersection(chosen, xy_px[kept]).points_in_world
        seen_px = np.array([view.project(point)[0] for view in chosen])
        off_px = np.linalg.norm(seen_px - xy_px[kept], axis=1)
        worst = int(np.argmax(off_px))
        width_px = chosen[worst].camera.width_px
        if not off_px[worst] > max(_LEAST_RESIDUAL_PX, _MOST_RESIDUAL * width_px):
            break
        kept = np.delete(kept, worst)
    return kept


def _check_residuals(
    label: str, picks: Sequence[Pick], widths_px: Sequence[int], misses: np.ndarray
) -> None:
    off_px = np.linalg.norm(misses, axis=1)
    worst = int(np.argmax(off_px))
    if off_px[worst] > max(_LEAST_RESIDUAL_PX, _MOST_RESIDUAL * widths_px[worst]):
        raise ScaleError(
            "scale.picks_apart",
            label=label,
            photo=picks[worst].photo,
            off_px=float(off_px[worst]),
        )


def _length(
    distance: KnownDistance,
    first: _LocatedEnd,
    second: _LocatedEnd,
    pick_sigma_px: float,
) -> RulerLength:
    between = second.point_in_world - first.point_in_world
    measured = float(np.linalg.norm(between))
    direction = between / max(measured, 1e-300)
    of_length = distance.length_sigma_mm / distance.length_mm
    freedom = first.dof + second.dof
    spread_px = math.sqrt((first.squares_px2 + second.squares_px2) / freedom) * widening(freedom)
    sigma_px = pick_sigma_px if distance.sigma_px is None else distance.sigma_px
    of_one_px = float(direction @ (first.covariance + second.covariance) @ direction)
    variance = of_one_px * max(sigma_px, spread_px) ** 2
    return RulerLength(
        label=distance.label,
        known_mm=distance.length_mm,
        measured=measured,
        sigma=float(np.hypot(np.sqrt(variance), measured * of_length)),
        role="check",
        between=distance.between,
        marks=distance.marks,
        stated_sigma_mm=distance.length_sigma_mm,
    )


def _by_cameras(
    scene: Scene, first: _LocatedEnd, second: _LocatedEnd
) -> Float64[np.ndarray, " u"] | None:
    """Jacobian of the length by poses and lenses; None where the scene has no covariance."""
    if scene.camera_covariance is None:
        return None
    shown = {
        photo: np.flatnonzero([photo in end.photos for end in (first, second)])
        for photo in {*first.photos, *second.photos}
    }
    points = np.array([first.point_in_world, second.point_in_world])
    moves, _ = points_by_cameras(scene, shown, points, _FEWEST_PICKS)
    return size_by_cameras(points, moves)


def ruler_of(lengths: Sequence[RulerLength], set_aside: tuple[SetAside, ...] = ()) -> Ruler:
    """Weighted mean of measured over known length; its sigma grows where the lengths differ.

    Only where they differ by more than their own sigmas explain (chi-square, one in 20): what they
    tell of these is widened then, for they are few.
    """
    control = [one for one in lengths if one.role == "control"] or list(lengths)
    ratios = np.array([one.measured / one.known_mm for one in control])
    sigmas = np.array([one.sigma / one.known_mm for one in control])
    weights = 1 / np.maximum(sigmas, 1e-12 * ratios) ** 2
    mean = float(weights @ ratios / weights.sum())
    freedom = max(1, len(control) - 1)
    misfit = float(weights @ (ratios - mean) ** 2)
    explained = misfit <= chdtri(freedom, _DIFFER)
    excess = 1.0 if explained else misfit / freedom * widening(freedom) ** 2
    sigma = float(np.sqrt(max(1.0, excess) / weights.sum()))
    return Ruler(
        units_per_mm=mean,
        relative_sigma=sigma / mean,
        lengths=tuple(lengths),
        set_aside=set_aside,
        by_cameras=_mean_growth([one.by_cameras for one in control], weights * ratios),
    )


def _mean_growth(
    growths: Sequence[Float64[np.ndarray, " u"] | None], weights: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " u"] | None:
    """Jacobian of a weighted mean of lengths; None where one of them has none."""
    known = [one for one in growths if one is not None]
    if len(known) < len(growths):
        return None
    return weights @ np.array(known) / float(weights.sum())
