"""Whatever is done to an AOP file, it is read or refused by name; nothing else happens."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from limbgram.core.errors import ShapeFileError
from limbgram.formats.aop.reading import read_aop

LINES = (
    ["AAOP1", "AAOP1", "a comment", "END COMMENTS", "CYLINDRICAL", "LEFT"]
    + ["1", "FIB", "1", "2.362", "90", "10", "5", "72", "3", "0", "0", "5", "20"]
    + ["50", "60", "50", "40", "45"] * 3
)
VALUES = ["nan", "inf", "-1", "1e308", "0", "999999999", "END COMMENTS", "", "é", "1 2", "3600"]


def read_or_refuse(lines: list[str]) -> bool:
    """True if the file was read."""
    try:
        found = read_aop("\n".join(lines).encode("latin-1"), "any.aop")
    except ShapeFileError as error:
        return require_name(error)
    assert np.isfinite(found.radius_map.radii_mm).all()
    assert (np.diff(found.radius_map.z_mm) > 0).all()
    return True


def require_name(error: ShapeFileError) -> bool:
    """A refusal names the file; False, for it was not read."""
    assert "any.aop" in str(error)
    return False


def test_cut_off_after_every_line() -> None:
    whole = [read_or_refuse(LINES[:count]) for count in range(len(LINES) + 1)]
    assert whole == [False] * len(LINES) + [True]


@settings(max_examples=150)
@given(first=st.integers(0, len(LINES) - 1), second=st.integers(0, len(LINES) - 1))
def test_lines_swapped(first: int, second: int) -> None:
    lines = list(LINES)
    lines[first], lines[second] = lines[second], lines[first]
    read_or_refuse(lines)


@settings(max_examples=200)
@given(line=st.integers(0, len(LINES) - 1), value=st.sampled_from(VALUES))
def test_a_line_replaced(line: int, value: str) -> None:
    lines = list(LINES)
    lines[line] = value
    read_or_refuse(lines)


@settings(max_examples=100)
@given(content=st.binary(max_size=400))
def test_any_bytes(content: bytes) -> None:
    try:
        read_aop(b"AAOP1\nAAOP1\n" + content, "any.aop")
    except ShapeFileError as error:
        require_name(error)
