"""Joining: the board takes part in one last adjustment of photos, lenses and points.

A board's corners are seen in more photos, and more sharply, than any spot of the skin. Those that
set the scale join all scene points as a body of known shape and free size; those that check it stay
out, so that they go on checking. How far a print is from its shape is read off the corners as they
were located before, so a bent board still ties photos together but does not bend them.
"""

from dataclasses import replace

import numpy as np

from limbgram.calibration.cameras import Cameras
from limbgram.mapping.adjustment import Body, adjust
from limbgram.mapping.scene import Scene
from limbgram.scale.plate.plate import Plate
from limbgram.targets.detections import BoardDetections

_MAD_TO_SIGMA = 1.4826
_LEAST_SHAPE_SIGMA = 1e-6
"""In sizes of the board."""
_LEAST_SIGMA_PX = 1e-3


def adjusted_with_board(
    scene: Scene, plate: Plate, detections: BoardDetections, cameras: Cameras
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
        body=_body_of(scene, plate, detections),
    )
    return replace(
        adjusted.scene,
        sigma_px=adjusted.sigma_px,
        lens_covariance=adjusted.lens_covariance,
        camera_covariance=adjusted.covariance,
    )


def _body_of(scene: Scene, plate: Plate, detections: BoardDetections) -> Body:
    seen = plate.corners.sightings
    used = np.flatnonzero(np.isin(seen.point_idx, plate.control_ids))
    used = used[np.lexsort((seen.view_idx[used], seen.point_idx[used]))]
    place = {view.name: k for k, view in enumerate(scene.views)}
    photo_of_view = np.array([place[view.name] for view in seen.views], np.int64)
    shape_mm = detections.corners_mm[plate.control_ids]
    return Body(
        shape=shape_mm,
        world_from_body=plate.scene_from_board,
        offsets=np.zeros_like(shape_mm),
        shape_sigma=_shape_sigma(plate, detections),
        photo_idx=photo_of_view[seen.view_idx[used]],
        corner_idx=np.searchsorted(plate.control_ids, seen.point_idx[used]).astype(np.int64),
        xy_px=np.ascontiguousarray(seen.xy_px[used]),
        sigma_px=max(plate.corners.sigma_px, _LEAST_SIGMA_PX),
        camera=scene.cameras[0],
    )


def _shape_sigma(plate: Plate, detections: BoardDetections) -> float:
    """How far one coordinate of a located corner lies from the board as described."""
    printed = plate.scene_from_board.apply(detections.corners_mm[plate.corners.ids])
    off = float(np.median(np.abs(plate.corners.points_in_world - printed)))
    size = plate.scene_from_board.scale * float(np.ptp(detections.corners_mm, axis=0).max())
    return max(_MAD_TO_SIGMA * off, _LEAST_SHAPE_SIGMA * size)
