"""The certificate: what an acceptance test found, kept beside the camera file and cited by reports.

A certificate names the camera file by its hash: another calibration of the same camera is another
kit, and has to be tested again.
"""

from dataclasses import dataclass
from datetime import date
from typing import Literal

from limbgram.capture.acceptance import Acceptance, Outcome
from limbgram.core.errors import OptionsError

FORMAT: Literal["limbgram acceptance"] = "limbgram acceptance"
USUAL_MONTHS = 12
_MOST_MONTHS = 120
_ID_DIGITS = 8
WORDS: dict[Outcome, str] = {
    "pass": "passed",
    "fail": "FAILED",
    "cannot tell": "could neither pass nor fail",
}


@dataclass(frozen=True, kw_only=True)
class CameraTested:
    """The camera file of the kit."""

    label: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class ArtefactTested:
    """The artefact, as far as a reader needs it to find it again."""

    name: str
    certificate: str
    calibrated: str
    sha256: str
    """Of its file."""


@dataclass(frozen=True, kw_only=True)
class CaptureTested:
    """A capture of the artefact."""

    name: str
    id: str
    photos: int
    light: str
    scale: str


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Everything that stands in the file."""

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
                f"A test that counts for {self.valid_months} months cannot be. Choose 1 to "
                f"{_MOST_MONTHS} months; {USUAL_MONTHS} are usual."
            )
        try:
            date.fromisoformat(self.made)
        except ValueError as error:
            raise OptionsError(f"{self.made!r} is no day. Write 2026-03-31.") from error

    def is_for(self, camera_sha256: str) -> bool:
        """Whether it was made with this very camera file."""
        return any(one.sha256 == camera_sha256 for one in self.cameras)


@dataclass(frozen=True, kw_only=True)
class SetupCited:
    """What a report says of the kit that it was made with."""

    certificate: str
    """First digits of the hash of the certificate."""
    camera: str
    artefact: str
    outcome: Outcome
    made: str
    months: int
    """Since then, on the day of the report; negative before it."""
    valid_months: int
    sentence: str
    remark: str
    """What to do about it; empty where nothing is to be done."""

    @property
    def expired(self) -> bool:
        """Whether the test is older than it was meant to count for."""
        return self.months >= self.valid_months


def cite(certificate: Certificate, sha256: str, camera: CameraTested, today: date) -> SetupCited:
    """What is said of a kit on this day."""
    months = _months(date.fromisoformat(certificate.made), today)
    outcome, name = certificate.acceptance.outcome, certificate.artefact.name
    age = f"{months} months ago" if months != 1 else "1 month ago"
    when = f"on {certificate.made}" + (f", {age}" if months > 0 else "")
    number = sha256[:_ID_DIGITS]
    return SetupCited(
        certificate=number,
        camera=camera.label,
        artefact=name,
        outcome=outcome,
        made=certificate.made,
        months=months,
        valid_months=certificate.valid_months,
        sentence=f"The kit {WORDS[outcome]} its acceptance test on {name} {when} "
        f"(certificate {number}).",
        remark=_remark(outcome, months, certificate.valid_months),
    )


def _months(made: date, today: date) -> int:
    """Whole months between two days."""
    months = 12 * (today.year - made.year) + today.month - made.month
    return months - (today.day < made.day)


def _remark(outcome: Outcome, months: int, valid_months: int) -> str:
    if outcome == "fail":
        return (
            "Calibrate the camera again, measure the scale board's print, and repeat the test "
            "before anything is made from these photos."
        )
    if outcome == "cannot tell":
        return "Repeat the test with more captures, or with an artefact that is known better."
    if months >= valid_months:
        return (
            f"The test is {months} months old and was meant to count for {valid_months}. Repeat "
            "it: `limbgram verify-setup`."
        )
    if months < 0:
        return "The certificate is of a day to come: is the clock of one computer wrong?"
    return ""
