"""Carried landmarks: those of a marked limb, proposed on another scan of the same limb.

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
from limbgram.workbench.compare.counterparts import Counterparts, Ground, measured_faces
from limbgram.workbench.compare.deviation import sample_evenly
from limbgram.workbench.compare.icp import tukey
from limbgram.workbench.compare.registration import RegistrationOptions, by_shape
from limbgram.workbench.limb import Landmark, Limb, Side


@dataclass(frozen=True, kw_only=True)
class _Part:
    """A part of the surface about a landmark, and how much it may move beside the larger one.

    Lengths are shares of the size, the root of the surface's area: 400 mm of a man's foot with its
    shank. One standard deviation each, assumed.
    """

    reach: float
    turn_deg: float
    shift: float
    growth: float


_PARTS = (
    _Part(reach=0.5, turn_deg=5.0, shift=0.02, growth=0.03),
    _Part(reach=0.25, turn_deg=3.0, shift=0.01, growth=0.02),
    _Part(reach=0.11, turn_deg=2.0, shift=0.004, growth=0.02),
)
_SHIFTS = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0])
"""Which of the seven motions are shifts."""
_SMALLER_SHIFT = 0.0023
"""What still smaller parts shift by themselves, which no surface tells: as in `_PARTS` it goes with
their reach, so that those of a half, a quarter and so on of the smallest add up to this."""
_SAMPLES = 20_000
"""Places on the marked surface: 300 within the smallest part."""
_PLACES = 800
"""Of a part: more of them tell no more, as their patches err alike."""
_MOST_ROUNDS = 12
_STILL_MM = 1e-3
_PATCH = 0.5
"""Side of a patch whose places err alike, in shares of a part's reach, as in `icp.py`."""
_LEAST_RMS_MM = 0.05
"""No two scans agree better."""
_BRIM_MM = 5.0
_LEAST_SHARE = 0.5
_MOST_RMS = 0.004
_MOST_OFF = 0.005
_MOST_SIGMA = 0.0125
_FEWEST_PARTS = 16
"""Parts that tell how much those of a limb move."""
_LEAST_TOLD = 3.0
"""Motions that the surface must have told, of those parts together."""
_NEAR = 1.0
"""So far from a part, in reaches, the others count for how much it moves."""
_OF_ALL = 3.0
"""As many parts' weight all of them together have in that."""
_SCALES = 0.05, 3.0
"""Within these, a limb says how much its parts move: heads and thighs 0.04 to 0.15 of what is
assumed of large parts, 0.2 to 0.4 of small ones."""
_SKIN = 0.03
"""Skin about a bone that stays slides by so much of the size for a radian that a joint turns:
12 mm on a man's foot. Assumed: no scan at hand tells how far the skin goes over a malleolus."""
_ALIEN = frozenset({"compare.pose.rival", "compare.shape.mirrored", "compare.shape.far"})
"""What the registration says where the surfaces are hardly one limb, or lie as nobody knows."""


@dataclass(frozen=True, kw_only=True)
class CarriedPlace:
    """A landmark on today's limb, as the marked one tells it."""

    landmark: Landmark
    """Not confirmed; its sigma holds what the marked one errs by, and both figures below."""
    carrying_mm: float
    """What the shape leaves open: one standard deviation in each direction along the surface.
    `benchmarks/landmarks.py` holds it against places of the skin that are known."""
    sliding_mm: float = 0.0
    """An allowance for skin that slides over the bone beside a turned joint: the same, assumed."""


@dataclass(frozen=True, kw_only=True)
class NotCarried:
    """A landmark of the marked limb that today's cannot be told by it."""

    name: str
    reason: Finding


@dataclass(frozen=True, kw_only=True)
class Carried:
    """What a marked limb tells of today's."""

    places: tuple[CarriedPlace, ...]
    left_out: tuple[NotCarried, ...]
    rms_mm: float
    """How far both surfaces lie apart, laid on each other as a whole."""

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
    alien = next((one for one in laid.notes if one.code in _ALIEN), None)
    if alien is not None:
        raise MeasureError("carried.other_limb", name=marked.name, reason=alien)
    known = {identity_of(mark.name) for mark in today.landmarks if mark.confirmed}
    wanted = [mark for mark in marked.landmarks if identity_of(mark.name) not in known]
    carrier = _Carrier.of(today.mesh, marked.mesh)
    marks_mm = np.array([mark.position_mm for mark in wanted]).reshape(-1, 3)
    places: list[CarriedPlace] = []
    left_out: list[NotCarried] = []
    fits = carrier.fits(marks_mm, laid.first_from_second)
    slid_mm = _SKIN * carrier.size_mm * _turned_rad(fits)
    for mark, fit in zip(wanted, fits, strict=True):
        sliding = slid_mm if identity_of(mark.name) in _still_names(today) else 0.0
        found = carrier.carried(mark, fit, placing, sliding)
        if isinstance(found, Finding):
            left_out.append(NotCarried(name=mark.name, reason=found))
        else:
            places.append(found)
    return Carried(places=tuple(places), left_out=tuple(left_out), rms_mm=laid.rms_mm or 0.0)


