"""Zoom: detects photos whose focal length differs from the others', without help from EXIF.

In      an adjusted scene.
Out     for every photo the focal length that fits it alone, over its camera's, with its sigma; and
        findings about photos that were zoomed, or focused at another distance.
Method  Points that three photos or more see stay where the scene has them. A photo's pose and one
        factor on its focal lengths are fitted to them anew, in robust least squares (Cauchy). The
        points are shared with photos that do not zoom, so the factor shows what a pose cannot: near
        points spread more than far ones. The points follow a zoomed photo in part, so that about
        0.4 of its zoom is seen: 0.45 % of 1 % on limb_ring15, at 11 sigmas. Under autofocus every
        photo has a focal length of its own; a photo is an outlier only by the others' spread. So it
        is where the points do not keep still, on a sheet of paper that bends, say: a photo that
        faces it squarely determines its zoom ten times worse than the others, and shows ten times
        their spread. Both the spread of the deviations and that of the deviations in their own
        sigmas set the threshold.
        Zoomed neighbours bias the points that they share, and none of them is sure then: of two of
        14 photos zoomed by 6 % each showed 1 %, at 3 to 4 sigmas. Photos beyond a lower threshold
        are suspected, and fitted anew to points that the other photos alone determine: there both
        showed 6 %, at more than 40 sigmas.
        Where many photos were zoomed, few others are left to compare with. The residuals then
        support focal lengths of single photos (lens_selection.py); solved for in one adjustment,
        seven of 14 photos zoomed by 5 % show 4.7 to 4.9 %, and the others 0.0 to 0.2 %. Two groups,
        one of them tight, are a zoom; one group that is off is the file of another camera.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import PARAMETERS, View
from limbgram.core.interval import MAD_TO_SIGMA
from limbgram.findings import Finding, doubt
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS
from limbgram.reconstruction.mapping.bundle_adjustment import SIGMA_INFLATION
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.photo import first_of

_FX = PARAMETERS.index("fx")
_FEWEST_POINTS = 30
_FEWEST_VIEWS = 3
_MOST_POINTS = 1500
_ROUNDS = 3
_STEP = 1e-6
_ODD_SIGMAS = 5.0
_SUSPECTED_SIGMAS = 2.0
_MIN_DIFFERENCE = 0.0035
"""Relative difference below which a focal length is no outlier. Photos that did not zoom show
0.0003 and one sigma if rendered, 0.0029 and 12 sigmas of a flowerpot under autofocus, 0.017 and 3
sigmas of a skull."""
_GROUP_WIDTH = 0.01
"""Largest relative difference of focal lengths within a group of photos."""
_BEYOND_FOCUS = 0.02
"""More than autofocus changes a focal length: at 0.5 m one of 6 mm grows by 0.012."""
_LEAST_GROUP_SHARE = 0.4
"""Smallest share of a camera's photos in the largest group."""


@dataclass(frozen=True)
class FocalFit:
    """Focal length of one photo over that of its camera."""

    ratio: float
    sigma: float


@dataclass(frozen=True)
class FocalOutliers:
    """Photos whose focal length is not that of the others."""

    odd: dict[int, Finding]
    suspected: tuple[int, ...]
    """These, and others whose zoomed neighbours may hide that they are."""


