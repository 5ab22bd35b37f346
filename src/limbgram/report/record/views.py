"""Views: a limb from its four sides, named as clinicians name them, landmarks numbered."""

import numpy as np

from limbgram.report.drawings.drawing import BELOW_PX, FAINT, Drawing, axes_at, bare, scale_bar
from limbgram.report.drawings.shading import shade_all
from limbgram.report.drawings.views import (
    BESIDE,
    letter_corners,
    limb_frames,
    normals_at,
    number_landmarks,
)
from limbgram.workbench.limb import AlignedLimb, Side

_WIDTH_IN = 10.5
_GAP_IN = 0.05
_TITLE_IN = 0.32


def four_sides_of_limb(limb: AlignedLimb) -> Drawing:
    """Anterior, lateral, posterior and medial of a limb that is in its own frame."""
    mesh, landmarks = limb.mesh, limb.landmarks
    sides = _sides(limb.side)
    frames = limb_frames(mesh, [azimuth_deg for _, azimuth_deg in sides])
    across_in = (_WIDTH_IN - _GAP_IN) / 4 - _GAP_IN
    along_in = across_in * (frames[0].height_px + BELOW_PX) / frames[0].width_px
    figure = bare(_WIDTH_IN, _TITLE_IN + along_in + _GAP_IN)
    normals = normals_at(mesh, landmarks)
    shaded = shade_all(mesh, frames)
    lefts_in = _GAP_IN + (across_in + _GAP_IN) * np.arange(4)
    panels = zip(lefts_in, sides, frames, shaded, strict=True)
    for left_in, (title, azimuth_deg), frame, picture in panels:
        axes = axes_at(figure, left_in, _TITLE_IN, across_in, along_in)
        axes.imshow(picture)
        axes.set_axis_off()
        axes.set_title(title, fontsize=10, color=FAINT, y=1.0)
        number_landmarks(axes, frame, landmarks, normals)
        scale_bar(axes, frame)
        letter_corners(axes, BESIDE[azimuth_deg])
    return Drawing(figure, _caption(bool(landmarks), mesh.filled_share()))


def _sides(side: Side) -> tuple[tuple[str, int], ...]:
    """Titles and where one looks from, degrees from the patient's right towards the front."""
    right, left = ("patient's right", 0), ("patient's left", 180)
    if side == "right":
        right, left = ("lateral (patient's right)", 0), ("medial", 180)
    elif side == "left":
        right, left = ("medial", 0), ("lateral (patient's left)", 180)
    outer, inner = (left, right) if side == "left" else (right, left)
    return ("anterior", 90), outer, ("posterior", 270), inner


def _caption(numbered: bool, filled: float) -> str:
    parts = ["Parallel views along the limb's own axes, all at one scale; proximal is up."]
    if numbered:
        parts.append("Numbers are the landmarks of the table.")
    if filled:
        parts.append(f"Orange ({filled:.1%} of the area) was filled in, not measured.")
    return " ".join(parts)
