"""Full-resolution tracks: scene points measured anew in every photo that sees them.

In      photos, a Scene placed by keypoints of reduced photos, the cameras' calibrations.
Out     the Scene of fewer, longer and more accurate tracks, adjusted.
Method  The photo that sees a point most squarely is its reference. The plane through the point's
        neighbours in the scene gives its normal; normal and poses give the affine map of a window
        to every other photo that looks at the point within a limiting angle. From there least-
        squares matching at full resolution measures the point (windows.follow_all). In the
        reference its position is given by definition: what the noise of its window shifts there is
        common to the track, as the noise of any one observation is. The adjustment then takes these
        observations alone.
        Keypoints of photos reduced to 0.6 MP cost a third of those at 4 MP, and followed they place
        the photos as well (docs/method/speed.md).
Fails   PlacementError: hardly a photo shows the points. A photo that shows few loses its pose.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.spatial import KDTree

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, View, differentiate_all
from limbgram.core.run import in_parallel
from limbgram.findings import fault
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.features.detection import spread_selection
from limbgram.reconstruction.mapping.placement import (
    MIN_PHOTO_POINTS,
    MIN_PLACED,
    MappingOptions,
    readjusted,
    without_photos,
)
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.matching.matching import PairMemory
from limbgram.reconstruction.matching.windows import Pyramid, build_pyramid, follow
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.photo import PhotoSet

_NEIGHBOURS = 12
"""Points whose best-fit plane approximates the surface."""
_FEWEST_RAYS = 2


_MAX_ANGLE_DEG = 65.0
"""Widest angle between a ray and the surface's normal."""
_MAX_TURN_DEG = 60.0
"""Widest angle between a ray and the reference's."""
_FINEST_MEGAPIXELS = 4.0
"""Photos are halved for the windows while they stay larger than about this."""
_MAX_SEARCHES = 100_000
"""Point and photo pairs that are searched at most; more improve little."""
_MEMORY_MB = 400.0
"""Memory for the photos of the pairs that are matched at a time."""


@dataclass(frozen=True, kw_only=True)
class FollowingOptions:
    """How many points are searched, and how the result is adjusted."""

    tries_a_photo: tuple[int, int] = (1500, 4000)
    """Points that are searched in a photo on average: at least, and at most."""
    mapping: MappingOptions = field(default_factory=MappingOptions)
    """How the result is adjusted."""


DEFAULTS = FollowingOptions()


def follow_points(
    photos: PhotoSet, scene: Scene, cameras: Cameras, options: FollowingOptions = DEFAULTS
) -> Scene:
    """The scene with its points measured in all photos that should show them, and adjusted.

    Raises:
        PlacementError: fewer photos than make a scene show its points.
    """
    found = _followed(photos, scene, options)
    shown = np.bincount(found.observations.photo_idx, minlength=len(scene.names))
    weak = {photo for photo in scene.placed if shown[photo] < MIN_PHOTO_POINTS}
    if len(scene.placed) - len(weak) < MIN_PLACED:
        raise PlacementError("placing.unsharp", weak=len(weak), placed=len(scene.placed))
    verdicts = tuple(
        replace(
            one, placed=False, reason=fault("placing.photo.unfollowed", points=int(shown[photo]))
        )
        if photo in weak
        else one
        for photo, one in enumerate(scene.verdicts)
    )
    firm = _without_single_rays(replace(without_photos(found, weak), verdicts=verdicts))
    return readjusted(firm, cameras, options.mapping)


