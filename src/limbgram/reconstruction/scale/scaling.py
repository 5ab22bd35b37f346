"""Scale: scene units to millimetres, and the world's frame.

In      a Scene; a board of known size lying in it, known distances, both or neither.
Out     a MetricScene, the only scene that the dense stages accept.
Method  A part of the known lengths sets the scale, the rest checks it. A board's corners of the
        first part also join photos, lenses and points in a last adjustment. Without any length the
        scene is made unitless on purpose: the cameras are 1000 units from what they look at.
Fails   ScaleError: a source that cannot be measured, or known lengths that contradict each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from limbgram.core.errors import ScaleError
from limbgram.core.geometry.arrays import Matrix3, Vector3
from limbgram.core.geometry.frames import Similarity, fit_similarity
from limbgram.core.interval import chi_square_tail
from limbgram.core.tape import CONTRADICTS_SIGMAS
from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.score_tests import SIGNIFICANCE_LEVEL
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.board import (
    SceneBoard,
    adjusted_with_board,
    find_scene_board,
    foreign_lens,
)
from limbgram.reconstruction.scale.displaced_board import without_displaced_board
from limbgram.reconstruction.scale.distances import measure_distances
from limbgram.reconstruction.scale.floor import (
    MOST_BELOW,
    centre_of_object,
    common_up,
    find_floor,
    rotation_to_z,
)
from limbgram.reconstruction.scale.metric import LengthCheck, MetricScene, Scale, StretchDoubt
from limbgram.reconstruction.scale.ruler import Ruler, scale_by_cameras
from limbgram.reconstruction.scale.stated_lengths import KnownDistance
from limbgram.reconstruction.scale.visibility import Aim, aim_of
from limbgram.reconstruction.targets.board import BoardDetections

_MOVED_PX = 0.3
"""Largest sigma of the corners of a board that kept still: these have 0.05 to 0.15 px."""


def check_scene_board(
    scene_board: SceneBoard, max_disagreement: float, scene: Scene, by: StretchDoubt = "none"
) -> None:
    """Refuse a board that is seen too poorly, is stretched, or whose halves disagree.

    Args:
        by: What may have stretched the scene, and the board with it: then it is no fact of the
            board, and is refused only where it leaves the scale less sure than is allowed.
    """
    sigma = scene_board.ruler.relative_sigma
    if not sigma <= max_disagreement:
        raise ScaleError("board.unsure", sigma=float(sigma), allowed=max_disagreement)
    stretch = scene_board.sure_stretch
    sure = abs(stretch) if by == "none" else scene_board.relative_sigma
    if stretch and sure > max_disagreement:
        longer, shorter = ("x", "y") if stretch > 0 else ("y", "x")
        raise ScaleError(
            "board.stretched" if by == "none" else "board.stretched_or_lens",
            stretch=abs(float(stretch)),
            longer=longer,
            shorter=shorter,
            allowed=max_disagreement if by == "none" else 2 * max_disagreement,
            moved=_moved(scene_board, scene),
            **({} if by == "none" else {"by": by}),
        )
    if abs(scene_board.check_error) > max_disagreement:
        raise ScaleError(
            "board.halves_disagree",
            error=float(scene_board.check_error),
            allowed=max_disagreement,
        )


def _stretch_doubt(scene: Scene, cameras: Cameras | None) -> StretchDoubt:
    """What may have stretched the scene; "none" where the cameras are not given."""
    if cameras is not None and any(one.source != "board" for one in cameras.calibrations):
        return "uncalibrated"
    rolling = scene.own is not None and "rolling shutter" in scene.own.deviations
    return "rolling shutter" if rolling else "none"


def _moved(scene_board: SceneBoard, scene: Scene) -> Finding | None:
    """The finding that the board was pushed; None where it kept still."""
    corners = scene_board.corners
    if scene.movement is not None and scene.movement.moved:
        seen = note("board.seen_moved.limb")
    elif corners.set_aside:
        seen = note("board.seen_moved.photo", photo=corners.set_aside[0].name)
    elif corners.sigma_px > _MOVED_PX:
        seen = note("board.seen_moved.corners", sigma_px=float(corners.sigma_px))
    else:
        return None
    return doubt("board.probably_moved", seen=seen)


def check_lengths(scale: Scale, max_disagreement: float, of_board: int = 0) -> None:
    """Refuse where a length, whether it set the scale or checks it, contradicts the scale.

    A typed one, by the rule of `core.tape`, contradicts only where it is off by more than its sigma
    explains: that of its picks, of lens and poses, of what else set the scale, and of its tape.

    Args:
        of_board: Number of lengths, the first ones, on the board that sets the scale. They are the
            longest between few corners, so noise may take one of them past what is allowed; it
            contradicts only if that is significant.
    """
    wrong = [
        one
        for k, one in enumerate(scale.lengths)
        if not abs(one.error) <= max_disagreement
        and not (
            _is_noise(one, of_board, max_disagreement)
            if k < of_board
            else abs(one.measured_mm - one.known_mm) <= CONTRADICTS_SIGMAS * one.sigma_mm
        )
    ]
    if wrong:
        worst = max(wrong, key=lambda one: abs(one.error))
        others = tuple(one.label for one in scale.lengths if one.role == "control")
        raise ScaleError(
            "scale.length_disagrees",
            label=worst.label,
            known_mm=worst.known_mm,
            measured_mm=float(worst.measured_mm),
            error=float(worst.error),
            sigma_mm=float(worst.sigma_mm),
            others=others,
            allowed=max_disagreement,
            cause=_cause(scale, worst, any(worst is one for one in scale.lengths[:of_board])),
        )


def _is_noise(length: LengthCheck, compared: int, max_disagreement: float) -> bool:
    """Whether allowed noise explains the error of the worst of so many lengths."""
    if not length.sigma_mm <= max_disagreement * length.known_mm:
        return False
    off_mm = abs(length.measured_mm - length.known_mm)
    return off_mm == 0 or (
        length.sigma_mm > 0
        and compared * chi_square_tail((off_mm / length.sigma_mm) ** 2, 1) > SIGNIFICANCE_LEVEL
    )


def _cause(scale: Scale, worst: LengthCheck, on_board: bool) -> Finding:
    """The finding of what may be wrong, with what may have stretched the scene."""
    by = scale.stretch_doubt
    poor = worst.sigma_mm > abs(worst.measured_mm - worst.known_mm) / 2
    if poor and (by == "none" or not on_board):
        return doubt("scale.cause.poor", by=by)
    if scale.source == "distances":
        return doubt("scale.cause.mistyped", by=by)
    if by != "none":
        return doubt("scale.cause.board_or_lens", by=by, typed=not on_board)
    return doubt("scale.cause.board")


_UNITLESS_DISTANCE = 1000.0
_BELOW = 0.03
"""Distance below the board from which points count as below, in half frames."""


_MAX_DISAGREEMENT = 0.003
"""Accepted difference between a checked length and the scale, as a fraction."""
_PICK_SIGMA_PX = 0.5
"""Standard deviation of one coordinate of a point picked by hand."""


@dataclass(frozen=True, kw_only=True)
class ScaleOptions:
    """How the scale and the floor are found."""

    seed: int = 0
    """For finding the floor's plane."""


