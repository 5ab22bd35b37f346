"""A random pattern for a sock, printed on fabric or transfer film, for a camera's resolution.

In      the size of a pixel on the skin, the size of a tile, a seed.
Out     a SockPattern that repeats without a seam, and a Sheet with rulers and the bare tile.
Method  Patterns for digital image correlation (Bossuyt 2013, "Optimized patterns for digital image
        correlation"): noise on a torus is limited to a ring of wavelengths and cut at a level. The
        ring's short end keeps all of it within what the camera resolves, also where the limb turns
        away; its long end leaves no bare area; a flat spectrum between them and random phases give
        one sharp peak of autocorrelation. The level is set where dark islands just do not flow
        together, so that every island is a spot of its own. Islands and gaps too small for the
        camera are removed. Colours go by wider noise: neighbours share one, places differ for the
        eye; dark inks on white and pale ones keep the contrast in grey.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import cast

import numpy as np
from contourpy import FillType, contour_generator
from jaxtyping import Bool, Float64, Int32, UInt8
from scipy.ndimage import label, map_coordinates

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.page import EDGE_MM, PageName, Paper, Sheet, pdf_of

SPECKLE_PX = 5.0
"""Width of a typical island: 3 to 5 px correlate best (Sutton, Orteu and Schreier 2009), and a side
of the limb that turns away by 50 degrees still shows it 3 px wide."""
_SHORTEST_PX, _LONGEST_PX = 7.0, 16.0
"""Wavelengths of the ring."""
_DARK_SHARE = 0.40
"""Below one half, where dark islands flow together into bands."""
_PALE_SHARE = 0.30
_FINEST_PX = 3.0
"""Islands and gaps less wide are removed."""
_STEP_PX = 0.8
_PATCH_PX = 60.0
"""Wavelength by which colours change."""
_TILE_STEP_MM = 10.0
_DARK = ((22, 26, 96), (140, 12, 30), (0, 84, 52), (28, 26, 30), (88, 18, 108))
_PALE = ((255, 224, 70), (160, 216, 248), (255, 190, 200))
WHITE = (255, 255, 255)
_PIXELS_MM = (0.02, 3.0)
"""Of the skin, in one pixel, for which a sock can be designed."""


@dataclass(frozen=True, kw_only=True)
class Ink:
    """One colour, printed where its field is above zero."""

    colour: tuple[int, int, int]
    field: Float64[np.ndarray, "rows columns"]


@dataclass(frozen=True, kw_only=True)
class SockPattern:
    """A tile that repeats without a seam, as sampled fields of its inks."""

    width_mm: float
    height_mm: float
    pixel_mm: float
    seed: int
    inks: tuple[Ink, ...]
    """In the order in which they are printed, on white."""

    @property
    def speckle_mm(self) -> float:
        return SPECKLE_PX * self.pixel_mm

    @cached_property
    def dark(self) -> Bool[np.ndarray, "rows columns"]:
        """Where a dark ink lies."""
        fields = [ink.field for ink in self.inks if ink.colour in _DARK]
        return np.max(fields, axis=0) > 0

    def colours_at(
        self, x_mm: Float64[np.ndarray, " n"], y_mm: Float64[np.ndarray, " n"]
    ) -> UInt8[np.ndarray, "n 3"]:
        """The colours of the repeated pattern at these points."""
        colours = np.full((len(x_mm), 3), WHITE, np.uint8)
        for ink in self.inks:
            rows, columns = ink.field.shape
            at = np.array([y_mm / self.height_mm * rows, x_mm / self.width_mm * columns])
            field = map_coordinates(ink.field, at, order=1, mode="grid-wrap")
            colours[field > 0] = ink.colour
        return colours


def sock_pattern(width_mm: float, height_mm: float, pixel_mm: float, seed: int = 0) -> SockPattern:
    """Design a tile for a camera whose pixel shows `pixel_mm` of the skin.

    Raises:
        OptionsError: pixels of this size suit no sock, or the tile is too small for the pattern.
    """
    least_mm, most_mm = _PIXELS_MM
    if not least_mm <= pixel_mm <= most_mm:
        raise OptionsError(
            "export.sheet.sock_pixel", pixel_mm=pixel_mm, least_mm=least_mm, most_mm=most_mm
        )
    if min(width_mm, height_mm) < 2 * _PATCH_PX * pixel_mm:
        raise OptionsError(
            "export.sheet.small_tile", width_mm=width_mm, height_mm=height_mm, pixel_mm=pixel_mm
        )
    step_mm = _STEP_PX * pixel_mm
    shape = (round(height_mm / step_mm), round(width_mm / step_mm))
    size_mm = (height_mm, width_mm)
    rng = np.random.default_rng((seed, 21))

    def noise(shortest_px: float, longest_px: float) -> Float64[np.ndarray, "rows columns"]:
        return _noise(shape, size_mm, shortest_px * pixel_mm, longest_px * pixel_mm, rng)

    ring = noise(_SHORTEST_PX, _LONGEST_PX)
    dark = _without_specks(ring - np.quantile(ring, 1 - _DARK_SHARE), pixel_mm / step_mm)
    under = noise(1.6 * _SHORTEST_PX, 1.6 * _LONGEST_PX)
    pale = _without_specks(under - np.quantile(under, 1 - _PALE_SHARE), pixel_mm / step_mm)
    inks: list[Ink] = []
    for field, colours in ((pale, _PALE), (dark, _DARK)):
        patches = np.array([noise(_PATCH_PX, 2 * _PATCH_PX) for _ in colours])
        islands, count = _islands(field > 0)
        chosen = _chosen(patches, islands, count)
        for k, colour in enumerate(colours):
            others = (islands > 0) & (chosen[islands] != k)
            inks.append(Ink(colour=colour, field=np.where(others, -field, field)))
    return SockPattern(
        width_mm=width_mm, height_mm=height_mm, pixel_mm=pixel_mm, seed=seed, inks=tuple(inks)
    )


def draw_sock(
    page: PageName, pixel_mm: float, seed: int = 0, distance_mm: float | None = None
) -> Sheet:
    """Two pages: a tile with rulers, and the bare tile to repeat on fabric.

    Args:
        distance_mm: From which the camera shows such pixels; only said on the sheet.
    """
    paper = Paper(page, upright=True)
    width, height = (_TILE_STEP_MM * (paper.room_mm // _TILE_STEP_MM)).tolist()
    pattern = sock_pattern(width, height, pixel_mm, seed)
    bare = Paper.of_size(page, width, height)
    _draw(paper, pattern, EDGE_MM, float(paper.origin_mm[1]))
    _draw(bare, pattern, 0.0, 0.0)
    where = "" if distance_mm is None else f", from {distance_mm:.0f} mm"
    title = (
        f"sock pattern for pixels of {pixel_mm:.3g} mm{where}: spots of "
        f"{pattern.speckle_mm:.3g} mm, number {seed}"
    )
    advice = (
        f"The tile of {width:g} x {height:g} mm goes on without a seam on all sides; page 2 is the "
        "tile alone, to repeat on fabric.",
    )
    down_mm = paper.frame(title, (width, height), advice)
    return Sheet(
        title=title,
        page=page,
        width_mm=paper.width_mm,
        height_mm=paper.height_mm,
        ruler_mm=float(paper.ruler_mm),
        ruler_down_mm=float(down_mm),
        square_mm=float(paper.square_mm),
        pdf=pdf_of([paper, bare], title),
    )


def _noise(
    shape: tuple[int, int],
    size_mm: tuple[float, float],
    shortest_mm: float,
    longest_mm: float,
    rng: np.random.Generator,
) -> Float64[np.ndarray, "rows columns"]:
    """Gaussian noise on a torus, with a flat spectrum between two wavelengths, zero elsewhere."""
    rows = np.fft.fftfreq(shape[0], size_mm[0] / shape[0])
    columns = np.fft.rfftfreq(shape[1], size_mm[1] / shape[1])
    frequency = np.hypot(rows[:, None], columns)
    ring = (frequency >= 1 / longest_mm) & (frequency <= 1 / shortest_mm)
    spectrum = np.fft.rfft2(rng.standard_normal(shape)) * ring
    field = np.fft.irfft2(spectrum, shape)
    return field / field.std()


def _without_specks(
    field: Float64[np.ndarray, "rows columns"], nodes_a_pixel: float
) -> Float64[np.ndarray, "rows columns"]:
    """The field without islands and gaps that the camera cannot resolve."""
    least = np.pi / 4 * (_FINEST_PX * nodes_a_pixel) ** 2
    for sign in (1.0, -1.0):
        islands, count = _islands(sign * field > 0)
        small = np.bincount(islands.ravel(), minlength=count + 1) < least
        small[0] = False
        field = np.where(small[islands], -field, field)
    return field


def _islands(
    mask: Bool[np.ndarray, "rows columns"],
) -> tuple[Int32[np.ndarray, "rows columns"], int]:
    """Labels, from 1, of the connected components on the torus, and the largest label."""
    found, count = cast(tuple[Int32[np.ndarray, "rows columns"], int], label(mask))
    numbers = np.arange(count + 1)
    pairs = [(found[0], found[-1]), (found[:, 0], found[:, -1])]
    for one, other in pairs:
        for a, b in zip(one.tolist(), other.tolist(), strict=True):
            if a and b:
                low, high = sorted((_root(numbers, a), _root(numbers, b)))
                numbers[high] = low
    roots = np.array([_root(numbers, k) for k in range(count + 1)], np.int32)
    return roots[found], count


def _root(numbers: np.ndarray, k: int) -> int:
    while numbers[k] != k:
        k = int(numbers[k])
    return k


def _chosen(
    patches: Float64[np.ndarray, "k rows columns"],
    islands: Int32[np.ndarray, "rows columns"],
    count: int,
) -> Int32[np.ndarray, " islands"]:
    """For each island the colour whose noise has the largest sum on it."""
    sums = [np.bincount(islands.ravel(), one.ravel(), minlength=count + 1) for one in patches]
    return np.argmax(sums, axis=0).astype(np.int32)


def _draw(paper: Paper, pattern: SockPattern, left_mm: float, top_mm: float) -> None:
    """Draw the tile as outlines, cut straight at its edges."""
    for ink in pattern.inks:
        rows, columns = ink.field.shape
        closed = np.pad(ink.field, ((0, 1), (0, 1)), mode="wrap")
        x = left_mm + np.linspace(0, pattern.width_mm, columns + 1)
        y = top_mm + np.linspace(0, pattern.height_mm, rows + 1)
        lines = contour_generator(x, y, closed, fill_type=FillType.OuterOffset)
        filled = cast(tuple[list[np.ndarray], list[np.ndarray]], lines.filled(0.0, np.inf))
        points, offsets = filled
        if not points:
            continue
        outlines = [
            outline[start:stop]
            for outline, cuts in zip(points, offsets, strict=True)
            for start, stop in pairwise(cuts.tolist())
        ]
        codes = np.concatenate([_codes(len(one)) for one in outlines])
        colour = "#{:02x}{:02x}{:02x}".format(*ink.colour)
        paper.fill_outlines(np.concatenate(outlines), codes, colour)


def _codes(count: int) -> UInt8[np.ndarray, " n"]:
    from matplotlib.path import Path as Outline

    codes = np.full(count, Outline.LINETO, np.uint8)
    codes[0], codes[-1] = Outline.MOVETO, Outline.CLOSEPOLY
    return codes
