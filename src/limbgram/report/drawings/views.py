"""Views: frames of a limb from its sides at one scale, landmarks numbered, corners lettered."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.report.drawings.drawing import INK, RED
from limbgram.report.drawings.shading import Frame, looking_along
from limbgram.workbench.limb import Landmark

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Vectors3 = Float64[np.ndarray, "n 3"]

_HEIGHT_PX = 560
_FACING = 0.15
"""Cosine to the viewer from which a landmark is drawn: those behind the horizon are not."""

BESIDE = {90: ("R", "L"), 0: ("B", "F"), 270: ("L", "R"), 180: ("F", "B")}
"""What lies left and right in a view, by its degrees from the patient's right towards the front."""
FROM_ABOVE = ("L", "R")
"""The same in a section, which is seen from above with the front upwards."""


def limb_frames(mesh_in_limb: Mesh, azimuths_deg: Sequence[int]) -> list[Frame]:
    """Views of one size and scale, degrees from the patient's right towards the front."""
    low, high = mesh_in_limb.vertices_mm.min(0), mesh_in_limb.vertices_mm.max(0)
    width_mm = 1.06 * float((high - low)[:2].max())
    height_mm = 1.04 * float(high[2] - low[2])
    pixel_mm = max(width_mm, height_mm) / _HEIGHT_PX
    return [
        Frame(
            picture_from_world=looking_along(azimuth_deg),
            middle_mm=(low + high) / 2,
            pixel_mm=pixel_mm,
            width_px=int(width_mm / pixel_mm),
            height_px=int(height_mm / pixel_mm),
        )
        for azimuth_deg in azimuths_deg
    ]


def letter_corners(axes: "Axes", beside: tuple[str, str]) -> None:
    """Say in the upper corners of a picture what lies left and right in it: R, L, F or B."""
    for along, across, name in zip((0.02, 0.98), ("left", "right"), beside, strict=True):
        axes.text(
            along,
            0.99,
            name,
            transform=axes.transAxes,
            color=INK,
            fontsize=13,
            weight="bold",
            va="top",
            ha=across,
        )


def normals_at(mesh: Mesh, landmarks: Sequence[Landmark]) -> Vectors3:
    """Outward unit normal of the surface at each landmark."""
    if not landmarks:
        return np.empty((0, 3))
    places = np.stack([mark.position_mm for mark in landmarks])
    closest = tree_on(mesh).closest(places)
    normals = mesh.face_normals()[closest.faces]
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def number_landmarks(
    axes: "Axes", frame: Frame, landmarks: Sequence[Landmark], normals: Vectors3
) -> set[int]:
    """Draw the numbers of the landmarks that face the viewer; which these are, from 1."""
    towards = -frame.picture_from_world[2]
    seen = {k for k, normal in enumerate(normals, start=1) if float(normal @ towards) >= _FACING}
    for number in sorted(seen):
        x, y, _ = frame.project(landmarks[number - 1].position_mm[None])[0]
        axes.plot(x, y, "o", color=RED, ms=3.5)
        axes.text(x + 9, y, str(number), fontsize=9, color=RED, va="center", weight="bold")
    return seen
