"""Openings: which of a mesh's boundary loops is the brim, the limb's own open end."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32

from limbgram.geometry.arrays import Faces, Points3, Vector3
from limbgram.surface.topology import boundary_loops


@dataclass(frozen=True)
class Openings:
    """The brim (None where the mesh has no open end) and the holes, as loops of vertices."""

    brim: Int32[np.ndarray, " b"] | None
    holes: list[Int32[np.ndarray, " l"]]


def find_openings(
    vertices: Points3, faces: Faces, min_share_at_end: float, min_share: float
) -> Openings:
    """Tell the brim from the holes by size and place.

    The loop of the largest area is the brim if it opens a large enough share of what the mesh
    shows from that side: `min_share_at_end` where it lies at the low or high end of the mesh
    (the world's z axis stands on the floor), `min_share` anywhere else.
    """
    loops = boundary_loops(faces)
    if not loops:
        return Openings(None, [])
    areas = [loop_area(vertices[loop]) for loop in loops]
    largest = int(np.argmax([np.linalg.norm(area) for area in areas]))
    size = float(np.linalg.norm(areas[largest]))
    shown = _silhouette(vertices, faces, areas[largest] / max(size, 1e-30))
    needed = min_share_at_end if _is_at_end(vertices, loops[largest]) else min_share
    if size < needed * shown:
        return Openings(None, loops)
    return Openings(loops[largest], loops[:largest] + loops[largest + 1 :])


def loop_area(loop: Points3) -> Vector3:
    """Area vector of a closed polyline: the largest that any view of it shows."""
    from_centre = loop - loop.mean(0)
    return 0.5 * np.cross(from_centre, np.roll(from_centre, -1, axis=0)).sum(0)


def _silhouette(vertices: Points3, faces: Faces, direction: Vector3) -> float:
    """Area of the mesh seen along a direction: the larger of its two sides."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    seen = 0.5 * np.cross(b - a, c - a) @ direction
    return float(max(seen[seen > 0].sum(), -seen[seen < 0].sum()))


def _is_at_end(vertices: Points3, loop: Int32[np.ndarray, " l"]) -> bool:
    """Whether the loop's middle lies in the lowest or highest tenth of the mesh."""
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    place = (vertices[loop, 2].mean() - low) / max(high - low, 1e-30)
    return bool(place < 0.1 or place > 0.9)
