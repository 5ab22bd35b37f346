"""Captures of the project's own generator, by number of photos and resolution, and the paper's.

    python benchmarks/sweep.py FOLDER --photos 15 --megapixels 4 --seed 11

makes one capture; `captures.py --sweep` and `cost.py` make and run many. The paper's set-up: 15
photos of 4752 x 3168 px with a 50 mm lens on a sensor 22.3 mm wide, from 2 m. With `--phone` the
lens is a phone's, as wide as one of 26 mm on film, in pictures of 4 x 3.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from harness import described
from limbgram.synthetic.capture import make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens

PHOTOS = (8, 15, 30, 60)
MEGAPIXELS = (1.0, 4.0, 15.0)
_PAPER_MEGAPIXELS = 4752 * 3168 / 1e6
_CAMERA = Lens(focal_mm=50.0, sensor_width_mm=22.3)
_PHONE = Lens(
    make="Apple",
    model="iPhone 13",
    name="wide 26mm",
    focal_mm=7.36,
    sensor_width_mm=9.8,
    aperture=1.6,
    k1=0.02,
    k2=-0.03,
)
PHONE_MM = 540.0
"""From which a phone's picture just holds a limb."""


@dataclass(frozen=True)
class Setting:
    """One point of a sweep."""

    photos: int
    megapixels: float
    seed: int
    distance_mm: float = 1500.0
    phone: bool = False

    @property
    def name(self) -> str:
        far = "" if self.distance_mm == 1500.0 else f"_d{self.distance_mm:.0f}"
        by = "phone" if self.phone else "synthetic"
        return f"{by}_p{self.photos}_mp{self.megapixels:g}{far}_s{self.seed}"

    @property
    def options(self) -> CaptureOptions:
        """Photos on one ring up to 20, on two up to 40, on three beyond."""
        across, down = (4, 3) if self.phone else (3, 2)
        width_px = 2 * round((self.megapixels * 1e6 * across / down) ** 0.5 / 2)
        options = CaptureOptions(
            photos=self.photos,
            rings=1 if self.photos <= 20 else 2 if self.photos <= 40 else 3,
            width_px=width_px,
            height_px=round(width_px * down / across),
            seed=self.seed,
            distance_mm=self.distance_mm,
            lens=_PHONE if self.phone else _CAMERA,
        )
        return replace(options, blur_px=0.7, samples=2) if self.phone else options

    @property
    def arguments(self) -> list[str]:
        """With which this file makes its capture."""
        words = ["--photos", str(self.photos), "--megapixels", str(self.megapixels)]
        words += ["--distance", str(self.distance_mm), "--seed", str(self.seed)]
        return [*words, "--phone"] if self.phone else words


def paper(seed: int) -> Setting:
    """The paper's set-up."""
    return Setting(15, round(_PAPER_MEGAPIXELS, 3), seed, 2000.0)


def phone(photos: int, megapixels: float, seed: int) -> Setting:
    """A limb taken with a phone from near."""
    return Setting(photos, megapixels, seed, PHONE_MM, phone=True)


def parse_settings(texts: list[str], seed: int) -> list[Setting]:
    """Settings such as 8x1 (photos x megapixels), `paper`, or `all` for the whole sweep."""
    found: list[Setting] = []
    for text in texts:
        if text == "all":
            found += [Setting(n, mp, seed) for mp in MEGAPIXELS for n in PHOTOS]
        elif text == "paper":
            found.append(paper(seed))
        else:
            photos, megapixels = text.split("x")
            found.append(Setting(int(photos), float(megapixels), seed))
    return found


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--photos", type=int, default=15)
    parser.add_argument("--megapixels", type=float, default=4.0)
    parser.add_argument("--distance", type=float, default=1500.0, help="mm")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--phone", action="store_true")
    chosen = parser.parse_args()
    setting = Setting(
        chosen.photos, chosen.megapixels, chosen.seed, chosen.distance, phone=chosen.phone
    )
    make_capture(chosen.folder, setting.options)


if __name__ == "__main__":
    main()
