"""Server: all routes put together, and the client's pages beside them."""

import gzip
import mimetypes
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

from fastapi import Depends, FastAPI, Header
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.exceptions import HTTPException as StarletteHTTPException

from limbgram.app import (
    camera_checks,
    cameras,
    cases,
    check,
    compare,
    events,
    exports,
    jobs,
    limb,
    measures,
    phone,
    photos,
    recipe,
    record,
    session,
    surface,
    templates,
    words,
)
from limbgram.app.access import Guard
from limbgram.app.app_wording import plain_answers
from limbgram.app.idempotency import OnceEach
from limbgram.app.replies import (
    RESPONSES,
    answer_disk,
    answer_http,
    answer_invalid,
    answer_missing,
    answer_refusal,
    missing,
)
from limbgram.app.state import AppState
from limbgram.app.unknown_names import refuse_unknown_query
from limbgram.core.errors import LimbgramError

STATIC = Path(__file__).parent / "static"
"""Where the built client lies."""
PREFIX = "/api/v1"
_RESOURCES = (
    session,
    cases,
    photos,
    phone,
    check,
    jobs,
    surface,
    limb,
    measures,
    recipe,
    exports,
    compare,
    record,
    cameras,
    camera_checks,
    templates,
    events,
    words,
)
_DESCRIPTION = """Photos of a painted sock become a limb's surface in true millimetres; the surface
is measured, adjusted, and leaves as files. Lengths are in mm, angles in degrees, sigmas are one
standard deviation. A refusal says what happened, why, and what to do."""
_NO_CLIENT = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>limbgram</title>
</head><body><h1>The app's pages are missing</h1><p>The server runs, and its API answers under
<code>/api/v1</code>, but the pages were not built into this installation. Install limbgram from its
wheel; or, in a clone, build them: <code>cd web, npm ci, npm run build</code>.</p></body></html>"""
_SHRINKING = (".js", ".css", ".html", ".svg", ".txt")
"""Files of the client that are sent compressed; fonts and pictures are so already."""
_LONG = "public, max-age=31536000, immutable"


def build(app_state: AppState, static: Path = STATIC) -> FastAPI:
    """The routes over one app_state, without their guard."""

    @asynccontextmanager
    async def living(_app: FastAPI) -> AsyncGenerator[None]:
        app_state.open()
        yield
        app_state.close()

    app = FastAPI(
        title="limbgram",
        version=version("limbgram"),
        description=_DESCRIPTION,
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=living,
        default_response_class=plain_answers(app_state.shelf),
        generate_unique_id_function=lambda route: route.name,
    )
    app.state.app_state = app_state
    app.add_middleware(OnceEach, shelf=app_state.shelf)  # pyright: ignore[reportArgumentType]
    for resource in _RESOURCES:
        app.include_router(
            resource.router,
            prefix=PREFIX,
            responses=RESPONSES,
            dependencies=[Depends(refuse_unknown_query)],
        )
    app.include_router(session.start_router)
    app.add_exception_handler(LimbgramError, answer_refusal)
    app.add_exception_handler(StarletteHTTPException, answer_http)
    app.add_exception_handler(RequestValidationError, answer_invalid)
    app.add_exception_handler(LookupError, answer_missing)
    app.add_exception_handler(OSError, answer_disk)

    @app.get("/{path:path}", include_in_schema=False)
    def page(path: str, accept_encoding: Annotated[str, Header()] = "") -> Response:
        """A file of the client; any other path is the client's own, and gets its page."""
        return _page(static, path, accept_encoding)

    return app


def guarded(app_state: AppState, static: Path = STATIC) -> Guard:
    """The server as it stands on a socket."""
    return Guard(build(app_state, static), app_state.access, diary=app_state.phone_ports.diary)


def _page(static: Path, path: str, accepted: str) -> Response:
    if path.startswith("api/"):
        raise missing("app.no_route")
    start = static / "index.html"
    if not start.is_file():
        return HTMLResponse(_NO_CLIENT, status_code=503)
    found = _static_file(static, path) if path else start
    if found is not None:
        kept = _LONG if path.startswith("assets/") else "no-cache"
        status = found.stat()
        if found.suffix in _SHRINKING and "gzip" in accepted:
            kind = mimetypes.guess_type(found.name)[0] or "application/octet-stream"
            small = _shrunk(found, status.st_mtime_ns, status.st_size)
            headers = {"cache-control": kept, "content-encoding": "gzip", "vary": "accept-encoding"}
            return Response(small, media_type=kind, headers=headers)
        return FileResponse(found, headers={"cache-control": kept, "vary": "accept-encoding"})
    if "." in path.rpartition("/")[2]:
        raise missing("case.no_such_file")
    return FileResponse(start, headers={"cache-control": "no-cache"})


def _static_file(static: Path, path: str) -> Path | None:
    """The client's file of a path; None where there is none, or it lies outside the folder."""
    try:
        found = (static / path).resolve()
        inside = found.is_relative_to(static.resolve())
        return found if inside and found.is_file() else None
    except (OSError, ValueError):  # a name that no file can have: too long, or with a NUL
        return None


@lru_cache(maxsize=64)
def _shrunk(file: Path, _changed: int, _size: int) -> bytes:
    """A file of the client, compressed once: some hundred kB in all."""
    return gzip.compress(file.read_bytes(), mtime=0)
