"""Edits: the shape adjusted; each is a function that takes a Limb and its parameters."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
