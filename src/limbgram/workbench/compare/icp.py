"""ICP: robust point-to-plane registration of a surface on another.

In      samples of the second surface, the first as a CounterpartSurface, and a start pose.
Out     a Fit: the pose, how well it fits, and whether the shape determines it at all.
Method  Gauss-Newton on the signed distance to the surface: point to plane (Chen and Medioni
        1992), but along the direction to the nearest place, which does not jump between triangles.
        Tukey's weights, their scale from the median and never growing, until the places stand.
        Where the relative pose is unknown, `best_of_starts` runs it from the principal
        axes of both, turned in steps, and keeps the best.
Fails   MeasureError: a shape has no measured surface away from its brim.

`known_pose` says how two shapes lie where one was made from the other. The limb files name what a
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
from limbgram.core.interval import MAD_TO_SIGMA, rms, widening
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.anatomy.names import paired_landmarks
from limbgram.workbench.compare.counterparts import Counterparts, CounterpartSurface, measured_faces
from limbgram.workbench.compare.deviation import sample_evenly
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

_TUKEY_CUTOFF = 4.685
"""Residuals beyond this many standard deviations get no weight."""
_SMALLEST_SCALE_MM = 1e-7
FEWEST = 12
"""Fewest samples that determine a pose."""
_TOLERANCE_SHARE = 1e-4
_SINGULAR = 1e-8
_NEARLY_STILL_MM = 0.05
"""From here on the set of samples with a counterpart is fixed; else those at brims flicker."""
_TOUCHING_MM = 1e-6
"""Nearer than this the direction to the nearest place is rounding; the normal replaces it."""
_LEAST_SLOPE = 0.25
"""Least value of the influence slope, for when most samples are nearly rejected."""
_PATCH = 1.0
"""Side of a patch of correlated errors, as a share of the surface's mean radius.

