"""Flatness: whether the scale board is bent, and by how much.

In      a scene, the board's corners as bodies have them (what they are off a flat board in their
        offsets), and calibrations.
Out     a bend of the board, held against the rules of every other term; None where it is flat.
Method  Corners lie off the plane by the products of their two places on the board: three numbers,
        one bend for all photos. Score test beside poses, lenses and each photo's lens deviation, of
        which the scene's own points tell; what the bends that single photos show differ by is the
        noise. Lenses that deviate alike in all photos are its rivals, so a distortion that is not
        the calibration's bends no board.
Limits  Nothing is asked where the corners as they were located lie flat. Where no board calibrated
        the lens, what that does beyond its model may bend the board: it is no fact there.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import SIMILARITY_SIZE
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, differentiate_all
from limbgram.core.interval import length_within
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.reconstruction.hypotheses.deformation_fields import Along, FieldEvidence
from limbgram.reconstruction.mapping.body import Body, moves_of_whole
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS
from limbgram.reconstruction.mapping.lens_evidence import (
    MOST,
    OWN,
    USUAL,
    SceneEquations,
    deviations_found,
    eliminated,
    lens_basis,
    packed,
)
from limbgram.reconstruction.mapping.scene import Explanation, Scene
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    ScoreTest,
    estimate_spread,
)
from limbgram.reconstruction.mapping.solution import LensPrior

SAG_FLOOR_MM = 0.5
"""A print glued on card is bent by this. It costs nothing that can be measured on a limb, and the
size is off by 0.002 % (210 mm)."""
_BENDS = 3
_ASKED = 0.5
"""Share of the floor from which corners as they were located raise the question."""


def board_bend(
    scene: Scene,
    priors: Sequence[Calibration],
    board: Body,
    size_mm: Float64[np.ndarray, "2"],
) -> Explanation | None:
    """How the board is bent unless it is flat, or chance explains it.

    Args:
        size_mm: Width and height of the print.
    """
    heights = _heights(board.shape, size_mm)
    if _sag(board, heights) < _ASKED * SAG_FLOOR_MM * board.world_from_body.scale:
        return None
    evidence = _evidence(scene, priors, board, heights)
    spread = estimate_spread(evidence.lenses_beside_fields(), USUAL, MOST).spread
    seen = evidence.fields(spread)
    along = Along.of(evidence, spread, np.ones(evidence.photos), seen, ScoreTest.of(seen))
    chance = along.chance(1)
    if chance > SIGNIFICANCE_LEVEL:
        return None
    effect, low, high = length_within(*along.solved)
    floor = SAG_FLOOR_MM * board.world_from_body.scale
    failed = along.failed()
    if any(one.source != "board" for one in priors):
        failed.append("model")
    if low < floor:
        failed.append("size")
    return Explanation(
        bodies="board",
        kind="bend",
        photos=tuple(np.array(scene.placed)[np.unique(board.photo_idx)].tolist()),
        numbers=_BENDS,
        score=float(along.one.statistic / along.noise - _BENDS * np.log(evidence.facts)),
        chance=chance,
        effect=effect,
        low=low,
        high=high,
        variance_before=along.every.variance_factor,
        variance_after=along.rest,
        failed=tuple(failed),
        floor=floor,
    )


def _heights(corners_mm: Points3, size_mm: Float64[np.ndarray, "2"]) -> Float64[np.ndarray, "n 3"]:
    """How high corners lie off the plane for one unit of each bend: by which both ends of a side
    lie off the middle, and by which the print's corners do where it is twisted."""
    x, y = (2.0 * corners_mm[:, :2] / size_mm - 1.0).T
    return np.column_stack([x * x, x * y, y * y])


def _sag(board: Body, heights: Float64[np.ndarray, "n 3"]) -> float:
    """By the corners as they were located, in the world's unit."""
    off = board.offsets @ board.world_from_body.rotation[:, 2]
    plane = np.column_stack([heights, board.shape[:, :2], np.ones(len(off))])
    return float(np.linalg.norm(np.linalg.lstsq(plane, off, rcond=None)[0][:_BENDS]))


