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
import numpy as np

from commands import done
from limbgram.formats.stl import write_stl
from limbgram.synthetic.props.limb import LimbKind, make_limb

PAGE = Path(__file__).resolve().parents[1] / "docs" / "clinic" / "workbench.md"
PICTURE = PAGE.with_name("rectification.png")
EDIT = re.compile(r"^limbgram edit add first\.toml (.+)$", re.MULTILINE)
SEED, STEP_MM = 4, 2.0
PLACES = {
    "patellar tendon": (0, 0.33),
    "tibial tubercle": (0, 0.43),
    "fibula head": (105, 0.38),
    "popliteal crease": (180, 0.27),
    "tibia end": (0, 0.87),
}
"""Degrees from anterior towards lateral, and share of the height from the cut."""


def main() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, SEED, STEP_MM, base_mm=0.0)
    draws = np.random.default_rng((SEED, 1))  # size, side, front: as the limb draws them
    draws.uniform()
    lateral, front = draws.choice([-1.0, 1.0]), draws.uniform(0, 2 * np.pi)
    points = limb.mesh.vertices_mm
    angles = np.degrees(lateral * (np.arctan2(points[:, 1], points[:, 0]) - front))
    marks: list[str] = []
    for name, (angle, share) in PLACES.items():
        off = np.abs((angles - angle + 180) % 360 - 180)
        place = points[np.argmin(off + np.abs(points[:, 2] - share * limb.height_mm))]
        marks += ["--landmark", f"{name}={','.join(f'{value:.2f}' for value in place)}"]
    recipe = PAGE.read_text("utf-8").split("limbgram edit apply")[0]
    with tempfile.TemporaryDirectory() as folder:
        scan, edits, made = (str(Path(folder) / f) for f in ("scan.stl", "first.toml", "made.ply"))
        write_stl(limb.mesh, Path(scan), "mm")
        side = "right" if lateral > 0 else "left"
        done("align", scan, "--side", side, "--kind", "transtibial", *marks)
        done("edit", "new", edits, "--for", scan)
        for edit in EDIT.findall(recipe):
            done("edit", "add", edits, *shlex.split(edit))
        done("edit", "apply", scan, edits, "-o", made)
        done("compare", scan, made, "--picture", str(PICTURE))
    drawn = cv2.imread(str(PICTURE))
    cv2.imwrite(str(PICTURE), drawn[: len(drawn) // 2])  # the lower half shows the normals


if __name__ == "__main__":
    main()
