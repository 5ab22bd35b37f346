"""The names of the library: each is imported, says what it is, and stands in the documentation."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import limbgram

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "library" / "reference").glob("*.md"))
DOCUMENTED = re.compile(r"^\.\. (?:autofunction|autoclass|py:data):: (\w+)$", re.MULTILINE)


@pytest.mark.parametrize("name", limbgram.__all__)
def test_every_name_can_be_imported_and_says_what_it_is(name: str) -> None:
    found = getattr(limbgram, name)
    assert (found.__doc__ or "").strip()
    if callable(found):
        assert found.__module__.startswith("limbgram.")


def test_every_name_stands_in_the_documentation_once() -> None:
    documented = [name for page in PAGES for name in DOCUMENTED.findall(page.read_text("utf-8"))]
    assert sorted(documented) == sorted(limbgram.__all__)


def test_a_name_that_is_not_there_is_refused() -> None:
    with pytest.raises(AttributeError):
        limbgram.no_such_name  # noqa: B018


def test_importing_the_library_loads_none_of_its_rooms() -> None:
    program = "import sys, limbgram; print([name for name in sys.modules if 'limbgram.' in name])"
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert said.stdout.strip() == "[]", said.stderr
