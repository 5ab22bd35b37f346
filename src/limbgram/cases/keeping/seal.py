"""Seals: a JSON record that holds the hash of its own text, so that a changed figure is noticed.

A seal guards against damage and against editing by hand, not against forgery: whoever can write
the file can seal it again.
"""

import hashlib
import json
from typing import Any

_SEAL = "seal"


def sealed(record: dict[str, Any]) -> dict[str, Any]:
    """The record with its seal."""
    text = json.dumps(record, allow_nan=False)
    return {**record, _SEAL: hashlib.sha256(text.encode()).hexdigest()}


def unsealed(record: dict[str, Any]) -> dict[str, Any]:
    """The record without its seal.

    Raises:
        LookupError: it has none, or is not what was sealed.
    """
    plain = {name: value for name, value in record.items() if name != _SEAL}
    if sealed(plain) != record:
        raise LookupError("not what was sealed")
    return plain
