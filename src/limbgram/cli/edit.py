"""`limbgram edit`: a recipe of edits made, changed, compared, and done to a scan."""

from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered, language, spoken
from limbgram.cli.shape_options import (
    ShapeArgument,
    UnitOption,
    require_apart,
    require_no_shape,
    shape_of,
)
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.files import other, require, toml_of, write_bytes
from limbgram.core.request_fields import Declared, declared, purpose_of
from limbgram.core.typed import tree_of, words_of_type
from limbgram.findings import note
from limbgram.formats.export_checks import as_kept
from limbgram.formats.limb_file import write_limb
from limbgram.workbench.edits.editing import EDIT_NAMED
from limbgram.workbench.recipe.file import encode_recipe, make_edit, read_recipe
from limbgram.workbench.recipe.ledger import lines_of
from limbgram.workbench.recipe.recipe import (
    Recipe,
    accepted,
    added,
    described_entry,
    differences,
    moved,
    removed,
    replay,
    require_scan,
    switched,
    undone,
)

_HELP = """Adjust a shape by a recipe: a readable file with an ordered list of edits.

The scan itself is never changed: `apply` does the recipe's edits to it and writes a new shape,
the same bytes each time. Every edit reports volume, girths and displacement.

1. `limbgram edit new first.toml --for scan.ply`
2. `limbgram edit add first.toml load at="patellar tendon" depth_mm=5 falloff_mm=18`
3. `limbgram edit add first.toml reduction "heights_mm=[30,200]" "per_cent=[0,4]" of=girth`
4. `limbgram edit apply scan.ply first.toml -o rectified.ply`

Change your mind by `undo`, `move`, `off`, `on` and `remove`, or in any text editor. `kinds` lists
the edits there are, `kinds NAME` the parameters of one.

The shape is a positive: **relieve** builds it up, outwards, and gives room; **load** carves it in,
inwards, and gives pressure. Places are landmarks by name, or [x,y,z] in mm in the limb's frame
(origin distal, +Z proximal, +Y anterior, +X the patient's right), or in the mesh's own with
positions_in=mesh. An edit that would fold the surface or push it through itself is refused. So is
a load on bone, on a nerve or on a tendon that bears none, and a depth above 10 mm, unless it is
said that it is meant: `--accept "load on fibula head"`, `--accept "depth to 12 mm"`, or later by
`accept`.
"""

edit_app = typer.Typer(help=_HELP, no_args_is_help=True, rich_markup_mode="markdown")

_NOTHING_DONE = note("recipe.nothing_done")

RecipeFile = Annotated[Path, typer.Argument(help="The recipe's file, TOML.")]
Number = Annotated[int, typer.Argument(help="Number of the edit, counted from 1.")]
Accept = Annotated[
    list[str] | None,
    typer.Option(
        "--accept",
        help='What is meant though it is unusual: "load on PLACE", "depth to N mm". Repeatable.',
    ),
]
Json = Annotated[bool, typer.Option("--json", help="The answer as one JSON document.")]


