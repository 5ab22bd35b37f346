"""Lenses of single photos in words: what differed from photo to photo, and by how many pixels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.reconstruction.mapping.own import numbers_of
from limbgram.reconstruction.mapping.scene import Deviation, Scene


@dataclass(frozen=True, kw_only=True)
class OwnLensFigures:
    """One kind of difference between photos that was solved for each of them."""

    kind: Deviation
    largest_px: float
    """Most that it moves a pixel of any photo: at the picture's border where it grows outwards."""
    chance: float
    """That photos of one lens look as much like it."""
    sentence: str


def own_lenses(scene: Scene) -> tuple[OwnLensFigures, ...]:
    """Kinds of difference that the residuals asked for; none in photos of one lens."""
    own, figures = scene.own, list[OwnLensFigures]()
    if own is None:
        return ()
    first = 0
    for kind, chance in zip(own.deviations, own.chances, strict=True):
        numbers = slice(first, first + numbers_of(kind))
        first = numbers.stop
        placed = np.array(scene.placed)
        moves_px = _moves_px(scene, kind, own.values[placed, numbers])
        largest_px = float(moves_px.max(initial=0.0))
        figures.append(
            OwnLensFigures(
                kind=kind, largest_px=largest_px, chance=chance, sentence=_told(kind, largest_px)
            )
        )
    return tuple(figures)


def _moves_px(
    scene: Scene, kind: Deviation, values: Float64[np.ndarray, "p q"]
) -> Float64[np.ndarray, " p"]:
    """By photo, how far its own numbers move a pixel, at the border where they grow outwards."""
    sizes = np.array([(view.camera.width_px, view.camera.height_px) for view in scene.views], float)
    match kind:
        case "principal point":
            return np.linalg.norm(values, axis=1) * sizes[:, 0]
        case "focal length":
            return np.abs(values[:, 0]) * 0.5 * np.linalg.norm(sizes, axis=1)
        case "rolling shutter":
            return np.linalg.norm(values[:, :2], axis=1) * 0.5 * sizes[:, 1]


def _told(kind: Deviation, largest_px: float) -> str:
    match kind:
        case "principal point":
            return (
                "The picture was shifted on the sensor from photo to photo, by up to "
                f"{largest_px:.1f} px, as an optical stabiliser does. The shift was solved for "
                "each photo. Switch the stabiliser off where the camera allows it."
            )
        case "focal length":
            return (
                "The focal length differed from photo to photo, by up to "
                f"{largest_px:.1f} px at the corners, as it does when the camera focuses anew or "
                "zooms. It was solved for each photo. Lock zoom and focus where the camera allows "
                "it."
            )
        case "rolling shutter":
            return (
                "The camera moved while it read its rows one after the other (rolling shutter), "
                f"which bent photos by up to {largest_px:.1f} px at their upper and lower border. "
                "This was solved for each photo. Hold the camera still for each photo, and give "
                "more light."
            )
