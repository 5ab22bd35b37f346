"""The floor that the object stands on, and the direction that is up.

Floor: RANSAC with a fixed seed over the sparse points near the aim. A plane is the floor if many
points lie on it and are spread out, hardly any lie below it, the object and all cameras are above
it. Up, where there is no floor: how the photos were taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.core.geometry.arrays import Matrix3, Points3, Vector3
from limbgram.core.geometry.lens import View
from limbgram.reconstruction.scale.visibility import Aim

_TRIALS = 20000
_BLOCK = 500
"""Planes tested at a time: the heights of all points above them take 12 MB."""
_NEAR = 2.0
"""Largest distance from the aim of points that count for the floor, in half frames."""
_MOST_POINTS = 3000
_THICKNESS = 0.012
"""Points this far from the plane lie on it, in half frames."""
_LEAST_SHARE = 0.06
_LEAST_POINTS = 50
MOST_BELOW = 0.02
"""Largest share of the points that may lie below the floor."""
_LEAST_ABOVE = 0.03
"""Share of the points that must stand clearly above it: the object. A printed sheet can carry
many times the points of a plain pot on it."""
_LEAST_SPREAD = 0.25
"""Standard deviation of the floor's points across its narrower direction, in half frames."""


@dataclass(frozen=True)
class Plane:
    """Points with normal @ x = height; the unit normal points to the cameras."""

    normal: Vector3
    height: float

    def above(self, points: Points3) -> np.ndarray:
        """Signed distance of points, positive on the cameras' side."""
        return points @ self.normal - self.height


def find_floor(
    views: Sequence[View], points_in_world: Points3, aim: Aim, seed: int
) -> Plane | None:
    """The plane under the object, or None where the points show none."""
    near = points_in_world[np.linalg.norm(points_in_world - aim.point, axis=1) < _NEAR * aim.reach]
    if len(near) < _LEAST_POINTS:
        return None
    draw = np.random.default_rng(seed)
    sample = near[draw.permutation(len(near))[:_MOST_POINTS]]
    centres = np.array([view.centre_in_world for view in views])
    thickness = _THICKNESS * aim.reach
    planes = _candidates(sample, centres, draw)
    if planes is None:
        return None
    blocks = np.array_split(planes, -(-len(planes) // _BLOCK))
    on = np.concatenate([_standing_on(block, sample, thickness) for block in blocks])
    best = planes[int(np.argmax(on))]
    floor = _refined(Plane(best[:3], float(best[3])), near, thickness)
    return floor if _is_floor(floor, near, centres, aim, thickness) else None


def _standing_on(
    planes: Float64[np.ndarray, "k 4"], sample: Points3, thickness: float
) -> Int64[np.ndarray, " k"]:
    """Number of inliers of each plane; zero where too many points lie below it."""
    heights = sample @ planes[:, :3].T - planes[:, 3]
    on = (np.abs(heights) < thickness).sum(0)
    below = (heights < -3 * thickness).sum(0)
    return np.where(below > MOST_BELOW * len(sample), 0, on)


def _candidates(
    sample: Points3, centres: Float64[np.ndarray, "photos 3"], draw: np.random.Generator
) -> np.ndarray | None:
    """Rows normal, height of planes through three points with all cameras above them."""
    a, b, c = (sample[draw.integers(len(sample), size=_TRIALS)] for _ in range(3))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    proper = sizes > 1e-12 * np.maximum(sizes.max(), 1e-300)
    normals, a = normals[proper] / sizes[proper, None], a[proper]
    heights = np.einsum("nk,nk->n", normals, a)
    flip = np.where(centres.mean(0) @ normals.T < heights, -1.0, 1.0)
    one_side = np.ones(len(normals), bool)
    for centre in centres:
        one_side &= (centre @ normals.T - heights) * flip > 0
    planes = np.column_stack([normals, heights]) * flip[:, None]
    return planes[one_side] if one_side.any() else None


def _refined(plane: Plane, points: Points3, thickness: float) -> Plane:
    """Least squares over the plane's own points, twice."""
    for _ in range(2):
        on = points[np.abs(plane.above(points)) < thickness]
        if len(on) < 3:
            return plane
        middle = on.mean(0)
        normal = np.linalg.svd(on - middle, full_matrices=False)[2][2]
        normal = normal * np.sign(normal @ plane.normal)
        plane = Plane(normal, float(normal @ middle))
    return plane


def _is_floor(
    plane: Plane,
    points: Points3,
    centres: Float64[np.ndarray, "photos 3"],
    aim: Aim,
    thickness: float,
) -> bool:
    heights = plane.above(points)
    on = points[np.abs(heights) < thickness]
    if len(on) < max(_LEAST_POINTS, _LEAST_SHARE * len(points)):
        return False
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(on.T))[1])
    return bool(
        spread > _LEAST_SPREAD * aim.reach
        and np.mean(heights < -3 * thickness) <= MOST_BELOW
        and np.mean(heights > 5 * thickness) >= _LEAST_ABOVE
        and plane.above(aim.point[None])[0] > 0
        and np.all(plane.above(centres) > 0)
    )


_AGREEING = 0.5
"""Length of the mean of unit vectors above which they count as one direction."""


_UP = np.array([[0.0, -1.0], [-1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
"""Direction in the stored picture that is up, by the clockwise quarter turns that show it
upright."""


def common_up(views: Sequence[View], aim: Aim, quarter_turns: Sequence[int] = ()) -> Vector3:
    """Up in the photos where they agree; otherwise the axis that the cameras go round.

    A ring of photos taken with the camera turned on its side has no common up in the stored
    pictures: then it is the normal of the cameras' plane, on the side that is up as they were held;
    where that is not known, on the side where the cameras look down from.

    Args:
        quarter_turns: By view, the clockwise quarter turns that show its picture upright; none: all
            are stored so.
    """
    stored = _mean_up(views, [0] * len(views))
    held = _mean_up(views, quarter_turns) if quarter_turns else stored
    agrees = bool(np.linalg.norm(held) > _AGREEING)
    if agrees and np.linalg.norm(stored) > _AGREEING:
        return held / np.linalg.norm(held)
    centres = np.array([view.centre_in_world for view in views])
    normal = np.linalg.svd(centres - centres.mean(0))[2][2]
    side = held if agrees else centres.mean(0) - aim.point
    return normal if float(normal @ side) >= 0 else -normal


def _mean_up(views: Sequence[View], quarter_turns: Sequence[int]) -> Vector3:
    """Mean of the directions that are up in the pictures, in the world."""
    ups = [
        _UP[turns] @ view.camera_from_world.rotation[:2]
        for view, turns in zip(views, quarter_turns, strict=True)
    ]
    return np.mean(ups, axis=0)


def rotation_to_z(up: Vector3) -> Matrix3:
    """The shortest rotation that takes the unit vector `up` to +Z."""
    z = np.array([0.0, 0.0, 1.0])
    if up[2] < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    v = np.cross(up, z)
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + skew + skew @ skew / (1 + up[2])


def centre_of_object(points_in_world: Points3, aim: Aim) -> Vector3:
    """Median of the points near the aim."""
    near = np.linalg.norm(points_in_world - aim.point, axis=1) < aim.reach
    return np.median(points_in_world[near], axis=0) if near.any() else aim.point
