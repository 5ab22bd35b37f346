"""Printed sheets: every kind drawn, rasterised by another program, and measured back."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pypdfium2
import pytest
from scipy.ndimage import distance_transform_edt

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.coded import draw_stickers
from limbgram.formats.sheets.kinds import KINDS, SheetOptions
from limbgram.formats.sheets.page import PageName, Sheet
from limbgram.formats.sheets.sock import SockPattern, sock_pattern
from limbgram.reconstruction.targets.marks import marks_in

DPI = 200
MM = 25.4 / DPI
COARSE = SheetOptions(pixel_mm=0.5)
NAMES = [kind.name for kind in KINDS]
CODED = ["scale-bars", "mat", "ring", "stickers"]


@cache
def drawn(name: str, page: PageName) -> Sheet:
    return next(kind for kind in KINDS if kind.name == name).draw(page, COARSE)


@cache
def picture(name: str, page: PageName, number: int = 0) -> np.ndarray:
    """One page of a sheet."""
    document = pypdfium2.PdfDocument(drawn(name, page).pdf)
    return document[number].render(scale=DPI / 72, grayscale=True).to_numpy().squeeze()


def words(name: str, page: PageName) -> str:
    return pypdfium2.PdfDocument(drawn(name, page).pdf)[0].get_textpage().get_text_range()


def middles(line: np.ndarray) -> np.ndarray:
    """Middles of the dark strokes along a line of pixels, px."""
    dark = 255.0 - line
    marked = np.flatnonzero(dark > 12)
    groups = np.split(marked, np.flatnonzero(np.diff(marked) > 1) + 1)
    return np.array([np.average(group, weights=dark[group]) for group in groups])


@pytest.mark.parametrize(
    ("name", "page"),
    [
        *((name, "a4") for name in NAMES),
        ("ring", "letter"),
        *(pytest.param(one, "letter", marks=pytest.mark.slow) for one in NAMES if one != "ring"),
    ],
)
def test_every_sheet_has_a_true_ruler_and_says_what_it_is(name: str, page: PageName) -> None:
    sheet, shown = drawn(name, page), picture(name, page)
    step = np.array([sheet.width_mm, sheet.height_mm]) / shown.shape[::-1]
    best = 0.0
    for line in shown[: shown.shape[0] // 2 : -1]:
        if np.count_nonzero(line < 243) < sheet.ruler_mm:
            continue
        at = middles(line) * step[0]
        if len(at) == sheet.ruler_mm + 1 and np.abs(np.diff(at) - 1).max() < 0.06:
            best = at[-1] - at[0]
            break
    assert best == pytest.approx(sheet.ruler_mm, abs=0.02)
    told = " ".join(words(name, page).split())
    assert f"limbgram {sheet.title.partition(' of ')[0]}" in told  # a mat has a title a sheet
    assert f"--measured-mm {sheet.ruler_mm:g}.0" in told
    assert f"{sheet.square_mm:g} mm" in told
    assert sheet.square_mm >= 10


@pytest.mark.parametrize(
    ("name", "page", "down_to_mm"),
    [
        *((name, "a4", 1000.0) for name in CODED if name != "stickers"),
        ("stickers", "a4", 63.0),  # two of its ten rows
        *(pytest.param(one, "letter", 1000.0, marks=pytest.mark.slow) for one in CODED),
    ],
)
def test_every_mark_is_printed_where_the_file_says(
    name: str, page: PageName, down_to_mm: float
) -> None:
    sheet = drawn(name, page)
    expected = {
        one.mark_id: (one.x_mm, one.y_mm)
        for plate in sheet.plates
        for one in plate.marks
        if one.y_mm < down_to_mm
    }
    assert len(expected) > 5
    found: dict[int, np.ndarray] = {}
    for number in range(len(pypdfium2.PdfDocument(sheet.pdf))):
        shown = picture(name, page, number)
        step = np.array([sheet.width_mm, sheet.height_mm]) / shown.shape[::-1]
        looked_at = shown[: round(down_to_mm / step[1])]
        for mark in marks_in(cv2.GaussianBlur(looked_at, (0, 0), 0.8)):
            assert mark.fit is not None, mark.doubt
            assert not mark.fit.bent
            found[mark.mark_id] = (mark.fit.centre_px + 0.5) * step
    assert found.keys() == expected.keys()
    off = np.array([found[one] - expected[one] for one in expected])
    assert 0 < np.abs(off).max() < 0.02


def test_scale_bars_lie_as_close_as_scissors_need() -> None:
    """On a landscape A4 page four bars of 28 mm, with 5 mm between them."""
    sheet = drawn("scale-bars", "a4")
    heights = sorted({round(plate.marks[0].y_mm, 3) for plate in sheet.plates})
    assert len(heights) == 4
    np.testing.assert_allclose(np.diff(heights), 33.0)


@pytest.mark.parametrize(
    ("name", "page", "plates", "marks", "side_mm", "across_mm", "down_mm"),
    [
        ("scale-bars", "a4", 4, 2, 20.0, 220.0, 0.0),
        ("mat", "a4", 4, 6, 40.0, 114.0, 189.0),
        ("mat", "a2", 1, 16, 40.0, 498.0, 312.0),
        ("ring", "a4", 1, 12, 20.0, 134.0, 134.0),
        ("stickers", "a4", 80, 1, 12.0, 0.0, 0.0),
    ],
)
def test_a_page_holds_what_it_has_room_for(
    name: str, page: PageName, plates: int, marks: int, side_mm: float, across_mm: float,
    down_mm: float,
) -> None:  # fmt: skip
    """Beside 12 mm of white all round, 9 mm for the name above, 25 mm for ruler and words below,
    and 22 mm for the ruler at the right."""
    sheet = drawn(name, page)
    assert len(sheet.plates) == plates
    for plate in sheet.plates:
        places = np.array([(one.x_mm, one.y_mm) for one in plate.marks])
        assert (len(plate.marks), plate.side_mm) == (marks, side_mm)
        np.testing.assert_allclose(np.ptp(places, axis=0), (across_mm, down_mm), atol=0.1)


def test_no_two_kinds_share_a_mark() -> None:
    ids = [
        {one.mark_id for plate in drawn(name, "a4").plates for one in plate.marks} for name in CODED
    ]
    assert len(set.union(*ids)) == sum(map(len, ids))


def test_stickers_that_cannot_be_read_are_refused() -> None:
    with pytest.raises(OptionsError, match="3 mm from number 0"):
        draw_stickers("a4", 3.0)
    assert [one.marks[0].mark_id for one in draw_stickers("a4", 12.0, 95).plates] == [
        95,
        96,
        97,
        98,
        99,
    ]


@pytest.fixture(scope="module")
def pattern() -> SockPattern:
    return sock_pattern(80.0, 100.0, 0.5, seed=3)


def barest_mm(pattern: SockPattern) -> float:
    """Diameter of the largest circle without an edge between dark and light."""
    rows, columns = pattern.dark.shape
    wide = np.pad(pattern.dark, ((rows // 2, rows // 2), (columns // 2, columns // 2)), "wrap")
    farthest = max(np.max(distance_transform_edt(area)) for area in (wide, ~wide))
    return 2 * farthest * pattern.width_mm / columns


def test_the_sock_leaves_nothing_bare_and_nothing_too_fine(pattern: SockPattern) -> None:
    dark = pattern.dark
    assert 0.33 < dark.mean() < 0.45
    assert 2.5 < barest_mm(pattern) < 3.5 * pattern.speckle_mm
    step_mm = pattern.pixel_mm / 5
    y, x = np.mgrid[0:40:step_mm, 0:40:step_mm]
    colours = pattern.colours_at(x.ravel(), y.ravel()).reshape(*x.shape, 3)
    inked = (colours.astype(int).sum(2) < 300).astype(np.uint8)
    two_pixels = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (10, 10))
    for area in (inked, 1 - inked):
        kept = cv2.morphologyEx(area, cv2.MORPH_OPEN, two_pixels)
        assert 0.0 < 1 - kept.sum() / area.sum() < 0.06  # finer than two pixels


def test_the_sock_is_like_itself_in_one_place_only(pattern: SockPattern) -> None:
    dark = pattern.dark - pattern.dark.mean()
    likeness = np.fft.ifft2(np.abs(np.fft.fft2(dark)) ** 2).real
    likeness /= likeness[0, 0]
    y, x = np.indices(dark.shape)
    y, x = np.minimum(y, dark.shape[0] - y), np.minimum(x, dark.shape[1] - x)
    away_mm = np.hypot(y, x) * pattern.width_mm / dark.shape[1]
    half_mm = away_mm[likeness > 0.5].max()
    assert 0.2 * pattern.speckle_mm < half_mm < 0.6 * pattern.speckle_mm
    assert likeness[away_mm > 6 * pattern.speckle_mm].max() < 0.2


def test_the_sock_goes_on_without_a_seam(pattern: SockPattern) -> None:
    y = np.linspace(0, pattern.height_mm, 3000)
    for shift in (pattern.width_mm, -pattern.width_mm):
        first = pattern.colours_at(np.full(3000, 1e-3), y)
        assert (first == pattern.colours_at(np.full(3000, 1e-3 + shift), y)).all(1).mean() > 0.999
    left = pattern.colours_at(np.full(3000, 0.0), y).astype(int)
    before = pattern.colours_at(np.full(3000, pattern.width_mm - 0.05), y).astype(int)
    assert (left == before).all(1).mean() > 0.9
    assert 0.02 < (left == np.roll(left, 700, axis=0)).all(1).mean() < 0.5


def test_a_printed_tile_joins_the_next(pattern: SockPattern) -> None:
    bare = picture("sock", "a4", 1).astype(float)
    across = np.abs(bare[:, 0] - bare[:, -1])
    inside = np.abs(bare[:, 500] - bare[:, 501])
    assert across.mean() < 2 * inside.mean() + 1
    assert np.abs(bare[:, 0] - bare[:, 300]).mean() > 3 * across.mean()
    assert pattern.seed == 3


def test_a_sock_says_from_where_it_is_to_be_seen() -> None:
    draw = next(one.draw for one in KINDS if one.name == "sock")
    assert "pixels of 0.5 mm, from 600 mm: " in draw("a4", replace(COARSE, distance_mm=600.0)).title
    assert "pixels of 0.5 mm: " in drawn("sock", "a4").title


def test_each_board_says_what_it_is_for() -> None:
    titles = {one.name.value: drawn(one.name, "a4").title for one in KINDS[:2]}
    assert titles["scale-board"].startswith("scale board: ChArUco board of 7 x 5 squares of 30 mm")
    assert titles["checkerboard"].startswith("calibration board: checkerboard of 14 x 10")


def test_pixels_that_suit_no_sock_are_refused() -> None:
    with pytest.raises(OptionsError, match="suits no sock"):
        sock_pattern(80.0, 80.0, 5.0)
    with pytest.raises(OptionsError, match="too small"):
        sock_pattern(20.0, 80.0, 0.5)
