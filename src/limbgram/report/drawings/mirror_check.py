"""The mirror check: what an exported file holds, seen as nobody can mistake it.

Sections from above, front up and the patient's right to the right, and the shape from the front and
from both sides at one scale, drawn from what was read back. Words in the upper corners of every
picture say what lies there. Laid beside the patient, a mirrored shape shows.
"""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut
from limbgram.report.drawings.drawing import FAINT, INK, RED, Drawing, axes_at, bare, scale_bar
from limbgram.report.drawings.shading import shade_all
from limbgram.report.drawings.views import limb_frames, normals_at, number_landmarks
from limbgram.workbench.limb import Landmark, Side

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SECTIONS_IN, _VIEW_IN, _GAP_IN = 2.9, 2.6, 0.2
_EDGE_IN, _TITLE_IN, _BELOW_IN = 0.15, 1.05, 0.5
"""Room beside the sections, for titles and signs, and for the key of the sections."""
_SIGN_PT = 15
"""Of LEFT and RIGHT: legible where the picture is shown at half its size."""
_WIDTH_IN = _SECTIONS_IN + 2 * _EDGE_IN + 3 * (_VIEW_IN + _GAP_IN)
_LETTERS = 140
"""That fit on a line of the key."""
_LINE_IN = 0.19
_VIEWS = (
    ("seen from the front", 90, "RIGHT", "LEFT"),
    ("seen from the patient's right", 0, "BACK", "FRONT"),
    ("seen from the patient's left", 180, "FRONT", "BACK"),
)
"""Title, degrees from the patient's right towards the front, what lies left and right in it."""
_LEVELS = (0.2, 0.4, 0.6, 0.8)
_COLOURS = ("#2b6ca3", "#3c8d5a", "#d9822b", "#b8403a")


def mirror_check(
    mesh_in_limb: Mesh, landmarks_in_limb: tuple[Landmark, ...], side: Side, title: str
) -> Drawing:
    """Four panels: sections from above, the shape from the front, the right and the left."""
    frames = limb_frames(mesh_in_limb, [azimuth_deg for _, azimuth_deg, _, _ in _VIEWS])
    tall_in = _VIEW_IN * min(max(frames[0].height_px / frames[0].width_px, 1.0), 2.2)
    normals = normals_at(mesh_in_limb, landmarks_in_limb)
    longest = _key(landmarks_in_limb, set())
    key_in = _LINE_IN * len(longest.splitlines())
    figure = bare(_WIDTH_IN, _TITLE_IN + tall_in + _BELOW_IN + key_in)
    _sections(axes_at(figure, _EDGE_IN, _TITLE_IN, _SECTIONS_IN, tall_in), mesh_in_limb)
    left_in = _SECTIONS_IN + 2 * _EDGE_IN
    seen: set[int] = set()
    shaded = shade_all(mesh_in_limb, frames)
    for k, (frame, picture, named) in enumerate(zip(frames, shaded, _VIEWS, strict=True)):
        axes = axes_at(figure, left_in + k * (_VIEW_IN + _GAP_IN), _TITLE_IN, _VIEW_IN, tall_in)
        axes.imshow(picture)
        axes.set_axis_off()
        axes.set_title(named[0], fontsize=11, color=FAINT, pad=24)
        seen |= number_landmarks(axes, frame, landmarks_in_limb, normals)
        scale_bar(axes, frame)
        _sign(axes, named[2], (0.0, 1.0), "left")
        _sign(axes, named[3], (1.0, 1.0), "right")
    size = np.ptp(mesh_in_limb.vertices_mm, axis=0)
    told = "no side" if side == "none" else f"the patient's {side.upper()} side"
    figure.suptitle(
        f"{title}: {told}; {size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} mm "
        "(right-left, front-back, along)",
        fontsize=10,
        color=INK,
        parse_math=False,
    )
    key = _key(landmarks_in_limb, seen)
    figure.supxlabel(key, fontsize=10, color=RED, x=0.02, ha="left", parse_math=False)
    return Drawing(
        figure,
        "Drawn from the file as it was read back. RIGHT is the patient's right. Compare with the "
        "patient before carving: a mirrored shape has its features on the other side.",
    )


def _key(landmarks: Sequence[Landmark], seen: set[int]) -> str:
    """Which number is which landmark, and which of them the shape covers in all three views."""
    named = [
        f"{number} {mark.name}{'' if number in seen else ' (out of sight)'}"
        for number, mark in enumerate(landmarks, start=1)
    ]
    return textwrap.fill("    ".join(named), _LETTERS)


def _sections(axes: "Axes", mesh: Mesh) -> None:
    low, high = float(mesh.vertices_mm[:, 2].min()), float(mesh.vertices_mm[:, 2].max())
    for share, colour in zip(_LEVELS, _COLOURS, strict=True):
        for section in cut(mesh, [low + share * (high - low)]):
            points = section.points_mm
            closed = np.concatenate([points, points[:1]]) if section.closed else points
            label = f"{share:.0%}"
            known = axes.get_legend_handles_labels()[1]
            axes.plot(*closed[:, :2].T, color=colour, lw=1, label="" if label in known else label)
    axes.plot(0, 0, "+", color=INK)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title("sections seen from above", fontsize=11, color=FAINT, pad=24)
    axes.legend(
        fontsize=7,
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        ncol=4,
        frameon=False,
        title="height, as a share of the length",
        title_fontsize=7,
    )
    _sign(axes, "LEFT", (0.0, 1.0), "left")
    _sign(axes, "FRONT", (0.5, 1.0), "center")
    _sign(axes, "RIGHT", (1.0, 1.0), "right")


def _sign(axes: "Axes", text: str, place: tuple[float, float], across: str) -> None:
    axes.text(
        *place,
        text,
        transform=axes.transAxes,
        fontsize=_SIGN_PT,
        weight="bold",
        color=RED,
        ha=across,
        va="bottom",
    )
