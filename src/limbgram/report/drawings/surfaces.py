"""Drawings of the result: the shaded surface from four sides, the cloud with its cameras."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import faces_inwards
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.report.drawings.drawing import (
    BELOW_PX,
    FAINT,
    INK,
    RED,
    Drawing,
    axes_at,
    bare,
    blank,
    scale_bar,
)
from limbgram.report.drawings.shading import Frame, looking_along, shade

_AZIMUTHS_DEG = (0, 90, 180, 270)
_HEIGHT_PX = 520
_WIDTH_IN, _GAP_IN, _TITLE_IN = 10.5, 0.1, 0.3
_SHOWN_POINTS = 40_000
_CAMERA_SHARE = 0.05
"""Length of a drawn camera as a share of the cameras' spread."""


def four_sides(mesh: Mesh, metric: MetricScene) -> Drawing:
    """The shaded surface from four sides at one scale, the filled part coloured."""
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    figure = sides_figure(mesh, None, in_mm=metric.scale.unit == "mm")
    return Drawing(figure, _surface_caption(mesh, metric, high - low))


def sides_figure(
    mesh: Mesh, paint: Float64[np.ndarray, "n 3"] | None, *, in_mm: bool, room_in: float = 0.05
) -> Figure:
    """Four sides of a mesh in clay or in the paint of its vertices; `room_in` is kept below.

    The inside of a thing is drawn as a cast of it would look: all else would be its back.
    """
    if faces_inwards(mesh):
        mesh = replace(mesh, faces=np.ascontiguousarray(mesh.faces[:, ::-1]))
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    width_mm = 1.08 * float(np.hypot(*(high - low)[:2]))
    height_mm = 1.04 * float(high[2] - low[2])
    pixel_mm = max(width_mm, height_mm) / _HEIGHT_PX
    width_px, height_px = int(width_mm / pixel_mm), int(height_mm / pixel_mm)
    across_in = (_WIDTH_IN - _GAP_IN) / 4 - _GAP_IN
    along_in = across_in * (height_px + BELOW_PX) / width_px
    figure = bare(_WIDTH_IN, _TITLE_IN + along_in + room_in)
    for number, azimuth_deg in enumerate(_AZIMUTHS_DEG):
        left_in = _GAP_IN + number * (across_in + _GAP_IN)
        axes = axes_at(figure, left_in, _TITLE_IN, across_in, along_in)
        frame = Frame(
            picture_from_world=looking_along(azimuth_deg),
            middle_mm=(low + high) / 2,
            pixel_mm=pixel_mm,
            width_px=width_px,
            height_px=height_px,
        )
        axes.imshow(shade(mesh, frame, paint))
        axes.set_axis_off()
        axes.set_title(f"{azimuth_deg}°", fontsize=9, color=FAINT, y=1.0)
        if in_mm:
            scale_bar(axes, frame)
    return figure


def cloud_with_cameras(cloud: Cloud, metric: MetricScene) -> Drawing:
    """The point cloud and the placed cameras from above and from the front, and the cloud near."""
    views = metric.scene.views
    figure = blank(10.5, 4.6)
    panels = figure.subplots(1, 3, width_ratios=(2, 2, 1))
    for axes, up, title in zip(panels, (1, 2, 2), ("from above", "from the front", "points")):
        _scatter(axes, cloud, up, 0.3 if title != "points" else 3.0)
        axes.set_title(title, fontsize=9, color=FAINT)
    spread = np.ptp(np.array([view.centre_in_world for view in views]), axis=0)
    depth = _CAMERA_SHARE * float(np.linalg.norm(spread))
    for axes, up in zip(panels[:2], (1, 2)):
        lines = np.concatenate([_frustum(view, depth) for view in views])[:, :, [0, up]]
        axes.add_collection(LineCollection(list(lines), colors=RED, linewidths=0.6))
        centres = np.array([view.centre_in_world for view in views])[:, [0, up]]
        axes.plot(*centres.T, ".", color=INK, ms=2)
    unit = "mm" if metric.scale.unit == "mm" else "scene units"
    return Drawing(
        figure,
        f"{len(cloud):,} oriented points, {cloud.spacing_mm:.2f} {unit} apart, and the "
        f"{len(views)} cameras where the photos were taken. A limb that is doubled, bent or "
        "misses a side shows here.",
    )


def _scatter(axes: Axes, cloud: Cloud, up: int, size: float) -> None:
    """Points across x, the far ones first."""
    step = max(1, len(cloud) // _SHOWN_POINTS)
    points, colours = cloud.points_mm[::step].astype(float), cloud.colours[::step] / 255.0
    towards = {1: points[:, 2], 2: -points[:, 1]}[up]
    order = np.argsort(towards, kind="stable")
    x, y = points[order, 0], points[order, up]
    axes.scatter(x, y, s=size, c=colours[order], lw=0, rasterized=True)
    axes.set_aspect("equal")
    axes.margins(0.05)
    axes.set_axis_off()


def _surface_caption(mesh: Mesh, metric: MetricScene, size: np.ndarray) -> str:
    unit = "mm" if metric.scale.unit == "mm" else "scene units (NO SCALE)"
    filled = 0.0 if mesh.filled is None else float(mesh.filled.mean())
    parts = (
        f"{len(mesh):,} vertices, {len(mesh.faces):,} triangles; "
        f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} {unit}, seen from four sides round the "
        "world's z axis. "
    )
    if faces_inwards(mesh):
        parts += "It is the inside of something, drawn as a cast of it would look. "
    return parts + (
        f"{filled:.1%} of the vertices are orange: no photo measured them, we filled them in."
        if filled
        else "Every vertex was measured."
    )


def _frustum(view: View, depth: float) -> np.ndarray:
    """Edges (n, 2, 3) of a small pyramid from the camera's centre towards what it sees."""
    camera = view.camera
    corners_px = np.array(
        [
            [0, 0],
            [camera.width_px, 0],
            [camera.width_px, camera.height_px],
            [0, camera.height_px],
        ],
        float,
    )
    rays = camera.rays(corners_px)
    corners: Points3 = view.camera_from_world.inverse.apply(depth * rays / rays[:, 2:])
    centre = np.broadcast_to(view.centre_in_world, corners.shape)
    spokes = np.stack([centre, corners], axis=1)
    rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    return np.concatenate([spokes, rim])
