"""The record: everything that is kept of a shape, with pictures.

In      an aligned shape; another one to compare it with, the recipe it was made by, the case of
        its scan, as far as there are any.
Out     a Record: its content in mm and mL, and pictures. No name of a file, folder, recipe or
        person is in it: see sources.
Fails   MeasureError: the shape is not aligned. OptionsError: the recipe belongs to neither shape.
"""

import platform
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from limbgram.core.typed import tree_of
from limbgram.findings import told
from limbgram.report.drawings.differences import difference_pictures
from limbgram.report.drawings.drawing import Drawing, Picture, png
from limbgram.report.drawings.sections import sections_drawing
from limbgram.report.drawings.wall_thickness import wall_map
from limbgram.report.record.advice import findings
from limbgram.report.record.bias import biases
from limbgram.report.record.content import (
    CaseCited,
    Content,
    Mark,
    RecipeDone,
    SourceFile,
    TapeRead,
)
from limbgram.report.record.sources import (
    CaseSource,
    RecipeSource,
    ReplayedRecipe,
    ShapeSource,
    printed_names,
    replayed_on,
    text_with_printed_names,
    with_printed_names,
)
from limbgram.report.record.views import four_sides_of_limb
from limbgram.workbench.bodies import outside_of
from limbgram.workbench.compare.comparison import CompareOptions, Comparison, compare
from limbgram.workbench.compare.messages import comparison_tree
from limbgram.workbench.compare.registration import RegistrationOptions, Way
from limbgram.workbench.edits.closing import enclosure_finding
from limbgram.workbench.limb import KIND_NAMED, AlignedLimb, Limb
from limbgram.workbench.measures.form import sheet_tree
from limbgram.workbench.measures.measured_skin import inner_faces
from limbgram.workbench.measures.measuring import (
    LimbMeasureOptions,
    Measures,
    measure_inside,
    measure_limb,
)
from limbgram.workbench.measures.sheet import measuring_sheet
from limbgram.workbench.measures.table import tree as measures_tree

_LIBRARIES = ("limbgram", "numpy", "scipy", "numba", "trimesh")


@dataclass(frozen=True, kw_only=True)
class RecordOptions:
    """What a record shows."""

    spacing_mm: float = 20.0
    """Of the levels."""
    reference: str | None = None
    """Landmark from which heights count; None for the distal end."""
    case_id: str = ""
    """Under which the case is kept; nothing that names a person."""
    case_untold: bool = False
    """The case was computed, and what it says of its own accuracy cannot be cited."""
    tape: tuple[TapeRead, ...] = ()
    """What was read by tape."""
    way: Way | None = None
    """How the other shape is laid on; None: limb frame on limb frame if the recipe is for it, else
    by shape."""


DEFAULTS = RecordOptions()


@dataclass(frozen=True, kw_only=True)
class Record:
    """What page and PDF are made of."""

    content: Content
    pictures: tuple[Picture, ...]
    """The four sides first, then the differences, or the sections where nothing was compared."""

    @cached_property
    def tree(self) -> dict[str, Any]:
        """What report.json holds."""
        return tree_of(self.content)


def record_of(
    shape: ShapeSource,
    against: ShapeSource | None = None,
    recipe: RecipeSource | None = None,
    case: CaseSource | None = None,
    options: RecordOptions = DEFAULTS,
) -> Record:
    """Measure, compare and replay what is named, and put it together."""
    printed = printed_names(recipe, shape, against)
    nameless_shape = with_printed_names(shape, printed)
    nameless_shape = replace(nameless_shape, limb=outside_of(nameless_shape.limb))
    other = None if against is None else with_printed_names(against, printed)
    reference = options.reference and printed.get(options.reference, options.reference)
    options_of_levels = LimbMeasureOptions(spacing_mm=options.spacing_mm, reference=reference)
    measures = measure_limb(nameless_shape.limb, options_of_levels)
    done = None if recipe is None else replayed_on(recipe, shape, against)
    inside = _measures_inside(nameless_shape.limb, measures, options_of_levels)
    compared = None if other is None else _compare(nameless_shape, other, done, options)
    limb = nameless_shape.limb.aligned().in_limb_frame()
    mesh = limb.mesh
    ledger = None if done is None else done.ledger
    with ThreadPoolExecutor(1) as beside:  # both are loops outside the interpreter, for the most
        steps = beside.submit(biases, measures, mesh, case, ledger, inside)
        pictures = _pictures(limb, measures, compared)
        lines = steps.result()
    content = Content(
        id=nameless_shape.id,
        side=limb.side,
        size_mm=tuple(np.ptp(mesh.vertices_mm, axis=0).tolist()),
        triangles=len(mesh.faces),
        notes=(*map(told, nameless_shape.limb.notes), told(enclosure_finding(mesh))),
        measures=measures_tree(measures),
        sheet=_sheet(measures.limb),
        inside=None if inside is None else measures_tree(inside),
        landmarks=tuple(
            Mark(
                name=mark.name,
                in_limb_mm=tuple(mark.position_mm.tolist()),
                confirmed=mark.confirmed,
            )
            for mark in limb.landmarks
        ),
        comparison=None if compared is None else comparison_tree(compared),
        recipe=None if done is None else _recipe(done, printed),
        case=None if case is None else _case(case, shape, against),
        case_untold=options.case_untold,
        case_id=options.case_id,
        tape=options.tape,
        bias=lines,
        files=tuple(_files(shape, against, recipe, case)),
        versions={
            **{name: version(name) for name in _LIBRARIES},
            "python": platform.python_version(),
        },
    )
    return Record(content=replace(content, findings=findings(content, measures)), pictures=pictures)


