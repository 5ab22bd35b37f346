"""Drawings of the result: the surface and its sigma from four sides, the cloud with its cameras."""

from typing import TYPE_CHECKING

import numpy as np

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.mesh.topology import is_inside_out
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.report.drawings.drawing import FAINT, INK, RED, Drawing, blank
from limbgram.report.drawings.maps import size_map
from limbgram.report.drawings.sides import sides_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN_POINTS = 40_000
_CAMERA_SHARE = 0.05
"""Length of a drawn camera as a share of the cameras' spread."""


def four_sides(mesh: Mesh, metric: MetricScene) -> Drawing:
    """The shaded surface from four sides at one scale, the filled part coloured."""
    low, high = mesh.vertices_mm.min(0), mesh.vertices_mm.max(0)
    figure = sides_figure(mesh, None, in_mm=metric.scale.unit == "mm")
    return Drawing(figure, _surface_caption(mesh, metric, high - low))


def sigma_map(mesh: Mesh, metric: MetricScene) -> Drawing:
    """One standard deviation along the normal, painted on the surface."""
    sigma_mm = np.full(len(mesh), np.nan) if mesh.sigma_mm is None else mesh.sigma_mm.astype(float)
    in_mm = metric.scale.unit == "mm"
    known = sigma_mm[np.isfinite(sigma_mm)]
    middle, high = np.quantile(known, [0.5, 0.95]) if len(known) else (np.nan, np.nan)
    unit = "mm" if in_mm else "scene units (NO SCALE)"
    return Drawing(
        size_map(mesh, sigma_mm, f"one standard deviation along the normal, {unit}", in_mm=in_mm),
        f"How sure the surface is: half of the vertices have a standard deviation below "
        f"{middle:.3f} {unit}, 95 % below {high:.3f}. It holds noise and shading, relief too fine "
        "to be measured, cameras and scale; filled parts have none.",
    )


def cloud_with_cameras(cloud: Cloud, metric: MetricScene) -> Drawing:
    """The point cloud and the placed cameras from above and from the front, and the cloud near."""
    from matplotlib.collections import LineCollection

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


def _scatter(axes: "Axes", cloud: Cloud, up: int, size: float) -> None:
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
    filled = mesh.filled_share()
    parts = (
        f"{len(mesh):,} vertices, {len(mesh.faces):,} triangles; "
        f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} {unit}, seen from four sides round the "
        "world's z axis. "
    )
    if is_inside_out(mesh):
        parts += "It is the inside of something, drawn as a cast of it would look. "
    return parts + (
        f"{filled:.1%} of the area is orange: no photo measured it, we filled it in."
        if filled
        else "All of it was measured."
    )


def _frustum(view: View, depth: float) -> np.ndarray:
    """Edges (n, 2, 3) of a small pyramid from the camera's centre towards what it sees."""
    camera = view.camera
    size_px = np.array([camera.width_px, camera.height_px])
    corners_px = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * size_px - 0.5
    rays = camera.rays(corners_px)
    corners: Points3 = view.camera_from_world.inverse.apply(depth * rays / rays[:, 2:])
    centre = np.broadcast_to(view.centre_in_world, corners.shape)
    spokes = np.stack([centre, corners], axis=1)
    rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    return np.concatenate([spokes, rim])
