"""Targets: boards and coded marks of known size, and where they appear in photos.

In      a PhotoSet, and the Board that lies in the scene or was photographed for calibration; or
        the dictionary of the marks on bars, mats and stickers.
Out     BoardDetections, MarkDetections: sub-pixel corners with their ids, photo by photo.
"""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
