"""The board as a ruler: the scale of the scene from a board of known size.

In      a Scene, and where its photos show the board's corners.
Out     the board's corners as points of the scene, the lengths that set the scale and those that
        check it, the scene adjusted once more together with the board.
Method  Corners are triangulated from all photos that see them. Those that contradict the others
        are dropped: where the limb's silhouette cuts the board, a detector puts some of them a
        pixel and more beside the truth. The uncertainty due to errors of single photos is found by
        leaving out one photo at a time (jackknife).
        Corners are split like the colours of a checkerboard: one half sets the scale; the other
        half, which shares no corner with it, checks it. The board is assumed to be printed as
        described: that x and y agree is tested; an error common to both shows only in another
        length. Corners that set the scale join one last adjustment as a body of known shape and
        free scale: they are seen in more photos, and more sharply, than any keypoint of the skin.
        Those that check it stay out. The sigma of the print's shape is estimated from the corners
        as triangulated before, so that a bent board still constrains the photos but does not bend
        the scene.
        Where x and y disagree significantly, one of them is not as printed, and the photos do not
        show which: the scale, which lies between both, is then uncertain by half of that.
Fails   ScaleError: too few corners, corners that contradict each other, a mirrored board. Corners
        have large residuals also where the camera file belongs to another lens; a board seen from
        three sides determines the focal length by itself, and so shows which is the cause.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int32

from limbgram.core.errors import CalibrationError, ScaleError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.geometry.lens import View
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.interval import MAD_TO_SIGMA, RAYLEIGH_MEDIAN
from limbgram.findings import Finding, doubt
from limbgram.reconstruction.calibration.adjustment import BoardObservation
from limbgram.reconstruction.calibration.cameras import Cameras, foreign_camera
from limbgram.reconstruction.calibration.screening import free_unknowns, screen
from limbgram.reconstruction.mapping.body import Body
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.scene import Scene, other_from_one
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.ruler import (
    LEAST_OBSERVATIONS,
    Ruler,
    RulerLength,
    corners_shown,
    jackknife_sigma,
    points_by_cameras,
    size_by_cameras,
    stretch_by_cameras,
)
from limbgram.reconstruction.targets.board import BoardDetections, PhotoCorners

_ROUNDS = 20
_LEAST_LIMIT_PX = 0.3
_LIMIT_SIGMAS = 4.0
_MOST_RESIDUAL = 0.001
"""Residual, as a share of the picture's width, above which the board cannot have lain still."""
_LEAST_AGREEING_SHARE = 0.5
"""Smallest share of a photo's corners that must agree with the other photos."""


@dataclass(frozen=True, kw_only=True)
class SceneCorners:
    """Corners of the board, located in the scene."""

    ids: Int32[np.ndarray, " n"]
    points_in_world: Points3
    without_photo: Float64[np.ndarray, "p n 3"]
    """The same points, each time without one of the p photos."""
    observations: "CornerObservations"
    """Inlier observations, of located corners and of others."""
    sigma_px: float
    """Standard deviation of one measured coordinate, from the residuals."""
    set_aside: tuple[SetAside, ...]


@dataclass(frozen=True)
class CornerObservations:
    """Observations: corner point_idx[k] of the board appears in views[view_idx[k]] at xy_px[k]."""

    views: tuple[View, ...]
    view_idx: Int32[np.ndarray, " m"]
    point_idx: Int32[np.ndarray, " m"]
    xy_px: Points2
    count: int

    def subset(self, kept: np.ndarray) -> "CornerObservations":
        """Some of the observations."""
        return CornerObservations(
            self.views, self.view_idx[kept], self.point_idx[kept], self.xy_px[kept], self.count
        )

    def points(self) -> Points3:
        """The corners; NaN where they are not seen enough."""
        if not self.views:
            return np.full((self.count, 3), np.nan)
        located = triangulate(self.views, self.view_idx, self.point_idx, self.xy_px, self.count)
        return located.points_in_world

    def residuals_px(self, points: Points3) -> Float64[np.ndarray, " m"]:
        """Distance between measured and projected pixels; NaN where the point is unknown."""
        distances = np.full(len(self.xy_px), np.nan)
        for idx, view in enumerate(self.views):
            rows = self.view_idx == idx
            projected = view.project(points[self.point_idx[rows]])
            distances[rows] = np.linalg.norm(self.xy_px[rows] - projected, axis=1)
        return distances


