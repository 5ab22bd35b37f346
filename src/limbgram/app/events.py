"""Events: a line whenever something of a case changed, as long as somebody may listen."""

import asyncio
import json
from collections.abc import AsyncGenerator, Callable

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from limbgram.app.access import session_in
from limbgram.app.clinic import CaseHere, Clinic, ClinicHere

router = APIRouter(tags=["events"])

_LOOK_S = 0.15
_BEAT_S = 15.0
_STREAM = {
    200: {
        "description": "Server-sent events. event: change; data: a JSON object.",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/cases/{case_id}/events", response_class=StreamingResponse, responses={**_STREAM})
def listen_to_case(clinic: ClinicHere, case: CaseHere, request: Request) -> StreamingResponse:
    """Subjects of a case that changed: {"changed": ["photos", "check", "job", "work", "case"]}.

    The first event names all of them. Ask the resource of a subject for what it is now.
    """
    return _stream(clinic, request, lambda: clinic.news.of(case.case_id))


@router.get("/events", response_class=StreamingResponse, responses={**_STREAM})
def listen_to_all(clinic: ClinicHere, request: Request) -> StreamingResponse:
    """Cases that changed: {"changed": ["K7Q-4F2"]}; `cameras` stands for the cameras."""
    return _stream(clinic, request, clinic.news.of_all)


def _stream(
    clinic: Clinic, request: Request, counts: Callable[[], dict[str, int]]
) -> StreamingResponse:
    access = clinic.access_of(request)
    session = session_in(request.headers.get("cookie", ""))
    return StreamingResponse(
        _changes(clinic, request, counts, lambda: access.state(session) == "open"),
        media_type="text/event-stream",
        headers={"cache-control": "no-store", "x-accel-buffering": "no"},
    )


async def _changes(
    clinic: Clinic,
    request: Request,
    counts: Callable[[], dict[str, int]],
    may_listen: Callable[[], bool],
) -> AsyncGenerator[str]:
    before: dict[str, int] | None = None
    quiet_s = 0.0
    while not clinic.closing and may_listen() and not await request.is_disconnected():
        now = counts()
        changed = [name for name, count in now.items() if (before or {}).get(name) != count]
        if changed or before is None:
            yield f"event: change\ndata: {json.dumps({'changed': changed})}\n\n"
            quiet_s = 0.0
        elif quiet_s >= _BEAT_S:
            yield ": still here\n\n"
            quiet_s = 0.0
        before = now
        await asyncio.sleep(_LOOK_S)
        quiet_s += _LOOK_S
