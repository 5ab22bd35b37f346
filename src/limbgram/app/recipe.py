"""Recipe: the edits in order, which are the list of what can be undone; previews and the ledger."""

import hashlib
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, cast

from fastapi import APIRouter, Depends, Header, Path, Query, Response
from pydantic import BaseModel, Field

from limbgram.app.binary_arrays import change_blocks, surface_blocks
from limbgram.app.forms import FieldReply, RequestBody
from limbgram.app.idempotency import ACT_ID
from limbgram.app.replies import BINARY, FindingReply
from limbgram.app.shape_cache import OpenShape
from limbgram.app.state import AppState, AppStateHere, WorkspaceHere
from limbgram.app.surface import tag_of
from limbgram.cases.case_export import unreadable_exports
from limbgram.cases.workspace import Workspace
from limbgram.core.errors import CaseError, LimbgramError, OptionsError
from limbgram.core.mesh.topology import is_watertight
from limbgram.core.request_fields import declared, purpose_of
from limbgram.core.typed import tree_of
from limbgram.findings import LANGUAGES, note
from limbgram.workbench.edits.edit import GROUP_NAMES, Edit, Words, name_of, words_in
from limbgram.workbench.edits.editing import EDIT_NAMED
from limbgram.workbench.limb import KindName
from limbgram.workbench.recipe.consent import plain_words
from limbgram.workbench.recipe.file import encode_recipe, make_edit, parse_recipe
from limbgram.workbench.recipe.ledger import (
    Displacement,
    Extreme,
    Figures,
    Ledger,
    Line,
    VolumeChange,
)
from limbgram.workbench.recipe.recipe import (
    Entry,
    Recipe,
    Replayed,
    accepted,
    added,
    described_entry,
    distinctive_parameters,
    moved,
    removed,
    require_scan,
    switched,
)

router = APIRouter(tags=["recipe"])

Number = Annotated[int, Path(ge=1, le=1000, description="Of the edit, from 1.")]
Parameters = dict[str, Any]


@dataclass(frozen=True)
class Gesture:
    """The id of an act that changes the recipe, and the mark of the recipe that it changes."""

    act: str | None
    seen: str | None


def _gesture(
    act_id: Annotated[
        str | None, Header(pattern=ACT_ID, description="Of this act: the same id twice is once.")
    ] = None,
    seen: Annotated[
        str | None,
        Query(
            max_length=64,
            description="Of the recipe that it changes: its mark, or the id of the act that made "
            "it. Where the recipe is another one by now, the act is refused.",
        ),
    ] = None,
) -> Gesture:
    return Gesture(act_id, seen)


GestureHere = Annotated[Gesture, Depends(_gesture)]


class EditWords(BaseModel):
    """What people read of a kind of edit, in one language."""

    name: str
    group: str
    does: str
    labels: dict[str, str] = Field(description="What its parameters are called.")
    help: dict[str, str] = Field(description="What they mean.")
    choices: dict[str, str] = Field(description="What words to choose from are called.")

    @classmethod
    def of(cls, words: Words, group: str) -> "EditWords":
        return cls(
            name=words.name,
            group=group,
            does=words.does,
            labels=dict(words.labels),
            help=dict(words.help),
            choices=dict(words.choices),
        )


class EditKind(BaseModel):
    """A kind of edit that there is."""

    kind: str
    group: str
    everyday: bool = Field(description="For everybody, not for experts alone.")
    does: str
    parameters: list[FieldReply]
    rarely: list[str] = Field(description="Parameters that experts alone are asked for.")
    kinds: list[KindName | None] = Field(
        description="Kinds of limb that it is for, null for one that nobody said; empty: for all."
    )
    words: dict[str, EditWords] = Field(description="By language.")


class EditReply(BaseModel):
    """One edit of the recipe."""

    number: int
    kind: str
    on: bool
    accept: list[str]
    parameters: Parameters
    telling: list[str] = Field(
        description="Names of the parameters that differ from their defaults, or of all."
    )
    text: str = Field(description="In one line.")


class RecipeReply(BaseModel):
    """The recipe, and what undo and redo can do."""

    name: str
    edits: list[EditReply]
    can_undo: bool
    can_redo: bool
    fits: bool = Field(description="Whether it was made for the surface that is worked on.")
    tag: str = Field(description="Of the shape after it: `surface?of=rectified` has the same.")
    mark: str = Field(description="Another one whenever the recipe changes.")
    act: str | None = Field(description="Id of the act that made it, where that is known.")
    notes: list[FindingReply]


class ConcernReply(BaseModel):
    """What somebody has to mean, or to know, of an edit."""

    finding: FindingReply
    word: str = Field(description="What accepts it; empty where nothing needs to be said.")
    accepted: bool


