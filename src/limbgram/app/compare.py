"""Compare: the shape of a case beside its scan, an earlier state of its recipe, another case, or a
shape of elsewhere."""

import asyncio
import secrets
import shutil
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response
from pydantic import BaseModel, Field

from limbgram.app.binary_arrays import encode_blocks
from limbgram.app.forms import REQUEST
from limbgram.app.replies import BINARY, BYTES, FindingReply, missing
from limbgram.app.state import AppState, AppStateHere, WorkspaceHere, other_case
from limbgram.app.surface import Which, limb_before, limb_of
from limbgram.cases.workspace import Workspace
from limbgram.core.errors import MissingError, OptionsError
from limbgram.core.files import written_whole
from limbgram.core.request_fields import Within
from limbgram.findings import Finding
from limbgram.formats.reading import SUFFIXES, read_limb
from limbgram.services.compare import CompareRequest, compare
from limbgram.workbench.compare.comparison import Comparison
from limbgram.workbench.compare.messages import comparison_tree, verdict
from limbgram.workbench.limb import Limb

router = APIRouter(tags=["compare"])

_MOST_BYTES = 400_000_000
_NAME = r"^[A-Za-z0-9][A-Za-z0-9 _-]{0,60}\.[A-Za-z]{3}$"


@dataclass(frozen=True, kw_only=True)
class Against(CompareRequest):
    """What the shape is compared with."""

    __pydantic_config__ = REQUEST

    of: Which = "rectified"
    """Which shape of this case is the second."""
    case: str | None = None
    """Another case, whose scan is the first."""
    shape: str | None = None
    """A file that was sent; it is the first."""
    edits: Annotated[int | None, Within(0, 1000)] = None
    """The first is this case after so many edits: an earlier state of its recipe."""


class ComparisonReply(BaseModel):
    """What changed from the first shape to the second."""

    verdict: FindingReply
    figures: dict[str, Any] = Field(description="As `limbgram compare --json` gives them.")


class ShapeName(BaseModel):
    """A shape that was sent."""

    name: str
    bytes: int


@router.get("/cases/{case_id}/shapes")
def list_shapes(workspace: WorkspaceHere) -> list[ShapeName]:
    """Shapes that were sent from elsewhere, to compare with."""
    if not workspace.shapes.is_dir():
        return []
    files = sorted(
        one
        for one in workspace.shapes.iterdir()
        if one.suffix.lower() in SUFFIXES and not one.name.startswith(".")  # still being read
    )
    return [ShapeName(name=one.name, bytes=one.stat().st_size) for one in files]


@router.put(
    "/cases/{case_id}/shapes/{name}",
    openapi_extra=BYTES,
)
async def put_shape(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    name: Annotated[str, Path(pattern=_NAME)],
    request: Request,
) -> ShapeName:
    """Send a shape to compare with, in a format that is read."""
    suffix = f".{name.rpartition('.')[2].lower()}"
    if suffix not in SUFFIXES:
        raise OptionsError("compare.file.kind", name=name)
    workspace.make_folder(workspace.shapes)
    own = workspace.shapes / f".{secrets.token_hex(4)}"
    sent, size = own / name, 0  # under its own name, by which a refusal names it
    try:
        own.mkdir()
        with sent.open("xb") as stream:
            async for piece in request.stream():  # of which none stays in memory
                size += len(piece)
                if size > _MOST_BYTES:
                    raise OptionsError(
                        "compare.file.large", name=name, most_mb=_MOST_BYTES // 1_000_000
                    )
                await asyncio.to_thread(stream.write, piece)
        # Others are answered meanwhile.
        await asyncio.to_thread(_keep_shape, sent, workspace.shapes / name)
    finally:
        shutil.rmtree(own, ignore_errors=True)
    app_state.news.tell(workspace.case.case_id, "work")
    return ShapeName(name=name, bytes=size)


@router.delete("/cases/{case_id}/shapes/{name}", status_code=204)
def delete_shape(
    app_state: AppStateHere, workspace: WorkspaceHere, name: Annotated[str, Path(pattern=_NAME)]
) -> None:
    """Take a shape away that was sent."""
    if name not in [one.name for one in list_shapes(workspace)]:
        raise missing("app.no_shape")
    (workspace.shapes / name).unlink()
    app_state.news.tell(workspace.case.case_id, "work")


@router.post("/cases/{case_id}/compare")
def compare_with(
    app_state: AppStateHere, workspace: WorkspaceHere, given: Against, request: Request
) -> ComparisonReply:
    """Where two shapes differ, by how much, and whether it matters for the fit."""
    found = _compared(app_state, workspace, given, request)
    said = FindingReply.of(verdict(found).finding)
    return ComparisonReply(verdict=said, figures=_finite(comparison_tree(found)))


@router.post("/cases/{case_id}/compare/differences", response_class=Response, responses=BINARY)
def read_compared(
    app_state: AppStateHere, workspace: WorkspaceHere, given: Against, request: Request
) -> Response:
    """The second shape in the first's limb frame, with its signed distance at each vertex.

    Blocks positions, indices and signed_mm; positive outside the first; NaN where nothing is near.
    The header has the figures of the same comparison, so that map and figures are one answer.
    """
    found = _compared(app_state, workspace, given, request)
    signed = found.deviation.on_second.difference_mm
    mesh = found.second_in_limb
    content = encode_blocks(
        {
            "what": "differences",
            "first": found.names[0],
            "second": found.names[1],
            "figures": _finite(comparison_tree(found)),
        },
        {"positions": mesh.vertices_mm, "indices": mesh.faces, "signed_mm": signed},
    )
    return Response(content, media_type="application/octet-stream")


def _keep_shape(sent: FilePath, place: FilePath) -> None:
    """Keep a shape that can be read."""
    read_limb(sent)
    with written_whole(place) as beside:
        sent.rename(beside)


def _compared(
    app_state: AppState, workspace: Workspace, given: Against, request: Request
) -> Comparison:
    second, _ = limb_of(app_state, workspace, given.of)
    return compare(_first(app_state, workspace, given, request), second, given)


def _first(app_state: AppState, workspace: Workspace, given: Against, request: Request) -> Limb:
    chosen = [one for one in (given.case, given.shape, given.edits) if one is not None]
    if len(chosen) > 1:
        raise OptionsError("compare.first.several")
    if given.case is not None:
        other = other_case(app_state, request, given.case)
        return app_state.shape_cache.shape(Workspace(other)).limb
    if given.shape is not None:
        known = [one.name for one in list_shapes(workspace)]
        if given.shape not in known:
            raise MissingError("app.no_shape")
        return read_limb(workspace.shapes / given.shape)
    return limb_before(app_state, workspace, given.edits)


def _finite(tree: Any) -> Any:
    """Without numbers that JSON does not have, and with findings in the words of the app."""
    match tree:
        case {"code": str(), "values": dict()}:
            return FindingReply.of(Finding.from_tree(tree)).model_dump(mode="json")
        case dict():
            return {str(name): _finite(value) for name, value in tree.items()}
        case list() | tuple():
            return [_finite(value) for value in tree]
        case float() if tree != tree or tree in (float("inf"), float("-inf")):
            return None
        case _:
            return tree
