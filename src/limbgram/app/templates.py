"""Templates: what the clinic did to several limbs, learned and kept, to be done to the next one."""

from pathlib import Path as FilePath
from typing import Annotated

from fastapi import APIRouter, Body, Path, Request, Response
from pydantic import BaseModel, Field

from limbgram.app.forms import RequestBody
from limbgram.app.replies import PICTURE, FindingReply
from limbgram.app.state import AppState, AppStateHere, other_case
from limbgram.app.surface import limb_of
from limbgram.cases.shelf_ids import ID_PATTERN
from limbgram.cases.templates import KeptTemplate, Templates
from limbgram.cases.workspace import Workspace
from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.report.drawings.drawing import png
from limbgram.report.drawings.time_course import unrolled_template
from limbgram.workbench.templates.learning import Pair
from limbgram.workbench.templates.template import moves_at_marks

router = APIRouter(tags=["templates"])

TemplateId = Annotated[str, Path(pattern=ID_PATTERN, description="Id of the template.")]


class Move(BaseModel):
    """How far a template moves the surface at a place."""

    place: str
    moved_mm: float = Field(description="Positive outward: room.")


class TemplateReply(BaseModel):
    """A template that the clinic keeps."""

    id: str
    name: str
    pairs: int = Field(description="Cases that it was learned from.")
    sided: bool = Field(description="Learned on limbs of a stated side; fits left and right.")
    reference: str = Field(description="Place from which heights count.")
    most_inward_mm: float
    most_outward_mm: float
    changed_share: float
    places: list[Move]
    finding: FindingReply | None = Field(
        default=None, description="Why its file cannot be read, and nothing else is known of it."
    )


class NewTemplate(RequestBody):
    """What a template is learned from."""

    name: str = Field(min_length=1, max_length=80)
    cases: list[str] = Field(
        min_length=1, max_length=50, description="Ids of cases that are aligned and rectified."
    )


class LearnedReply(BaseModel):
    """The templates after one was learned, and how far to trust it."""

    templates: list[TemplateReply]
    notes: list[FindingReply]


@router.get("/templates")
def list_templates(app_state: AppStateHere) -> list[TemplateReply]:
    """The templates that the clinic keeps."""
    return [_reply(one, app_state.shelf.root) for one in _templates(app_state).all()]


@router.post("/templates", status_code=201)
def learn_template(app_state: AppStateHere, given: NewTemplate, request: Request) -> LearnedReply:
    """Learn what was done to the limbs of some cases: from each one's scan to its shape now."""
    pairs = [_pair(app_state, request, one) for one in dict.fromkeys(given.cases)]
    learned = _templates(app_state).learn(given.name, pairs)
    notes = [FindingReply.of(one, app_state.shelf.root) for one in learned.notes]
    return LearnedReply(templates=list_templates(app_state), notes=notes)


@router.put("/templates/file")
def take_template_file(
    app_state: AppStateHere,
    content: Annotated[bytes, Body(media_type="application/octet-stream", max_length=2_000_000)],
) -> list[TemplateReply]:
    """Take a template's file that `limbgram template learn` wrote."""
    _templates(app_state).take(content)
    return list_templates(app_state)


@router.get("/templates/{template_id}/file", response_class=Response)
def read_template_file(app_state: AppStateHere, template_id: TemplateId) -> Response:
    """The template's file: the parameter `learned` of the edit `from-template`."""
    return Response(
        _templates(app_state).template(template_id).file.read_bytes(), media_type="application/json"
    )


@router.get("/templates/{template_id}/picture", response_class=Response, responses=PICTURE)
def read_template_picture(app_state: AppStateHere, template_id: TemplateId) -> Response:
    """What it does, on the limb unrolled."""
    drawn = png(unrolled_template(_templates(app_state).template(template_id).read()).figure)
    return Response(drawn.tobytes(), media_type="image/png")


@router.delete("/templates/{template_id}", status_code=204)
def delete_template(app_state: AppStateHere, template_id: TemplateId) -> None:
    """Delete a template; recipes keep what they took of it."""
    _templates(app_state).remove(_templates(app_state).template(template_id))


def _templates(app_state: AppState) -> Templates:
    return Templates(app_state.shelf.templates)


def _pair(app_state: AppState, request: Request, case_id: str) -> Pair:
    workspace = Workspace(other_case(app_state, request, case_id))
    if not workspace.recipe().entries:
        raise OptionsError("template.nothing_to_learn", case=case_id)
    return Pair(
        before=limb_of(app_state, workspace, "scan")[0],
        after=limb_of(app_state, workspace, "rectified")[0],
    )


def _reply(kept: KeptTemplate, root: FilePath) -> TemplateReply:
    try:
        template = kept.read()
    except ShapeFileError as error:  # the others are still to be had, and this one deleted
        return TemplateReply(
            id=kept.template_id,
            name=kept.file.name,
            pairs=0,
            sided=False,
            reference="",
            most_inward_mm=0.0,
            most_outward_mm=0.0,
            changed_share=0.0,
            places=[],
            finding=FindingReply.of(error.finding, root),
        )
    moved = template.displacement_mm
    return TemplateReply(
        id=kept.template_id,
        name=template.name,
        pairs=template.pairs,
        sided=template.sided,
        reference=template.reference,
        most_inward_mm=float(min(moved.min(), 0.0)),
        most_outward_mm=float(max(moved.max(), 0.0)),
        changed_share=float((moved != 0).mean()),
        places=[
            Move(place=name, moved_mm=moved_mm)
            for name, moved_mm in moves_at_marks(template).items()
        ],
    )