def _followed(photos: PhotoSet, scene: Scene, options: FollowingOptions) -> Scene:
    """The scene with new observations, not yet adjusted."""
    placed, views = np.array(scene.placed), scene.views
    points = _SurfacePoints.of(scene).thinned(scene, options)
    halvings = _halvings(photos, _FINEST_MEGAPIXELS)
    size = 2.0**halvings
    memory = PairMemory.of(photos, _MEMORY_MB, halvings=halvings)

    @lru_cache(maxsize=memory.photos)
    def prepared(view: int) -> Pyramid:
        return build_pyramid(load_luma(photos.photos[placed[view]], halvings))

    def one(pair: tuple[int, int]) -> _Measured:
        rows = np.flatnonzero((points.reference == pair[0]) & points.expected_in[:, pair[1]])
        expected = points.expected(rows, views[pair[0]], views[pair[1]])
        expected[:, [0, 3]] = (expected[:, [0, 3]] + 0.5) / size - 0.5
        xy_px = (points.xy_px[rows] + 0.5) / size - 0.5
        result = follow(prepared(pair[0]), prepared(pair[1]), xy_px, expected)
        good = np.isfinite(result[:, 2])
        xy_px = (result[good, :2] + 0.5) * size - 0.5
        return _Measured(np.full(int(good.sum()), pair[1]), rows[good], xy_px)

    own = _Measured(points.reference, np.arange(len(points.places)), points.xy_px)
    found = [own, *in_parallel(one, points.pairs(), memory.workers)]
    point = np.concatenate([part.point for part in found])
    photo = placed[np.concatenate([part.view for part in found])]
    order = np.lexsort((photo, point))
    seen = Observations(
        photo[order].astype(np.int32),
        point[order].astype(np.int32),
        np.concatenate([part.xy_px for part in found])[order],
    )
    return _without_single_rays(replace(scene, points_in_world=points.places, observations=seen))


@dataclass(frozen=True)
class _Measured:
    """Point point[k] was measured in view view[k] at xy_px[k]."""

    view: Int64[np.ndarray, " m"]
    point: Int64[np.ndarray, " m"]
    xy_px: Float64[np.ndarray, "m 2"]


@dataclass(frozen=True)
class _SurfacePoints:
    """Points with surface normals, reference views, and the other views that should show them."""

    places: Points3
    tangents: Float64[np.ndarray, "n 3 2"]
    """Two tangent directions of the surface."""
    reference: Int64[np.ndarray, " n"]
    """Index of the reference among the placed photos."""
    xy_px: Points2
    """In the reference."""
    expected_in: Bool[np.ndarray, "n views"]
    rays: Int64[np.ndarray, " n"]
    """Number of observations in the scene."""

    @classmethod
    def of(cls, scene: Scene) -> "_SurfacePoints":
        points, seen = scene.points_in_world, scene.observations
        view_idx = np.full(len(scene.names), -1)
        view_idx[list(scene.placed)] = np.arange(len(scene.placed))
        view = view_idx[seen.photo_idx]
        toward = np.array([one.centre_in_world for one in scene.views])[None] - points[:, None]
        toward /= np.linalg.norm(toward, axis=2, keepdims=True)
        observed = toward[seen.point_idx, view]
        normals = _normals(points)
        side = (observed * normals[seen.point_idx]).sum(1)
        normals[np.bincount(seen.point_idx, side, len(points)) < 0] *= -1.0

        squarely = (observed * normals[seen.point_idx]).sum(1)
        order = np.lexsort((view, -squarely, seen.point_idx))
        first = order[np.searchsorted(seen.point_idx[order], np.arange(len(points)))]
        every, reference = np.arange(len(points)), view[first]
        facing = np.einsum("nvi,ni->nv", toward, normals)
        turned = np.einsum("nvi,ni->nv", toward, toward[every, reference])
        expected_in = facing > np.cos(np.radians(_MAX_ANGLE_DEG))
        expected_in &= turned > np.cos(np.radians(_MAX_TURN_DEG))
        expected_in[seen.point_idx, view] = True
        expected_in[every, reference] = False
        return cls(
            places=points,
            tangents=_tangents(normals),
            reference=reference,
            xy_px=seen.xy_px[first],
            expected_in=expected_in,
            rays=np.bincount(seen.point_idx, minlength=len(points)),
        )

    def thinned(self, scene: Scene, options: FollowingOptions) -> "_SurfacePoints":
        """A subset within the limit of searches, spread evenly over each reference."""
        views = scene.views
        each = np.clip(_MAX_SEARCHES / len(views), *options.tries_a_photo)
        share = float(each) * len(views) / max(int(self.expected_in.sum()), 1)
        if share >= 1.0:
            return self
        # ties are broken at random, not from the top of the photo downwards
        strength = (self.rays + np.random.default_rng(0).random(len(self.rays))).astype(np.float32)
        kept: list[Int64[np.ndarray, " k"]] = []
        for view, one in enumerate(views):
            own = np.flatnonzero(self.reference == view)
            side_px = max(one.camera.width_px, one.camera.height_px)
            xy_px = np.clip(self.xy_px[own], 0.0, side_px - 1.0).astype(np.float32)
            chosen = spread_selection(xy_px, strength[own], side_px, int(np.ceil(share * len(own))))
            kept.append(np.sort(own[chosen]))
        rows = np.concatenate(kept)
        return _SurfacePoints(
            self.places[rows],
            self.tangents[rows],
            self.reference[rows],
            self.xy_px[rows],
            self.expected_in[rows],
            self.rays[rows],
        )

    def pairs(self) -> list[tuple[int, int]]:
        """Pairs of a reference and a view in which some of its points are expected."""
        count = self.expected_in.shape[1]
        return [
            (first, second)
            for first in range(count)
            for second in np.flatnonzero(self.expected_in[self.reference == first].any(0)).tolist()
        ]

    def expected(
        self, rows: Int64[np.ndarray, " k"], reference: View, other: View
    ) -> Float64[np.ndarray, "k 6"]:
        """Affine maps of windows around the points of one reference into another view."""
        places = np.ascontiguousarray(self.places[rows])
        here, there = (
            _pixels_by_point(view, places) @ self.tangents[rows] for view in (reference, other)
        )
        maps = there @ np.linalg.inv(here)
        off = self.xy_px[rows] - reference.project(places)
        start = other.project(places) + np.einsum("nij,nj->ni", maps, off)
        return np.column_stack([start[:, 0], maps[:, 0], start[:, 1], maps[:, 1]])


