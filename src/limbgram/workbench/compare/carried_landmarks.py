"""Carried landmarks: a marked limb's landmarks, proposed on another scan of the same limb.

In      the limb of today; a marked one of the same kind and side, such as that of an earlier visit.
Out     for each landmark that today's limb lacks a proposal with its error, or why there is none.
Method  The marked surface is laid on today's as a whole (`registration.py`). About each landmark an
        ever smaller part of it may then turn, shift and grow a little more, as a joint that is held
        otherwise or a lost volume asks for; a Gaussian prior holds these seven motions, and its
        posterior is the next part's prior, widened by what that part may move by itself: assumed,
        and scaled by what the parts of this limb are seen to move, the near ones above all. Patches
        of a surface err alike, so that their number counts, not that of the samples. What the shape
        does not tell stays as wide as the prior: on a plain shank a place errs along it by
        millimetres, on a toe by tenths.
Fails   MeasureError: another kind, another side, or surfaces that are hardly one limb.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import MAD_TO_SIGMA
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import Finding, note
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.landmark import USUAL, Placing
from limbgram.workbench.anatomy.names import identity_of
from limbgram.workbench.compare.counterparts import Counterparts, CounterpartSurface, measured_faces
from limbgram.workbench.compare.deviation import sample_evenly
from limbgram.workbench.compare.icp import tukey
from limbgram.workbench.compare.registration import RegistrationOptions, by_shape
from limbgram.workbench.limb import Landmark, Limb, Side


@dataclass(frozen=True, kw_only=True)
class _FitLevel:
    """A level of the fit: a part about a landmark, and how much it may move in the larger one.

    Lengths are shares of the size, the root of the surface's area: 400 mm of a man's foot with its
    shank. One standard deviation each, assumed.
    """

    reach: float
    turn_deg: float
    shift: float
    growth: float


_FIT_LEVELS = (
    _FitLevel(reach=0.5, turn_deg=5.0, shift=0.02, growth=0.03),
    _FitLevel(reach=0.25, turn_deg=3.0, shift=0.01, growth=0.02),
    _FitLevel(reach=0.11, turn_deg=2.0, shift=0.004, growth=0.02),
)
_SHIFTS = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0])
"""Marks the shifts among the seven motions."""
_SMALLER_SHIFT = 0.0023
"""Shift of still smaller parts, which no surface determines: it falls with their reach as in
`_FIT_LEVELS`, so that those of a half, a quarter and so on of the smallest add up to this."""
_SAMPLES = 20_000
"""Samples of the marked surface: 300 within the smallest part."""
_SAMPLES_PER_FIT = 800
"""Most samples of a part; more add nothing, because errors are correlated in patches."""
_MOST_ROUNDS = 12
_CONVERGED_MM = 1e-3
_PATCH = 0.5
"""Side of a patch whose places err alike, in shares of a part's reach, as in `icp.py`."""
_LEAST_RMS_MM = 0.05
"""Least RMS distance; no two scans agree better."""
_BRIM_MM = 5.0
_LEAST_SHARE = 0.5
_MOST_RMS = 0.004
_MOST_DISTANCE = 0.005
_MOST_SIGMA = 0.0125
_FEWEST_PARTS = 16
"""Fewest parts from which the movement of a limb's parts is estimated."""
_LEAST_INFORMATION = 3.0
"""Least number of motions determined by the surface, over all parts."""
_NEIGHBOURHOOD = 1.0
"""Radius, in reaches, within which other parts count for a part's scale of motion."""
_GLOBAL_WEIGHT = 3.0
"""Weight of all parts together in that, in parts."""
_SCALE_LIMITS = 0.05, 3.0
"""Limits of the scale of motion: heads and thighs show 0.04 to 0.15 of what is
assumed of large parts, 0.2 to 0.4 of small ones."""
_SKIN_SLIDE = 0.03
"""Skin about a bone that stays slides by so much of the size for a radian that a joint turns:
12 mm on a man's foot. Assumed: no scan at hand tells how far the skin goes over a malleolus."""
_OTHER_LIMB_CODES = frozenset({"compare.pose.rival", "compare.shape.mirrored", "compare.shape.far"})
"""Findings of the registration that say that the surfaces are hardly of one limb."""


