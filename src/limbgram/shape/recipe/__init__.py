"""Recipe: edits as a readable file, replayed on a scan."""

from limbgram.shape.recipe.accepting import Concern
from limbgram.shape.recipe.file import encode_recipe, make_edit, parse_recipe, read_recipe
from limbgram.shape.recipe.ledger import Ledger, Line, lines_of
from limbgram.shape.recipe.recipe import (
    Entry,
    Recipe,
    accepted,
    added,
    described,
    differences,
    moved,
    removed,
    switched,
    undone,
)
from limbgram.shape.recipe.replay import Replayed, replay, replay_as_it_is, require_scan

__all__ = [
    "Concern",
    "Entry",
    "Ledger",
    "Line",
    "Recipe",
    "Replayed",
    "accepted",
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
    "replay_as_it_is",
    "require_scan",
    "switched",
    "undone",
]
