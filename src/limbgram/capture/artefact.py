"""The artefact: the body on which a clinic's kit is tested, with its calibrated values.

In      a TOML or JSON file: spheres, lengths between them or between coded marks, cylinders, a
        calibrated mesh; each with the uncertainty on its calibration certificate.
Out     an Artefact.
Fails   CaseError: no such file, or it is none, or a value in it cannot be.

    format = "limbgram artefact"
    version = 1
    name = "Ball bar 12"
    spheres = [
        {name = "A", diameter_mm = 50.012, uncertainty_mm = 0.004, form_mm = 0.003},
        {name = "B", diameter_mm = 50.009, uncertainty_mm = 0.004, form_mm = 0.003},
    ]
    lengths = [{first = "A", second = "B", length_mm = 150.004, uncertainty_mm = 0.006}]

An uncertainty is the expanded one of a certificate, for a coverage factor of 2. A mark is named by
its number: `mark 7`.
"""

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from limbgram.core.errors import CaseError
from limbgram.core.files import json_of, read_content, toml_of
from limbgram.core.typed import value_of
from limbgram.findings import Finding, note

_LARGEST_BYTES = 1_000_000
_MARK = re.compile(r"mark (\d{1,4})")
_SMALLEST_MM, _LARGEST_MM = 1.0, 5000.0
_LARGEST_SHARE = 0.05
"""Nobody calls a value calibrated whose uncertainty is larger than this share of it."""
_LARGEST_OF_MESH_MM = 1.0
_MOST_SPHERES = 12
_EXAMPLE = "`limbgram verify-setup --help` shows how such a file is written."


@dataclass(frozen=True, kw_only=True)
class SphereStandard:
    """A calibrated sphere."""

    name: str
    diameter_mm: float
    uncertainty_mm: float
    form_mm: float = 0.0
    """Its own deviation from a sphere, peak to valley, as the certificate has it."""


@dataclass(frozen=True, kw_only=True)
class LengthStandard:
    """A calibrated length between the middles of two spheres, or of two coded marks."""

    first: str
    second: str
    length_mm: float
    uncertainty_mm: float

    @property
    def name(self) -> str:
        return f"{self.first} to {self.second}"

    @property
    def mark_ids(self) -> tuple[int, int] | None:
        """Numbers of the marks; None between spheres."""
        found = [_MARK.fullmatch(end) for end in (self.first, self.second)]
        if found[0] is None or found[1] is None:
            return None
        return int(found[0][1]), int(found[1][1])


@dataclass(frozen=True, kw_only=True)
class CylinderStandard:
    """A gauge cylinder."""

    name: str
    diameter_mm: float
    uncertainty_mm: float
    form_mm: float = 0.0


@dataclass(frozen=True, kw_only=True)
class MeshStandard:
    """A body whose whole surface was calibrated, as a mesh in millimetres."""

    name: str
    file: str
    """Beside the artefact file, or with its whole path."""
    uncertainty_mm: float


@dataclass(frozen=True, kw_only=True)
class Artefact:
    """An artefact with all of its calibrated standards."""

    name: str
    sha256: str
    """Of its file: another file is another artefact."""
    certificate: str = ""
    """Who calibrated it and under which number."""
    calibrated: str = ""
    """When."""
    spheres: tuple[SphereStandard, ...] = ()
    lengths: tuple[LengthStandard, ...] = ()
    cylinder: CylinderStandard | None = None
    mesh: MeshStandard | None = None

    @property
    def spacings(self) -> tuple[LengthStandard, ...]:
        """Lengths between spheres."""
        return tuple(one for one in self.lengths if one.mark_ids is None)

    @property
    def gap_mm(self) -> float:
        """The widest gap between its pieces: from one sphere to the next, over a bar that is too
        thin or too bare to be seen."""
        radius = min((one.diameter_mm for one in self.spheres), default=0.0) / 2
        return max((one.length_mm - radius for one in self.spacings), default=0.0)

    @property
    def between_marks(self) -> tuple[LengthStandard, ...]:
        return tuple(one for one in self.lengths if one.mark_ids is not None)


