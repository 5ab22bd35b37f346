"""`limbgram template`: a rectification learned from pairs, shown, and applied to a limb."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from limbgram.cli.replies import Reply, answered, spoken
from limbgram.cli.shape_options import (
    AlignedShape,
    UnitOfAll,
    UnitOption,
    require_apart,
    require_output,
    shape_of,
)
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.files import other, require, write_bytes
from limbgram.core.mesh.topology import volume_mm3
from limbgram.core.typed import tree_of
from limbgram.formats.export_checks import as_kept
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.compare.registration import RegistrationOptions, Way
from limbgram.workbench.edits.pressing import LEAST_PRESSURE_MM
from limbgram.workbench.frame.sensitive import sensitive_place
from limbgram.workbench.templates.files import encode_template, read_template
from limbgram.workbench.templates.learning import LearnOptions, Pair, learn
from limbgram.workbench.templates.template import Template, apply_template, moves_at_marks

_HELP = """Keep a rectification as a template and apply it to other limbs.

Shapes before the rectification must be aligned, with landmarks of the same names on all. One pair
keeps what was done once; several give the mean, its spread, and only what is significant.

1. `limbgram template learn a.ply a-rectified.ply b.ply b-rectified.ply -o mine.json`
2. `limbgram template show mine.json --picture mine.png`
3. `limbgram template apply limb.ply mine.json -o rectified.ply`
"""

template_app = typer.Typer(help=_HELP, no_args_is_help=True, rich_markup_mode="markdown")

TemplateFile = Annotated[Path, typer.Argument(help="The template's file, JSON.")]
Json = Annotated[bool, typer.Option("--json", help="Reply as JSON.")]


@answered
def learn_command(
    shapes: Annotated[
        list[Path], typer.Argument(help="Shapes in pairs: before, after, before, after.")
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="Where the template is written, JSON.")],
    name: Annotated[
        str, typer.Option(help="What it is called.", show_default="the file's name")
    ] = "",
    way: Annotated[
        Way,
        typer.Option(
            "--align",
            help="How each after is laid on its before. auto: as they lie where it was made "
            "from it, else icp.",
        ),
    ] = "auto",
    reference: Annotated[
        str | None,
        typer.Option(help="Landmark from which heights count.", show_default="the most proximal"),
    ] = None,
    brim: Annotated[float, typer.Option(help="Strip along open edges left out, mm.")] = 5.0,
    unit: UnitOfAll = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Learn a template from shapes before and after the clinic's own rectifications."""
    require_output(out, ".json", "template")
    if len(shapes) % 2:
        raise OptionsError("template.learn.odd", count=len(shapes))
    limbs = [shape_of(shape, unit).limb for shape in shapes]
    pairs = [Pair(before=one, after=two) for one, two in zip(limbs[::2], limbs[1::2])]
    options = LearnOptions(
        registration=RegistrationOptions(way=way, brim_mm=brim, mostly_unchanged=True),
        reference=reference,
    )
    learned = learn(pairs, name or out.stem, options)
    template, notes = learned.template, learned.notes
    written = _write(template, out)
    return Reply(
        (
            *_lines(template),
            *(f"Note: {with_full_stop(spoken(note))}" for note in notes),
            f"Written: {written}",
        ),
        {**_tree(template), "notes": tree_of(notes), "written": [str(written)]},
    )


