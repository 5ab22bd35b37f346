"""The camera file: one calibration as JSON that people can read.

Pixel (0, 0) is the centre of the top left pixel; the lens model is that of core.geometry.lens.
Sigmas are written for people; the covariance is what is read. Coefficients that a file does not
have are zero: it was written before the lens model had them.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np

from limbgram.core.errors import CaseError, reason_of
from limbgram.core.files import json_of, read_content, write_bytes
from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, Camera, LensParameters
from limbgram.core.typed import TOLERANT, value_of
from limbgram.findings import Finding, fault, note
from limbgram.reconstruction.calibration.cameras import Calibration, LensSource

_FORMAT = "limbgram camera"
_VERSION = 1
_LARGEST_BYTES = 1_000_000
_LARGEST_PX = 1e7
"""Longer than any focal length: a hundred metres on the finest sensor."""
_LARGEST_SIDE_PX = 100_000


@dataclass(frozen=True, kw_only=True)
class _CameraFile:
    """The fields of a camera file that are read."""

    format: Literal["limbgram camera"]
    version: Literal[1]
    width_px: int
    height_px: int
    label: str
    source: LensSource
    parameters: LensParameters
    covariance: tuple[tuple[float, ...], ...]
    sigmas: LensParameters | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None
    digital_zoom: float | None = None
    body: str | None = None
    rms_px: float | None = None
    edge_px: float | None = None


def write_camera(
    path: Path | str, calibration: Calibration, provenance: Mapping[str, str] | None = None
) -> None:
    """Write a calibration, and in `provenance` where it comes from (board, photos, program).

    Raises:
        CaseError: another kind of file lies there.
        ExportError: it cannot be written.
    """
    path = Path(path)
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
        "focal_35mm": calibration.focal_35mm,
        "digital_zoom": calibration.digital_zoom,
        "body": calibration.body,
        "source": calibration.source,
        "rms_px": calibration.rms_px if math.isfinite(calibration.rms_px) else None,
        "edge_px": calibration.edge_px,
        "parameters": dict(zip(PARAMETERS, camera.packed.tolist())),
        "sigmas": dict(zip(PARAMETERS, calibration.sigmas.tolist())),
        "covariance": calibration.covariance.tolist(),
        "provenance": dict(provenance or {}),
    }
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_bytes(path, text.encode())


def require_camera_place(path: Path) -> None:
    """Refuse to overwrite another kind of file: a photo, say, or the settings of a program.

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
        raise CaseError("file.camera.in_the_way", path=str(path))


def read_camera(path: Path | str) -> Calibration:
    """The calibration in a camera file.

    Raises:
        CaseError: there is no such file, or it is no camera file, or a value cannot be.
    """
    path = Path(path)
    content = read_content(path, _LARGEST_BYTES, CaseError, note("file.camera.how_made"))
    return parse_camera(content, path)


def parse_camera(content: bytes, path: Path) -> Calibration:
    """The calibration in the content of a camera file.

    Args:
        path: By which a refusal names the file; it is not read.

    Raises:
        CaseError: it is no camera file, or a value cannot be.
    """
    try:
        tree = json_of(content)
        record = value_of(tree, _CameraFile, strictness=TOLERANT)
    except ValueError as error:
        raise _unusable(path, reason_of(error)) from error
    camera = Camera(
        width_px=record.width_px, height_px=record.height_px, **asdict(record.parameters)
    )
    if (
        not 1
        <= min(camera.width_px, camera.height_px)
        <= max(camera.width_px, camera.height_px)
        <= _LARGEST_SIDE_PX
    ):
        raise _unusable(path, fault("file.camera.size"))
    if min(camera.fx, camera.fy) <= 0:
        raise _unusable(path, fault("file.camera.focal"))
    if np.abs(camera.packed).max() > _LARGEST_PX:
        raise _unusable(path, fault("file.camera.parameter"))
    for name in ("focal_mm", "focal_35mm", "digital_zoom", "rms_px", "edge_px"):
        value = getattr(record, name)
        if value is not None and value < 0:
            raise _unusable(path, fault("file.camera.negative", field=name))
    rows = [row for row, name in enumerate(PARAMETERS) if name in tree["parameters"]]
    covariance = np.zeros((LENS_SIZE, LENS_SIZE))
    covariance[np.ix_(rows, rows)] = _covariance(path, record.covariance, len(rows))
    if record.sigmas is not None:
        _require_own_sigmas(path, record.sigmas, covariance)
    return Calibration(
        camera=camera,
        covariance=covariance,
        source=record.source,
        label=record.label,
        focal_mm=record.focal_mm,
        focal_35mm=record.focal_35mm,
        digital_zoom=record.digital_zoom,
        body=record.body,
        rms_px=math.nan if record.rms_px is None else record.rms_px,
        edge_px=record.edge_px,
    )


def _covariance(path: Path, rows: tuple[tuple[float, ...], ...], size: int) -> np.ndarray:
    """The covariance of the parameters that the file has, checked."""
    if len(rows) != size or any(len(row) != size for row in rows):
        raise _unusable(path, fault("file.camera.covariance_size", size=size))
    covariance = np.array(rows, float)
    if np.abs(covariance).max() > _LARGEST_PX**2:
        raise _unusable(path, fault("file.camera.covariance_number"))
    if (np.diag(covariance) < 0).any():
        raise _unusable(path, fault("file.camera.variance"))
    sigmas = np.sqrt(np.diag(covariance))
    unit = np.outer(np.where(sigmas > 0, sigmas, 1.0), np.where(sigmas > 0, sigmas, 1.0))
    if not np.allclose(covariance, covariance.T, rtol=1e-6) or (
        np.linalg.eigvalsh(covariance / unit).min() < -1e-6
    ):
        raise _unusable(path, fault("file.camera.covariance"))
    return covariance


def _require_own_sigmas(path: Path, sigmas: LensParameters, covariance: np.ndarray) -> None:
    """Refuse sigmas that do not match the covariance: somebody edited one and not the other.

    Files may leave them out, since the covariance has them.
    """
    written = [getattr(sigmas, name) for name in PARAMETERS]
    if not np.allclose(written, np.sqrt(np.diag(covariance)), rtol=1e-6, atol=1e-12):
        raise _unusable(path, fault("file.camera.sigmas"))


def _unusable(path: Path, why: Finding) -> CaseError:
    return CaseError("file.camera.unusable", path=str(path), why=why)
