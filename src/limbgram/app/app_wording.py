"""App wording: what the library says, in the words of the app.

The library speaks to whoever called it, and most often that is the command line: its sentences name
commands, their options and folders of the machine. People who sit before the app have steps and
buttons in place of these, and need not know where the server keeps its files.
"""

import re
from pathlib import Path
from typing import Any

from fastapi.responses import JSONResponse

from limbgram.core.errors import AS_IS, printable
from limbgram.findings import Finding, told

_SENTENCES = "headline line lines message notes photos_note problem"
_REASONS = "reason reasons refusal remark remarks sentence told unreadable why"
SAID = frozenset(f"{_SENTENCES} {_REASONS}".split())
"""Fields of answers that hold sentences for people; `note` is what they wrote themselves."""
_STEPS = {
    "align": "the step Align",
    "measure": "the step Measure",
    "edit accept": "“Is meant”",
    "edit": "the step Rectify",
    "template learn": "“Learn one” in the step Rectify",
    "export": "the step Send",
    "report": "the step Record",
    "reconstruct": "“Compute shape”",
    "accuracy": "“Compute shape”",
    "calibrate": "the page Cameras",
    "app": "the program on the clinic's machine",
}
"""Of a command, the longest first where one begins as another; what the app has in its place."""
_SETTINGS = {
    "accept": "“Is meant”",
    "align": "alignment",
    "anterior": "the front",
    "axis": "the axis",
    "board": "the board",
    "camera": "the camera",
    "case": "the case",
    "colour": "the colour",
    "kind": "the kind of limb",
    "known-distance": "a known distance",
    "landmark": "a landmark",
    "memory": "the memory",
    "part": "part",
    "proximal": "the proximal direction",
    "side": "the side",
    "sock": "the sock",
    "tape": "a tape",
    "triangles": "triangles",
    "unit": "the unit",
}
"""Of an option, likewise; any other one is called the setting of its name."""
_COMMAND = re.compile(r"([Rr]un )?`?limbgram ((?:[a-z][a-z-]*)(?: (?:accept|learn))?)([^`\n]*)`")
_EXAMPLE = re.compile(r", such as --[^,.;:]+(?:\.\d[^,.;:]*)?")
_OPTION = re.compile(r"(?<![\w-])--([a-z][a-z-]*[a-z])=?")
_SHORT = re.compile(r",? (?:by|with) -o\b")
_DOUBLE = re.compile(r"\b(a|an|the|stated) (?:a|the) (?=\w)")
_START = re.compile(r"(^|[.!?] )([at])(?=(?:he)? (?:step|page|axis|front|side|tape|landmark)\b)")
_PATH = re.compile(r"(?<![\w:/.<])(?:/[^\s/:;,'\"`()<>]+){2,}|(?<!\w)[A-Za-z]:\\[^\s:;,'\"`()]+")


def plain_answers(root: Path) -> type[JSONResponse]:
    """JSON whose sentences are in the words of the app; the cases lie in the folder."""

    class PlainAnswer(JSONResponse):
        def render(self, content: Any) -> bytes:
            return super().render(_plain_in(content, root, said=False))

    return PlainAnswer


def finding_for_app(finding: Finding, root: Path | None = None) -> dict[str, Any]:
    """A finding as the app answers it: without folders of the machine, advice in its words."""
    change = plain if finding.code == AS_IS else without_folders
    shown = finding.with_texts(lambda text: printable(change(text, root)))
    return {**shown.tree(), "sentence": told(shown, door="app")}


def plain(text: str, root: Path | None = None) -> str:
    """A sentence without commands, options and folders of the machine."""
    text = without_folders(text, root)
    text = _COMMAND.sub(_step, _EXAMPLE.sub("", text))
    text = _OPTION.sub(_setting, _SHORT.sub("", text)).replace("`", "")
    text = _DOUBLE.sub(r"\1 ", text)
    return _START.sub(lambda at: at[1] + at[2].upper(), text)


def without_folders(text: str, root: Path | None = None) -> str:
    """A text with the names of files alone in the place of their paths."""
    if root is not None:
        text = text.replace(f"{root}/", "").replace(str(root), root.name)
    return _PATH.sub(lambda found: re.split(r"[/\\]", found[0])[-1], text)


def _step(found: re.Match[str]) -> str:
    name = found[2]
    known = _STEPS.get(name) or _STEPS.get(name.partition(" ")[0])
    words = known or f"“{name.replace('-', ' ')}”"
    run = found[1] or ""
    return f"{'Use' if run[:1] == 'R' else 'use'} {words}" if run else words


def _setting(found: re.Match[str]) -> str:
    known = _SETTINGS.get(found[1]) or f"the setting “{found[1].replace('-', ' ')}”"
    return f"{known} " if found[0].endswith("=") else known


def _plain_in(content: Any, root: Path, *, said: bool) -> Any:
    match content:
        case str():
            return plain(content, root) if said else content
        case list():
            return [_plain_in(one, root, said=said) for one in content]
        case {"code": str(), "gravity": str(), "values": dict()}:
            return finding_for_app(Finding.from_tree(content), root)
        case dict():
            return {name: _plain_in(one, root, said=name in SAID) for name, one in content.items()}
        case _:
            return content
