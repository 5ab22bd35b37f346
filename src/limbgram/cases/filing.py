"""Filing: the record of the shape that was worked on in a case."""

from limbgram.cases.assessing import cited
from limbgram.cases.bench import Bench, Work
from limbgram.core.errors import CaseError
from limbgram.formats.reading import ShapeFile, read_shape
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.report.record.record import Record, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource


def filed_record(bench: Bench, work: Work) -> Record:
    """The record of the shape after the recipe, beside its scan; or of the scan, if it has no edit.

    Raises:
        MeasureError: the limb is not aligned.
    """
    scan = _source(work.scan, work.limb_file_sha256)
    if not work.done.ledger.lines:
        return record_of(scan, case=_case(bench))
    path = bench.rectified(work.done.limb)
    shape = _source(read_shape(path), hash_of(limb_file_beside(path).read_bytes()))
    recipe = RecipeSource(recipe=work.recipe, sha256=work.recipe_sha256)
    return record_of(shape, scan, recipe, _case(bench))


def _source(read: ShapeFile, limb_file_sha256: str | None) -> ShapeSource:
    return ShapeSource(
        limb=read.limb, sha256=read.sha256, kind="PLY", limb_file_sha256=limb_file_sha256
    )


def _case(bench: Bench) -> CaseSource | None:
    """The case that it came from; None where that was never finished here, or is unscaled."""
    try:
        return cited(bench.case.folder)
    except CaseError:
        return None
