"""The figures that README and docs publish, made from benchmarks/results by one command.

    python benchmarks/claims.py            write every block anew
    python benchmarks/claims.py --check    name the blocks that differ, exit code 1 if any

A block of a Markdown file stands between `<!-- figures: NAME -->` and `<!-- end of figures -->`;
NAME is a function below that makes its text of result files alone. A test runs the check.
"""

import json
import math
import re
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from cost_tables import BY_PHOTOS, BY_PIXELS, cost_table, finished, least
from explanation_tables import by_fault
from harness import described, table
from landmark_tables import by_kind

Json = dict[str, Any]

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).parent / "results"
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
BLOCK = re.compile(
    r"(?P<open><!-- figures: (?P<name>[a-z-]+) -->\n)(?P<text>.*?)(?P<end><!-- end of figures -->)",
    re.DOTALL,
)
MEASURED = ("rendered", "sweep", "real", "skull")
"""Result files of whole captures."""
LABELS = {
    "limb_ring15": "limb, rendered, 3.8 MP",
    "foot_ring24": "foot, rendered, 3.8 MP",
    "limb_sparse15": "limb, 8 % of it painted, rendered, 3.8 MP",
    "synthetic_p15_mp15.054_d2000_s11": "the published paper's set-up, own generator, 15 MP, 2 m",
    "synthetic_p15_mp4_s11": "limb, own generator, 4 MP",
    "synthetic_p8_mp1_s11": "limb, own generator, 1 MP",
    "synthetic_p60_mp1_s11": "limb, own generator, 1 MP",
    "flowerpot": "flowerpot on a printed sheet, real phone photos",
    "skull": "skull, real photos, no scale",
}
"""What the sets of the accuracy table are, in its order."""
SHORT = ("limb_ring15", "foot_ring24", "synthetic_p8_mp1_s11", "flowerpot")
"""What README shows of them: two that were chosen on, one that fails, one of real photos."""

GAP_OF_GIRTH = 0.05
"""A girth that is off by more of itself is one of an open surface."""