@dataclass(frozen=True, kw_only=True)
class _File:
    format: Literal["limbgram artefact"]
    version: Literal[1]
    name: str
    certificate: str = ""
    calibrated: str = ""
    spheres: tuple[SphereStandard, ...] = ()
    lengths: tuple[LengthStandard, ...] = ()
    cylinder: CylinderStandard | None = None
    mesh: MeshStandard | None = None


def read_artefact(path: Path) -> Artefact:
    """The artefact of a file.

    Raises:
        CaseError: there is no such file, or it is no artefact file, or a value cannot be.
    """
    content = read_content(path, _LARGEST_BYTES, CaseError, _EXAMPLE)
    try:
        if path.suffix.lower() == ".json":
            tree = json_of(content)
        else:
            tree = toml_of(content)
        file = value_of(tree, _File, "the file")
        fault = next(_file_faults(file), None)
    except ValueError as error:
        reason = note("said.as_is", message=str(error))
        raise CaseError("kit.artefact.unusable", path=str(path), reason=reason) from error
    if fault is not None:
        raise CaseError("kit.artefact.unusable", path=str(path), reason=fault)
    mesh = file.mesh
    if mesh is not None:
        mesh = MeshStandard(
            name=mesh.name,
            file=str((path.parent / mesh.file).absolute()),
            uncertainty_mm=mesh.uncertainty_mm,
        )
    return Artefact(
        name=file.name,
        sha256=hashlib.sha256(content).hexdigest(),
        certificate=file.certificate,
        calibrated=file.calibrated,
        spheres=file.spheres,
        lengths=file.lengths,
        cylinder=file.cylinder,
        mesh=mesh,
    )


def _file_faults(file: _File) -> Iterator[Finding]:
    """Faults of an artefact file's values."""
    if not (file.spheres or file.lengths or file.cylinder or file.mesh):
        yield note("kit.artefact.empty")
    names = [one.name for one in file.spheres]
    if len(set(names)) != len(names):
        yield note("kit.artefact.same_name")
    if len(names) > _MOST_SPHERES:
        yield note("kit.artefact.too_many", spheres=len(names), most=_MOST_SPHERES)
    round_ones = [*file.spheres, *([file.cylinder] if file.cylinder else [])]
    for one in round_ones:
        yield from _value_faults("diameter", one.name, one.diameter_mm, one.uncertainty_mm)
        if not 0 <= one.form_mm <= _LARGEST_SHARE * one.diameter_mm:
            yield note("kit.artefact.form", name=one.name, form_mm=one.form_mm)
    for length in file.lengths:
        yield from _value_faults("length", length.name, length.length_mm, length.uncertainty_mm)
        yield from _end_faults(length, names)
    if file.mesh is not None and not 0 <= file.mesh.uncertainty_mm <= _LARGEST_OF_MESH_MM:
        yield note("kit.artefact.mesh", name=file.mesh.name, most_mm=_LARGEST_OF_MESH_MM)


def _value_faults(
    of: Literal["diameter", "length"], name: str, value_mm: float, uncertainty_mm: float
) -> Iterator[Finding]:
    if not _SMALLEST_MM <= value_mm <= _LARGEST_MM:
        yield note(
            "kit.artefact.value",
            of=of,
            name=name,
            value_mm=value_mm,
            least_mm=_SMALLEST_MM,
            most_mm=_LARGEST_MM,
        )
    elif not 0 <= uncertainty_mm <= _LARGEST_SHARE * value_mm:
        yield note(
            "kit.artefact.uncertainty",
            of=of,
            name=name,
            uncertainty_mm=uncertainty_mm,
            most_share=_LARGEST_SHARE,
        )


def _end_faults(length: LengthStandard, names: list[str]) -> Iterator[Finding]:
    if length.first == length.second:
        yield note("kit.artefact.no_length", name=length.name)
    elif length.mark_ids is None:
        for end in (length.first, length.second):
            if end not in names:
                yield note("kit.artefact.no_end", name=length.name, end=end)
