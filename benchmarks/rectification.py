"""The picture of docs/clinic/workbench.md: the recipe that stands there, done to a synthetic limb.

    python benchmarks/rectification.py

The limb is a transtibial one from the project's own generator, without photos; its landmarks
are put by angle and height. The edits are read from the page, so that picture and page agree.
"""

import re
import shlex
import tempfile
from pathlib import Path

import cv2

from commands import done
from harness import described
from limbgram.formats.stl import write_stl
from limbgram.synthetic.props.limb import TRANSTIBIAL_PLACES, LimbKind, make_limb

PAGE = Path(__file__).resolve().parents[1] / "docs" / "clinic" / "workbench.md"
PICTURE = PAGE.with_name("rectification.png")
EDIT = re.compile(r"^limbgram edit add first\.toml (.+)$", re.MULTILINE)
SEED, STEP_MM = 4, 2.0


def main() -> None:
    described(__doc__).parse_args()
    limb = make_limb(LimbKind.TRANSTIBIAL, SEED, STEP_MM, base_mm=0.0)
    marks: list[str] = []
    for name, (angle_deg, share) in TRANSTIBIAL_PLACES.items():
        place = limb.place_mm(angle_deg, share)
        marks += ["--landmark", f"{name}={','.join(f'{value:.2f}' for value in place)}"]
    recipe = PAGE.read_text("utf-8").split("limbgram edit apply")[0]
    with tempfile.TemporaryDirectory() as folder:
        scan, edits, made = (str(Path(folder) / f) for f in ("scan.stl", "first.toml", "made.ply"))
        write_stl(limb.mesh, Path(scan), "mm")
        done("align", scan, "--side", limb.side, "--kind", "transtibial", *marks)
        done("edit", "new", edits, "--for", scan)
        for edit in EDIT.findall(recipe):
            done("edit", "add", edits, *shlex.split(edit))
        done("edit", "apply", scan, edits, "-o", made)
        done("compare", scan, made, "--picture", str(PICTURE))
    drawn = cv2.imread(str(PICTURE))
    cv2.imwrite(str(PICTURE), drawn[: len(drawn) // 2])  # the lower half shows the normals


if __name__ == "__main__":
    main()
