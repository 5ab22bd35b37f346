"""Contact: the least distance from the axis at which a ball touches the surface.

In      a surface, closely sampled; places along and round the z axis.
Out     the radius at which the ball's centre stops, coming from outside along the tool's axis.
Method  every sample stops the ball at its own radius; the largest counts. This is the surface's
        true offset, not a radial one, and a ball that comes from outside keeps its shank clear.

Angles are counted from +Y, counter-clockwise seen from +Z (the tool's direction is
(-sin A, cos A)).
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import find_edges
from limbgram.core.run import in_parallel

_BIN_MM = 1.5
_BINS_ROUND = 180
_BLOCK = 20_000


@dataclass(frozen=True)
class ContactField:
    """Samples of a surface, binned along and round the axis, for contact with a ball."""

    points: Float64[np.ndarray, "n 3"]
    starts: Int64[np.ndarray, " ends"]
    nearest_mm: Float64[np.ndarray, " x"]
    """Least radius in each ring of bins."""
    farthest_mm: Float64[np.ndarray, " b"]
    """Largest radius in each bin."""
    low_mm: float

    @classmethod
    def of(cls, points_mm: Points3) -> "ContactField":
        x, y, z = points_mm.T
        low = float(z.min())
        along = ((z - low) / _BIN_MM).astype(np.int64)
        angle = np.arctan2(-x, y) % (2 * np.pi)
        around = np.minimum((angle / (2 * np.pi) * _BINS_ROUND).astype(np.int64), _BINS_ROUND - 1)
        bins = along * _BINS_ROUND + around
        rings = int(along.max()) + 1
        order = np.argsort(bins, kind="stable")
        starts = np.searchsorted(bins[order], np.arange(rings * _BINS_ROUND + 1))
        radii = np.hypot(x, y)
        nearest = np.full(rings, np.inf)
        np.minimum.at(nearest, along, radii)
        farthest = np.zeros(rings * _BINS_ROUND)
        np.maximum.at(farthest, bins, radii)
        return cls(np.ascontiguousarray(points_mm[order]), starts, nearest, farthest, low)

    def stops_mm(
        self,
        z_mm: Float64[np.ndarray, " k"],
        angles_rad: Float64[np.ndarray, " k"],
        ball_mm: float,
        floor_mm: float,
    ) -> Float64[np.ndarray, " k"]:
        """Distance of the ball's centre from the axis at contact; the floor where there is none."""
        stops = np.full(len(z_mm), floor_mm)

        def stop_block(start: int) -> None:
            part = slice(start, start + _BLOCK)
            _ball_stops(
                self.points,
                self.starts,
                self.nearest_mm,
                self.farthest_mm,
                self.low_mm,
                z_mm[part],
                angles_rad[part],
                ball_mm,
                stops[part],
            )

        in_parallel(stop_block, range(0, len(z_mm), _BLOCK))
        return stops


def sample_surface(mesh: Mesh, spacing_mm: float) -> Points3:
    """Vertices, and points on edges and in faces, so that gaps are no wider than the spacing."""
    edges = find_edges(mesh.faces)
    lengths = np.linalg.norm(np.diff(mesh.vertices_mm[edges.ends], axis=1)[:, 0], axis=1)
    parts = np.maximum(np.ceil(lengths / spacing_mm).astype(np.int64), 1)
    inner = parts - 1
    edge = np.repeat(np.arange(len(parts)), inner)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(inner) - inner, inner) + 1
    share = (step / parts[edge])[:, None]
    ends = mesh.vertices_mm[edges.ends[edge]]
    on_edges = (1 - share) * ends[:, 0] + share * ends[:, 1]
    of_face = parts[edges.of_half_edge].reshape(-1, 3).max(1)
    in_faces = [
        _face_lattice(mesh, of_face == count, count) for count in np.unique(of_face).tolist()
    ]
    return np.concatenate([mesh.vertices_mm, on_edges, *in_faces])


def _face_lattice(mesh: Mesh, chosen: np.ndarray, count: int) -> Points3:
    """Lattice points inside faces whose edges are divided into a number of parts."""
    i, j = np.meshgrid(np.arange(1, count), np.arange(1, count), indexing="ij")
    kept = i + j < count
    u, v = i[kept] / count, j[kept] / count
    weights = np.column_stack([1 - u - v, u, v])
    return np.einsum("kc,fcd->fkd", weights, mesh.vertices_mm[mesh.faces[chosen]]).reshape(-1, 3)


@njit(cache=True, nogil=True)
def _ball_stops(
    points: np.ndarray,
    starts: np.ndarray,
    nearest: np.ndarray,
    farthest: np.ndarray,
    low: float,
    z_mm: np.ndarray,
    angles: np.ndarray,
    ball: float,
    stops: np.ndarray,
):
    rings = nearest.shape[0]
    around = _BINS_ROUND
    bin_rad = 2 * math.pi / around
    ball2 = ball * ball
    for q in range(z_mm.shape[0]):
        z, angle = z_mm[q], angles[q] % (2 * math.pi)
        towards_x, towards_y = -math.sin(angle), math.cos(angle)
        best = stops[q]
        middle = int((z - low) / _BIN_MM)
        first = max(0, int(math.floor((z - ball - low) / _BIN_MM)))
        last = min(rings - 1, int(math.floor((z + ball - low) / _BIN_MM)))
        here = int(angle / bin_rad)
        for turn in range(2 * (last - first + 1) + 2 * abs(middle) + 2):
            # From the middle outwards, so that the far bins are passed over.
            ring = middle + (turn + 1) // 2 * (1 if turn % 2 else -1)
            if ring < first or ring > last:
                continue
            off = 0.0
            if ring != middle:
                edge = low + (ring if ring > middle else ring + 1) * _BIN_MM
                off = abs(edge - z)
            if off >= ball:
                continue
            rise = math.sqrt(ball2 - off * off)
            wide = around // 2
            if nearest[ring] > ball:
                wide = min(wide, int(math.asin(ball / nearest[ring]) / bin_rad) + 1)
            for side in range(-wide, wide + 1):
                cell = ring * around + (here + side) % around
                if farthest[cell] + rise <= best:
                    continue
                for p in range(starts[cell], starts[cell + 1]):
                    x, y = points[p, 0], points[p, 1]
                    across = x * towards_y - y * towards_x
                    away = points[p, 2] - z
                    free2 = ball2 - across * across - away * away
                    if free2 > 0:
                        stop = x * towards_x + y * towards_y + math.sqrt(free2)
                        if stop > best:
                            best = stop
        stops[q] = best
