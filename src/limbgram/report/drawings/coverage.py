"""Coverage: where photos stand round a limb, and how sure its surface will be once measured.

Left the ring from above, the first photo at 12 o'clock; a camera held high stands nearer to the
middle. Right the limb unrolled: azimuth across, height upwards, the upper end above the dashed
line; the shade is the expected interval, dark where it is wide, hatched where too few photos see.
"""

import math
import string
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.patches import Circle, Rectangle

from limbgram.capture.answer import CaptureCheck, Coverage
from limbgram.capture.camera_positions import Stand
from limbgram.core.interval import COVER, Interval, plus_minus
from limbgram.report.drawings.drawing import FAINT, INK, PALE_INK, axes_at, bare, png

SURENESS_MM = (0.0, 0.06, 0.12, 0.20, 0.32, 0.50)
SURENESS = ("#F6F4F7", "#ECE5F1", "#C4ACD4", "#9B70B2", "#6E3A8A", "#42165C")
"""Half the width of the interval that holds in 95 of 100, and its shade: the same in all cases."""
ACT, DOUBT = "#0B6076", "#855400"
_GROUND = "#E6EAEB"
_SHADES = LinearSegmentedColormap.from_list(
    "sureness", [(at / SURENESS_MM[-1], shade) for at, shade in zip(SURENESS_MM, SURENESS)]
)
_RANGE = Normalize(0.0, SURENESS_MM[-1], clip=True)
_WIDTH_IN, _HEIGHT_IN = 10.6, 4.7
_LETTERS = 8
_HIGHEST_DEG, _LOWEST_DEG = 90.0, -30.0
_OUTER, _INNER = 1.0, 0.42
_CLEAR = 0.2
"""Between a label and the middle of a photo's circle."""


@dataclass(frozen=True, kw_only=True)
class StandMark:
    """A camera stand to be marked on the ring."""

    stand: Stand
    label: str
    kind: str
    """"counts", "does not count" or "to add"."""


def coverage_picture(check: CaptureCheck) -> UInt8[np.ndarray, " n"]:
    """What a check found, as a PNG."""
    marks = [
        StandMark(
            stand=Stand(
                azimuth_deg=one.azimuth_deg, elevation_deg=one.elevation_deg, distance=math.nan
            ),
            label=str(number),
            kind="counts" if one.counts else "does not count",
        )
        for number, one in enumerate(check.photos, start=1)
        if one.placed
    ]
    places = [
        (azimuth, elevation)
        for one in check.missing
        for azimuth, elevation in zip(one.azimuths_deg, one.elevations_deg)
    ]
    marks += [
        StandMark(
            stand=Stand(azimuth_deg=azimuth, elevation_deg=elevation, distance=math.nan),
            label=letter_of(number),
            kind="to add",
        )
        for number, (azimuth, elevation) in enumerate(places)
    ]
    title = "GO" if check.go else "NOT YET"
    placed = sum(one.placed for one in check.photos)
    said = f"{placed} of {len(check.photos)} photos placed"
    if places:
        said += f", {len(places)} to add"
    return _picture(f"{title}: {said}", marks, check.coverage)


def plan_picture(
    title: str, stands: Sequence[Stand], coverage: Coverage
) -> UInt8[np.ndarray, " n"]:
    """Where a plan lets photos be taken, and what they will give, as a PNG."""
    marks = [
        StandMark(stand=one, label=str(number), kind="counts")
        for number, one in enumerate(stands, start=1)
    ]
    return _picture(title, marks, coverage)


