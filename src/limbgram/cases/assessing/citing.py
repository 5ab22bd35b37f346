"""Citing: what a finished case says of its own accuracy, for the record of a shape made from it."""

from typing import Any

from limbgram.cases.folder import CaseFolder
from limbgram.cases.keeping.fingerprint import file_sha256
from limbgram.cases.keeping.seal import unsealed
from limbgram.errors import CaseError
from limbgram.files import json_of
from limbgram.report.document.trees import ACCURACY_SCHEMA
from limbgram.report.shape.record import CaseSource


def cited(case: CaseFolder) -> CaseSource:
    """The case's accuracy and the hashes of what it delivered.

    Raises:
        CaseError: the folder is no case with an accuracy.json in millimetres.
    """
    try:
        accuracy: dict[str, Any] = json_of(case.accuracy("json").read_bytes())
        record = json_of(case.record.read_bytes())
        schema, unit, truth = accuracy["schema"], accuracy["unit"], accuracy["truth"]
        files = frozenset(str(file["sha256"]) for file in record["files"])
        hash_of_record = file_sha256(case.record)
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        raise CaseError(
            f"{case.root} is no finished case with an accuracy.json that can be read. Name the "
            "folder that `limbgram reconstruct` was given by -o, or run `limbgram accuracy` on it."
        ) from error
    if schema != ACCURACY_SCHEMA:
        raise CaseError(
            f"The accuracy.json of {case.root} is of another version ({schema}). Run `limbgram "
            "accuracy` on the case again."
        )
    try:
        accuracy = unsealed(accuracy)
    except LookupError as error:
        raise CaseError(
            f"The accuracy.json of {case.root} is not as it was written: it is damaged, was "
            "edited, or is older than this version. Run `limbgram accuracy` on the case again."
        ) from error
    if truth is not None:
        raise CaseError(
            f"The accuracy.json of {case.root} is a comparison with a truth, not what the case "
            "says of itself. Run `limbgram accuracy` on the case again, without --truth."
        )
    if unit != "mm":
        raise CaseError(
            f"The case {case.root} has no scale, so nothing in it is in millimetres. Leave --case "
            "out, or reconstruct with a board or known distances."
        )
    return CaseSource(sha256=hash_of_record, accuracy=accuracy, files=files)
