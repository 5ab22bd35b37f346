"""`limbgram trend`: the measuring sheets of a limb's visits, and whether each measure changed."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.replies import Reply, answered, language
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import UnitOfAll, require_output, shape_of
from limbgram.services.trend import TrendFiles, TrendRequest, trend
from limbgram.workbench.compare.messages import sheet_trend_lines, sheet_trend_tree


@answered
@asking
def trend_command(
    shapes: Annotated[list[Path], typer.Argument(help="Aligned shapes of one limb, a visit each.")],
    ask: TrendRequest,
    files: TrendFiles,
    unit: UnitOfAll = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Follow a limb's measuring sheet over visits: what changed, by how much, and how surely.

    Give one --day for each shape. Place the same landmarks on each, and align it, first.
    """
    require_output(files.xlsx, ".xlsx", "table")
    require_output(files.csv, ".csv", "table")
    found = trend([shape_of(shape, unit).limb for shape in shapes], ask)
    written = [str(path) for path in files.write(found)]
    return Reply(
        (*sheet_trend_lines(found, language()), *(f"Written: {path}" for path in written)),
        {**sheet_trend_tree(found), "written": written},
    )
