"""Events: server-sent events on changes of cases, while the session is open.

A change is sent at once, those of the second after it together: a client asks again at each event,
and a run reports its steps many times a second.
"""

import asyncio
import json
from collections.abc import AsyncGenerator, Callable

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from limbgram.app.state import AppState, AppStateHere, CaseHere, SessionHere

router = APIRouter(tags=["events"])

_LOOK_S = 0.15
_APART_S = 1.0
_BEAT_S = 15.0
_STREAM = {
    200: {
        "description": "Server-sent events. event: change; data: a JSON object.",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/cases/{case_id}/events", response_class=StreamingResponse, responses={**_STREAM})
def listen_to_case(
    app_state: AppStateHere, case: CaseHere, request: Request, session: SessionHere
) -> StreamingResponse:
    """Subjects of a case that changed: {"changed": ["photos", "check", "job", "work", "case"]}.

    The first event names all of them. Ask the resource of a subject for what it is now.
    """
    return _stream(app_state, request, session, lambda: app_state.news.of(case.case_id))


@router.get("/events", response_class=StreamingResponse, responses={**_STREAM})
def listen_to_all(
    app_state: AppStateHere, request: Request, session: SessionHere
) -> StreamingResponse:
    """Cases that changed: {"changed": ["K7Q-4F2"]}; `cameras` stands for the cameras."""
    return _stream(app_state, request, session, app_state.news.of_all)


def _stream(
    app_state: AppState, request: Request, session: str, counts: Callable[[], dict[str, int]]
) -> StreamingResponse:
    access = app_state.access_of(request)
    return StreamingResponse(
        _changes(app_state, request, counts, lambda: access.state(session) == "open"),
        media_type="text/event-stream",
        headers={"cache-control": "no-store", "x-accel-buffering": "no"},
    )


async def _changes(
    app_state: AppState,
    request: Request,
    counts: Callable[[], dict[str, int]],
    may_listen: Callable[[], bool],
) -> AsyncGenerator[str]:
    before: dict[str, int] | None = None
    quiet_s = told_s = _APART_S
    while not app_state.closing and may_listen() and not await request.is_disconnected():
        now = counts()
        changed = [name for name, count in now.items() if (before or {}).get(name) != count]
        if before is None or (changed and told_s >= _APART_S):
            yield f"event: change\ndata: {json.dumps({'changed': changed})}\n\n"
            told_s = _APART_S if before is None else 0.0
            before, quiet_s = now, 0.0
        elif quiet_s >= _BEAT_S:
            yield ": still here\n\n"
            quiet_s = 0.0
        await asyncio.sleep(_LOOK_S)
        quiet_s += _LOOK_S
        told_s += _LOOK_S
