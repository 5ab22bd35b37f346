"""Job: runs one reconstruction, from a folder of photos to a finished case."""

import shutil
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from limbgram.cases.accuracy import evidence_of, write_accuracy
from limbgram.cases.case_record import write_json
from limbgram.cases.certificates import cited_setups, take_certificates_in
from limbgram.cases.deliverables import deliver
from limbgram.cases.folder import CaseFolder, take_in
from limbgram.cases.job_messages import Answer, Job
from limbgram.cases.stage_cache import CachingRun
from limbgram.core.errors import CaseError
from limbgram.core.files import written_whole
from limbgram.core.typed import tree_of
from limbgram.formats.camera import read_camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.photos.photo import naming_left_out
from limbgram.reconstruction.pipeline import Capture, Reconstruction, options_for, reconstruct
from limbgram.report.accuracy.assessment import assess
from limbgram.report.case import case_report
from limbgram.report.html import html_of
from limbgram.report.pictures import Pictures, draw
from limbgram.report.summary import Summary, Verdict, summarise
from limbgram.report.terminal_summary import profile_lines, summary_lines


@dataclass(frozen=True)
class Done:
    """The result of a job."""

    reconstruction: Reconstruction
    verdict: Verdict
    answer: Answer


def do(job: Job, run: CachingRun) -> Done:
    """Copy the photos in, reconstruct, assess, write the deliverables and the report."""
    case = run.case
    calibrations = _take_cameras_in(job, case)
    take_certificates_in(case, job.camera_files)
    left_out = take_in(case, job.sources, job.masks)
    capture = Capture(
        sources=(case.photos,),
        calibrations=calibrations,
        board=job.board,
        distances=job.distances,
        tapes=job.tapes,
        plates=job.plates,
    )
    with naming_left_out(left_out):
        done = reconstruct(capture, options_for(job.choices), run)
    drawn = run(
        draw,
        done.photos,
        done.features,
        done.pairs,
        done.metric,
        done.cloud,
        done.mesh,
        done.others,
    )
    done = replace(done, photos=replace(done.photos, set_aside=(*left_out, *done.photos.set_aside)))
    # Assessed before any file is written: the names of files tell a red result.
    evidence = evidence_of(done, cited_setups(case, datetime.now(UTC).date()))
    assessment = run.unkept(assess, evidence)
    red = assessment.light == "red"
    run.unkept(deliver, done, case.deliverables, unscaled=job.unscaled, red=red)
    write_accuracy(case, assessment)
    summary = summarise(done, assessment, run.timings, run.reused)
    _write_report(case, summary, drawn, f"Surface of {evidence.name}")
    answer = Answer(
        summary=case.summary,
        light=summary.verdict.light,
        lines=summary_lines(summary),
        costs=profile_lines(summary.stages),
    )
    return Done(done, summary.verdict, answer)


def _take_cameras_in(job: Job, case: CaseFolder) -> tuple[Calibration, ...]:
    """Read the camera files and keep copies in the case.

    Raises:
        CaseError: one cannot be read, or lies where the copy of another belongs.
    """
    calibrations = tuple(read_camera(file) for file in job.camera_files)
    for idx, file in enumerate(job.camera_files):
        kept = case.camera_file(idx)
        if kept.resolve() in {other.resolve() for other in job.camera_files if other != file}:
            raise CaseError("camera.file_in_its_place", kept=str(kept), file=str(file))
        if not (kept.exists() and kept.samefile(file)):
            with written_whole(kept) as beside:
                shutil.copyfile(file, beside)
    return calibrations


def _write_report(case: CaseFolder, summary: Summary, drawn: Pictures, title: str) -> None:
    case.report.mkdir(exist_ok=True)
    for picture in drawn.pictures:
        with written_whole(case.report / f"{picture.name}.png") as beside:
            beside.write_bytes(picture.png.tobytes())
    with written_whole(case.page) as beside:
        beside.write_text(html_of(case_report(summary, drawn, title)), encoding="utf-8")
    write_json(case.summary, tree_of(summary))
