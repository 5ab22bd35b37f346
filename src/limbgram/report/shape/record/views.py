"""Views: a limb from its four sides, named as clinicians name them, landmarks numbered."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from limbgram.report.drawings.drawing import FAINT, RED, Drawing, blank
from limbgram.report.drawings.shading import Frame, looking_along, shade_all
from limbgram.report.drawings.surfaces import scale_bar
from limbgram.shape.limb import Landmark, Side
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

_HEIGHT_PX = 560
_WIDTH_IN = 10.5
_FACING = 0.15
"""Cosine to the viewer from which a landmark is drawn: those behind the horizon are not."""


def four_sides_of_limb(mesh_in_limb: Mesh, landmarks: Sequence[Landmark], side: Side) -> Drawing:
    """Anterior, lateral, posterior and medial of a shape in its limb frame."""
    low, high = mesh_in_limb.vertices_mm.min(0), mesh_in_limb.vertices_mm.max(0)
    width_mm = 1.06 * float((high - low)[:2].max())
    height_mm = 1.04 * float(high[2] - low[2])
    pixel_mm = max(width_mm, height_mm) / _HEIGHT_PX
    width_px, height_px = int(width_mm / pixel_mm), int(height_mm / pixel_mm)
    figure = blank(_WIDTH_IN, _WIDTH_IN / 4 * height_px / width_px + 0.5)
    normals = _normals_at(mesh_in_limb, landmarks)
    sides = _sides(side)
    frames = [
        Frame(
            picture_from_world=looking_along(azimuth_deg),
            middle_mm=(low + high) / 2,
            pixel_mm=pixel_mm,
            width_px=width_px,
            height_px=height_px,
        )
        for _, azimuth_deg in sides
    ]
    shaded = shade_all(mesh_in_limb, frames)
    panels = figure.subplots(1, 4)
    for axes, (title, _), frame, picture in zip(panels, sides, frames, shaded, strict=True):
        axes.imshow(picture)
        axes.set_axis_off()
        axes.set_title(title, fontsize=10, color=FAINT)
        _number(axes, frame, landmarks, normals)
        scale_bar(axes, frame)
    filled = mesh_in_limb.filled
    share = 0.0 if filled is None else float(filled.mean())
    return Drawing(figure, _caption(bool(landmarks), share))


def _sides(side: Side) -> tuple[tuple[str, int], ...]:
    """Titles and where one looks from, degrees from the patient's right towards the front."""
    right, left = ("patient's right", 0), ("patient's left", 180)
    if side == "right":
        right, left = ("lateral (patient's right)", 0), ("medial", 180)
    elif side == "left":
        right, left = ("medial", 0), ("lateral (patient's left)", 180)
    outer, inner = (left, right) if side == "left" else (right, left)
    return ("anterior", 90), outer, ("posterior", 270), inner


def _normals_at(mesh: Mesh, landmarks: Sequence[Landmark]) -> np.ndarray:
    """Outward unit normal of the surface at each landmark."""
    if not landmarks:
        return np.empty((0, 3))
    places = np.stack([mark.position_mm for mark in landmarks])
    closest = TriangleTree.of(mesh.vertices_mm, mesh.faces).closest(places)
    normals = mesh.face_normals()[closest.faces]
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def _number(axes: Axes, frame: Frame, landmarks: Sequence[Landmark], normals: np.ndarray) -> None:
    """The numbers of the landmarks that face the viewer."""
    towards = -frame.picture_from_world[2]
    for number, (mark, normal) in enumerate(zip(landmarks, normals, strict=True), start=1):
        if float(normal @ towards) < _FACING:
            continue
        x, y, _ = frame.project(mark.position_mm[None])[0]
        axes.plot(x, y, "o", color=RED, ms=3.5)
        axes.text(x + 9, y, str(number), fontsize=9, color=RED, va="center", weight="bold")


def _caption(numbered: bool, filled: float) -> str:
    parts = ["Parallel views along the limb's own axes, all at one scale; proximal is up."]
    if numbered:
        parts.append("Numbers are the landmarks of the table.")
    if filled:
        parts.append(f"Orange ({filled:.1%} of the vertices) was filled in, not measured.")
    return " ".join(parts)
