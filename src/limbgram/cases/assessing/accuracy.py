"""Accuracy of a case: CASE/accuracy.json, accuracy.html and accuracy.pdf.

A comparison with a truth goes into accuracy-truth.* beside them: the case's own verdict stays what
others cite, whatever it was compared with.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from limbgram.cases.assessing.kept import kept_evidence
from limbgram.cases.assessing.truths import read_truth
from limbgram.cases.folder import CaseFolder, locked, written_whole
from limbgram.cases.keeping.seal import sealed
from limbgram.cases.record import write_json
from limbgram.pipeline import Reconstruction
from limbgram.report.accuracy import Assessment, Evidence, assess
from limbgram.report.accuracy.figures.truth import Alignment
from limbgram.report.accuracy.pages import accuracy_page, accuracy_pdf, accuracy_pictures
from limbgram.report.drawings.drawing import Picture


def assess_case(case: CaseFolder, truth: Path | None, alignment: Alignment) -> dict[str, Any]:
    """Assess a finished case from what it keeps, and write page, PDF and JSON into it.

    Beside a truth they have names of their own, and what the case says of itself stays.

    Raises:
        CaseError: it is no finished case, its products cannot be read, or the truth cannot.
    """
    evidence = kept_evidence(case)
    known = None if truth is None else read_truth(truth, evidence, alignment)
    assessment = assess(evidence, known)
    pictures = accuracy_pictures(evidence, assessment)
    with locked(case):
        write_accuracy(case, assessment, pictures)
        with written_whole(case.accuracy("pdf", against_truth=known is not None)) as half:
            half.write_bytes(accuracy_pdf(assessment.tree, pictures))
    return assessment.tree


def evidence_of(done: Reconstruction) -> Evidence:
    """The same evidence while the products are still at hand."""
    return Evidence(
        photos=done.photos,
        cameras=done.cameras,
        detections=done.detections,
        metric=done.metric,
        mesh=done.mesh,
        tapes=done.tapes,
    )


def write_accuracy(
    case: CaseFolder, assessment: Assessment, pictures: Sequence[Picture] = ()
) -> None:
    """Write CASE/accuracy.json, or accuracy-truth.json, and the page that shows it."""
    against_truth = assessment.tree["truth"] is not None
    write_json(case.accuracy("json", against_truth=against_truth), sealed(assessment.tree))
    with written_whole(case.accuracy("html", against_truth=against_truth)) as half:
        half.write_text(accuracy_page(assessment.tree, pictures), encoding="utf-8")