def locate_corners(scene: Scene, detections: BoardDetections) -> SceneCorners:
    """Triangulate the corners that at least three placed photos see.

    Raises:
        ScaleError: the board's corners contradict each other in all photos.
    """
    observations = _corner_observations(scene, detections)
    inliers = _consistent(observations)
    _check_still(inliers, observations)
    trusted, doubted = _without_contradicting_photos(inliers, observations)
    points = trusted.points()
    seen = np.bincount(trusted.point_idx, minlength=trusted.count)
    known = np.isfinite(points).all(1) & (seen >= LEAST_OBSERVATIONS)
    replicates = _leave_one_out(trusted, points)
    return SceneCorners(
        ids=np.flatnonzero(known).astype(np.int32),
        points_in_world=points[known],
        without_photo=replicates[:, known],
        observations=trusted,
        sigma_px=_sigma_px(trusted.residuals_px(points)),
        set_aside=doubted,
    )


def placed_photos(detections: BoardDetections, scene: Scene) -> dict[int, PhotoCorners]:
    """The corners in each placed photo of the board, by the photo's index in the scene."""
    index = {scene.names[k]: k for k in scene.placed}
    return {index[one.name]: one for one in detections.photos if one.name in index}


def _corner_observations(scene: Scene, detections: BoardDetections) -> CornerObservations:
    """Observations of the board's corners in placed photos."""
    seen = placed_photos(detections, scene)
    photos = seen.values()
    return CornerObservations(
        scene.views_of(seen),
        np.repeat(np.arange(len(photos), dtype=np.int32), [len(photo.ids) for photo in photos]),
        np.concatenate([photo.ids for photo in photos] or [np.zeros(0, np.int32)]),
        np.concatenate([photo.xy_px for photo in photos] or [np.zeros((0, 2))]),
        len(detections.corners_mm),
    )


def _consistent(observations: CornerObservations) -> CornerObservations:
    """Drop each corner's worst observation while it is far beyond the usual residual."""
    for _ in range(_ROUNDS):
        residuals = observations.residuals_px(observations.points())
        limit = _limit_px(_sigma_px(residuals))
        worst = np.zeros(observations.count)
        np.maximum.at(worst, observations.point_idx, np.nan_to_num(residuals))
        dropped = (residuals > limit) & (residuals == worst[observations.point_idx])
        if not dropped.any():
            break
        observations = observations.subset(~dropped)
    return observations


def _limit_px(sigma_px: float) -> float:
    """Residual beyond which a corner is an outlier."""
    return max(_LEAST_LIMIT_PX, _LIMIT_SIGMAS * sigma_px)


def _check_still(inliers: CornerObservations, observations: CornerObservations) -> None:
    if not len(inliers.xy_px):
        return
    sigma_px = _sigma_px(observations.residuals_px(inliers.points()))
    if sigma_px > _MOST_RESIDUAL * max(view.camera.width_px for view in observations.views):
        raise ScaleError("board.moved", sigma_px=float(sigma_px), photos=len(observations.views))


def _without_contradicting_photos(
    inliers: CornerObservations, observations: CornerObservations
) -> tuple[CornerObservations, tuple[SetAside, ...]]:
    """Leave out photos in which most corners contradict the other photos."""
    before = np.bincount(observations.view_idx, minlength=len(observations.views))
    after = np.bincount(inliers.view_idx, minlength=len(observations.views))
    contradicting = after < _LEAST_AGREEING_SHARE * before
    doubted = tuple(
        SetAside(
            observations.views[k].name,
            doubt(
                "board.photo.contradicts",
                corners=int(before[k] - after[k]),
                seen=int(before[k]),
            ),
        )
        for k in np.flatnonzero(contradicting)
    )
    return inliers.subset(~contradicting[inliers.view_idx]), doubted


def _leave_one_out(
    observations: CornerObservations, points: Points3
) -> Float64[np.ndarray, "p n 3"]:
    """The points without each photo in turn; a point that needs the photo stays where it is."""
    replicates = [
        observations.subset(observations.view_idx != photo).points()
        for photo in np.unique(observations.view_idx)
    ]
    stack = np.array(replicates).reshape(-1, *points.shape)
    return np.where(np.isfinite(stack), stack, points)


def _sigma_px(residuals: Float64[np.ndarray, " m"]) -> float:
    """Robust sigma of one coordinate from distances of two (median of a Rayleigh distribution)."""
    known = residuals[np.isfinite(residuals)]
    return float(np.median(known)) / RAYLEIGH_MEDIAN if len(known) else 0.0


_DIRECTIONS = ("along x", "along y", "diagonal", "other diagonal")


