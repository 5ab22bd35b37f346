"""The setup: what reports say of the kit that photos were taken with.

Apart from the test and its certificate, which most who cite a kit never open.
"""

from dataclasses import dataclass
from typing import Literal

from limbgram.findings import Finding, doubt, fault, note

Outcome = Literal["pass", "fail", "cannot tell"]
"""Of an acceptance test."""


@dataclass(frozen=True, kw_only=True)
class SetupCited:
    """A kit's acceptance as a report cites it."""

    certificate: str
    """First digits of the hash of the certificate."""
    camera: str
    artefact: str
    outcome: Outcome
    made: str
    months: int
    """Since then, on the day of the report; negative before it."""
    valid_months: int

    @property
    def expired(self) -> bool:
        """Whether the test is older than it was meant to count for."""
        return self.months >= self.valid_months

    @property
    def to_do(self) -> bool:
        """Whether something is to be done about it."""
        return self.outcome != "pass" or self.expired or self.months < 0

    @property
    def finding(self) -> Finding:
        """A finding of how the kit passed, and what to do."""
        said: dict[str, str | int] = {
            "artefact": self.artefact,
            "made": self.made,
            "months": self.months,
            "certificate": self.certificate,
        }
        match self.outcome:
            case "fail":
                return fault("kit.failed", **said)
            case "cannot tell":
                return doubt("kit.undecided", **said)
            case "pass" if self.expired:
                return doubt("kit.expired", **said, valid_months=self.valid_months)
            case "pass" if self.months < 0:
                return doubt("kit.to_come", **said)
            case "pass":
                return note("kit.passed", **said)