DEFAULTS = ScaleOptions()


def to_millimetres(
    scene: Scene,
    detections: BoardDetections | None = None,
    distances: Sequence[KnownDistance] = (),
    options: ScaleOptions = DEFAULTS,
    cameras: Cameras | None = None,
    quarter_turns: Sequence[int] = (),
) -> MetricScene:
    """Scale and turn a scene so that one unit is one millimetre and +Z is up.

    With `cameras`, the calibrations that the scene's lenses started from, a board takes part in one
    more adjustment of the scene. Without them the scene keeps its form.
    With a board the origin is its centre, x runs along its columns and z = 0 is the floor.
    Otherwise the origin is the object's centre, and the floor is known where points show it.

    Args:
        quarter_turns: By photo, as `PhotoSet.quarter_turns` has them: where no floor is known, +Z
            is up as the photos were held. None: all are stored upright.
    """
    try:
        return _scaled(scene, detections, distances, options, cameras, quarter_turns)
    except ScaleError as refusal:
        if detections is None or cameras is None:
            raise
        cause = foreign_lens(scene, detections, cameras)
        if cause is None:
            raise
        raise ScaleError("board.unmeasured", cause=cause) from refusal


def _scaled(
    scene: Scene,
    detections: BoardDetections | None,
    distances: Sequence[KnownDistance],
    options: ScaleOptions,
    cameras: Cameras | None,
    quarter_turns: Sequence[int],
) -> MetricScene:
    pushed: tuple[SetAside, ...] = ()
    told_apart = scene.movement is not None and scene.movement.moved  # and so were the corners
    if detections is not None and not told_apart:
        agreeing = without_displaced_board(scene, detections)
        pushed = agreeing.set_aside[len(detections.set_aside) :]
        detections = agreeing
    scene_board = find_scene_board(scene, detections) if detections is not None else None
    if scene_board is not None and detections is not None and cameras is not None:
        scene = adjusted_with_board(scene, scene_board, detections, cameras)
        scene_board = find_scene_board(scene, detections)
    aim = aim_of(scene.views, scene.points_in_world)
    turns = [quarter_turns[k] for k in scene.placed] if quarter_turns else []
    rulers: list[Ruler] = []
    if scene_board is not None:
        rulers.append(replace(scene_board.ruler, relative_sigma=scene_board.relative_sigma))
    if distances:
        typed = measure_distances(
            scene, distances, _PICK_SIGMA_PX, all_check=scene_board is not None
        )
        rulers.append(typed)
    if not rulers:
        return _unitless(scene, aim, turns, options)
    scale = _scale(rulers, "distances" if scene_board is None else "board", scene)
    scale = replace(scale, stretch_doubt=_stretch_doubt(scene, cameras))
    if scene_board is not None:
        scale = replace(
            scale,
            board_stretch=scene_board.sure_stretch,
            set_aside=(*pushed, *scale.set_aside),
        )
    if scene_board is not None:
        check_scene_board(scene_board, _MAX_DISAGREEMENT, scene, scale.stretch_doubt)
    of_board = 0 if scene_board is None else len(scene_board.ruler.lengths)
    check_lengths(scale, _MAX_DISAGREEMENT, of_board)
    mm_per_unit = 1 / rulers[0].units_per_mm
    if scene_board is not None:
        metric = _on_board(scene, aim, scene_board, mm_per_unit, scale)
        return _with_sensitivity(metric, scene_board, detections)
    metric = _on_floor(scene, aim, turns, mm_per_unit, scale, options.seed)
    return _with_sensitivity_of_lengths(metric, distances)