A limb changes over such lengths. Where errors are shorter, few large patches hold as often."""
_UNDETERMINED = 3e-5
"""A motion is undetermined if the surface answers it by less than the root of this, mm per mm."""


@dataclass(frozen=True, kw_only=True)
class PoseCovariance:
    """The covariance of a pose: how freely the second surface can still move on the first."""

    middle_mm: Vector3
    """Centre of the samples that count, in the first's frame."""
    covariance: Float64[np.ndarray, "6 6"]
    """Of a turn about the centre, rad, then of a shift there, mm. Errors are correlated within
    patches, and uniform growth by the remaining difference counts as an error of the pose."""
    growth_shift: Vector3
    """Shift for which uniform growth of 1 mm would be taken, mm per mm; zero by landmarks."""

    @property
    def covariance_mm2(self) -> Matrix3:
        """Covariance of the shift alone."""
        return self.covariance[3:, 3:]

    def sigmas_mm(self, points_mm: Points3, normals: Points3) -> Float64[np.ndarray, " n"]:
        """Standard deviation of the second surface's position along normals at points."""
        columns = _jacobian(points_mm, normals, self.middle_mm, 1.0)
        return np.sqrt(np.einsum("ni,ij,nj->n", columns, self.covariance, columns).clip(0.0))


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A pose found by ICP, and how well it fits."""

    first_from_second: Rigid
    rms_mm: float
    """Unweighted RMS distance along the normals of the samples that have a counterpart."""
    used_share: float
    """Share of samples with a counterpart that were not rejected as changed."""
    cost_mm: float
    """RMS distance of all samples, each at most `_CAP_MM`."""
    rounds: int
    converged: bool
    undetermined: tuple[Finding, ...]
    """Doubts about motions that hardly change the fit."""
    larger_share: float
    """By how much, as a fraction of all lengths, the second surface is larger than the first."""
    pose_covariance: PoseCovariance | None
    """None where too few samples count."""


@dataclass(frozen=True, kw_only=True)
class IcpOptions:
    """When to stop, and what counts as far."""

    tolerance_mm: float = 1e-4
    """The last round moves the places by less, or by a ten-thousandth of their distances."""
    max_rounds: int = 60


DEFAULTS = IcpOptions()
_CAP_MM = 10.0
"""Largest distance that a place adds to the cost by which poses are ranked."""


def run_icp(
    points_mm: Points3,
    surface: CounterpartSurface,
    start: Rigid,
    options: IcpOptions = DEFAULTS,
) -> Fit:
    """Register samples on a surface from a start pose."""
    return _fit(points_mm, surface, _settled(points_mm, surface, start, options))


@dataclass(frozen=True)
class _SettledPose:
    """Where the iteration ended."""

    first_from_second: Rigid
    rounds: int
    converged: bool


def _settled(
    points_mm: Points3, surface: CounterpartSurface, start: Rigid, options: IcpOptions
) -> _SettledPose:
    pose, rounds, moved_mm = start, 0, np.inf
    scale_mm, valid = np.inf, np.ones(len(points_mm), bool)
    tolerance_mm = options.tolerance_mm
    while rounds < options.max_rounds and moved_mm > tolerance_mm:
        placed = pose.apply(points_mm)
        found = surface.counterparts(placed)
        if moved_mm > _NEARLY_STILL_MM:
            valid = _has_counterpart(found)
        scale_mm = min(scale_mm, _scale_mm(found, valid))
        weights = _weights(found, valid, scale_mm)
        if np.count_nonzero(weights) < FEWEST:
            break
        tolerance_mm = max(options.tolerance_mm, _TOLERANCE_SHARE * scale_mm)
        step = _gauss_newton_step(placed, found, weights)
        moved_mm = rms(step.apply(placed) - placed)
        pose, rounds = _orthonormal(step @ pose), rounds + 1
    converged = rounds > 0 and moved_mm <= tolerance_mm
    return _SettledPose(pose, rounds, converged)


def _fit(points_mm: Points3, surface: CounterpartSurface, settled: _SettledPose) -> Fit:
    placed = settled.first_from_second.apply(points_mm)
    found = surface.counterparts(placed)
    valid = _has_counterpart(found)
    weights = _weights(found, valid, _scale_mm(found, valid))
    off_mm = found.signed_mm[valid]
    return Fit(
        first_from_second=settled.first_from_second,
        rms_mm=rms(off_mm),
        used_share=float(np.count_nonzero(weights) / len(weights)),
        cost_mm=_cost_mm(found),
        rounds=settled.rounds,
        converged=settled.converged,
        undetermined=_undetermined(placed, found, weights),
        larger_share=_growth_share(placed, found, valid),
        pose_covariance=_pose_covariance(placed, found, weights),
    )


def _cost_mm(found: Counterparts) -> float:
    capped = np.minimum(np.abs(found.signed_mm), _CAP_MM)
    capped[found.at_brim] = _CAP_MM
    return rms(capped)


def _growth_share(placed: Points3, found: Counterparts, valid: Bool[np.ndarray, " n"]) -> float:
    """The uniform growth that, with a shift, best explains the distances (least squares)."""
    if np.count_nonzero(valid) < FEWEST:
        return float("nan")
    normals, points = found.smooth_normals[valid], placed[valid]
    levers = ((points - points.mean(0)) * normals).sum(1)
    columns = np.column_stack([levers, normals])
    slope = float(np.linalg.lstsq(columns, found.signed_mm[valid], rcond=None)[0][0])
    return 1 / max(1 - slope, 0.1) - 1


def _pose_covariance(
    placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]
) -> PoseCovariance | None:
    """The pose's covariance from residuals clustered by patches, and from uniform growth.

    Growth all round pulls every patch the same way. Counted among their pulls as well, it would
    pass for as many errors that know nothing of each other.
    """
    if np.count_nonzero(weights) < FEWEST:
        return None
    middle, reach_mm = _centre_and_radius(placed, weights)
    columns = _jacobian(placed, found.smooth_normals, middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns
    inverse = np.linalg.pinv(normal, rcond=_SINGULAR, hermitian=True)
    cells = np.floor((placed - middle) / (_PATCH * reach_mm)).astype(int)
    patch = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    pulls = _patch_pulls(columns, found.signed_mm, weights, patch)
    moved = pulls @ inverse / _mean_influence_slope(weights)
    growth = inverse @ (columns.T @ weights)
    off_mm, counted = np.bincount(patch, weights * found.signed_mm), np.bincount(patch, weights)
    off_mm2 = float(np.sum(off_mm**2 / np.maximum(counted, 1e-12)) / counted.sum())
    covariance = moved.T @ moved + off_mm2 * np.outer(growth, growth)
    in_rad = np.repeat([1 / reach_mm, 1.0], 3)  # turns were counted in mm at the reach
    return PoseCovariance(
        middle_mm=middle,
        covariance=covariance * np.outer(in_rad, in_rad),
        growth_shift=growth[3:],
    )


def _patch_pulls(
    columns: Float64[np.ndarray, "n 6"],
    off_mm: Float64[np.ndarray, " n"],
    weights: Float64[np.ndarray, " n"],
    patch: Int[np.ndarray, " n"],
) -> Float64[np.ndarray, "p 6"]:
    """The pull of each patch's common error on the pose, without uniform growth.

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


