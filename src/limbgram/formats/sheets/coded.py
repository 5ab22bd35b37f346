"""Sheets with coded marks: scale bars, floor mats, a turntable ring, stickers.

In      a page, and for stickers their first number and their size.
Out     a Sheet whose plates have the positions of its marks. Kinds do not share numbers, so that
        all of them may lie in one scene.
Limits  lengths are known within a plate only: each of several taped sheets is a plate, and how they
        are taped does not matter.
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import OptionsError
from limbgram.formats.sheets.page import PageName, Paper, Sheet, pdf_of, rectangle, runs
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, marker_dictionary
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark

STICKER_IDS = range(100)
_BAR_IDS = range(100, 140)
_RING_IDS = range(140, 180)
_MAT_IDS = range(200, 400)
STICKER_MM = 12.0
_BAR_MARK_MM = 20.0
_BAR_HIGH_MM = 28.0
_BAR_STEP_MM = 33.0
_MAT_MARK_MM = 40.0
_MAT_SHEETS = 4
_MAT_PITCH_MM = 95.0
_RING_MARK_MM = 20.0
_RING_COUNT = 12
_STIFF = "Print at 100 % (actual size), on matt paper, and glue it flat on a stiff plate."
_STICKERS_MM = (6.0, 40.0)
"""Sides of stickers that can be read and stick to a limb."""


def draw_bars(page: PageName) -> Sheet:
    """Scale bars to cut out, as long as the page allows, each with a mark at either end."""
    paper = Paper(page, upright=False)
    length_mm = 10.0 * ((float(paper.room_mm[0]) - _BAR_HIGH_MM) // 10)
    count = min(int(paper.room_mm[1] // _BAR_STEP_MM), len(_BAR_IDS) // 2)
    plates: list[MarkPlate] = []
    for k in range(count):
        first, last = _BAR_IDS[2 * k], _BAR_IDS[2 * k + 1]
        corner = paper.origin_mm + np.array([0, k * _BAR_STEP_MM])
        middle = corner + _BAR_HIGH_MM / 2
        marks = (
            PrintedMark(mark_id=first, x_mm=float(middle[0]), y_mm=float(middle[1])),
            PrintedMark(mark_id=last, x_mm=float(middle[0]) + length_mm, y_mm=float(middle[1])),
        )
        plate = MarkPlate(name=f"scale bar {k + 1}", side_mm=_BAR_MARK_MM, marks=marks)
        _draw(paper, plate)
        paper.cut_line(corner.tolist(), (length_mm + _BAR_HIGH_MM, _BAR_HIGH_MM))
        words = f"{plate.name}: marks {first} and {last}, {length_mm:g} mm between their middles"
        paper.write(middle[0] + length_mm / 2, middle[1] + 1, words, 8, align="center")
        plates.append(plate)
    title = (
        f"scale bars of {length_mm:g} mm, marks of {_BAR_MARK_MM:g} mm from {KIT_DICTIONARY}, "
        f"{_BAR_IDS[0]} to {_BAR_IDS[2 * count - 1]}"
    )
    advice = (
        f"{_STIFF} Cut the bars out, and lay two beside the limb, on either side.",
        f"What counts is the distance between the middles: {length_mm:g} mm as drawn.",
    )
    size = (float(paper.room_mm[0]), count * _BAR_STEP_MM)
    return _sheet(title, [paper], [paper.frame(title, size, advice)], plates)


def draw_mat(page: PageName) -> Sheet:
    """A floor mat: on large pages one plate round a free middle, else several sheets to tape."""
    if min(Paper(page, upright=True).room_mm) >= 3 * _MAT_PITCH_MM:
        return _large_mat(page)
    papers: list[Paper] = []
    plates: list[MarkPlate] = []
    downs: list[int] = []
    for number in range(_MAT_SHEETS):
        paper = Paper(page, upright=True)
        room = paper.room_mm
        columns, rows = 2, 2 + int(room[1] >= 2.4 * _MAT_PITCH_MM)
        half = _MAT_MARK_MM * 0.625
        x = np.linspace(half, room[0] - half, columns) + paper.origin_mm[0]
        y = np.linspace(half, room[1] - half, rows) + paper.origin_mm[1]
        first = _MAT_IDS[number * columns * rows]
        places = [(x[c], y[r]) for r in range(rows) for c in range(columns)]
        plate = _plate(f"floor mat, sheet {number + 1}", _MAT_MARK_MM, first, places)
        _draw(paper, plate, numbers=True)
        title = f"floor mat, sheet {number + 1} of {_MAT_SHEETS}: {_marks_in_words(plate)}"
        advice = (
            "Print at 100 % (actual size) and tape the sheets flat on the table round the limb.",
            "Distances on one sheet are known; how the sheets are taped does not matter.",
        )
        downs.append(paper.frame(title, room.tolist(), advice))
        papers.append(paper)
        plates.append(plate)
    title = f"floor mat of {_MAT_SHEETS} sheets, marks of {_MAT_MARK_MM:g} mm"
    return _sheet(title, papers, downs, plates)


def _large_mat(page: PageName) -> Sheet:
    paper = Paper(page, upright=False)
    room = paper.room_mm
    half = _MAT_MARK_MM * 0.625
    columns, rows = (max(2, int((side - 2 * half) // _MAT_PITCH_MM) + 1) for side in room)
    x = np.linspace(half, room[0] - half, columns) + paper.origin_mm[0]
    y = np.linspace(half, room[1] - half, rows) + paper.origin_mm[1]
    places = [
        (x[c], y[r])
        for r in range(rows)
        for c in range(columns)
        if r in (0, rows - 1) or c in (0, columns - 1)
    ]
    plate = _plate("floor mat", _MAT_MARK_MM, _MAT_IDS[0], places)
    _draw(paper, plate, numbers=True)
    middle = paper.origin_mm + room / 2
    radius_mm = float(room.min() / 2 - 2 * _MAT_MARK_MM)
    paper.circle(middle.tolist(), radius_mm)
    paper.write(middle[0], middle[1], "the limb stands here", 10, align="center")
    title = f"floor mat: {_marks_in_words(plate)}"
    advice = ("Print at 100 % and lay it flat; the limb stands in the circle.",)
    return _sheet(title, [paper], [paper.frame(title, room.tolist(), advice)], [plate])


def draw_ring(page: PageName) -> Sheet:
    """A ring of marks for a turntable: it is cut out and turns with what stands in it."""
    paper = Paper(page, upright=True)
    room = paper.room_mm
    outer_mm = float(room.min() / 2)
    radius_mm = outer_mm - 0.75 * _RING_MARK_MM
    middle = paper.origin_mm + outer_mm
    angles = 2 * np.pi * np.arange(_RING_COUNT) / _RING_COUNT
    places = [
        (middle[0] + radius_mm * np.sin(a), middle[1] - radius_mm * np.cos(a)) for a in angles
    ]
    plate = _plate("turntable ring", _RING_MARK_MM, _RING_IDS[0], places)
    _draw(paper, plate, turns_rad=angles.tolist())
    inner_mm = radius_mm - 0.75 * _RING_MARK_MM
    for radius in (outer_mm, inner_mm):
        paper.circle(middle.tolist(), radius)
    paper.fill(np.array([rectangle(-6, -0.05, 12, 0.1), rectangle(-0.05, -6, 0.1, 12)]) + middle)
    paper.write(middle[0], middle[1] - 9, "middle of the turntable", 7, align="center")
    title = f"turntable ring: {_marks_in_words(plate)}, on a circle of {2 * radius_mm:g} mm"
    advice = (
        _STIFF,
        "Cut along the circles and fix it on the turntable. Lay no still board beside it.",
    )
    down = paper.frame(title, (2 * outer_mm, 2 * outer_mm), advice)
    return _sheet(title, [paper], [down], [plate])


def draw_stickers(page: PageName, side_mm: float = STICKER_MM, first: int = 0) -> Sheet:
    """Numbered marks to stick on limb or sock, where landmarks are.

    Raises:
        OptionsError: the stickers have no size that can be read, or no number is left.
    """
    least_mm, most_mm = _STICKERS_MM
    if not least_mm <= side_mm <= most_mm or first not in STICKER_IDS:
        raise OptionsError(
            "export.sheet.stickers",
            least_mm=least_mm,
            most_mm=most_mm,
            first_id=STICKER_IDS[0],
            last_id=STICKER_IDS[-1],
            side_mm=side_mm,
            number=first,
        )
    paper = Paper(page, upright=True)
    room = paper.room_mm
    piece_mm = math.ceil(side_mm * 1.3) + 1.0
    step = np.array([piece_mm + 2, piece_mm + 5])
    columns, rows = (room // step).astype(int).tolist()
    count = min(columns * rows, STICKER_IDS[-1] + 1 - first)
    plates: list[MarkPlate] = []
    for k in range(count):
        corner = paper.origin_mm + step * (k % columns, k // columns)
        middle = corner + piece_mm / 2
        plate = _plate(f"sticker {first + k}", side_mm, first + k, [(middle[0], middle[1])])
        _draw(paper, plate)
        paper.cut_line(corner.tolist(), (piece_mm, piece_mm + 3))
        paper.write(middle[0], corner[1] + piece_mm + 2, f"{first + k}", 7, align="center")
        plates.append(plate)
    title = (
        f"stickers {first} to {first + count - 1}: marks of {side_mm:g} mm from {KIT_DICTIONARY}"
    )
    high_mm = float(step[1] * math.ceil(count / columns))
    advice = (
        "Print at 100 % (actual size) on matt sticker paper or transfer film. Cut along the lines:",
        "the white border belongs to the mark. Stick each where limb or sock is smooth.",
    )
    return _sheet(title, [paper], [paper.frame(title, (room[0], high_mm), advice)], plates)


def _sheet(
    title: str, papers: Sequence[Paper], downs_mm: Sequence[int], plates: Sequence[MarkPlate]
) -> Sheet:
    paper = papers[0]
    return Sheet(
        title=title,
        page=paper.page,
        width_mm=paper.width_mm,
        height_mm=paper.height_mm,
        ruler_mm=float(paper.ruler_mm),
        ruler_down_mm=float(downs_mm[0]),
        square_mm=float(paper.square_mm),
        pdf=pdf_of(papers, title),
        plates=tuple(plates),
    )


def _marks_in_words(plate: MarkPlate) -> str:
    ids = [one.mark_id for one in plate.marks]
    return f"marks {ids[0]} to {ids[-1]} of {plate.side_mm:g} mm from {plate.dictionary}"


def _plate(
    name: str, side_mm: float, first: int, places_mm: Sequence[tuple[float, float]]
) -> MarkPlate:
    return MarkPlate(
        name=name,
        side_mm=side_mm,
        marks=tuple(
            PrintedMark(mark_id=first + k, x_mm=float(x), y_mm=float(y))
            for k, (x, y) in enumerate(places_mm)
        ),
    )


def _draw(
    paper: Paper,
    plate: MarkPlate,
    *,
    turns_rad: Sequence[float] | None = None,
    numbers: bool = False,
) -> None:
    """Draw the marks of a plate at their places, each turned clockwise about its middle."""
    quads: list[Float64[np.ndarray, "k 4 2"]] = []
    for k, mark in enumerate(plate.marks):
        black = _black_cells(mark.mark_id)
        cell_mm = plate.side_mm / len(black)
        cells = [rectangle(start, row, end - start, 1) for row, start, end in runs(black)]
        local = np.array(cells) * cell_mm - plate.side_mm / 2
        turn = 0.0 if turns_rad is None else turns_rad[k]
        rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        quads.append(local @ rotation + (mark.x_mm, mark.y_mm))
        if numbers:
            below_mm = mark.y_mm + plate.side_mm * 0.625 + 3
            paper.write(mark.x_mm, below_mm, f"{mark.mark_id}", 6, align="center")
    paper.fill(np.concatenate(quads))


@cache
def _black_cells(mark_id: int) -> Bool[np.ndarray, "c c"]:
    codes = marker_dictionary(KIT_DICTIONARY)
    return codes.generateImageMarker(mark_id, codes.markerSize + 2) == 0
