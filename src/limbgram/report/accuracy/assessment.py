"""The assessment: everything that a finished case says about its own accuracy, as one JSON tree.

In      Evidence, and the truth where there is one.
Out     a tree (ACCURACY_SCHEMA); lengths in mm, or in scene units where nothing gives the scale
        (`unit`). What a key means, and its unit, is in the glossary.
"""

from dataclasses import asdict, dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.report.accuracy.evidence import Evidence, Json
from limbgram.report.accuracy.figures import (
    camera_figures,
    image_figures,
    length_figures,
    network_figures,
    pose_figures,
    residual_figures,
    surface_figures,
)
from limbgram.report.accuracy.glossary import glossary_tree
from limbgram.report.accuracy.judgement import criteria, expectation, headline, reasons, worst
from limbgram.report.accuracy.limits import findings
from limbgram.report.accuracy.truth import Alignment, truth_figures
from limbgram.report.alignment import Truth
from limbgram.report.document.page import ACCURACY_SCHEMA, finite
from limbgram.report.summary import INTENDED_USE


@dataclass(frozen=True, kw_only=True)
class KnownTruth:
    """The true surface, what it is, and how ours is laid onto it."""

    kind: str
    """Such as "a mesh file": its name may be a patient's."""
    truth: Truth
    centres_mm: Points3
    """Our camera centres, in the order of the truth's; none where it has none."""
    alignment: Alignment = "surface"


@dataclass(frozen=True)
class Assessment:
    """The tree, and what only the pictures need."""

    tree: Json
    off_mm: Float64[np.ndarray, " n"] | None
    """Each vertex's signed distance from the truth; NaN where it has none. None without truth."""


def assess(evidence: Evidence, known: KnownTruth | None = None) -> Assessment:
    """Assess a case; NaN becomes None."""
    compared = None
    if known is not None:
        compared = truth_figures(evidence.mesh, known.centres_mm, known.truth, known.alignment)
    figures: Json = {
        "residuals": residual_figures(evidence.metric.scene),
        "network": network_figures(evidence.metric.scene),
        "lengths": length_figures(evidence),
        "cameras": camera_figures(evidence),
        "poses": pose_figures(evidence.metric.scene),
        "surface": surface_figures(evidence),
        "images": image_figures(evidence),
        "truth": None,
    }
    if known is not None and compared is not None:
        in_pixels = compared.figures["rms_mm"] / figures["images"]["pixel"]
        figures["truth"] = {"kind": known.kind, "rms_px": in_pixels, **compared.figures}
    figures["expected"] = expectation(figures)
    judged = criteria(figures)
    tree: Json = {
        "schema": ACCURACY_SCHEMA,
        "case": evidence.name,
        "unit": evidence.unit,
        "light": worst(judged),
        "headline": headline(figures, judged),
        "reasons": [one.sentence for one in reasons(judged)],
        "intended_use": INTENDED_USE,
        "criteria": [asdict(one) for one in judged],
        "findings": [asdict(one) for one in findings(figures)],
        **figures,
        "glossary": glossary_tree(),
    }
    return Assessment(finite(tree), None if compared is None else compared.off_mm)
