"""Job: the computing of a case's shape, and its products as they come."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, Field

from limbgram.app.binary_arrays import encode_blocks, surface_blocks
from limbgram.app.cameras import camera_files
from limbgram.app.forms import REQUEST, RequestBody
from limbgram.app.known_lengths import BoardSpec
from limbgram.app.replies import BINARY, FindingReply, missing
from limbgram.app.state import AppState, AppStateHere, CaseHere
from limbgram.app.surface import Coordinates, triple
from limbgram.cases.intermediate_products import (
    IntermediateProducts,
    cameras_so_far,
    cloud_so_far,
    surface_so_far,
)
from limbgram.cases.job_messages import order
from limbgram.cases.job_queue import JobState, StageProgress, TimeLeft, read_job_file
from limbgram.cases.shelf import ShelvedCase
from limbgram.cases.uploads import Received, one_of_each
from limbgram.core.errors import CaseError, PhotoError
from limbgram.reconstruction.photos.video import FrameOptions, is_video, open_video
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, TapedGirth
from limbgram.services.reconstruct import Known, Shaping

router = APIRouter(tags=["job"])


class Tape(RequestBody):
    """A girth taped on the limb before the photos, to test the size by."""

    girth_mm: float = Field(gt=0, le=5000)
    height_mm: float | None = Field(
        default=None, ge=-5000, le=5000, description="Above the table; null: the widest place."
    )


@dataclass(frozen=True, kw_only=True)
class JobOptions(Shaping):
    """What is decided about a run."""

    __pydantic_config__: ClassVar = REQUEST

    board: BoardSpec | None = field(default_factory=BoardSpec)
    """The scale board in the scene; null looks for none."""
    cameras: Annotated[tuple[str, ...], Field(max_length=20)] = ()
    """Ids of calibrated cameras."""
    distances: Annotated[tuple[KnownDistance, ...], Field(max_length=100)] = ()
    """Known lengths between points picked in two photos or more."""
    tapes: Annotated[tuple[Tape, ...], Field(max_length=100)] = ()
    """Girths taped on the limb."""

    def known(self) -> Known:
        """What is known of lengths.

        Raises:
            OptionsError: nothing would set the scale, and nobody said that none is wanted.
        """
        known = Known(
            board=None if self.board is None else self.board.board(),
            distances=self.distances,
            tapes=tuple(
                TapedGirth(girth_mm=one.girth_mm, height_mm=one.height_mm) for one in self.tapes
            ),
        )
        known.require_size(unscaled=self.unscaled)
        return known


class JobReply(BaseModel):
    """How far a run is."""

    state: JobState | Literal["none"]
    stages: list[StageProgress]
    stage: int = Field(description="Number of the stage that runs, from 1.")
    before: int = Field(
        default=0, description="Runs of other cases that come first, while it is queued."
    )
    elapsed_s: float = Field(description="Of all starts together, without pauses.")
    left: TimeLeft | None = Field(default=None, description="null where nobody knows.")
    began: str = ""
    message: str = Field(default="", description="What, why, what to do; where it did not finish.")
    finding: FindingReply | None = Field(default=None, description="The message as data.")
    kind: str = Field(default="", description="Name of the error; for experts.")
    light: str = ""
    photos: list[str] = Field(default=[], description="That it works on.")
    there: IntermediateProducts = Field(description="Products that can be looked at already.")


class Camera(BaseModel):
    """Where a photo was taken."""

    photo: str
    centre_mm: Coordinates
    right: Coordinates
    down: Coordinates
    forward: Coordinates
    width_px: int
    height_px: int
    focal_px: float


@router.get("/cases/{case_id}/job")
def read_job(app_state: AppStateHere, case: CaseHere) -> JobReply:
    """How far the run is; the same after the program was started again."""
    return _reply(app_state, case)


@router.post("/cases/{case_id}/job", status_code=202)
def start_job(app_state: AppStateHere, case: CaseHere, given: JobOptions) -> JobReply:
    """Compute the shape, for the first time or with other options; nothing is sent again.

    It is queued while as many runs of other cases work as are allowed at a time.
    """
    received = app_state.intake(case).received()
    folder = case.received if received else case.photos_given
    if folder is None:
        raise CaseError("app.no_photos_yet")
    if not case.label_file.exists():  # a folder that the shelf lists becomes a case by its run
        case.relabel(case.unlabelled)
    used = one_of_each(folder, received)
    megapixels = sum(_pixels_of(folder, one) for one in used) / 1e6
    job = order(
        case.folder.root,
        [folder / one.name for one in received] or [folder],
        given,
        given.known(),
        camera_files=camera_files(app_state, given.cameras),
    )
    app_state.live_checks.of(case).cancel()
    app_state.runner.start(job, megapixels)
    return _reply(app_state, case)


def _pixels_of(folder: Path, received: Received) -> int:
    """Pixels of a photo, or of all frames that are taken of a film."""
    if not is_video(folder / received.name):
        return received.width_px * received.height_px
    try:
        film = open_video(folder / received.name)
    except PhotoError:  # the run says why
        return 0
    wanted = FrameOptions.count
    return min(film.frames_told or wanted, wanted) * film.width_px * film.height_px


@router.post("/cases/{case_id}/job/pause")
def pause_job(app_state: AppStateHere, case: CaseHere) -> JobReply:
    """Let the run rest; it keeps its memory and its elapsed time."""
    job = app_state.runner.running(case.folder)
    if job is None:
        raise CaseError("job.nothing_to_hold")
    job.hold()
    return _reply(app_state, case)


@router.post("/cases/{case_id}/job/resume")
def resume_job(app_state: AppStateHere, case: CaseHere) -> JobReply:
    """Let a resting run go on; or take up one that was cancelled or interrupted."""
    job = app_state.runner.running(case.folder)
    if job is not None and job.file.state == "held":
        app_state.runner.resume(case.folder)
    else:
        app_state.runner.restart(case.folder)
    return _reply(app_state, case)


@router.post("/cases/{case_id}/job/cancel")
def cancel_job(app_state: AppStateHere, case: CaseHere) -> JobReply:
    """End the run within two seconds; finished stages are kept, `resume` goes on from there."""
    job = app_state.runner.running(case.folder)
    if job is None or not job.active:
        raise CaseError("job.nothing_to_cancel")
    job.cancel()
    return _reply(app_state, case)


@router.get("/cases/{case_id}/job/cameras")
def read_cameras(case: CaseHere) -> list[Camera]:
    """Where the photos were taken, as soon as they are placed."""
    return [
        Camera(
            photo=view.name,
            centre_mm=triple(view.centre_in_world),
            right=triple(view.camera_from_world.rotation[0]),
            down=triple(view.camera_from_world.rotation[1]),
            forward=triple(view.camera_from_world.rotation[2]),
            width_px=view.camera.width_px,
            height_px=view.camera.height_px,
            focal_px=float(view.camera.fx),
        )
        for view in cameras_so_far(case.folder)
    ]


@router.get("/cases/{case_id}/job/cloud", response_class=Response, responses=BINARY)
def read_cloud(
    case: CaseHere,
    most: Annotated[int, Query(ge=1000, le=2_000_000, description="Points at most.")] = 60_000,
) -> Response:
    """The points, as soon as they are there: blocks positions, normals, colours."""
    cloud = cloud_so_far(case.folder)
    if cloud is None:
        raise missing("app.no_points_yet")
    step = max(1, -(-len(cloud) // most))
    blocks = {
        "positions": cloud.points_mm[::step],
        "normals": cloud.normals[::step],
        "colours": cloud.colours[::step],
    }
    content = encode_blocks({"what": "cloud", "points": len(cloud)}, blocks)
    return Response(content, media_type="application/octet-stream")


@router.get("/cases/{case_id}/job/surface", response_class=Response, responses=BINARY)
def read_surface_underway(case: CaseHere) -> Response:
    """The surface as far as it is: wrapped, then measured."""
    mesh = surface_so_far(case.folder)
    if mesh is None:
        raise missing("app.no_surface_yet")
    return Response(surface_blocks(mesh, {}), media_type="application/octet-stream")


def _reply(app_state: AppState, case: ShelvedCase) -> JobReply:
    running = app_state.runner.running(case.folder)
    job = running.file if running is not None else read_job_file(case.folder)
    there = IntermediateProducts.of(case.folder)
    if job is None:
        return JobReply(state="none", stages=[], stage=0, elapsed_s=0.0, there=there)
    why = None if job.why is None else FindingReply.of(job.why, app_state.shelf.root)
    at = next((k for k, one in enumerate(job.stages, 1) if one.state == "running"), 0)
    return JobReply(
        state=job.state,
        stages=list(job.stages),
        stage=at or sum(one.state == "done" for one in job.stages),
        before=app_state.runner.jobs_ahead(case.folder),
        elapsed_s=job.elapsed_s if running is None else running.elapsed_s,
        left=None if running is None else running.time_left(),
        began=job.began,
        message="" if why is None else why.sentence,
        finding=why,
        kind=job.kind,
        light=job.light,
        photos=[one.name for one in one_of_each(case.received, app_state.intake(case).received())],
        there=there,
    )
