"""How the sources lie: every module says what it is."""

from pathlib import Path

import pytest

import limbgram

PACKAGE = Path(limbgram.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))


def test_the_package_is_looked_at() -> None:
    assert len(FILES) > 50
    assert PACKAGE / "reconstruction" / "pipeline.py" in FILES


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(PACKAGE)))
def test_every_module_says_what_it_is(file: Path) -> None:
    content = file.read_text("utf-8").strip()
    assert not content or content.startswith(('"""', 'r"""')), "a module begins with its docstring"
