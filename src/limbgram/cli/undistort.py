"""`limbgram undistort`: a case's photos without distortion, for programs that know no lens."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.case_assessment import kept_evidence, require_unaltered
from limbgram.cases.folder import CaseFolder
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.files import require_folder
from limbgram.core.run import Run
from limbgram.formats.undistorted import write_undistorted


@answered
def undistort_command(
    case: Annotated[Path, typer.Argument(help="Case folder of `limbgram reconstruct`.")],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder to write; must not be there.")],
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Write a case's photos without distortion, with a COLMAP model of pinhole cameras.

    images/ and sparse/ as OpenMVS and others take them, in millimetres.
    """
    require_folder(out.parent)
    kept = kept_evidence(CaseFolder(case))
    require_unaltered(kept.photos.photos)
    with display(as_json) as screen:
        run = Run(listener=screen.listen)
        written = run(write_undistorted, kept.photos, kept.metric, out)
    photos = len(kept.metric.scene.placed)
    return Reply(
        (f"Written: {written}: {photos} photos without distortion, and their pinhole cameras",),
        {"written": str(written), "photos": photos},
    )
