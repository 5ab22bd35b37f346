"""Ids and names of what a shelf keeps beside its cases: cameras and templates."""

import re
import secrets

ID_PATTERN = "^[a-z0-9]{8}$"
_ID = re.compile(ID_PATTERN)
_LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"
"""Without those that are easily misread for one another."""
LONGEST_NAME = 80


def new_id() -> str:
    """An id that nobody guesses and that is a plain name for a file."""
    return "".join(secrets.choice(_LETTERS) for _ in range(8))


def is_id(name: str) -> bool:
    """Whether a name is that of something kept: other files may lie beside it."""
    return _ID.fullmatch(name) is not None
