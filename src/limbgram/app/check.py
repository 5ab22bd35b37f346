"""Check: whether the photos will do, told while the patient is still there."""

from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel, Field

from limbgram.app.boards import BoardSpec
from limbgram.app.cameras import camera_files
from limbgram.app.clinic import CaseHere, ClinicHere
from limbgram.app.coaching import Asked
from limbgram.capture.coach import CaptureCheck
from limbgram.cases.fingerprint import file_sha256
from limbgram.formats.camera import read_camera

router = APIRouter(tags=["photos"])


class AskCheck(BaseModel):
    """With what the photos are checked."""

    board: BoardSpec | None = Field(
        default=BoardSpec(), description="The scale board in the scene; null looks for none."
    )
    cameras: list[str] = Field(default=[], max_length=20, description="Ids of cameras.")


class Check(BaseModel):
    """The answer of the coach, and whether it is that of today's photos."""

    state: Literal["none", "running", "done", "refused"]
    current: bool = Field(description="Whether the answer looked at all photos that are here.")
    photos: int = Field(description="That the answer, or the check that runs, looked at.")
    stage: str = ""
    took_s: float = 0.0
    message: str = Field(default="", description="Why there is no answer.")
    answer: CaptureCheck | None = None


@router.get("/cases/{case_id}/check")
def read_check(clinic: ClinicHere, case: CaseHere) -> Check:
    """What the coach said last, and whether it is at work."""
    coach = clinic.coaches.of(case)
    here = len(clinic.intake(case).received())
    answered = coach.state in ("done", "refused")
    return Check(
        state="refused" if answered and coach.message else coach.state,
        current=coach.photos == here and answered,
        photos=coach.photos,
        stage=coach.stage,
        took_s=coach.took_s,
        message=coach.message,
        answer=coach.found,
    )


@router.post("/cases/{case_id}/check", status_code=202)
def ask_check(clinic: ClinicHere, case: CaseHere, given: AskCheck) -> Check:
    """Check the photos that are here; again after more have come."""
    # also those that cannot be used: whoever reads them says why
    sources = tuple(case.received / one.name for one in clinic.intake(case).received())
    if not sources and case.folder.photos.is_dir():
        sources = (case.folder.photos,)
    cameras = camera_files(clinic, given.cameras)
    clinic.coaches.ask(
        case,
        Asked(
            sources=sources,
            calibrations=tuple(read_camera(one) for one in cameras),
            camera_sha256=tuple(file_sha256(one) for one in cameras),
            board=None if given.board is None else given.board.board(),
        ),
    )
    return read_check(clinic, case)


@router.delete("/cases/{case_id}/check", status_code=204)
def stop_check(clinic: ClinicHere, case: CaseHere) -> None:
    """End the check that runs."""
    clinic.coaches.of(case).cancel()
