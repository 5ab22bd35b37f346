"""Shape record: builds the record of a case's edited shape from its work."""

from limbgram.cases.case_assessment import cited
from limbgram.cases.folder import CaseFolder
from limbgram.cases.workspace import MAKING, TapeStanding, Work, Workspace
from limbgram.core.errors import CaseError
from limbgram.core.interval import COVER
from limbgram.findings import Finding
from limbgram.formats.reading import ShapeFile, read_shape
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.report.record.content import TapeRead
from limbgram.report.record.record import Record, RecordOptions, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.workbench.measures.measuring import Measures, check_one_reading, measure_limb


def shape_record_of(workspace: Workspace, work: Work) -> Record:
    """The record of the shape after the recipe, compared with the scan; of the scan without edits.

    Raises:
        MeasureError: the limb is not aligned.
    """
    scan = _source(work.scan, work.limb_file_sha256)
    case = _case(workspace)
    options = RecordOptions(
        case_id=workspace.case.case_id,
        case_untold=case is None and _was_computed(workspace.case.folder),
        tape=_tape(workspace, work),
    )
    if not work.done.ledger.lines:
        return record_of(scan, case=case, options=options)
    with MAKING.of(workspace.root):
        path = workspace.rectified(work.done.limb)
        shape = _source(read_shape(path), hash_of(limb_file_beside(path).read_bytes()))
    recipe = RecipeSource(recipe=work.recipe, sha256=work.recipe_sha256)
    return record_of(shape, scan, recipe, case, options)


def _tape(workspace: Workspace, work: Work) -> tuple[TapeRead, ...]:
    """Every tape reading compared with the scan, with its withdrawal and acceptance."""
    standings = workspace.tape_standings()
    if not standings:
        return ()
    measured = measure_limb(work.scan.limb)
    return tuple(_tape_read(measured, one) for one in standings)


def _tape_read(measured: Measures, standing: TapeStanding) -> TapeRead:
    reading = standing.read.reading
    check = check_one_reading(measured, reading)
    refused = isinstance(check, Finding)
    return TapeRead(
        made=standing.read.made,
        height_mm=reading.height_mm,
        read_mm=reading.girth_mm,
        measured_mm=None if refused else check.measured.value,
        within_mm=None if refused else COVER * check.sigma_mm,
        conflict=not refused and check.conflict,
        reason=check if refused else None,
        withdrawn=standing.withdrawn,
        accepted=standing.accepted,
    )


def _source(read: ShapeFile, limb_file_sha256: str | None) -> ShapeSource:
    return ShapeSource(
        limb=read.limb, sha256=read.sha256, kind="PLY", limb_file_sha256=limb_file_sha256
    )


def _case(workspace: Workspace) -> CaseSource | None:
    """The case as a source; None where it was not computed here, or cannot be cited."""
    try:
        return cited(workspace.case.folder)
    except CaseError:
        return None


def _was_computed(case: CaseFolder) -> bool:
    return case.record.is_file() or case.accuracy("json").is_file()