def _still_names(limb: Limb) -> frozenset[str]:
    """Landmarks on bone that stays where a joint turns: the skin around them slides."""
    joints = () if limb.kind is None else KIND_NAMED[limb.kind].joints
    return frozenset(name for joint in joints for name in joint.rigid)


def _turned_rad(fits: Sequence["_Fit"]) -> float:
    """How far any two parts of the limb turned against each other: a joint is held otherwise."""
    turns = np.stack([fit.rotation for fit in fits]) if fits else np.eye(3)[None]
    traces = np.einsum("nij,mij->nm", turns, turns)
    return float(np.arccos(np.clip((traces.min() - 1) / 2, -1, 1)))


def _require_same(today: Limb, marked: Limb, side: Side) -> None:
    """Refuse what cannot be the same limb by what is said of it."""
    if not marked.landmarks:
        raise MeasureError("carried.no_landmarks", name=marked.name)
    if today.kind is None or marked.kind is None:
        raise MeasureError("carried.no_kind", name=(today if today.kind is None else marked).name)
    if today.kind != marked.kind:
        raise MeasureError("carried.kind", name=marked.name, kind=marked.kind, own=today.kind)
    if KIND_NAMED[today.kind].sided and (marked.side == "none" or marked.side != side):
        raise MeasureError("carried.side", name=marked.name, side=marked.side, own=side)


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """How a part of the marked surface lies on today's.

    Motions are a turn about the landmark, rad, a shift, mm, and growth, beside the larger part.
    """

    mark_mm: Vector3
    """The landmark on the marked surface."""
    at_mm: Vector3
    """Where it comes to lie."""
    rotation: Float64[np.ndarray, "3 3"]
    size: float = 1.0
    """Over the marked part's."""
    covariance: Float64[np.ndarray, "7 7"]
    prior: Float64[np.ndarray, "7 7"]
    """The covariance before the surface was asked."""
    motion: Float64[np.ndarray, " 7"]
    rms_mm: float = 0.0
    share: float = 1.0
    """Of the part that has a counterpart and lies as the rest of it."""

    @classmethod
    def laid(cls, mark_mm: Vector3, pose: Rigid) -> "_Fit":
        """As the whole surface lies."""
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

    def moved(self, motion: Float64[np.ndarray, " 7"]) -> "_Fit":
        """As a smaller part of it lies."""
        turn = Rigid.from_rotation_vector(motion[:3], np.zeros(3)).rotation
        return replace(
            self,
            at_mm=self.at_mm + motion[3:6],
            rotation=turn @ self.rotation,
            size=self.size * (1 + motion[6]),
            motion=motion,
        )

    def placed(self, arms_mm: Points3) -> Points3:
        """Places of the marked surface, from the landmark on, where they come to lie."""
        return self.at_mm + self.size * arms_mm @ self.rotation.T


