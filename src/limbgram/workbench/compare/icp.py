"""ICP: a surface moved onto another by its own shape, point to plane, robustly.

In      places on the second surface, the first as a Ground, and a pose to start from.
Out     a Fit: the pose, how well it fits, and whether the shape determines it at all.
Method  Gauss-Newton on the signed distance to the surface: point to plane (Chen and Medioni
        1992), but along the way to the nearest place, which does not jump between triangles.
        Tukey's weights, their scale from the median and never growing, until the places stand.
        Where nobody says how two shapes lie to each other, `tried_starts` runs it from the main
        directions of both, turned in steps, and keeps the best.
Fails   MeasureError: a shape has no measured surface away from its brim.

`descent` says how two shapes lie where one was made from the other. The limb files name what a
shape was made from, and the motion between both meshes' axes. Where they do not (older ones, and
files of other programs) the shapes themselves show it: an edited shape keeps its scan's limb frame
to the last digit, and often some of its vertices. Two scans never do, because each is aligned by
its own landmarks. Laid on each other by shape, what was taken off would turn into a slide along
the axis.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int
from scipy.spatial import KDTree

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.interval import MAD_TO_SIGMA, widening
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import paired
from limbgram.workbench.compare.counterparts import Counterparts, Ground, measured_faces
from limbgram.workbench.compare.deviation import sample_evenly
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

_TUKEY = 4.685
"""Residuals beyond this many standard deviations count nothing."""
_SMALLEST_SCALE_MM = 1e-7
FEWEST = 12
"""Places without which there is no pose."""
_SLIGHT = 1e-4
_SINGULAR = 1e-8
_NEARLY_STILL_MM = 0.05
"""From here on the places that have a counterpart stay the same: else those at brims flicker."""
_TOUCHING_MM = 1e-6
"""Nearer than this the way to the nearest place is rounding, and the normal stands for it."""
_LEAST_SLOPE = 0.25
"""At least, of the pull over the weight: nothing tells where most places are nearly rejected."""
_PATCH = 1.0
"""Side of a patch whose places err alike, in shares of the mean reach of the surface.

