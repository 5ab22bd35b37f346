"""Superseded results: moves results of other photos, options or versions aside before a new run.

A case is run again: with the same photos, options and program, the results that lie there are what
the run will make again, so they stay while it runs, and a stop or a full disk spoils nothing. With
anything changed they would be taken for an answer to what was asked now, above all when that is
refused: before the first stage runs they are moved to CASE/superseded/, and they go when a run
finishes.

Pages are moved before everything else and case.json is written last: a run that is killed on the
way leaves a case.json that speaks of results which are not there, never a page that no case.json
speaks for. The next run moves what was left.
"""

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

from limbgram.cases.case_record import read_record
from limbgram.cases.fingerprint import Fingerprints, code_version, sha256_if_readable
from limbgram.cases.folder import CaseFolder, incoming, require_apart
from limbgram.cases.job_messages import Job, plain_tree
from limbgram.core.files import written_whole
from limbgram.formats.camera import read_camera

_NOTE = """These are the results of an earlier run of this case. Since then it was run again with
other photos, options or another version of the program, and that run has not finished, so they are
no answer to what was asked last. case.json beside this file is that of the earlier run; the one in
the folder above says what became of the later run and why. As soon as a run finishes, this folder
is removed.
"""


def key_of(job: Job) -> str:
    """Key of what a job's results depend on: bytes of photos and camera files, options, program.

    Raises:
        PhotoError: a source does not exist.
        CaseError: a camera file cannot be read, or the case is the photos' own folder.
    """
    tree: dict[str, Any] = plain_tree(job)
    del tree["case"], tree["masks"]
    require_apart(CaseFolder(job.case), job.sources)
    pictures, _ = incoming(job.sources, job.masks)
    tree["sources"] = sorted(
        (name.as_posix(), sha256_if_readable(source)) for source, name in pictures
    )
    tree["camera_files"] = [Fingerprints().of(read_camera(file)) for file in job.camera_files]
    tree["program"] = code_version("limbgram.cases.job")
    return hashlib.sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()


def is_up_to_date(case: CaseFolder, key: str) -> bool:
    """Whether the case holds the finished results of the job with this key."""
    try:
        record = read_record(case)
    except LookupError:
        return False
    return (
        record.state == "finished"
        and record.job == key
        and case.page.is_file()
        and case.summary.is_file()
        and case.accuracy("json").is_file()
        and all((case.root / file.path).is_file() for file in record.files)
    )


def is_finished(case: CaseFolder) -> bool:
    """Whether case.json says that its results are whole."""
    try:
        return read_record(case).state == "finished"
    except LookupError:
        return False


def supersede(case: CaseFolder) -> None:
    """Move results that no longer stand aside, pages first, with the record that speaks of them."""
    results = [path for path in _results(case) if path.exists()]
    if not results:
        return
    case.superseded.mkdir(exist_ok=True)
    with written_whole(case.superseded / "READ-ME.txt") as beside:
        beside.write_text(_NOTE, encoding="utf-8")
    if case.record.is_file():
        with written_whole(case.superseded / "case.json") as beside:
            shutil.copyfile(case.record, beside)
    for path in results:
        aside = case.superseded / path.name
        if aside.is_dir():
            shutil.rmtree(aside)
        path.replace(aside)


def drop_superseded(case: CaseFolder) -> None:
    """Remove the results of earlier runs, once there are new ones."""
    shutil.rmtree(case.superseded, ignore_errors=True)


def _results(case: CaseFolder) -> tuple[Path, ...]:
    """What a run leaves for people and programs: pages first."""
    accuracy = [
        case.accuracy(suffix, against_truth=truth)
        for truth in (False, True)
        for suffix in ("html", "pdf", "json")
    ]
    return (case.page, *accuracy, case.summary, case.report, case.deliverables)
