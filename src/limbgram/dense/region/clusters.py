"""Clusters: sparse points that belong to one surface, told by their own spacing."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int32
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from limbgram.errors import RegionError
from limbgram.geometry.arrays import Points3
from limbgram.scale.sight import Aim

_NEIGHBOURS = 6
_LINK_FACTOR = 3.0
"""Points are linked up to this many times their median distance to the sixth neighbour."""
_ATTACH_FACTOR = 2.0
"""Points this many links from the limb and from each other belong to it: thinly covered parts."""
_COMPANY = 3
"""Other thinly spread points that such a point needs round it."""
_WIDENINGS = (1.0, 2.0, 4.0)
_LEAST_LINK = 0.04
"""Gaps narrower than this share of the reach part nothing, however densely points lie."""
_MOST_LINK = 0.15
"""Longest link over a gap, in half frames."""
_RIVAL_SHARE = 0.6
"""A second object of this share of the first one's weight makes the choice a guess."""


@dataclass(frozen=True)
class LimbPoints:
    """Sparse points of the limb, and the gap over which they are one object."""

    points_mm: Points3
    link_mm: float


def link_length(points: Points3) -> float:
    """How far apart neighbours on one surface are, by the points' own spacing."""
    distances = KDTree(points).query(points, k=_NEIGHBOURS + 1)[0]
    return _LINK_FACTOR * float(np.median(distances[:, -1]))


def limb_among(points: Points3, aim: Aim, least_points: int) -> LimbPoints:
    """The points of the object that the cameras aim at.

    Where two parts of like weight lie apart, points are linked over wider gaps before the choice
    is called a guess: an object may be painted thinly in its middle.
    """
    spacing = max(link_length(points), _LEAST_LINK * aim.reach)
    aside = np.linalg.norm(points - aim.point, axis=1) / aim.reach
    weights = np.exp(-2 * aside**2)
    choice = None
    for widening in _WIDENINGS:
        link_mm = min(widening * spacing, max(spacing, _MOST_LINK * aim.reach))
        choice = _choose(points, weights, link_mm)
        if choice.rival_share <= _RIVAL_SHARE * choice.share:
            break
    if choice is None or choice.share == 0.0:
        raise RegionError(
            "The scene points are scattered and form no object. Photograph with more overlap, "
            "or give a box or photo masks."
        )
    if choice.rival_share > _RIVAL_SHARE * choice.share:
        raise RegionError(
            f"Two objects could be the limb: they hold {choice.share:.0%} and "
            f"{choice.rival_share:.0%} of the {len(points)} scene points where the cameras look. "
            "If the limb is plain, its surroundings were found instead: paint the sock with dense, "
            "irregular spots and photograph again. Otherwise remove the other object, or give a "
            "box or photo masks."
        )
    if choice.limb.sum() < least_points:
        raise RegionError(
            f"The object where the cameras look has only {choice.limb.sum()} points; "
            f"{least_points} are needed. Paint it more densely, come closer, or give a box or "
            "photo masks."
        )
    return LimbPoints(points[choice.limb], choice.link_mm)


@dataclass(frozen=True)
class _Choice:
    limb: Bool[np.ndarray, " n"]
    link_mm: float
    share: float
    """Of all clusters' weight: what the limb's own cluster has."""
    rival_share: float
    """The same for the heaviest cluster of which most lies apart from the limb."""


def _choose(points: Points3, weights: Float64[np.ndarray, " n"], link_mm: float) -> _Choice:
    """The heaviest cluster with its thin parts, and how heavy the next one is."""
    labels = clusters(points, link_mm)
    member = labels >= 0
    if not member.any():
        return _Choice(member, link_mm, 0.0, 0.0)
    shares = np.bincount(labels[member], weights[member]) / weights[member].sum()
    best = int(np.argmax(shares))
    limb = _with_thin_parts(points, labels == best, _ATTACH_FACTOR * link_mm)
    sizes = np.bincount(labels[member])
    attached = np.bincount(labels[member & limb], minlength=len(sizes)) > sizes / 2
    rival_share = float(np.where(attached, 0.0, shares).max())
    return _Choice(limb, link_mm, float(shares[best]), rival_share)


def clusters(points: Points3, link_mm: float) -> Int32[np.ndarray, " n"]:
    """Cluster of each point, -1 for stray ones: DBSCAN (Ester et al. 1996)."""
    crowd = np.asarray(KDTree(points).query_ball_point(points, link_mm, return_length=True))
    dense = np.flatnonzero(crowd > _NEIGHBOURS)
    labels = np.full(len(points), -1, np.int32)
    if not len(dense):
        return labels
    pairs = KDTree(points[dense]).query_pairs(link_mm, output_type="ndarray")
    ones = np.ones(len(pairs), np.int8)
    graph = sparse.coo_array((ones, (pairs[:, 0], pairs[:, 1])), (len(dense), len(dense)))
    labels[dense] = csgraph.connected_components(graph, directed=False)[1]
    return labels


def _with_thin_parts(
    points: Points3, limb: Bool[np.ndarray, " n"], reach_mm: float
) -> Bool[np.ndarray, " n"]:
    """The limb and what lies near it in company; a stray point has none of its own kind."""
    others = np.flatnonzero(~limb)
    if not len(others):
        return limb
    near = others[KDTree(points[limb]).query(points[others])[0] <= reach_mm]
    crowd = KDTree(points[others]).query_ball_point(points[near], reach_mm, return_length=True)
    attached = limb.copy()
    attached[near[np.asarray(crowd) > _COMPANY]] = True
    return attached
