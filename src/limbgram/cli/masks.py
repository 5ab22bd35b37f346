"""`limbgram masks`: what of each photo is the limb, to look at and to correct."""

from pathlib import Path
from typing import Annotated

import typer

from limbgram.cases.folder import CaseFolder
from limbgram.cases.masks import MARGIN_MM, write_masks
from limbgram.cli.progress import display
from limbgram.cli.replies import Reply, answered
from limbgram.core.run import Run


@answered
def masks_command(
    case: Annotated[Path, typer.Argument(help="Case folder of `limbgram reconstruct`.")],
    folder: Annotated[Path, typer.Option("-o", "--out", help="Folder to make.")],
    margin: Annotated[
        float, typer.Option(help="White round the surface, mm, 0 to 100.")
    ] = MARGIN_MM,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,
) -> Reply:
    """Write a case's masks, what it took for the limb in each photo, to correct and use again.

    A mask is a PNG as large as its photo: white is used, black is not. Correct it in any paint
    program: paint black what is not the limb (a chair, a helper's arm, the other leg), and white
    what was missed. Then `limbgram reconstruct PHOTOS --masks FOLDER -o NEWCASE` uses nothing else.
    Good photos need no masks.
    """
    with display(as_json) as screen:
        made = write_masks(CaseFolder(case), folder, Run(listener=screen.listen), margin)
    lines = [
        f"{len(made.masks)} masks are in {made.folder}: white is the limb as the case measured it, "
        f"and {margin:g} mm round it.",
        f"At a glance: {made.sheet}",
        f"Correct them in any paint program, then: limbgram reconstruct PHOTOS --masks "
        f"{made.folder} -o NEWCASE",
    ]
    if made.without:
        lines.append(
            f"No mask for {', '.join(made.without)}: they have no place in the scene, or do not "
            "show the limb. Without a mask a photo is used whole."
        )
    return Reply(
        tuple(lines),
        {
            "folder": str(made.folder),
            "masks": [str(one) for one in made.masks],
            "without": list(made.without),
            "sheet": str(made.sheet),
        },
    )
