"""How the sources lie: files a person can read at a sitting, folders that fit one screen."""

from pathlib import Path

import pytest

import limbgram

PACKAGE = Path(limbgram.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
FOLDERS = sorted({file.parent for file in FILES})


def test_the_package_is_looked_at() -> None:
    assert len(FILES) > 50
    assert PACKAGE / "cases" in FOLDERS


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(PACKAGE)))
def test_no_file_is_longer_than_300_lines(file: Path) -> None:
    assert len(file.read_text("utf-8").splitlines()) <= 300


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_no_folder_has_more_than_eight_files(folder: Path) -> None:
    allowed = {"__init__.py"}
    if folder == PACKAGE:
        allowed |= {"errors.py", "run.py", "pipeline.py"}
    names = {file.name for file in folder.glob("*.py")} - allowed
    assert len(names) <= 8, sorted(names)


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(PACKAGE)))
def test_every_module_says_what_it_is(file: Path) -> None:
    content = file.read_text("utf-8").strip()
    assert not content or content.startswith(('"""', 'r"""')), "a module begins with its docstring"
