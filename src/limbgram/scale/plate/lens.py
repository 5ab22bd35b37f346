"""Lens: the focal length that a board shows in the photos of a scene, to tell whose fault it is.

Corners that miss each other blame the board, but a camera file of another lens does the same. The
board is a calibration target too: seen from three sides it tells the focal length by itself.
"""

from limbgram.calibration import Cameras, foreign_camera
from limbgram.calibration.adjustment import Sighting
from limbgram.calibration.screening import free_unknowns, screen
from limbgram.errors import CalibrationError
from limbgram.mapping.scene import Scene
from limbgram.targets.detections import BoardDetections

_LEAST_PHOTOS, _LEAST_CORNERS = 3, 10
_LEAST_DIFFERENCE = 0.05
"""A focal length nearer than this to the calibration's is the same lens's: focus moves it by a few
per cent."""
_SURE_SIGMAS = 5.0
_PHOTO_FACTOR, _CORNER_SIGMAS = 3.0, 5.0
"""What is left out of a calibration (calibration.screening), as there."""


def foreign_lens(scene: Scene, detections: BoardDetections, cameras: Cameras) -> str | None:
    """Why a calibration given is not that of the photos, by the board in them; None where it is."""
    for idx, calibration in enumerate(cameras.calibrations):
        sightings = tuple(
            Sighting(one.name, one.ids, one.xy_px)
            for one in detections.photos
            if scene.camera_idx[one.photo_idx] == idx and len(one.ids) >= _LEAST_CORNERS
        )
        if calibration.source != "board" or len(sightings) < _LEAST_PHOTOS:
            continue
        camera = calibration.camera
        try:
            solution = screen(
                sightings,
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
            return foreign_camera(camera.fx, shown_px, "the board in them shows")
    return None
