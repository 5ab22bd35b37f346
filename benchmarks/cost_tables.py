"""Cost as tables for people, and a plot of its growth.

python benchmarks/cost_tables.py benchmarks/results/cost.json    draws cost.png beside it
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from harness import described, made_on, table
from limbgram.core.errors import RED_EXIT_CODE

Result = dict[str, Any]
BY_PHOTOS = ("p15x1", "p30x1", "p60x1")
"""Sets that differ in the number of photos alone."""
BY_PIXELS = ("phone30x1", "phone30x3", "phone30x12", "phone30x48")
"""Sets that differ in the size of the photos alone."""


def page(results: Result) -> str:
    """Cost, accuracy and stages of every set, and of an earlier result beside it."""
    sets = results["sets"]
    parts = [
        "# Cost of whole captures",
        made_on(results["machine"]),
        "## Photos to STL\n\n" + cost_table(sets),
        "## Accuracy of the same runs\n\n" + _accuracy(sets),
        "## Stages: CPU s / peak MB\n\n" + _stages(sets),
    ]
    if "before" in results:
        before = results["before"]
        parts += [
            "## Before",
            made_on(before["machine"]),
            cost_table(before["sets"]),
            "## Stages before: CPU s / peak MB\n\n" + _stages(before["sets"]),
        ]
    if "warm_up" in results:
        run = results["warm_up"]
        parts.append(
            f"`limbgram warm-up` of a copy that has never run: {run['wall_s']:.0f} s, "
            f"{run['cpu_s']:.0f} CPU s, exit code {run['exit_code']}."
        )
    return "\n\n".join(parts) + "\n"


def plot(results: Result, path: Path) -> None:
    """Draw seconds and memory against photos and pixels, where a growth was measured."""
    sets = results["sets"]
    if any(_grown(sets, names) for names in (BY_PHOTOS, BY_PIXELS)):
        _plot(sets, path)


def cost_table(sets: Result) -> str:
    """Every set: what a whole run takes, and what pycolmap's sparse step does."""
    heads = ("set", "CPU s", "pycolmap's sparse step, CPU s", "ratio", "wall s", "peak MB",
             "triangles of all surfaces", "verdict", "runs")  # fmt: skip
    rows: list[Sequence[str]] = []
    for one in sets.values():
        runs, theirs = finished(one["limbgram"]), finished(one["pycolmap"])
        count = str(len(one["limbgram"]))
        if not runs:
            failed = one["limbgram"][0]
            rows.append((one["what"], *[""] * 6, f"exit {failed['exit_code']}", count))
            continue
        rows.append(
            (
                one["what"],
                f"{least(runs, 'cpu_s'):.0f}",
                f"{least(theirs, 'sparse_cpu_s'):.0f} ({_steps(theirs)})" if theirs else "",
                f"{ratio(one):.2f}" if theirs else "",
                f"{least(runs, 'wall_s'):.0f}",
                f"{max(run['peak_mb'] for run in runs):.0f}",
                f"{runs[-1]['triangles']:,}",
                runs[-1]["verdict"].upper(),
                count,
            )
        )
    return table(heads, rows)


def ratio(one: Result) -> float:
    """CPU seconds of our whole run over pycolmap's sparse step, the least of each."""
    theirs = least(finished(one["pycolmap"]), "sparse_cpu_s")
    return least(finished(one["limbgram"]), "cpu_s") / theirs


def finished(runs: Sequence[Result]) -> list[Result]:
    """Runs that went all the way."""
    return [run for run in runs if run["exit_code"] in (0, RED_EXIT_CODE)]


def least(runs: Sequence[Result], figure: str) -> float:
    """The least of a figure: what other programs do on the machine only adds."""
    return min(run[figure] for run in runs)


def _steps(theirs: Sequence[Result]) -> str:
    """Extract + match + map of the run that took least."""
    best = min(theirs, key=lambda run: run["sparse_cpu_s"])
    return " + ".join(f"{seconds:.0f}" for seconds in best["steps_cpu_s"].values())


