"""limbgram: a walk-round of photographs becomes a limb's surface in true millimetres.

The names of the library stand in `__init__.pyi`, once: type checkers read them there, and here each
is imported when it is first used, so that the command line starts without any of them.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
