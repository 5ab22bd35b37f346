"""Camera checks: whether photos fit a camera, and what is known of the camera of the case's run.

And of its size, what a tape said of it; and what was done with its photos.
"""

from datetime import UTC, datetime
from typing import Annotated, Literal

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from limbgram.app.cameras import camera_files
from limbgram.app.replies import FindingReply
from limbgram.app.state import AppStateHere, CaseHere
from limbgram.capture.setup import Outcome
from limbgram.cases.cameras import camera_doubt
from limbgram.cases.case_findings import capture_notes, tapes_judged
from limbgram.cases.certificates import cameras_of, cited_setups
from limbgram.formats.camera import read_camera

router = APIRouter(tags=["cameras"])


class CameraFit(BaseModel):
    """Whether photos and cameras belong together, as far as size and headers of the photos tell."""

    fits: bool
    why: FindingReply | None = Field(default=None, description="Why they do not, and what to do.")


class Setup(BaseModel):
    """What the certificate of a kit says of it today."""

    camera: str
    outcome: Outcome
    made: str = Field(description="Day of the acceptance test.")
    months: int = Field(description="Since then.")
    valid_months: int
    expired: bool = Field(description="Older than it was meant to count for.")
    finding: FindingReply = Field(description="How it did, and what to do about it, if anything.")
    due: bool = Field(
        description="Whether another test is due: the last one is too old, or was not passed."
    )


class TapeSaid(BaseModel):
    """A taped girth beside the surface, as the case's accuracy says it."""

    light: Literal["green", "amber", "red"]
    finding: FindingReply


class Kit(BaseModel):
    """The kit of a case, what checked its size, and what was done with its photos."""

    cameras: list[str] = Field(description="Labels of the camera files that were given.")
    setups: list[Setup] = Field(description="Of those with a certificate.")
    tapes: list[TapeSaid] = Field(description="Girths taped on the limb, given with the run.")
    notes: list[FindingReply] = Field(
        description="Whether the limb kept still, and what was done with the photos: masks, a "
        "turntable, two poses, marks that helped; as the page says it."
    )


@router.get("/cases/{case_id}/camera-fit")
def read_camera_fit(
    app_state: AppStateHere,
    case: CaseHere,
    camera: Annotated[list[str], Query(max_length=20, description="Ids of cameras.")],
) -> CameraFit:
    """Whether the photos that are here can be of these cameras; asked before the run."""
    sources = [case.received / one.name for one in app_state.intake(case).received()]
    if case.photos_given is not None:
        sources = sorted(case.photos_given.iterdir())
    doubt = camera_doubt(sources, [read_camera(one) for one in camera_files(app_state, camera)])
    return CameraFit(fits=doubt is None, why=None if doubt is None else FindingReply.of(doubt))


@router.get("/cases/{case_id}/kit")
def read_kit(case: CaseHere) -> Kit:
    """The calibrated cameras of the run with the age of their certificate, and its tapes."""
    return Kit(
        cameras=[one.label for one in cameras_of(case.folder)],
        setups=[
            Setup(
                camera=one.camera,
                outcome=one.outcome,
                made=one.made,
                months=one.months,
                valid_months=one.valid_months,
                expired=one.expired,
                finding=FindingReply.of(one.finding),
                due=one.expired or one.outcome != "pass",
            )
            for one in cited_setups(case.folder, datetime.now(UTC).date())
        ],
        tapes=[
            TapeSaid(light=one.light, finding=FindingReply.of(one.finding))
            for one in tapes_judged(case.folder)
        ],
        notes=[FindingReply.of(one) for one in capture_notes(case.folder)],
    )