def _accuracy(sets: Result) -> str:
    heads = ("set", "photos placed", "RMS mm", "95 % mm", "cameras mm", "scale", "error / sigma")
    rows: list[Sequence[str]] = []
    for one in sets.values():
        for run in finished(one["limbgram"])[-1:]:
            truth = run.get("truth")
            if truth is None:
                told = ["no truth", *[""] * 4]
            else:
                cameras, sigma = truth["camera_rms_mm"], truth["sigma"]
                told = [
                    f"{truth['rms_mm']:.4f}",
                    f"{truth['p95_mm']:.4f}",
                    "" if cameras is None else f"{cameras:.3f}",
                    f"{truth['scale_error']:+.4%}",
                    "" if sigma is None else f"{sigma['robust_spread']:.2f}",
                ]
            rows.append((one["what"], f"{run['placed']} of {one['photos']}", *told))
    return table(heads, rows)


def _stages(sets: Result) -> str:
    """A column a set, from its run that took least."""
    best = {
        name: _by_stage(min(runs, key=_cpu_s)["stages"])
        for name, one in sets.items()
        if (runs := finished(one["limbgram"]))
    }
    names = dict.fromkeys(stage for stages in best.values() for stage in stages)
    rows = [(name, *(_stage(stages.get(name)) for stages in best.values())) for name in names]
    sums = (sum(stage["cpu_s"] for stage in stages.values()) for stages in best.values())
    return table(("stage", *best), [*rows, ("all stages", *(f"{cpu_s:.1f}" for cpu_s in sums))])


def _by_stage(stages: Sequence[Result]) -> dict[str, Result]:
    """A stage that ran for several bodies counts once: its seconds added, its largest peak."""
    found: dict[str, Result] = {}
    for stage in stages:
        known = found.setdefault(stage["stage"], {"cpu_s": 0.0, "peak_mb": None})
        known["cpu_s"] += stage["cpu_s"]
        peaks = [peak for peak in (known["peak_mb"], stage["peak_mb"]) if peak is not None]
        known["peak_mb"] = max(peaks, default=None)
    return found


def _stage(stage: Result | None) -> str:
    if stage is None:
        return ""
    peak = "" if stage["peak_mb"] is None else f" / {stage['peak_mb']}"
    return f"{stage['cpu_s']:.1f}{peak}"


def _cpu_s(run: Result) -> float:
    return run["cpu_s"]


def _grown(sets: Result, names: Sequence[str]) -> list[Result]:
    return [sets[name] for name in names if name in sets and finished(sets[name]["limbgram"])]


def _plot(sets: Result, path: Path) -> None:
    """Seconds against photos; seconds and memory against pixels."""
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    by_photos, by_pixels, memory = figure.subplots(1, 3)

    def ours(one: Result) -> float:
        return least(finished(one["limbgram"]), "cpu_s")

    few, many = _grown(sets, BY_PHOTOS), _grown(sets, BY_PIXELS)
    _line(by_photos, few, "photos", ours, "o-", "limbgram, whole way")
    beside = [one for one in few if finished(one["pycolmap"])]
    _line(by_photos, beside, "photos", _sparse_s, "s--", "pycolmap, sparse step alone")
    by_photos.set(xlabel="photos of 1 MP", ylabel="CPU seconds", title="Seconds against photos")
    _line(by_pixels, many, "megapixels", ours, "o-", "limbgram, whole way")
    by_pixels.set(ylabel="CPU seconds", title="Seconds against pixels")
    _line(memory, many, "megapixels", _peak_mb, "o-", "limbgram, whole way")
    memory.set(ylabel="peak MB", title="Memory against pixels")
    for axes in (by_pixels, memory):
        axes.set(xlabel="megapixels of 30 phone photos")
    for axes in (by_photos, by_pixels, memory):
        axes.set_xscale("log")
        stops = sorted({x for line in axes.lines for x in line.get_xdata()})
        axes.set_xticks(stops, [f"{stop:.2g}" for stop in stops])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize=7)
    figure.savefig(path, dpi=120)


def _line(
    axes: Axes,
    sets: Sequence[Result],
    along: str,
    value: Callable[[Result], float],
    form: str,
    label: str,
) -> None:
    if sets:
        axes.plot([one[along] for one in sets], [value(one) for one in sets], form, label=label)


def _sparse_s(one: Result) -> float:
    return least(finished(one["pycolmap"]), "sparse_cpu_s")


def _peak_mb(one: Result) -> float:
    return max(run["peak_mb"] for run in finished(one["limbgram"]))


if __name__ == "__main__":
    parser = described(__doc__)
    parser.add_argument("written", type=Path, help="the results, as JSON")
    written: Path = parser.parse_args().written
    plot(json.loads(written.read_text("utf-8")), written.with_suffix(".png"))