@answered
def apply_command(
    scan: ShapeArgument,
    recipe: RecipeFile,
    out: Annotated[Path, typer.Option("-o", "--out", help="Where the new shape is written.")],
    other_scan: Annotated[
        bool, typer.Option("--other-scan", help="Apply it though it was made for another scan.")
    ] = False,
    unit: UnitOption = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Apply a recipe to a scan: print the ledger and write the new shape."""
    require_apart(out, scan)
    made = read_recipe(recipe)
    read = shape_of(scan, unit)
    if not other_scan:
        require_scan(made, read.sha256, scan.name)
    replayed = replay(made, read.limb)
    limb = as_kept(replayed.limb, out)
    written = write_limb(limb, out)
    done = bool(replayed.ledger.lines)
    return Reply(
        (
            *(f"Note: {with_full_stop(spoken(one))}" for one in (*made.notes, *limb.notes)),
            *(lines_of(replayed.ledger, language()) if done else (spoken(_NOTHING_DONE),)),
            f"Written: {written}",
        ),
        {
            "recipe": made.name,
            "ledger": tree_of(replayed.ledger),
            "notes": tree_of((*made.notes, *limb.notes, *(() if done else (_NOTHING_DONE,)))),
            "written": str(written),
        },
    )


@answered
def new_command(
    recipe: RecipeFile,
    scan: Annotated[
        Path | None, typer.Option("--for", help="Scan that it is for; its file's hash is kept.")
    ] = None,
    name: Annotated[str, typer.Option(help="What it is called; no patient's name.")] = "",
    unit: UnitOption = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Begin a recipe without edits."""
    require_no_shape(recipe, "recipe")
    if recipe.exists():
        raise OptionsError("recipe.file.there", name=str(recipe))
    scan_hash = "" if scan is None else shape_of(scan, unit).sha256
    return _kept(recipe, Recipe(name=name or recipe.stem, scan_sha256=scan_hash))


@answered
def add_command(
    recipe: RecipeFile,
    kind: Annotated[str, typer.Argument(help="Name of the edit; `edit kinds` lists them.")],
    parameters: Annotated[
        list[str] | None,
        typer.Argument(
            help='name=value, values as in TOML; lists in brackets and quotes: "per_cent=[0,3]".'
        ),
    ] = None,
    number: Annotated[
        int | None, typer.Option("--as", help="Its number; without it the last.")
    ] = None,
    accept: Accept = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Add an edit to a recipe."""
    given = dict(_parameter(text) for text in parameters or ())
    edit = make_edit(kind, given, "The new edit")
    return _kept(recipe, added(read_recipe(recipe), edit, number, accept or ()))


@answered
def accept_command(
    recipe: RecipeFile,
    number: Number,
    words: Annotated[
        list[str], typer.Argument(help='"load on PLACE" or "depth to N mm", as the refusal says.')
    ],
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Say of an edit that it is meant: a load on a sensitive place, or a great depth."""
    return _kept(recipe, accepted(read_recipe(recipe), number, words))


@answered
def undo_command(
    recipe: RecipeFile,
    steps: Annotated[int, typer.Option(help="How many of the last edits are taken off.")] = 1,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Take the last edit off a recipe."""
    return _kept(recipe, undone(read_recipe(recipe), steps))


@answered
def remove_command(recipe: RecipeFile, number: Number, as_json: Json = False) -> Reply:  # noqa: ARG001
    """Take one edit out of a recipe."""
    return _kept(recipe, removed(read_recipe(recipe), number))


@answered
def move_command(
    recipe: RecipeFile,
    number: Number,
    to: Annotated[int, typer.Argument(help="Number that it has afterwards.")],
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Give an edit another place in the order."""
    return _kept(recipe, moved(read_recipe(recipe), number, to))


@answered
def off_command(recipe: RecipeFile, number: Number, as_json: Json = False) -> Reply:  # noqa: ARG001
    """Switch an edit off; it stays in the recipe."""
    return _kept(recipe, switched(read_recipe(recipe), number, on=False))


@answered
def on_command(recipe: RecipeFile, number: Number, as_json: Json = False) -> Reply:  # noqa: ARG001
    """Switch an edit on again."""
    return _kept(recipe, switched(read_recipe(recipe), number, on=True))


@answered
def show_command(recipe: RecipeFile, as_json: Json = False) -> Reply:  # noqa: ARG001
    """List a recipe's edits."""
    return _recipe_reply(read_recipe(recipe))


@answered
def diff_command(
    old: Annotated[Path, typer.Argument(help="A recipe.")],
    new: Annotated[Path, typer.Argument(help="Another one.")],
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Say what changed from one recipe to another."""
    recipes = read_recipe(old), read_recipe(new)
    lines = differences(*recipes)
    notes = tuple(
        f"Note: {with_full_stop(spoken(one))}" for recipe in recipes for one in recipe.notes
    )
    return Reply(
        (*notes, *(lines or ("The recipes do the same.",))),
        {
            "changes": list(lines),
            "notes": tree_of([one for recipe in recipes for one in recipe.notes]),
        },
    )


@answered
def kinds_command(
    kind: Annotated[str | None, typer.Argument(help="One edit; without it all.")] = None,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """List the edits there are, or the parameters of one."""
    if kind is not None and kind not in EDIT_NAMED:
        raise OptionsError("recipe.edit.unknown", kind=kind, known=tuple(EDIT_NAMED))
    chosen = EDIT_NAMED if kind is None else {kind: EDIT_NAMED[kind]}
    lines: list[str] = []
    content: dict[str, Any] = {}
    for name, made in chosen.items():
        does = purpose_of(made)
        parameters = {
            one.name: f"{_expected(one)}. {one.meaning}".rstrip() for one in declared(made)
        }
        limbs = [one for one in made.about.kinds if one is not None]
        content[name] = {"does": does, "limbs": limbs, "parameters": parameters}
        if kind is None:
            lines.append(f"{name}: {does}")
        else:
            lines.append(f"{does} For: {', '.join(limbs)}." if limbs else does)
            lines += [f"  {key}: {expected}" for key, expected in parameters.items()]
    return Reply(tuple(lines), content)


def _expected(one: Declared) -> str:
    """What may be given: "a number above 0 and up to 20 mm, else 0.3"."""
    expected = words_of_type(one.hint)
    if one.within is not None:
        how = "above {0:g} and up to {1:g}" if one.within.above else "from {0:g} to {1:g}"
        expected += f"{', each' * one.several} {how.format(one.within.least, one.within.most)}"
    if one.unit:
        expected += f"{', in' * (one.within is None)} {one.unit}"
    usual = "" if one.required or one.default in (None, "", ()) else f", else {one.default}"
    return f"{expected}{usual}"


def _kept(path: Path, recipe: Recipe) -> Reply:
    """Write a recipe's file and list its edits."""

    def check(written: Path) -> None:
        require(read_recipe(written) == recipe, other(path.name, "recipe"))

    write_bytes(path, encode_recipe(recipe), check)
    return _recipe_reply(recipe)


def _recipe_reply(recipe: Recipe) -> Reply:
    listed = [described_entry(entry) for entry in recipe.entries]
    lines = [f"Note: {with_full_stop(spoken(one))}" for one in recipe.notes]
    lines.append(f'Recipe "{recipe.name}", {len(listed)} {"edit" if len(listed) == 1 else "edits"}')
    lines += [f"  {number}. {text}" for number, text in enumerate(listed, start=1)]
    entries = [
        {"edit": text, "on": entry.on, "accept": list(entry.accept)}
        for text, entry in zip(listed, recipe.entries, strict=True)
    ]
    return Reply(
        tuple(lines), {"name": recipe.name, "edits": entries, "notes": tree_of(recipe.notes)}
    )


def _parameter(text: str) -> tuple[str, Any]:
    """A name and its value; what is no TOML value is a text without its quotes."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise OptionsError("recipe.parameter.form", text=text)
    try:
        return name, toml_of(f"value = {value}")["value"]
    except ValueError as error:
        if value[:1] in ("[", '"', "'", "{"):
            raise OptionsError(
                "recipe.parameter.unreadable", text=text, reason=str(error)
            ) from error
        return name, value


for _name, _command in {
    "apply": apply_command,
    "new": new_command,
    "add": add_command,
    "accept": accept_command,
    "undo": undo_command,
    "remove": remove_command,
    "move": move_command,
    "off": off_command,
    "on": on_command,
    "show": show_command,
    "diff": diff_command,
    "kinds": kinds_command,
}.items():
    edit_app.command(_name)(_command)
