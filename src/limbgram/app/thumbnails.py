"""Thumbnails: one view of the limb, cut out of the report's picture, background transparent."""

import io
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

_SMALL_PX = 112
_VIEWS = (0.08, 0.94)
"""Shares of the picture's height between which the views lie; text is above and below."""
_BACKGROUND = 250
"""Least brightness of the background, in all three channels."""


@lru_cache(maxsize=256)
def thumbnail_of(picture: Path, _changed: int) -> bytes:
    """A PNG of one view, cut out of the report's picture of a surface.

    Args:
        _changed: When the picture was written: another one gives another thumbnail.
    """
    with Image.open(picture) as whole:
        pixels: np.ndarray = np.asarray(whole.convert("RGB"))
    view = pixels[int(_VIEWS[0] * len(pixels)) : int(_VIEWS[1] * len(pixels))]
    drawn = np.any(view < _BACKGROUND, axis=2)
    ends = np.flatnonzero(np.diff(np.pad(drawn.any(axis=0), 1).astype(np.int8)))
    runs = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > len(view) // 10]
    first, last = runs[0] if runs else (0, view.shape[1])
    rows = np.flatnonzero(drawn[:, first:last].any(axis=1))
    top, low = (rows[0], rows[-1] + 1) if len(rows) else (0, len(view))
    cut = np.dstack([view, np.where(drawn, 255, 0).astype(np.uint8)])[top:low, first:last]
    small = Image.fromarray(cut, "RGBA")
    small.thumbnail((_SMALL_PX, _SMALL_PX), Image.Resampling.BOX)
    made = io.BytesIO()
    small.save(made, "PNG")
    return made.getvalue()