class LineReply(BaseModel):
    """What one edit did."""

    number: int
    edit: str = Field(description="In one line.")
    before: Figures
    after: Figures
    volume: VolumeChange | None
    extreme: Extreme | None
    displacement: Displacement | None
    told: list[FindingReply]
    concerns: list[ConcernReply]


class LedgerReply(BaseModel):
    """What a recipe did."""

    levels_mm: list[float] = Field(description="Heights of the girths.")
    lines: list[LineReply]
    volume: VolumeChange | None = Field(description="Of all edits together.")
    places_mm: dict[str, float] = Field(
        description="How far all edits moved the surface at each sensitive place, outward "
        "positive: where they press within its reach the deepest place, else its landmark."
    )


class Ledgered(BaseModel):
    """The recipe and what each edit did; or why one is refused."""

    recipe: RecipeReply
    ledger: LedgerReply | None = None
    solid: bool | None = Field(
        default=None,
        description="Whether the shape after it is closed all round, as printers need.",
    )
    refusal: FindingReply | None = Field(
        default=None, description="Why the recipe cannot be done; null where it can."
    )


class NewEdit(RequestBody):
    """An edit to add or to try."""

    kind: str = Field(max_length=40)
    parameters: Parameters = Field(max_length=30)
    accept: list[str] = Field(
        default=[], max_length=20, description="What is meant though unusual."
    )
    number: int | None = Field(
        default=None, ge=1, le=1000, description="Its place; null: the last."
    )


class EditChange(RequestBody):
    """What is to be otherwise of an edit; what is left out stays."""

    on: bool | None = None
    parameters: Parameters | None = Field(default=None, max_length=30, description="All of them.")
    accept: list[str] | None = Field(default=None, max_length=20)
    number: int | None = Field(default=None, ge=1, le=1000, description="Its new place.")


class RecipeText(RequestBody):
    """A recipe's file."""

    toml: str = Field(max_length=4_000_000)


@router.get("/edits")
def list_kinds() -> list[EditKind]:
    """The kinds of edits there are, and their parameters."""
    return list(_kinds())


@cache
def _kinds() -> tuple[EditKind, ...]:
    """Cached, because they take 0.1 s to build."""
    return tuple(
        EditKind(
            kind=kind,
            group=made.about.group,
            everyday=made.about.everyday,
            does=purpose_of(made),
            parameters=[FieldReply.of(one) for one in declared(made)],
            rarely=list(made.about.rarely),
            kinds=list(made.about.kinds),
            words={
                spoken: EditWords.of(words_in(made, spoken), GROUP_NAMES[spoken][made.about.group])
                for spoken in LANGUAGES
            },
        )
        for kind, made in EDIT_NAMED.items()
    )


@router.get("/cases/{case_id}/recipe")
def read_recipe(app_state: AppStateHere, workspace: WorkspaceHere) -> RecipeReply:
    """The recipe."""
    with app_state.shape_cache.changing(workspace):
        return recipe_reply(app_state, workspace)


@router.get("/cases/{case_id}/recipe/ledger")
def read_ledger(app_state: AppStateHere, workspace: WorkspaceHere) -> Ledgered:
    """What each edit did to volume, girths and surface."""
    with app_state.shape_cache.changing(workspace):
        return _ledgered(app_state, workspace)


@router.get("/cases/{case_id}/recipe/file", response_class=Response)
def read_recipe_file(workspace: WorkspaceHere) -> Response:
    """The recipe as a file for `limbgram edit apply`."""
    return Response(encode_recipe(workspace.recipe()), media_type="application/toml")


@router.put("/cases/{case_id}/recipe/file")
def put_recipe_file(
    app_state: AppStateHere, workspace: WorkspaceHere, gesture: GestureHere, given: RecipeText
) -> Ledgered:
    """Put another recipe in its place; undo goes back."""
    made = parse_recipe(given.toml, "The recipe")
    require_scan(
        made, app_state.shape_cache.shape(workspace).file.sha256, "the surface of this case"
    )
    with app_state.shape_cache.changing(workspace):
        _current_recipe(app_state, workspace, gesture)
        return _save(app_state, workspace, made, gesture)


@router.post("/cases/{case_id}/recipe/edits", status_code=201)
def add_edit(
    app_state: AppStateHere, workspace: WorkspaceHere, gesture: GestureHere, given: NewEdit
) -> Ledgered:
    """Add an edit to the recipe; the answer is the ledger, `recipe/change` brings the shape."""
    edit = make_edit(given.kind, _frozen(given.parameters), "The new edit")
    with app_state.shape_cache.changing(workspace):
        recipe = _current_recipe(app_state, workspace, gesture)
        return _save(app_state, workspace, added(recipe, edit, given.number, given.accept), gesture)


