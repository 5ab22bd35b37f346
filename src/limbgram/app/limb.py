"""Limb: landmarks, side and axes of the shape that is worked on."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Path, Request
from pydantic import BaseModel, Field

from limbgram.app.forms import REQUEST, RequestBody
from limbgram.app.replies import FindingReply, missing
from limbgram.app.state import AppState, AppStateHere, WorkspaceHere, other_case
from limbgram.app.surface import Coordinates, triple
from limbgram.cases.case_assessment import stickers_of
from limbgram.cases.shelf import ID_PATTERN
from limbgram.cases.workspace import Workspace
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import COVER
from limbgram.services.align import AlignRequest, align, propose
from limbgram.workbench.anatomy.kind import Facing
from limbgram.workbench.frame.landmarks import NAMES, with_landmarks
from limbgram.workbench.frame.painted_marks import find_marks
from limbgram.workbench.frame.suggested_landmarks import guess_places
from limbgram.workbench.limb import KIND_NAMED, KindName, Landmark, Limb, Placed, Side

router = APIRouter(tags=["limb"])

EarlierCase = Annotated[str, Path(pattern=ID_PATTERN, description="Id of the other case.")]
NameHere = Annotated[str, Path(min_length=1, max_length=80, description="The landmark's name.")]


class Place(BaseModel):
    """A named place on the surface."""

    name: str
    position_mm: Coordinates = Field(description="In the mesh's frame, on the surface.")
    in_limb_mm: Coordinates | None = Field(default=None, description="Right, anterior, proximal.")
    within_mm: float | None = Field(
        default=None, description="± in 95 of 100 of the surface there."
    )


class LimbReply(BaseModel):
    """What is known of the shape that is worked on."""

    source: str = Field(description="Name of its file in the case.")
    sha256: str
    vertices: int
    faces: int
    aligned: bool
    side: Side | None = None
    kind: KindName | None = None
    places: list[Place]
    rotation: list[Coordinates] | None = Field(
        default=None, description="Rows of the rotation from the mesh's frame to the limb's."
    )
    translation_mm: Coordinates | None = Field(default=None, description="Of that motion.")
    flexion_deg: float = Field(description="With which the axes were set last.")
    size_mm: Coordinates = Field(description="Of its box: in the limb frame if it is aligned.")
    sock_mm: float
    stale: bool = Field(description="The case was computed again: take the new surface, or stay.")
    doubt: FindingReply | None = Field(
        default=None, description="Why nothing may be made of it unchecked."
    )
    notes: list[FindingReply] = []


class PlaceMark(RequestBody):
    """Where a place was picked."""

    position_mm: Coordinates = Field(description="In the mesh's frame, near the surface.")
    placed: Placed = Field(default="click", description="How: it tells how well, for angles.")
    sigma_mm: Annotated[float, Field(gt=0, le=50)] | None = Field(
        default=None,
        description="How well, in each direction along the surface; else as usual for that way.",
    )


class TemplateName(BaseModel):
    """A place that clinicians know by name."""

    name: str
    facing: Facing
    level: int


class LimbKind(BaseModel):
    """A kind of limb."""

    kind: KindName
    words: dict[str, str] = Field(description="What people call it, by language.")
    sided: bool = Field(description="Whether it is a left or a right one.")
    long: bool = Field(description="Whether its long axis can be fitted to the surface.")
    sheet: bool = Field(description="Whether it has a measuring sheet.")
    joints: list[str] = Field(description="That `repose` turns.")


class Mark(BaseModel):
    """A painted spot that may be a place."""

    position_mm: Coordinates
    colour: tuple[int, int, int]
    diameter_mm: float


class Guess(BaseModel):
    """A place that may be a landmark: somebody confirms it."""

    by: Literal["shape", "sticker", "visit"]
    name: str = Field(default="", description="Of the landmark; empty for a sticker.")
    sticker: int | None = Field(default=None, description="Number on the sticker.")
    position_mm: Coordinates = Field(description="In the mesh's frame, on the surface.")
    sigma_mm: float | None = Field(
        default=None, description="How well it is told, in each direction along the surface."
    )
    within_mm: float | None = Field(default=None, description="The same, ± in 95 of 100.")


class NotCarriedReply(BaseModel):
    """A landmark of the other scan that this one does not tell."""

    name: str
    reason: FindingReply


class CarriedGuesses(BaseModel):
    """What another scan of the limb, such as an earlier visit's, tells of its landmarks."""

    places: list[Guess]
    left_out: list[NotCarriedReply]
    rms_mm: float = Field(description="Between both surfaces, laid on each other as a whole.")


