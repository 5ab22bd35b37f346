"""Chains: pairs whose turn contradicts a chain of pairs that have more matches each.

A chessboard, a row of like buttons or two like labels look alike in photos from different sides.
The matches of such a pair agree with one geometry, and it is a wrong one: with two pairs of 33
matches each, on a board seen from sides a right angle apart, the mapper folded a ring of twelve
photos up. Round the ring, every pair has more matches than such a pair. So the pairs are joined to
the tree that has the most matches (the maximum spanning tree: on its way between two photos, every
pair has at least as many matches as the pair of the two), and a pair that turns its second photo
otherwise than the tree does contradicts it. A pair that shows little but a plane may do so too and
be right: this is asked only where photos could not be placed by all pairs, of the mapper's alone.

Points on a plane allow a photo two poses. Opposite photos on a turntable share nothing but the
board, and more of it than neighbours share of sparse paint: the mapper poses them by it, half of
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

_MOST_STARTS = 4


def along_chains(pairs: Pairs, photos: int) -> Pairs:
    """Less the pairs whose turn contradicts a chain of pairs with more matches."""
    told = [(pair, pair.second_from_first) for pair in pairs.verified if pair.kind == "general"]
    turned = [(pair, pose) for pair, pose in told if pose is not None]
    if not turned:
        return pairs
    turns, tree = _turns_by_tree(turned, photos)
    first, second = np.array([pair.matches.photos for pair, _ in turned]).T
    shown = np.array([pose.rotation for _, pose in turned])
    off_deg = angles_deg(shown @ turns[first] @ turns[second].transpose(0, 2, 1))
    contradict = (tree[first] == tree[second]) & (off_deg > CONTRADICTION_DEG)
    wrong = {turned[k][0].matches.photos for k in np.flatnonzero(contradict).tolist()}
    kept = tuple(pair for pair in pairs.verified if pair.matches.photos not in wrong)
    return Pairs(kept, pairs.rejected + len(pairs.verified) - len(kept))


def without_planes(pairs: Pairs) -> Pairs:
    """Less the pairs that see a plane: by its points a photo has two poses."""
    kept = tuple(pair for pair in pairs.verified if pair.kind != "planar")
    return Pairs(kept, pairs.rejected + len(pairs.verified) - len(kept))


def starts(pairs: Pairs) -> tuple[tuple[int, int], ...]:
    """General pairs with the most matches to start the mapper from, no photo in two of them."""
    general = [pair for pair in pairs.verified if pair.kind == "general"]
    found: list[tuple[int, int]] = []
    for pair in sorted(general, key=lambda pair: -len(pair.matches)):
        if not any({*pair.matches.photos} & {*other} for other in found):
            found.append(pair.matches.photos)
    return tuple(found[:_MOST_STARTS])


def _turns_by_tree(
    turned: Sequence[tuple[VerifiedPair, Rigid]], photos: int
) -> tuple[Float64[np.ndarray, "p 3 3"], Int32[np.ndarray, " p"]]:
    """Turn of every photo along the tree of most matches, and the tree that each stands in."""
    by_ends = {pair.matches.photos: pose.rotation for pair, pose in turned}
    by_ends |= {(second, first): turn.T for (first, second), turn in by_ends.items()}
    first, second = np.array([pair.matches.photos for pair, _ in turned]).T
    rarity = 1.0 / np.array([len(pair.matches) for pair, _ in turned])
    links = minimum_spanning_tree(csr_array((rarity, (first, second)), shape=(photos, photos)))
    tree = connected_components(links, directed=False)[1]
    turns = np.tile(np.eye(3), (photos, 1, 1))
    for start in np.unique(tree, return_index=True)[1].tolist():
        order, before = breadth_first_order(links, start, directed=False)
        for photo in order[1:].tolist():
            turns[photo] = by_ends[int(before[photo]), photo] @ turns[before[photo]]
    return turns, tree
