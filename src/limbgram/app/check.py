"""Check: whether the photos will do, told while the patient is still there."""

import math
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from typing import Any, Literal, cast

from fastapi import APIRouter
from pydantic import BaseModel, Field

from limbgram.app.cameras import camera_files
from limbgram.app.forms import RequestBody
from limbgram.app.known_lengths import BoardSpec
from limbgram.app.live_checks import Asked
from limbgram.app.replies import FindingReply
from limbgram.app.state import AppStateHere, CaseHere
from limbgram.capture.answer import CaptureCheck
from limbgram.cases.fingerprint import file_sha256
from limbgram.cases.uploads import Received, used_instead
from limbgram.findings import Finding
from limbgram.formats.camera import read_camera

router = APIRouter(tags=["photos"])


class AskCheck(RequestBody):
    """With what the photos are checked."""

    board: BoardSpec | None = Field(
        default=BoardSpec(), description="The scale board in the scene; null looks for none."
    )
    cameras: list[str] = Field(default=[], max_length=20, description="Ids of cameras.")


class CheckedReply(BaseModel):
    """One photo as far as it was looked at."""

    name: str
    placed: bool
    points: int = Field(description="Scene points seen in it.")
    edge_px: float | None = Field(description="Width of the sharpest edges on the limb.")
    burnt: float | None = Field(description="Share of the limb that is burnt out.")
    features_per_cm2: float | None
    azimuth_deg: float | None = Field(
        description="From above, counter-clockwise from the first placed photo."
    )
    elevation_deg: float | None = Field(description="Of the camera above level.")
    counts: bool = Field(description="Whether it is placed, sharp and well exposed.")
    remarks: list[FindingReply]


class MissingReply(BaseModel):
    """Photos to add, and from where."""

    count: int
    azimuths_deg: list[float]
    elevations_deg: list[float] = Field(description="Above level, one for each azimuth.")
    between: tuple[str, str] | None = Field(
        description="Photos on either side of a gap; null where a place is seen by too few."
    )
    asked: FindingReply = Field(description="The same as a request.")


class CoverageReply(BaseModel):
    """What the photos that count will measure, cell by cell, rows from below upwards."""

    rows: int
    side_rows: int
    columns: int
    photos: list[list[int | None]] = Field(description="That show the cell squarely, six at most.")
    sigma_mm: list[list[float | None]]
    places: list[list[tuple[float, float, float]]] = Field(description="Middles of the cells.")
    length: float
    radius: float
    measured: float = Field(description="Share of the limb that two photos or more see.")
    well: float = Field(description="Share that three or more see.")
    sigma_middle_mm: float | None
    weakest: FindingReply | None


class CoachReply(BaseModel):
    """The answer of the coach, and what it rests on."""

    go: bool
    headline: FindingReply
    findings: list[FindingReply] = Field(description="What stands in the way of GO.")
    photos: list[CheckedReply]
    missing: list[MissingReply]
    largest_gap_deg: float | None = Field(description="Between photos that count.")
    board_photos: int | None = Field(description="Photos in which the board was found.")
    coverage: CoverageReply | None
    notes: list[FindingReply]
    kept_still: bool | None = Field(description="Whether the limb kept still and its shape.")

    @classmethod
    def of(cls, found: CaptureCheck) -> "CoachReply":
        """An answer, its findings in the words of the app."""
        return cls.model_validate(_replied(found))


def _replied(value: object) -> Any:
    """Dataclasses as tables, their findings as replies; None for what is not known."""
    match value:
        case Finding():
            return FindingReply.of(value)
        case float():
            return value if math.isfinite(value) else None
        case tuple():
            return [_replied(item) for item in cast(tuple[object, ...], value)]
        case _ if is_dataclass(value) and not isinstance(value, type):
            return {field.name: _replied(getattr(value, field.name)) for field in fields(value)}
        case _:
            return value


class Check(BaseModel):
    """The answer of the coach, and whether it is that of today's photos."""

    state: Literal["none", "running", "done", "refused"]
    current: bool = Field(description="Whether the answer looked at all photos that are here.")
    photos: int = Field(description="That the answer, or the check that runs, looked at.")
    stage: str = ""
    took_s: float = 0.0
    message: str = Field(default="", description="Why there is no answer.")
    finding: FindingReply | None = Field(default=None, description="The same as data.")
    answer: CoachReply | None = None


@router.get("/cases/{case_id}/check")
def read_check(app_state: AppStateHere, case: CaseHere) -> Check:
    """What the coach said last, and whether it is at work."""
    coach = app_state.live_checks.of(case)
    answered = coach.state in ("done", "refused")
    root = app_state.shelf.root
    why = None if coach.refusal is None else FindingReply.of(coach.refusal, root)
    return Check(
        state="refused" if answered and why else coach.state,
        current=answered and coach.covers(_seen(app_state.intake(case).received())),
        photos=coach.photos,
        stage=coach.stage,
        took_s=coach.took_s,
        message="" if why is None else why.sentence,
        finding=why,
        answer=None if coach.found is None else CoachReply.of(coach.found),
    )


@router.post("/cases/{case_id}/check", status_code=202)
def ask_check(app_state: AppStateHere, case: CaseHere, given: AskCheck) -> Check:
    """Check the photos that are here; again after more have come."""
    # also those that cannot be used: whoever reads them says why
    received = app_state.intake(case).received()
    sources = tuple(case.received / one.name for one in received)
    if case.photos_given is not None:
        sources = (case.photos_given,)
    spare = used_instead(case.received, received)
    cameras = camera_files(app_state, given.cameras)
    app_state.live_checks.ask(
        case,
        Asked(
            sources=sources,
            calibrations=tuple(read_camera(one) for one in cameras),
            camera_sha256=tuple(file_sha256(one) for one in cameras),
            board=None if given.board is None else given.board.board(),
            seen=_seen(received),
            photos=len(received) - len(spare) if received else app_state.overviews.of(case).photos,
        ),
    )
    return read_check(app_state, case)


@router.delete("/cases/{case_id}/check", status_code=204)
def stop_check(app_state: AppStateHere, case: CaseHere) -> None:
    """End the check that runs."""
    app_state.live_checks.of(case).cancel()


def _seen(received: Iterable[Received]) -> frozenset[tuple[str, str]]:
    return frozenset((one.name, one.kept_sha256) for one in received)
