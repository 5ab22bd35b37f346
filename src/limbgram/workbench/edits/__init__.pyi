"""Edits: its names, each imported when it is first used."""

from .edit import Edit, name_of
from .editing import EDIT_NAMED, EDITS, do_edit

__all__ = ["EDITS", "EDIT_NAMED", "Edit", "do_edit", "name_of"]
