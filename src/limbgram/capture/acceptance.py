"""Acceptance: whether a kit measures an artefact as truly as its user wants it to.

In      an Artefact, what one capture or several made of it, and the permissible errors.
Out     an Acceptance: every test value with its decision, what could not be measured, bias, spread
        and largest error, and pass, fail or cannot tell.
Method  in the manner of VDI/VDE 2634 Part 3 and ISO 10360-13, on the delivered surface: the size
        error of a Gaussian sphere or cylinder, its form (95 % of the points, and all), the error of
        the distance between two spheres and of lengths between coded marks, the distance from a
        calibrated mesh that the surface is laid on rigidly. A scale is nowhere fitted.
        Decision by ISO 14253-1, for a value E with permissible error M and the artefact's expanded
        uncertainty U: pass where |E| + U <= M, fail where |E| - U > M, and between them nobody can
        tell. The test is passed if every value passes, and failed if one fails.
        Unlike the standards' own procedures, as many positions are tested as captures are given,
        and the points are the vertices of the surface that photos measured.
Fails   OptionsError: no permissible error is for anything on the artefact. MeasureError: nothing
        of it was measured in any capture.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.capture.artefact import Artefact, LengthStandard
from limbgram.capture.permissible import KINDS, Kind, Limits
from limbgram.capture.probing import Probed, Surface, find_cylinder, find_spheres
from limbgram.core.errors import LimbgramError, MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.planted import signed_on
from limbgram.core.run import track
from limbgram.workbench.compare.comparison import lay
from limbgram.workbench.compare.frames import axes_of
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.limb import Limb

Outcome = Literal["pass", "fail", "cannot tell"]
_SPACING_SHARE = 0.05
"""Two spheres whose distance is farther from the calibrated one are not this pair."""
_MISSING_COST = 10.0
_LEAST_REACHED = 0.5
"""Of a calibrated mesh's area: it stands on something and its underside may be part of the mesh,
but a scrap of it proves no kit."""
_NEAR_MM = 3.0
"""A calibrated place with a measured vertex so near was reached; no limit permits so much."""
_ALIKE = 0.02
"""Diameters so near to each other are searched once."""


@dataclass(frozen=True, kw_only=True)
class MeasuredCapture:
    """What one capture made of the artefact."""

    name: str
    id: str
    """First digits of the hash of its photos."""
    photos: int
    light: str
    """Of its own verdict."""
    scale: str
    """What set its size, in words."""
    meshes: tuple[Mesh, ...]
    """Every body of the surface, the meant one first."""
    surface: Surface
    marks_mm: Mapping[int, Vector3] = field(default_factory=dict[int, Vector3])
    """Middles of the coded marks."""
    gave_scale: tuple[frozenset[int], ...] = ()
    """Pairs of marks whose lengths set the scale and so test nothing."""


@dataclass(frozen=True, kw_only=True)
class MeasuredError:
    """One error, and what is decided on it."""

    capture: str
    kind: Kind
    name: str
    calibrated_mm: float
    measured_mm: float
    error_mm: float
    uncertainty_mm: float
    """Of the artefact, expanded (k = 2)."""
    permissible_mm: float | None
    outcome: Outcome | None
    """None where no permissible error was declared."""


@dataclass(frozen=True, kw_only=True)
class Body:
    """A sphere or cylinder as it was found."""

    capture: str
    name: str
    points: int
    seen: float
    """Share of the sphere, of the way round the cylinder, or of the mesh's area."""
    off_rms_mm: float
    """Of its points from the associated body."""


@dataclass(frozen=True, kw_only=True)
class NotMeasured:
    """What a capture does not show, and why."""

    capture: str
    name: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class Spread:
    """All errors of one kind together."""

    kind: Kind
    count: int
    bias_mm: float
    """Their mean."""
    spread_mm: float | None
    """Their standard deviation; None of one error."""
    worst_mm: float
    """The largest, with its sign."""
    bias_share: float | None
    """Mean of the errors as parts of the calibrated lengths: an error of scale. None for forms."""


@dataclass(frozen=True, kw_only=True)
class Permitted:
    """What the user declared for one kind of error."""

    kind: Kind
    words: str
    base_mm: float
    per_mm: float
    """So much more for each millimetre of length."""


@dataclass(frozen=True, kw_only=True)
class Acceptance:
    """The whole test."""

    outcome: Outcome
    headline: str
    values: tuple[MeasuredError, ...]
    spreads: tuple[Spread, ...]
    bodies: tuple[Body, ...]
    not_measured: tuple[NotMeasured, ...]
    permitted: tuple[Permitted, ...]


