"""Tables of landmarks that were carried over, for people: by kind, limb and landmark."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from harness import made_on, table

INSIDE: Final = 2.448
"""Standard deviations of one direction within which 95 of 100 places of a plane lie."""
_FIGURES = ("proposed", "refused", "gone, yet proposed", "RMS mm", "95 % mm", "stated RMS mm",
            "inside", "without allowance")  # fmt: skip
_HEADS = ("", "pairs", *_FIGURES)


def rms(values: Sequence[float]) -> float:
    """Root mean square; NaN of none."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")


def page(result: dict[str, Any]) -> str:
    """By kind, by landmark, and what was refused."""
    rows = list(result["pairs"].values())
    commits = dict.fromkeys(row["commit"][:12] for row in rows)
    return (
        "\n\n".join(
            [
                f"# Landmarks of an earlier visit, half of shapes and seeds: {result['half']}",
                f"{made_on(result['machine'])}; rows of commits {', '.join(commits)}",
                "Errors along the surface of places that the later scan holds; inside: shorter "
                f"than {INSIDE} standard deviations of one direction; and without what is assumed "
                "of skin that slides. Refused: of those that the scan holds.",
                "## By kind",
                by_kind(result),
                "## By limb",
                table(_HEADS, [_by(rows, kind, limb, limb) for kind, limb in _limbs(rows)]),
                "## By landmark",
                *(
                    part
                    for kind in _kinds(rows)
                    for part in (f"### {kind}", _landmarks(rows, kind))
                ),
                "\n".join(_reasons(rows)),
            ]
        )
        + "\n"
    )


def by_kind(result: dict[str, Any]) -> str:
    """A row for each kind of limb, and one for all."""
    rows = list(result["pairs"].values())
    every = [one for kind in _kinds(rows) for _, one in marks_of(rows, kind)]
    whole = ("all", f"{len(rows)}", *summary(every))
    return table(_HEADS, [*(_by(rows, kind, kind) for kind in _kinds(rows)), whole])


def _kinds(rows: Sequence[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(row["kind"] for row in rows))


def _limbs(rows: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    return sorted(dict.fromkeys((row["kind"], row["limb"]) for row in rows))


def marks_of(rows: Sequence[dict[str, Any]], kind: str, limb: str = "") -> list[tuple[str, Any]]:
    """Name and figures of each landmark of the pairs of a kind."""
    return [
        mark
        for row in rows
        if row["kind"] == kind and (not limb or row["limb"] == limb) and not row["refused"]
        for mark in row["landmarks"].items()
    ]


def _by(rows: Sequence[dict[str, Any]], kind: str, label: str, limb: str = "") -> Sequence[str]:
    own = [row for row in rows if row["kind"] == kind and (not limb or row["limb"] == limb)]
    marks = [mark for _, mark in marks_of(rows, kind, limb)]
    none = sum(bool(row["refused"]) for row in own)
    pairs = f"{len(own)}" + (f" ({none} refused)" if none else "")
    return (label if not limb else f"{kind}, {label}", pairs, *summary(marks))


def summary(marks: Sequence[dict[str, Any]]) -> Sequence[str]:
    """Figures of landmarks, as cells."""
    held = [one for one in marks if not one.get("gone")]
    told = [one for one in held if "off_mm" in one]
    wrong = sum("off_mm" in one for one in marks if one.get("gone"))
    off = [one["off_mm"] for one in told]
    stated = [float(np.hypot(one["carrying_mm"], one["sliding_mm"])) for one in told]
    inside = np.less(off, INSIDE * np.array(stated))
    alone = [one["off_mm"] < INSIDE * one["carrying_mm"] for one in told]
    if not told:
        return (f"0 of {len(held)}", "", f"{wrong}", "", "", "", "", "")
    return (
        f"{len(told)} of {len(held)}",
        f"{1 - len(told) / len(held):.1%}",
        f"{wrong} of {len(marks) - len(held)}",
        f"{rms(off):.2f}",
        f"{np.quantile(off, 0.95):.2f}",
        f"{np.sqrt(2) * rms(stated):.2f}",
        f"{np.mean(inside):.1%}",
        f"{np.mean(alone):.1%}",
    )


def _landmarks(rows: Sequence[dict[str, Any]], kind: str) -> str:
    marks = marks_of(rows, kind)
    names = dict.fromkeys(name for name, _ in marks)
    return table(
        ("landmark", *_FIGURES),
        [(name, *summary([one for own, one in marks if own == name])) for name in names],
    )


def _reasons(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    """How often each reason was given, of places that the scan holds and of others."""
    for kind in _kinds(rows):
        marks = [one for _, one in marks_of(rows, kind) if "refused" in one]
        codes = sorted({one["refused"] for one in marks})
        told = ", ".join(
            f"{code} {sum(one['refused'] == code for one in marks if not one.get('gone'))} + "
            f"{sum(one['refused'] == code for one in marks if one.get('gone'))} gone"
            for code in codes
        )
        yield f"- {kind}: {told or 'none refused'}"