def _normals(points: Points3) -> Points3:
    """Normals of robust best-fit planes through each point's neighbours."""
    tree = KDTree(points)
    near = points[tree.query(points, k=min(_NEIGHBOURS, len(points)))[1]]
    near = near - np.median(near, axis=1, keepdims=True)
    away = np.linalg.norm(near, axis=2)
    near /= np.maximum(np.maximum(away, np.median(away, axis=1, keepdims=True)), 1e-12)[..., None]
    return np.linalg.eigh(np.einsum("nki,nkj->nij", near, near)).eigenvectors[:, :, 0]


def _tangents(normals: Points3) -> Float64[np.ndarray, "n 3 2"]:
    """Two orthonormal directions across each normal."""
    aside = np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=2)


def _pixels_by_point(view: View, points: Points3) -> Float64[np.ndarray, "n 2 3"]:
    """Jacobian of the pixels by the points."""
    by_point = np.zeros((len(points), 2, 3))
    by_pose, by_lens = np.zeros((len(points), 2, POSE_SIZE)), np.zeros((len(points), 2, LENS_SIZE))
    differentiate_all(view.packed, points, by_point, by_pose, by_lens)
    return by_point


def _halvings(photos: PhotoSet, megapixels: float) -> int:
    """How often photos are halved for the windows."""
    pixels = max(photo.width_px * photo.height_px for photo in photos.photos)
    return max(0, round(0.5 * float(np.log2(pixels / (megapixels * 1e6)))))


def _without_single_rays(scene: Scene) -> Scene:
    """The scene without points that one photo alone shows."""
    seen = scene.observations
    enough = np.bincount(seen.point_idx, minlength=len(scene.points_in_world)) >= _FEWEST_RAYS
    keep = enough[seen.point_idx]
    number = (np.cumsum(enough) - 1).astype(np.int32)
    return replace(
        scene,
        points_in_world=scene.points_in_world[enough],
        observations=Observations(
            seen.photo_idx[keep], number[seen.point_idx[keep]], seen.xy_px[keep]
        ),
    )
