"""The page: one HTML file that holds everything, asks nothing of the network, runs no script.

In      the summary (report.summary) and the pictures.
Out     HTML text.
"""

from collections.abc import Sequence
from html import escape
from typing import Any

from limbgram.report.document.page import document, figure_html, table
from limbgram.report.parts import parts_section
from limbgram.report.pictures import Pictures

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif;
  color: #22303a; background: #fff; max-width: 66rem; margin: 2rem auto 4rem; padding: 0 1.2rem; }
h1 { font-size: 1.5rem; margin: 0 0 .4rem; } h2 { font-size: 1.1rem; margin: 2.2rem 0 .5rem; }
.verdict { font-size: 1.15rem; border-left: .6rem solid; padding: .6rem .9rem; }
.verdict b { color: #fff; border-radius: .3rem; padding: .05rem .6rem; margin-right: .6rem;
  letter-spacing: .04em; }
.verdict ul { font-size: .95rem; margin: .4rem 0 0; }
.verdict.green { border-color: #2f7d4f; background: #f0f7f2; } .green b { background: #2f7d4f; }
.verdict.amber { border-color: #a8690a; background: #fdf6ea; } .amber b { background: #a8690a; }
.verdict.red { border-color: #b8403a; background: #fbf0ef; } .red b { background: #b8403a; }
.use { color: #5c6a73; } figure { margin: 0 0 1.6rem; } img { max-width: 100%; height: auto; }
figcaption { color: #46545d; font-size: .92rem; max-width: 52rem; }
table { border-collapse: collapse; font-size: .88rem; } td, th { padding: .2rem .8rem .2rem 0;
  text-align: left; vertical-align: top; border-bottom: 1px solid #e4e9ec; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
tr.bad td { color: #b8403a; } .wide { overflow-x: auto; }
"""

_STAGES = {
    "read photos": "Read the photos",
    "cameras for": "Cameras",
    "detect": "Feature points",
    "match": "Matches",
    "verify": "Pairs",
    "place": "Place the photos",
    "find board": "Find the board",
    "to millimetres": "Scale",
    "find region": "Find the limb",
    "estimate depth": "Depth",
    "fuse": "Points",
    "pivot": "Surface (Ball Pivoting)",
    "poisson": "Surface (Poisson)",
    "tell parts": "Parts",
    "repair": "Repair",
    "refine": "Even triangles",
    "measure": "Measure the surface",
    "draw": "Pictures",
    "hold tapes": "Taped girths",
    "deliver": "Files",
    "assess": "Accuracy",
    "assess case": "Accuracy",
    "calibrate": "Calibrate the camera",
    "make capture": "Photograph a synthetic limb",
}


def stage_title(stage: str) -> str:
    """A stage's name for people."""
    return _STAGES.get(stage.replace("_", " "), stage.replace("_", " ").capitalize())


def page_of(summary: dict[str, Any], drawn: Pictures, title: str) -> str:
    """The report as one self-contained page."""
    sections = (
        f"<h1>{escape(title)}</h1>",
        _verdict(summary["verdict"]),
        '<p><a href="accuracy.html">How accurate is it, and what limits it?</a></p>',
        f'<p class="use">{escape(summary["intended_use"])}</p>',
        parts_section(summary["parts"], summary["unit"]),
        *(figure_html(picture) for picture in drawn.pictures),
        "<h2>Known lengths</h2>",
        _lengths(summary),
        "<h2>Photos</h2>",
        _photos(summary["photos"]),
        _set_aside(summary["set_aside"]),
        "<h2>Stages</h2>",
        *(f"<p>{escape(note)}</p>" for note in summary["resolution"]["notes"]),
        _stages(summary["stages"]),
    )
    return document(title, sections, _STYLE)


def _verdict(verdict: dict[str, Any]) -> str:
    """The light that the accuracy has, in its colour and in words, and every reason for it."""
    word = verdict["light"].upper()
    said = verdict["headline"].removeprefix(word).lstrip(": ")
    others = [reason for reason in verdict["reasons"] if reason not in said]
    items = "".join(f"<li>{escape(reason)}</li>" for reason in others)
    return (
        f'<div class="verdict {verdict["light"]}"><b>{word}</b>{escape(said)}'
        + (f"<ul>{items}</ul>" if items else "")
        + f'</div>\n<p class="use">{escape(verdict["facts"])}</p>'
    )


def _lengths(summary: dict[str, Any]) -> str:
    lengths = summary["scale"]["lengths"]
    if not lengths:
        return "<p>None: nothing says how large this is.</p>"
    rows = [
        (
            length["label"],
            length["role"],
            f"{length['known_mm']:.3f}",
            f"{length['measured_mm']:.3f}",
            f"{100 * length['error']:+.3f} %",
        )
        for length in sorted(lengths, key=lambda length: length["role"])
    ]
    note = "<p>Control lengths set the scale; check lengths did not, so they test it.</p>"
    heads = ("length", "role", "#known mm", "#measured mm", "#error")
    return note + table(heads, rows)


def _photos(photos: Sequence[dict[str, Any]]) -> str:
    rows = [
        (
            photo["name"],
            "placed" if photo["placed"] else "not placed",
            f"{photo['features']:,}",
            f"{photo['points']:,}",
            "" if photo["rms_px"] is None or not photo["placed"] else f"{photo['rms_px']:.3f}",
            " ".join((photo["reason"], *photo["remarks"])).strip(),
        )
        for photo in photos
    ]
    heads = ("photo", "verdict", "#features", "#points", "#residual px", "remarks")
    return table(heads, rows, [not photo["placed"] for photo in photos])


def _set_aside(parts: Sequence[dict[str, str]]) -> str:
    if not parts:
        return ""
    rows = [(part["name"], part["reason"]) for part in parts]
    return "<h2>Set aside</h2>" + table(("what", "why"), rows)


def _stages(stages: Sequence[dict[str, Any]]) -> str:
    rows = [
        (
            stage_title(stage["stage"]),
            f"{stage['wall_s']:.1f}",
            f"{stage['cpu_s']:.1f}",
            "" if stage["peak_mb"] is None else f"{stage['peak_mb']:.0f}",
            "taken from the last run" if stage["reused"] else "",
        )
        for stage in stages
    ]
    wall_s, cpu_s = (sum(stage[kind] for stage in stages) for kind in ("wall_s", "cpu_s"))
    rows.append(("All", f"{wall_s:.1f}", f"{cpu_s:.1f}", "", ""))
    return table(("stage", "#seconds", "#CPU seconds", "#peak MB", ""), rows)
