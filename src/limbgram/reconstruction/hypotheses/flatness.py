"""Flatness: whether the scale board is bent, and by how much.

In      a scene, the board's corners as a Body (the offsets of which say how far they lie off a flat
        board), and calibrations.
Out     a bend of the board, with the rules that it fails; None where it is flat.
Method  Corners leave the plane by the products of their two coordinates on the board: three
        numbers, one bend for all photos. Score test beside poses, lenses and each photo's lens
        deviation, which the scene's own points determine; the noise is the variance of the bends of
        single photos. Lenses that deviate alike in all photos are its rivals, so a distortion that
        is not the calibration's bends no board.
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
from limbgram.reconstruction.hypotheses.deformation_fields import FieldEquations, FieldTest
from limbgram.reconstruction.mapping.body import Body, moves_of_whole
from limbgram.reconstruction.mapping.bundle import CAUCHY_SIGMAS
from limbgram.reconstruction.mapping.bundle_adjustment import LensPrior
from limbgram.reconstruction.mapping.lens_equations import (
    DEVIATION_SIZE,
    MAX_SPREAD,
    USUAL_SPREAD,
    SceneEquations,
    eliminate,
    known_deviations_rhs,
    lens_basis,
    packed_lenses,
)
from limbgram.reconstruction.mapping.scene import Explanation, Scene
from limbgram.reconstruction.mapping.score_tests import (
    SIGNIFICANCE_LEVEL,
    ScoreTest,
    estimate_spread,
)

SAG_FLOOR_MM = 0.5
"""Sag from which a bend matters. A print glued on card has as much: nothing that can be measured
on a limb follows, and the size is off by 0.002 % (210 mm)."""
_NUMBERS = 3
_TEST_SHARE = 0.5
"""Share of the floor from which the sag of the located corners is tested."""


def board_bend(
    scene: Scene,
    priors: Sequence[Calibration],
    board: Body,
    size_mm: Float64[np.ndarray, "2"],
) -> Explanation | None:
    """How the board is bent; None where it is flat, or the bend is not significant.

    Args:
        size_mm: Width and height of the print.
    """
    field = _bending_field(board.shape, size_mm)
    if _sag(board, field) < _TEST_SHARE * SAG_FLOOR_MM * board.world_from_body.scale:
        return None
    equations = _field_equations(scene, priors, board, field)
    spread = estimate_spread(equations.of_lenses(), USUAL_SPREAD, MAX_SPREAD).spread
    of_fields = equations.of_fields(spread)
    constant = np.ones(equations.photos)
    test = FieldTest.of(equations, spread, constant, of_fields, ScoreTest.of(of_fields))
    p_value = test.p_value(1)
    if p_value > SIGNIFICANCE_LEVEL:
        return None
    effect, low, high = length_within(*test.estimate)
    floor = SAG_FLOOR_MM * board.world_from_body.scale
    failed = test.failed_rules()
    if any(one.source != "board" for one in priors):
        failed.append("model")
    if low < floor:
        failed.append("size")
    return Explanation(
        bodies="board",
        kind="bend",
        photos=tuple(np.array(scene.placed)[np.unique(board.photo_idx)].tolist()),
        numbers=_NUMBERS,
        score=float(
            test.along_course.statistic / test.noise - _NUMBERS * np.log(equations.sample_size)
        ),
        chance=p_value,
        effect=effect,
        low=low,
        high=high,
        variance_before=test.each_photo.variance_factor,
        variance_after=test.residual_variance,
        failed=tuple(failed),
        floor=floor,
    )


def _bending_field(
    corners_mm: Points3, size_mm: Float64[np.ndarray, "2"]
) -> Float64[np.ndarray, "n 3"]:
    """Height of the corners above the plane for one unit of each number of a bend.

    The numbers are how far both ends of a side lie above the middle, and the twist of the corners.
    """
    x, y = (2.0 * corners_mm[:, :2] / size_mm - 1.0).T
    return np.column_stack([x * x, x * y, y * y])


def _sag(board: Body, field: Float64[np.ndarray, "n 3"]) -> float:
    """Sag of the corners as they were located, in the world's unit."""
    off = board.offsets @ board.world_from_body.rotation[:, 2]
    plane = np.column_stack([field, board.shape[:, :2], np.ones(len(off))])
    return float(np.linalg.norm(np.linalg.lstsq(plane, off, rcond=None)[0][:_NUMBERS]))


