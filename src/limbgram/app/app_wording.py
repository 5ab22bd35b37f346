"""App wording: what the library says, as the app answers it.

Advice has words of its own for the app, steps and buttons in place of commands and options
(`findings`). Nobody before the app need know where the server keeps its files: of their paths the
names alone are told.
"""

import re
from pathlib import Path
from typing import Any

from fastapi.responses import JSONResponse

from limbgram.cases.shelf import Shelf
from limbgram.core.errors import printable
from limbgram.findings import Finding, told

_SENTENCES = "headline line lines message notes photos_note problem"
_REASONS = "reason reasons refusal remark remarks sentence told unreadable why"
SAID = frozenset(f"{_SENTENCES} {_REASONS}".split())
"""Fields of answers that hold sentences for people; `note` is what they wrote themselves."""
_PATH = re.compile(r"(?<![\w:/.<])(?:/[^\s/:;,'\"`()<>]+){2,}|(?<!\w)[A-Za-z]:\\[^\s:;,'\"`()]+")


def plain_answers(shelf: Shelf) -> type[JSONResponse]:
    """JSON whose sentences name no folder of the machine, nor that of the cases."""

    class PlainAnswer(JSONResponse):
        def render(self, content: Any) -> bytes:
            return super().render(_worded(content, shelf.root, said=False))

    return PlainAnswer


def finding_for_app(finding: Finding, root: Path | None = None) -> dict[str, Any]:
    """A finding as the app answers it: without folders of the machine, advice in its words."""
    shown = finding.with_texts(lambda text: printable(without_folders(text, root)))
    return {**shown.tree(), "sentence": told(shown, door="app")}


def without_folders(text: str, root: Path | None = None) -> str:
    """A text with the names of files alone in the place of their paths."""
    if root is not None:
        text = text.replace(f"{root}/", "").replace(str(root), root.name)
    return _PATH.sub(lambda found: re.split(r"[/\\]", found[0])[-1], text)


def _worded(content: Any, root: Path, *, said: bool) -> Any:
    match content:
        case str():
            return without_folders(content, root) if said else content
        case list():
            return [_worded(one, root, said=said) for one in content]
        case {"code": str(), "gravity": str(), "values": dict()}:
            return finding_for_app(Finding.from_tree(content), root)
        case dict():
            return {name: _worded(one, root, said=name in SAID) for name, one in content.items()}
        case _:
            return content