def long_lengths(
    board_mm: Points3,
    points_in_world: Points3,
    without_photo: Float64[np.ndarray, "p n 3"],
    moves: Float64[np.ndarray, "n 3 u"] | None,
    chosen: Bool[np.ndarray, " n"],
    role: Literal["control", "check"],
) -> tuple[RulerLength, ...]:
    """The longest length in each direction between chosen corners.

    Args:
        moves: Jacobian of the points by poses and lenses.
    """
    rows = np.flatnonzero(chosen)
    return tuple(
        RulerLength(
            label=f"board, {direction}",
            known_mm=float(np.linalg.norm(board_mm[first] - board_mm[second])),
            measured=float(np.linalg.norm(points_in_world[first] - points_in_world[second])),
            sigma=jackknife_sigma(
                np.linalg.norm(without_photo[:, first] - without_photo[:, second], axis=1)
            ),
            role=role,
            between="board",
            by_cameras=None
            if moves is None
            else size_by_cameras(points_in_world[[first, second]], moves[[first, second]]),
        )
        for direction, first, second in _longest(board_mm, rows)
    )


def _longest(board_mm: Points3, rows: np.ndarray) -> Iterator[tuple[str, int, int]]:
    """The farthest pair in each direction: direction, first row, second row."""
    first, second = (rows[side] for side in np.triu_indices(len(rows), 1))
    across, down = (board_mm[second] - board_mm[first])[:, :2].T
    length = np.hypot(across, down)
    slant = np.minimum(np.abs(across), np.abs(down)) > 0.3 * length
    cases = (down == 0, across == 0, slant & (across * down > 0), slant & (across * down < 0))
    for direction, among in zip(_DIRECTIONS, cases, strict=True):
        if among.any():
            best = int(np.argmax(np.where(among, length, 0.0)))
            yield direction, int(first[best]), int(second[best])


_LEAST_CORNERS = 8
_LEAST_HALF = 3
_OUTLIER_SIGMAS = 5.0
_LEAST_OUTLIER = 0.001
"""Corners nearer to the flat board than this share of its size are never outliers."""


@dataclass(frozen=True, kw_only=True)
class SceneBoard:
    """A board located in the scene, and the scale by its corners."""

    scene_from_board: Similarity
    """Board frame in millimetres (z into the board) to the scene's world and unit."""
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

    @property
    def sure_stretch(self) -> float:
        """The stretch where it is beyond noise; 0 where it is not."""
        return self.stretch if abs(self.stretch) > _SURE_STRETCH * self.stretch_sigma else 0.0

    @property
    def relative_sigma(self) -> float:
        """Standard deviation of the scale, a fraction: measurement, and the print's own error.

        If x and y are each wrong by sigma, they differ by sqrt(2) sigma, and their mean is wrong by
        sigma / sqrt(2), half of that.
        """
        return float(np.hypot(self.ruler.relative_sigma, self.sure_stretch / 2))


_SURE_STRETCH = 3.0
"""Sigmas beyond which x and y disagree; on good captures they are 0 to 1.5 apart."""


def find_scene_board(scene: Scene, detections: BoardDetections) -> SceneBoard:
    """The board as a ruler.

    Raises:
        ScaleError: too few of its corners could be located, or they contradict each other.
    """
    located = locate_corners(scene, detections)
    control = _control_half(located.ids, detections)
    _check_enough(control, detections)
    flat = _flat_inliers(detections.corners_mm[located.ids], located.points_in_world)
    control = control[flat]
    _check_enough(control, detections)
    board_mm = detections.corners_mm[located.ids[flat]]
    points, replicates = located.points_in_world[flat], located.without_photo[:, flat]

    pose = fit_similarity(board_mm, points)
    _check_facing(pose, scene)
    width, height = (n * detections.board.square_mm for n in detections.board.squares)
    scale = fit_similarity(board_mm[control], points[control]).scale
    scales = [fit_similarity(board_mm[control], one[control]).scale for one in replicates]
    moves = _moves(scene, detections, pose, located.ids[flat])
    return SceneBoard(
        scene_from_board=pose,
        outline_mm=np.array([(0, 0, 0), (width, 0, 0), (width, height, 0), (0, height, 0)], float),
        corners=located,
        control_ids=located.ids[flat][control],
        ruler=Ruler(
            units_per_mm=scale,
            relative_sigma=jackknife_sigma(np.array(scales)) / scale,
            lengths=(
                *long_lengths(board_mm, points, replicates, moves, control, "control"),
                *long_lengths(board_mm, points, replicates, moves, ~control, "check"),
            ),
            set_aside=located.set_aside + _off_plane(located, ~flat, pose, detections),
            by_cameras=None if moves is None else size_by_cameras(points[control], moves[control]),
        ),
        check_error=fit_similarity(board_mm[~control], points[~control]).scale / scale - 1,
        stretch=_stretch(board_mm, points),
        stretch_sigma=float(
            np.hypot(
                jackknife_sigma(np.array([_stretch(board_mm, one) for one in replicates])),
                _stretch_sigma_by_cameras(scene, detections, pose, located.ids[flat]),
            )
        ),
    )


