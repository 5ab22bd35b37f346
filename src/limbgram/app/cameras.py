"""Cameras: calibrations that the clinic keeps, made of board photos, with age and certificate."""

import math
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace as otherwise
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Path, Query, Request
from fastapi.responses import FileResponse
from pydantic import BaseModel, Field

from limbgram.app.forms import RequestBody
from limbgram.app.known_lengths import BoardSpec
from limbgram.app.photos import NameHere, Photos, Sent, UploadId, photos_reply, receive, received_of
from limbgram.app.replies import BYTES, PICTURE, FindingReply, missing
from limbgram.app.state import AppState, AppStateHere
from limbgram.cases.cameras import Cameras, CameraState, KeptCamera
from limbgram.cases.shelf_ids import ID_PATTERN
from limbgram.cases.uploads import checked_name, photos_in
from limbgram.core.errors import CaseError, LimbgramError, printable
from limbgram.core.run import Run
from limbgram.findings import Finding

router = APIRouter(tags=["cameras"])

_OLD_DAYS = 180
"""Beyond which a lens is to be calibrated again."""

CameraId = Annotated[str, Path(pattern=ID_PATTERN, description="Id of the camera.")]


class CameraReply(BaseModel):
    """A camera that the clinic keeps."""

    id: str
    name: str
    state: CameraState
    message: str = Field(
        default="", description="What the calibration found, or why it was refused."
    )
    finding: FindingReply | None = Field(default=None, description="The same as data.")
    calibrated: str = Field(default="", description="Date and time, UTC; empty before.")
    age_days: int | None = None
    old: bool = Field(
        default=False, description="Calibrate again before a limb that matters: half a year passed."
    )
    photos: int = Field(description="Photos of the board that are here.")
    label: str = Field(default="", description="Make, model and lens, as the photos say.")
    focal_mm: float | None = None
    width_px: int = 0
    height_px: int = 0
    rms_px: float | None = Field(default=None, description="How well the photos fit the lens.")
    certificate: str | None = Field(default=None, description="Where its picture is.")


class NewCamera(RequestBody):
    """What a new camera is called."""

    name: str = Field(min_length=1, max_length=80)


@router.get("/cameras")
def list_cameras(app_state: AppStateHere) -> list[CameraReply]:
    """The cameras that the clinic keeps."""
    return [_reply(app_state, one) for one in _cameras(app_state).all()]


@router.post("/cameras", status_code=201)
def new_camera(app_state: AppStateHere, given: NewCamera) -> CameraReply:
    """Begin a camera; then send photos of the board, or a camera file."""
    return _changed_reply(app_state, _cameras(app_state).new_camera(given.name))


@router.get("/cameras/{camera_id}")
def read_camera(app_state: AppStateHere, camera_id: CameraId) -> CameraReply:
    """One camera."""
    return _reply(app_state, _cameras(app_state).camera(camera_id))


@router.patch("/cameras/{camera_id}")
def rename_camera(app_state: AppStateHere, camera_id: CameraId, given: NewCamera) -> CameraReply:
    """Call a camera something else."""
    camera = _cameras(app_state).camera(camera_id)
    camera.relabel(otherwise(camera.label, name=given.name))
    return _changed_reply(app_state, camera)


@router.delete("/cameras/{camera_id}", status_code=204)
def delete_camera(app_state: AppStateHere, camera_id: CameraId) -> None:
    """Delete a camera with its photos; cases keep their own copy of its file."""
    _cameras(app_state).remove(_cameras(app_state).camera(camera_id))
    app_state.news.tell("cameras", camera_id)


@router.post("/cameras/{camera_id}/calibrate", status_code=202)
def calibrate_camera(app_state: AppStateHere, camera_id: CameraId, given: BoardSpec) -> CameraReply:
    """Find the lens by the photos that are here; ask again until the state says how it ended."""
    camera, board = _cameras(app_state).camera(camera_id), given.board()
    if camera_id in app_state.calibrations:
        raise CaseError("camera.calibrating")
    camera.relabel(camera.label.as_calibrating)
    app_state.calibrations.add(camera_id)

    def work() -> None:
        try:
            with app_state.calibrating, suppress(LimbgramError, OSError):  # its label says why
                camera.calibrate(board, Run())
        finally:
            app_state.calibrations.discard(camera_id)
            app_state.news.tell("cameras", camera_id)

    threading.Thread(target=work, name="calibrate", daemon=True).start()
    return _reply(app_state, camera)


@router.get("/cameras/{camera_id}/photos")
def list_board_photos(app_state: AppStateHere, camera_id: CameraId) -> Photos:
    """Photos of the board that are here."""
    camera = _cameras(app_state).camera(camera_id)
    return photos_reply(received_of(app_state.intake_of(camera.received)))