@dataclass(frozen=True, kw_only=True)
class CarriedPlace:
    """A landmark proposed on today's limb, carried over from the marked one."""

    landmark: Landmark
    """Not confirmed; its sigma includes the marked one's error and both figures below."""
    carrying_mm: float
    """Standard deviation by the fit of shapes, in each direction along the surface.
    `benchmarks/landmarks.py` compares it with known places of the skin."""
    sliding_mm: float = 0.0
    """Assumed standard deviation for skin that slides over the bone beside a turned joint."""


@dataclass(frozen=True, kw_only=True)
class NotCarried:
    """A landmark of the marked limb that could not be carried to today's."""

    name: str
    reason: Finding


@dataclass(frozen=True, kw_only=True)
class Carried:
    """The landmarks carried from a marked limb to today's."""

    places: tuple[CarriedPlace, ...]
    left_out: tuple[NotCarried, ...]
    rms_mm: float
    """RMS distance of both surfaces, aligned as a whole."""

    @property
    def landmarks(self) -> tuple[Landmark, ...]:
        return tuple(one.landmark for one in self.places)


def carry_landmarks(today: Limb, marked: Limb, side: Side, placing: Placing = USUAL) -> Carried:
    """The marked limb's landmarks that nobody has placed on today's, on today's surface.

    Args:
        today: Aligned or not; of a known kind.
        side: Of today's limb, as the clinician says it.
        placing: How well the marked limb's landmarks are placed where they do not say it.

    Raises:
        MeasureError: the marked limb has no landmarks, is of another kind or side, or its surface
            is hardly the same limb's.
    """
    _require_same(today, marked, side)
    laid = by_shape(today, marked, RegistrationOptions(brim_mm=_BRIM_MM))
    alien = next((one for one in laid.notes if one.code in _OTHER_LIMB_CODES), None)
    if alien is not None:
        raise MeasureError("carried.other_limb", name=marked.name, reason=alien)
    known = {identity_of(mark.name) for mark in today.landmarks if mark.confirmed}
    wanted = [mark for mark in marked.landmarks if identity_of(mark.name) not in known]
    carrier = _SurfacePair.of(today.mesh, marked.mesh)
    marks_mm = np.array([mark.position_mm for mark in wanted]).reshape(-1, 3)
    places: list[CarriedPlace] = []
    left_out: list[NotCarried] = []
    fits = carrier.fits(marks_mm, laid.first_from_second)
    slid_mm = _SKIN_SLIDE * carrier.size_mm * _largest_turn_rad(fits)
    for mark, fit in zip(wanted, fits, strict=True):
        sliding = slid_mm if identity_of(mark.name) in _rigid_landmarks(today) else 0.0
        found = carrier.carried(mark, fit, placing, sliding)
        if isinstance(found, Finding):
            left_out.append(NotCarried(name=mark.name, reason=found))
        else:
            places.append(found)
    return Carried(places=tuple(places), left_out=tuple(left_out), rms_mm=laid.rms_mm or 0.0)


def _rigid_landmarks(limb: Limb) -> frozenset[str]:
    """Landmarks on bone that stays where a joint turns, with sliding skin around them."""
    joints = () if limb.kind is None else KIND_NAMED[limb.kind].joints
    return frozenset(name for joint in joints for name in joint.rigid)


def _largest_turn_rad(fits: Sequence["_LocalFit"]) -> float:
    """The largest turn between any two parts of the limb, as by a joint held differently."""
    turns = np.stack([fit.rotation for fit in fits]) if fits else np.eye(3)[None]
    traces = np.einsum("nij,mij->nm", turns, turns)
    return float(np.arccos(np.clip((traces.min() - 1) / 2, -1, 1)))