def main() -> int:
    parser = described(__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing")
    chosen = parser.parse_args()
    stale = False
    for page in PAGES:
        written = page.read_text("utf-8")
        made = made_anew(written)
        if made == written:
            continue
        stale = True
        sys.stderr.write(f"{page.relative_to(ROOT)}: figures differ from the results\n")
        if not chosen.check:
            page.write_text(made, "utf-8")
    return int(stale and chosen.check)


def made_anew(page: str) -> str:
    """A page with every block made from the results."""
    return BLOCK.sub(
        lambda block: f"{block['open']}{BLOCKS[block['name']]().strip()}\n{block['end']}", page
    )


@cache
def result(name: str) -> Json:
    """A result file; a missing one is an error, never an empty block."""
    content: Json = json.loads((RESULTS / f"{name}.json").read_text("utf-8"))
    return content


def short() -> str:
    """Four sets for those who read one table: measured, foot, too few photos, real ones."""
    heads = ("set", "photos", "verdict", "surface RMS", "worst girth", "error / sigma")
    rows: list[Sequence[str]] = []
    for name in SHORT:
        label, photos, verdict, rms, _, _, _, _, girth, _, sigma, _, _ = _accuracy_row(
            LABELS[name], _measured()[name]
        )
        rows.append((label, photos, verdict, rms, girth, sigma))
    return table(heads, rows)


def accuracy() -> str:
    """All sets with their verdicts, the failed ones among them."""
    heads = ("set", "photos", "verdict", "surface RMS", "95 % within", "bias", "within 0.25 mm",
             "scale error", "worst girth", "volume", "error / sigma", "CPU", "peak")  # fmt: skip
    found = _measured()
    rows = [_accuracy_row(label, found[name]) for name, label in LABELS.items() if name in found]
    return table(heads, rows) + "\n\n" + _measured_on(MEASURED)


def _measured() -> dict[str, Json]:
    return {name: one for file in MEASURED for name, one in result(file)["sets"].items()}


def _accuracy_row(label: str, one: Json) -> Sequence[str]:
    said = one.get("accuracy") or {}
    truth, run = said.get("truth"), one["reconstruct"]
    cost = (f"{run['cpu_s']:.0f} s", f"{run['peak_mb'] / 1000:.1f} GB")
    verdict = str(said.get("light", f"refused, exit {run['exit_code']}")).upper()
    if truth is None:
        return (label, str(one["photos"]), verdict, *(["no truth"] * 8), *cost)
    repeats = [again["truth"] for again in one.get("repeats", [])]

    def over(value: Callable[[Json], float], form: str) -> str:
        return _with_spread(value(truth), [value(again) for again in repeats], form)

    return (
        label,
        str(one["photos"]),
        verdict,
        over(lambda t: t["rms_mm"], "{:.3f}") + " mm",
        over(lambda t: t["p95_mm"], "{:.3f}") + " mm",
        over(lambda t: t["mean_mm"], "{:+z.3f}") + " mm",
        over(lambda t: 100 * t["within"]["0.25 mm"], "{:.2f}") + " %",
        over(lambda t: 100 * t["scale_error"], "{:+z.3f}") + " %",
        _girth_of_gaps(truth) or over(worst_girth_mm, "{:+z.2f}") + " mm",
        over(lambda t: 100 * t["volume_error"], "{:+z.2f}") + " %",
        "" if truth["sigma"] is None else over(lambda t: t["sigma"]["robust_spread"], "{:.2f}"),
        *cost,
    )


def _girth_of_gaps(truth: Json) -> str:
    """The worst girth where it is that of a gap, not of an error of measurement; else nothing."""
    worst = max(truth["girths"], key=lambda one: abs(one["error_mm"]), default=None)
    if worst is None or abs(worst["error_mm"]) < GAP_OF_GIRTH * worst["true_mm"]:
        return ""
    return f"{worst['error_mm']:+.0f} mm: surface is missing there"


def worst_girth_mm(truth: Json) -> float:
    """The largest error of a girth, with its sign."""
    errors = [girth["error_mm"] for girth in truth["girths"]]
    return max(errors, key=abs, default=math.nan)


def _with_spread(value: float, again: Sequence[float], form: str) -> str:
    """A figure, and from where to where it went in the repeats."""
    told = _written(value, form)
    if not again:
        return told
    low, high = _written(min(again), form), _written(max(again), form)
    return told if low == high == told else f"{told} ({low} to {high})"


def _written(value: float, form: str) -> str:
    """A figure; what rounds to nothing has no minus."""
    text = form.format(value)
    return form.format(0.0) if float(text) == 0 else text


def spoiled() -> str:
    """Captures that cannot give a right answer, and what is said of them."""
    heads = ("capture", "what it really is", "exit", "what limbgram says")
    rows = [
        (one["title"], one["truth"], str(one["exit_code"]), one["says"])
        for one in result("spoiled")["captures"]
    ]
    return table(heads, rows) + "\n\n" + _measured_on(("spoiled",))


def intervals() -> str:
    """How often stated 95 % intervals held, each side for itself."""
    return (
        f"{_intervals('intervals_smoothed')}\n\n"
        "Every setting, on other seeds, before rims ended at the cut of a cast:\n\n"
        f"{_intervals('intervals_growth')}"
    )


def _intervals(name: str) -> str:
    settings = {
        "usual": "usual",
        "smooth": "no relief",
        "rough": "2.5 times the relief",
        "fine": "relief down to waves of 2.5 mm",
        "sharp": "twice the resolution",
        "sparse": "8 % painted",
        "bare": "5 % painted",
        "patchy": "half of the paint left out in patches",
        "wrinkled": "15 % painted, wrinkles down to 3 mm",
        "shapes": "scans of other limbs, dense to little paint",
        "skin": "knit, veins, scars and wrinkles",
    }
    heads = ("captures", "figure", "interval holds", "states too little", "states too much",
             "mean error / sigma", "RMS error / sigma")  # fmt: skip
    rows = [
        (
            f"{settings[setting]}, {one['captures']}",
            kind,
            f"{_held(one)} of {one['figures']} ({_held(one) / one['figures']:.1%})",
            f"{one['too_little']}",
            f"{one['too_much']}",
            f"{one['mean_error_over_sigma']:+z.2f}",
            f"{one['rms_error_over_sigma']:.2f}",
        )
        for setting, kinds in result(name)["settings"].items()
        for kind, one in kinds.items()
    ]
    return table(heads, rows) + "\n\n" + _measured_on((name,))


def _held(one: Json) -> int:
    return one["figures"] - one["too_little"] - one["too_much"]


def cost() -> str:
    """Whole runs beside pycolmap's sparse step, and how cost grows with photos and pixels."""
    sets = result("cost")["sets"]
    told = [cost_table(sets)]
    for names, grows in ((BY_PHOTOS, "photos"), (BY_PIXELS, "megapixels")):
        few, many = (sets.get(name) for name in (names[0], names[-1]))
        if few is not None and many is not None:
            told.append(_grown(few, many, grows))
    return "\n\n".join([*told, _measured_on(("cost",))])


def _grown(few: Json, many: Json, grows: str) -> str:
    """In words, from one set to a larger one."""
    runs, more = (finished(one["limbgram"]) for one in (few, many))
    before, after = least(runs, "cpu_s"), least(more, "cpu_s")
    times = many[grows] / few[grows]
    beside = ""
    if few["pycolmap"] and many["pycolmap"]:
        theirs = (least(finished(one["pycolmap"]), "sparse_cpu_s") for one in (few, many))
        beside = "; pycolmap's sparse step {:.0f} to {:.0f}".format(*theirs)
    peaks = [max(run["peak_mb"] for run in of) / 1000 for of in (runs, more)]
    return (
        f"From {few['what']} to {many['what']}, {times:.0f} times as many {grows}, the whole run "
        f"grows {after / before:.1f} times ({before:.0f} to {after:.0f} CPU s{beside}) and its "
        f"peak from {peaks[0]:.1f} to {peaks[1]:.1f} GB."
    )


def real() -> str:
    """What the real captures, which have no true surface, can be held against."""
    sets = result("real")["sets"] | result("skull")["sets"]
    pot, skull = sets["flowerpot"], sets["skull"]
    checks = [one for one in pot["summary"]["scale"]["lengths"] if one["role"] == "check"]
    worst = max(abs(one["error"]) for one in checks)
    return (
        f"A flowerpot on a printed sheet ({pot['photos']} phone photos, no calibration): "
        f"{_placed(pot)} placed; scaled by one printed distance it predicts the other to "
        f"{worst:.2%}. A skull ({skull['photos']} photos, no board): {_placed(skull)} placed, "
        f"camera centres within {skull['poses']['centres_rms_percent_of_radius']:.2f} % of the "
        "ring's radius of the reference. Verdicts:\n\n"
        + "\n".join(
            f"- {LABELS[name]}: {one['accuracy']['headline']}" for name, one in sets.items()
        )
    )


def landmarks() -> str:
    """How far landmarks of an earlier visit come to lie from where the skin went, by kind."""
    return by_kind(result("landmarks")) + "\n\n" + _measured_on(("landmarks",))


def angles() -> str:
    """How far angles are off where landmarks are placed with an error, of feet and of the trunk."""
    cases = result("device_photos")["cases"]
    every = [one for name, one in cases.items() if name.startswith("foot")]
    feet, marked = ([one for one in every if ("marked" in one) is has] for has in (False, True))
    trunks = [one for name, one in cases.items() if name.startswith("trunk")]
    heads = ("angle", "off, marks painted and found in photos", "off (RMS), marks off by 0.5 mm",
             "by 2 mm", "± held, in draws", "most sensitive to")  # fmt: skip
    rows = [
        (name.removesuffix("_deg").replace("_", " "), *_angle_cells(bodies, with_marks, name))
        for bodies, with_marks in ((feet, marked), (trunks, []))
        for name in bodies[0]["angles"]["0.5 mm"]
    ]
    wide = sorted({one["width_px"] for one in feet})
    lengths = "\n".join(
        _lengths_at(width, [one["measures"] for one in feet if one["width_px"] == width])
        for width in wide
    )
    lengths += "\n" + _lengths_at(3000, [one["measures"] for one in marked], ", with marks")
    return f"{table(heads, rows)}\n\n{lengths}\n\n" + _measured_on(("device_photos",))


def _lengths_at(width_px: int, feet: Sequence[Json], how: str = "") -> str:
    """How far lengths and girths of feet are off that were seen in photos of this width."""
    off = [row["off"] for foot in feet for key, row in foot.items() if row and key.endswith("_mm")]
    told = [
        f"{name} off by {_range([foot[key]['off'] for foot in feet], 2)} mm, one standard "
        f"deviation stated as {_range([foot[key]['sigma'] for foot in feet], 2)} mm"
        for name, key in (
            ("foot length", "foot_length_mm"),
            ("heel to second toe", "heel_to_second_toe_mm"),
        )
    ]
    return (
        f"- Photos {width_px} px wide{how}: {sum(abs(one) <= 0.3 for one in off)} of {len(off)} "
        f"lengths and girths within 0.3 mm; {'; '.join(told)}."
    )


def _angle_cells(bodies: Sequence[Json], marked: Sequence[Json], name: str) -> Sequence[str]:
    """Of one angle: errors of the bodies, how often its interval held, its worst landmark."""
    off = [abs(one["marked"]["angles"][name]["off_deg"]) for one in marked]
    drawn = [marks[name] for one in bodies for marks in one["angles"].values()]
    slopes = [(slope, mark) for one in bodies for mark, slope in one["by_landmark"][name].items()]
    slope, mark = max(slopes)
    return (
        _range(off, 2) + " degrees" if off else "not measured",
        *(
            _range([one["angles"][by][name]["rms_deg"] for one in bodies]) + " degrees"
            for by in ("0.5 mm", "2 mm")
        ),
        f"{sum(round(one['held'] * one['draws']) for one in drawn)} of "
        f"{sum(one['draws'] for one in drawn)}",
        f"{mark}, {slope:.1f} degrees a millimetre",
    )


def _range(values: Sequence[float], digits: int = 1) -> str:
    told = dict.fromkeys(f"{one:z.{digits}f}" for one in (min(values), max(values)))
    return " to ".join(told)


def explained_faults() -> str:
    """What is told of each fault at each strength."""
    return by_fault(result("explanations"))


def _placed(one: Json) -> str:
    photos = one["summary"]["photos"]
    return f"{sum(photo['placed'] for photo in photos)} of {len(photos)}"


def _measured_on(files: Sequence[str]) -> str:
    """Where the figures come from: result file, commit, machine."""
    told = [
        f"`{name}.json` (commit {machine['commit'][:12]}, {machine['cores']} cores)"
        for name in files
        for machine in [result(name)["machine"]]
    ]
    return f"From `benchmarks/results`: {', '.join(told)}."


BLOCKS: dict[str, Callable[[], str]] = {
    "short": short,
    "accuracy": accuracy,
    "spoiled": spoiled,
    "intervals": intervals,
    "cost": cost,
    "real": real,
    "landmarks": landmarks,
    "explained-faults": explained_faults,
    "angles": angles,
}

if __name__ == "__main__":
    sys.exit(main())