def accept(
    artefact: Artefact,
    captures: Sequence[MeasuredCapture],
    limits: Limits,
    calibrated: Mesh | None = None,
) -> Acceptance:
    """Test a kit.

    Args:
        calibrated: The mesh of the artefact, where it has one.

    Raises:
        OptionsError: no permissible error is for anything on the artefact.
        MeasureError: nothing of the artefact was measured.
    """
    _require_use(artefact, limits)
    values: list[MeasuredError] = []
    bodies: list[Body] = []
    missing: list[NotMeasured] = []
    for capture in track(captures):
        tested = _Tested(capture=capture, limits=limits)
        tested.spheres(artefact)
        tested.cylinder(artefact)
        tested.marks(artefact)
        if calibrated is not None:
            tested.mesh(artefact, calibrated)
        values += tested.values
        bodies += tested.bodies
        missing += tested.missing
    if not values:
        told = " ".join(f"{one.name} in {one.capture}: {one.reason}." for one in missing[:3])
        raise MeasureError(
            f"Nothing of {artefact.name} was measured. {told} See that the artefact is painted "
            "with fine spots and seen from all sides, and that its file has its true sizes in mm."
        )
    outcome = _whole(values, missing)
    return Acceptance(
        outcome=outcome,
        headline=_headline(outcome, values, missing),
        values=tuple(values),
        spreads=tuple(_spreads(values)),
        bodies=tuple(bodies),
        not_measured=tuple(missing),
        permitted=tuple(
            Permitted(kind=kind, words=str(one), base_mm=one.base_mm, per_mm=1 / one.per)
            for kind, one in limits.items()
        ),
    )


def decide(error_mm: float, uncertainty_mm: float, permissible_mm: float) -> Outcome:
    """By ISO 14253-1; the artefact's uncertainty is on neither side."""
    if abs(error_mm) + uncertainty_mm <= permissible_mm:
        return "pass"
    return "fail" if abs(error_mm) - uncertainty_mm > permissible_mm else "cannot tell"


def assign(artefact: Artefact, found: Mapping[str, Sequence[Probed]]) -> dict[str, Probed]:
    """Which of the spheres that were found is which on the artefact: by their distances.

    Args:
        found: Candidates by the name of the standard.
    """
    names = [one.name for one in artefact.spheres]
    best: tuple[float, dict[str, Probed]] = (math.inf, {})

    def extend(chosen: dict[str, Probed], taken: list[int], cost: float, depth: int) -> None:
        nonlocal best
        if cost >= best[0]:
            return
        if depth == len(names):
            best = (cost, dict(chosen))
            return
        name = names[depth]
        for one in found[name]:
            if id(one) in taken:
                continue
            added = _spacing_cost(artefact.spacings, {**chosen, name: one}, name)
            if added is not None:
                extend({**chosen, name: one}, [*taken, id(one)], cost + added, depth + 1)
        extend(chosen, taken, cost + _MISSING_COST, depth + 1)

    extend({}, [], 0.0, 0)
    return best[1]


def _spacing_cost(
    spacings: Sequence[LengthStandard], chosen: Mapping[str, Probed], latest: str
) -> float | None:
    """How badly the distances to one sphere fit, with less for what is better seen; None: not."""
    cost = 0.01 * (1 - chosen[latest].seen)
    for one in spacings:
        if latest not in (one.first, one.second) or not {one.first, one.second} <= chosen.keys():
            continue
        off = abs(_apart_mm(chosen[one.first], chosen[one.second]) / one.length_mm - 1)
        if off > _SPACING_SHARE:
            return None
        cost += off
    return cost


def _apart_mm(one: Probed, other: Probed) -> float:
    return float(np.linalg.norm(one.middle_mm - other.middle_mm))


