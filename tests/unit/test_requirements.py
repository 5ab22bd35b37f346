"""The kept lists of versions answer to what pyproject.toml allows."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
ASKED = re.compile(r"([\w-]+)>=([\d.]+)$")


def pinned(name: str) -> dict[str, tuple[int, ...]]:
    """Version of each library in a list; what follows the numbers, such as .post1, left out."""
    lines = (ROOT / "requirements" / name).read_text("utf-8").splitlines()
    found = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {library: numbers(version) for library, version in found}


def numbers(version: str) -> tuple[int, ...]:
    """1.20.0 as (1, 20): zeros at the end mean nothing."""
    found = [int(part) for part in version.split(".") if part.isdigit()]
    while found and not found[-1]:
        found.pop()
    return tuple(found)


def allowed(*requirements: list[str]) -> dict[str, tuple[int, ...]]:
    """Lower bound of each library."""
    asked = [ASKED.match(one) for listed in requirements for one in listed]
    assert None not in asked, "every library has one bound, the oldest version that works"
    return {one[1].lower(): numbers(one[2]) for one in asked if one is not None}


def test_the_oldest_versions_are_those_that_are_allowed() -> None:
    lowest = pinned("lowest.txt")
    bounds = allowed(PROJECT["dependencies"], EXTRAS["heif"], EXTRAS["raw"])
    assert len(bounds) > 10
    for library, bound in bounds.items():
        assert lowest[library][: len(bound)] == bound, f"{library}: make requirements anew"


@pytest.mark.parametrize("extra", ["", *EXTRAS])
def test_the_tested_versions_hold_every_library_and_are_allowed(extra: str) -> None:
    tested = pinned("tested.txt")
    for library, bound in allowed(EXTRAS[extra] if extra else PROJECT["dependencies"]).items():
        assert tested[library] >= bound, f"{library}: make requirements anew"
