"""Contact sheet: small pictures in rows on white, each with a caption below it."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from limbgram.core.geometry.arrays import ColourImage

_CAPTION_PX = 20
_GAP_PX = 4


@dataclass(frozen=True)
class CaptionedPicture:
    """One picture of a contact sheet."""

    caption: str
    pixels: ColourImage


def contact_sheet(pictures: Sequence[CaptionedPicture], columns: int) -> ColourImage:
    """All pictures in their order, row by row; there has to be one."""
    cell_height_px = max(one.pixels.shape[0] for one in pictures) + _CAPTION_PX
    cell_width_px = max(one.pixels.shape[1] for one in pictures) + _GAP_PX
    columns = min(columns, len(pictures))
    rows = -(-len(pictures) // columns)
    sheet = np.full((rows * cell_height_px, columns * cell_width_px, 3), 255, np.uint8)
    for idx, one in enumerate(pictures):
        top, left = idx // columns * cell_height_px, idx % columns * cell_width_px
        height_px, width_px = one.pixels.shape[:2]
        sheet[top : top + height_px, left : left + width_px] = one.pixels
        cv2.putText(
            sheet, one.caption, (left + 2, top + cell_height_px - 6), cv2.FONT_HERSHEY_SIMPLEX,
            0.45, (0, 0, 0), 1, cv2.LINE_AA,
        )  # fmt: skip
    return sheet
