"""The mirror check: what an exported file holds, seen as nobody can mistake it.

Sections from proximal, front up, and the shape from the front and from the patient's right, drawn
from what was read back. Laid beside the patient, a mirrored shape shows.
"""

import numpy as np
from matplotlib.axes import Axes

from limbgram.geometry.arrays import Matrix3
from limbgram.geometry.rigid import turned
from limbgram.report.drawings.drawing import FAINT, INK, RED, Drawing, blank
from limbgram.report.drawings.shading import Frame, shade
from limbgram.shape.limb import Landmark, Side
from limbgram.surface.mesh import Mesh
from limbgram.surface.sections import cut

_HEIGHT_PX = 460
_FROM_THE_RIGHT = np.array([[0.0, 1.0, 0], [0, 0, -1.0], [-1.0, 0, 0]])
_FROM_THE_FRONT = np.array([[-1.0, 0, 0], [0, 0, -1.0], [0, -1.0, 0]])
_LEVELS = (0.2, 0.4, 0.6, 0.8)
_COLOURS = ("#2b6ca3", "#3c8d5a", "#d9822b", "#b8403a")


def mirror_check(
    mesh_in_limb: Mesh, landmarks_in_limb: tuple[Landmark, ...], side: Side, title: str
) -> Drawing:
    """Three panels: sections from proximal, the shape from the front and from the right."""
    figure = blank(10.5, 4.2)
    sections, front, beside = figure.subplots(1, 3)
    _sections(sections, mesh_in_limb)
    _view(front, mesh_in_limb, landmarks_in_limb, _FROM_THE_FRONT)
    _view(beside, mesh_in_limb, landmarks_in_limb, _FROM_THE_RIGHT)
    sections.set_title("sections seen from proximal", fontsize=9, color=FAINT, pad=16)
    front.set_title("seen from the front", fontsize=9, color=FAINT, pad=16)
    beside.set_title("seen from the patient's right", fontsize=9, color=FAINT, pad=16)
    _sign(sections, "FRONT", (0.5, 1.0), "center", "bottom")
    _sign(sections, "RIGHT", (1.0, 0.5), "left", "center")
    _sign(sections, "LEFT", (0.0, 0.5), "right", "center")
    _sign(front, "RIGHT", (0.0, 0.5), "right", "center")
    _sign(front, "LEFT", (1.0, 0.5), "left", "center")
    _sign(beside, "FRONT", (1.0, 0.5), "left", "center")
    _sign(beside, "BACK", (0.0, 0.5), "right", "center")
    size = np.ptp(mesh_in_limb.vertices_mm, axis=0)
    told = "no side" if side == "none" else f"the patient's {side.upper()} side"
    figure.suptitle(
        f"{title}: {told}; {size[0]:.0f} x {size[1]:.0f} x {size[2]:.0f} mm "
        "(right-left, front-back, along)",
        fontsize=10,
        color=INK,
    )
    return Drawing(
        figure,
        "Drawn from the file as it was read back. RIGHT is the patient's right. Compare with the "
        "patient before carving: a mirrored shape has its features on the other side.",
    )


def _sections(axes: Axes, mesh: Mesh) -> None:
    low, high = float(mesh.vertices_mm[:, 2].min()), float(mesh.vertices_mm[:, 2].max())
    for share, colour in zip(_LEVELS, _COLOURS, strict=True):
        for section in cut(mesh, [low + share * (high - low)]):
            points = section.points_mm
            closed = np.concatenate([points, points[:1]]) if section.closed else points
            label = f"{share:.0%} of the length"
            known = axes.get_legend_handles_labels()[1]
            axes.plot(*closed[:, :2].T, color=colour, lw=1, label="" if label in known else label)
    axes.plot(0, 0, "+", color=INK)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.legend(fontsize=6, loc="upper center", bbox_to_anchor=(0.5, 0), ncol=4, frameon=False)


def _view(axes: Axes, mesh: Mesh, landmarks: tuple[Landmark, ...], turn: Matrix3) -> None:
    seen = turned(mesh.vertices_mm, turn)
    size = np.ptp(seen, axis=0)
    pixel_mm = float(max(size[0], size[1]) / _HEIGHT_PX)
    frame = Frame(
        picture_from_world=turn,
        middle_mm=(mesh.vertices_mm.min(0) + mesh.vertices_mm.max(0)) / 2,
        pixel_mm=pixel_mm,
        width_px=int(size[0] / pixel_mm) + 3,
        height_px=int(size[1] / pixel_mm) + 3,
    )
    axes.imshow(shade(mesh, frame))
    for mark in landmarks:
        x, y, _ = frame.project(mark.position_mm[None])[0]
        axes.plot(x, y, ".", color=RED, ms=4)
        axes.text(x + 6, y, mark.name, fontsize=6, color=RED, va="center", clip_on=True)
    axes.set_axis_off()


def _sign(axes: Axes, text: str, place: tuple[float, float], across: str, along: str) -> None:
    axes.text(
        *place,
        text,
        transform=axes.transAxes,
        fontsize=8,
        weight="bold",
        color=RED,
        ha=across,
        va=along,
    )
