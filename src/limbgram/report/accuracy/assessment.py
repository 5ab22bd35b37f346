"""The assessment: everything that a finished case says about its own accuracy.

In      Evidence, and the truth where there is one.
Out     an Assessment; `tree` is what accuracy.json holds (ACCURACY_SCHEMA). What a key means, and
        its unit, is in the glossary.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

from limbgram.capture.setup import SetupCited
from limbgram.core.notebook import brief
from limbgram.core.typed import tree_of
from limbgram.findings import Finding
from limbgram.report.accuracy.capture import image_figures, length_figures, movement_figures
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.figures import Figures
from limbgram.report.accuracy.glossary import glossary_tree
from limbgram.report.accuracy.judgement import (
    Criterion,
    criteria,
    expectation,
    headline,
    reasons,
    size_is_checked,
    worst,
)
from limbgram.report.accuracy.limits import findings
from limbgram.report.accuracy.network import (
    camera_figures,
    network_figures,
    pose_figures,
    residual_figures,
)
from limbgram.report.accuracy.selfcalibration import SelfCalibration, self_calibration
from limbgram.report.accuracy.surface import surface_figures
from limbgram.report.accuracy.truth import KnownTruth, truth_figures
from limbgram.report.intended_use import OF_SCANS
from limbgram.report.verdict_light import Light

ACCURACY_SCHEMA = "limbgram-accuracy/2"
READ_SCHEMAS = ("limbgram-accuracy/1", ACCURACY_SCHEMA)
"""The first had sentences in the place of findings."""


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """What a case says of its own error, or what a comparison with a truth said."""

    case: str
    unit: str
    """What a length is called: mm, or scene units."""
    light: Light
    headline: Finding
    size_checked: bool
    """Whether a length that owes nothing to what set the scale confirms the size."""
    reasons: tuple[Finding, ...]
    """Everything that is not green, the gravest first."""
    criteria: tuple[Criterion, ...]
    findings: tuple[Finding, ...]
    figures: Figures
    self_calibration: SelfCalibration | None = None
    """What missing camera files cost."""
    setups: tuple[SetupCited, ...] = ()
    """Acceptance tests of the kit."""
    off_mm: Float64[np.ndarray, " n"] | None = None
    """Each vertex's signed distance from the truth; NaN where it has none. None without truth."""

    __repr__ = brief

    @cached_property
    def tree(self) -> dict[str, Any]:
        """What accuracy.json holds."""
        return {
            "schema": ACCURACY_SCHEMA,
            "case": self.case,
            "unit": self.unit,
            "light": self.light,
            "headline": tree_of(self.headline),
            "size_checked": self.size_checked,
            "reasons": tree_of(self.reasons),
            "intended_use": OF_SCANS,
            "criteria": tree_of(self.criteria),
            "findings": tree_of(self.findings),
            "self_calibration": tree_of(self.self_calibration),
            "setups": tree_of(self.setups),
            **tree_of(self.figures),
            "glossary": glossary_tree(),
        }


def assess(evidence: Evidence, known: KnownTruth | None = None) -> Assessment:
    """Assess a case."""
    scene = evidence.metric.scene
    lengths, network = length_figures(evidence), network_figures(scene)
    surface, images = surface_figures(evidence), image_figures(evidence)
    movement = movement_figures(evidence)
    compared = None if known is None else truth_figures(evidence.mesh, known, images.pixel)
    figures = Figures(
        residuals=residual_figures(scene),
        network=network,
        lengths=lengths,
        cameras=camera_figures(evidence),
        poses=pose_figures(scene),
        surface=surface,
        images=images,
        movement=movement,
        truth=None if compared is None else compared.figures,
        expected=expectation(surface, lengths, network, movement),
    )
    uncalibrated = self_calibration(figures.cameras, figures.expected, evidence.unit)
    # a setup was proved with its camera file: without that it says nothing of the case
    unused = any(lens.contradicted is not None for lens in figures.cameras)
    setups = () if unused else evidence.setups
    judged = criteria(figures, setups, uncalibrated)
    return Assessment(
        case=evidence.name,
        unit=evidence.unit,
        light=worst(judged),
        headline=headline(figures, judged),
        size_checked=size_is_checked(figures),
        reasons=tuple(one.finding for one in reasons(judged)),
        criteria=judged,
        findings=findings(figures, setups, uncalibrated),
        figures=figures,
        self_calibration=uncalibrated,
        setups=setups,
        off_mm=None if compared is None else compared.off_mm,
    )