def _scale(rulers: Sequence[Ruler], source: Literal["board", "distances"], scene: Scene) -> Scale:
    """The first ruler's scale, with the lengths of all."""
    units_per_mm = rulers[0].units_per_mm
    return Scale(
        unit="mm",
        source=source,
        relative_sigma=rulers[0].relative_sigma,
        lengths=tuple(
            LengthCheck(
                label=one.label,
                known_mm=one.known_mm,
                measured_mm=one.measured / units_per_mm,
                sigma_mm=rulers[0].sigma_of(one, scene) / units_per_mm,
                role=one.role,
                between=one.between,
                marks=one.marks,
            )
            for ruler in rulers
            for one in ruler.lengths
        ),
        set_aside=tuple(one for ruler in rulers for one in ruler.set_aside),
    )


def _with_sensitivity(
    metric: MetricScene, scene_board: SceneBoard, detections: BoardDetections | None
) -> MetricScene:
    """The same scene with the Jacobian of its scale by poses and lenses."""
    if detections is None:
        return metric
    outline = np.array(metric.board_corners_mm)
    world_from_board = fit_similarity(scene_board.outline_mm, outline, with_scale=False)
    by_cameras = scale_by_cameras(
        metric.scene, detections, world_from_board.apply(detections.corners_mm)
    )
    return replace(metric, scale=replace(metric.scale, by_cameras=by_cameras))


def _with_sensitivity_of_lengths(
    metric: MetricScene, distances: Sequence[KnownDistance]
) -> MetricScene:
    """The same for a scale that is set by known distances; as it is without a covariance."""
    ruler = measure_distances(metric.scene, distances, _PICK_SIGMA_PX, all_check=False)
    if ruler.by_cameras is None:
        return metric
    return replace(metric, scale=replace(metric.scale, by_cameras=-ruler.by_cameras))


def _on_board(
    scene: Scene, aim: Aim, scene_board: SceneBoard, mm_per_unit: float, scale: Scale
) -> MetricScene:
    """The scene with axes along the board; this is the floor unless the object extends below."""
    centre = scene_board.scene_from_board.apply(scene_board.outline_mm).mean(0)
    x, y, z = scene_board.scene_from_board.rotation.T
    world_from_scene = _similarity_to(centre, np.array([x, -y, -z]), mm_per_unit)
    moved = scene.moved(world_from_scene)
    near = np.linalg.norm(scene.points_in_world - aim.point, axis=1) < aim.reach
    heights = moved.points_in_world[near, 2]
    is_floor = np.mean(heights < -_BELOW * aim.reach * mm_per_unit) <= MOST_BELOW
    outline = world_from_scene.apply(scene_board.scene_from_board.apply(scene_board.outline_mm))
    return MetricScene(
        scene=moved,
        scale=scale,
        floor_z_mm=0.0 if is_floor else None,
        board_corners_mm=tuple(outline),
    )


def _on_floor(
    scene: Scene, aim: Aim, turns: Sequence[int], mm_per_unit: float, scale: Scale, seed: int
) -> MetricScene:
    """The scene with +Z up by the floor's plane, or by how the photos were held."""
    floor = find_floor(scene.views, scene.points_in_world, aim, seed)
    up = common_up(scene.views, aim, turns) if floor is None else floor.normal
    origin = centre_of_object(scene.points_in_world, aim)
    moved = scene.moved(_similarity_to(origin, rotation_to_z(up), mm_per_unit))
    height = None if floor is None else -float(floor.above(origin[None])[0]) * mm_per_unit
    return MetricScene(scene=moved, scale=scale, floor_z_mm=height)


def _unitless(scene: Scene, aim: Aim, turns: Sequence[int], options: ScaleOptions) -> MetricScene:
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    return _on_floor(scene, aim, turns, _UNITLESS_DISTANCE / aim.distance, scale, options.seed)


def _similarity_to(origin: Vector3, axes: Matrix3, scale: float) -> Similarity:
    """The similarity that makes `origin` the origin and the rows of `axes` the axes."""
    return Similarity(scale, axes, -scale * axes @ origin)
