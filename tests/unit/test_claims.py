"""The figures that are published are those of the result files."""

import importlib
import json
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOK = "A laboratory notebook:"
"""How a page begins whose figures were measured once, by the way, and are no promises."""
MEASURED = re.compile(r"\d[\d.,]*\s?(?:mm\b|px\b|%|s\b|seconds|minutes|GB\b|MB\b|CPU)")


@pytest.fixture(scope="module")
def claims() -> ModuleType:
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        return importlib.import_module("claims")
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))


def test_every_published_block_is_what_its_results_say(claims: ModuleType) -> None:
    for page in claims.PAGES:
        text = page.read_text("utf-8")
        assert claims.made_anew(text) == text, f"{page.name}: run python benchmarks/claims.py"


def test_every_kind_of_block_is_published(claims: ModuleType) -> None:
    text = "".join(page.read_text("utf-8") for page in claims.PAGES)
    assert {block["name"] for block in claims.BLOCK.finditer(text)} == set(claims.BLOCKS)


def test_a_changed_result_changes_the_page(
    claims: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for file in claims.RESULTS.glob("*.json"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    tree = json.loads((tmp_path / "rendered.json").read_text("utf-8"))
    tree["sets"]["limb_ring15"]["accuracy"]["truth"]["rms_mm"] = 9.876
    (tmp_path / "rendered.json").write_text(json.dumps(tree), "utf-8")
    monkeypatch.setattr(claims, "RESULTS", tmp_path)
    claims.result.cache_clear()
    readme = (ROOT / "README.md").read_text("utf-8")
    changed = claims.made_anew(readme)
    claims.result.cache_clear()
    assert "9.876" in changed
    assert "9.876" not in readme


def test_the_readme_types_no_measured_figure_by_hand(claims: ModuleType) -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    by_hand = re.sub(r"```.*?```", "", claims.BLOCK.sub("", text), flags=re.DOTALL)
    assert "limbgram" in by_hand
    assert MEASURED.findall(by_hand) == []


def test_pages_with_figures_of_experiments_say_so() -> None:
    pages = sorted((ROOT / "docs" / "method").glob("*.md"))
    assert len(pages) >= 5
    for page in pages:
        assert NOTEBOOK in page.read_text("utf-8")[:600], page.name


def test_the_front_door_is_short_and_its_moving_picture_light() -> None:
    """Nobody read the README that had 3,987 words and 75 lines of tables."""
    text = (ROOT / "README.md").read_text("utf-8")
    assert len(text.splitlines()) <= 130
    assert sum(line.startswith("|") for line in text.splitlines()) <= 20
    (moving,) = re.findall(r"\((docs/\S+\.gif)\)", text)
    assert (ROOT / moving).stat().st_size < 3_000_000
    still = re.findall(r"!\[[^]]+\]\((docs/\S+\.png)\)", text)
    assert len(still) >= 4
    assert all((ROOT / one).is_file() for one in still)
