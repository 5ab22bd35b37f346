"""Exports: files for carvers, printers and other programs, with what was read back of each."""

from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as InPath
from fastapi.responses import FileResponse
from pydantic import BaseModel, Field

from limbgram.app.forms import FieldReply, RequestBody
from limbgram.app.replies import PICTURE, missing
from limbgram.app.state import AppStateHere, WorkspaceHere
from limbgram.cases.case_export import (
    ExportedFile,
    ExportOptions,
    export_shape,
    exported_file,
    exported_files,
    mirror_picture,
)
from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import declared
from limbgram.core.typed import Mismatch, value_of
from limbgram.formats.reading import SUFFIXES
from limbgram.services.export import EVERYDAY, EXPORTS, USED_FOR, Triangles
from limbgram.workbench.limb import Side

router = APIRouter(tags=["export"])

NameHere = Annotated[
    str, InPath(max_length=80, pattern=r"^[A-Za-z0-9][A-Za-z0-9.-]*$", description="Of the file.")
]


class NewExport(RequestBody):
    """Which file to write."""

    kind: str = Field(max_length=20, description="A kind of `/api/v1/exports`.")
    side: Side = Field(description="Said anew by whoever looks at the patient; never filled in.")
    signed_by: str = Field(
        default="", max_length=300, description="For a red capture: who takes it on, and why."
    )
    how: dict[str, Any] = Field(
        default={}, max_length=40, description="What the receiver expects, by the kind's fields."
    )


class ExportKind(BaseModel):
    """A kind of file that is written."""

    kind: str
    used_for: dict[str, str] = Field(description="Who takes it, by language.")
    everyday: bool = Field(description="Asked for by most.")
    mesh: bool = Field(description="A surface of triangles and no more.")
    fields: list[FieldReply]


@router.get("/exports")
def list_export_kinds() -> list[ExportKind]:
    """The kinds of files that are written, the everyday ones first, and what each may be asked."""
    return [
        ExportKind(
            kind=kind,
            used_for={**USED_FOR[kind]},
            everyday=kind in EVERYDAY,
            mesh=EXPORTS[kind] is Triangles,
            fields=[FieldReply.of(one) for one in declared(EXPORTS[kind]) if one.hint is not Path],
        )
        for kind in (*EVERYDAY, *(one for one in EXPORTS if one not in EVERYDAY))
    ]


@router.get("/shape-files")
def list_shape_files() -> list[str]:
    """The endings of files that are read as shapes."""
    return list(SUFFIXES)


@router.get("/cases/{case_id}/exports")
def list_exports(workspace: WorkspaceHere) -> list[ExportedFile]:
    """The files that were written, the newest first."""
    return list(exported_files(workspace))


@router.post("/cases/{case_id}/exports", status_code=201)
def new_export(app_state: AppStateHere, workspace: WorkspaceHere, given: NewExport) -> ExportedFile:
    """Write a file, read it back, compare, and draw the picture to hold against the patient."""
    written = export_shape(workspace, app_state.shape_cache.work(workspace), _options(given))
    app_state.news.tell(workspace.case.case_id, "work")
    return written


@router.get("/cases/{case_id}/exports/{name}", response_class=FileResponse, responses=PICTURE)
def read_export(workspace: WorkspaceHere, name: NameHere) -> FileResponse:
    """The file."""
    found = exported_file(workspace, name)
    return FileResponse(
        workspace.files / found.name, filename=found.name, media_type="application/octet-stream"
    )


@router.get(
    "/cases/{case_id}/exports/{name}/mirror", response_class=FileResponse, responses=PICTURE
)
def read_mirror(workspace: WorkspaceHere, name: NameHere) -> FileResponse:
    """The mirror check: what the file holds, to be held against the patient."""
    picture = mirror_picture(workspace, exported_file(workspace, name).name)
    if not picture.is_file():
        raise missing("app.no_picture")
    return FileResponse(picture)


def _options(given: NewExport) -> ExportOptions:
    request = EXPORTS.get(given.kind)
    if request is None:
        raise OptionsError("exported.no_kind", kind=given.kind, kinds=tuple(EXPORTS))
    paths = [one.name for one in declared(request) if one.hint is Path]  # no files of the server
    try:
        ask = value_of({key: one for key, one in given.how.items() if key not in paths}, request)
    except Mismatch as error:
        raise OptionsError("exported.not_so", kind=given.kind, reason=str(error)) from error
    return ExportOptions(kind=given.kind, side=given.side, signed_by=given.signed_by, ask=ask)