@dataclass
class _Tested:
    """One capture while it is tested."""

    capture: MeasuredCapture
    limits: Limits
    values: list[MeasuredError] = field(default_factory=list[MeasuredError])
    bodies: list[Body] = field(default_factory=list[Body])
    missing: list[NotMeasured] = field(default_factory=list[NotMeasured])

    def spheres(self, artefact: Artefact) -> None:
        """Size, form and distances of the spheres."""
        if not artefact.spheres:
            return
        searched: dict[float, tuple[Probed, ...]] = {}
        found: dict[str, Sequence[Probed]] = {}
        for one in artefact.spheres:
            near = [mm for mm in searched if abs(mm / one.diameter_mm - 1) < _ALIKE]
            size = near[0] if near else one.diameter_mm
            if size not in searched:
                searched[size] = find_spheres(self.capture.surface, size)
            found[one.name] = searched[size]
        chosen = assign(artefact, found)
        for one in artefact.spheres:
            probed = chosen.get(one.name)
            if probed is None:
                self._miss(f"sphere {one.name}", "no such sphere is in the surface")
                continue
            self._round(one.name, probed, one.diameter_mm, one.uncertainty_mm, one.form_mm)
        for spacing in artefact.spacings:
            ends = [chosen.get(spacing.first), chosen.get(spacing.second)]
            if ends[0] is None or ends[1] is None:
                self._miss(spacing.name, "one of its spheres was not found")
                continue
            self._length("spacing", spacing, _apart_mm(ends[0], ends[1]))

    def cylinder(self, artefact: Artefact) -> None:
        one = artefact.cylinder
        if one is None:
            return
        probed = find_cylinder(self.capture.surface, one.diameter_mm)
        if probed is None:
            self._miss(f"cylinder {one.name}", "no such cylinder is in the surface")
            return
        self._round(one.name, probed, one.diameter_mm, one.uncertainty_mm, one.form_mm)

    def marks(self, artefact: Artefact) -> None:
        """Lengths between coded marks."""
        for one in artefact.between_marks:
            ids = one.mark_ids
            if ids is None:
                continue
            if frozenset(ids) in self.capture.gave_scale:
                self._miss(one.name, "this very length set the scale, so it cannot test it")
                continue
            lost = [number for number in ids if number not in self.capture.marks_mm]
            if lost:
                self._miss(one.name, f"mark {lost[0]} was found in fewer than two placed photos")
                continue
            first, second = (self.capture.marks_mm[number] for number in ids)
            self._length("length", one, float(np.linalg.norm(first - second)))

    def mesh(self, artefact: Artefact, calibrated: Mesh) -> None:
        """Distances from the calibrated mesh, after a rigid alignment."""
        standard = artefact.mesh
        if standard is None:
            return
        try:
            off_mm, reached = held_against(self.capture.meshes[0], calibrated)
        except LimbgramError as error:
            self._miss(standard.name, f"the surface could not be laid on it: {error}")
            return
        if reached < _LEAST_REACHED:
            self._miss(
                standard.name,
                f"the surface shows {reached:.0%} of it; {_LEAST_REACHED:.0%} are needed",
            )
            return
        p95 = float(np.quantile(np.abs(off_mm), 0.95))
        self._add("surface", standard.name, 0.0, p95, p95, standard.uncertainty_mm, 0.0)
        self.bodies.append(
            Body(
                capture=self.capture.name,
                name=standard.name,
                points=len(off_mm),
                seen=reached,
                off_rms_mm=float(np.sqrt(np.mean(off_mm**2))),
            )
        )

    def _round(
        self, name: str, probed: Probed, diameter_mm: float, uncertainty_mm: float, form_mm: float
    ) -> None:
        error_mm = probed.diameter_mm - diameter_mm
        measured = probed.diameter_mm
        self._add("size", name, diameter_mm, measured, error_mm, uncertainty_mm, diameter_mm)
        within, whole = probed.form_95_mm, probed.form_mm
        self._add("form", name, 0.0, within, within, form_mm, 0.0)
        self._add("form-all", name, 0.0, whole, whole, form_mm, 0.0)
        self.bodies.append(
            Body(
                capture=self.capture.name,
                name=name,
                points=probed.points,
                seen=probed.seen,
                off_rms_mm=float(np.sqrt(np.mean(probed.off_mm**2))),
            )
        )

    def _length(
        self, kind: Literal["spacing", "length"], standard: LengthStandard, measured_mm: float
    ) -> None:
        known = standard.length_mm
        error_mm = measured_mm - known
        self._add(kind, standard.name, known, measured_mm, error_mm, standard.uncertainty_mm, known)

    def _add(
        self,
        kind: Kind,
        name: str,
        calibrated_mm: float,
        measured_mm: float,
        error_mm: float,
        uncertainty_mm: float,
        length_mm: float,
    ) -> None:
        limit = self.limits.get(kind)
        permissible = None if limit is None else limit.at(length_mm)
        self.values.append(
            MeasuredError(
                capture=self.capture.name,
                kind=kind,
                name=name,
                calibrated_mm=calibrated_mm,
                measured_mm=measured_mm,
                error_mm=error_mm,
                uncertainty_mm=uncertainty_mm,
                permissible_mm=permissible,
                outcome=None
                if permissible is None
                else decide(error_mm, uncertainty_mm, permissible),
            )
        )

    def _miss(self, name: str, reason: str) -> None:
        self.missing.append(NotMeasured(capture=self.capture.name, name=name, reason=reason))


