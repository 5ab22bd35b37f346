"""Results of whole captures as tables for people, and a plot of what a sweep cost.

python benchmarks/tables.py benchmarks/results/sweep.json    draws sweep.png beside it
"""

import json
import math
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


def page(results: Result) -> str:
    """Accuracy, cost, stages and rivals of every set."""
    parts = [
        "# Whole captures",
        made_on(results["machine"]),
        _accuracy(results["sets"]),
        _cost(results["sets"]),
        _stages(results["sets"]),
        _rivals(results["sets"]),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def plot(results: Result, path: Path) -> None:
    """Draw cost and error against photos and pixels, where there is a sweep."""
    swept = [one for one in results["sets"].values() if "setting" in one and _fine(one)]
    if swept:
        _plot(swept, path)


def _fine(one: Result) -> bool:
    return one.get("reconstruct", {}).get("exit_code") in (0, RED_EXIT_CODE)


def _accuracy(sets: Result) -> str:
    heads = ("set", "RMS mm", "RMS px", "95 % mm", "mean mm", "within 0.1 mm", "covered 0.1 mm",
             "covered 0.25 mm", "scale", "worst girth mm", "volume", "cameras mm",
             "error / sigma")  # fmt: skip
    rows: list[Sequence[str]] = []
    for name, one in sets.items():
        truth = (one.get("accuracy") or {}).get("truth")
        if truth is None:
            continue
        girth = max((abs(g["error_mm"]) for g in truth["girths"]), default=math.nan)
        sigma = truth["sigma"]
        rows.append(
            (
                name,
                f"{truth['rms_mm']:.4f}",
                f"{truth['rms_px']:.3f}",
                f"{truth['p95_mm']:.4f}",
                f"{truth['mean_mm']:+.4f}",
                f"{truth['within']['0.1 mm']:.2%}",
                f"{truth['covered']['0.1 mm']:.2%}",
                f"{truth['covered']['0.25 mm']:.2%}",
                f"{truth['scale_error']:+.4%}",
                f"{girth:.3f}",
                f"{truth['volume_error']:+.3%}",
                "" if truth["camera_rms_mm"] is None else f"{truth['camera_rms_mm']:.3f}",
                "" if sigma is None else f"{sigma['robust_spread']:.2f}",
            )
        )
    return "## Accuracy\n\n" + table(heads, rows) if rows else ""


def _cost(sets: Result) -> str:
    heads = ("set", "photos", "exit", "wall s", "CPU s", "peak MB", "first line")
    rows = [
        (
            name,
            str(one.get("photos", "")),
            str(one["reconstruct"]["exit_code"]),
            f"{one['reconstruct']['wall_s']:.1f}",
            f"{one['reconstruct']['cpu_s']:.1f}",
            f"{one['reconstruct']['peak_mb']:.0f}",
            (one.get("accuracy") or {}).get("headline", one["reconstruct"]["message"][:80]),
        )
        for name, one in sets.items()
        if "reconstruct" in one
    ]
    return "## Cost of `limbgram reconstruct`\n\n" + table(heads, rows) if rows else ""


def _stages(sets: Result) -> str:
    """CPU seconds and peak memory by stage, a column a set."""
    done = {name: one["summary"]["stages"] for name, one in sets.items() if "summary" in one}
    names = list(dict.fromkeys(stage["stage"] for stages in done.values() for stage in stages))
    rows: list[Sequence[str]] = []
    for name in names:
        cells = [name]
        for stages in done.values():
            stage = next((one for one in stages if one["stage"] == name), None)
            peak = "" if stage is None or stage["peak_mb"] is None else f"{stage['peak_mb']:.0f}"
            cells.append(
                "" if stage is None else f"{stage['wall_s']:.1f} / {stage['cpu_s']:.1f} / {peak}"
            )
        rows.append(cells)
    heading = "## Stages: wall s / CPU s / peak MB\n\n"
    return heading + table(("stage", *done), rows) if rows else ""


def _rivals(sets: Result) -> str:
    heads = ("set", "who", "photos placed", "camera centres, % of radius", "rotation deg", "wall s",
             "CPU s", "peak MB")  # fmt: skip
    rows: list[Sequence[str]] = []
    for name, one in sets.items():
        if "rivals" not in one:
            continue
        contenders = {"limbgram, whole way": {**one["reconstruct"], "poses": one.get("poses")}}
        for who, run in {**contenders, **one["rivals"]}.items():
            poses = run.get("poses")
            rows.append(
                (
                    name,
                    who,
                    "" if not poses else str(poses["photos"]),
                    "" if not poses else f"{poses['centres_rms_percent_of_radius']:.4f}",
                    "" if not poses else f"{poses['rotation_mean_deg']:.4f}",
                    f"{run['wall_s']:.1f}",
                    f"{run['cpu_s']:.1f}",
                    f"{run['peak_mb']:.0f}",
                )
            )
    return "## Rivals on the same photos and calibration\n\n" + table(heads, rows) if rows else ""


def _plot(swept: Sequence[Result], path: Path) -> None:
    """Cost against photos and against pixels, and the error in pixels."""
    figure = Figure(figsize=(11, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    by_photos, by_pixels, error = figure.subplots(1, 3)
    _lines(by_photos, swept, "photos", "megapixels", "{:g} MP", _cpu_s)
    _against(by_photos, swept)
    by_photos.set(xlabel="photos", ylabel="CPU seconds", title="Cost against photos")
    _lines(by_pixels, swept, "megapixels", "photos", "{:g} photos", _cpu_s)
    by_pixels.set(xlabel="megapixels a photo", ylabel="CPU seconds", title="Cost against pixels")
    _lines(error, swept, "photos", "megapixels", "{:g} MP", _rms_px)
    error.set(xlabel="photos", ylabel="RMS error, px on the object", title="Error")
    for axes in (by_photos, by_pixels, error):
        axes.set_xscale("log")
        axes.set_yscale("log")
        stops = sorted({x for line in axes.lines for x in line.get_xdata()})
        axes.set_xticks(stops, [f"{stop:g}" for stop in stops])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("{x:g}")
        axes.grid(alpha=0.3, which="both")
        axes.legend(fontsize=7)
    figure.savefig(path, dpi=120)


def _lines(
    axes: Axes,
    swept: Sequence[Result],
    along: str,
    by: str,
    label: str,
    value: Callable[[Result], float],
) -> None:
    for group in sorted({one["setting"][by] for one in swept}):
        own = sorted(
            (one["setting"][along], value(one)) for one in swept if one["setting"][by] == group
        )
        axes.plot(*zip(*own, strict=True), "o-", ms=4, label=label.format(group))


def _against(axes: Axes, swept: Sequence[Result]) -> None:
    """What a rival's cameras alone cost, beside our whole way, at the commonest resolution."""
    sizes = [one["setting"]["megapixels"] for one in swept]
    common = max(set(sizes), key=sizes.count)
    for name in sorted({name for one in swept for name in one.get("rivals", {})}):
        own = sorted(
            (one["setting"]["photos"], one["rivals"][name]["cpu_s"])
            for one in swept
            if one["setting"]["megapixels"] == common and name in one.get("rivals", {})
        )
        label = f"{name}, cameras only, {common:g} MP"
        axes.plot(*zip(*own, strict=True), "s--", ms=4, color="0.45", label=label)


def _cpu_s(one: Result) -> float:
    return one["reconstruct"]["cpu_s"]


def _rms_px(one: Result) -> float:
    return one["accuracy"]["truth"]["rms_px"] if one.get("accuracy") else math.nan


if __name__ == "__main__":
    parser = described(__doc__)
    parser.add_argument("written", type=Path, help="the results, as JSON")
    written: Path = parser.parse_args().written
    plot(json.loads(written.read_text("utf-8")), written.with_suffix(".png"))
