"""Carving: the shape as a carver takes it, and the proof that it carves it."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
