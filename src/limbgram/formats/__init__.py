"""Formats: shapes in and out of files, in millimetres.

Each format has one file, its reader and its writer together. A reader refuses what it cannot be
sure of; a writer reads its file back and compares it before the file takes its name.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
