"""Plates on the table beside the limb: scale bars and mats with coded marks, of exact size."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64, UInt8

from limbgram.core.geometry.arrays import Vector3
from limbgram.reconstruction.targets.board import marker_dictionary
from limbgram.reconstruction.targets.plates import MarkPlate
from limbgram.synthetic.props.room import Panel

PLATE_HEIGHT_MM = 1.5
_MARGIN = 0.2
"""White border round the outermost marks, in sides of a mark."""
_TEXEL_MM = 0.1
_SMOOTH_MM = 0.15
"""Blur of the print, as a textured panel has one sample a pixel."""
_FROM_LIMB_MM = 125.0
_APART_RAD = 0.8
_BLACK, _WHITE = 52, 226


@dataclass(frozen=True)
class LaidPlate:
    """A plate on the table."""

    panel: Panel
    middles_mm: dict[int, Vector3]
    """Centre of each mark in the world, by its id."""


def lay_plates(plates: Sequence[MarkPlate], away_from: Vector3) -> tuple[LaidPlate, ...]:
    """Lay plates round the limb, on the side opposite to `away_from`."""
    free = np.arctan2(-away_from[1], -away_from[0])
    spread = _APART_RAD * (np.arange(len(plates)) - 0.5 * (len(plates) - 1))
    return tuple(_laid(plate, free + turn) for plate, turn in zip(plates, spread, strict=True))


def _laid(plate: MarkPlate, toward: float) -> LaidPlate:
    places = np.array([(one.x_mm, one.y_mm) for one in plate.marks])
    margin = (0.5 + _MARGIN) * plate.side_mm
    size = np.ptp(places, axis=0) + 2 * margin
    on_plate = places - places.min(0) + margin
    right = np.array([-np.sin(toward), np.cos(toward), 0.0])
    down = np.array([right[1], -right[0], 0.0])
    middle = (_FROM_LIMB_MM + size[1] / 2) * np.array([np.cos(toward), np.sin(toward), 0.0])
    origin = middle - size[0] / 2 * right - size[1] / 2 * down
    origin = origin + np.array([0.0, 0.0, PLATE_HEIGHT_MM])
    in_world = origin + on_plate[:, :1] * right + on_plate[:, 1:] * down
    ids = [one.mark_id for one in plate.marks]
    return LaidPlate(
        Panel(origin, right, down, size, _picture(plate, on_plate, size)),
        dict(zip(ids, in_world, strict=True)),
    )


def _picture(
    plate: MarkPlate, places_mm: Float64[np.ndarray, "n 2"], size_mm: Float64[np.ndarray, "2"]
) -> UInt8[np.ndarray, "h w 3"]:
    """The print, as a texture that is blurred by `_SMOOTH_MM`."""
    codes = marker_dictionary(plate.dictionary)
    cells = codes.markerSize + 2
    wide, high = np.rint(size_mm / _TEXEL_MM).astype(int).tolist()
    texel = size_mm / (wide, high)
    picture = np.full((high, wide), _WHITE, np.float32)
    for mark, place in zip(plate.marks, places_mm, strict=True):
        pattern = np.asarray(codes.generateImageMarker(mark.mark_id, cells), np.float32)
        tones = np.where(pattern > 0, _WHITE, _BLACK).astype(np.float32)
        tones = np.pad(tones, 1, constant_values=_WHITE)
        cell = plate.side_mm / cells
        start = np.append(place - plate.side_mm / 2 - cell, 0.0)
        scale = texel / cell
        # From texel indices to cell indices, whose centres are integers; cell 0 is the padding.
        cell_from_texel = np.array(
            [
                [scale[0], 0.0, (0.5 * texel[0] - start[0]) / cell - 0.5],
                [0.0, scale[1], (0.5 * texel[1] - start[1]) / cell - 0.5],
            ]
        )
        drawn = cv2.warpAffine(
            tones,
            cell_from_texel,
            (wide, high),
            flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(float(_WHITE),),
        )
        picture = np.minimum(picture, drawn)
    grey = cv2.GaussianBlur(picture, (0, 0), _SMOOTH_MM / _TEXEL_MM)
    return np.repeat(np.rint(grey).astype(np.uint8)[..., None], 3, axis=2)
