"""Lengths between two landmarks: along the limb's axis, straight, and over the surface.

The way over the surface has its length at the smoothing length, and is the limb's as girths are:
what fine relief the surface lost is added. A length's sigma holds the surface's errors and, beside
them, how both landmarks were placed: each errs along the surface, which is nearly all of it.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.smoothed_length import smoothed_length
from limbgram.core.mesh.mesh import Mesh, dots, unit
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.core.mesh.uncertainty import propagate
from limbgram.workbench.measures.geodesic import length_mm, shortest_path
from limbgram.workbench.measures.levels import Figure, Sigmas


@dataclass(frozen=True, kw_only=True)
class Length:
    """The lengths from one landmark to another, in mm."""

    start: str
    end: str
    along_axis: Figure
    """Positive if the end lies more proximal."""
    straight: Figure
    over_surface: Figure
    """Length of the shortest path at the smoothing length."""
    path_in_limb_mm: Points3
    """The shortest path over the surface."""


@dataclass(frozen=True)
class Place:
    """A landmark in the limb frame."""

    name: str
    in_limb_mm: Vector3
    sigma_mm: float = 0.0
    """How well it was placed: one standard deviation in each direction along the surface."""


def length_between(sigmas: Sigmas, start: Place, end: Place) -> Length:
    """All lengths between two places on a mesh in the limb frame.

    Raises:
        MeasureError: no surface joins the two.
    """
    ends = np.stack([start.in_limb_mm, end.in_limb_mm])
    rise = float(ends[1, 2] - ends[0, 2])
    upwards = np.array([[0.0, 0, -1], [0, 0, 1]])
    path = shortest_path(sigmas.mesh, ends[0], ends[1])
    straight = _length_slopes(ends)
    placing = _EndPlacing.of(sigmas, (start, end))
    return Length(
        start=start.name,
        end=end.name,
        along_axis=placing.with_placing(_propagated_figure(sigmas, rise, ends, upwards), upwards),
        straight=placing.with_placing(
            _propagated_figure(sigmas, length_mm(ends), ends, straight), straight
        ),
        over_surface=placing.with_placing(
            surface_length(sigmas, path), _length_slopes(path)[[0, -1]]
        ),
        path_in_limb_mm=path,
    )


@dataclass(frozen=True)
class _EndPlacing:
    """The placing errors of both ends of a length, along the surface."""

    sigmas_mm: Float64[np.ndarray, "2"]
    normals: Float64[np.ndarray, "2 3"]

    @classmethod
    def of(cls, sigmas: Sigmas, ends: tuple[Place, Place]) -> "_EndPlacing":
        ids, shares = barycentric_on_mesh(sigmas.mesh, np.stack([end.in_limb_mm for end in ends]))
        normals = unit(np.einsum("pk,pkd->pd", shares, sigmas.normals[ids]))
        return cls(np.array([end.sigma_mm for end in ends]), normals)

    def with_placing(self, figure: Figure, slopes: Float64[np.ndarray, "2 3"]) -> Figure:
        """A length whose sigma includes placing errors, by its slopes at both ends."""
        if figure.sigma is None:
            return figure
        along = slopes - dots(slopes, self.normals)[:, None] * self.normals
        placing_mm = float(np.linalg.norm(self.sigmas_mm[:, None] * along))
        return Figure(figure.value, math.hypot(figure.sigma, placing_mm))


def surface_length(sigmas: Sigmas, path_mm: Points3) -> Figure:
    """Length of a path over the surface at the smoothing length, with lost length added."""
    if not length_mm(path_mm) > 0:  # from a place to itself
        return _propagated_figure(sigmas, 0.0, path_mm, np.zeros_like(path_mm))
    smooth = smoothed_length(path_mm, closed=False)
    figure = _propagated_figure(sigmas, smooth.value_mm, path_mm, smooth.slopes)
    if figure.sigma is None:
        return figure
    middles, steps = (path_mm[1:] + path_mm[:-1]) / 2, np.diff(path_mm, axis=0)
    ids, shares = barycentric_on_mesh(sigmas.mesh, middles)
    more, sigma = sigmas.lost_length_mm(ids, shares, unit(steps), np.linalg.norm(steps, axis=1))
    return Figure(figure.value + more, math.hypot(figure.sigma, sigma))


def _length_slopes(path_mm: Points3) -> Points3:
    """Change of a polyline's length for a millimetre of each of its points."""
    steps = np.diff(path_mm, axis=0)
    along = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-300)
    slopes = np.zeros_like(path_mm)
    slopes[1:] += along
    slopes[:-1] -= along
    return slopes


def _propagated_figure(sigmas: Sigmas, value: float, places_mm: Points3, slopes: Points3) -> Figure:
    if sigmas.mesh.sigma_mm is None:
        return Figure(value, None)
    return Figure(value, propagate(sigmas.mesh, vertex_gradient(sigmas, places_mm, slopes)))


def vertex_gradient(
    sigmas: Sigmas, places_mm: Points3, slopes: Points3
) -> Float64[np.ndarray, " vertices"]:
    """Change for a millimetre of each vertex along its normal, for places carried by triangles."""
    ids, shares = barycentric_on_mesh(sigmas.mesh, places_mm)
    changes = shares * np.einsum("pkd,pd->pk", sigmas.normals[ids], slopes)
    return np.bincount(ids.ravel(), changes.ravel(), len(sigmas.mesh))


def barycentric_on_mesh(
    mesh: Mesh, places_mm: Points3
) -> tuple[Int32[np.ndarray, "p 3"], Float64[np.ndarray, "p 3"]]:
    """Corners of the triangle on which each place lies, and its barycentric coordinates there."""
    closest = tree_on(mesh).closest(places_mm)
    ids = mesh.faces[closest.faces]
    a, b, c = (mesh.vertices_mm[ids[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    size = np.maximum((normal**2).sum(1), 1e-300)
    at = closest.points_mm
    shares = np.column_stack(
        [
            (np.cross(c - b, at - b) * normal).sum(1) / size,
            (np.cross(a - c, at - c) * normal).sum(1) / size,
            (np.cross(b - a, at - a) * normal).sum(1) / size,
        ]
    )
    return ids, shares