@router.patch("/cases/{case_id}/recipe/edits/{number}")
def change_edit(
    app_state: AppStateHere,
    workspace: WorkspaceHere,
    gesture: GestureHere,
    number: Number,
    given: EditChange,
) -> Ledgered:
    """Change an edit: switch it, change its numbers, accept what it does, or move it."""
    with app_state.shape_cache.changing(workspace):
        recipe = _current_recipe(app_state, workspace, gesture)
        if given.on is not None:
            recipe = switched(recipe, number, on=given.on)
        if given.parameters is not None:
            recipe = _with_parameters(recipe, number, given.parameters)
        if given.accept is not None:
            recipe = accepted(recipe, number, given.accept)
        if given.number is not None:
            recipe = moved(recipe, number, given.number)
        return _save(app_state, workspace, recipe, gesture)


@router.delete("/cases/{case_id}/recipe/edits/{number}")
def delete_edit(
    app_state: AppStateHere, workspace: WorkspaceHere, gesture: GestureHere, number: Number
) -> Ledgered:
    """Take an edit out of the recipe."""
    with app_state.shape_cache.changing(workspace):
        recipe = _current_recipe(app_state, workspace, gesture)
        return _save(app_state, workspace, removed(recipe, number), gesture)


@router.post("/cases/{case_id}/recipe/undo")
def undo(app_state: AppStateHere, workspace: WorkspaceHere, gesture: GestureHere) -> Ledgered:
    """Undo the last gesture, whatever it was: an edit, a switch, a number, an order."""
    with app_state.shape_cache.changing(workspace):
        _current_recipe(app_state, workspace, gesture)
        _announce(app_state, workspace, workspace.step(-1), gesture)
        return _ledgered(app_state, workspace)


@router.post("/cases/{case_id}/recipe/redo")
def redo(app_state: AppStateHere, workspace: WorkspaceHere, gesture: GestureHere) -> Ledgered:
    """Do again what was undone last."""
    with app_state.shape_cache.changing(workspace):
        _current_recipe(app_state, workspace, gesture)
        _announce(app_state, workspace, workspace.step(1), gesture)
        return _ledgered(app_state, workspace)


@router.post("/cases/{case_id}/recipe/preview", response_class=Response, responses=BINARY)
def preview(app_state: AppStateHere, workspace: WorkspaceHere, given: NewEdit) -> Response:
    """The shape with one more edit at the recipe's end, which is not kept: blocks of a change.

    The change is from `surface?of=rectified` as it is now; its header has the edit's ledger line.
    Where more than half of the surface changes, the whole surface comes.
    """
    shape = app_state.shape_cache.shape(workspace)
    recipe = workspace.recipe()
    edit = make_edit(given.kind, _frozen(given.parameters), "The edit")
    words = plain_words(given.accept, "The edit")
    tried = replace(recipe, entries=(*recipe.entries, Entry(edit=edit, accept=words)))
    return _change(shape, recipe, tried)


@router.get("/cases/{case_id}/recipe/change", response_class=Response, responses=BINARY)
def read_change(app_state: AppStateHere, workspace: WorkspaceHere) -> Response:
    """From the shape before the last gesture to the shape now, as blocks of a change.

    Header: from_tag and tag. Where the client has another shape than from_tag it fetches the whole.
    """
    with app_state.shape_cache.changing(workspace):
        shape, recipe, history = (
            app_state.shape_cache.shape(workspace),
            workspace.recipe(),
            workspace.history(),
        )
    before = history.recipes[max(0, history.present - 1)]
    return _change(shape, parse_recipe(before, "The recipe before"), recipe)


def recipe_reply(app_state: AppState, workspace: Workspace) -> RecipeReply:
    shape, recipe, history = (
        app_state.shape_cache.shape(workspace),
        workspace.recipe(),
        workspace.history(),
    )
    mark = _mark(recipe)
    act, made = app_state.shape_cache.made.get(workspace.root, (None, ""))
    return RecipeReply(
        name=recipe.name,
        edits=[
            EditReply(
                number=number,
                kind=name_of(type(entry.edit)),
                on=entry.on,
                accept=list(entry.accept),
                parameters=_parameters(entry.edit),
                telling=list(distinctive_parameters(entry.edit)),
                text=described_entry(entry),
            )
            for number, entry in enumerate(recipe.entries, 1)
        ],
        can_undo=history.can_undo,
        can_redo=history.can_redo,
        fits=not recipe.scan_sha256 or recipe.scan_sha256 == shape.file.sha256,
        tag=tag_of(shape.file.sha256, shape.limb, recipe),
        mark=mark,
        act=act if made == mark else None,
        notes=[
            FindingReply.of(one, app_state.shelf.root)
            for one in (
                *recipe.notes,
                *(note("said.as_is", message=text) for text in workspace.notes()),
                *unreadable_exports(workspace),
            )
        ],
    )


