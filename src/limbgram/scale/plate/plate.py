"""Plate: a board of known size as a ruler in the scene.

The corners are split like the colours of a checkerboard: one half sets the scale, the other half,
which shares no corner with it, checks it. The board is taken to be printed as described; that x
and y agree is tested, that both are wrong alike only another length can tell.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int32

from limbgram.errors import ScaleError
from limbgram.geometry.arrays import Points3
from limbgram.geometry.similarity import Similarity, fit_similarity
from limbgram.mapping.scene import Scene
from limbgram.photos.photo import SetAside
from limbgram.scale.plate.corners import SceneCorners, locate_corners
from limbgram.scale.plate.lengths import long_lengths
from limbgram.scale.ruler import Ruler, jackknife_sigma
from limbgram.targets.detections import BoardDetections

_LEAST_CORNERS = 8
_LEAST_HALF = 3
_OUTLIER_SIGMAS = 5.0
_LEAST_OUTLIER = 0.001
"""Corners nearer to the flat board than this share of its size are never outliers."""


@dataclass(frozen=True, kw_only=True)
class Plate:
    """A board found in the scene: where it is, and what it says about the scale."""

    scene_from_board: Similarity
    """Board frame in millimetres (z into the plate) to the scene's world and unit."""
    outline_mm: Points3
    """Outer corners of the squares in the board frame."""
    corners: SceneCorners
    control_ids: Int32[np.ndarray, " c"]
    """Corners that set the scale: rows of the board's corners."""
    ruler: Ruler
    check_error: float
    """Scale by the checking half over scale by the other half, less one."""
    stretch: float
    """How much longer x is than y in the scene, as a fraction; 0 on a board printed true."""
    stretch_sigma: float


def find_plate(scene: Scene, detections: BoardDetections) -> Plate:
    """The board as a ruler.

    Raises:
        ScaleError: too few of its corners could be located, or they contradict each other.
    """
    located = locate_corners(scene, detections)
    control = _control_half(located.ids, detections)
    _check_enough(control, detections)
    flat = _flat(detections.corners_mm[located.ids], located.points_in_world)
    control = control[flat]
    _check_enough(control, detections)
    board_mm = detections.corners_mm[located.ids[flat]]
    points, replicates = located.points_in_world[flat], located.without_photo[:, flat]

    pose = fit_similarity(board_mm, points)
    _check_facing(pose, scene)
    width, height = (n * detections.board.square_mm for n in detections.board.squares)
    scale = fit_similarity(board_mm[control], points[control]).scale
    scales = [fit_similarity(board_mm[control], one[control]).scale for one in replicates]
    return Plate(
        scene_from_board=pose,
        outline_mm=np.array([(0, 0, 0), (width, 0, 0), (width, height, 0), (0, height, 0)], float),
        corners=located,
        control_ids=located.ids[flat][control],
        ruler=Ruler(
            units_per_mm=scale,
            relative_sigma=jackknife_sigma(np.array(scales)) / scale,
            lengths=(
                *long_lengths(board_mm, points, replicates, control, "control"),
                *long_lengths(board_mm, points, replicates, ~control, "check"),
            ),
            set_aside=located.set_aside + _off_plane(int((~flat).sum())),
        ),
        check_error=fit_similarity(board_mm[~control], points[~control]).scale / scale - 1,
        stretch=_stretch(board_mm, points),
        stretch_sigma=jackknife_sigma(np.array([_stretch(board_mm, one) for one in replicates])),
    )


def _control_half(ids: np.ndarray, detections: BoardDetections) -> Bool[np.ndarray, " n"]:
    across = detections.board.inner[0]
    return (ids // across + ids % across) % 2 == 0


def _check_enough(control: Bool[np.ndarray, " n"], detections: BoardDetections) -> None:
    enough = len(control) >= _LEAST_CORNERS
    if not enough or min(control.sum(), (~control).sum()) < _LEAST_HALF:
        if detections.cause:
            raise ScaleError(
                f"{len(detections.photos)} photos show the {detections.board}. {detections.cause}"
            )
        raise ScaleError(
            f"Only {len(control)} corners of the {detections.board} could be located in the "
            f"scene; {_LEAST_CORNERS} are needed, each in three placed photos "
            f"({len(detections.photos)} photos show the board). Lay the whole board flat where "
            "most photos see it, check that its size and dictionary are given as printed, or "
            "give a known distance."
        )


def _flat(board_mm: Points3, points: Points3) -> Bool[np.ndarray, " n"]:
    """Corners that lie where a flat board of the right proportions has them."""
    kept = np.ones(len(points), bool)
    for _ in range(len(points)):
        pose = fit_similarity(board_mm[kept], points[kept])
        off = np.linalg.norm(points - pose.apply(board_mm), axis=1)
        size = pose.scale * float(np.ptp(board_mm, axis=0).max())
        limit = max(_LEAST_OUTLIER * size, _OUTLIER_SIGMAS * float(np.median(off[kept])))
        worst = int(np.argmax(np.where(kept, off, 0.0)))
        if off[worst] <= limit or kept.sum() <= _LEAST_CORNERS:
            break
        kept[worst] = False
    return kept


def _off_plane(count: int) -> tuple[SetAside, ...]:
    if not count:
        return ()
    return (SetAside("board", f"{count} corners lie off the flat board and were not used"),)


def _check_facing(pose: Similarity, scene: Scene) -> None:
    """The printed side must face the cameras, or the scene is inside out."""
    toward = np.array([view.centre_in_world - pose.translation for view in scene.views])
    if np.mean(toward @ pose.rotation[:, 2] < 0) < 0.5:
        raise ScaleError(
            "The board shows its back to the cameras: the scene is inside out, or the board was "
            "printed mirrored. Print the board unmirrored; if it is, photograph with more "
            "overlap."
        )


def _stretch(board_mm: Points3, points: Points3) -> float:
    """Length of the board's x over the length of its y in the scene, less one."""
    plane = board_mm[:, :2] - board_mm[:, :2].mean(0)
    axes = np.linalg.lstsq(plane, points - points.mean(0), rcond=None)[0]
    along_x, along_y = np.linalg.norm(axes, axis=1)
    return float(along_x / along_y) - 1
