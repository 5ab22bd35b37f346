"""Limb groups: photos of one scene that share nothing of the limb with its other photos.

In      photos, features, all matches and the scene that they were placed in, cameras.
Out     LimbGroups: two or more groups of photos that stand at neighbouring places of the scene and
        show no common point of the limb; none where all hang together.
Method  Board, floor and room join photos of two casts, or of one that was turned beside them, into
        one scene in which two shapes lie through each other. Scene points in the region of the
        limb link photos that see them; photos so linked form groups. Within a group nearly all
        photos that stand next to each other share a good part of their points. If photos of two
        groups stand as near to each other, and none of them share any, the chance of that follows
        from how often neighbours within a group do not.
        A limb that only shifted looks the same: its matches contradict the scene. So the matches
        on the limb that the scene does not explain are asked: if they give neighbours of two groups
        a geometry of their own that turns as the scene does, the limb moved a little, which
        `movement` tells; the groups are one.
Fails   never: a limb that cannot be told from its surroundings has no groups.
Limits  Rounds at two heights that share no point stand farther apart than neighbours do.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.sparse import coo_array

from limbgram.core.errors import RegionError
from limbgram.core.geometry.frames import angle_between_deg
from limbgram.core.geometry.triangulation import sampson_px
from limbgram.core.mesh.topology import components
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.dense.region import Region, find_region, footprint
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.verdicts import solved_lenses
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.reconstruction.twoview.essential import fundamental_from_pose, undistorted
from limbgram.reconstruction.twoview.verification import verify_pair

_FEWEST_PHOTOS = 4
"""Of a group."""
_FEWEST_POINTS = 30
"""Of the limb, that a photo must show to be asked."""
_SHARED = 0.05
"""Of the points of the photo that shows fewer: neighbours on one limb share 0.4 to 0.8, those of
two limbs 0.00 to 0.04, as a match may err and some points of the floor count as the limb's;"""
_FEWEST_SHARED = 10
"""and so many points at least."""
_BESIDE = 1.25
"""Neighbours stand no farther apart than so many times the usual step of the walk,"""
_WIDEST_DEG = 45.0
"""and no farther than this, seen from the limb;"""
_ACROSS_DEG = 30.0
"""and those of two groups no farther than this: a round from the side and one from above, 40
degrees higher, may share nothing of one limb."""
_FALSE_ALARM = 1e-6
"""Chance that photos of one limb look so. Of neighbours of one group 19 in 20 or more share points,
so that five or six pairs of neighbours across suffice."""
_FACING = 0.5
"""Share of the smaller group that has neighbours in the other: the halves of a ring that paint does
not join meet at their ends alone."""
_EXPLAINED_PX = 3.0
"""Matches this near to the scene's epipolar lines may lie beside the limb."""
_TURNED_DEG = 20.0
"""Turn against the scene from which a limb was turned and did not just shift."""
_MOVED = 0.25
"""Share of the neighbours across that must tell of a shift."""


@dataclass(frozen=True)
class LimbGroups:
    """Photos by what they share of the limb, most of them first; empty where all hang together."""

    photos: tuple[tuple[int, ...], ...] = ()


def limb_groups(
    photos: PhotoSet, features: Features, matches: Matches, scene: Scene, cameras: Cameras
) -> LimbGroups:
    """The groups of a scene in which the limb stands twice."""
    metric = to_millimetres(scene)
    try:
        region = find_region(photos, metric)
    except RegionError:
        return LimbGroups()
    links = _links(metric, region)
    groups = _linked(links)
    if len(groups) < 2:
        return LimbGroups()
    first, *others = groups
    apart = [first]
    for group in others:
        across = _neighbours_across(links, first, group)
        if len(across) and not _only_shifted(
            across, features, matches, metric, region, cameras, photos
        ):
            apart.append(group)
    if len(apart) < 2:
        return LimbGroups()
    return LimbGroups(tuple(tuple(scene.placed[k] for k in group) for group in apart))


@dataclass(frozen=True)
class _Links:
    """By pair of placed photos; photos that show too little of the limb are linked to none."""

    asked: Bool[np.ndarray, " p"]
    shared: Bool[np.ndarray, "p p"]
    """Whether both show a good part of the same points of the limb."""
    apart_deg: Float64[np.ndarray, "p p"]
    """Between their centres, seen from the limb."""


