"""Tracks against a plain union of matches, on a scene whose points are known."""

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from limbgram.reconstruction.mapping.body_motion import connected_photos
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.tracks import (
    significant_pairs,
    with_all_tracks,
    with_best_connected_matches,
)
from limbgram.reconstruction.matching.matching import PairMatches
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

MakeScene = Callable[..., Scene]
MakePair = Callable[..., VerifiedPair]


@pytest.mark.parametrize("seed", range(3))
def test_the_matches_that_reach_farthest_stay(make_pair: MakePair, seed: int) -> None:
    random = np.random.default_rng(seed)
    verified = tuple(
        make_pair(a, b, np.column_stack([random.permutation(40)[:25], random.permutation(40)[:25]]))
        for a, b in [(0, 1), (1, 2), (0, 2), (2, 3)]
    )
    degree: Counter[tuple[int, int]] = Counter()
    for one in verified:
        for row in one.matches.keypoint_idx.tolist():
            degree[one.matches.first, row[0]] += 1
            degree[one.matches.second, row[1]] += 1
    for before, after in zip(
        verified, with_best_connected_matches(Pairs(verified, ()), 10).verified
    ):
        first, second = before.matches.first, before.matches.second
        reach = {
            tuple(row): degree[first, row[0]] + degree[second, row[1]]
            for row in before.matches.keypoint_idx.tolist()
        }
        kept = [reach[tuple(row)] for row in after.matches.keypoint_idx.tolist()]
        assert sorted(kept, reverse=True) == sorted(reach.values(), reverse=True)[:10]
        assert len(after.residual_px) == 10
    whole = with_best_connected_matches(Pairs(verified, ()), 100).verified
    assert [len(one.matches) for one in whole] == [25] * 4


def test_tracks_are_what_true_matches_join(make_scene: MakeScene, make_pair: MakePair) -> None:
    """Wrong matches and keypoints that show one point twice in a photo make no track."""
    scene = make_scene(photos=6, points=40, share=0.7)
    random, seen = np.random.default_rng(2), scene.observations
    point_of = [seen.point_idx[seen.photo_idx == k] for k in range(6)]
    places = [seen.xy_px[seen.photo_idx == k] for k in range(6)]
    double = int(np.intersect1d(point_of[0], point_of[1])[0])
    places[1] = np.vstack([places[1], places[1][point_of[1] == double] + 0.3])
    point_of[1] = np.append(point_of[1], double)  # photo 1 shows that point twice

    verified, links = [], []
    for first, second in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 2), (3, 5)]:
        rows, wrong = [], []
        for i, point in enumerate(point_of[first]):
            y = scene.view(second).project(scene.points_in_world[point][None])[0, 1]
            rows += [(i, int(j)) for j in np.flatnonzero(point_of[second] == point)]
            far = np.flatnonzero(np.abs(places[second][:, 1] - y) > 40)  # epipolar lines are level
            wrong += [(i, int(random.choice(far)))] if i % 4 == 0 and len(far) else []
        assert len(wrong) > 3
        links += [{(first, i), (second, j)} for i, j in rows]
        verified.append(make_pair(first, second, np.array(rows + wrong)))
    found = with_all_tracks(scene, places, Pairs(tuple(verified), ()), 0.5)

    groups: list[set[tuple[int, int]]] = []
    for link in links:
        groups, touched = [g for g in groups if not g & link], [g for g in groups if g & link]
        groups.append(link.union(*touched))
    expected = set()
    for group in groups:
        once = [(k, i) for k, i in group if sum(other == k for other, _ in group) == 1]
        if len(once) > 1:
            expected.add(frozenset((k, *places[k][i].tolist()) for k, i in once))
    again = found.observations
    tracks = {
        frozenset(
            (int(again.photo_idx[row]), *again.xy_px[row].tolist())
            for row in np.flatnonzero(again.point_idx == k)
        )
        for k in range(len(found.points_in_world))
    }
    assert tracks == expected
    assert len(expected) > 25
    assert any(len(group) > 2 and (1, len(point_of[1]) - 1) in group for group in groups)
    for place in found.points_in_world:
        assert np.linalg.norm(scene.points_in_world - place, axis=1).min() < 1e-5


def test_wrong_matches_alone_make_no_point(make_scene: MakeScene, make_pair: MakePair) -> None:
    """Before a plain backdrop one wrong match may be all that there is beside the limb."""
    scene = make_scene(photos=6, points=40, share=0.7)
    seen = scene.observations
    places = [seen.xy_px[seen.photo_idx == k] for k in range(6)]
    far = np.abs(places[1][:, 1] - places[0][0, 1])  # epipolar lines are level
    wrong = make_pair(0, 1, np.array([(0, int(far.argmax()))]))
    assert far.max() > 40
    found = with_all_tracks(scene, places, Pairs((wrong,), ()), 0.5)
    assert (len(found.points_in_world), len(found.observations.xy_px)) == (0, 0)
    assert connected_photos(found) == ()


@pytest.mark.parametrize("largest_px", [0.5, 2.0])
def test_pairs_that_obey_by_chance_alone_tell_nothing(
    make_scene: MakeScene, largest_px: float
) -> None:
    """Neighbours share their points; photos from opposite sides have wrong matches alone."""
    scene = make_scene(photos=8, points=90, share=1.0)
    random = np.random.default_rng(6)
    places = tuple(view.project(scene.points_in_world) for view in scene.views)

    def matched(first: int, second: int, count: int, wrong: float) -> PairMatches:
        own = random.permutation(90)[:count]
        mixed = np.where(random.uniform(size=count) < wrong, random.permutation(90)[:count], own)
        return PairMatches(
            first=first,
            second=second,
            keypoint_idx=np.column_stack([own, mixed]).astype(np.int32),
            xy_first_px=places[first][own],
            xy_second_px=places[second][mixed],
            correlation=np.ones(count, np.float32),
        )

    true = [matched(k, (k + 1) % 8, 60, 0.0) for k in range(8)]
    true += [matched(0, 2, 60, 0.5), matched(1, 3, 14, 0.0)]
    wrong = [matched(k, (k + 4) % 8, count, 1.0) for k in range(8) for count in (4, 12, 60)]
    kept = significant_pairs(scene, places, [*true, *wrong], largest_px)
    assert [id(one) for one in kept] == [id(one) for one in true]
