"""Client figures: numbers that the page draws and judges by, from the one place where each stands.

`python -m limbgram.app.client_figures web/src/api/figures.json` writes them; a test keeps that file
what it would write.
"""

import json
import sys
from pathlib import Path
from typing import Any

from limbgram.app.known_lengths import BoardSpec, Ruler
from limbgram.app.measures import SAME_HEIGHT_MM
from limbgram.core.geometry.smoothed_length import SMOOTHING_MM
from limbgram.formats.printed_size import MOST_OFF
from limbgram.reconstruction.calibration.board import MIN_PHOTOS
from limbgram.reconstruction.targets.board import LENS_BOARD
from limbgram.report.drawings.coverage import SURENESS_MM
from limbgram.report.drawings.differences import EDGES_MM
from limbgram.workbench.measures.measured_skin import HOLLOW_SHARE
from limbgram.workbench.recipe.ledger import SPACING_MM


def figures() -> dict[str, Any]:
    printed = BoardSpec().model_dump(exclude={"ruler"})
    lens = BoardSpec(
        kind="checkerboard",
        columns=LENS_BOARD.columns,
        rows=LENS_BOARD.rows,
        square_mm=LENS_BOARD.square_mm,
        marker_mm=0.0,
    ).model_dump(exclude={"ruler"})
    return {
        "SMOOTHING_MM": SMOOTHING_MM,
        "HOLLOW_SHARE": HOLLOW_SHARE,
        "LEVEL_SPACING_MM": SPACING_MM,
        "SAME_HEIGHT_MM": SAME_HEIGHT_MM,
        "SURE_STOPS_MM": list(SURENESS_MM),
        "DIFFERENCE_LIMITS_MM": list(EDGES_MM[:4]),
        "PRINTED_BOARD": printed,
        "LENS_BOARD": lens,
        "RULER_MM": float(Ruler.model_fields["drawn_mm"].default),
        "RULER_MOST_OFF": MOST_OFF,
        "FEWEST_BOARD_PHOTOS": MIN_PHOTOS,
    }


def text_of_figures() -> str:
    return json.dumps(figures(), indent=2) + "\n"


def main() -> None:
    Path(sys.argv[1]).write_text(text_of_figures(), encoding="utf-8")


if __name__ == "__main__":
    main()
