"""Edits: the shape adjusted; each is a function that takes a Limb and its parameters."""

from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDIT_NAMED, EDITS, do_edit
from limbgram.workbench.edits.offset import offset

__all__ = ["EDITS", "EDIT_NAMED", "Edit", "do_edit", "name_of", "offset"]
