"""Surface: the shape to look at, and all that is asked of it: points, sections, differences."""

import hashlib
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Header, Query, Response
from pydantic import BaseModel, Field

from limbgram.app.binary_arrays import encode_blocks, surface_blocks
from limbgram.app.forms import RequestBody
from limbgram.app.replies import BINARY, FindingReply
from limbgram.app.state import AppState, AppStateHere, CaseHere, WorkspaceHere
from limbgram.cases.photo_evidence import PointPhoto, point_evidence
from limbgram.cases.workspace import Workspace
from limbgram.core.interval import COVER
from limbgram.core.mesh.sections import cut
from limbgram.workbench.edits.pressing import changed_vertices, signed_offsets
from limbgram.workbench.limb import AlignedLimb, Limb
from limbgram.workbench.recipe.file import encode_recipe
from limbgram.workbench.recipe.recipe import Recipe, beginning

router = APIRouter(tags=["surface"])

Which = Literal["scan", "rectified"]
WhichHere = Annotated[
    Which, Query(description="The scan as it was computed, or the shape after the recipe.")
]
_Coordinate = Annotated[float, Field(allow_inf_nan=False)]
Coordinates = tuple[_Coordinate, _Coordinate, _Coordinate]


class AskPoint(RequestBody):
    """A place on the surface."""

    position_mm: Coordinates = Field(description="In the mesh's frame.")


class Point(BaseModel):
    """What is known of a place on the surface."""

    position_mm: Coordinates = Field(description="The nearest place on the surface.")
    normal: Coordinates
    in_limb_mm: Coordinates | None = Field(
        default=None, description="In the limb frame, if it is aligned."
    )
    sigma_mm: float | None = Field(
        default=None, description="One standard deviation; null: filled in."
    )
    within_mm: float | None = Field(default=None, description="± in 95 of 100.")
    filled: bool
    photos: list[PointPhoto] = Field(
        default=[], description="That measured it, the squarest first."
    )
    photos_note: FindingReply | None = Field(default=None, description="Why no photos are named.")


class Ring(BaseModel):
    """One closed or open line of a section."""

    closed: bool
    length_mm: float
    points_mm: list[Coordinates] = Field(description="In the mesh's frame.")


class Section(BaseModel):
    """The lines in which a plane across the limb cuts the surface."""

    height_mm: float = Field(description="In the limb frame; of an unaligned shape the mesh's z.")
    rings: list[Ring]


@router.get("/cases/{case_id}/surface", response_class=Response, responses=BINARY)
def read_surface(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    of: WhichHere = "scan",
    if_none_match: Annotated[str | None, Header()] = None,
) -> Response:
    """The surface as blocks (docs/library/http.md): positions, indices, normals, sigma, colours.

    Positions are in the mesh's frame; `limb` says how they lie in the limb's.
    """
    limb, tag = limb_of(app_state, workspace, of)
    if if_none_match is not None and tag in if_none_match:
        return Response(status_code=304, headers={"etag": tag})
    return Response(
        surface_blocks(limb.mesh, {"of": of, "tag": tag.strip('"')}),
        media_type="application/octet-stream",
        headers={"etag": tag, "cache-control": "private, no-cache"},
    )


@router.get("/cases/{case_id}/surface/differences", response_class=Response, responses=BINARY)
def read_differences(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    edits: Annotated[
        int | None,
        Query(
            ge=0,
            le=1000,
            description="The first edits of the recipe that the other shape has: an earlier state.",
        ),
    ] = None,
) -> Response:
    """How far each vertex of the shape after the recipe lies from the scan: block signed_mm.

    Or from the shape as it was after the first edits. Positive outward: added. In the order of the
    vertices of `surface?of=rectified`.
    """
    after, tag = limb_of(app_state, workspace, "rectified")
    before = limb_before(app_state, workspace, edits)
    signed = np.zeros(len(after.mesh), np.float32)
    moved = changed_vertices(before.mesh, after.mesh)
    if moved.any():
        signed[moved] = signed_offsets(before.mesh, after.mesh.vertices_mm[moved]).signed_mm
    content = encode_blocks({"what": "differences", "tag": tag.strip('"')}, {"signed_mm": signed})
    return Response(content, media_type="application/octet-stream")