def _mean_influence_slope(weights: Float64[np.ndarray, " n"]) -> float:
    """Mean slope of Tukey's influence function over its weight.

    Huber 1981, Robust Statistics, 7.6.
    """
    roots = np.sqrt(weights)
    return max(float((roots * (5 * roots - 4)).sum() / weights.sum()), _LEAST_SLOPE)


def _has_counterpart(found: Counterparts) -> Bool[np.ndarray, " n"]:
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
    """Tukey's weights; zero where there is no counterpart."""
    return np.where(valid, tukey(found.signed_mm, scale_mm), 0.0)


def tukey(off_mm: Float64[np.ndarray, " n"], scale_mm: float) -> Float64[np.ndarray, " n"]:
    """Tukey's biweight of distances for a scale; zero beyond 4.685 times the scale."""
    return np.clip(1 - (off_mm / (_TUKEY_CUTOFF * scale_mm)) ** 2, 0, None) ** 2


def _distance_gradients(placed: Points3, found: Counterparts) -> Points3:
    """Unit gradients of the distance at the samples."""
    sizes = np.abs(found.signed_mm)
    apart = sizes > _TOUCHING_MM
    ways = found.flat_normals.copy()
    ways[apart] = (placed - found.points_mm)[apart] / found.signed_mm[apart, None]
    return ways


