"""Accuracy: what a finished case knows of its own error, judged, with what limits it.

In      Evidence: products of a case; and its truth where there is one.
Out     a JSON tree, one HTML page without scripts, a PDF of two pages.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