def _moves(
    scene: Scene, detections: BoardDetections, pose: Similarity, ids: Int32[np.ndarray, " n"]
) -> Float64[np.ndarray, "n 3 u"] | None:
    """Jacobian of the corners by poses and lenses; None where the scene has no covariance."""
    if scene.camera_covariance is None:
        return None
    shown = corners_shown(detections)
    return points_by_cameras(scene, shown, pose.apply(detections.corners_mm))[0][ids]


def _stretch_sigma_by_cameras(
    scene: Scene, detections: BoardDetections, pose: Similarity, ids: Int32[np.ndarray, " n"]
) -> float:
    """Standard deviation of the ratio of the board's sides due to lenses and poses."""
    if scene.camera_covariance is None:
        return 0.0
    corners = pose.apply(detections.corners_mm)
    by_cameras = stretch_by_cameras(scene, detections, corners, ids)
    return float(np.sqrt(by_cameras @ scene.camera_covariance @ by_cameras))


def _control_half(ids: np.ndarray, detections: BoardDetections) -> Bool[np.ndarray, " n"]:
    across = detections.board.inner[0]
    return (ids // across + ids % across) % 2 == 0


def _check_enough(control: Bool[np.ndarray, " n"], detections: BoardDetections) -> None:
    enough = len(control) >= _LEAST_CORNERS
    if not enough or min(control.sum(), (~control).sum()) < _LEAST_HALF:
        photos, board = len(detections.photos), detections.board.finding
        if detections.cause is not None:
            raise ScaleError("board.unseen", photos=photos, board=board, cause=detections.cause)
        raise ScaleError(
            "board.few_corners",
            corners=len(control),
            board=board,
            least=_LEAST_CORNERS,
            photos=photos,
        )


def _flat_inliers(board_mm: Points3, points: Points3) -> Bool[np.ndarray, " n"]:
    """Mask of the corners that agree with a flat board of the right proportions."""
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


def _off_plane(
    located: SceneCorners,
    off: Bool[np.ndarray, " n"],
    pose: Similarity,
    detections: BoardDetections,
) -> tuple[SetAside, ...]:
    """Mask of the corners whose residuals contradict the flat board, beyond depth noise."""
    seen = located.observations
    misses_px = seen.residuals_px(pose.apply(detections.corners_mm))
    wrong = np.isin(seen.point_idx, located.ids[off]) & (misses_px > _limit_px(located.sigma_px))
    count = int(np.sum(np.bincount(seen.point_idx[wrong]) > 1))  # one photo alone may be wrong
    return (SetAside("board", doubt("board.off_plane", corners=count)),) if count else ()


def _check_facing(pose: Similarity, scene: Scene) -> None:
    """The printed side must face the cameras, or the scene is inside out."""
    toward = np.array([view.centre_in_world - pose.translation for view in scene.views])
    if np.mean(toward @ pose.rotation[:, 2] < 0) < 0.5:
        raise ScaleError("board.back")


def _stretch(board_mm: Points3, points: Points3) -> float:
    """Length of the board's x over the length of its y in the scene, less one."""
    plane = board_mm[:, :2] - board_mm[:, :2].mean(0)
    axes = np.linalg.lstsq(plane, points - points.mean(0), rcond=None)[0]
    along_x, along_y = np.linalg.norm(axes, axis=1)
    return float(along_x / along_y) - 1


_LEAST_SHAPE_SIGMA = 1e-6
"""Smallest sigma of the shape, over the size of the board."""
_LEAST_SIGMA_PX = 1e-3


def adjusted_with_board(
    scene: Scene, scene_board: SceneBoard, detections: BoardDetections, cameras: Cameras
) -> Scene:
    """The scene adjusted once more, with its new covariance; unit and observations stay.

    Lenses that the scene holds (no variance left) are held again.
    """
    held = scene.lens_covariance is not None and not scene.lens_covariance.any()
    adjusted = adjust(
        scene,
        cameras.calibrations,
        hold_board_lenses=held,
        outlier_sigmas=np.inf,
        rounds=1,
        body=_body_of(
            scene,
            scene_board.corners,
            scene_board.control_ids,
            scene_board.scene_from_board,
            detections,
        ),
        solve_own=True,
    )
    found = replace(
        adjusted.scene,
        sigma_px=adjusted.sigma_px,
        lens_covariance=adjusted.lens_covariance,
        camera_covariance=adjusted.covariance,
    )
    return replace(  # nothing holds the size of a scene: what is known in its unit stays so
        found.moved(other_from_one(found, scene, scene.placed)),
        movement=scene.movement,
        bending=scene.bending,
        lens_explanations=scene.lens_explanations,
    )


def located_board(scene: Scene, detections: BoardDetections) -> Body | None:
    """The board's corners as the photos locate them; None where they are few or contradict each
    other."""
    try:
        corners = locate_corners(scene, detections)
    except ScaleError:
        return None
    if len(corners.ids) < _LEAST_CORNERS:
        return None
    shape_mm = detections.corners_mm[corners.ids]
    pose = fit_similarity(shape_mm, corners.points_in_world)
    body = _body_of(scene, corners, corners.ids, pose, detections)
    return replace(body, offsets=corners.points_in_world - pose.apply(shape_mm))


def _body_of(
    scene: Scene,
    corners: SceneCorners,
    ids: Int32[np.ndarray, " c"],
    scene_from_board: Similarity,
    detections: BoardDetections,
) -> Body:
    """A flat body of some of the corners that were located."""
    seen = corners.observations
    used = np.flatnonzero(np.isin(seen.point_idx, ids))
    used = used[np.lexsort((seen.view_idx[used], seen.point_idx[used]))]
    place = {view.name: k for k, view in enumerate(scene.views)}
    photo_of_view = np.array([place[view.name] for view in seen.views], np.int64)
    shape_mm = detections.corners_mm[ids]
    printed = scene_from_board.apply(detections.corners_mm[corners.ids])
    return Body(
        shape=shape_mm,
        world_from_body=scene_from_board,
        offsets=np.zeros_like(shape_mm),
        shape_sigma=_shape_sigma(corners.points_in_world - printed, scene_from_board, detections),
        photo_idx=photo_of_view[seen.view_idx[used]],
        corner_idx=np.searchsorted(ids, seen.point_idx[used]).astype(np.int64),
        xy_px=np.ascontiguousarray(seen.xy_px[used]),
        sigma_px=max(corners.sigma_px, _LEAST_SIGMA_PX),
    )


def _shape_sigma(off: Points3, scene_from_board: Similarity, detections: BoardDetections) -> float:
    """How far one coordinate of a located corner lies from the board as described."""
    size = scene_from_board.scale * float(np.ptp(detections.corners_mm, axis=0).max())
    return max(MAD_TO_SIGMA * float(np.median(np.abs(off))), _LEAST_SHAPE_SIGMA * size)


_LEAST_PHOTOS, _LENS_LEAST_CORNERS = 3, 10
_LEAST_DIFFERENCE = 0.05
"""A focal length nearer than this to the calibration's is the same lens's: focus moves it by a few
per cent."""
_SURE_SIGMAS = 5.0
_PHOTO_FACTOR, _CORNER_SIGMAS = 3.0, 5.0
"""What is left out of a calibration (calibration.screening), as there."""


def foreign_lens(scene: Scene, detections: BoardDetections, cameras: Cameras) -> Finding | None:
    """Why a calibration given is not that of the photos, by the board in them; None where it is."""
    for idx, calibration in enumerate(cameras.calibrations):
        observations = tuple(
            BoardObservation(one.name, one.ids, one.xy_px)
            for one in detections.photos
            if scene.camera_idx[one.photo_idx] == idx and len(one.ids) >= _LENS_LEAST_CORNERS
        )
        if calibration.source != "board" or len(observations) < _LEAST_PHOTOS:
            continue
        camera = calibration.camera
        try:
            solution = screen(
                observations,
                detections.corners_mm,
                (camera.width_px, camera.height_px),
                free_unknowns(k3=False, skew=False, board=False),
                min_photos=_LEAST_PHOTOS,
                photo_factor=_PHOTO_FACTOR,
                corner_sigmas=_CORNER_SIGMAS,
            ).solution
        except CalibrationError:
            continue  # these views leave the lens open: the board cannot tell
        shown_px, sigma_px = float(solution.shared[0]), float(solution.covariance[0, 0]) ** 0.5
        limit_px = max(_LEAST_DIFFERENCE * camera.fx, _SURE_SIGMAS * sigma_px)
        if abs(shown_px - camera.fx) > limit_px:
            return foreign_camera(camera.fx, shown_px, "board")
    return None
