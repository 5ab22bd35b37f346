"""App wording: findings and sentences of the library, worded for the app's answers.

Advice has a wording of its own for the app, with steps and buttons instead of commands and options
(`findings`). Paths on the server are reduced to file names.
"""

import re
from pathlib import Path
from typing import Any

from fastapi.responses import JSONResponse

from limbgram.cases.shelf import Shelf
from limbgram.core.errors import printable
from limbgram.findings import Finding, told

_SENTENCES = "headline line lines message notes"
_REASONS = "reason reasons refusal remark remarks sentence told unreadable why"
SAID = frozenset(f"{_SENTENCES} {_REASONS}".split())
"""Fields of answers that hold sentences for people; `note` is what they wrote themselves."""
_PATH = re.compile(r"(?<![\w:/.<])(?:/[^\s/:;,'\"`()<>]+){2,}|(?<!\w)[A-Za-z]:\\[^\s:;,'\"`()]+")


def plain_answers(shelf: Shelf) -> type[JSONResponse]:
    """JSON answers whose sentences name no folder of the server."""

    class PlainAnswer(JSONResponse):
        def render(self, content: Any) -> bytes:
            return super().render(_worded(content, shelf.root, said=False))

    return PlainAnswer


def finding_for_app(finding: Finding, root: Path | None = None) -> dict[str, Any]:
    """A finding as the app answers it: without folders of the server, with the app's advice."""
    shown = _shown(finding, root)
    return {**shown.tree(), "sentence": told(shown, door="app")}


def sentences_for_app(finding: Finding, root: Path, language: str) -> str:
    """The same in the words of a language."""
    return told(_shown(finding, root), language, door="app")


def _shown(finding: Finding, root: Path | None) -> Finding:
    return finding.with_texts(lambda text: printable(without_folders(text, root)))


def without_folders(text: str, root: Path | None = None) -> str:
    """A text with paths reduced to file names."""
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