A limb changes over such lengths. Where errors are shorter, few large patches hold as often."""
_LOOSE = 3e-5
"""A motion is undetermined if the surface answers it by less than the root of this, mm per mm."""


@dataclass(frozen=True, kw_only=True)
class Looseness:
    """How freely the second surface still slides on the first, in the first's frame."""

    middle_mm: Vector3
    """Of the places that count."""
    covariance: Float64[np.ndarray, "6 6"]
    """Of a turn about the middle, rad, then of a shift there, mm: patches err alike, and growth all

    round of the size by which they still differ would pass for a motion."""
    growth_shift: Vector3
    """Shift that growth of 1 mm all round would be taken for, mm per mm; nothing by landmarks."""

    @property
    def covariance_mm2(self) -> Matrix3:
        """Of the shift, whatever turns with it."""
        return self.covariance[3:, 3:]

    def sigmas_mm(self, points_mm: Points3, normals: Points3) -> Float64[np.ndarray, " n"]:
        """Standard deviation, along the normals, of where the second surface lies."""
        columns = _columns(points_mm, normals, self.middle_mm, 1.0)
        return np.sqrt(np.einsum("ni,ij,nj->n", columns, self.covariance, columns).clip(0.0))


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A pose that was found."""

    first_from_second: Rigid
    rms_mm: float
    """Of the distances along the normals of the places that have a counterpart, unweighted."""
    used_share: float
    """Of the places: those with a counterpart that were not rejected as changed."""
    cost_mm: float
    """Root mean square distance of all places, each at most `cap_mm`."""
    rounds: int
    converged: bool
    undetermined: tuple[Finding, ...]
    """Motions that hardly change the fit."""
    larger_share: float
    """By how much, as a fraction of all lengths, the second surface is larger than the first."""
    looseness: Looseness | None
    """None where nothing holds the surfaces."""


@dataclass(frozen=True, kw_only=True)
class IcpOptions:
    """When to stop, and what counts as far."""

    tolerance_mm: float = 1e-4
    """The last round moves the places by less, or by a ten-thousandth of their distances."""
    max_rounds: int = 60
    cap_mm: float = 10.0
    """Largest distance that a place adds to the cost by which poses are ranked."""


def run_icp(points_mm: Points3, ground: Ground, start: Rigid, options: IcpOptions) -> Fit:
    """Move the places onto the ground from a start."""
    pose, rounds, moved_mm = start, 0, np.inf
    scale_mm, valid = np.inf, np.ones(len(points_mm), bool)
    tolerance_mm = options.tolerance_mm
    while rounds < options.max_rounds and moved_mm > tolerance_mm:
        placed = pose.apply(points_mm)
        found = ground.counterparts(placed)
        if moved_mm > _NEARLY_STILL_MM:
            valid = _valid(found)
        scale_mm = min(scale_mm, _scale_mm(found, valid))
        weights = _weights(found, valid, scale_mm)
        if np.count_nonzero(weights) < FEWEST:
            break
        tolerance_mm = max(options.tolerance_mm, _SLIGHT * scale_mm)
        step = _step(placed, found, weights)
        moved_mm = float(np.sqrt(np.mean(np.sum((step.apply(placed) - placed) ** 2, axis=1))))
        pose, rounds = _orthonormal(step @ pose), rounds + 1
    converged = rounds > 0 and moved_mm <= tolerance_mm
    return _fit(points_mm, ground, pose, rounds, converged, options)


def _fit(
    points_mm: Points3,
    ground: Ground,
    pose: Rigid,
    rounds: int,
    converged: bool,
    options: IcpOptions,
) -> Fit:
    placed = pose.apply(points_mm)
    found = ground.counterparts(placed)
    valid = _valid(found)
    weights = _weights(found, valid, _scale_mm(found, valid))
    off_mm = found.signed_mm[valid]
    capped = np.minimum(np.abs(found.signed_mm), options.cap_mm)
    capped[found.at_brim] = options.cap_mm
    return Fit(
        first_from_second=pose,
        rms_mm=float(np.sqrt(np.mean(off_mm**2))) if len(off_mm) else float("nan"),
        used_share=float(np.count_nonzero(weights) / len(weights)),
        cost_mm=float(np.sqrt(np.mean(capped**2))),
        rounds=rounds,
        converged=converged,
        undetermined=_undetermined(placed, found, weights),
        larger_share=_larger_share(placed, found, valid),
        looseness=_looseness(placed, found, weights),
    )


def _larger_share(placed: Points3, found: Counterparts, valid: Bool[np.ndarray, " n"]) -> float:
    """The growth that, with a shift, takes most of the distances away, by least squares."""
    if np.count_nonzero(valid) < FEWEST:
        return float("nan")
    normals, points = found.smooth_normals[valid], placed[valid]
    levers = ((points - points.mean(0)) * normals).sum(1)
    columns = np.column_stack([levers, normals])
    slope = float(np.linalg.lstsq(columns, found.signed_mm[valid], rcond=None)[0][0])
    return 1 / max(1 - slope, 0.1) - 1


def _looseness(
    placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]
) -> Looseness | None:
    """From the distances that no motion and no growth takes away, patch by patch, and from growth.

    Growth all round pulls every patch the same way. Counted among their pulls as well, it would
    pass for as many errors that know nothing of each other.
    """
    if np.count_nonzero(weights) < FEWEST:
        return None
    middle, reach_mm = _arms(placed, weights)
    columns = _columns(placed, found.smooth_normals, middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns
    inverse = np.linalg.pinv(normal, rcond=_SINGULAR, hermitian=True)
    cells = np.floor((placed - middle) / (_PATCH * reach_mm)).astype(int)
    patch = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    pulls = _pulls(columns, found.signed_mm, weights, patch)
    moved = pulls @ inverse / _slope(weights)
    growth = inverse @ (columns.T @ weights)
    off_mm, counted = np.bincount(patch, weights * found.signed_mm), np.bincount(patch, weights)
    off_mm2 = float(np.sum(off_mm**2 / np.maximum(counted, 1e-12)) / counted.sum())
    covariance = moved.T @ moved + off_mm2 * np.outer(growth, growth)
    in_rad = np.repeat([1 / reach_mm, 1.0], 3)  # turns were counted in mm at the reach
    return Looseness(
        middle_mm=middle,
        covariance=covariance * np.outer(in_rad, in_rad),
        growth_shift=growth[3:],
    )


def _pulls(
    columns: Float64[np.ndarray, "n 6"],
    off_mm: Float64[np.ndarray, " n"],
    weights: Float64[np.ndarray, " n"],
    patch: Int[np.ndarray, " n"],
) -> Float64[np.ndarray, "p 6"]:
    """How each patch pulls the pose by what it errs as a whole, growth left out.

    A fit gives way to its patches, the more the more they hold. So each one errs by what the others
    leave of it (the jackknife of clusters; Bell and McCaffrey 2002, Survey Methodology 28:169-181).
    """
    count = int(patch.max()) + 1
    columns = np.column_stack([columns, np.ones(len(columns))])
    normals, pulls = np.zeros((count, 7, 7)), np.zeros((count, 7))
    np.add.at(normals, patch, np.einsum("n,ni,nj->nij", weights, columns, columns))
    normal = normals.sum(0)
    inverse = np.linalg.pinv(normal, rcond=_SINGULAR, hermitian=True)
    left_mm = off_mm - columns @ (inverse @ (columns.T @ (weights * off_mm)))
    np.add.at(pulls, patch, columns * (weights * left_mm)[:, None])
    without = np.linalg.pinv(normal - normals, rcond=_SINGULAR, hermitian=True)
    pulls = np.einsum("ij,pjk,pk->pi", normal, without, pulls)[:, :6]
    return pulls * np.sqrt((count - 1) / count) * widening(max(count - 7, 1))


def _slope(weights: Float64[np.ndarray, " n"]) -> float:
    """Of Tukey's pull over its weight, on average: by so much less than weights say places hold.

    Huber 1981, Robust Statistics, 7.6.
    """
    roots = np.sqrt(weights)
    return max(float((roots * (5 * roots - 4)).sum() / weights.sum()), _LEAST_SLOPE)


def _valid(found: Counterparts) -> Bool[np.ndarray, " n"]:
    return ~found.at_brim & found.measured


def _scale_mm(found: Counterparts, valid: Bool[np.ndarray, " n"]) -> float:
    """Robust standard deviation of the distances; infinite where there is none."""
    off_mm = np.abs(found.signed_mm[valid])
    return (
        max(MAD_TO_SIGMA * float(np.median(off_mm)), _SMALLEST_SCALE_MM) if len(off_mm) else np.inf
    )


def _weights(
    found: Counterparts, valid: Bool[np.ndarray, " n"], scale_mm: float
) -> Float64[np.ndarray, " n"]:
    """Tukey's; nothing where there is no counterpart."""
    return np.where(valid, tukey(found.signed_mm, scale_mm), 0.0)


