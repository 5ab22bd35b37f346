"""Painted marks: spots painted on the sock in one plain colour, offered as landmark candidates.

In      a mesh whose vertices carry the colours of the photos.
Out     Marks, the plainest first: places on the surface, in the mesh's frame.
Method  vertices of strong colour join with neighbours of nearly the same hue to patches; a patch of
        the size of a mark, round, and unlike what lies round it, is a mark.
        Dabs of a painted sock pass as well: there, say the marks' colour, or use shape.painted.
Fails   MeasureError: the mesh has no colours, or too many spots pass. OptionsError: a grey.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int32, UInt8

from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import turn_rad
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import components, find_edges

_LEAST_CHROMA = 60.0
"""Largest minus smallest of red, green and blue, 0 to 255."""

_SAME_HUE_DEG = 25.0
"""Angle between two hues below which they count as one colour."""
_SMALLEST_MM, _LARGEST_MM = 3.0, 30.0
"""Diameter of the circle of the same area."""
_MOST_STRETCH = 2.0
"""Largest reach from the middle, as a multiple of that circle's radius."""
_MOST = 40
"""More spots than this are no marks but a painted sock."""


@dataclass(frozen=True, kw_only=True)
class Mark:
    """A spot that may be a landmark."""

    position_mm: Vector3
    """On the surface, in the mesh's frame."""
    colour: UInt8[np.ndarray, "3"]
    diameter_mm: float
    strength: float
    """Chroma of the spot, 0 to 255."""


def find_marks(mesh: Mesh, colour: tuple[int, int, int] | None = None) -> tuple[Mark, ...]:
    """Round spots of one strong colour, by falling strength of their colour.

    Args:
        colour: sRGB of the marks; None: any strong colour.

    Raises:
        MeasureError: the mesh has no colours, or too many spots pass.
        OptionsError: the given colour is too near to grey to have a hue.
    """
    if mesh.colours is None:
        raise MeasureError("landmark.marks.no_colours")
    chroma, hue_rad = _chroma(mesh.colours), _hue_rad(mesh.colours)
    coloured = chroma >= _LEAST_CHROMA
    if colour is not None:
        if max(colour) - min(colour) < _LEAST_CHROMA:
            raise OptionsError("landmark.marks.grey_name", colour=colour)
        wanted = _hue_rad(np.array([colour], np.uint8))[0]
        turn = np.abs(turn_rad(hue_rad, wanted))
        coloured &= turn < np.radians(_SAME_HUE_DEG)
    labels = _patches(mesh, coloured, hue_rad, np.radians(_SAME_HUE_DEG))
    areas = mesh.vertex_areas_mm2()
    sizes = np.bincount(labels, areas * coloured)
    diameters = np.sqrt(4 * sizes / np.pi)
    fitting = (diameters >= _SMALLEST_MM) & (diameters <= _LARGEST_MM)
    order = np.argsort(labels, kind="stable")
    starts = np.searchsorted(labels[order], np.arange(len(sizes) + 1))
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    found: list[Mark] = []
    for patch in np.flatnonzero(fitting):
        ids = order[starts[patch] : starts[patch + 1]]
        weights = areas[ids] * chroma[ids]
        middle = weights @ mesh.vertices_mm[ids] / weights.sum()
        reach = float(np.linalg.norm(mesh.vertices_mm[ids] - middle, axis=1).max())
        if len(ids) < 3 or reach > _MOST_STRETCH * float(diameters[patch]) / 2:
            continue
        mean = weights @ mesh.colours[ids].astype(np.float64) / weights.sum()
        found.append(
            Mark(
                position_mm=tree.closest(middle[None]).points_mm[0],
                colour=np.rint(mean).astype(np.uint8),
                diameter_mm=float(diameters[patch]),
                strength=float(mean.max() - mean.min()),
            )
        )
    if len(found) > _MOST:
        raise MeasureError("landmark.marks.many", count=len(found), most=_MOST)
    return tuple(sorted(found, key=lambda mark: -mark.strength))


def _chroma(colours: UInt8[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    return np.ptp(colours.astype(np.float64), axis=1)


def _hue_rad(colours: UInt8[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    red, green, blue = colours.astype(np.float64).T
    return np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue)


def _patches(
    mesh: Mesh,
    coloured: Bool[np.ndarray, " n"],
    hue_rad: Float64[np.ndarray, " n"],
    same_rad: float,
) -> Int32[np.ndarray, " n"]:
    """Label of each vertex: coloured neighbours of nearly one hue share theirs."""
    ends = find_edges(mesh.faces).ends
    turn = turn_rad(hue_rad[ends[:, 0]], hue_rad[ends[:, 1]])
    alike = coloured[ends].all(1) & (np.abs(turn) < same_rad)
    return components(ends[alike], len(mesh))
