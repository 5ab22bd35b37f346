"""Advice: what a professional should check or know before anything is made from the shape."""

from collections.abc import Iterator

from limbgram.core.errors import with_full_stop
from limbgram.core.tape import AGREES_SIGMAS, READING_SIGMA_MM
from limbgram.findings import advice, sentence, told
from limbgram.report.record.content import CaseCited, Content, Finding, Json, RecipeDone
from limbgram.report.record.sources import SAME_MM
from limbgram.workbench.edits.pressing import PRESSES_MM
from limbgram.workbench.edits.solids import LEAST_WALL_MM
from limbgram.workbench.measures.measuring import Measures

_FILLED_SHARE = 0.01
APART = f"More than {AGREES_SIGMAS * READING_SIGMA_MM:g} mm"
"""How far a tape may be off where the limb does not taper."""


def findings(content: Content, measures: Measures) -> tuple[Finding, ...]:
    """The grave ones first."""
    found = (
        *_about_recipe(content.recipe),
        *_about_case(content.case),
        *_about_surface(measures),
        *_by_tape(content),
        *_about_comparison(content.comparison),
        *(
            Finding(topic="file", what=with_full_stop(note), remedy="Look at the pictures.")
            for note in content.notes
        ),
    )
    return tuple(sorted(found, key=lambda one: one.gravity != "serious"))


def tape_checks(content: Content) -> tuple[tuple[float, float], ...]:
    """Three heights from the reference and the tape girths there, lowest first."""
    rows = [row for row in content.measures["levels"] if row["tape_mm"] is not None]
    picked = {round(share * (len(rows) - 1)) for share in (0.25, 0.5, 0.75)} if rows else set()
    return tuple(
        (rows[idx]["from_reference_mm"], rows[idx]["tape_mm"]["value"]) for idx in sorted(picked)
    )


def _by_tape(content: Content) -> Iterator[Finding]:
    compared = [one for one in content.tape if not one.withdrawn and one.measured_mm is not None]
    for one in compared:
        if one.conflict:
            accepted = f"; accepted {one.accepted}" if one.accepted else ""
            yield Finding(
                topic="tape",
                what=f"The tape read {one.read_mm:.1f} mm at {one.height_mm:g} mm, the scan has "
                f"{one.measured_mm:.1f} mm there: they contradict each other{accepted}.",
                remedy="Tape again, and measure a row of the board's squares, before anything is "
                "made.",
                gravity="mild" if one.accepted else "serious",
            )
    checks = tape_checks(content)
    if checks and not compared:
        girths = ", ".join(f"{girth:.0f} mm at {height:g} mm" for height, girth in checks)
        reference = content.measures["reference"]
        yield Finding(
            topic="tape",
            what="No tape reading has been compared with this shape here.",
            remedy=f"Read by tape before fabrication: {girths} (heights count from: {reference}). "
            f"{APART} apart: find out why first.",
        )


def _about_surface(measures: Measures) -> Iterator[Finding]:
    limb = measures.limb
    if not limb.sock_mm:
        yield Finding(
            topic="surface",
            what="No sock is recorded as taken off this shape.",
            remedy="If one was worn in the scan, its thickness is in every radius. Take it off "
            "with the edit `sock`, or with `measure --sock` for the figures alone.",
        )
    if limb.mesh.sigma_mm is None:
        yield Finding(
            topic="surface",
            what="The shape carries no uncertainty, so no figure has a ±.",
            remedy="PLY files of `limbgram reconstruct` carry it.",
        )
    wall = measures.wall
    if wall is not None:
        sentence = told(wall.told("limb"))
        yield Finding(
            topic="surface",
            what=f"{sentence[0].upper()}{sentence[1:]}.",
            remedy=f"Less than {LEAST_WALL_MM:g} mm is not made by printers of every kind; look at "
            "the map of the wall.",
            gravity="serious" if wall.thinnest_mm < LEAST_WALL_MM else "mild",
        )
    filled = 0.0 if limb.mesh.filled is None else float(limb.mesh.filled.mean())
    if filled > _FILLED_SHARE:
        yield Finding(
            topic="surface",
            what=f"{filled:.1%} of the surface was filled in, not measured.",
            remedy="It is orange in the pictures: rely on nothing there.",
            gravity="serious",
        )
    missing = sum(row.level is None for row in measures.rows)
    if missing:
        yield Finding(
            topic="surface",
            what=f"{missing} of {len(measures.rows)} levels have no girth.",
            remedy="The table says why.",
        )
    if measures.beside:
        yield Finding(
            topic="surface",
            what=measures.beside,
            remedy="If another one is meant, measure it by a landmark on it.",
        )


def _about_recipe(recipe: RecipeDone | None) -> Iterator[Finding]:
    if recipe is None:
        return
    yield from _about_pressure(recipe)
    for note in recipe.notes:
        what = with_full_stop(f"{note[0].upper()}{note[1:]}")
        yield Finding(topic="recipe", what=what, remedy="Check it against what you meant.")
    if recipe.apart_mm is not None and recipe.apart_mm > SAME_MM:
        yield Finding(
            topic="recipe",
            what=f"The shape is not what the recipe makes of the scan: they are up to "
            f"{recipe.apart_mm:.2f} mm apart.",
            remedy="Apply the recipe again (`limbgram edit apply`), or name the recipe that made "
            "it; the ledger below is not this shape's.",
            gravity="serious",
        )


def _about_pressure(recipe: RecipeDone) -> Iterator[Finding]:
    """Loads on what bears no pressure, great depths, and what all edits together leave there."""
    for line in recipe.lines:
        for concern in line.concerns:
            if not concern.word:
                continue
            said = "accepted in the recipe" if concern.accepted else "NOT accepted in the recipe"
            yield Finding(
                topic="recipe",
                what=f"Edit {line.number}: {told(concern.finding)} ({said}: {concern.word}).",
                remedy="Look whether it is meant: what is made over the shape presses there. For "
                "room use the edit relieve.",
                gravity="serious",
            )
    pressed = {name: -moved for name, moved in recipe.places_mm.items() if moved < -PRESSES_MM}
    if pressed:
        places = ", ".join(f"{name} {depth:.1f} mm" for name, depth in pressed.items())
        yield Finding(
            topic="recipe",
            what=f"All edits together press on places that bear no pressure: {places}.",
            remedy="Give room there by the edit relieve, or know that it is meant.",
        )


def _about_case(case: CaseCited | None) -> Iterator[Finding]:
    if case is None:
        return
    for one in case.setups:
        yield Finding(
            topic="case",
            what=sentence(one.finding),
            remedy=advice(one.finding) or "The certificate lies beside the camera file.",
            gravity="serious" if one.outcome == "fail" else "mild",
        )
    if not case.delivered:
        yield Finding(
            topic="case",
            what="None of the shapes is a file of the case that is named.",
            remedy="Scale and surface of the table of biases hold only if the shape came from it.",
            gravity="serious",
        )
    if case.light != "green":
        yield Finding(
            topic="case",
            what=f"The capture's own assessment is {case.light.upper()}.",
            remedy="Read the case's accuracy page: it says what limits it.",
            gravity="serious" if case.light == "red" else "mild",
        )


def _about_comparison(comparison: Json | None) -> Iterator[Finding]:
    for note in () if comparison is None else comparison["notes"]:
        yield Finding(topic="comparison", what=note, remedy="Read the comparison with it in mind.")
