"""What CONTRIBUTING.md names is there: files, folders, and the names that a recipe sends you to."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
PLACES = ("", "src/limbgram", "src/limbgram/workbench", "src/limbgram/reconstruction")
"""A recipe may leave out the folders that its neighbours have named."""
MADE = {
    ".venv/bin/activate",
    "formats/NAME.py",
    "workbench/edits/NAME.py",
    "demo/case/report.html",
    "build/site",
}
"""Not there yet: what a recipe has you make."""
NAMED_IN = re.compile(
    r"`(_?[A-Za-z]\w+)` (?:of|in)\s+`([\w./]+\.py)`|`([\w./]+\.py)` \(`(_?\w+)`\)"
)


def paths() -> list[str]:
    """Every word with a slash, or with the ending of a file, in quotes of code or in a block."""
    blocks = re.findall(r"```\n(.*?)```", TEXT, re.DOTALL)
    words = [word for code in re.findall(r"`([^`\n]+)`", TEXT) for word in code.split()]
    words += [word for block in blocks for word in block.split()]
    likely = re.compile(r"[\w.-]*/[\w./*-]*|[\w-]+\.(?:py|md|toml|txt|css|html)")
    return sorted({word for word in words if likely.fullmatch(word)} - MADE)


def found(path: str) -> list[Path]:
    return [file for place in PLACES for file in (ROOT / place).glob(path.rstrip("/"))]


def test_every_path_is_there() -> None:
    assert [path for path in paths() if not found(path)] == []


def test_paths_are_found_at_all() -> None:
    assert len(paths()) > 40
    assert not found("report/page.py")


@pytest.mark.parametrize("match", [*NAMED_IN.finditer(TEXT)], ids=lambda match: match[0])
def test_every_name_stands_in_its_file(match: re.Match[str]) -> None:
    name, path = (match[1], match[2]) if match[1] else (match[4], match[3])
    (file,) = found(path)
    assert re.search(rf"\b{name}\b", file.read_text("utf-8")), f"{name} in {path}"