def tukey(off_mm: Float64[np.ndarray, " n"], scale_mm: float) -> Float64[np.ndarray, " n"]:
    """Tukey's weights of distances of this spread: nothing beyond 4.685 times it."""
    return np.clip(1 - (off_mm / (_TUKEY * scale_mm)) ** 2, 0, None) ** 2


def _ways(placed: Points3, found: Counterparts) -> Points3:
    """Unit directions in which the distance grows."""
    sizes = np.abs(found.signed_mm)
    apart = sizes > _TOUCHING_MM
    ways = found.flat_normals.copy()
    ways[apart] = (placed - found.points_mm)[apart] / found.signed_mm[apart, None]
    return ways


def _step(placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]) -> Rigid:
    """One Gauss-Newton step; motions that the shape does not feel stay zero."""
    middle, reach_mm = _arms(placed, weights)
    columns = _columns(placed, _ways(placed, found), middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns / weights.sum()
    towards = columns.T @ (weights * found.signed_mm) / weights.sum()
    values, vectors = np.linalg.eigh(normal)
    felt = values > _SINGULAR
    motion = -(vectors[:, felt] / values[felt]) @ (vectors[:, felt].T @ towards)
    turn = Rigid.from_rotation_vector(motion[:3] / reach_mm, np.zeros(3)).rotation
    return Rigid(turn, middle + motion[3:] - turn @ middle)


def _arms(placed: Points3, weights: Float64[np.ndarray, " n"]) -> tuple[Vector3, float]:
    """Weighted middle, and the root mean square distance from it."""
    middle = weights @ placed / weights.sum()
    square = float(weights @ ((placed - middle) ** 2).sum(1) / weights.sum())
    return middle, max(np.sqrt(square), 1e-9)


def _columns(placed: Points3, normals: Points3, middle: Vector3, reach_mm: float) -> np.ndarray:
    """Motion along the normal for a millimetre of turning (at the reach) and of shifting."""
    return np.column_stack([np.cross(placed - middle, normals) / reach_mm, normals])


def _undetermined(
    placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]
) -> tuple[Finding, ...]:
    if not weights.any():
        return (doubt("compare.shape.tells_nothing"),)
    middle, reach_mm = _arms(placed, weights)
    columns = _columns(placed, found.smooth_normals, middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns / weights.sum()
    values, vectors = np.linalg.eigh(normal)
    open_motions: list[Finding] = []
    for value, vector in zip(values, vectors.T):
        if value < _LOOSE:
            turning = float(np.sum(vector[:3] ** 2)) > 0.5
            direction = vector[:3] if turning else vector[3:]
            direction = direction / np.linalg.norm(direction)
            direction *= np.sign(direction[np.argmax(np.abs(direction))])
            way = tuple((direction + 0.0).tolist())
            open_motions.append(doubt("compare.shape.open", turning=turning, direction=way))
    return tuple(open_motions)


def _orthonormal(pose: Rigid) -> Rigid:
    """Rounding of many products taken off."""
    u, _, vt = np.linalg.svd(pose.rotation)
    return Rigid(u @ vt, pose.translation)


_SAME_FRAME = 1e-9
_SAME_PLACE_MM = 1e-3
"""A file's rounding."""
_PROBES = 500
_SHARED = 0.05
"""Of the second's vertices that lie on the first's: more than ends and axes have by chance."""


@dataclass(frozen=True)
class Descent:
    """How a shape and what was made from it lie to each other."""

    first_from_second: Rigid
    """Between the frames of the meshes."""
    because: Finding


def descent(first: Limb, second: Limb) -> Descent | None:
    """How both lie, if one was made from the other; None where nothing tells."""
    told = _by_origins(first, second)
    if told is not None:
        return Descent(told, note("compare.descent.one_file"))
    because = _why_alike(first, second)
    return None if because is None else Descent(Rigid.identity(), because)


def _by_origins(first: Limb, second: Limb) -> Rigid | None:
    """By the nearest file that both come from, read in the same unit."""
    theirs = {(one.sha256, one.mm_per_unit): one for one in reversed(second.origins)}
    for own in first.origins:
        other = theirs.get((own.sha256, own.mm_per_unit))
        if other is not None:
            return own.mesh_from_origin @ other.mesh_from_origin.inverse
    return None


def _why_alike(first: Limb, second: Limb) -> Finding | None:
    """Why both lie in the same coordinates; None where nothing tells."""
    if _shared_share(first, second) >= _SHARED:
        return note("compare.descent.shared_vertices")
    if not isinstance(first, AlignedLimb) or not isinstance(second, AlignedLimb):
        return None
    if not _same_frame(first.frame, second.frame):
        return None
    if _free(first.frame) or _same_faces(first, second) or _same_landmarks(first, second):
        return note("compare.descent.same_frame")
    return None


def _shared_share(first: Limb, second: Limb) -> float:
    own = second.mesh.vertices_mm
    probes = own[np.linspace(0, len(own) - 1, min(_PROBES, len(own))).astype(int)]
    off_mm = np.asarray(KDTree(first.mesh.vertices_mm).query(probes)[0])
    return float(np.mean(off_mm < _SAME_PLACE_MM))


def _same_frame(one: LimbFrame, two: LimbFrame) -> bool:
    motions = one.limb_from_mesh, two.limb_from_mesh
    turned = np.abs(motions[0].rotation - motions[1].rotation).max()
    shifted = np.abs(motions[0].translation - motions[1].translation).max()
    return bool(turned < _SAME_FRAME and shifted < _SAME_PLACE_MM)


def _free(frame: LimbFrame) -> bool:
    """Whether the axes lie as no file format puts them by itself: not along the file's own."""
    return bool(np.abs(frame.limb_from_mesh.rotation).max(1).min() < 1 - _SAME_FRAME)


def _same_faces(first: Limb, second: Limb) -> bool:
    return np.array_equal(first.mesh.faces, second.mesh.faces)


def _same_landmarks(first: Limb, second: Limb) -> bool:
    """One landmark that no edit moved is enough: nobody marks a place twice to the micrometre."""
    return any(
        float(np.abs(one.position_mm - other.position_mm).max()) < _SAME_PLACE_MM
        for one, other in paired(first.landmarks, second.landmarks)
    )


_TURNS = 8
_SAME_MM = 5.0
"""Starts nearer to each other than this along the axis count as one."""
_END_SHARE = 0.005


@dataclass(frozen=True)
class _Trunk:
    """A shape's middle and main directions, the longest last."""

    middle: Vector3
    axes: Matrix3
    """Columns; right-handed."""
    ends_mm: Float64[np.ndarray, "2"]
    """Lowest and highest place along the last axis, from the middle."""


def possible_starts(first_mm: Points3, second_mm: Float64[np.ndarray, "m 3"]) -> list[Rigid]:
    """Poses first_from_second: as the files lie, and long axis on long axis both ways round,

    turned in steps, with the middles, the lower ends or the upper ends together.
    """
    first, second = _trunk(first_mm), _trunk(second_mm)
    starts = [Rigid.identity()]
    for flip in (np.eye(3), np.diag([1.0, -1.0, -1.0])):
        low, high = second.ends_mm if flip[2, 2] > 0 else -second.ends_mm[::-1]
        shifts = [0.0]
        for shift in (first.ends_mm[0] - low, first.ends_mm[1] - high):
            if min(abs(shift - other) for other in shifts) > _SAME_MM:
                shifts.append(float(shift))
        for turn in 2 * np.pi * np.arange(_TURNS) / _TURNS:
            about = Rigid.from_rotation_vector(np.array([0, 0, turn]), np.zeros(3)).rotation
            rotation = first.axes @ about @ flip @ second.axes.T
            for shift in shifts:
                middle = first.middle + shift * first.axes[:, 2]
                starts.append(Rigid(rotation, middle - rotation @ second.middle))
    return starts


def width_mm(places_mm: Points3) -> float:
    """Mean diameter across the long axis, however the shape lies; exact for a tube."""
    across = np.linalg.eigvalsh(np.cov(places_mm.T))[:2].sum()
    return 2 * float(np.sqrt(max(across, 1e-18)))


def _trunk(points_mm: Points3) -> _Trunk:
    middle = points_mm.mean(0)
    _, axes = np.linalg.eigh(np.cov((points_mm - middle).T))
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    along = (points_mm - middle) @ axes[:, 2]
    return _Trunk(middle, axes, np.quantile(along, [_END_SHARE, 1 - _END_SHARE]))


COARSE, MIDDLE, FINE = 300, 1500, 10_000
"""Places on the second surface while starts are tried, while the best compete, and at last."""
_KEPT = 3
_RIVAL_COST, _RIVAL_DEG = 1.05, 10.0


def tried_starts(
    first: Limb, second: Limb, ground: Ground, brim_mm: float, icp: IcpOptions
) -> tuple[Fit, bool]:
    """The best fit of many starts, and whether another one does nearly as well."""
    coarse_mm, middle_mm = places_of(second, COARSE, brim_mm), places_of(second, MIDDLE, brim_mm)
    quick = IcpOptions(tolerance_mm=0.05, max_rounds=10, cap_mm=icp.cap_mm)
    starts = possible_starts(places_of(first, MIDDLE, brim_mm), middle_mm)
    fits = sorted(
        (run_icp(coarse_mm, ground, start, quick) for start in starts),
        key=lambda fit: fit.cost_mm,
    )
    apart: list[Fit] = []
    for fit in fits:
        if len(apart) < _KEPT and all(_turned(fit, other) for other in apart):
            apart.append(fit)
    longer = IcpOptions(tolerance_mm=0.01, max_rounds=40, cap_mm=icp.cap_mm)
    better = sorted(
        (run_icp(middle_mm, ground, fit.first_from_second, longer) for fit in apart),
        key=lambda fit: fit.cost_mm,
    )
    best = better[0]
    rival = any(
        other.cost_mm < _RIVAL_COST * best.cost_mm and _turned(best, other) for other in better[1:]
    )
    return best, rival


def _turned(one: Fit, other: Fit) -> bool:
    turn = angle_between_deg(one.first_from_second.rotation, other.first_from_second.rotation)
    return turn > _RIVAL_DEG


def places_of(limb: Limb, count: int, brim_mm: float) -> Points3:
    """Evenly spread places that were measured and lie away from the brim."""
    samples = sample_evenly(limb.mesh, count)
    kept = measured_faces(limb.mesh, brim_mm)[samples.faces]
    if np.count_nonzero(kept) < FEWEST:
        raise MeasureError("compare.brim.all", name=limb.name, brim_mm=brim_mm)
    return samples.points_mm[kept]