def _measures_inside(limb: Limb, outside: Measures, options: LimbMeasureOptions) -> Measures | None:
    """The inside of a wall; None of another shape, and where too little of the wall goes round."""
    if outside.skin != "outside" or not inner_faces(outside.outer_mesh).any():
        return None
    return measure_inside(limb, options)


def _compare(
    shape: ShapeSource, other: ShapeSource, done: ReplayedRecipe | None, options: RecordOptions
) -> Comparison:
    """The shape less the other one."""
    way: Way = "as-is" if done is not None and done.apart_mm is not None else "auto"
    return compare(
        other.limb,
        shape.limb,
        CompareOptions(
            registration=RegistrationOptions(way=options.way or way),
            spacing_mm=options.spacing_mm,
        ),
    )


def _pictures(
    limb: AlignedLimb, measures: Measures, compared: Comparison | None
) -> tuple[Picture, ...]:
    """What is drawn of a limb in its own frame."""
    drawings = [("sides", "The shape from four sides", four_sides_of_limb(limb))]
    if compared is not None:
        drawings.append(("differences", "What differs", difference_pictures(compared)))
    elif any(row.level is not None for row in measures.rows):
        drawings.append(("sections", "Sections at the levels", sections_drawing(measures)))
    if measures.wall is not None:
        drawings.append(("wall", "How thick the wall is", wall_map(limb.mesh, measures.wall)))
    return tuple(_picture(*drawing) for drawing in drawings)


def _sheet(limb: Limb) -> dict[str, Any] | None:
    """The measuring sheet of a limb whose kind has one, and whose side is known."""
    if limb.kind is None or not KIND_NAMED[limb.kind].sheet or limb.anatomy.left is None:
        return None
    return sheet_tree(measuring_sheet(limb))


def _recipe(done: ReplayedRecipe, printed: Mapping[str, str]) -> RecipeDone:
    """The ledger; its edits name landmarks as the record does."""
    return RecipeDone(
        id=done.recipe.id,
        scan=done.scan.id,
        apart_mm=done.apart_mm,
        notes=tuple(map(told, (*done.recipe.recipe.notes, *done.told))),
        levels_mm=done.ledger.levels_mm,
        places_mm=done.ledger.places_mm,
        lines=tuple(
            replace(
                line,
                edit=text_with_printed_names(line.edit, printed),
                told=tuple(
                    one.with_texts(lambda name: printed.get(name, name)) for one in line.told
                ),
            )
            for line in done.ledger.lines
        ),
    )


def _case(case: CaseSource, shape: ShapeSource, against: ShapeSource | None) -> CaseCited:
    hashes = {source.sha256 for source in (shape, against) if source is not None}
    lengths = case.accuracy.lengths
    return CaseCited(
        id=case.id,
        light=case.accuracy.light,
        headline=told(case.accuracy.headline),
        delivered=bool(hashes & case.files),
        check_lengths=len(lengths.check),
        check_worst=lengths.check_worst,
        expected_p95_mm=case.accuracy.expected.p95_mm,
        setups=case.accuracy.setups,
    )


def _files(
    shape: ShapeSource,
    against: ShapeSource | None,
    recipe: RecipeSource | None,
    case: CaseSource | None,
) -> Iterator[SourceFile]:
    """Every file the record stands on, by hash."""
    for what, source in (("shape", shape), ("compared with", against)):
        if source is None:
            continue
        yield SourceFile(what=what, id=source.id, kind=source.kind, sha256=source.sha256)
        if source.limb_file_sha256 is not None:
            sha256 = source.limb_file_sha256
            yield SourceFile(what="its limb file", id=source.id, kind="JSON", sha256=sha256)
    if recipe is not None:
        yield SourceFile(what="recipe", id=recipe.id, kind="TOML", sha256=recipe.sha256)
    if case is not None:
        yield SourceFile(what="case", id=case.id, kind="JSON", sha256=case.sha256)


def _picture(name: str, title: str, drawing: Drawing) -> Picture:
    return Picture(name, title, drawing.caption, png(drawing.figure))
