"""Kept products: those of a finished case from which its accuracy is read; nothing is computed.

What is read is what the finished run kept, to the byte: the keys stand in case.json, the hashes
beside the products, those of the photos among them.
"""

import json
from collections.abc import Iterable
from typing import Any, TypeVar, cast

from limbgram.calibration.cameras import Cameras
from limbgram.cases.folder import CaseFolder
from limbgram.cases.keeping.fingerprint import file_sha256
from limbgram.cases.keeping.store import read_product
from limbgram.errors import CaseError
from limbgram.photos.photo import Photo, PhotoSet
from limbgram.report.accuracy import Evidence
from limbgram.scale.metric import MetricScene
from limbgram.shape.measures.taping import TapeWitnesses
from limbgram.surface.mesh import Mesh
from limbgram.targets.detections import BoardDetections

T = TypeVar("T")


def kept_evidence(case: CaseFolder) -> Evidence:
    """The evidence that a finished case keeps.

    Raises:
        CaseError: the folder is no finished case, or its products are not those it was
            finished with.
    """
    keys = _keys_of_finished(case)
    board, tapes = keys.get("find_board"), keys.get("hold_tapes")
    return Evidence(
        photos=_read(case, keys, "read_photos", PhotoSet),
        cameras=_read(case, keys, "cameras_for", Cameras),
        detections=None if board is None else _read(case, keys, "find_board", BoardDetections),
        metric=_read(case, keys, "to_millimetres", MetricScene),
        mesh=_read(case, keys, "measure", Mesh),
        tapes=TapeWitnesses() if tapes is None else _read(case, keys, "hold_tapes", TapeWitnesses),
    )


def require_unaltered(photos: Iterable[Photo]) -> None:
    """Refuse photos whose files no longer hold what was reconstructed.

    Raises:
        CaseError: a photo is gone, or holds other bytes.
    """
    for photo in photos:
        try:
            same = file_sha256(photo.path) == photo.sha256
        except OSError:
            same = False
        if not same:
            raise CaseError(
                f"{photo.path} is no longer the photo that the case was made from: it was altered, "
                "moved or damaged. Put the original back, or run `limbgram reconstruct` with the "
                "photos into a new case."
            )


def _keys_of_finished(case: CaseFolder) -> dict[str, str]:
    """Key of each stage's product, as case.json has them."""
    try:
        record: Any = json.loads(case.record.read_text("utf-8"))
        state = record["state"]
        keys = {str(stage["stage"]): str(stage["key"]) for stage in record.get("stages", ())}
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise CaseError(
            f"{case.root} is no case: it has no readable case.json. Name the folder that "
            "`limbgram reconstruct` was given with -o."
        ) from error
    if state != "finished":
        raise CaseError(
            f"The case {case.root} is {state}. Run `limbgram reconstruct` again: it continues "
            "where it stopped."
        )
    return keys


def _read(case: CaseFolder, keys: dict[str, str], stage: str, hint: type[T]) -> T:
    folder = case.stages / stage
    try:
        kept, _ = read_product(folder, keys[stage], hint, case.root)
    except LookupError as error:
        raise CaseError(
            f"{folder} is not what the case was finished with: it is damaged, was edited, or was "
            "made by another version. Run `limbgram reconstruct` on the case again: it makes anew "
            "what is not whole."
        ) from error
    return cast(T, kept)
