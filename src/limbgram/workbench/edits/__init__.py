"""Edits: the shape adjusted; each is a function that takes a Limb and its parameters."""

from limbgram.workbench.edits.editing import EDITS, Edit, do_edit, name_of
from limbgram.workbench.edits.offset import offset

__all__ = ["EDITS", "Edit", "do_edit", "name_of", "offset"]
