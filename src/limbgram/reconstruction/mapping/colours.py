"""Colours: what the photos show where the points of a scene were seen.

In      the photos, a scene of them.
Out     by point red, green and blue of one photo that sees it; grey where none does.
Method  the first photo of each point, reduced by half, at the nearest pixel.
"""

import numpy as np
from jaxtyping import UInt8

from limbgram.core.run import track
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.decoding import load_colour
from limbgram.reconstruction.photos.photo import PhotoSet

GREY = 128
_HALVINGS = 1


def point_colours(photos: PhotoSet, scene: Scene) -> UInt8[np.ndarray, "n 3"]:
    """Colours by point of the scene."""
    colours = np.full((len(scene.points_in_world), 3), GREY, np.uint8)
    seen = scene.observations
    placed = np.flatnonzero(np.isin(seen.photo_idx, scene.placed))
    first = placed[np.unique(seen.point_idx[placed], return_index=True)[1]]
    for photo_idx in track(np.unique(seen.photo_idx[first]).tolist()):
        rows = first[seen.photo_idx[first] == photo_idx]
        picture = load_colour(photos.photos[photo_idx], _HALVINGS)
        xy = np.rint((seen.xy_px[rows] + 0.5) / (1 << _HALVINGS) - 0.5).astype(np.int64)
        height, width = picture.shape[:2]
        x, y = np.clip(xy[:, 0], 0, width - 1), np.clip(xy[:, 1], 0, height - 1)
        colours[seen.point_idx[rows]] = picture[y, x]
    return colours
