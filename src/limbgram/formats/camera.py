"""The camera file: one calibration as JSON that people can read.

Pixel (0, 0) is the centre of the top left pixel; the lens model is geometry.camera's. Sigmas
are written for people; what is read back is the covariance they come from. A file is written
beside its place, synced and renamed, so an interrupted write leaves the old one.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import cast

import numpy as np

from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content, written_whole
from limbgram.core.geometry.lens import PARAMETERS, Camera
from limbgram.reconstruction.calibration.cameras import Calibration

_FORMAT = "limbgram camera"
_VERSION = 1
_LARGEST_BYTES = 1_000_000
_LARGEST_PX = 1e7
"""No focal length is longer in pixels: a hundred metres of lens on the finest sensor."""


def write_camera(
    path: Path, calibration: Calibration, provenance: Mapping[str, str] | None = None
) -> None:
    """Keep a calibration, and in `provenance` where it comes from (board, photos, program).

    Raises:
        CaseError: the file cannot be written, or would take the place of another one.
    """
    require_camera_place(path)
    camera = calibration.camera
    record = {
        "format": _FORMAT,
        "version": _VERSION,
        "convention": "pixel (0, 0) is the centre of the top left pixel; Brown-Conrady",
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "label": calibration.label,
        "focal_mm": calibration.focal_mm,
        "source": calibration.source,
        "rms_px": calibration.rms_px if math.isfinite(calibration.rms_px) else None,
        "parameters": dict(zip(PARAMETERS, camera.packed.tolist())),
        "sigmas": dict(zip(PARAMETERS, calibration.sigmas.tolist())),
        "covariance": calibration.covariance.tolist(),
        "provenance": dict(provenance or {}),
    }
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as beside:
            beside.write_bytes(text.encode())
    except OSError as error:
        raise CaseError(
            f"The camera file {path} cannot be written: {error.strerror or error}. Check that "
            "its folder exists, may be written to and has room."
        ) from error


def require_camera_place(path: Path) -> None:
    """Refuse to write over what is no camera file: a photo, say, or the settings of a program.

    Raises:
        CaseError: another file lies there.
    """
    if not path.exists():
        return
    try:
        record = json_of(read_content(path, _LARGEST_BYTES, CaseError))
        ours = isinstance(record, dict) and cast(dict[str, object], record).get("format") == _FORMAT
    except (CaseError, ValueError):
        ours = False
    if not ours:
        raise CaseError(
            f"{path} is there already and is no camera file: it would be lost. Choose another "
            "name by -o, such as camera.json."
        )


def read_camera(path: Path) -> Calibration:
    """The calibration in a camera file.

    Raises:
        CaseError: there is no such file, or it is no camera file, or a value cannot be.
    """
    content = read_content(
        path, _LARGEST_BYTES, CaseError, "A camera file is made with `limbgram calibrate`."
    )
    try:
        record = json_of(content)
    except ValueError as error:
        raise CaseError(
            f"{path} is no camera file: {error}. Make one with `limbgram calibrate`."
        ) from error
    if not isinstance(record, dict):
        raise _unusable(path, "it holds no record")
    return _parsed(path, cast(dict[str, object], record))


def _parsed(path: Path, record: dict[str, object]) -> Calibration:
    if record.get("format") != _FORMAT:
        raise _unusable(path, f"its format is not {_FORMAT!r}")
    if record.get("version") != _VERSION:
        raise _unusable(path, f"it has version {record.get('version')}, known is {_VERSION}")
    source, label = record.get("source"), record.get("label")
    if source not in ("board", "exif") or not isinstance(label, str):
        raise _unusable(path, "source or label is missing")
    parameters = record.get("parameters")
    if not isinstance(parameters, dict):
        raise _unusable(path, "the parameters are missing")
    values = cast(dict[str, object], parameters)
    camera = Camera(
        width_px=_whole(path, record, "width_px"),
        height_px=_whole(path, record, "height_px"),
        **{name: _number(path, values, name) for name in PARAMETERS},
    )
    if min(camera.fx, camera.fy) <= 0:
        raise _unusable(path, "a focal length is not positive")
    if np.abs(camera.packed).max() > _LARGEST_PX:
        raise _unusable(path, "a parameter is larger than any camera's")
    for name in ("focal_mm", "rms_px"):
        if record.get(name) is not None and _number(path, record, name) < 0:
            raise _unusable(path, f"{name} is negative")
    covariance = _covariance(path, record.get("covariance"))
    _require_own_sigmas(path, record.get("sigmas"), covariance)
    return Calibration(
        camera=camera,
        covariance=covariance,
        source=source,
        label=label,
        focal_mm=None if record.get("focal_mm") is None else _number(path, record, "focal_mm"),
        rms_px=math.nan if record.get("rms_px") is None else _number(path, record, "rms_px"),
    )


def _covariance(path: Path, rows: object) -> np.ndarray:
    try:
        covariance = np.array(rows, float)
    except (TypeError, ValueError) as error:
        raise _unusable(path, "the covariance is no table of numbers") from error
    size = len(PARAMETERS)
    if covariance.shape != (size, size) or not (np.abs(covariance) <= _LARGEST_PX**2).all():
        raise _unusable(path, f"the covariance is not {size} x {size} numbers")
    if (np.diag(covariance) < 0).any():
        raise _unusable(path, "a variance is negative")
    sigmas = np.sqrt(np.diag(covariance))
    unit = np.outer(np.where(sigmas > 0, sigmas, 1.0), np.where(sigmas > 0, sigmas, 1.0))
    if not np.allclose(covariance, covariance.T, rtol=1e-6) or (
        np.linalg.eigvalsh(covariance / unit).min() < -1e-6
    ):
        raise _unusable(path, "the covariance is not symmetric and positive")
    return covariance


def _require_own_sigmas(path: Path, told: object, covariance: np.ndarray) -> None:
    """Refuse sigmas that are not those of the covariance: somebody changed one and not the other.

    Files that leave them out are read: they say nothing that the covariance does not.
    """
    if told is None:
        return
    values = cast(dict[str, object], told) if isinstance(told, dict) else {}
    sigmas = [_number(path, values, name) for name in PARAMETERS]
    if not np.allclose(sigmas, np.sqrt(np.diag(covariance)), rtol=1e-6, atol=1e-12):
        raise _unusable(path, "its sigmas are not those of its covariance")


def _number(path: Path, record: Mapping[str, object], name: str) -> float:
    value = record.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise _unusable(path, f"{name} is {value!r}, not a number")
    return float(value)


def _whole(path: Path, record: Mapping[str, object], name: str) -> int:
    value = record.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 100_000:
        raise _unusable(path, f"{name} is {value!r}, not a size in pixels")
    return value


def _unusable(path: Path, why: str) -> CaseError:
    return CaseError(
        f"{path} is no usable camera file: {why}. Make it again with `limbgram calibrate`."
    )