def _links(metric: MetricScene, region: Region) -> _Links:
    scene = metric.scene
    seen, on_limb = scene.observations, region.contains(scene.points_in_world)
    rank = np.full(len(scene.names), -1)
    rank[list(scene.placed)] = np.arange(len(scene.placed))
    kept = on_limb[seen.point_idx] & (rank[seen.photo_idx] >= 0)
    ones = np.ones(int(kept.sum()))
    shape = (len(scene.points_in_world), len(scene.placed))
    shows = coo_array((ones, (seen.point_idx[kept], rank[seen.photo_idx[kept]])), shape).tocsr()
    shows.data[:] = 1.0  # a point may be seen twice in a photo
    common = (shows.T @ shows).toarray()
    points = np.diag(common)
    fewer = np.maximum(np.minimum.outer(points, points), 1.0)
    aim = aim_of(scene.views, scene.points_in_world)
    rays = np.array([view.centre_in_world - aim.point for view in scene.views])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    apart_deg = np.degrees(np.arccos(np.clip(rays @ rays.T, -1.0, 1.0)))
    shared = (common > _SHARED * fewer) & (common >= _FEWEST_SHARED)
    return _Links(points >= _FEWEST_POINTS, shared, apart_deg)


def _linked(links: _Links) -> list[Int64[np.ndarray, " n"]]:
    """Ranks of the photos of each sizeable group, the largest first."""
    edges = links.shared & links.asked & links.asked[:, None]
    label = components(np.argwhere(edges), len(edges))
    groups = [np.flatnonzero((label == k) & links.asked) for k in np.unique(label)]
    groups = [one for one in groups if len(one) >= _FEWEST_PHOTOS]
    return sorted(groups, key=lambda one: (-len(one), int(one[0])))


def _neighbours_across(
    links: _Links, first: Int64[np.ndarray, " n"], second: Int64[np.ndarray, " m"]
) -> Int64[np.ndarray, "k 2"]:
    """Pairs of neighbours of two groups where it cannot be chance that none share a point."""
    nothing = np.zeros((0, 2), np.int64)
    steps = [_next_deg(links.apart_deg[np.ix_(one, one)]) for one in (first, second)]
    near_deg = min(_BESIDE * float(np.median(np.concatenate(steps))), _WIDEST_DEG)
    within, sharing = 0, 0
    for one in (first, second):
        rows, columns = np.triu_indices(len(one), 1)
        pairs = one[rows], one[columns]
        beside = links.apart_deg[pairs] < near_deg
        within += int(beside.sum())
        sharing += int(links.shared[pairs][beside].sum())
    beside = links.apart_deg[np.ix_(first, second)] < min(near_deg, _ACROSS_DEG)
    smaller = beside.any(axis=0) if len(second) <= len(first) else beside.any(axis=1)
    if smaller.mean() < _FACING:
        return nothing
    lonely = 1.0 - (sharing + 0.5) / (within + 1.0)
    if lonely ** beside.sum() > _FALSE_ALARM:
        return nothing
    row, column = np.nonzero(beside)
    return np.column_stack([first[row], second[column]])


def _next_deg(apart_deg: Float64[np.ndarray, "n n"]) -> Float64[np.ndarray, " n"]:
    """How far the nearest other photo of a group stands."""
    return (apart_deg + np.diag(np.full(len(apart_deg), np.inf))).min(axis=1)


def _only_shifted(
    across: Int64[np.ndarray, "k 2"],
    features: Features,
    matches: Matches,
    metric: MetricScene,
    region: Region,
    cameras: Cameras,
    photos: PhotoSet,
) -> bool:
    """Whether neighbours of two groups show one limb that moved a little between them."""
    scene = metric.scene
    lenses = solved_lenses(scene, cameras).calibrations
    by_photos = {(pair.first, pair.second): pair for pair in matches.pairs}
    shifted = 0
    for ranks in across:
        first, second = sorted(scene.placed[k] for k in ranks)
        pair = by_photos.get((first, second))
        if pair is None:
            continue
        left = _unexplained(pair, features, metric, region)
        ours, theirs = (lenses[photos.photos[k].camera_idx] for k in (first, second))
        found = verify_pair(left, ours, theirs)
        if found is None or found.second_from_first is None:
            continue
        placed = [scene.view(k).camera_from_world for k in (first, second)]
        turn = placed[1].rotation @ placed[0].rotation.T
        shifted += angle_between_deg(turn, found.second_from_first.rotation) < _TURNED_DEG
    return shifted > _MOVED * len(across)


def _unexplained(
    pair: PairMatches, features: Features, metric: MetricScene, region: Region
) -> PairMatches:
    """Matches on the limb that contradict the scene."""
    views = [metric.scene.view(photo) for photo in (pair.first, pair.second)]
    on_limb = [
        footprint(region, view).shows(features.keypoints[photo].xy_px)[ends]
        for view, photo, ends in zip(views, (pair.first, pair.second), pair.keypoint_idx.T)
    ]
    poses = [view.camera_from_world for view in views]
    straight = [
        undistorted(view.camera, xy_px)
        for view, xy_px in zip(views, (pair.xy_first_px, pair.xy_second_px))
    ]
    fundamental = fundamental_from_pose(
        poses[1] @ poses[0].inverse, views[0].camera.matrix, views[1].camera.matrix
    )
    off_px = np.abs(sampson_px(fundamental, *straight))
    return pair.some(on_limb[0] & on_limb[1] & ~(off_px < _EXPLAINED_PX))
