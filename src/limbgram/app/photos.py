"""Photos: one PUT a file, in pieces if need be; what is here, and pictures of it."""

import asyncio
import io
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path as FilePath
from typing import Annotated, Literal

from fastapi import APIRouter, Header, Path, Query, Request, Response
from fastapi.responses import FileResponse
from PIL import Image, ImageOps
from pydantic import BaseModel, Field

from limbgram.app.replies import ADDRESS_ALONE, BYTES, PICTURE, FindingReply, missing
from limbgram.app.state import AppStateHere, CaseHere
from limbgram.cases.shelf import ShelvedCase
from limbgram.cases.uploads import (
    MOST_FILES,
    MOST_PHOTO_BYTES,
    PIECES,
    WHOLE,
    Intake,
    Received,
    checked_name,
    is_zip,
    limit_of,
    used_instead,
)
from limbgram.core.errors import CaseError, OptionsError
from limbgram.reconstruction.photos.decoding import DECODING_FAULTS, open_picture, to_look_at
from limbgram.reconstruction.photos.shots import files_not_used

router = APIRouter(tags=["photos"])

NameHere = Annotated[str, Path(max_length=200, description="The file's own name.")]
UploadId = Annotated[
    str | None,
    Header(
        pattern=r"^[A-Za-z0-9_-]{8,64}$",
        description="Of your choice, the same for all pieces of a file: tells it from the file of "
        "another sender that has the same name.",
    ),
]
_RANGE = re.compile(r"bytes (\d{1,15})-(\d{1,15})/(\d{1,15}|\*)")
_WRITE_BYTES = 1 << 16
"""Bytes buffered before a write: sixty photos may arrive at the same time, and each needs little
more memory than this."""
_KEEPER = ThreadPoolExecutor(1, thread_name_prefix="keeper")
"""Hashes and cleans one complete photo after the other, so that only one is in memory. Zips go to
the default executor."""
_SMALLEST_PX, _LARGEST_PX = 32, 4096


class Photo(BaseModel):
    """A file that was sent."""

    name: str
    state: Literal["here", "arriving", "unusable"]
    bytes: int = Field(description="That are here, as they came.")
    total: int | None = Field(default=None, description="That were announced.")
    sha256: str = Field(default="", description="Of the file as it came, once it is whole.")
    removed: list[str] = Field(default=[], description="What was taken out of its header.")
    kept: list[str] = Field(
        default=[], description="What had to stay though it may tell the camera."
    )
    width_px: int = 0
    height_px: int = 0
    problem: FindingReply | None = Field(default=None, description="Why it cannot be used.")
    same_shot: str = Field(
        default="", description="File of the same shot that is used instead; empty: none is."
    )

    @property
    def counts(self) -> bool:
        """Whether a run uses it, as far as is known."""
        unusable = self.problem is not None and self.problem.code == "photo.unusable"
        return self.state != "arriving" and not self.same_shot and not unusable


class Photos(BaseModel):
    """All files of a case."""

    photos: list[Photo]
    here: int = Field(
        description="Photos that are whole and can be used; of several files of one shot one."
    )
    bytes: int
    most_files: int = MOST_FILES
    most_bytes: int = Field(default=MOST_PHOTO_BYTES, description="Of one photo.")


class Sent(BaseModel):
    """What became of what was sent."""

    whole: bool = Field(description="Whether the file is whole now; else send the next piece.")
    new: bool = Field(description="False where the same file was here already.")
    bytes: int = Field(description="Of the file that are here.")
    photos: list[Photo] = Field(default=[], description="The file, or what a zip held.")


@router.get("/cases/{case_id}/photos")
def list_photos(app_state: AppStateHere, case: CaseHere) -> Photos:
    """What is here, and how much of what is still arriving."""
    return photos_reply(photos_of(app_state.intake(case), case))


