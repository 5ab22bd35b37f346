"""The moving picture of README: photos, the surface with its sigma, rectified, and as a file.

    python benchmarks/tour.py

A limb of the project's own generator, photographed by a phone, goes through the commands that a
user types. Nothing is drawn that they did not make; the landmarks of the rectification are taken
from the generator, through the cameras that both know.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from PIL import Image, ImageDraw, ImageFont

from commands import done
from harness import described
from limbgram.cases.scoring import centres_mm
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.reading import read_shape
from limbgram.report.drawings.shading import Frame, looking_along, shade_all
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.props.limb import TRANSTIBIAL_PLACES
from limbgram.workbench.limb import Limb
from sweep import phone

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "tour.gif"
SEED, PHOTOS, MEGAPIXELS = 23, 20, 1.2
WIDTH, HEIGHT, BAR = 640, 420, 34
TURN = 20
"""Pictures of one turn of the limb."""
SHOWN_S = 0.12
SIGMA_MM, MOVED_MM = 0.15, 4.0
"""Where the colours end."""
EDITS = (
    ("reduction", "heights_mm=[20,140]", "per_cent=[0,3]", "of=girth"),
    ("load", "at=patellar tendon", "depth_mm=5", "falloff_mm=22"),
    ("relieve", "at=fibula head", "depth_mm=4", "falloff_mm=20"),
    ("relieve", "at=tibia end", "depth_mm=4", "falloff_mm=22"),
)
INK, PAPER = (22, 34, 42), (255, 255, 255)


def main() -> None:
    described(__doc__).parse_args()
    OUT.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        options = replace(phone(PHOTOS, MEGAPIXELS, SEED).options, calibration_photos=10)
        capture = make_capture(root / "capture", options)
        camera, case = root / "camera.json", root / "case"
        done("calibrate", str(capture.folder / "calibration"), "--board", "14x10", "--square", "10",
             "-o", str(camera))  # fmt: skip
        done("reconstruct", str(capture.folder / "images"), "--camera", str(camera),
             "-o", str(case))  # fmt: skip
        scan = case / "deliverables" / "surface.ply"
        marks: list[str] = []
        case_from_truth = _between(case / "deliverables" / "poses.json",
                                   capture.folder / "truth" / "cameras.json")  # fmt: skip
        for name, place in TRANSTIBIAL_PLACES.items():
            seen = case_from_truth.apply(capture.truth.limb.place_mm(*place)[None])[0]
            marks += ["--landmark", f"{name}={','.join(f'{value:.2f}' for value in seen)}"]
        side = capture.truth.limb.side
        done("align", str(scan), "--side", side, "--kind", "transtibial", *marks)
        recipe, made = root / "tour.toml", root / "rectified.ply"
        done("edit", "new", str(recipe), "--for", str(scan))
        for edit in EDITS:
            done("edit", "add", str(recipe), *edit)
        done("edit", "apply", str(scan), str(recipe), "-o", str(made))
        done("export", str(made), "--to", "aop", "--side", side, "-o", str(root / "limb.aop"))
        pictures = [
            *_walk(sorted((capture.folder / "images").iterdir())),
            *_sure(read_shape(scan).limb),
            *_rectified(read_shape(scan).limb, read_shape(made).limb),
            *_file(read_shape(root / "limb.aop").limb),
        ]
    first, *rest = [one.quantize(96, dither=Image.Dither.NONE) for one in pictures]
    first.save(OUT, save_all=True, append_images=rest, duration=round(1000 * SHOWN_S), loop=0)
    print(f"{OUT.name}: {len(pictures)} pictures, {OUT.stat().st_size / 1e6:.2f} MB")  # noqa: T201


def _between(case: Path, truth: Path) -> Similarity:
    """From the truth's frame to the case's, by the centres of the cameras."""
    found, true = centres_mm(case), centres_mm(truth)
    shared = sorted(found.keys() & true.keys())
    return fit_similarity(
        np.array([true[name] for name in shared]), np.array([found[name] for name in shared])
    )


def _walk(photos: list[Path]) -> Iterator[Image.Image]:
    """One photo after the other, those before them small below."""
    taken: list[Image.Image] = []
    for path in photos:
        photo = Image.open(path).convert("RGB")
        page = _page("1. Photos: a walk round the limb, camera positions unknown")
        large = photo.resize((400, round(400 * photo.height / photo.width)))
        page.paste(large, ((WIDTH - 400) // 2, BAR + 6))
        taken.append(photo.resize((30, round(30 * photo.height / photo.width))))
        for k, small in enumerate(taken):
            page.paste(small, (12 + 31 * k, HEIGHT - small.height - 8))
        yield page


def _sure(limb: Limb) -> Iterator[Image.Image]:
    """The surface in the colours of its sigma."""
    mesh = limb.aligned().mesh_in_limb
    sigma = np.zeros(len(mesh)) if mesh.sigma_mm is None else mesh.sigma_mm.astype(float)
    words = f"2. The surface in mm, coloured by one standard deviation: 0 to {SIGMA_MM:g} mm"
    yield from _turned(mesh, colormaps["viridis"](np.nan_to_num(sigma / SIGMA_MM, nan=1.0)), words)


def _rectified(before: Limb, after: Limb) -> Iterator[Image.Image]:
    """What the recipe moved: red built up, blue carved in."""
    mesh, scan = after.aligned().mesh_in_limb, before.aligned().mesh_in_limb
    nearest = TriangleTree.of(scan.vertices_mm, scan.faces).closest(mesh.vertices_mm).points_mm
    moved = ((mesh.vertices_mm - nearest) * mesh.vertex_normals()).sum(1)
    words = f"3. Rectified by a recipe: built up (red), carved in (blue), up to {MOVED_MM:g} mm"
    yield from _turned(mesh, colormaps["RdBu_r"](0.5 + moved / (2 * MOVED_MM)), words)


def _file(limb: Limb) -> Iterator[Image.Image]:
    """The file as it is read back: an AOP file's sections."""
    mesh = limb.aligned().mesh_in_limb
    height = mesh.vertices_mm[:, 2]
    rows = np.isclose(np.mod(np.round(height, 3), 12.0), 0.0, atol=0.5)
    paint = np.where(rows[:, None], (0.05, 0.38, 0.46, 1.0), (0.82, 0.80, 0.77, 1.0))
    words = "4. The file, read back: AOP, STL, DXF, G-code for a carver"
    yield from _turned(mesh, paint, words)


def _turned(mesh: Mesh, colours: np.ndarray, words: str) -> Iterator[Image.Image]:
    """One turn of a limb about its long axis, the proximal end up."""
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    size = HEIGHT - BAR - 12
    frames = [
        Frame(
            picture_from_world=looking_along(90 + 360 * k / TURN, 8.0),
            middle_mm=(low + high) / 2,
            pixel_mm=1.08 * float(high[2] - low[2]) / size,
            width_px=WIDTH,
            height_px=size,
        )
        for k in range(TURN)
    ]
    for picture in shade_all(mesh, frames, 255.0 * colours[:, :3]):
        page = _page(words)
        drawn = Image.fromarray(picture, "RGBA")
        page.paste(drawn, (0, BAR + 6), drawn)
        yield page


def _page(words: str) -> Image.Image:
    page = Image.new("RGB", (WIDTH, HEIGHT), PAPER)
    pen = ImageDraw.Draw(page)
    pen.rectangle((0, 0, WIDTH, BAR), fill=INK)
    pen.text((14, 8), words, fill=PAPER, font=ImageFont.load_default(15))
    return page


if __name__ == "__main__":
    main()
