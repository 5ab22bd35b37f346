"""The pictures of docs/clinic/capture.md, drawn from a synthetic capture by a phone.

    python benchmarks/guide.py

walk.png: a walk round the limb, from above and as the phone saw it. mistakes.png: one photo as it
should be, and spoiled in the ways that clinics know. check.png: what `limbgram check` draws of the
walk when it was broken off.
"""

import json
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from PIL import Image
from scipy.spatial import ConvexHull

from commands import done, run
from harness import described
from limbgram.cases.scoring import read_truth_mesh
from limbgram.synthetic.capture import make_capture
from spoiled import blurred, overexposed
from sweep import phone

CLINIC = Path(__file__).resolve().parents[1] / "docs" / "clinic"
SEED, PHOTOS, MEGAPIXELS = 23, 24, 0.8
FAR_MM = 1600.0
RED = 7
"""The exit code of a capture that is not complete."""
INK, ACCENT, PAPER = "#16222A", "#0B6076", "#FFFFFF"


def main() -> None:
    described(__doc__).parse_args()
    matplotlib.use("Agg")
    matplotlib.rcParams.update({"font.size": 9, "text.color": INK, "axes.edgecolor": INK})
    near = replace(phone(PHOTOS, MEGAPIXELS, SEED).options, rings=2, calibration_photos=10)
    with tempfile.TemporaryDirectory() as folder:
        walk = make_capture(Path(folder) / "walk", near).folder
        far = make_capture(
            Path(folder) / "far",
            replace(near, photos=3, rings=1, distance_mm=FAR_MM, calibration_photos=0),
        ).folder
        bare = make_capture(
            Path(folder) / "bare", replace(near, photos=6, board=None, calibration_photos=0)
        ).folder
        draw_walk(walk, CLINIC / "walk.png")
        draw_mistakes(walk, far, bare, CLINIC / "mistakes.png")
        draw_check(walk, CLINIC / "check.png")


def pictures(capture: Path) -> list[Image.Image]:
    return [Image.open(path).convert("RGB") for path in sorted((capture / "images").iterdir())]


def draw_walk(capture: Path, out: Path) -> None:
    """From above: where each photo was taken; beside it every second photo."""
    told = json.loads((capture / "truth" / "cameras.json").read_text("utf-8"))
    centres_mm = np.array([one["C"] for one in told["images"]])
    shown = pictures(capture)[::2]
    figure = plt.figure(figsize=(10, 4.2), facecolor=PAPER)
    grid = figure.add_gridspec(
        3, 8, left=0.01, right=0.99, bottom=0.02, top=0.93, hspace=0.0, wspace=0.06
    )
    plan = figure.add_subplot(grid[:, :4])
    heights_mm = centres_mm[:, 2]
    high = heights_mm > heights_mm.mean()
    for rows, mark, name in ((~high, "o", "level with the limb"), (high, "^", "from higher up")):
        plan.scatter(*centres_mm[rows, :2].T, marker=mark, s=46, color=ACCENT, label=name)
    for number, (x_mm, y_mm) in enumerate(centres_mm[:, :2], 1):
        plan.annotate(str(number), (x_mm, y_mm), xytext=(6, 4), textcoords="offset points")
    draw_table(plan, capture)
    plan.set_aspect("equal")
    plan.axis("off")
    plan.legend(loc="upper left", frameon=False, fontsize=8)
    plan.set_title("From above: two rounds, a step apart")
    for k, picture in enumerate(shown):
        draw_photo(figure.add_subplot(grid[k // 4, 4 + k % 4]), picture, str(2 * k + 1))
    figure.savefig(out, dpi=110)
    plt.close(figure)


def draw_table(plan: Axes, capture: Path) -> None:
    """Limb and board, as they stand."""
    limb_mm = read_truth_mesh(capture / "truth" / "mesh.ply")[0]["xyz"][:, :2].astype(float)
    outline = limb_mm[ConvexHull(limb_mm).vertices]
    plan.fill(*outline.T, facecolor="#E6EAEB", edgecolor=INK)
    plan.text(*outline.mean(axis=0), "limb", ha="center", va="center")
    board = json.loads((capture / "truth" / "board.json").read_text("utf-8"))["scene_board"]
    across, down = (board["square_mm"] * board[name] for name in ("squares_x", "squares_y"))
    corners = np.array([[0, 0, 0], [across, 0, 0], [across, down, 0], [0, down, 0]], float)
    placed = corners @ np.array(board["R"]).T + np.array(board["t"])
    plan.fill(*placed[:, :2].T, facecolor=PAPER, edgecolor=INK, hatch="xx", linewidth=1)
    plan.text(*placed[:, :2].mean(axis=0), "board", ha="center", va="center",
              bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 1})  # fmt: skip


def draw_photo(axes: Axes, picture: Image.Image, title: str) -> None:
    axes.imshow(picture)
    axes.set_title(title, fontsize=8, pad=2)
    axes.axis("off")


def draw_mistakes(walk: Path, far: Path, bare: Path, out: Path) -> None:
    good = pictures(walk)[4]
    cells: Sequence[tuple[str, Image.Image]] = (
        ("Good: sharp, limb large,\nboard in the picture", good),
        ("Blurred: hold still,\nmore light", blurred(good)),
        ("Burnt out: tap the limb,\ndraw the exposure down", overexposed(good)),
        ("Too far away:\ncome closer", pictures(far)[0]),
        ("No board:\nno size", pictures(bare)[1]),
    )
    figure, row = plt.subplots(1, len(cells), figsize=(10, 2.1), facecolor=PAPER)
    for axes, (title, picture) in zip(row, cells, strict=True):
        draw_photo(axes, picture, title)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.01, top=0.80, wspace=0.05)
    figure.savefig(out, dpi=110)
    plt.close(figure)


def draw_check(walk: Path, out: Path) -> None:
    """Of the first two thirds of the lower round."""
    camera = walk / "camera.json"
    done("calibrate", str(walk / "calibration"), "--board", "14x10", "--square", "10",
         "-o", str(camera))  # fmt: skip
    photos = [str(path) for path in sorted((walk / "images").iterdir())]
    taken = photos[: PHOTOS // 3 + 2]
    checked = run("check", *taken, "--camera", str(camera), "--picture", str(out))
    if checked.returncode != RED:
        raise SystemExit(f"a broken-off walk was not found out: {checked.stdout}{checked.stderr}")


if __name__ == "__main__":
    main()