@router.put(
    "/cases/{case_id}/photos/{name}",
    status_code=200,
    openapi_extra=BYTES,
)
async def put_photo(
    app_state: AppStateHere,
    case: CaseHere,
    name: NameHere,
    request: Request,
    content_range: Annotated[
        str | None, Header(description="Of a piece: bytes 0-1048575/8000000.")
    ] = None,
    upload_id: UploadId = None,
    replace: Annotated[
        bool, Query(description="Put it in the place of another of its name.")
    ] = False,
) -> Sent:
    """Send a photo, a film, or a zip of photos, whole or a piece of it; again does no harm.

    The hash in the answer is that of the file as it came: compare it. What is kept has the same
    pixels; `removed` names what was taken out of its header, `kept` what stays there: of a raw file
    the maker's note, and the whole header where its kind is not known (RAF, CR3, BigTIFF). Of a
    film only the place goes. If the line breaks, ask for the list: it says how many bytes are here;
    go on from there with Content-Range. 409: another upload of the name comes in.
    """
    _require_received(case)
    return await receive(
        app_state.intake(case),
        name,
        request,
        content_range,
        upload_id,
        replace=replace,
        on_change=lambda: app_state.news.tell(case.case_id, "photos"),
    )


@router.delete("/cases/{case_id}/photos/{name}", status_code=204)
def delete_photo(app_state: AppStateHere, case: CaseHere, name: NameHere) -> None:
    """Take a photo out of the case."""
    _require_received(case)
    if not app_state.intake(case).remove(checked_name(name)):
        raise missing("app.no_photo")
    app_state.news.tell(case.case_id, "photos")


@router.get("/cases/{case_id}/photos/{name}/picture", response_class=Response, responses=PICTURE)
def read_picture(
    case: CaseHere,
    name: NameHere,
    width: Annotated[int, Query(ge=_SMALLEST_PX, le=_LARGEST_PX, description="px")] = 320,
    upright: Annotated[
        bool, Query(description="Turned as a person holds it; else as the sensor stores it.")
    ] = True,
    _of: Annotated[str, Query(alias="of", max_length=64, description=ADDRESS_ALONE)] = "",
) -> Response:
    """A photo as a JPEG of some width."""
    path = photo_file(case, checked_name(name))
    return Response(
        _reduced(path, width, upright=upright),
        media_type="image/jpeg",
        headers={"cache-control": "private, max-age=3600"},
    )


@router.get("/cases/{case_id}/photos/{name}/file", response_class=FileResponse, responses=PICTURE)
def read_file(case: CaseHere, name: NameHere) -> FileResponse:
    """A photo as it is kept."""
    path = photo_file(case, checked_name(name))
    return FileResponse(path, filename=path.name, media_type="application/octet-stream")


async def receive(
    intake: Intake,
    name: str,
    request: Request,
    content_range: str | None,
    upload_id: str | None = None,
    *,
    replace: bool,
    on_change: Callable[[], None],
) -> Sent:
    """Receive a file, or a piece of it, from a request."""
    name = checked_name(name)
    start, end, total = _range(content_range)
    length = request.headers.get("content-length", "")
    if total is None and length.isdecimal() and content_range is None:
        total = int(length)
    upload = upload_id or (WHOLE if content_range is None else PIECES)
    stream = await asyncio.to_thread(intake.begin, name, start, total, upload)
    here = start
    most = limit_of(name) if end is None else end + 1
    pending = bytearray()
    with stream:  # held until the file has its name
        async for piece in request.stream():
            here += len(piece)
            if here > most:
                raise OptionsError("photo.upload.too_long", name=name)
            if not pending and len(piece) >= _WRITE_BYTES:
                await asyncio.to_thread(stream.write, piece)
                continue
            pending += piece
            if len(pending) >= _WRITE_BYTES:
                await asyncio.to_thread(stream.write, pending)
                pending = bytearray()
        await asyncio.to_thread(stream.write, pending)
        on_change()
        whole = content_range is None if total is None else here >= total
        if not whole:
            return Sent(whole=False, new=True, bytes=here)
        await asyncio.to_thread(stream.close)
        keeper = None if is_zip(name) else _KEEPER
        work = partial(_finished, intake, name, replace)
        ended = await asyncio.get_running_loop().run_in_executor(keeper, work)
    on_change()
    return Sent(
        whole=True,
        new=any(new for _, new in ended),
        bytes=here,
        photos=[_photo(one) for one, _ in ended],
    )