class Guesses(BaseModel):
    """All guesses, and why some kinds have none."""

    places: list[Guess]
    note: FindingReply | None = Field(default=None, description="Why stickers were not looked for.")


@dataclass(frozen=True, kw_only=True)
class Align(AlignRequest):
    """What the clinician states. Directions are in the mesh's frame."""

    __pydantic_config__ = REQUEST


@router.get("/limb-kinds")
def list_limb_kinds() -> list[LimbKind]:
    """The kinds of limb, in the order of lists."""
    return [
        LimbKind(
            kind=one.name,
            words=dict(one.words),
            sided=one.sided,
            long=one.long,
            sheet=bool(one.sheet),
            joints=[joint.name for joint in one.joints],
        )
        for one in KIND_NAMED.values()
    ]


@router.get("/templates/names/{kind}")
def list_names(kind: KindName) -> list[TemplateName]:
    """The places that are known of a kind of limb, in the order in which they are asked for."""
    return [
        TemplateName(name=one.identity, facing=one.facing, level=one.level or 0)
        for one in NAMES[kind]
    ]


@router.get("/cases/{case_id}/limb")
def read_limb(app_state: AppStateHere, workspace: WorkspaceHere) -> LimbReply:
    """The shape that is worked on: places, side, axes."""
    return limb_reply(app_state, workspace)


@router.put("/cases/{case_id}/limb/places/{name}")
def put_place(
    app_state: AppStateHere, workspace: WorkspaceHere, name: NameHere, given: PlaceMark
) -> LimbReply:
    """Place a landmark, or move it; it goes to the nearest place on the surface."""
    picked = Landmark(
        name=name,
        position_mm=_vector(given.position_mm),
        placed=given.placed,
        sigma_mm=given.sigma_mm,
    )
    with app_state.shape_cache.changing(workspace):
        shape = app_state.shape_cache.shape(workspace)
        workspace.save_limb(with_landmarks(shape.limb, [picked]), shape.file)
    return _changed_reply(app_state, workspace)


@router.delete("/cases/{case_id}/limb/places/{name}")
def delete_place(app_state: AppStateHere, workspace: WorkspaceHere, name: NameHere) -> LimbReply:
    """Take a landmark away."""
    with app_state.shape_cache.changing(workspace):
        shape = app_state.shape_cache.shape(workspace)
        left = tuple(one for one in shape.limb.landmarks if one.name != name)
        if len(left) == len(shape.limb.landmarks):
            raise missing("app.no_place")
        workspace.save_limb(replace(shape.limb, landmarks=left), shape.file)
    return _changed_reply(app_state, workspace)


@router.get("/cases/{case_id}/limb/marks")
def list_marks(app_state: AppStateHere, workspace: WorkspaceHere) -> list[Mark]:
    """Painted spots on the surface, the plainest first: guesses for places."""
    found = find_marks(app_state.shape_cache.shape(workspace).limb.mesh)
    return [
        Mark(
            position_mm=triple(one.position_mm),
            colour=(int(one.colour[0]), int(one.colour[1]), int(one.colour[2])),
            diameter_mm=one.diameter_mm,
        )
        for one in found
    ]


@router.get("/cases/{case_id}/limb/guesses")
def list_guesses(app_state: AppStateHere, workspace: WorkspaceHere) -> Guesses:
    """Places that the shape itself tells, and coded stickers that the photos show."""
    shape = app_state.shape_cache.shape(workspace)
    limb = replace(shape.limb, kind=shape.limb.kind or workspace.case.label.kind)
    found = [
        Guess(by="shape", name=one.name, position_mm=triple(one.position_mm))
        for one in guess_places(limb)
    ]
    try:
        stickers = stickers_of(workspace.case.folder, limb.mesh)
    except (CaseError, OptionsError) as error:  # a shape without its photos has no stickers
        return Guesses(places=found, note=FindingReply.of(error.finding, app_state.shelf.root))
    for one in stickers.placed:
        at = shape.tree.closest(one.position_mm[None]).points_mm[0]
        found.append(Guess(by="sticker", sticker=one.mark_id, position_mm=triple(at)))
    return Guesses(places=found)


