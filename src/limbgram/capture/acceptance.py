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
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64
from scipy.spatial import KDTree

from limbgram.capture.artefact import Artefact, LengthStandard
from limbgram.capture.permissible_errors import KINDS, Kind, Limits
from limbgram.capture.probing import ProbedBody, Surface, find_cylinder, find_spheres
from limbgram.capture.setup import Outcome
from limbgram.core.errors import LimbgramError, MeasureError, OptionsError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.interval import rms
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import signed_on
from limbgram.core.run import track
from limbgram.findings import Finding, Gravity, note
from limbgram.workbench.compare.comparison import align_shapes
from limbgram.workbench.compare.frames import axes_of
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.limb import Limb

_GRAVITIES: dict[Outcome, Gravity] = {
    "pass": Gravity.NOTE,
    "cannot tell": Gravity.DOUBT,
    "fail": Gravity.FAULT,
}
_SPACING_SHARE = 0.05
"""Two spheres whose distance is farther from the calibrated one are not this pair."""
_MISSING_COST = 10.0
_LEAST_REACHED = 0.5
"""Of a calibrated mesh's area: it stands on something and its underside may be part of the mesh,
but a scrap of it proves no kit."""
_NEAR_MM = 3.0
"""A calibrated place with a measured vertex so near was reached; no limit permits so much."""
_SPACING_AGREES = 0.02
"""Diameters so near to each other are searched once."""


@dataclass(frozen=True, kw_only=True)
class MeasuredCapture:
    """One capture of the artefact, as it was measured."""

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
    """One measured error, and the decision on it."""

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
    """A feature that a capture does not show, and the reason."""

    capture: str
    name: str
    reason: Finding


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Statistics of all errors of one kind."""

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
    """The permissible error that the user declared for one kind."""

    kind: Kind
    words: str
    base_mm: float
    per_mm: float
    """So much more for each millimetre of length."""


@dataclass(frozen=True, kw_only=True)
class Acceptance:
    """The result of an acceptance test."""

    outcome: Outcome
    headline: Finding
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
    """Test a kit on an artefact.

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
        tested = _CaptureTest(capture=capture, limits=limits)
        tested.spheres(artefact)
        tested.cylinder(artefact)
        tested.marks(artefact)
        if calibrated is not None:
            tested.mesh(artefact, calibrated)
        values += tested.values
        bodies += tested.bodies
        missing += tested.missing
    if not values:
        raise MeasureError(
            "kit.nothing_measured",
            artefact=artefact.name,
            missing=tuple(map(_not_measured_finding, missing[:3])),
        )
    outcome = _overall_outcome(values, missing)
    return Acceptance(
        outcome=outcome,
        headline=_headline(outcome, values, missing),
        values=tuple(values),
        spreads=tuple(_spreads_by_kind(values)),
        bodies=tuple(bodies),
        not_measured=tuple(missing),
        permitted=tuple(
            Permitted(kind=kind, words=str(one), base_mm=one.base_mm, per_mm=1 / one.per)
            for kind, one in limits.items()
        ),
    )


def decide(error_mm: float, uncertainty_mm: float, permissible_mm: float) -> Outcome:
    """The decision by ISO 14253-1; the artefact's uncertainty counts for neither side."""
    if abs(error_mm) + uncertainty_mm <= permissible_mm:
        return "pass"
    return "fail" if abs(error_mm) - uncertainty_mm > permissible_mm else "cannot tell"


def assign(artefact: Artefact, found: Mapping[str, Sequence[ProbedBody]]) -> dict[str, ProbedBody]:
    """Identify the spheres that were found with those of the artefact, by their distances.

    Args:
        found: Candidates by the name of the standard.
    """
    names = [one.name for one in artefact.spheres]
    best: tuple[float, dict[str, ProbedBody]] = (math.inf, {})

    def extend(chosen: dict[str, ProbedBody], taken: list[int], cost: float, depth: int) -> None:
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
    spacings: Sequence[LengthStandard], chosen: Mapping[str, ProbedBody], latest: str
) -> float | None:
    """Cost of the distances to one sphere, less for well-seen ones; None if they do not fit."""
    cost = 0.01 * (1 - chosen[latest].seen)
    for one in spacings:
        if latest not in (one.first, one.second) or not {one.first, one.second} <= chosen.keys():
            continue
        off = abs(_distance_mm(chosen[one.first], chosen[one.second]) / one.length_mm - 1)
        if off > _SPACING_SHARE:
            return None
        cost += off
    return cost