def letter_of(number: int) -> str:
    """A, B, ... Z, then AA, AB and so on."""
    letters = string.ascii_uppercase
    first = letters[number // len(letters) - 1] if number >= len(letters) else ""
    return first + letters[number % len(letters)]


def _picture(
    title: str, marks: Sequence[StandMark], coverage: Coverage | None
) -> UInt8[np.ndarray, " n"]:
    figure = bare(_WIDTH_IN, _HEIGHT_IN)
    figure.text(0.02, 0.95, title, fontsize=13, color=INK, weight="bold", va="center")
    _ring(axes_at(figure, 0.25, 0.55, 3.9, 3.9), marks)
    if coverage is not None:
        _map(axes_at(figure, 4.95, 0.85, 4.2, 3.0), coverage)
        if math.isfinite(coverage.sigma_middle_mm):
            _legend(axes_at(figure, 9.4, 0.85, 0.16, 3.0))
    return png(figure)


def _ring(axes: Axes, marks: Sequence[StandMark]) -> None:
    """Seen from above, clockwise from 12."""
    axes.set_xlim(-1.28, 1.28)
    axes.set_ylim(-1.28, 1.28)
    axes.set_aspect("equal")
    axes.axis("off")
    places = [
        _position_on_ring(one.stand.azimuth_deg, _radius_of_elevation(one.stand.elevation_deg))
        for one in marks
    ]
    for elevation_deg, words in ((0.0, "level"), (45.0, "45° up")):
        radius = _radius_of_elevation(elevation_deg)
        axes.add_patch(Circle((0, 0), radius, fill=False, ec=FAINT, lw=0.7, ls=(0, (4, 3))))
        x, y = _free_place(radius, places)
        axes.text(
            x, y, words, fontsize=6.5, color=PALE_INK, ha="center", va="center", backgroundcolor="w"
        )
    axes.add_patch(Circle((0, 0), 0.24, fc=_GROUND, ec=PALE_INK, lw=0.8))
    axes.text(0, 0, "limb", ha="center", va="center", fontsize=_LETTERS, color=PALE_INK)
    for hour in range(1, 13):
        x, y = _position_on_ring(-30.0 * hour, 1.21)
        axes.text(x, y, str(hour), ha="center", va="center", fontsize=7, color=FAINT)
    styles = {
        "counts": {"fc": "#5C7A85", "ec": "white", "ls": "-", "text": "white"},
        "does not count": {"fc": "white", "ec": DOUBT, "ls": "-", "text": DOUBT},
        "to add": {"fc": "#DFEFF3", "ec": ACT, "ls": (0, (2, 1.2)), "text": ACT},
    }
    for mark, place in zip(marks, places, strict=True):
        style = styles[mark.kind]
        axes.add_patch(
            Circle(place, 0.085, fc=style["fc"], ec=style["ec"], ls=style["ls"], lw=1.3, zorder=3)
        )
        axes.text(
            *place,
            mark.label,
            ha="center",
            va="center",
            fontsize=6.5,
            color=style["text"],
            weight="bold" if mark.kind == "to add" else "normal",
            zorder=4,
        )
    kinds = dict.fromkeys(mark.kind for mark in marks)
    words = {
        "counts": "filled: photos",
        "does not count": "brown: blurred or badly lit",
        "to add": "dashed letters: photos to add",
    }
    axes.text(
        0,
        -1.33,
        "from above, photo 1 at 12; " + "; ".join(words[kind] for kind in kinds),
        ha="center",
        va="top",
        fontsize=7,
        color=PALE_INK,
    )


def _radius_of_elevation(elevation_deg: float) -> float:
    """Distance from the ring's middle: high cameras are drawn near to it."""
    share = (elevation_deg - _LOWEST_DEG) / (_HIGHEST_DEG - _LOWEST_DEG)
    return _OUTER - (_OUTER - _INNER) * min(max(share, 0.0), 1.0)


def _free_place(radius: float, taken: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """An azimuth between two hours with no photo near, near 12 o'clock if that is free."""
    tried = [_position_on_ring(-15.0 - 30.0 * k, radius) for k in range(12)]
    off = [min((math.dist(one, other) for other in taken), default=math.inf) for one in tried]
    return next((one for one, far in zip(tried, off) if far > _CLEAR), tried[int(np.argmax(off))])


def _position_on_ring(azimuth_deg: float, radius: float) -> tuple[float, float]:
    """Azimuth 0 is up; azimuths turn counter-clockwise."""
    turn = np.radians(azimuth_deg)
    return (-radius * float(np.sin(turn)), radius * float(np.cos(turn)))


def _map(axes: Axes, coverage: Coverage) -> None:
    """The limb unrolled, 12 o'clock at both ends, hours running to the right."""
    in_mm = math.isfinite(coverage.sigma_middle_mm)
    photos = _numbers(coverage.photos)
    values = _numbers(coverage.sigma_mm) * COVER if in_mm else photos
    half = coverage.columns // 2
    for row in range(coverage.rows):
        for column in range(coverage.columns):
            if not np.isfinite(photos[row, column]):
                continue
            value = values[row, column]
            # Clockwise to the right, the photographer's 6 o'clock in the middle.
            at = (coverage.columns - column) % coverage.columns
            shade = _shade(value, in_mm)
            for left in (at, at + coverage.columns):
                if left - 0.5 > coverage.columns:
                    continue
                axes.add_patch(
                    Rectangle(
                        (left - 0.5, row),
                        1,
                        1,
                        fc=shade,
                        ec="white" if photos[row, column] >= 2 else PALE_INK,
                        lw=0.4,
                        hatch="" if photos[row, column] >= 2 else "/////",
                    )
                )
    axes.axhline(coverage.side_rows, color=PALE_INK, lw=0.8, ls=(0, (4, 3)))
    axes.set_xlim(0, coverage.columns)
    axes.set_ylim(0, coverage.rows)
    axes.set_xticks(
        np.linspace(0, coverage.columns, 5), ["12", "3", "6", "9", "12"], fontsize=_LETTERS
    )
    axes.set_xlabel("side that faces this hour, from above", fontsize=_LETTERS, color=PALE_INK)
    unit = " mm" if in_mm else ""
    ticks = np.linspace(0, coverage.side_rows, 4)
    heights = [f"{share * coverage.length:.0f}{unit}" for share in np.linspace(0, 0.9, 4)]
    axes.set_yticks([*ticks, coverage.side_rows + 1], [*heights, "upper end"], fontsize=_LETTERS)
    axes.tick_params(colors=INK, length=2)
    axes.set_facecolor("#ffffff")
    for side in axes.spines.values():
        side.set_color(FAINT)
    said = f"{coverage.measured:.0%} of the limb seen by two photos or more"
    if in_mm:
        middle = plus_minus(Interval.of_sigma(coverage.sigma_middle_mm), 2)
        said += f"; half of it surer than {middle} mm"
    axes.set_title(said, fontsize=_LETTERS + 0.5, color=INK, loc="left")
    axes.text(
        half,
        -2.35,
        "hatched: seen by fewer than two photos" if (photos < 2).any() else "",
        ha="center",
        va="top",
        fontsize=7,
        color=PALE_INK,
    )


def _shade(value: float, in_mm: bool) -> tuple[float, float, float, float] | str:
    if not np.isfinite(value):
        return "#D6DCDE"
    if in_mm:
        return _SHADES(_RANGE(value))
    return _SHADES(1.0 - min(value, 6.0) / 6.0)


def _legend(axes: Axes) -> None:
    bar = Colorbar(axes, cmap=_SHADES, norm=_RANGE, ticks=list(SURENESS_MM))
    bar.ax.tick_params(labelsize=7, colors=INK, length=2)
    bar.ax.set_yticklabels([*(f"{at:.2f} mm" for at in SURENESS_MM[:-1]), "0.50 mm, more"])
    bar.ax.set_xlabel("±, holds\nin 95 of 100", fontsize=7, color=PALE_INK)
    bar.outline.set_visible(False)


def _numbers(rows: Sequence[Sequence[float | int | None]]) -> Float64[np.ndarray, "r c"]:
    return np.array([[np.nan if one is None else float(one) for one in row] for row in rows])
