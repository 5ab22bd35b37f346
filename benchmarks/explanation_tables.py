"""Tables of what was said of captures: explanations.json for people, and by fault."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from harness import made_on, table

DOORS = ("check", "reconstruct")
_OVER_STATED = "error of 95 %, true / stated, mm"
UNDECIDED = (
    "movement.unknown", "movement.shape.unknown", "board.stretched_or_lens", "board.bent_or_lens",
    "scale.cause.board_or_lens",
)  # fmt: skip
"""Codes that name a second cause beside the first, and what would decide."""
ASKS = (
    "placing.too_few", "placing.torn", "placing.no_start", "placing.photo.other_group",
    "placing.photo.alone", "placing.photo.few_agree", "placing.photo.loose",
)  # fmt: skip
"""Codes that blame nothing: photos stand too far apart, or show too little, to be joined."""
UNTOLD = ("silent", "undecided")
"""Outcomes of a fault that is not told."""
_TWO = ("two casts beside one board",)
"""Of the clinic's folders, those that are not sound."""


def outcome(one: dict[str, Any], door: str) -> str:
    """How a door did: of sound captures false or right, of faults what it told."""
    found = one[door]
    if not _is_fault(one):
        if found["accused"]:
            return "accused"
        if any(code.startswith(ASKS) for code in found["said"]):
            return "asks for photos"
        return "refused" if found["refused"] else "set aside" if found["aside"] else "right"
    if found["told"]:
        return "told beside another cause" if found["accused"] else "told"
    if found["accused"]:
        return "another cause"
    if any(code.startswith(UNDECIDED) for code in found["said"]):
        return "undecided"
    return "refused" if found["refused"] else "silent"


def _is_fault(one: dict[str, Any]) -> bool:
    return one["family"] == "faults" or one["row"] in _TWO


def page(result: dict[str, Any]) -> str:
    """The table for people."""
    captures: dict[str, dict[str, Any]] = result["captures"]
    parts = ["# What is said of sound captures, and of faults"]
    if "machine" in result:
        parts.append(made_on(result["machine"]))
    heads = (
        "family",
        "row",
        "strength",
        "captures",
        *DOORS,
        _OVER_STATED,
        "CPU s a door",
        "commit",
    )
    rows: list[Sequence[str]] = []
    for family, row, strength in dict.fromkeys(_group(one) for one in captures.values()):
        own = [one for one in captures.values() if _group(one) == (family, row, strength)]
        cpu = np.median([one[door]["cpu_s"] for one in own for door in DOORS if door in one])
        counts = [_counted(outcome(one, door) for one in own if door in one) for door in DOORS]
        commits = ", ".join(dict.fromkeys(one["commit"] for one in own))
        over = ", ".join(_over_stated(one) for one in own if "surface" in one)
        rows.append((family, row, strength, str(len(own)), *counts, over, f"{cpu:.0f}", commits))
    parts.append(table(heads, rows))
    answers = [(name, one, door) for name, one in captures.items() for door in DOORS if door in one]
    sound = [one for one in answers if not _is_fault(one[1])]
    for title, asked, listed in (
        ("Sound captures: false accusations", sound, ("accused",)),
        ("Sound captures: refused, or photos set aside", sound, ("refused", "set aside")),
        ("Faults: another cause named, alone or beside the true one",
         [one for one in answers if one not in sound],
         ("another cause", "told beside another cause")),
    ):  # fmt: skip
        found = [one for one in asked if outcome(one[1], one[2]) in listed]
        parts.append(f"{title}: {len(found)} answers of {len(asked)}.")
        parts.append("\n".join(_line(*one) for one in found))
    silent = _silent_with_surface(result)
    lies = [one for one in silent if _stated_too_little(one[1])]
    parts.append(
        f"Faults silent in reconstruct, true error beyond the stated one: {len(lies)} of "
        f"{len(silent)} whose surface was made."
    )
    parts.append("\n".join(f"- {name}: {_over_stated(one)}" for name, one in lies))
    return "\n\n".join(filter(None, parts)).rstrip() + "\n"


