"""Scale: scene units to millimetres, and the world's frame.

In      a Scene; a board of known size lying in it, known distances, both or neither.
Out     a MetricScene, the only scene that the dense stages accept.
Method  a part of the known lengths sets the scale, the rest checks it. A board's corners of the
        first part also join photos, lenses and points in a last adjustment. Without any length the
        scene is made unitless on purpose: the cameras are 1000 units from what they look at.
Fails   ScaleError: a source that cannot be measured, or lengths that contradict each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from limbgram.calibration.cameras import Cameras
from limbgram.errors import ScaleError
from limbgram.geometry.arrays import Matrix3, Vector3
from limbgram.geometry.similarity import Similarity, fit_similarity
from limbgram.mapping.scene import Scene
from limbgram.scale.distances import KnownDistance, measure_distances
from limbgram.scale.frame import centre_of_object, common_up, find_floor, rotation_to_z
from limbgram.scale.metric import LengthCheck, MetricScene, Scale
from limbgram.scale.plate import Plate, adjusted_with_board, find_plate, foreign_lens
from limbgram.scale.ruler import Ruler
from limbgram.scale.sensitivity import scale_by_cameras
from limbgram.scale.sight import Aim, aim_of
from limbgram.scale.verdict import check_lengths, check_plate
from limbgram.targets.detections import BoardDetections

_UNITLESS_DISTANCE = 1000.0
_MOST_BELOW = 0.02
"""Share of the points near the aim that may lie below a board which is the floor."""
_BELOW = 0.03
"""How far below, in half frames."""


@dataclass(frozen=True, kw_only=True)
class ScaleOptions:
    """How closely known lengths must agree."""

    max_disagreement: float = 0.003
    """Accepted difference between a checked length and the scale, as a fraction."""
    pick_sigma_px: float = 0.5
    """Standard deviation of one coordinate of a point picked by hand."""
    seed: int = 0
    """For finding the floor's plane."""


DEFAULTS = ScaleOptions()


def to_millimetres(
    scene: Scene,
    detections: BoardDetections | None = None,
    distances: Sequence[KnownDistance] = (),
    options: ScaleOptions = DEFAULTS,
    cameras: Cameras | None = None,
) -> MetricScene:
    """Scale and turn a scene so that one unit is one millimetre and +Z is up.

    With `cameras`, the calibrations that the scene's lenses started from, a board takes part in one
    more adjustment of the scene. Without them the scene keeps its form.
    With a board the origin is its centre, x runs along its columns and z = 0 is the floor.
    Otherwise the origin is the object's centre, and the floor is known where points show it.
    """
    try:
        return _scaled(scene, detections, distances, options, cameras)
    except ScaleError as refusal:
        if detections is None or cameras is None:
            raise
        cause = foreign_lens(scene, detections, cameras)
        if cause is None:
            raise
        raise ScaleError(f"The board cannot be measured in these photos. {cause}") from refusal


def _scaled(
    scene: Scene,
    detections: BoardDetections | None,
    distances: Sequence[KnownDistance],
    options: ScaleOptions,
    cameras: Cameras | None,
) -> MetricScene:
    plate = find_plate(scene, detections) if detections is not None else None
    if plate is not None and detections is not None and cameras is not None:
        scene = adjusted_with_board(scene, plate, detections, cameras)
        plate = find_plate(scene, detections)
    aim = aim_of(scene.views, scene.points_in_world)
    rulers = [] if plate is None else [plate.ruler]
    if distances:
        typed = measure_distances(
            scene, distances, options.pick_sigma_px, all_check=plate is not None
        )
        rulers.append(typed)
    if not rulers:
        return _unitless(scene, aim, options)
    scale = _scale(rulers, "distances" if plate is None else "board")
    if plate is not None:
        check_plate(plate, options.max_disagreement)
    check_lengths(scale, options.max_disagreement)
    mm_per_unit = 1 / rulers[0].units_per_mm
    if plate is not None:
        metric = _on_plate(scene, aim, plate, mm_per_unit, scale)
        return _with_sensitivity(metric, plate, detections)
    return _on_floor(scene, aim, mm_per_unit, scale, options.seed)


def _scale(rulers: Sequence[Ruler], source: Literal["board", "distances"]) -> Scale:
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
                sigma_mm=one.sigma / units_per_mm,
                role=one.role,
            )
            for ruler in rulers
            for one in ruler.lengths
        ),
        set_aside=tuple(one for ruler in rulers for one in ruler.set_aside),
    )


def _with_sensitivity(
    metric: MetricScene, plate: Plate, detections: BoardDetections | None
) -> MetricScene:
    """The same scene, knowing how its scale hangs on its cameras."""
    if detections is None:
        return metric
    outline = np.array(metric.board_corners_mm)
    world_from_board = fit_similarity(plate.outline_mm, outline, with_scale=False)
    by_cameras = scale_by_cameras(
        metric.scene, detections, world_from_board.apply(detections.corners_mm)
    )
    return replace(metric, scale=replace(metric.scale, by_cameras=by_cameras))


def _on_plate(
    scene: Scene, aim: Aim, plate: Plate, mm_per_unit: float, scale: Scale
) -> MetricScene:
    """World axes along the board; it is the floor unless much of the object lies behind it."""
    centre = plate.scene_from_board.apply(plate.outline_mm).mean(0)
    x, y, z = plate.scene_from_board.rotation.T
    world_from_scene = _moved_to(centre, np.array([x, -y, -z]), mm_per_unit)
    moved = scene.moved(world_from_scene)
    near = np.linalg.norm(scene.points_in_world - aim.point, axis=1) < aim.reach
    heights = moved.points_in_world[near, 2]
    is_floor = np.mean(heights < -_BELOW * aim.reach * mm_per_unit) <= _MOST_BELOW
    outline = world_from_scene.apply(plate.scene_from_board.apply(plate.outline_mm))
    return MetricScene(
        scene=moved,
        scale=scale,
        floor_z_mm=0.0 if is_floor else None,
        board_corners_mm=tuple(outline),
    )


def _on_floor(scene: Scene, aim: Aim, mm_per_unit: float, scale: Scale, seed: int) -> MetricScene:
    """World axes by the floor's plane, or by how the photos were held."""
    floor = find_floor(scene.views, scene.points_in_world, aim, seed)
    up = common_up(scene.views, aim) if floor is None else floor.normal
    origin = centre_of_object(scene.points_in_world, aim)
    moved = scene.moved(_moved_to(origin, rotation_to_z(up), mm_per_unit))
    height = None if floor is None else -float(floor.above(origin[None])[0]) * mm_per_unit
    return MetricScene(scene=moved, scale=scale, floor_z_mm=height)


def _unitless(scene: Scene, aim: Aim, options: ScaleOptions) -> MetricScene:
    scale = Scale(unit="unitless", source="none", relative_sigma=float("nan"))
    return _on_floor(scene, aim, _UNITLESS_DISTANCE / aim.distance, scale, options.seed)


def _moved_to(origin: Vector3, axes: Matrix3, scale: float) -> Similarity:
    """The similarity that makes `origin` the origin and the rows of `axes` the axes."""
    return Similarity(scale, axes, -scale * axes @ origin)