def _require_same(today: Limb, marked: Limb, side: Side) -> None:
    """Refuse a marked limb that cannot be the same limb by kind or side."""
    if not marked.landmarks:
        raise MeasureError("carried.no_landmarks", name=marked.name)
    if today.kind is None or marked.kind is None:
        raise MeasureError("carried.no_kind", name=(today if today.kind is None else marked).name)
    if today.kind != marked.kind:
        raise MeasureError("carried.kind", name=marked.name, kind=marked.kind, own=today.kind)
    if KIND_NAMED[today.kind].sided and (marked.side == "none" or marked.side != side):
        raise MeasureError("carried.side", name=marked.name, side=marked.side, own=side)


@dataclass(frozen=True, kw_only=True)
class _LocalFit:
    """The fit of a part of the marked surface on today's.

    Motions are a turn about the landmark, rad, a shift, mm, and growth, beside the larger part.
    """

    mark_mm: Vector3
    """The landmark on the marked surface."""
    at_mm: Vector3
    """Its place on today's surface."""
    rotation: Float64[np.ndarray, "3 3"]
    size: float = 1.0
    """Scale over the marked part."""
    covariance: Float64[np.ndarray, "7 7"]
    prior: Float64[np.ndarray, "7 7"]
    """The covariance before the surface was used."""
    motion: Float64[np.ndarray, " 7"]
    rms_mm: float = 0.0
    share: float = 1.0
    """Share of the part that has a counterpart and fits as the rest of it does."""

    @classmethod
    def from_pose(cls, mark_mm: Vector3, pose: Rigid) -> "_LocalFit":
        """The fit of a part by the pose of the whole surface."""
        none = np.zeros((7, 7))
        at = pose.apply(mark_mm[None])[0]
        return cls(
            mark_mm=mark_mm,
            at_mm=at,
            rotation=pose.rotation,
            covariance=none,
            prior=none,
            motion=np.zeros(7),
        )

    def moved(self, motion: Float64[np.ndarray, " 7"]) -> "_LocalFit":
        """The fit after an additional motion of a smaller part."""
        turn = Rigid.from_rotation_vector(motion[:3], np.zeros(3)).rotation
        return replace(
            self,
            at_mm=self.at_mm + motion[3:6],
            rotation=turn @ self.rotation,
            size=self.size * (1 + motion[6]),
            motion=motion,
        )

    def transformed(self, arms_mm: Points3) -> Points3:
        """Points of the marked surface, relative to the landmark, moved to today's surface."""
        return self.at_mm + self.size * arms_mm @ self.rotation.T