def _gauss_newton_step(
    placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]
) -> Rigid:
    """One Gauss-Newton step; motions that the shape does not determine stay zero."""
    middle, reach_mm = _centre_and_radius(placed, weights)
    columns = _jacobian(placed, _distance_gradients(placed, found), middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns / weights.sum()
    towards = columns.T @ (weights * found.signed_mm) / weights.sum()
    values, vectors = np.linalg.eigh(normal)
    felt = values > _SINGULAR
    motion = -(vectors[:, felt] / values[felt]) @ (vectors[:, felt].T @ towards)
    turn = Rigid.from_rotation_vector(motion[:3] / reach_mm, np.zeros(3)).rotation
    return Rigid(turn, middle + motion[3:] - turn @ middle)


def _centre_and_radius(
    placed: Points3, weights: Float64[np.ndarray, " n"]
) -> tuple[Vector3, float]:
    """Weighted centroid, and the RMS distance from it."""
    middle = weights @ placed / weights.sum()
    square = float(weights @ ((placed - middle) ** 2).sum(1) / weights.sum())
    return middle, max(np.sqrt(square), 1e-9)


def _jacobian(placed: Points3, normals: Points3, middle: Vector3, reach_mm: float) -> np.ndarray:
    """Motion along the normals for a millimetre of turning (at the radius) and of shifting."""
    return np.column_stack([np.cross(placed - middle, normals) / reach_mm, normals])


def _undetermined(
    placed: Points3, found: Counterparts, weights: Float64[np.ndarray, " n"]
) -> tuple[Finding, ...]:
    if not weights.any():
        return (doubt("compare.shape.tells_nothing"),)
    middle, reach_mm = _centre_and_radius(placed, weights)
    columns = _jacobian(placed, found.smooth_normals, middle, reach_mm)
    normal = (columns * weights[:, None]).T @ columns / weights.sum()
    values, vectors = np.linalg.eigh(normal)
    open_motions: list[Finding] = []
    for value, vector in zip(values, vectors.T):
        if value < _UNDETERMINED:
            turning = float(np.sum(vector[:3] ** 2)) > 0.5
            direction = vector[:3] if turning else vector[3:]
            direction = direction / np.linalg.norm(direction)
            direction *= np.sign(direction[np.argmax(np.abs(direction))])
            way = tuple((direction + 0.0).tolist())
            open_motions.append(doubt("compare.shape.open", turning=turning, direction=way))
    return tuple(open_motions)


def _orthonormal(pose: Rigid) -> Rigid:
    """The pose with its rotation made orthonormal again."""
    u, _, vt = np.linalg.svd(pose.rotation)
    return Rigid(u @ vt, pose.translation)


_SAME_FRAME = 1e-9
_SAME_PLACE_MM = 1e-3
"""A file's rounding."""
_PROBES = 500
_LEAST_SHARED = 0.05
"""Least share of the second's vertices on the first's that is no coincidence."""


@dataclass(frozen=True)
class KnownPose:
    """The known pose of two shapes of which one was made from the other."""

    first_from_second: Rigid
    """Between the frames of the meshes."""
    because: Finding


def known_pose(first: Limb, second: Limb) -> KnownPose | None:
    """The pose of two shapes if one was made from the other; None if that is not known."""
    told = _pose_by_origins(first, second)
    if told is not None:
        return KnownPose(told, note("compare.descent.one_file"))
    because = _why_same_coordinates(first, second)
    return None if because is None else KnownPose(Rigid.identity(), because)


def _pose_by_origins(first: Limb, second: Limb) -> Rigid | None:
    """The pose by the nearest file that both come from, read in the same unit."""
    theirs = {(one.sha256, one.mm_per_unit): one for one in reversed(second.origins)}
    for own in first.origins:
        other = theirs.get((own.sha256, own.mm_per_unit))
        if other is not None:
            return own.mesh_from_origin @ other.mesh_from_origin.inverse
    return None


def _why_same_coordinates(first: Limb, second: Limb) -> Finding | None:
    """Why both lie in the same coordinates; None if that is not known."""
    if _shared_vertex_share(first, second) >= _LEAST_SHARED:
        return note("compare.descent.shared_vertices")
    if not isinstance(first, AlignedLimb) or not isinstance(second, AlignedLimb):
        return None
    if not _same_frame(first.frame, second.frame):
        return None
    if _is_oblique(first.frame) or _same_faces(first, second) or _same_landmarks(first, second):
        return note("compare.descent.same_frame")
    return None


def _shared_vertex_share(first: Limb, second: Limb) -> float:
    own = second.mesh.vertices_mm
    probes = own[np.linspace(0, len(own) - 1, min(_PROBES, len(own))).astype(int)]
    off_mm = np.asarray(KDTree(first.mesh.vertices_mm).query(probes)[0])
    return float(np.mean(off_mm < _SAME_PLACE_MM))


def _same_frame(one: LimbFrame, two: LimbFrame) -> bool:
    motions = one.limb_from_mesh, two.limb_from_mesh
    turned = np.abs(motions[0].rotation - motions[1].rotation).max()
    shifted = np.abs(motions[0].translation - motions[1].translation).max()
    return bool(turned < _SAME_FRAME and shifted < _SAME_PLACE_MM)


def _is_oblique(frame: LimbFrame) -> bool:
    """Whether the limb's axes are oblique to the file's, as no format sets them by itself."""
    return bool(np.abs(frame.limb_from_mesh.rotation).max(1).min() < 1 - _SAME_FRAME)


def _same_faces(first: Limb, second: Limb) -> bool:
    return np.array_equal(first.mesh.faces, second.mesh.faces)


def _same_landmarks(first: Limb, second: Limb) -> bool:
    """Whether a landmark lies at the same place in both, as nobody marks it twice so exactly."""
    return any(
        float(np.abs(one.position_mm - other.position_mm).max()) < _SAME_PLACE_MM
        for one, other in paired_landmarks(first.landmarks, second.landmarks)
    )


_TURNS = 8
_SAME_START_MM = 5.0
"""Starts nearer to each other than this along the axis count as one."""
_END_SHARE = 0.005


@dataclass(frozen=True)
class _PrincipalAxes:
    """A shape's centroid and principal axes, the longest last."""

    middle: Vector3
    axes: Matrix3
    """Columns; right-handed."""
    ends_mm: Float64[np.ndarray, "2"]
    """Lowest and highest place along the last axis, from the middle."""


def possible_starts(first_mm: Points3, second_mm: Float64[np.ndarray, "m 3"]) -> list[Rigid]:
    """Start poses first_from_second: the files' coordinates, and long axis on long axis, both ways
    round, turned in steps, with the centres, the lower ends or the upper ends together.
    """
    first, second = _principal_axes(first_mm), _principal_axes(second_mm)
    starts = [Rigid.identity()]
    for flip in (np.eye(3), np.diag([1.0, -1.0, -1.0])):
        low, high = second.ends_mm if flip[2, 2] > 0 else -second.ends_mm[::-1]
        shifts = [0.0]
        for shift in (first.ends_mm[0] - low, first.ends_mm[1] - high):
            if min(abs(shift - other) for other in shifts) > _SAME_START_MM:
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


def _principal_axes(points_mm: Points3) -> _PrincipalAxes:
    middle = points_mm.mean(0)
    _, axes = np.linalg.eigh(np.cov((points_mm - middle).T))
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    along = (points_mm - middle) @ axes[:, 2]
    return _PrincipalAxes(middle, axes, np.quantile(along, [_END_SHARE, 1 - _END_SHARE]))


COARSE, MIDDLE, FINE = 300, 1500, 10_000
"""Samples of the second surface while starts are tried, while the best compete, and at last."""
_STARTS_KEPT = 3
_RIVAL_COST, _RIVAL_DEG = 1.05, 10.0


@dataclass(frozen=True)
class _RankedPose:
    """A pose found from one of many starts."""

    first_from_second: Rigid
    cost_mm: float

    @classmethod
    def of(
        cls, points_mm: Points3, surface: CounterpartSurface, start: Rigid, options: IcpOptions
    ) -> "_RankedPose":
        pose = _settled(points_mm, surface, start, options).first_from_second
        return cls(pose, _cost_mm(surface.counterparts(pose.apply(points_mm))))


def best_of_starts(
    first: Limb, second: Limb, surface: CounterpartSurface, brim_mm: float
) -> tuple[Rigid, bool]:
    """The best pose from many starts, and whether another one is nearly as good."""
    coarse_mm, middle_mm = (
        measured_samples(second, COARSE, brim_mm),
        measured_samples(second, MIDDLE, brim_mm),
    )
    quick = IcpOptions(tolerance_mm=0.05, max_rounds=10)
    starts = possible_starts(measured_samples(first, MIDDLE, brim_mm), middle_mm)
    fits = sorted(
        (_RankedPose.of(coarse_mm, surface, start, quick) for start in starts),
        key=lambda fit: fit.cost_mm,
    )
    apart: list[_RankedPose] = []
    for fit in fits:
        if len(apart) < _STARTS_KEPT and all(_is_turned(fit, other) for other in apart):
            apart.append(fit)
    longer = IcpOptions(tolerance_mm=0.01, max_rounds=40)
    better = sorted(
        (_RankedPose.of(middle_mm, surface, fit.first_from_second, longer) for fit in apart),
        key=lambda fit: fit.cost_mm,
    )
    best = better[0]
    rival = any(
        other.cost_mm < _RIVAL_COST * best.cost_mm and _is_turned(best, other)
        for other in better[1:]
    )
    return best.first_from_second, rival


def _is_turned(one: _RankedPose, other: _RankedPose) -> bool:
    turn = angle_between_deg(one.first_from_second.rotation, other.first_from_second.rotation)
    return turn > _RIVAL_DEG


def measured_samples(limb: Limb, count: int, brim_mm: float) -> Points3:
    """Evenly spread samples of the measured surface away from the brim."""
    samples = sample_evenly(limb.mesh, count)
    kept = measured_faces(limb.mesh, brim_mm)[samples.faces]
    if np.count_nonzero(kept) < FEWEST:
        raise MeasureError("compare.brim.all", name=limb.name, brim_mm=brim_mm)
    return samples.points_mm[kept]