def photos_of(intake: Intake, case: ShelvedCase) -> list[Photo]:
    """What was sent, and the photos of a case that was made by the command line."""
    found = received_of(intake)
    if case.photos_given is not None:
        given = sorted(one for one in case.photos_given.iterdir() if one.is_file())
        instead = files_not_used(given)
        found = [
            Photo(
                name=one.name,
                state="here",
                bytes=one.stat().st_size,
                same_shot=instead.get(one.name, ""),
            )
            for one in given
        ]
    return found


def received_of(intake: Intake) -> list[Photo]:
    """What was sent, whole or in part."""
    received = intake.received()
    instead = used_instead(intake.folder, received)
    found = [_photo(one, instead.get(one.name, "")) for one in received]
    found += [
        Photo(name=one.name, state="arriving", bytes=one.bytes, total=one.total)
        for one in intake.arriving()
    ]
    return found


def photos_reply(found: list[Photo]) -> Photos:
    return Photos(
        photos=found,
        here=sum(one.counts for one in found),
        bytes=sum(one.bytes for one in found),
    )


def photo_file(case: ShelvedCase, name: str) -> FilePath:
    """The file of a photo of a case."""
    for folder in (case.received, case.folder.photos):
        if (folder / name).is_file():
            return folder / name
    raise missing("app.no_photo")


def _require_received(case: ShelvedCase) -> None:
    """Refuse to change photos that the app did not receive: one more would hide all of them, and a
    run would set them aside.

    Raises:
        CaseError: they were given on the command line.
    """
    if case.photos_given is not None:
        raise CaseError("case.upload.given")


def _finished(intake: Intake, name: str, replace: bool) -> tuple[tuple[Received, bool], ...]:
    if is_zip(name):
        return intake.unpack(name, replace=replace)
    return (intake.finish(name, replace=replace),)


def _photo(received: Received, same_shot: str = "") -> Photo:
    return Photo(
        name=received.name,
        state="unusable" if received.problem else "here",
        bytes=received.bytes,
        total=received.bytes,
        sha256=received.sha256,
        removed=list(received.removed),
        kept=list(received.kept),
        width_px=received.width_px,
        height_px=received.height_px,
        problem=FindingReply.of(received.problem) if received.problem else None,
        same_shot=same_shot,
    )


def _range(text: str | None) -> tuple[int, int | None, int | None]:
    """First and last byte of a piece, and of how many."""
    if text is None:
        return 0, None, None
    found = _RANGE.fullmatch(text.strip())
    first, last = (int(found[1]), int(found[2])) if found else (0, -1)
    total = int(found[3]) if found and found[3] != "*" else None
    if last < first or (total is not None and last >= total):
        raise OptionsError("photo.upload.no_range")
    return first, last, total


def _reduced(path: FilePath, width: int, *, upright: bool) -> bytes:
    try:
        with open_picture(path) as picture:
            picture.draft("RGB", (width, width))
            shown = to_look_at(picture)
            turned = ImageOps.exif_transpose(shown) if upright else shown
            small = turned.convert("RGB")
    except DECODING_FAULTS as fault:
        raise missing("app.photo_damaged") from fault
    height = max(1, round(small.height * width / small.width))
    if small.width > width:
        small = small.resize((width, height), Image.Resampling.BOX)
    made = io.BytesIO()
    small.save(made, "JPEG", quality=82)
    return made.getvalue()
