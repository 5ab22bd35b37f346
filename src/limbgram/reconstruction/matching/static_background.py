"""Static background: detection of what stands still behind a turning object.

In      Features of all photos.
Out     StaticBackground: groups of photos that one still camera took, and which keypoints of each
        stand still.
Method  Two keypoints of two photos coincide if they lie at the same pixel and look alike: the same
        scale, direction and descriptor. Photos of which many of the largest keypoints coincide were
        taken by a still camera, up to a small shift and growth that all share (a tripod that was
        touched, a stabiliser; a focus found anew). Where these move it far, what coincides lies all
        over the picture: a patch of it is moved alike by many a walk. A photo that coincides with
        most of such a group belongs to it all the same.
        Such photos are believed to show a turning object only if there are at least four of them
        and if other keypoints of theirs match with a movement; photos of a limb and a camera that
        both stood still, or one photo twice, are left alone. What moves the picture of each photo
        of a group is found in least squares over all its pairs. Once that is undone, a keypoint
        stands still if it coincides with keypoints of two or more of six other photos, spread over
        the group; and so does a match whose ends lie at the same pixel.
        A walk round a limb has no such photos, and all of its keypoints are kept.
Fails   MatchingError: one still camera took all photos, and nothing in them moves.

What stands still is the room behind a turntable or a stool, or before it; dirt on the sensor; a
watermark. Matches of it are right and tell nothing of the object, and they outnumber the object's
where that is thinly painted: pairs would be chosen by them, and RANSAC would prefer them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int64
from scipy import sparse
from scipy.spatial import KDTree

from limbgram.core.errors import MatchingError
from limbgram.core.geometry.arrays import Points2, Vector2
from limbgram.core.mesh.topology import components
from limbgram.findings import Finding, note
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.matching.descriptors import comparable, match_descriptors
from limbgram.reconstruction.matching.matching import Matches, PairMatches

_DETECTION_TOLERANCE = 0.3
"""Largest distance between two detections of a feature that stands still, in its own scales."""
_LEAST_PX = 1.0
"""Such a distance that is accepted at any scale."""
_SAME_ANGLE_DEG = 20.0
_SAME_SCALE = 1.3
_SAME_DESCRIPTOR = 0.9
"""Smallest product of unit descriptors of the same feature: in two photos it is 0.93 to 0.99."""
_MATCH_RATIO = 0.8


_MOVE_SHARE = 0.01
"""Farthest that a still camera's picture moves, as a share of its longer side: a stabiliser shifts
single photos by a quarter of it (one sigma), and a focus found anew lets the picture grow by half
a per cent."""
_MOTION_SIZE = 3
"""Parameters of such a motion."""
_MOST_ROUNDS = 10
"""Of fitting a motion to its inliers; fewer once the inliers no longer change."""
_TOUCHED_SHARE = 0.002
"""Motion from which coinciding keypoints must lie all over the picture; dirt and watermarks need
not."""
_ALL_OVER = 0.1
"""Smallest standard deviation of coinciding keypoints across the picture, over its longer side."""
_MOST = 0.5
"""Share of a group with which a photo must coincide to belong to it, wherever in the picture."""
_LEAST_COINCIDING = 12
"""Fewest keypoints of the survey that coincide in two photos of a still camera."""
_LEAST_MOVING = 16
"""Fewest matches of other keypoints that moved."""
_LEAST_MOVE_SHARE = 0.005
"""Smallest such motion, as a share of the longer side."""
_PARTNERS = 6
"""Photos of its group with which each is compared."""
_LEAST_PARTNERS = 2
"""Fewest of them in which a keypoint that stands still is found again."""
_SURVEY_KEYPOINTS = 500
"""Number of the largest keypoints of each photo in the survey."""
_LEAST_PHOTOS = 4
"""Fewest photos in which a turning object is told from one photo taken twice."""


@dataclass(frozen=True)
class ImageMotion:
    """Motion of the image of the static background: shift and growth, to first order."""

    growth: float = 0.0
    """In parts of itself, from the corner where pixels count from."""
    shift_px: Vector2 = field(default_factory=lambda: np.zeros(2))

    def undone(self, xy_px: Points2) -> Points2:
        """Pixels with the motion undone."""
        return xy_px - self.shift_px - self.growth * xy_px


@dataclass(frozen=True, kw_only=True)
class StaticBackground:
    """Keypoints that stand still in photos of a turning object; none if the camera moved."""

    groups: tuple[tuple[int, ...], ...] = ()
    """Photos that one still camera took."""
    keypoints: tuple[Bool[np.ndarray, " n"], ...] = ()
    """Which keypoints of each photo stand still; empty where there are no groups."""
    moves: tuple["ImageMotion", ...] = ()
    """Of each photo, from the first of its group; empty where there are no groups."""

    @property
    def photos(self) -> tuple[int, ...]:
        """All photos of the groups."""
        return tuple(sorted(photo for group in self.groups for photo in group))

    @property
    def count(self) -> int:
        """Number of keypoints that stand still, in all photos."""
        return sum(int(flags.sum()) for flags in self.keypoints)

    @property
    def notes(self) -> tuple[Finding, ...]:
        """The finding that the camera stood still, and what was left out."""
        if not self.groups:
            return ()
        return (note("pairs.turned", photos=len(self.photos), points=self.count),)

    def moving(self, features: Features) -> Features:
        """The features without what stands still."""
        if not self.groups:
            return features
        return Features(
            tuple(
                one.some(~flags)
                for one, flags in zip(features.keypoints, self.keypoints, strict=True)
            )
        )

    def moving_matches(self, matches: Matches) -> Matches:
        """The matches without those whose ends lie at one place: the room, dust, a watermark.

        The few honest points that happen to lie in the same place are no loss, and a pair without
        any movement has no depth to give.
        """

        def moving(pair: PairMatches) -> PairMatches:
            here, there = pair.xy_first_px, pair.xy_second_px
            if self.moves:
                here = self.moves[pair.first].undone(here)
                there = self.moves[pair.second].undone(there)
            return pair.some(np.linalg.norm(there - here, axis=1) >= _LEAST_PX)

        return replace(matches, pairs=tuple(moving(pair) for pair in matches.pairs))


def find_still(features: Features) -> StaticBackground:
    """Keypoints that stand still in photos of a still camera.

    Raises:
        MatchingError: a still camera took all photos, and nothing moves in them.
    """
    side_px = max((float(one.xy_px.max()) for one in features.keypoints if len(one)), default=0.0)
    candidates = _groups(features, side_px)
    groups: list[tuple[int, ...]] = []
    flags = [np.zeros(len(one), bool) for one in features.keypoints]
    moves = [ImageMotion() for _ in features.keypoints]
    for group, moved in candidates:
        found = {photo: _standing(features, photo, moved, side_px) for photo in group}
        if _something_moves(features, group, found, side_px):
            groups.append(group)
            for photo, standing in found.items():
                flags[photo], moves[photo] = standing, moved[photo]
        elif len(group) == len(features.keypoints):
            raise MatchingError("pairs.same_picture", photos=len(group))
    if not groups:
        return StaticBackground()
    return StaticBackground(groups=tuple(groups), keypoints=tuple(flags), moves=tuple(moves))


@dataclass(frozen=True)
class _KeypointTable:
    """Keypoints of several photos, concatenated."""

    photo: Int64[np.ndarray, " n"]
    xy_px: Points2
    scale_px: Float32[np.ndarray, " n"]
    angle_deg: Float32[np.ndarray, " n"]
    descriptors: Float32[np.ndarray, "n 128"]

    @classmethod
    def of(
        cls, features: Features, photos: Sequence[int], most: int | None = None
    ) -> "_KeypointTable":
        kept = [features.keypoints[photo] for photo in photos]
        sizes = [len(one) if most is None else min(most, len(one)) for one in kept]
        pairs = list(zip(kept, sizes, strict=True))
        return cls(
            np.repeat(np.array(photos, np.int64), sizes),
            np.concatenate([one.xy_px[:size] for one, size in pairs]).astype(np.float64),
            np.concatenate([one.scale_px[:size] for one, size in pairs]),
            np.concatenate([one.angle_deg[:size] for one, size in pairs]),
            comparable(np.concatenate([one.descriptors[:size] for one, size in pairs])),
        )

    def alike(self, pairs: Int64[np.ndarray, "k 2"]) -> Bool[np.ndarray, " k"]:
        """Which pairs of keypoints look alike, in two different photos."""
        first, second = pairs.T
        turn = np.abs((self.angle_deg[first] - self.angle_deg[second] + 180.0) % 360.0 - 180.0)
        ratio = self.scale_px[first] / self.scale_px[second]
        good = (self.photo[first] != self.photo[second]) & (turn < _SAME_ANGLE_DEG)
        good &= (ratio < _SAME_SCALE) & (ratio > 1.0 / _SAME_SCALE)
        rows = np.flatnonzero(good)
        products = (self.descriptors[first[rows]] * self.descriptors[second[rows]]).sum(1)
        good[rows] = products > _SAME_DESCRIPTOR
        return good

    def near(self, reach_px: float) -> Int64[np.ndarray, "k 2"]:
        """Sorted pairs of keypoints that look alike, nearer to each other than this."""
        pairs = KDTree(self.xy_px).query_pairs(reach_px, output_type="ndarray").astype(np.int64)
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        return pairs[self.alike(pairs)]


class _Group(NamedTuple):
    """Photos of one still camera, and the image motion of each."""

    photos: tuple[int, ...]
    moves: dict[int, ImageMotion]


def _groups(features: Features, side_px: float) -> list[_Group]:
    """Groups of photos in which enough of the largest keypoints coincide."""
    count = len(features.keypoints)
    if not any(map(len, features.keypoints)):
        return []
    row = _KeypointTable.of(features, range(count), _SURVEY_KEYPOINTS)
    pairs = row.near(max(_LEAST_PX, _MOVE_SHARE * side_px))
    between = row.photo[pairs[:, 0]] * count + row.photo[pairs[:, 1]]
    joined, everywhere = list[Int64[np.ndarray, "k 2"]](), list[bool]()
    for code in np.unique(between):
        own = pairs[between == code]
        first, second = own.T
        reach_px = _reach(row.scale_px[first])
        together = own[_together(row.xy_px[first], row.xy_px[second], reach_px)]
        if len(together) < _LEAST_COINCIDING:
            continue
        here, there = row.xy_px[together.T]
        moved_px = float(np.median(np.linalg.norm(there - here, axis=1)))
        touched = moved_px < max(_LEAST_PX, _TOUCHED_SHARE * side_px)
        joined.append(together)
        everywhere.append(touched or _breadth(here) > _ALL_OVER * side_px)
    if not joined:
        return []
    ends = row.photo[np.array([one[0] for one in joined])]
    coinciding = np.concatenate(joined)
    return [
        _Group(group, _moves(group, row, coinciding[_inside(group, row.photo[coinciding])]))
        for group in _joined_photos(ends, np.array(everywhere), count)
    ]


def _inside(group: Sequence[int], ends: Int64[np.ndarray, "k 2"]) -> Bool[np.ndarray, " k"]:
    """Which pairs lie in a group."""
    return np.asarray(np.isin(ends, group).all(axis=1), np.bool_)


def _joined_photos(
    ends: Int64[np.ndarray, "k 2"],
    everywhere: Bool[np.ndarray, " k"],
    count: int,
) -> list[tuple[int, ...]]:
    """Groups of photos whose keypoints coincide all over the picture, or with most of a group.

    A room that shows keypoints in a part of the picture passes that test in some pairs and fails it
    in others. What coincides with most photos of one place was taken from there.

    Args:
        ends: Photos of the pairs that coincide anywhere.
        everywhere: Which of them do all over the picture.
    """
    linked = np.zeros((count, count), bool)
    linked[ends, ends[:, ::-1]] = True
    label = components(ends[everywhere], count)
    sizes = np.bincount(label)
    large = np.flatnonzero(sizes >= _LEAST_PHOTOS)
    share = np.array([linked[:, label == k].mean(axis=1) for k in large]).reshape(-1, count)
    for photo in np.flatnonzero(sizes[label] < _LEAST_PHOTOS).tolist():
        if len(large) and share[:, photo].max() > _MOST:
            label[photo] = large[np.argmax(share[:, photo])]
    return [tuple(np.flatnonzero(label == k).tolist()) for k in large.tolist()]


def _moves(
    group: tuple[int, ...], row: _KeypointTable, pairs: Int64[np.ndarray, "k 2"]
) -> dict[int, ImageMotion]:
    """Image motion of each photo from the first of its group, by coinciding keypoints."""
    here, there = row.xy_px[pairs.T]
    first, second = (_MOTION_SIZE * np.searchsorted(group, row.photo[ends]) for ends in pairs.T)
    size, rows = _MOTION_SIZE * len(group), np.arange(len(pairs))
    normal, right = np.zeros((size, size)), np.zeros(size)
    for axis in range(2):
        values = [there[:, axis], -here[:, axis], np.ones(len(pairs)), -np.ones(len(pairs))]
        columns = [second, first, second + 1 + axis, first + 1 + axis]
        design = sparse.coo_array(
            (np.concatenate(values), (np.tile(rows, 4), np.concatenate(columns))),
            (len(pairs), size),
        ).tocsr()
        normal += (design.T @ design).toarray()
        right += design.T @ (there - here)[:, axis]
    free = slice(_MOTION_SIZE, None)
    moved = np.linalg.solve(normal[free, free], right[free]).reshape(-1, _MOTION_SIZE)
    found = [ImageMotion(), *(ImageMotion(float(g), np.array([x, y])) for g, x, y in moved)]
    return dict(zip(group, found, strict=True))


def _together(
    here: Points2, there: Points2, reach_px: Float64[np.ndarray, " k"]
) -> Bool[np.ndarray, " k"]:
    """Inliers of the shift and growth of the image with most inliers.

    From the shift that most agree with, growth is found in least squares, again and again with all
    that agree by then.
    """
    moves = there - here
    tree = KDTree(moves)
    count = tree.query_ball_point(moves, reach_px, return_length=True)
    most = int(np.argmax(count))
    first = moves[tree.query_ball_point(moves[most], reach_px[most])]
    together = np.linalg.norm(moves - np.median(first, axis=0), axis=1) < reach_px
    for _ in range(_MOST_ROUNDS):
        if together.sum() < _LEAST_COINCIDING:
            break
        before, together = together, _explained(here, moves, together, reach_px)
        if np.array_equal(before, together):
            break
    return together


def _explained(
    here: Points2,
    moves: Float64[np.ndarray, "k 2"],
    own: Bool[np.ndarray, " k"],
    reach_px: Float64[np.ndarray, " k"],
) -> Bool[np.ndarray, " k"]:
    """Inliers of the least-squares shift and growth of some of the moves."""
    middle, shift = here[own].mean(axis=0), moves[own].mean(axis=0)
    off = here - middle
    growth = float((off[own] * moves[own]).sum()) / max(float((off[own] ** 2).sum()), _LEAST_PX)
    return np.linalg.norm(moves - shift - growth * off, axis=1) < reach_px


def _breadth(xy_px: Points2) -> float:
    """Standard deviation along the narrow side."""
    return float(np.sqrt(max(np.linalg.eigvalsh(np.cov(xy_px.T))[0], 0.0)))


def _reach(scale_px: Float32[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    return np.maximum(_LEAST_PX, _DETECTION_TOLERANCE * scale_px.astype(np.float64))


def _standing(
    features: Features,
    photo: int,
    moves: dict[int, ImageMotion],
    side_px: float,
) -> Bool[np.ndarray, " n"]:
    """Which keypoints of a photo are found again at their place in others of its group."""
    own = features.keypoints[photo]
    times = np.zeros(len(own), np.int64)
    for other in _partners(photo, [*moves], _PARTNERS):
        row = _KeypointTable.of(features, (photo, other))
        pairs = row.near(max(_LEAST_PX, _MOVE_SHARE * side_px))
        here, there = row.xy_px[pairs.T]
        off_px = moves[other].undone(there) - moves[photo].undone(here)
        again = np.linalg.norm(off_px, axis=1) < _reach(row.scale_px[pairs[:, 0]])
        times[np.unique(pairs[again, 0])] += 1
    return times >= _LEAST_PARTNERS


def _partners(photo: int, group: Sequence[int], count: int) -> Iterator[int]:
    """Other photos of the group, evenly spread over it."""
    others = [one for one in group if one != photo]
    for k in np.unique(np.linspace(0, len(others) - 1, min(count, len(others))).astype(int)):
        yield others[k]


def _something_moves(
    features: Features,
    group: Sequence[int],
    standing: dict[int, Bool[np.ndarray, " n"]],
    side_px: float,
) -> bool:
    """Whether in half of the photos what does not stand still is found elsewhere in the next."""
    enough = 0
    for first, second in zip(group, (*group[1:], group[0]), strict=True):
        ours = features.keypoints[first].some(~standing[first])
        theirs = features.keypoints[second].some(~standing[second])
        if not (len(ours) and len(theirs)):
            continue
        pairs = match_descriptors(
            comparable(ours.descriptors), comparable(theirs.descriptors), _MATCH_RATIO
        )
        moves = np.linalg.norm(ours.xy_px[pairs[:, 0]] - theirs.xy_px[pairs[:, 1]], axis=1)
        enough += int((moves > _LEAST_MOVE_SHARE * side_px).sum()) >= _LEAST_MOVING
    return 2 * enough >= len(group)
