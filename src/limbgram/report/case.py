"""Case: what the report of a reconstruction shows, and in which order.

In      the summary (report.summary) and the pictures.
Out     a Report; it has no sheets of paper.
"""

import math
from collections.abc import Iterator, Sequence

from limbgram.findings import told
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.report.acceptance import setup_section
from limbgram.report.accuracy.judgement import findings_in, without_light
from limbgram.report.accuracy.selfcalibration import SelfCalibration
from limbgram.report.blocks import Banner, Block, Illustration, Link, Report, Section, Table, Text
from limbgram.report.parts import PartSummary, area_of, place_of
from limbgram.report.pictures import Pictures
from limbgram.report.stages import stage_title
from limbgram.report.summary import LengthSummary, PhotoSummary, StageSummary, Summary, Verdict


def case_report(summary: Summary, drawn: Pictures, title: str) -> Report:
    """Verdict, pictures, and the tables for those who want to know more."""
    return Report(
        title=title,
        banner=_verdict(summary.verdict),
        note=" ".join(map(told, summary.verdict.facts)),
        intended_use=summary.intended_use,
        sections=(
            Section(title="", blocks=(_TO_ACCURACY,)),
            *_processing_notes((*summary.scene.notes, *map(told, summary.resolution.notes))),
            *parts_section(summary.parts, summary.unit),
            *_without_camera_file(summary.self_calibration),
            *setup_section(summary.setups),
            *(
                Section(title=one.title, blocks=(Illustration(image=one, caption=one.caption),))
                for one in drawn.pictures
            ),
            Section(title="Known lengths", blocks=_lengths(summary.scale.lengths)),
            Section(title="Photos", blocks=(_photos(summary.photos),)),
            *_set_aside(summary.set_aside),
            Section(title="Stages", blocks=(_stages(summary.stages),)),
        ),
    )


def _processing_notes(notes: Sequence[str]) -> Iterator[Section]:
    """Notes of unusual processing: masks, a limb that moved, a turntable."""
    if notes:
        yield Section(
            title="What was done with these photos", blocks=tuple(Text(words=n) for n in notes)
        )


def _without_camera_file(found: SelfCalibration | None) -> Iterator[Section]:
    if found is not None:
        yield Section(title="Camera without a file", blocks=(Text(words=told(found.finding)),))


_TO_ACCURACY = Link(words="How accurate is it, and what limits it?", address="accuracy.html")


def _verdict(verdict: Verdict) -> Banner:
    """The light that the accuracy has, in its colour and in words, and every reason for it."""
    said = findings_in(verdict.headline)
    return Banner(
        badge=verdict.light.upper(),
        words=told(without_light(verdict.headline)),
        colour=verdict.light,
        reasons=tuple(told(reason) for reason in verdict.reasons if reason not in said),
    )


def parts_section(parts: Sequence[PartSummary], unit: str) -> Iterator[Section]:
    """The bodies of a reconstruction, where there are several."""
    if len(parts) < 2:
        return
    note = (
        "The photos show several bodies that do not hang together. The surface is the one that "
        "they look at most, or the one that was asked for; each other one has a file of its own "
        "in the same frame. `limbgram reconstruct ... --part NUMBER` makes another the surface."
    )
    rows = tuple(
        (
            str(row.number),
            row.name,
            area_of(row, unit),
            place_of(row, unit),
            row.file or row.reason,
        )
        for row in parts
    )
    heads = ("part", "what", "#area", "middle and size", "file")
    yield Section(title="Parts", blocks=(Text(words=note), Table(heads=heads, rows=rows)))


def _lengths(lengths: Sequence[LengthSummary]) -> tuple[Block, ...]:
    if not lengths:
        return (Text(words="None: nothing says how large this is."),)
    rows = tuple(
        (
            length.label,
            length.role,
            f"{length.known_mm:.3f}",
            f"{length.measured_mm:.3f}",
            f"{100 * length.error:+z.3f} %",
        )
        for length in sorted(lengths, key=lambda length: length.role)
    )
    note = "Control lengths set the scale; check lengths did not, so they test it."
    heads = ("length", "role", "#known mm", "#measured mm", "#error")
    return Text(words=note), Table(heads=heads, rows=rows)


def _photos(photos: Sequence[PhotoSummary]) -> Table:
    rows = tuple(
        (
            photo.name,
            "placed" if photo.placed else "not placed",
            f"{photo.features:,}",
            f"{photo.points:,}",
            "" if math.isnan(photo.rms_px) or not photo.placed else f"{photo.rms_px:.3f}",
            " ".join((photo.reason, *photo.remarks)).strip(),
        )
        for photo in photos
    )
    heads = ("photo", "verdict", "#features", "#points", "#residual px", "remarks")
    return Table(heads=heads, rows=rows, marked=tuple(not photo.placed for photo in photos))


def _set_aside(files: Sequence[SetAside]) -> Iterator[Section]:
    if files:
        rows = tuple((file.name, told(file.reason)) for file in files)
        yield Section(title="Set aside", blocks=(Table(heads=("what", "why"), rows=rows),))


def _stages(stages: Sequence[StageSummary]) -> Table:
    rows = [
        (
            stage_title(stage.stage),
            f"{stage.wall_s:.1f}",
            f"{stage.cpu_s:.1f}",
            "" if math.isnan(stage.peak_mb) else f"{stage.peak_mb:.0f}",
            "taken from the last run" if stage.reused else "",
        )
        for stage in stages
    ]
    wall_s, cpu_s = sum(one.wall_s for one in stages), sum(one.cpu_s for one in stages)
    rows.append(("All", f"{wall_s:.1f}", f"{cpu_s:.1f}", "", ""))
    return Table(heads=("stage", "#seconds", "#CPU seconds", "#peak MB", ""), rows=tuple(rows))