@answered
def apply_command(
    shape: AlignedShape,
    template: TemplateFile,
    out: Annotated[Path, typer.Option("-o", "--out", help="Where the new shape is written.")],
    strength: Annotated[float, typer.Option(help="Factor of all displacements.")] = 1.0,
    unit: UnitOption = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Apply a template to a limb, at the limb's own landmarks."""
    require_apart(out, shape)
    known = read_template(template)
    limb = shape_of(shape, unit).limb
    applied = apply_template(limb, known, strength)
    kept = as_kept(applied.limb, out)
    written = write_limb(kept, out)
    volumes_ml = [volume_mm3(mesh) / 1000 for mesh in (limb.mesh, applied.limb.mesh)]
    change_ml, moved = volumes_ml[1] - volumes_ml[0], applied.moved_mm
    share = change_ml / volumes_ml[0]
    notes = (*limb.notes, *applied.notes, *kept.notes[len(applied.limb.notes) :])
    return Reply(
        (
            f"{known.name} applied at {strength:.0%}: the surface moved by {moved.min():+z.1f} to "
            f"{moved.max():+z.1f} mm (+ room, - pressure), the volume by {change_ml:+z.1f} mL "
            f"({share:+z.1%}).",
            *(f"Note: {with_full_stop(spoken(note))}" for note in notes),
            f"Written: {written}",
        ),
        {
            "template": known.name,
            "strength": strength,
            "most_inward_mm": float(moved.min()),
            "most_outward_mm": float(moved.max()),
            "mean_mm": float(moved.mean()),
            "volume_change_ml": change_ml,
            "volume_change_share": share,
            "pressures": [asdict(one) for one in applied.pressures],
            "notes": tree_of(notes),
            "written": [str(written)],
        },
    )


@answered
def show_command(
    template: TemplateFile,
    picture: Annotated[Path | None, typer.Option(help="Write it unrolled (PNG).")] = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Show what a template does, and where."""
    require_output(picture, ".png", "picture")
    known = read_template(template)
    written: list[Path] = []
    if picture is not None:
        from limbgram.report.drawings.drawing import png
        from limbgram.report.drawings.time_course import unrolled_template

        written = [write_bytes(picture, png(unrolled_template(known).figure).tobytes())]
    return Reply(
        (*_lines(known), *(f"Written: {path}" for path in written)),
        {**_tree(known), "written": [str(path) for path in written]},
    )


def _write(template: Template, path: Path) -> Path:
    content = encode_template(template)

    def check(written: Path) -> None:
        again = encode_template(read_template(written))
        require(again == content, other(path.name, "template"))

    return write_bytes(path, content, check)


def _lines(template: Template) -> Sequence[str]:
    moved, spread = template.displacement_mm, template.spread_mm
    share = float((moved != 0).mean())
    moves = moves_at_marks(template)
    count = "1 pair" if template.pairs == 1 else f"{template.pairs} pairs"
    told = (
        f"between pairs it spreads by {np.nanmedian(spread):.2f} mm (median)"
        if np.isfinite(spread).any()
        else "one pair tells no spread: learn from three or more"
    )
    return (
        f"{template.name}: {moved.min():+z.1f} to {moved.max():+z.1f} mm (+ room, - pressure) on "
        f"{share:.0%} of the surface, from {count}; {told}.",
        f"Heights count from the rounded end (0) to {template.reference} (1).",
        *(
            f"  {mark.name:<28} height {mark.height:5.2f}   {mark.angle_deg:+z6.1f} degrees "
            f"towards lateral   {moves[mark.name]:+z.1f} mm{_warning(mark.name, moves[mark.name])}"
            for mark in template.marks
        ),
    )


def _warning(name: str, moved_mm: float) -> str:
    """Behind a landmark that the template presses on and that bears no pressure."""
    place = sensitive_place(name, None)
    pressed = place is not None and moved_mm < -LEAST_PRESSURE_MM
    return f"   ! presses on the {place.name}: {place.why}" if place and pressed else ""


def _tree(template: Template) -> dict[str, Any]:
    moved, spread = template.displacement_mm, template.spread_mm
    moves = moves_at_marks(template)
    return {
        "name": template.name,
        "pairs": template.pairs,
        "sided": template.sided,
        "reference": template.reference,
        "landmarks": [
            {
                "name": mark.name,
                "height": mark.height,
                "angle_deg": mark.angle_deg,
                "moved_mm": moves[mark.name],
                "sensitive": sensitive_place(mark.name, None) is not None,
            }
            for mark in template.marks
        ],
        "most_inward_mm": float(moved.min()),
        "most_outward_mm": float(moved.max()),
        "changed_share": float((moved != 0).mean()),
        "median_spread_mm": float(np.nanmedian(spread)) if np.isfinite(spread).any() else None,
    }


template_app.command("learn")(learn_command)
template_app.command("apply")(apply_command)
template_app.command("show")(show_command)
