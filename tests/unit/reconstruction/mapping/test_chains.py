"""Which pairs contradict a chain of stronger pairs."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.reconstruction.mapping.chains import (
    start_pairs,
    without_contradicting_pairs,
    without_planar_pairs,
)
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

MakePair = Callable[..., VerifiedPair]


@pytest.fixture
def pair_of(make_scene: Callable[..., Scene], make_pair: MakePair) -> MakePair:
    """A pair of a ring of twelve photos, turned by so much too far."""
    scene = make_scene(photos=12)

    def pair(
        first: int, second: int, matches: int, wrong_deg: float = 0.0, kind: str = "general"
    ) -> VerifiedPair:
        views = scene.view(first), scene.view(second)
        pose = views[1].camera_from_world @ views[0].camera_from_world.inverse
        wrong = Rigid.from_rotation_vector(np.radians([0.0, wrong_deg, 0.0]), np.zeros(3))
        return make_pair(first, second, np.zeros((matches, 2)), wrong @ pose, kind)

    return pair


def ends(pairs: Pairs) -> set[tuple[int, int]]:
    return {(one.matches.first, one.matches.second) for one in pairs.verified}


def test_a_board_that_looks_alike_from_two_sides_contradicts_the_ring(pair_of: MakePair) -> None:
    ring = [pair_of(k, (k + 1) % 12, 120 + 7 * k, 2.0 * (-1) ** k) for k in range(12)]
    across = [pair_of(0, 6, 60), pair_of(3, 9, 60, 4.0)]
    alike = [pair_of(0, 9, 32, 90.0), pair_of(1, 4, 33, -90.0)]
    given = Pairs((*ring, *across, *alike), 5)
    kept = without_contradicting_pairs(given, 12)
    assert ends(given) - ends(kept) == {(0, 9), (1, 4)}
    assert kept.rejected == 7


def test_the_stronger_pair_is_never_the_one_that_contradicts(pair_of: MakePair) -> None:
    """A chain with a wrong link is weaker than the pair that it contradicts."""
    chain = [pair_of(0, 1, 200), pair_of(1, 2, 25, 60.0), pair_of(2, 3, 200)]
    kept = without_contradicting_pairs(Pairs((*chain, pair_of(0, 3, 90)), 0), 12)
    assert ends(kept) == {(0, 1), (2, 3), (0, 3)}


def test_a_plane_and_a_pair_that_no_chain_joins_are_kept(pair_of: MakePair) -> None:
    """Of the two poses that a plane allows, a pair may keep the wrong one."""
    chain = [pair_of(0, 1, 200), pair_of(1, 2, 200)]
    others = [pair_of(0, 2, 40, 60.0, "planar"), pair_of(4, 5, 22, 80.0)]
    given = Pairs((*chain, *others), 0)
    assert without_contradicting_pairs(given, 12) == given
    assert without_contradicting_pairs(Pairs((), 3), 12) == Pairs((), 3)


def test_the_mapper_starts_from_solid_pairs_elsewhere_each_time(pair_of: MakePair) -> None:
    ring = [pair_of(k, (k + 1) % 12, 120 + k) for k in range(12)]
    given = Pairs((*ring, pair_of(0, 6, 300, 0.0, "planar")), 2)
    assert start_pairs(given) == ((11, 0), (9, 10), (7, 8), (5, 6))
    assert without_planar_pairs(given) == Pairs(tuple(ring), 3)
    assert start_pairs(Pairs((), 0)) == ()
