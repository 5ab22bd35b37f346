"""Chains: pairs whose rotation contradicts a chain of pairs that have more matches each.

A chessboard, a row of like buttons or two like labels look alike in photos from different sides.
The matches of such a pair agree with one geometry, and it is a wrong one: with two pairs of 33
matches each, on a board seen from sides a right angle apart, the mapper folded a ring of twelve
photos up. Round the ring, every pair has more matches than such a pair. So the maximum spanning
tree by number of matches is built (on its path between two photos, every pair has at least as many
matches as the pair of the two), and a pair whose rotation differs from that along the tree
contradicts it. A pair that shows little but a plane may differ too and be right: this is asked only
where photos could not be placed by all pairs, and concerns only what the mapper gets.

Points on a plane allow a photo two poses. Opposite photos on a turntable share nothing but the
board, and more of it than neighbours share of sparse texture: the mapper poses them by it, half of
the ring takes the other pose, and which half depends on the pair that it starts from.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64, Int32
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from limbgram.core.geometry.frames import Rigid
from limbgram.reconstruction.mapping.verdicts import CONTRADICTION_DEG, angles_deg
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

_MOST_START_PAIRS = 4


def without_contradicting_pairs(pairs: Pairs, photos: int) -> Pairs:
    """The pairs without those whose rotation contradicts a chain of pairs with more matches."""
    general = [(pair, pair.second_from_first) for pair in pairs.verified if pair.kind == "general"]
    with_pose = [(pair, pose) for pair, pose in general if pose is not None]
    if not with_pose:
        return pairs
    rotations, tree = _rotations_along_trees(with_pose, photos)
    first, second = np.array([pair.matches.photos for pair, _ in with_pose]).T
    measured = np.array([pose.rotation for _, pose in with_pose])
    off_deg = angles_deg(measured @ rotations[first] @ rotations[second].transpose(0, 2, 1))
    contradict = (tree[first] == tree[second]) & (off_deg > CONTRADICTION_DEG)
    wrong = {with_pose[k][0].matches.photos for k in np.flatnonzero(contradict).tolist()}
    kept = tuple(pair for pair in pairs.verified if pair.matches.photos not in wrong)
    return Pairs(kept, pairs.rejected + len(pairs.verified) - len(kept))


def without_planar_pairs(pairs: Pairs) -> Pairs:
    """The pairs without planar ones: the points of a plane allow a photo two poses."""
    kept = tuple(pair for pair in pairs.verified if pair.kind != "planar")
    return Pairs(kept, pairs.rejected + len(pairs.verified) - len(kept))


def start_pairs(pairs: Pairs) -> tuple[tuple[int, int], ...]:
    """Initial pairs for the mapper: general ones with the most matches, no photo in two of them."""
    general = [pair for pair in pairs.verified if pair.kind == "general"]
    found: list[tuple[int, int]] = []
    for pair in sorted(general, key=lambda pair: -len(pair.matches)):
        if not any({*pair.matches.photos} & {*other} for other in found):
            found.append(pair.matches.photos)
    return tuple(found[:_MOST_START_PAIRS])


def _rotations_along_trees(
    with_pose: Sequence[tuple[VerifiedPair, Rigid]], photos: int
) -> tuple[Float64[np.ndarray, "p 3 3"], Int32[np.ndarray, " p"]]:
    """Rotation of every photo along its maximum spanning tree, and the number of that tree."""
    by_ends = {pair.matches.photos: pose.rotation for pair, pose in with_pose}
    by_ends |= {(second, first): rotation.T for (first, second), rotation in by_ends.items()}
    first, second = np.array([pair.matches.photos for pair, _ in with_pose]).T
    rarity = 1.0 / np.array([len(pair.matches) for pair, _ in with_pose])
    links = minimum_spanning_tree(csr_array((rarity, (first, second)), shape=(photos, photos)))
    tree = connected_components(links, directed=False)[1]
    rotations = np.tile(np.eye(3), (photos, 1, 1))
    for start in np.unique(tree, return_index=True)[1].tolist():
        order, before = breadth_first_order(links, start, directed=False)
        for photo in order[1:].tolist():
            rotations[photo] = by_ends[int(before[photo]), photo] @ rotations[before[photo]]
    return rotations, tree
