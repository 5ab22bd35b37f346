"""Clusters: sparse points that belong to one surface, told by their own spacing."""

import numpy as np
from jaxtyping import Bool, Int32
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
_RIVAL_SHARE = 0.6
"""A second object of this share of the first one's weight makes the choice a guess."""


def link_length(points: Points3) -> float:
    """How far apart neighbours on one surface are, by the points' own spacing."""
    distances = KDTree(points).query(points, k=_NEIGHBOURS + 1)[0]
    return _LINK_FACTOR * float(np.median(distances[:, -1]))


def crowded(points: Points3) -> Points3:
    """The points without stray ones."""
    kept = clusters(points, link_length(points)) >= 0
    return points[kept] if kept.any() else points


def limb_among(points: Points3, aim: Aim, least_points: int) -> Points3:
    """The points of the object that the cameras aim at."""
    link_mm = link_length(points)
    labels = clusters(points, link_mm)
    member = labels >= 0
    if not member.any():
        raise RegionError(
            "The scene points are scattered and form no object. Photograph with more overlap, "
            "or give a box or photo masks."
        )
    aside = np.linalg.norm(points - aim.point, axis=1) / aim.reach
    weights = np.bincount(labels[member], np.exp(-2 * aside[member] ** 2))
    best = int(np.argmax(weights))
    limb = _with_thin_parts(points, labels == best, _ATTACH_FACTOR * link_mm)
    _check_rivals(labels, weights, best, limb)
    if limb.sum() < least_points:
        raise RegionError(
            f"The object where the cameras look has only {limb.sum()} points; {least_points} "
            "are needed. Paint it more densely, come closer, or give a box or photo masks."
        )
    return points[limb]


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


def _check_rivals(
    labels: Int32[np.ndarray, " n"],
    weights: np.ndarray,
    best: int,
    limb: Bool[np.ndarray, " n"],
) -> None:
    """Refuse where another object, most of it away from the limb, could as well be meant."""
    member = labels >= 0
    sizes = np.bincount(labels[member])
    attached = np.bincount(labels[member & limb], minlength=len(sizes)) > sizes / 2
    rivals = np.where(attached, 0.0, weights)
    if rivals.max() > _RIVAL_SHARE * weights[best]:
        shares = weights / weights.sum()
        raise RegionError(
            f"Two objects could be the limb: they hold {shares[best]:.0%} and "
            f"{shares[np.argmax(rivals)]:.0%} of the points where the cameras look. Remove the "
            "other object, or give a box or photo masks."
        )