def held_against(mesh: Mesh, calibrated: Mesh) -> tuple[Float64[np.ndarray, " n"], float]:
    """A measured surface laid rigidly on a calibrated mesh.

    Returns:
        Signed distances of the measured vertices in mm, and the share of the calibrated mesh's area
        that has a measured vertex near it.

    Raises:
        MeasureError: the shapes cannot be laid on each other.
    """
    truth, ours = Limb(mesh=calibrated, name="artefact"), Limb(mesh=mesh, name="surface")
    alignment = lay(truth, ours, axes_of(truth), RegistrationOptions(way="icp"))
    measured = np.ones(len(mesh), bool) if mesh.filled is None else ~mesh.filled
    points: Points3 = alignment.first_from_second.apply(mesh.vertices_mm[measured])
    gaps_mm = KDTree(points).query(calibrated.vertices_mm)[0]
    areas_mm2 = calibrated.vertex_areas_mm2()
    reached = float(areas_mm2[gaps_mm < _NEAR_MM].sum() / areas_mm2.sum())
    return signed_on(calibrated).signed(points).signed_mm, reached


def _require_use(artefact: Artefact, limits: Limits) -> None:
    kinds: set[Kind] = set()
    if artefact.spheres or artefact.cylinder:
        kinds |= {"form", "form-all", "size"}
    if artefact.spacings:
        kinds.add("spacing")
    if artefact.between_marks:
        kinds.add("length")
    if artefact.mesh is not None:
        kinds.add("surface")
    if not kinds & limits.keys():
        raise OptionsError(
            f"The permissible errors are for {', '.join(limits)}, and {artefact.name} can test "
            f"{', '.join(sorted(kinds))}. Give one of these by --mpe."
        )


def _whole(values: Sequence[MeasuredError], missing: Sequence[NotMeasured]) -> Outcome:
    outcomes = {one.outcome for one in values}
    if "fail" in outcomes:
        return "fail"
    return "cannot tell" if missing or "cannot tell" in outcomes else "pass"


def _headline(
    outcome: Outcome, values: Sequence[MeasuredError], missing: Sequence[NotMeasured]
) -> str:
    judged = [one for one in values if one.outcome is not None]
    match outcome:
        case "pass":
            worst = max(judged, key=lambda one: abs(one.error_mm) / (one.permissible_mm or 1.0))
            return (
                f"PASS: all {len(judged)} errors lie within what is permitted, with the artefact's "
                f"uncertainty counted. The nearest to its limit: {_sentence(worst)}."
            )
        case "fail":
            failed = [one for one in judged if one.outcome == "fail"]
            worst = max(failed, key=lambda one: abs(one.error_mm) / (one.permissible_mm or 1.0))
            return f"FAIL: {len(failed)} of {len(judged)} errors are too large. {_sentence(worst)}."
        case "cannot tell":
            open_ones = [one for one in judged if one.outcome == "cannot tell"]
            reasons = [f"{one.name} in {one.capture}: {one.reason}" for one in missing]
            reasons += [
                f"{_sentence(one)}, nearer to the limit than the artefact is known "
                f"({one.uncertainty_mm:.3g} mm)"
                for one in open_ones
            ]
            more = f" And {len(reasons) - 1} more." if len(reasons) > 1 else ""
            return f"CANNOT TELL: {reasons[0]}.{more}"


def _sentence(one: MeasuredError) -> str:
    sign = "" if one.kind in ("form", "form-all", "surface") else "+"
    return (
        f"{KINDS[one.kind]} of {one.name} in {one.capture} is {one.error_mm:{sign}.3f} mm, "
        f"{one.permissible_mm:.3f} mm are permitted"
    )


def _spreads(values: Sequence[MeasuredError]) -> Iterator[Spread]:
    for kind in KINDS:
        errors = [one for one in values if one.kind == kind]
        if not errors:
            continue
        off = np.array([one.error_mm for one in errors])
        known = np.array([one.calibrated_mm for one in errors])
        yield Spread(
            kind=kind,
            count=len(off),
            bias_mm=float(off.mean()),
            spread_mm=float(off.std(ddof=1)) if len(off) > 1 else None,
            worst_mm=float(off[np.argmax(np.abs(off))]),
            bias_share=float((off / known).mean()) if (known > 0).all() else None,
        )