def _distance_mm(one: ProbedBody, other: ProbedBody) -> float:
    return float(np.linalg.norm(one.middle_mm - other.middle_mm))


@dataclass
class _CaptureTest:
    """The test of one capture, while errors are collected."""

    capture: MeasuredCapture
    limits: Limits
    values: list[MeasuredError] = field(default_factory=list[MeasuredError])
    bodies: list[Body] = field(default_factory=list[Body])
    missing: list[NotMeasured] = field(default_factory=list[NotMeasured])

    def spheres(self, artefact: Artefact) -> None:
        """Test size, form and distances of the spheres."""
        if not artefact.spheres:
            return
        searched: dict[float, tuple[ProbedBody, ...]] = {}
        found: dict[str, Sequence[ProbedBody]] = {}
        for one in artefact.spheres:
            near = [mm for mm in searched if abs(mm / one.diameter_mm - 1) < _SPACING_AGREES]
            size = near[0] if near else one.diameter_mm
            if size not in searched:
                searched[size] = find_spheres(self.capture.surface, size)
            found[one.name] = searched[size]
        chosen = assign(artefact, found)
        for one in artefact.spheres:
            probed = chosen.get(one.name)
            if probed is None:
                self._add_missing(f"sphere {one.name}", note("kit.missing.sphere"))
                continue
            self._add_round_body(one.name, probed, one.diameter_mm, one.uncertainty_mm, one.form_mm)
        for spacing in artefact.spacings:
            ends = [chosen.get(spacing.first), chosen.get(spacing.second)]
            if ends[0] is None or ends[1] is None:
                self._add_missing(spacing.name, note("kit.missing.end"))
                continue
            self._add_length("spacing", spacing, _distance_mm(ends[0], ends[1]))

    def cylinder(self, artefact: Artefact) -> None:
        one = artefact.cylinder
        if one is None:
            return
        probed = find_cylinder(self.capture.surface, one.diameter_mm)
        if probed is None:
            self._add_missing(f"cylinder {one.name}", note("kit.missing.cylinder"))
            return
        self._add_round_body(one.name, probed, one.diameter_mm, one.uncertainty_mm, one.form_mm)

    def marks(self, artefact: Artefact) -> None:
        """Test lengths between coded marks."""
        for one in artefact.between_marks:
            ids = one.mark_ids
            if ids is None:
                continue
            if frozenset(ids) in self.capture.gave_scale:
                self._add_missing(one.name, note("kit.missing.set_scale"))
                continue
            lost = [number for number in ids if number not in self.capture.marks_mm]
            if lost:
                self._add_missing(one.name, note("kit.missing.mark", mark=lost[0]))
                continue
            first, second = (self.capture.marks_mm[number] for number in ids)
            self._add_length("length", one, float(np.linalg.norm(first - second)))

    def mesh(self, artefact: Artefact, calibrated: Mesh) -> None:
        """Test distances from the calibrated mesh, after a rigid alignment."""
        standard = artefact.mesh
        if standard is None:
            return
        try:
            off_mm, reached = align_with_calibrated(self.capture.meshes[0], calibrated)
        except LimbgramError as error:
            self._add_missing(standard.name, note("kit.missing.not_laid", reason=error.finding))
            return
        if reached < _LEAST_REACHED:
            self._add_missing(
                standard.name,
                note("kit.missing.scrap", shown_share=reached, needed_share=_LEAST_REACHED),
            )
            return
        p95 = float(np.quantile(np.abs(off_mm), 0.95))
        self._add_error("surface", standard.name, 0.0, p95, p95, standard.uncertainty_mm, 0.0)
        self.bodies.append(
            Body(
                capture=self.capture.name,
                name=standard.name,
                points=len(off_mm),
                seen=reached,
                off_rms_mm=rms(off_mm),
            )
        )

    def _add_round_body(
        self,
        name: str,
        probed: ProbedBody,
        diameter_mm: float,
        uncertainty_mm: float,
        form_mm: float,
    ) -> None:
        error_mm = probed.diameter_mm - diameter_mm
        measured = probed.diameter_mm
        self._add_error("size", name, diameter_mm, measured, error_mm, uncertainty_mm, diameter_mm)
        within, whole = probed.form_95_mm, probed.form_mm
        self._add_error("form", name, 0.0, within, within, form_mm, 0.0)
        self._add_error("form-all", name, 0.0, whole, whole, form_mm, 0.0)
        self.bodies.append(
            Body(
                capture=self.capture.name,
                name=name,
                points=probed.points,
                seen=probed.seen,
                off_rms_mm=rms(probed.off_mm),
            )
        )

    def _add_length(
        self, kind: Literal["spacing", "length"], standard: LengthStandard, measured_mm: float
    ) -> None:
        known = standard.length_mm
        error_mm = measured_mm - known
        self._add_error(
            kind, standard.name, known, measured_mm, error_mm, standard.uncertainty_mm, known
        )

    def _add_error(
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

    def _add_missing(self, name: str, reason: Finding) -> None:
        self.missing.append(NotMeasured(capture=self.capture.name, name=name, reason=reason))


def align_with_calibrated(mesh: Mesh, calibrated: Mesh) -> tuple[Float64[np.ndarray, " n"], float]:
    """Align a measured surface rigidly with a calibrated mesh.

    Returns:
        Signed distances of the measured vertices in mm, and the share of the calibrated mesh's area
        that has a measured vertex near it.

    Raises:
        MeasureError: the shapes cannot be laid on each other.
    """
    truth, ours = Limb(mesh=calibrated, name="artefact"), Limb(mesh=mesh, name="surface")
    alignment = align_shapes(truth, ours, axes_of(truth), RegistrationOptions(way="icp"))
    measured = mesh.measured
    points: Points3 = alignment.first_from_second.apply(mesh.vertices_mm[measured])
    gaps_mm = KDTree(points).query(calibrated.vertices_mm)[0]
    areas_mm2 = calibrated.vertex_areas_mm2()
    reached = float(areas_mm2[gaps_mm < _NEAR_MM].sum() / areas_mm2.sum())
    return signed_on(calibrated).query(points).signed_mm, reached


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
            "kit.nothing_to_test",
            limits=tuple(limits),
            artefact=artefact.name,
            kinds=tuple(sorted(kinds)),
        )


