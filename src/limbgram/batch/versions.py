"""Versions: whether two machines would make the same bytes of the same capture."""

import hashlib
from collections.abc import Iterable

from limbgram.cases.fingerprint import code_version

_ALWAYS = ("limbgram.batch.attempt_process", "limbgram.cases.job")


def program_version(modules: Iterable[str] = ()) -> str:
    """What results hang on of the program, of Python and of the libraries that are installed.

    Args:
        modules: Whose code is used beside that of a reconstruction: of the steps after it.
    """
    told = "\n".join(code_version(module) for module in (*_ALWAYS, *modules))
    return hashlib.sha256(told.encode()).hexdigest()
