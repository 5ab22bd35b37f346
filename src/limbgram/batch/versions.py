"""Versions: whether two machines would make the same bytes of the same capture."""

import hashlib
from collections.abc import Iterable

from limbgram.cases.fingerprint import code_version

_ALWAYS = ("limbgram.batch.attempt_process", "limbgram.cases.job")


def program_version(modules: Iterable[str] = ()) -> str:
    """Hash of all that results depend on in the program, Python and the installed libraries.

    Args:
        modules: Modules of the steps after the reconstruction.
    """
    versions = "\n".join(code_version(module) for module in (*_ALWAYS, *modules))
    return hashlib.sha256(versions.encode()).hexdigest()