def _current_recipe(app_state: AppState, workspace: Workspace, gesture: Gesture) -> Recipe:
    """The recipe, if it is still the one that the client changes.

    Edits have numbers: in a recipe that was changed meanwhile a number may mean another edit.

    Raises:
        CaseError: the recipe was changed meanwhile.
    """
    recipe = workspace.recipe()
    mark = _mark(recipe)
    if gesture.seen not in (None, mark) and app_state.shape_cache.made.get(workspace.root) != (
        gesture.seen,
        mark,
    ):
        raise CaseError("recipe.changed")
    return recipe


def _save(app_state: AppState, workspace: Workspace, recipe: Recipe, gesture: Gesture) -> Ledgered:
    """Save a recipe after replaying it; a refused one changes nothing.

    The caller holds the case's lock since it read the recipe before.
    """
    shape = app_state.shape_cache.shape(workspace)
    done = shape.replayed(recipe)
    workspace.save_recipe(recipe)
    _announce(app_state, workspace, recipe, gesture)
    return _with_ledger(recipe_reply(app_state, workspace), done)


def _announce(app_state: AppState, workspace: Workspace, recipe: Recipe, gesture: Gesture) -> None:
    """Notify other clients, and remember the act that made this recipe."""
    app_state.shape_cache.made[workspace.root] = (gesture.act, _mark(recipe))
    app_state.news.tell(workspace.case.case_id, "work")


def _mark(recipe: Recipe) -> str:
    return hashlib.sha256(encode_recipe(recipe)).hexdigest()[:24]


def _ledgered(app_state: AppState, workspace: Workspace) -> Ledgered:
    """The saved recipe with its ledger; or with a refusal, if landmarks have moved since."""
    shape, reply = app_state.shape_cache.shape(workspace), recipe_reply(app_state, workspace)
    try:
        done = shape.replayed(workspace.recipe())
    except LimbgramError as error:
        root = app_state.shelf.root
        return Ledgered(recipe=reply, refusal=FindingReply.of(error.finding, root))
    return _with_ledger(reply, done)


def _with_ledger(reply: RecipeReply, done: Replayed) -> Ledgered:
    solid = is_watertight(done.limb.mesh.faces)
    return Ledgered(recipe=reply, ledger=_ledger(done.ledger), solid=solid)


def _ledger(ledger: Ledger) -> LedgerReply:
    return LedgerReply(
        levels_mm=list(ledger.levels_mm),
        lines=[_line(line) for line in ledger.lines],
        volume=ledger.volume,
        places_mm=dict(ledger.places_mm),
    )


def _line(line: Line) -> LineReply:
    return LineReply(
        number=line.number,
        edit=line.edit,
        before=line.before,
        after=line.after,
        volume=line.volume,
        extreme=line.extreme,
        displacement=line.displacement,
        told=[FindingReply.of(one) for one in line.told],
        concerns=[
            ConcernReply(finding=FindingReply.of(one.finding), word=one.word, accepted=one.accepted)
            for one in line.concerns
        ],
    )


def _change(shape: OpenShape, before: Recipe, after: Recipe) -> Response:
    old, new = shape.replayed(before), shape.replayed(after)
    line: Line | None = new.ledger.lines[-1] if new.ledger.lines else None
    header = {
        "from_tag": tag_of(shape.file.sha256, shape.limb, before),
        "tag": tag_of(shape.file.sha256, shape.limb, after),
        "levels_mm": list(new.ledger.levels_mm),
        "line": None if line is None else _line(line).model_dump(mode="json"),
    }
    content = change_blocks(old.limb.mesh, new.limb.mesh, header) or surface_blocks(
        new.limb.mesh, header
    )
    return Response(content, media_type="application/octet-stream")


def _with_parameters(recipe: Recipe, number: int, parameters: Parameters) -> Recipe:
    if number > len(recipe.entries):
        raise OptionsError("recipe.number.none", edits=len(recipe.entries), number=number)
    entry = recipe.entries[number - 1]
    edit = make_edit(name_of(type(entry.edit)), _frozen(parameters), f"Edit {number}")
    entries = list(recipe.entries)
    entries[number - 1] = replace(entry, edit=edit)
    return replace(recipe, entries=tuple(entries))


def _frozen(parameters: Parameters) -> Parameters:
    """The parameters without nulls, which leave the default."""
    return {name: value for name, value in parameters.items() if value is not None}


def _parameters(edit: Edit) -> Parameters:
    return cast(Parameters, tree_of(edit))