@dataclass(frozen=True)
class _Carrier:
    """Two surfaces made ready."""

    ground: Ground
    """Of today."""
    marked: Ground
    samples_mm: Points3
    """On the marked surface, where it was measured."""
    size_mm: float

    @classmethod
    def of(cls, today: Mesh, marked: Mesh) -> "_Carrier":
        samples = sample_evenly(marked, _SAMPLES)
        kept = measured_faces(marked, _BRIM_MM)[samples.faces]
        return cls(
            ground=Ground.of(today, _BRIM_MM),
            marked=Ground.of(marked, _BRIM_MM),
            samples_mm=samples.points_mm[kept],
            size_mm=float(np.sqrt(marked.area_mm2())),
        )

    def fits(self, marks_mm: Points3, pose: Rigid) -> list[_Fit]:
        """The smallest part about each place, laid on today's surface.

        Other places beside them, evenly spread, tell how much parts of this limb move.
        """
        spread = self.samples_mm[:: max(len(self.samples_mm) // _FEWEST_PARTS, 1)]
        beside = spread[: max(_FEWEST_PARTS - len(marks_mm), 0)]
        fits = [_Fit.laid(at, pose) for at in (*marks_mm, *beside)]
        scales = np.ones((len(fits), 7))
        for part in _PARTS:
            own = self._own(part)
            found = [self._fitted(fit, part, own) for fit in fits]
            scales = _scales_of(found, part.reach * self.size_mm)
            fits = [
                _with_prior(fit, start, start.covariance + own * np.outer(scale, scale))
                for fit, start, scale in zip(found, fits, scales, strict=True)
            ]
        smaller_mm = _SMALLER_SHIFT * self.size_mm * scales[: len(marks_mm), 3]
        return [
            replace(fit, covariance=fit.covariance + np.diag(one_mm**2 * _SHIFTS))
            for fit, one_mm in zip(fits, smaller_mm, strict=False)
        ]

    def _own(self, part: _Part) -> Float64[np.ndarray, "7 7"]:
        """Covariance of what a part may move by itself."""
        sigmas = [np.radians(part.turn_deg), part.shift * self.size_mm, part.growth]
        return np.diag(np.square(np.repeat(sigmas, [3, 3, 1])))

    def carried(
        self, mark: Landmark, fit: _Fit, placing: Placing, sliding_mm: float
    ) -> CarriedPlace | Finding:
        """One landmark on today's surface, or why it is not told."""
        if not mark.confirmed:
            return note("carried.unconfirmed")
        if not self.marked.counterparts(mark.position_mm[None]).measured[0]:
            return note("carried.marked_unmeasured")
        found = self.ground.counterparts(fit.at_mm[None])
        carrying_mm = _along(fit.covariance[3:6, 3:6], found.smooth_normals[0])
        reason = self._against(found, fit, carrying_mm)
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

    def _against(self, found: Counterparts, fit: _Fit, carrying_mm: float) -> Finding | None:
        """Why today's surface does not tell the place."""
        if not found.measured[0] or found.at_brim[0]:
            return note("carried.unmeasured")
        if fit.share < _LEAST_SHARE:
            return note("carried.little", share=fit.share)
        off_mm = abs(float(found.signed_mm[0]))
        if off_mm > max(_MOST_OFF * self.size_mm, 4 * fit.rms_mm):
            return note("carried.apart", off_mm=off_mm)
        if fit.rms_mm > _MOST_RMS * self.size_mm:
            return note("carried.changed", rms_mm=fit.rms_mm)
        if carrying_mm > _MOST_SIGMA * self.size_mm:
            return note("carried.loose", sigma_mm=carrying_mm)
        return None

    def _fitted(self, start: _Fit, part: _Part, own: Float64[np.ndarray, "7 7"]) -> _Fit:
        """A part laid on today's surface, from where a larger one lies (Gauss-Newton)."""
        reach_mm = part.reach * self.size_mm
        arms = self.samples_mm - start.mark_mm
        away = np.linalg.norm(arms, axis=1) / reach_mm
        arms, away = arms[away < 1], away[away < 1]
        thin = max(len(arms) // _PLACES, 1)
        arms, bell = arms[::thin], (1 - away[::thin] ** 2) ** 2
        prior = start.covariance + own
        held = np.linalg.inv(prior)
        fit = replace(start, motion=np.zeros(7), prior=prior, covariance=prior)
        for _ in range(_MOST_ROUNDS):
            placed = fit.placed(arms)
            found = self.ground.counterparts(placed)
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
            if np.abs(step[3:6]).max() < _STILL_MM:
                break
        return fit


def _scales_of(fits: Sequence[_Fit], reach_mm: float) -> Float64[np.ndarray, "n 7"]:
    """How much more or less each part moved than assumed: by turn, shift and growth.

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
    near = np.exp(-((apart / (_NEAR * reach_mm)) ** 2))
    for group in (slice(0, 3), slice(3, 6), slice(6, 7)):
        own_moved, own_told = moved[:, group].sum(1), told[:, group].sum(1)
        if own_told.sum() < _LEAST_TOLD:
            continue
        whole = own_moved.sum() / own_told.sum()
        share = _OF_ALL * own_told.mean()
        local = (near @ own_moved + share * whole) / (near @ own_told + share)
        scales[:, group] = np.clip(np.sqrt(local), *_SCALES)[:, None]
    return scales


def _with_prior(fit: _Fit, start: _Fit, prior: Float64[np.ndarray, "7 7"]) -> _Fit:
    """The same part held by another prior; the surface is taken to answer evenly."""
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
    """Tukey's within the part, nothing where there is no counterpart."""
    valid: Bool[np.ndarray, " n"] = ~found.at_brim & found.measured
    if not valid.any():
        return np.zeros(len(bell))
    off_mm = np.abs(found.signed_mm)
    scale_mm = max(MAD_TO_SIGMA * float(np.median(off_mm[valid])), _LEAST_RMS_MM)
    return np.where(valid, bell * tukey(off_mm, scale_mm), 0)


def _along(covariance: Float64[np.ndarray, "3 3"], normal: Vector3) -> float:
    """Standard deviation in each direction along the surface, the mean of both."""
    flat = np.eye(3) - np.outer(normal, normal)
    return float(np.sqrt(np.trace(flat @ covariance @ flat) / 2))