@router.put("/cameras/{camera_id}/photos/{name}", openapi_extra=BYTES)
async def put_board_photo(
    app_state: AppStateHere,
    camera_id: CameraId,
    name: NameHere,
    request: Request,
    content_range: Annotated[str | None, Header()] = None,
    upload_id: UploadId = None,
    replace: bool = False,
) -> Sent:
    """Send a photo of the board; as those of a case."""
    camera = _cameras(app_state).camera(camera_id)
    return await receive(
        app_state.intake_of(camera.received),
        name,
        request,
        content_range,
        upload_id,
        replace=replace,
        on_change=lambda: app_state.news.tell("cameras", camera_id),
    )


@router.delete("/cameras/{camera_id}/photos/{name}", status_code=204)
def delete_board_photo(app_state: AppStateHere, camera_id: CameraId, name: NameHere) -> None:
    """Take a photo of the board away."""
    camera = _cameras(app_state).camera(camera_id)
    if not app_state.intake_of(camera.received).remove(checked_name(name)):
        raise missing("app.no_photo")
    app_state.news.tell("cameras", camera_id)


@router.put("/cameras/{camera_id}/file")
def take_camera_file(
    app_state: AppStateHere,
    camera_id: CameraId,
    content: Annotated[bytes, Body(media_type="application/octet-stream", max_length=4_000_000)],
    name: Annotated[
        str, Query(max_length=200, description="The file's own name, by which a refusal names it.")
    ] = "camera.json",
) -> CameraReply:
    """Take a camera file that `limbgram calibrate` wrote."""
    camera = _cameras(app_state).camera(camera_id)
    camera.take_file(content, printable(name, keep=""))
    return _changed_reply(app_state, camera)


@router.get("/cameras/{camera_id}/file", response_class=FileResponse)
def read_camera_file(app_state: AppStateHere, camera_id: CameraId) -> FileResponse:
    """The camera file, for `limbgram reconstruct --camera`."""
    camera = _cameras(app_state).camera(camera_id)
    if not camera.file.is_file():
        raise missing("camera.not_calibrated", name=camera.label.name)
    return FileResponse(camera.file, filename=f"camera-{camera_id}.json")


@router.get("/cameras/{camera_id}/certificate", response_class=FileResponse, responses=PICTURE)
def read_certificate(app_state: AppStateHere, camera_id: CameraId) -> FileResponse:
    """Residuals and coverage of its calibration, a picture."""
    camera = _cameras(app_state).camera(camera_id)
    if not camera.certificate.is_file():
        raise missing("camera.without_certificate")
    return FileResponse(camera.certificate)


def camera_files(app_state: AppState, ids: Sequence[str]) -> tuple[FilePath, ...]:
    """The camera files of cameras that a request names.

    Raises:
        CaseError: one is not calibrated.
    """
    files: list[FilePath] = []
    for camera_id in ids:
        camera = _cameras(app_state).camera(camera_id)
        if not camera.file.is_file():
            raise CaseError("camera.not_calibrated", name=camera.label.name)
        files.append(camera.file)
    return tuple(files)


def _cameras(app_state: AppState) -> Cameras:
    return Cameras(app_state.shelf.cameras)


def _changed_reply(app_state: AppState, camera: KeptCamera) -> CameraReply:
    app_state.news.tell("cameras", camera.camera_id)
    return _reply(app_state, camera)


def _reply(app_state: AppState, camera: KeptCamera) -> CameraReply:
    try:
        label, lens = camera.label, camera.calibration()
    except CaseError as error:  # it hides none of the others
        name = camera.camera_id
        why = _finding_fields(app_state, error.finding)
        return CameraReply(id=name, name=name, state="refused", photos=0, **why)
    age = None
    if label.calibrated:
        age = (datetime.now(UTC) - datetime.fromisoformat(label.calibrated)).days
    has_certificate = camera.certificate.is_file()
    if camera.camera_id in app_state.calibrations:
        label = label.as_calibrating
    elif label.state == "calibrating" and not app_state.sampling.locked():
        # No thread calibrates it: its end could not be written, on a full disk, say.
        label = camera.interrupted
    return CameraReply(
        id=camera.camera_id,
        name=label.name,
        state=label.state,
        calibrated=label.calibrated,
        age_days=age,
        old=age is not None and age > _OLD_DAYS,
        photos=photos_in(camera.received),
        label="" if lens is None else lens.label,
        focal_mm=None if lens is None else lens.focal_mm,
        width_px=0 if lens is None else lens.camera.width_px,
        height_px=0 if lens is None else lens.camera.height_px,
        rms_px=None if lens is None or math.isnan(lens.rms_px) else lens.rms_px,
        certificate=f"/api/v1/cameras/{camera.camera_id}/certificate" if has_certificate else None,
        **({} if label.told is None else _finding_fields(app_state, label.told)),
    )


def _finding_fields(app_state: AppState, finding: Finding) -> dict[str, Any]:
    found = FindingReply.of(finding, app_state.shelf.root)
    return {"message": found.sentence, "finding": found}