@router.post("/cases/{case_id}/surface/point")
def ask_point(
    app_state: AppStateHere, case: CaseHere, workspace: WorkspaceHere, given: AskPoint
) -> Point:
    """What is known of a place: how sure, and the photos that measured it, with residuals."""
    shape = app_state.shape_cache.shape(workspace)
    mesh, limb = shape.limb.mesh, shape.limb
    found = shape.tree.closest(np.array([given.position_mm], np.float64))
    place, face = found.points_mm[0], mesh.faces[found.faces[0]]
    corners = mesh.vertices_mm[face]
    nearest = int(face[int(np.linalg.norm(corners - place, axis=1).argmin())])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= max(float(np.linalg.norm(normal)), 1e-30)
    sigma = None if mesh.sigma_mm is None else float(mesh.sigma_mm[nearest])
    known = sigma is not None and bool(np.isfinite(sigma))
    filled = mesh.filled is not None and bool(mesh.filled[nearest])
    seen = point_evidence(case.folder, place, normal)
    motion = limb.known_limb_from_mesh
    return Point(
        position_mm=triple(place),
        normal=triple(normal),
        in_limb_mm=None if motion is None else triple(motion.apply(place[None])[0]),
        sigma_mm=sigma if known else None,
        within_mm=COVER * sigma if known and sigma is not None else None,
        filled=filled,
        photos=list(seen.photos),
        photos_note=None if seen.note is None else FindingReply.of(seen.note),
    )


@router.get("/cases/{case_id}/surface/section")
def read_section(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    height_mm: Annotated[
        float, Query(ge=-5000, le=5000, description="In the limb frame, from the distal end.")
    ],
    of: WhichHere = "scan",
) -> Section:
    """The ring at a height, to draw on the limb."""
    limb, _ = limb_of(app_state, workspace, of)
    motion = limb.known_limb_from_mesh
    if motion is None:
        sections = cut(limb.mesh, [height_mm])
    else:
        along = motion.rotation[2]
        sections = cut(limb.mesh, [height_mm - float(motion.translation[2])], along)
    rings = [
        Ring(
            closed=one.closed,
            length_mm=one.length_mm,
            points_mm=[triple(point) for point in one.points_mm],
        )
        for one in sections
    ]
    return Section(height_mm=height_mm, rings=rings)


def limb_of(app_state: AppState, workspace: Workspace, of: Which) -> tuple[Limb, str]:
    """The shape that is meant, and a tag that is another one when it changes."""
    shape = app_state.shape_cache.shape(workspace)
    if of == "scan":
        return shape.limb, f'"{shape.file.sha256[:24]}"'
    recipe = workspace.recipe()
    return shape.replayed(recipe).limb, f'"{tag_of(shape.file.sha256, shape.limb, recipe)}"'


def limb_before(app_state: AppState, workspace: Workspace, edits: int | None) -> Limb:
    """The scan, or the shape after the first edits of the recipe.

    Raises:
        OptionsError: the recipe has fewer edits.
    """
    if edits is None:
        return limb_of(app_state, workspace, "scan")[0]
    return (
        app_state.shape_cache.shape(workspace).replayed(beginning(workspace.recipe(), edits)).limb
    )


def tag_of(sha256: str, limb: Limb, recipe: Recipe) -> str:
    """Tells shapes made by a recipe apart: by scan, landmarks and what the recipe does."""
    places = repr([(mark.name, mark.position_mm.tolist()) for mark in limb.landmarks])
    frame = limb.frame if isinstance(limb, AlignedLimb) else None
    text = sha256.encode() + places.encode() + repr(frame).encode() + encode_recipe(recipe)
    return hashlib.sha256(text).hexdigest()[:24]


def triple(values: np.ndarray) -> Coordinates:
    x, y, z = (float(value) for value in values)
    return x, y, z
