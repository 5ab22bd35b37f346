"""Certificates as files: written once, beside the camera file; copied into cases; cited from there.

CAMERA.acceptance.json beside CAMERA.json is the certificate of the kit, with a page and a PDF of
the same name. It is sealed by the hash of its own text.
"""

import json
import shutil
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from limbgram.capture.certificate import CameraTested, Certificate, cite
from limbgram.capture.setup import SetupCited
from limbgram.cases.encoding import sealed, unsealed
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.files import (
    json_of,
    make_folder,
    read_content,
    require_folder,
    write_bytes,
    written_whole,
)
from limbgram.core.typed import tree_of, value_of
from limbgram.formats.camera import read_camera

SUFFIX = ".acceptance.json"
_LARGEST_BYTES = 4_000_000
_ADVICE = "Make it again: `limbgram verify-setup`."


def certificate_beside(camera_file: Path) -> Path:
    """Where the certificate of a camera file lies."""
    return camera_file.with_name(f"{camera_file.name.removesuffix('.json')}{SUFFIX}")


def require_certificate_place(path: Path) -> None:
    """Refuse a path where no certificate can be written, or another kind of file lies.

    Raises:
        CaseError: another file lies there, or its name does not end in .json.
        ExportError: its folder cannot be made.
    """
    if not path.name.endswith(".json"):
        raise CaseError("case.certificate.no_name", path=str(path))
    require_folder(path.parent)
    if not path.exists():
        return
    try:
        read_certificate(path)
    except CaseError as error:
        raise CaseError("case.certificate.another_file", path=str(path)) from error


def write_certificate(path: Path, certificate: Certificate) -> None:
    """Write a certificate, in place of an older one of the same name.

    Raises:
        CaseError: another kind of file lies there.
        ExportError: it cannot be written.
    """
    require_certificate_place(path)
    make_folder(path.parent)
    text = json.dumps(sealed(tree_of(certificate)), indent=1, ensure_ascii=False, allow_nan=False)
    write_bytes(path, (text + "\n").encode())


def read_certificate(path: Path) -> Certificate:
    """Read a certificate.

    Raises:
        CaseError: there is none, it is damaged, or somebody changed it.
    """
    content = read_content(path, _LARGEST_BYTES, CaseError, _ADVICE)
    try:
        tree = json_of(content)
        if not isinstance(tree, dict):
            raise ValueError("it is none")
        return value_of(unsealed(tree), Certificate, "the certificate")
    except (ValueError, OptionsError) as error:
        raise CaseError("case.certificate.unusable", path=str(path), why=str(error)) from error
    except LookupError as error:
        raise CaseError("case.certificate.altered", path=str(path)) from error


def take_certificates_in(case: CaseFolder, camera_files: Sequence[Path]) -> None:
    """Copy the certificate of each camera file into the case, if it is of this very file.

    A certificate of another calibration says nothing of this one and stays where it is.

    Raises:
        CaseError: a certificate lies there and is not as it was written.
    """
    for idx, file in enumerate(camera_files):
        kept = certificate_beside(case.camera_file(idx))
        source = certificate_beside(file)
        if source.exists() and source.resolve() == kept.resolve():
            continue
        kept.unlink(missing_ok=True)
        if source.is_file() and read_certificate(source).is_for(file_sha256(file)):
            with written_whole(kept) as beside:
                shutil.copyfile(source, beside)


def cited_setups(case: CaseFolder, today: date) -> tuple[SetupCited, ...]:
    """Citations of the kit's certificates for reports; none for cameras without a certificate.

    Raises:
        CaseError: a certificate in the case is not as it was written.
    """
    found: list[SetupCited] = []
    for idx in range(_cameras_in(case)):
        file = case.camera_file(idx)
        path = certificate_beside(file)
        if not path.is_file():
            continue
        certificate = read_certificate(path)
        if certificate.is_for(file_sha256(file)):
            camera = CameraTested(label=read_camera(file).label, sha256=file_sha256(file))
            found.append(cite(certificate, file_sha256(path), camera, today))
    return tuple(found)


def cameras_of(case: CaseFolder) -> tuple[CameraTested, ...]:
    """The camera files that a case was made with."""
    files = [case.camera_file(idx) for idx in range(_cameras_in(case))]
    return tuple(
        CameraTested(label=read_camera(file).label, sha256=file_sha256(file)) for file in files
    )


def _cameras_in(case: CaseFolder) -> int:
    count = 0
    while case.camera_file(count).is_file():
        count += 1
    return count
