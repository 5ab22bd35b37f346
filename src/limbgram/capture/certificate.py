"""The certificate: what an acceptance test found, kept beside the camera file and cited by reports.

A certificate names the camera file by its hash: another calibration of the same camera is another
kit, and has to be tested again.
"""

from dataclasses import dataclass
from datetime import date
from typing import Literal

from limbgram.capture.acceptance import Acceptance
from limbgram.capture.setup import SetupCited
from limbgram.core.errors import OptionsError

FORMAT: Literal["limbgram acceptance"] = "limbgram acceptance"
USUAL_MONTHS = 12
_MOST_MONTHS = 120
_ID_DIGITS = 8


@dataclass(frozen=True, kw_only=True)
class CameraTested:
    """The camera file of the kit that was tested."""

    label: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class ArtefactTested:
    """The artefact of the test, as far as a reader needs it to identify it."""

    name: str
    certificate: str
    calibrated: str
    sha256: str
    """Of its file."""


@dataclass(frozen=True, kw_only=True)
class CaptureTested:
    """A capture of the artefact, as cited in the certificate."""

    name: str
    id: str
    photos: int
    light: str
    scale: str


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """The certificate of an acceptance test, as it stands in its file."""

    format: Literal["limbgram acceptance"] = FORMAT
    version: Literal[1] = 1
    program: str
    made: str
    """Day of the test, 2026-03-31."""
    valid_months: int = USUAL_MONTHS
    """After how many months the reports ask for another test."""
    cameras: tuple[CameraTested, ...]
    """None where the photos had no camera file: then no report can cite it."""
    artefact: ArtefactTested
    captures: tuple[CaptureTested, ...]
    acceptance: Acceptance

    def __post_init__(self) -> None:
        if not 1 <= self.valid_months <= _MOST_MONTHS:
            raise OptionsError(
                "kit.valid_months",
                valid_months=self.valid_months,
                most=_MOST_MONTHS,
                usual=USUAL_MONTHS,
            )
        try:
            date.fromisoformat(self.made)
        except ValueError as error:
            raise OptionsError("kit.no_day", made=self.made) from error

    def is_for(self, camera_sha256: str) -> bool:
        """Whether it was made with this very camera file."""
        return any(one.sha256 == camera_sha256 for one in self.cameras)


def cite(certificate: Certificate, sha256: str, camera: CameraTested, today: date) -> SetupCited:
    """The citation of a kit's certificate on a day."""
    return SetupCited(
        certificate=sha256[:_ID_DIGITS],
        camera=camera.label,
        artefact=certificate.artefact.name,
        outcome=certificate.acceptance.outcome,
        made=certificate.made,
        months=_months(date.fromisoformat(certificate.made), today),
        valid_months=certificate.valid_months,
    )


def _months(made: date, today: date) -> int:
    """Whole months between two days."""
    months = 12 * (today.year - made.year) + today.month - made.month
    return months - (today.day < made.day)
