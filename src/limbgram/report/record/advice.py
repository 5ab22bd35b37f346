"""Advice: what a professional should check or know before anything is made from the shape."""

from collections.abc import Iterator
from dataclasses import replace

from limbgram.core.errors import with_full_stop
from limbgram.core.tape import AGREES_SIGMAS, READING_SIGMA_MM
from limbgram.findings import Finding, Gravity, doubt, fault, note, told
from limbgram.report.record.content import CaseCited, Content, Json, RecipeDone
from limbgram.report.record.sources import SAME_MM
from limbgram.workbench.edits.pressing import LEAST_PRESSURE_MM
from limbgram.workbench.edits.wall import LEAST_WALL_MM
from limbgram.workbench.frame.landmarks import unconfirmed_finding
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import Measures

_FILLED_SHARE = 0.01
_ORDER = tuple(reversed(Gravity))
APART_MM = AGREES_SIGMAS * READING_SIGMA_MM
"""How far a tape may be off where the limb does not taper."""


def findings(content: Content, measures: Measures) -> tuple[Finding, ...]:
    """The findings of a record, the grave ones first."""
    proposed = unconfirmed_finding(measures.limb)
    red = _red_findings(measures.limb)
    said = set(map(told, red))
    found = (
        *red,
        *(() if proposed is None else (proposed,)),
        *_recipe_findings(content.recipe),
        *((fault("record.case.untold"),) if content.case_untold else ()),
        *_case_findings(content.case),
        *_surface_findings(measures),
        *_tape_findings(content),
        *_comparison_findings(content.comparison),
        *(
            note("record.file", said=with_full_stop(one))
            for one in content.notes
            if one not in said
        ),
    )
    return tuple(sorted(found, key=lambda one: _ORDER.index(one.gravity)))


def tape_checks(content: Content) -> tuple[tuple[float, float], ...]:
    """Three heights from the reference and the tape girths there, lowest first.

    Of a wall they are those of its inside, which the limb fills.
    """
    taped = content.measures if content.inside is None else content.inside
    rows = [row for row in taped["levels"] if row["tape_mm"] is not None]
    picked = {round(share * (len(rows) - 1)) for share in (0.25, 0.5, 0.75)} if rows else set()
    return tuple(
        (rows[idx]["from_reference_mm"], rows[idx]["tape_mm"]["value"]) for idx in sorted(picked)
    )


def _red_findings(limb: Limb) -> tuple[Finding, ...]:
    """The note that a shape comes from a capture with a red verdict, as the fault that it is."""
    codes = set() if limb.doubt is None else {limb.doubt.code}
    return tuple(replace(one, gravity=Gravity.FAULT) for one in limb.notes if one.code in codes)


def _tape_findings(content: Content) -> Iterator[Finding]:
    compared = [one for one in content.tape if not one.withdrawn and one.measured_mm is not None]
    for one in compared:
        if one.conflict:
            judge = doubt if one.accepted else fault
            yield judge(
                "record.tape.conflict",
                height_mm=one.height_mm,
                read_mm=one.read_mm,
                measured_mm=one.measured_mm,
                within_mm=one.within_mm,
                accepted=one.accepted,
            )
    checks = tape_checks(content)
    if checks and not compared:
        yield doubt(
            "record.tape.none",
            girths=tuple(
                note("record.tape.to_read", height_mm=height, girth_mm=girth)
                for height, girth in checks
            ),
            reference=content.measures["reference"],
            apart_mm=APART_MM,
        )


def _surface_findings(measures: Measures) -> Iterator[Finding]:
    limb = measures.limb
    if not limb.sock_mm:
        yield doubt("record.surface.no_sock")
    if limb.mesh.sigma_mm is None:
        yield doubt("record.surface.no_sigma")
    wall = measures.wall
    if wall is not None:
        judge = fault if wall.thinnest_mm < LEAST_WALL_MM else note
        yield judge(
            "record.surface.wall",
            thinnest_mm=wall.thinnest_mm,
            median_mm=wall.median_mm,
            place_in_limb_mm=tuple(wall.place_mm.tolist()),
            least_mm=LEAST_WALL_MM,
        )
    filled = limb.mesh.filled_share()
    if filled > _FILLED_SHARE:
        yield fault("record.surface.filled", share=filled)
    missing = sum(row.level is None for row in measures.rows)
    if missing:
        yield doubt("record.surface.no_girths", missing=missing, levels=len(measures.rows))
    if measures.others_note is not None:
        yield doubt("record.surface.beside", others=measures.others_note)


def _recipe_findings(recipe: RecipeDone | None) -> Iterator[Finding]:
    if recipe is None:
        return
    yield from _pressure_findings(recipe)
    for one in recipe.notes:
        yield doubt("record.recipe.note", said=one)
    if recipe.apart_mm is not None and recipe.apart_mm > SAME_MM:
        yield fault("record.recipe.apart", apart_mm=recipe.apart_mm)


def _pressure_findings(recipe: RecipeDone) -> Iterator[Finding]:
    """Findings of loads on sensitive places, of great depths, and of all edits together there."""
    for line in recipe.lines:
        for concern in line.concerns:
            if not concern.word:
                continue
            yield fault(
                "record.recipe.concern",
                number=line.number,
                what=concern.finding,
                accepted=concern.accepted,
                word=concern.word,
            )
    pressed = {
        name: -moved for name, moved in recipe.places_mm.items() if moved < -LEAST_PRESSURE_MM
    }
    if pressed:
        yield doubt(
            "record.recipe.pressed",
            places=tuple(
                note("record.recipe.pressed_place", place=name, depth_mm=depth)
                for name, depth in pressed.items()
            ),
        )


def _case_findings(case: CaseCited | None) -> Iterator[Finding]:
    if case is None:
        return
    for one in case.setups:
        yield one.finding
    if not case.delivered:
        yield fault("record.case.not_its_file")
    if case.light != "green":
        judge = fault if case.light == "red" else doubt
        yield judge("record.case.light", light=case.light)


def _comparison_findings(comparison: Json | None) -> Iterator[Finding]:
    for one in () if comparison is None else comparison["notes"]:
        yield doubt("record.comparison", said=Finding.from_tree(one))
