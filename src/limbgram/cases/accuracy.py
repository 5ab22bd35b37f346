"""Accuracy: the accuracy report of a case, written while its products are still in memory.

Apart from `case_assessment`, which reads finished cases and needs twice as many programs for it.
"""

from collections.abc import Sequence

from limbgram.capture.setup import SetupCited
from limbgram.cases.case_record import write_json
from limbgram.cases.encoding import sealed
from limbgram.cases.folder import CaseFolder
from limbgram.core.files import written_whole
from limbgram.reconstruction.pipeline import Reconstruction
from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.accuracy.layout import accuracy_report
from limbgram.report.drawings.drawing import Picture
from limbgram.report.html import html_of


def evidence_of(done: Reconstruction, setups: tuple[SetupCited, ...] = ()) -> Evidence:
    """The products of a case as evidence of its accuracy."""
    return Evidence(
        photos=done.photos,
        cameras=done.cameras,
        detections=done.detections,
        metric=done.metric,
        mesh=done.mesh,
        tapes=done.tapes,
        setups=setups,
    )


def write_accuracy(
    case: CaseFolder, assessment: Assessment, pictures: Sequence[Picture] = ()
) -> None:
    """Write CASE/accuracy.json, or accuracy-truth.json, and the page that shows it."""
    against_truth = assessment.figures.truth is not None
    write_json(case.accuracy("json", against_truth=against_truth), sealed(assessment.tree))
    with written_whole(case.accuracy("html", against_truth=against_truth)) as beside:
        beside.write_text(html_of(accuracy_report(assessment, pictures)), encoding="utf-8")