def focal_fits(scene: Scene) -> tuple[FocalFit | None, ...]:
    """Fit of each photo's focal length; None where it is not placed or shows too few points."""
    seen = scene.observations
    views = np.bincount(seen.point_idx, minlength=len(scene.points_in_world))
    shared = views[seen.point_idx] >= _FEWEST_VIEWS
    fits: list[FocalFit | None] = [None] * len(scene.names)
    for photo in scene.placed:
        rows = shared & (seen.photo_idx == photo)
        if rows.sum() >= _FEWEST_POINTS:
            some = np.flatnonzero(rows)[:: 1 + int(rows.sum()) // _MOST_POINTS]
            points = scene.points_in_world[seen.point_idx[some]]
            fits[photo] = _fit_focal(scene.view(photo), points, seen.xy_px[some])
    return tuple(fits)


def odd_focals(scene: Scene) -> dict[int, Finding]:
    """Photos of another focal length than their camera's, each with its finding."""
    return focal_outliers(scene).odd


def focal_outliers(scene: Scene) -> FocalOutliers:
    """Which photos have another focal length than the others, and which may have."""
    fits = focal_fits(scene)
    return FocalOutliers(_outliers(fits, _ODD_SIGMAS), tuple(_outliers(fits, _SUSPECTED_SIGMAS)))


def odd_by_others(suspected: Sequence[int], by_others: Scene) -> dict[int, Finding]:
    """The suspected photos that are outliers by points that the other photos determine.

    Args:
        by_others: The scene with points triangulated without the suspected photos.
    """
    fits = focal_fits(by_others)
    return {
        photo: found for photo, found in _outliers(fits, _ODD_SIGMAS).items() if photo in suspected
    }


def zoomed_photos(zoomed: Sequence[str], photos: int) -> Finding:
    """Finding that some photos are used though they have another focal length."""
    return doubt("lens.zoomed", count=len(zoomed), photos=photos, **first_of(zoomed))


def zoomed_by_solved_focals(scene: Scene) -> dict[int, Finding]:
    """Photos whose solved focal lengths (`Scene.own`) differ from those of the largest group.

    Empty where none was solved for, or where a camera's photos form no group.
    """
    own = scene.own
    if own is None or "focal length" not in own.deviations:
        return {}
    # of the solved lens: the deviations themselves are parts of a guessed one, which may be far off
    usual_px = np.array([scene.cameras[camera].fx for camera in scene.camera_idx])
    factors, fits = 1.0 + own.shifts[:, _FX] / usual_px, focal_fits(scene)
    found: dict[int, Finding] = {}
    for camera in sorted({scene.camera_idx[photo] for photo in scene.placed}):
        known = [
            (photo, fit.sigma)
            for photo, fit in enumerate(fits)
            if fit is not None and scene.camera_idx[photo] == camera
        ]
        photos, sigmas = np.array([k for k, _ in known], int), np.array([s for _, s in known])
        alike = _largest_group(factors[photos])
        if not alike.any():
            continue
        off = factors[photos] / np.median(factors[photos[alike]]) - 1.0
        firm = _ODD_SIGMAS * _sigma_inflation(off[alike], sigmas[alike]) * sigmas
        for k in np.flatnonzero(np.abs(off) > np.maximum(_BEYOND_FOCUS, firm)).tolist():
            found[int(photos[k])] = _odd(float(off[k]), at_least=False)
    return found


def _largest_group(factors: Float64[np.ndarray, " p"]) -> Bool[np.ndarray, " p"]:
    """Mask of the largest group of like focal lengths; of equal ones, that of the camera's."""
    if not len(factors):
        return np.zeros(0, np.bool_)
    alike = np.abs(factors[:, None] - factors) < _GROUP_WIDTH
    sizes = alike.sum(axis=1)
    if sizes.max() < _LEAST_GROUP_SHARE * len(factors):
        return np.zeros(len(factors), np.bool_)
    largest = np.flatnonzero(sizes == sizes.max())
    return alike[largest[np.argmin(np.abs(factors[largest] - 1.0))]]


def _sigma_inflation(
    deviations: Float64[np.ndarray, " p"], sigmas: Float64[np.ndarray, " p"]
) -> float:
    """Factor by which the sigmas of usual photos understate their spread; 1 at least."""
    return max(1.0, MAD_TO_SIGMA * float(np.median(np.abs(deviations) / sigmas)))


def _odd(off: float, *, at_least: bool) -> Finding:
    """Finding that a photo has another focal length."""
    return doubt("lens.photo.zoomed", longer=off > 0, share=abs(off), at_least=at_least)


def _outliers(fits: Sequence[FocalFit | None], sigmas: float) -> dict[int, Finding]:
    """Photos whose focal length is an outlier by the others' spread and by so many own sigmas."""
    known = {photo: fit for photo, fit in enumerate(fits) if fit is not None}
    if not known:
        return {}
    deviations = np.array([abs(fit.ratio - 1.0) for fit in known.values()])
    own_sigmas = np.array([fit.sigma for fit in known.values()])
    usual = MAD_TO_SIGMA * float(np.median(deviations))
    inflation = _sigma_inflation(deviations, own_sigmas)
    found: dict[int, Finding] = {}
    for photo, fit in known.items():
        off = fit.ratio - 1.0
        if abs(off) > max(_MIN_DIFFERENCE, sigmas * inflation * fit.sigma, _ODD_SIGMAS * usual):
            found[photo] = _odd(float(off), at_least=True)
    return found


def _fit_focal(view: View, points: Points3, xy_px: Points2) -> FocalFit:
    """Pose and focal length of a photo by fixed points, in robust least squares."""
    size = float(np.linalg.norm(view.centre_in_world - np.median(points, axis=0)))
    step, normal, sigma_px = np.zeros(7), np.eye(7), 1.0
    total = 0.0
    for _ in range(_ROUNDS):
        at = _perturbed(view, step, size)
        placed = at.project(points)
        off = (xy_px - placed).ravel()
        known = np.isfinite(off)
        sigma_px = max(MAD_TO_SIGMA * float(np.median(np.abs(off[known]))), 1e-6)
        slopes = np.column_stack(
            [
                (_perturbed(view, step + _STEP * axis, size).project(points) - placed).ravel()
                / _STEP
                for axis in np.eye(7)
            ]
        )[known]
        weights = 1.0 / (1.0 + (off[known] / (CAUCHY_SIGMAS * sigma_px)) ** 2)
        normal = slopes.T @ (weights[:, None] * slopes)
        step = step + np.linalg.lstsq(normal, slopes.T @ (weights * off[known]), rcond=1e-12)[0]
        total = float(step[6])
    covariance = np.linalg.pinv(normal, rcond=1e-12, hermitian=True)
    return FocalFit(
        ratio=float(np.exp(total)),
        sigma=float(SIGMA_INFLATION * sigma_px * np.sqrt(covariance[6, 6])),
    )


def _perturbed(view: View, step: Float64[np.ndarray, "7"], size: float) -> View:
    """The view rotated, shifted (in units of `size`) and zoomed in its own frame."""
    factor = float(np.exp(step[6]))
    camera = replace(
        view.camera,
        fx=view.camera.fx * factor,
        fy=view.camera.fy * factor,
        skew=view.camera.skew * factor,
    )
    move = Rigid.from_rotation_vector(step[:3], step[3:6] * size)
    return View(view.name, camera, move @ view.camera_from_world)
