"""Terminal summary: a summary in the lines that people read at a terminal.

In      a Summary.
Out     lines: the verdict, what was left out, size, bodies, resolution; and what each stage cost.
"""

import math
from collections.abc import Sequence

from limbgram.findings import told
from limbgram.report.parts import part_lines
from limbgram.report.stages import stage_title
from limbgram.report.summary import StageSummary, Summary


def summary_lines(summary: Summary) -> tuple[str, ...]:
    """The verdict and what goes with it."""
    mesh = summary.mesh
    unit = "mm" if summary.unit == "mm" else "units of unknown size"
    size = " x ".join(f"{side:.1f}" for side in mesh.size)
    missing = [f"  {photo.name}: {photo.reason}" for photo in summary.photos if photo.reason]
    aside = [f"  {part.name}: {told(part.reason)}" for part in summary.set_aside]
    return (
        told(summary.verdict.headline),
        *_to_check(summary),
        " ".join(map(told, summary.verdict.facts)),
        *missing,
        *aside,
        f"Surface: {mesh.faces:,} triangles, {size} {unit}.",
        *part_lines(summary.parts, summary.unit),
        *summary.scene.notes,
        *map(told, summary.resolution.notes),
        *(() if summary.self_calibration is None else (told(summary.self_calibration.finding),)),
        *(told(one.finding) for one in summary.setups),
    )


def _to_check(summary: Summary) -> tuple[str, ...]:
    """How to have the scale checked, where nothing independent did."""
    if summary.verdict.size_checked or summary.unit != "mm":
        return ()
    return ("To check the scale, tape one girth and pass --tape HEIGHT=GIRTH or widest=GIRTH.",)


def profile_lines(stages: Sequence[StageSummary]) -> tuple[str, ...]:
    """What each stage cost; a stage taken from the last run tells what it cost then."""
    rows = [
        f"  {stage_title(stage.stage):<26}{stage.wall_s:9.2f}{stage.cpu_s:9.2f}"
        + (f"{stage.peak_mb:9.0f}" if not math.isnan(stage.peak_mb) else f"{'?':>9}")
        + "   taken from the last run" * stage.reused
        for stage in stages
    ]
    wall_s, cpu_s = sum(one.wall_s for one in stages), sum(one.cpu_s for one in stages)
    peaks = [stage.peak_mb for stage in stages if not math.isnan(stage.peak_mb)]
    return (
        f"  {'stage':<26}{'wall s':>9}{'CPU s':>9}{'peak MB':>9}",
        *rows,
        f"  {'All':<26}{wall_s:9.2f}{cpu_s:9.2f}" + (f"{max(peaks):9.0f}" if peaks else ""),
    )