def _evidence(
    scene: Scene, priors: Sequence[Calibration], board: Body, heights: Float64[np.ndarray, "n 3"]
) -> FieldEvidence:
    """Poses, points, lenses and the place of the board eliminated."""
    photos = len(scene.placed)
    of_points = SceneEquations.of(scene, scene.placed, priors)
    first = POSE_SIZE * photos
    lens = slice(first, first + LENS_SIZE * len(priors))
    place = slice(lens.stop + OWN * photos, lens.stop + OWN * photos + SIMILARITY_SIZE)
    size = place.stop + _BENDS * photos
    normal, right = np.zeros((size, size)), np.zeros(size)
    normal[: place.start, : place.start] = of_points.normal
    right[: place.start] = of_points.right
    prior = LensPrior.of(priors, hold_board_lenses=False)
    prior.join(normal, right, packed(scene), first)
    # of the corners as they are, so that a world that turns or grows bends no board
    arms = board.corners - board.world_from_body.translation
    bends = heights[:, None] * board.world_from_body.rotation[:, 2:]
    moves = np.concatenate([moves_of_whole(arms), bends], axis=2)
    for k in np.unique(board.photo_idx).tolist():
        camera = scene.camera_idx[scene.placed[k]]
        rows, residual = _seen_in(scene, board, k, moves, lens_basis(priors[camera].camera))
        at = np.concatenate(
            [
                POSE_SIZE * k + np.arange(POSE_SIZE),
                first + LENS_SIZE * camera + np.arange(LENS_SIZE),
                lens.stop + OWN * k + np.arange(OWN),
                np.arange(place.start, place.stop),
                place.stop + _BENDS * k + np.arange(_BENDS),
            ]
        )
        normal[np.ix_(at, at)] += rows.T @ rows
        right[at] += rows.T @ residual
    known = np.ones(lens.stop, bool)
    known[lens] = prior.free
    out = np.concatenate([np.flatnonzero(known), np.arange(place.start, place.stop)])
    kept = np.setdiff1d(np.arange(lens.stop, size), out)
    left, pull = eliminated(normal, right, out, kept)
    pull = pull + deviations_found(scene, scene.placed, left)
    return FieldEvidence(photos, _BENDS, left, pull, photos * of_points.clusters)


def _seen_in(
    scene: Scene,
    board: Body,
    photo: int,
    moves: Float64[np.ndarray, "n 3 k"],
    basis: Float64[np.ndarray, "lens 9"],
) -> tuple[Float64[np.ndarray, "r c"], Float64[np.ndarray, " r"]]:
    """Weighted rows of one photo over its pose, lens, deviation, and what moves the corners; and
    what is left of a flat board, to first order about the corners as they were located."""
    view = scene.view(scene.placed[photo])
    seen = np.flatnonzero(board.photo_idx == photo)
    residual = board.xy_px[seen] - view.project(board.corners[board.corner_idx[seen]])
    shown = np.isfinite(residual).all(axis=1)  # a lens that folds inside the picture has others
    seen, residual = seen[shown], residual[shown]
    corner = board.corner_idx[seen]
    points: Points3 = np.ascontiguousarray(board.corners[corner])
    by_point, by_pose = np.zeros((len(seen), 2, 3)), np.zeros((len(seen), 2, POSE_SIZE))
    by_lens = np.zeros((len(seen), 2, LENS_SIZE))
    differentiate_all(view.packed, points, by_point, by_pose, by_lens)
    off = (residual**2).sum(axis=1) / (CAUCHY_SIGMAS * board.sigma_px) ** 2
    weight = 1.0 / (board.sigma_px * np.sqrt(1.0 + off))
    residual = residual + np.einsum("nai,ni->na", by_point, board.offsets[corner])
    rows = np.concatenate([by_pose, by_lens, by_lens @ basis, by_point @ moves[corner]], axis=2)
    rows = weight[:, None, None] * rows
    return rows.reshape(-1, rows.shape[2]), (weight[:, None] * residual).ravel()
