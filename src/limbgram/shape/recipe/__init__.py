"""Recipe: edits as a readable file, replayed on a scan."""

from limbgram.shape.recipe.file import encode_recipe, make_edit, parse_recipe, read_recipe
from limbgram.shape.recipe.ledger import Ledger, Line, lines_of
from limbgram.shape.recipe.recipe import (
    Entry,
    Recipe,
    added,
    described,
    differences,
    moved,
    removed,
    switched,
    undone,
)
from limbgram.shape.recipe.replay import Replayed, replay, require_scan

__all__ = [
    "Entry",
    "Ledger",
    "Line",
    "Recipe",
    "Replayed",
    "added",
    "described",
    "differences",
    "encode_recipe",
    "lines_of",
    "make_edit",
    "moved",
    "parse_recipe",
    "read_recipe",
    "removed",
    "replay",
    "require_scan",
    "switched",
    "undone",
]
