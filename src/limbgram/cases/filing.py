"""Filing: the record of the shape that was worked on in a case."""

from limbgram.cases.assessing import cited
from limbgram.cases.bench import Bench
from limbgram.core.errors import CaseError
from limbgram.formats.reading import read_shape
from limbgram.formats.sidecar import hash_of, limb_file_beside
from limbgram.report.record.record import Record, record_of
from limbgram.report.record.sources import CaseSource, RecipeSource, ShapeSource
from limbgram.workbench.recipe.recipe import Replayed


def filed_record(bench: Bench, done: Replayed) -> Record:
    """The record of the shape after the recipe, beside its scan; or of the scan, if it has no edit.

    Raises:
        MeasureError: the limb is not aligned.
    """
    scan = _source(bench, rectified=False)
    if not done.ledger.lines:
        return record_of(scan, case=_case(bench))
    bench.write_rectified(done.limb)
    recipe = RecipeSource(recipe=bench.recipe(), sha256=hash_of(bench.recipe_file.read_bytes()))
    return record_of(_source(bench, rectified=True), scan, recipe, _case(bench))


def _source(bench: Bench, *, rectified: bool) -> ShapeSource:
    path = bench.rectified_file if rectified else bench.scan_file()
    read, beside = read_shape(path), limb_file_beside(path)
    return ShapeSource(
        limb=read.limb,
        sha256=read.sha256,
        kind=path.suffix[1:].upper(),
        limb_file_sha256=hash_of(beside.read_bytes()) if beside.is_file() else None,
    )


def _case(bench: Bench) -> CaseSource | None:
    """The case that it came from; None where that was never finished here, or is unscaled."""
    try:
        return cited(bench.case.folder)
    except CaseError:
        return None
