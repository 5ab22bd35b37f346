"""`limbgram align`: landmarks, side and axes of a shape, kept beside it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from limbgram.cli.landmark_options import (
    MarksRequest,
    ProposalRequest,
    landmarks_asked,
    marks_seen,
)
from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import READ, UnitOption, shape_of
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.files import require_place
from limbgram.core.interval import Interval, plus_minus, what_it_means
from limbgram.core.typed import tree_of
from limbgram.findings.tell import LANGUAGES
from limbgram.formats.limb_file import write_limb_file
from limbgram.formats.reading import ShapeFile
from limbgram.formats.sidecar import limb_file_beside, limb_file_for
from limbgram.services.align import AlignRequest, Axes, align, confirm, propose
from limbgram.workbench.anatomy.kind import Place
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.anatomy.names import NAMES_IN
from limbgram.workbench.bodies import outside_of
from limbgram.workbench.compare.carried_landmarks import Carried
from limbgram.workbench.devices.landmark_uses import uses_of
from limbgram.workbench.frame.landmarks import (
    notes_but_unconfirmed,
    unconfirmed_finding,
    with_landmarks,
)
from limbgram.workbench.limb import AlignedLimb, KindName, Side


@answered
@asking
def align_command(
    axes: Axes,
    look: MarksRequest,
    proposals: ProposalRequest,
    shape: Annotated[
        Path | None,
        typer.Argument(help=f"The shape: {READ}.", show_default=False),
    ] = None,
    side: Annotated[
        Side | None,
        typer.Option(help="Side of the patient: never guessed. A trunk or a head needs none."),
    ] = None,
    kind: Annotated[
        KindName | None,
        typer.Option(help="What the names of the landmarks mean; kept with the shape."),
    ] = None,
    names: Annotated[
        bool,
        typer.Option("--names", help="Only list the landmarks of --kind, and what each serves."),
    ] = False,
    unit: UnitOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Give a shape its axes: +Z proximal, +Y anterior, +X the patient's right, origin distal.

    The shape's file stays as it is; landmarks, side and axes are kept in NAME.limb.json beside it.
    """
    if names:
        return _names(kind)
    if shape is None:
        raise OptionsError("align.no_shape", kinds=READ)
    read = shape_of(shape, unit)
    seen = marks_seen(read.limb, look)
    if look.marks and seen is not None:
        return seen.reply
    if side is None and kind is not None and not KIND_NAMED[kind].sided:
        side = "none"
    if side is None:
        raise OptionsError("align.side.unsaid")
    require_place(limb_file_for(shape))
    limb = with_landmarks(read.limb, landmarks_asked(read.limb, look, seen))
    limb = confirm(limb, proposals.confirm) if proposals.confirm else limb
    carried = None
    if proposals.landmarks_from is not None:
        proposed = propose(limb, shape_of(proposals.landmarks_from, None).limb, side, kind)
        limb, carried = proposed.limb, proposed.carried
    aligned = align(limb, AlignRequest.of(axes, side, kind), read.declared)
    return _kept(aligned, shape, read, carried)


def _kept(limb: AlignedLimb, shape: Path, read: ShapeFile, carried: Carried | None) -> Reply:
    """Write the limb file, and say where the limb lies now."""
    said = unconfirmed_finding(limb)
    limb = replace(limb, notes=(*(() if said is None else (said,)), *notes_but_unconfirmed(limb)))
    written = write_limb_file(limb, shape, mm_per_unit=read.mm_per_unit, sha256=read.sha256)
    motion = limb.limb_from_mesh
    limb = outside_of(limb)
    size = np.ptp(motion.apply(limb.mesh.vertices_mm), axis=0)
    places = {mark.name: motion.apply(mark.position_mm[None])[0] for mark in limb.landmarks}
    lines = [
        *(f"Note: {with_full_stop(spoken(one))}" for one in limb.notes),
        f"Side: {limb.side}. {size[2]:.1f} mm along the axis, {size[0]:.1f} mm from side to "
        f"side, {size[1]:.1f} mm from front to back.",
        *(
            f"  {name:<28} right {x:7.1f}   anterior {y:7.1f}   proximal {z:7.1f} mm"
            for name, (x, y, z) in places.items()
        ),
        *([] if carried is None else _carried_lines(carried)),
        f"Written: {written}",
    ]
    content: dict[str, Any] = {
        "side": limb.side,
        "limb_from_mesh": {
            "rotation": motion.rotation.tolist(),
            "translation_mm": motion.translation.tolist(),
        },
        "size_mm": size.tolist(),
        "landmarks": [
            {"name": name, "in_limb_mm": place.tolist()} for name, place in places.items()
        ],
        "carried": None if carried is None else _carried_tree(carried),
        "kind": limb.kind,
        "notes": tree_of(limb.notes),
        "written": str(limb_file_beside(shape)),
    }
    return Reply(tuple(lines), content)


def _carried_lines(carried: Carried) -> list[str]:
    """Each proposal with its error, and why the others have none."""
    sure = [Interval.of_sigma(one.landmark.sigma_mm or 0.0) for one in carried.places]
    lines = [
        f"  proposed: {one.landmark.name:<28} {plus_minus(interval, 1)} mm"
        for one, interval in zip(carried.places, sure, strict=True)
    ]
    lines += [f"  not proposed: {one.name}: {spoken(one.reason)}" for one in carried.left_out]
    return [*lines, *what_it_means(sure)]


def _carried_tree(carried: Carried) -> dict[str, Any]:
    return {
        "proposed": [
            {
                "name": one.landmark.name,
                "sigma_mm": one.landmark.sigma_mm,
                "carrying_sigma_mm": one.carrying_mm,
                "sliding_sigma_mm": one.sliding_mm,
            }
            for one in carried.places
        ],
        "left_out": [{"name": one.name, "reason": tree_of(one.reason)} for one in carried.left_out],
        "rms_mm": carried.rms_mm,
    }


def _names(kind: KindName | None) -> Reply:
    """All places of a kind, or of each, and what they serve."""
    chosen = [one for one in KIND_NAMED.values() if kind is None or one.name == kind]
    lines: list[str] = []
    content: dict[str, Any] = {}
    for one in chosen:
        uses = uses_of(one)
        lines += [f"{one.name}:", *(_line(row, uses[row.identity]) for row in one.places)]
        content[one.name] = [
            {
                "name": row.identity,
                "facing": row.facing,
                "level": row.level,
                "uses": uses[row.identity],
                "names": {language: NAMES_IN[language][row.identity] for language in LANGUAGES},
            }
            for row in one.places
        ]
    return Reply(tuple(lines), content)


def _line(row: Place, uses: Sequence[str]) -> str:
    """A place, the side on which it lies, its name in the other languages, and what it serves."""
    others = ", ".join(NAMES_IN[language][row.identity][0] for language in LANGUAGES[1:])
    return f"  {row.identity:<32}{row.facing:<11}{others:<36}{', '.join(uses) or 'name alone'}"