def _overall_outcome(values: Sequence[MeasuredError], missing: Sequence[NotMeasured]) -> Outcome:
    outcomes = {one.outcome for one in values}
    if "fail" in outcomes:
        return "fail"
    return "cannot tell" if missing or "cannot tell" in outcomes else "pass"


def without_outcome(headline: Finding) -> Finding:
    """A headline without the name of its outcome, for where the outcome itself is shown.

    That of a file of an earlier version, which has no values, stays whole.
    """
    said = headline.values.get("answer")
    return said if isinstance(said, Finding) else headline


def _headline(
    outcome: Outcome, values: Sequence[MeasuredError], missing: Sequence[NotMeasured]
) -> Finding:
    answer = _answer_finding(outcome, values, missing)
    return replace(
        note("kit.headline", outcome=outcome, answer=answer), gravity=_GRAVITIES[outcome]
    )


def _answer_finding(
    outcome: Outcome, values: Sequence[MeasuredError], missing: Sequence[NotMeasured]
) -> Finding:
    judged = [one for one in values if one.outcome is not None]
    match outcome:
        case "pass":
            return note("kit.all_within", count=len(judged), worst=_error_finding(_worst(judged)))
        case "fail":
            failed = [one for one in judged if one.outcome == "fail"]
            return note(
                "kit.too_large",
                failed=len(failed),
                count=len(judged),
                worst=_error_finding(_worst(failed)),
            )
        case "cannot tell":
            reasons = [_not_measured_finding(one) for one in missing]
            reasons += [
                note("kit.near_limit", error=_error_finding(one), uncertainty_mm=one.uncertainty_mm)
                for one in judged
                if one.outcome == "cannot tell"
            ]
            return note("kit.open", first=reasons[0], more=len(reasons) - 1)


def _worst(judged: Sequence[MeasuredError]) -> MeasuredError:
    return max(judged, key=lambda one: abs(one.error_mm) / (one.permissible_mm or 1.0))


def _not_measured_finding(one: NotMeasured) -> Finding:
    return note("kit.not_measured", name=one.name, capture=one.capture, reason=one.reason)


def _error_finding(one: MeasuredError) -> Finding:
    return note(
        "kit.error",
        kind=one.kind,
        name=one.name,
        capture=one.capture,
        error_mm=one.error_mm,
        signed=one.kind not in ("form", "form-all", "surface"),
        permissible_mm=one.permissible_mm,
    )


def _spreads_by_kind(values: Sequence[MeasuredError]) -> Iterator[Spread]:
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