def by_fault(result: dict[str, Any]) -> str:
    """What `reconstruct` says of each fault at each strength, and what all answers share."""
    captures: dict[str, dict[str, Any]] = result["captures"]
    faults = [
        one for one in captures.values() if one["family"] == "faults" and "reconstruct" in one
    ]
    rows: list[Sequence[str]] = []
    for row in dict.fromkeys(one["row"] for one in faults):
        outcomes: dict[str, list[str]] = {}
        for one in faults:
            if one["row"] == row:
                outcomes.setdefault(one["strength"], []).append(outcome(one, "reconstruct"))
        told = [f"{name}: {_counted(outcomes[name])}" for name in sorted(outcomes, key=_in_order)]
        rows.append((row, "; ".join(told)))
    answers = [(one, door) for one in captures.values() for door in DOORS if door in one]
    of_faults = [outcome(*one) for one in answers if _is_fault(one[0])]
    of_sound = [outcome(*one) for one in answers if not _is_fault(one[0])]
    wrong = sum("another cause" in one for one in of_faults)
    silent = _silent_with_surface(result)
    lies = sum(_stated_too_little(one) for _, one in silent)
    return "\n\n".join(
        (
            table(("fault", "what `reconstruct` says, by strength, in captures"), rows),
            f"Another cause is named in {wrong} of {len(of_faults)} answers about faults. Limb, "
            f"board, camera or a photo is accused in {of_sound.count('accused')} of "
            f"{len(of_sound)} answers about sound captures. Where a fault stays silent, the true "
            f"error of the surface exceeds the stated one in {lies} of {len(silent)} surfaces.",
        )
    )


def _silent_with_surface(result: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Names and rows of faults that `reconstruct` does not tell and whose surface was made."""
    return [
        (name, one)
        for name, one in result["captures"].items()
        if "surface" in one and "reconstruct" in one and outcome(one, "reconstruct") == "silent"
    ]


def _in_order(strength: str) -> tuple[float, str]:
    """Strengths in the order of their number; those without one first."""
    number = re.match(r"[0-9.]+", strength)
    return (float(number[0]) if number else 0.0, strength)


def _over_stated(one: dict[str, Any]) -> str:
    """True and stated error, and their ratio."""
    true, stated = one["surface"]["true_p95_mm"], one["surface"]["stated_p95_mm"]
    if stated is None:
        return f"{true:.2f} / none stated"
    return f"{true:.2f} / {stated:.2f} = {true / stated:.2f}"


def _stated_too_little(one: dict[str, Any]) -> bool:
    stated = one["surface"]["stated_p95_mm"]
    return stated is not None and one["surface"]["true_p95_mm"] > stated


def _line(name: str, one: dict[str, Any], door: str) -> str:
    found = one[door]
    strength = f"; {one['strength']}" if one["family"] == "sound" else ""
    codes = found["accused"] or list(filter(None, [found["refused"]]))
    aside = f"; {len(found['aside'])} photos set aside" if found["aside"] else ""
    what = f"{', '.join(codes)}{aside}"
    return f"- {name} ({one['row']}{strength}), {door}, {one['commit'][:7]}: {what}"


def _group(one: dict[str, Any]) -> tuple[str, str, str]:
    return one["family"], one["row"], one["strength"] if one["family"] != "sound" else ""


def _counted(outcomes: Iterable[str]) -> str:
    found = list(outcomes)
    return ", ".join(f"{found.count(one)} {one}" for one in dict.fromkeys(sorted(found)))


def in_short(found: dict[str, Any]) -> str:
    return "; ".join(
        f"{door}: {outcome(found, door)} {found[door]['told']} {found[door]['accused']} "
        f"{found[door]['refused']} aside {len(found[door]['aside'])}, {found[door]['cpu_s']} s"
        for door in DOORS
        if door in found
    )