@dataclass(frozen=True)
class _SurfacePair:
    """Today's and the marked surface, prepared for fitting."""

    today: CounterpartSurface
    """Today's surface."""
    marked: CounterpartSurface
    samples_mm: Points3
    """Samples of the measured part of the marked surface."""
    size_mm: float

    @classmethod
    def of(cls, today: Mesh, marked: Mesh) -> "_SurfacePair":
        samples = sample_evenly(marked, _SAMPLES)
        kept = measured_faces(marked, _BRIM_MM)[samples.faces]
        return cls(
            today=CounterpartSurface.of(today, _BRIM_MM),
            marked=CounterpartSurface.of(marked, _BRIM_MM),
            samples_mm=samples.points_mm[kept],
            size_mm=float(np.sqrt(marked.area_mm2())),
        )

    def fits(self, marks_mm: Points3, pose: Rigid) -> list[_LocalFit]:
        """The fit of the smallest part about each landmark on today's surface.

        Other places, evenly spread, help to estimate how much parts of this limb move.
        """
        spread = self.samples_mm[:: max(len(self.samples_mm) // _FEWEST_PARTS, 1)]
        beside = spread[: max(_FEWEST_PARTS - len(marks_mm), 0)]
        fits = [_LocalFit.from_pose(at, pose) for at in (*marks_mm, *beside)]
        scales = np.ones((len(fits), 7))
        for part in _FIT_LEVELS:
            own = self._own_covariance(part)
            found = [self._fitted_locally(fit, part, own) for fit in fits]
            scales = _motion_scales(found, part.reach * self.size_mm)
            fits = [
                _with_other_prior(fit, start, start.covariance + own * np.outer(scale, scale))
                for fit, start, scale in zip(found, fits, scales, strict=True)
            ]
        smaller_mm = _SMALLER_SHIFT * self.size_mm * scales[: len(marks_mm), 3]
        return [
            replace(fit, covariance=fit.covariance + np.diag(one_mm**2 * _SHIFTS))
            for fit, one_mm in zip(fits, smaller_mm, strict=False)
        ]

    def _own_covariance(self, part: _FitLevel) -> Float64[np.ndarray, "7 7"]:
        """Prior covariance of a part's own motion."""
        sigmas = [np.radians(part.turn_deg), part.shift * self.size_mm, part.growth]
        return np.diag(np.square(np.repeat(sigmas, [3, 3, 1])))

    def carried(
        self, mark: Landmark, fit: _LocalFit, placing: Placing, sliding_mm: float
    ) -> CarriedPlace | Finding:
        """One landmark on today's surface, or the reason why it cannot be carried."""
        if not mark.confirmed:
            return note("carried.unconfirmed")
        if not self.marked.counterparts(mark.position_mm[None]).measured[0]:
            return note("carried.marked_unmeasured")
        found = self.today.counterparts(fit.at_mm[None])
        carrying_mm = _tangential_sigma(fit.covariance[3:6, 3:6], found.smooth_normals[0])
        reason = self._reason_against(found, fit, carrying_mm)
        if reason is not None:
            return reason
        return CarriedPlace(
            landmark=Landmark(
                name=mark.name,
                position_mm=found.points_mm[0],
                placed="proposed",
                sigma_mm=float(np.hypot(np.hypot(carrying_mm, sliding_mm), placing.of(mark))),
                confirmed=False,
            ),
            carrying_mm=carrying_mm,
            sliding_mm=sliding_mm,
        )

    def _reason_against(
        self, found: Counterparts, fit: _LocalFit, carrying_mm: float
    ) -> Finding | None:
        """The reason why a place on today's surface cannot be trusted, if there is one."""
        if not found.measured[0] or found.at_brim[0]:
            return note("carried.unmeasured")
        if fit.share < _LEAST_SHARE:
            return note("carried.little", share=fit.share)
        off_mm = abs(float(found.signed_mm[0]))
        if off_mm > max(_MOST_DISTANCE * self.size_mm, 4 * fit.rms_mm):
            return note("carried.apart", off_mm=off_mm)
        if fit.rms_mm > _MOST_RMS * self.size_mm:
            return note("carried.changed", rms_mm=fit.rms_mm)
        if carrying_mm > _MOST_SIGMA * self.size_mm:
            return note("carried.loose", sigma_mm=carrying_mm)
        return None

    def _fitted_locally(
        self, start: _LocalFit, part: _FitLevel, own: Float64[np.ndarray, "7 7"]
    ) -> _LocalFit:
        """A part fitted to today's surface, starting at the larger part's fit (Gauss-Newton)."""
        reach_mm = part.reach * self.size_mm
        arms = self.samples_mm - start.mark_mm
        away = np.linalg.norm(arms, axis=1) / reach_mm
        arms, away = arms[away < 1], away[away < 1]
        thin = max(len(arms) // _SAMPLES_PER_FIT, 1)
        arms, bell = arms[::thin], (1 - away[::thin] ** 2) ** 2
        prior = start.covariance + own
        held = np.linalg.inv(prior)
        fit = replace(start, motion=np.zeros(7), prior=prior, covariance=prior)
        for _ in range(_MOST_ROUNDS):
            placed = fit.transformed(arms)
            found = self.today.counterparts(placed)
            weights = _weights(found, bell)
            share = float(weights.sum() / max(bell.sum(), 1e-12))
            if share < _LEAST_SHARE:
                return replace(fit, share=share)
            off_mm, across = found.signed_mm, found.smooth_normals
            mean_mm2 = max(float(weights @ off_mm**2 / weights.sum()), _LEAST_RMS_MM**2)
            patches = np.pi / 3 / _PATCH**2 * share  # the bell holds a third of its disc
            counted = weights / weights.sum() * patches / mean_mm2
            turned = placed - fit.at_mm
            levers = np.sum(turned * across, axis=1)
            columns = np.column_stack([np.cross(turned, across), across, levers])
            normal = (columns * counted[:, None]).T @ columns + held
            step = -np.linalg.solve(normal, columns.T @ (counted * off_mm) + held @ fit.motion)
            fit = replace(
                start.moved(fit.motion + step),
                prior=prior,
                covariance=np.linalg.inv(normal),
                rms_mm=float(np.sqrt(mean_mm2)),
                share=share,
            )
            if np.abs(step[3:6]).max() < _CONVERGED_MM:
                break
        return fit


def _motion_scales(fits: Sequence[_LocalFit], reach_mm: float) -> Float64[np.ndarray, "n 7"]:
    """Scales of each part's motion over the assumed one: by turn, shift and growth.

    What the surface told of a motion, over what it would have told of one as large as assumed: of
    the parts near by, as a joint turns only what lies beside it, and with the weight of a few
    parts of all of them.
    """
    there = np.array([one.share >= _LEAST_SHARE for one in fits])
    scales = np.ones((len(fits), 7))
    if not there.any():
        return scales
    usual = np.stack([np.diag(one.prior) for one in fits])[there]
    moved = np.stack([one.motion for one in fits])[there] ** 2 / usual
    told = 1 - np.stack([np.diag(one.covariance) for one in fits])[there] / usual
    places = np.stack([one.mark_mm for one in fits])
    apart = np.linalg.norm(places[:, None] - places[None, there], axis=2)
    near = np.exp(-((apart / (_NEIGHBOURHOOD * reach_mm)) ** 2))
    for group in (slice(0, 3), slice(3, 6), slice(6, 7)):
        own_moved, own_told = moved[:, group].sum(1), told[:, group].sum(1)
        if own_told.sum() < _LEAST_INFORMATION:
            continue
        whole = own_moved.sum() / own_told.sum()
        share = _GLOBAL_WEIGHT * own_told.mean()
        local = (near @ own_moved + share * whole) / (near @ own_told + share)
        scales[:, group] = np.clip(np.sqrt(local), *_SCALE_LIMITS)[:, None]
    return scales


def _with_other_prior(
    fit: _LocalFit, start: _LocalFit, prior: Float64[np.ndarray, "7 7"]
) -> _LocalFit:
    """The fit with another prior, as if the surface were linear in the motion."""
    if fit.share < _LEAST_SHARE:
        return replace(fit, prior=prior, covariance=prior)
    normal = np.linalg.inv(fit.covariance)
    other = normal - np.linalg.inv(fit.prior) + np.linalg.inv(prior)
    motion = np.linalg.solve(other, normal @ fit.motion)
    return replace(
        start.moved(motion),
        prior=prior,
        covariance=np.linalg.inv(other),
        rms_mm=fit.rms_mm,
        share=fit.share,
    )


def _weights(found: Counterparts, bell: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Tukey's weights times the part's bell; zero where there is no counterpart."""
    valid: Bool[np.ndarray, " n"] = ~found.at_brim & found.measured
    if not valid.any():
        return np.zeros(len(bell))
    off_mm = np.abs(found.signed_mm)
    scale_mm = max(MAD_TO_SIGMA * float(np.median(off_mm[valid])), _LEAST_RMS_MM)
    return np.where(valid, bell * tukey(off_mm, scale_mm), 0)


def _tangential_sigma(covariance: Float64[np.ndarray, "3 3"], normal: Vector3) -> float:
    """Mean standard deviation in the two directions along the surface."""
    flat = np.eye(3) - np.outer(normal, normal)
    return float(np.sqrt(np.trace(flat @ covariance @ flat) / 2))