@router.get("/cases/{case_id}/limb/guesses/{earlier_id}")
def list_carried_guesses(
    app_state: AppStateHere, workspace: WorkspaceHere, earlier_id: EarlierCase, request: Request
) -> CarriedGuesses:
    """Landmarks of another case, such as the patient's last one, as they lie on this limb."""
    label = workspace.case.label
    limb = app_state.shape_cache.shape(workspace).limb
    earlier = Workspace(other_case(app_state, request, earlier_id))
    marked = app_state.shape_cache.shape(earlier).limb
    side = limb.side if limb.side != "none" else label.side or "none"
    carried = propose(limb, marked, side, label.kind).carried
    return CarriedGuesses(
        places=[
            Guess(
                by="visit",
                name=one.landmark.name,
                position_mm=triple(one.landmark.position_mm),
                sigma_mm=one.landmark.sigma_mm,
                within_mm=COVER * (one.landmark.sigma_mm or 0.0),
            )
            for one in carried.places
        ],
        left_out=[
            NotCarriedReply(name=one.name, reason=FindingReply.of(one.reason))
            for one in carried.left_out
        ],
        rms_mm=carried.rms_mm,
    )


@router.post("/cases/{case_id}/limb/align")
def align_limb(app_state: AppStateHere, workspace: WorkspaceHere, given: Align) -> LimbReply:
    """Give the shape its axes: +Z proximal, +Y anterior, +X the patient's right, origin distal."""
    with app_state.shape_cache.changing(workspace):
        shape = app_state.shape_cache.shape(workspace)
        label = workspace.case.label
        ask = replace(given, kind=given.kind or label.kind)
        aligned = align(shape.limb, ask, shape.file.declared)
        workspace.save_limb(aligned, shape.file)
        said = replace(label, side=ask.side, kind=ask.kind, flexion_deg=ask.flexion_deg)
        workspace.case.relabel(said)
    app_state.news.tell(workspace.case.case_id, "case")
    reply = _changed_reply(app_state, workspace)
    reply.notes = _notes(app_state, aligned)
    return reply


@router.post("/cases/{case_id}/limb/refresh")
def refresh_limb(app_state: AppStateHere, workspace: WorkspaceHere) -> LimbReply:
    """Take the surface of the last run to work on; places are carried over, axes set anew."""
    with app_state.shape_cache.changing(workspace):
        workspace.take_scan()
    return _changed_reply(app_state, workspace)


def limb_reply(app_state: AppState, workspace: Workspace) -> LimbReply:
    shape = app_state.shape_cache.shape(workspace)
    limb, mesh = shape.limb, shape.limb.mesh
    motion = limb.known_limb_from_mesh
    places = mesh.vertices_mm if motion is None else motion.apply(mesh.vertices_mm)
    return LimbReply(
        source=workspace.scan_file().name,
        sha256=shape.file.sha256,
        vertices=len(mesh),
        faces=len(mesh.faces),
        aligned=motion is not None,
        side=None if motion is None else limb.side,
        kind=limb.kind or workspace.case.label.kind,
        places=[_place(limb, one) for one in limb.landmarks],
        rotation=None if motion is None else [triple(row) for row in motion.rotation],
        translation_mm=None if motion is None else triple(motion.translation),
        flexion_deg=workspace.case.label.flexion_deg,
        size_mm=triple(np.ptp(places, axis=0)),
        sock_mm=limb.sock_mm,
        stale=workspace.is_stale(),
        doubt=None if limb.doubt is None else FindingReply.of(limb.doubt),
        notes=_notes(app_state, limb),
    )


def _notes(app_state: AppState, limb: Limb) -> list[FindingReply]:
    return [FindingReply.of(one, app_state.shelf.root) for one in limb.notes]


def _changed_reply(app_state: AppState, workspace: Workspace) -> LimbReply:
    app_state.news.tell(workspace.case.case_id, "work")
    return limb_reply(app_state, workspace)


def _place(limb: Limb, mark: Landmark) -> Place:
    motion = limb.known_limb_from_mesh
    mesh = limb.mesh
    nearest = int(((mesh.vertices_mm - mark.position_mm) ** 2).sum(1).argmin())
    sigma = float("nan") if mesh.sigma_mm is None else float(mesh.sigma_mm[nearest])
    return Place(
        name=mark.name,
        position_mm=triple(mark.position_mm),
        in_limb_mm=None if motion is None else triple(motion.apply(mark.position_mm[None])[0]),
        within_mm=COVER * sigma if np.isfinite(sigma) else None,
    )


def _vector(values: Coordinates) -> Vector3:
    return np.array(values, np.float64)
