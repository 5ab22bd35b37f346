"""Recipe: edits as a readable file, replayed on a scan."""

from limbgram.workbench.recipe.consent import Concern
from limbgram.workbench.recipe.file import encode_recipe, make_edit, parse_recipe, read_recipe
from limbgram.workbench.recipe.ledger import Ledger, Line, lines_of
from limbgram.workbench.recipe.recipe import (
    Entry,
    Recipe,
    Replayed,
    accepted,
    added,
    described_entry,
    differences,
    moved,
    removed,
    replay,
    replay_as_it_is,
    require_scan,
    switched,
    undone,
)

__all__ = [
    "Concern",
    "Entry",
    "Ledger",
    "Line",
    "Recipe",
    "Replayed",
    "accepted",
    "added",
    "described_entry",
    "differences",
    "encode_recipe",
    "lines_of",
    "make_edit",
    "moved",
    "parse_recipe",
    "read_recipe",
    "removed",
    "replay",
    "replay_as_it_is",
    "require_scan",
    "switched",
    "undone",
]