def _field_equations(
    scene: Scene, priors: Sequence[Calibration], board: Body, field: Float64[np.ndarray, "n 3"]
) -> FieldEquations:
    """Equations over deviations and bends, with poses, points, lenses and board pose eliminated."""
    photos = len(scene.placed)
    of_points = SceneEquations.of(scene, scene.placed, priors)
    first = POSE_SIZE * photos
    lens = slice(first, first + LENS_SIZE * len(priors))
    board_rows = slice(
        lens.stop + DEVIATION_SIZE * photos, lens.stop + DEVIATION_SIZE * photos + SIMILARITY_SIZE
    )
    size = board_rows.stop + _NUMBERS * photos
    normal, right = np.zeros((size, size)), np.zeros(size)
    normal[: board_rows.start, : board_rows.start] = of_points.normal
    right[: board_rows.start] = of_points.right
    prior = LensPrior.of(priors, hold_board_lenses=False)
    prior.add_to(normal, right, packed_lenses(scene), first)
    # of the corners as located, so that a similarity of the world bends no board
    arms = board.corners - board.world_from_body.translation
    bends = field[:, None] * board.world_from_body.rotation[:, 2:]
    moves = np.concatenate([moves_of_whole(arms), bends], axis=2)
    for k in np.unique(board.photo_idx).tolist():
        camera = scene.camera_idx[scene.placed[k]]
        rows, residual = _photo_rows(scene, board, k, moves, lens_basis(priors[camera].camera))
        at = np.concatenate(
            [
                POSE_SIZE * k + np.arange(POSE_SIZE),
                first + LENS_SIZE * camera + np.arange(LENS_SIZE),
                lens.stop + DEVIATION_SIZE * k + np.arange(DEVIATION_SIZE),
                np.arange(board_rows.start, board_rows.stop),
                board_rows.stop + _NUMBERS * k + np.arange(_NUMBERS),
            ]
        )
        normal[np.ix_(at, at)] += rows.T @ rows
        right[at] += rows.T @ residual
    free = np.ones(lens.stop, bool)
    free[lens] = prior.free
    eliminated_rows = np.concatenate(
        [np.flatnonzero(free), np.arange(board_rows.start, board_rows.stop)]
    )
    kept = np.setdiff1d(np.arange(lens.stop, size), eliminated_rows)
    reduced, reduced_right = eliminate(normal, right, eliminated_rows, kept)
    reduced_right = reduced_right + known_deviations_rhs(scene, scene.placed, reduced)
    return FieldEquations(photos, _NUMBERS, reduced, reduced_right, photos * of_points.clusters)


def _photo_rows(
    scene: Scene,
    board: Body,
    photo: int,
    moves: Float64[np.ndarray, "n 3 k"],
    basis: Float64[np.ndarray, "lens 9"],
) -> tuple[Float64[np.ndarray, "r c"], Float64[np.ndarray, " r"]]:
    """Weighted Jacobian of one photo's corners over its pose, lens, deviation and `moves`, and the
    residuals of a flat board, to first order about the corners as they were located."""
    view = scene.view(scene.placed[photo])
    seen = np.flatnonzero(board.photo_idx == photo)
    residual = board.xy_px[seen] - view.project(board.corners[board.corner_idx[seen]])
    shown = np.isfinite(residual).all(axis=1)  # not where the lens model folds inside the picture
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
