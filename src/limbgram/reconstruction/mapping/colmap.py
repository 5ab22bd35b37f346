"""The boundary to pycolmap's incremental mapper: the only file that knows its conventions.

In      keypoints, verified pairs, cameras.
Out     one scene per connected component, largest first, without verdicts and not yet adjusted
        with our own lens model.
There   the centre of the top left pixel is (0.5, 0.5); ids count from 1; a camera has no skew,
        which is therefore taken out of the keypoints; all in memory, one thread, seeded, so that
        the same input gives the same scene.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import FROM_CORNER_PX, OPENCV, Camera, without_skew
from limbgram.core.run import signal_handlers_kept, track
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair

with signal_handlers_kept():
    import pycolmap

_FEWEST_MATCHES = 15
_SMALLEST_MODEL = 3
_CONFIGURATIONS = {
    "general": pycolmap.TwoViewGeometryConfiguration.CALIBRATED,
    "planar": pycolmap.TwoViewGeometryConfiguration.PLANAR,
    "rotation": pycolmap.TwoViewGeometryConfiguration.PANORAMIC,
}


class MapperSettings(NamedTuple):
    """What the mapper starts from, and what it asks of a photo."""

    fewest_points: int
    """Inliers with which a photo is registered."""
    seed: int = 0
    pair: tuple[int, int] | None = None
    """Initial pair; the mapper's choice if None."""


def map_incrementally(
    photos: PhotoSet,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    cameras: Cameras,
    held: Sequence[bool],
    settings: MapperSettings,
    own_sigmas_px: Sequence[Float64[np.ndarray, " k"]] | None = None,
) -> tuple[Scene, ...]:
    """Incremental mapping: initial pair, resection of each next photo, triangulation, adjustment.

    Lenses that are not held are refined as one focal length and one radial term.

    Args:
        held: By camera, whether its lens stays as it is.
        keypoints_px: Keypoints of every photo, in the order that the pairs number them.
        settings: With an initial pair given, only one scene is built.
        own_sigmas_px: By photo and keypoint, of corners of coded marks; zero for others.
    """
    pycolmap.logging.minloglevel = pycolmap.logging.ERROR.value
    with pycolmap.Database.open(":memory:") as database:
        _write_photos(database, photos, keypoints_px, cameras)
        for pair in pairs.verified:
            _write_pair(database, pair)
        cache = pycolmap.DatabaseCache.create(database, pycolmap.DatabaseCacheOptions())
    manager = pycolmap.ReconstructionManager()
    pipeline = pycolmap.IncrementalPipeline(_options(held, settings), cache, manager)
    steps = track(range(len(photos.photos)))

    def one_more() -> None:
        next(steps, None)

    events = pycolmap.IncrementalPipelineCallback
    pipeline.add_callback(events.NEXT_IMAGE_REG_CALLBACK, one_more)
    pipeline.run()
    models = [manager.get(idx) for idx in range(manager.size())]
    models.sort(key=lambda model: (-model.num_reg_images(), -model.num_points3D()))
    return tuple(_scene(model, photos, keypoints_px, cameras, own_sigmas_px) for model in models)


def _options(held: Sequence[bool], settings: MapperSettings) -> pycolmap.IncrementalPipelineOptions:
    options = pycolmap.IncrementalPipelineOptions()
    options.extract_colors = False
    options.num_threads = 1
    options.random_seed = settings.seed
    if settings.pair is not None:
        options.init_image_id1, options.init_image_id2 = (photo + 1 for photo in settings.pair)
        options.multiple_models = False
    options.min_num_matches = _FEWEST_MATCHES
    options.min_model_size = _SMALLEST_MODEL
    options.mapper.abs_pose_min_num_inliers = settings.fewest_points
    options.constant_cameras = {idx + 1 for idx, one in enumerate(held) if one}
    options.ba_refine_principal_point = False
    options.ba_global_frames_ratio = options.ba_global_points_ratio = 1.5
    options.ba_local_max_refinements = options.ba_global_max_refinements = 1
    options.ba_local_function_tolerance = options.ba_global_function_tolerance = 1e-5
    return options


def _write_photos(
    database: pycolmap.Database, photos: PhotoSet, keypoints_px: Sequence[Points2], cameras: Cameras
) -> None:
    for idx, given in enumerate(cameras.calibrations):
        database.write_camera(_colmap_camera(given, idx + 1), use_camera_id=True)
    for idx, (photo, places) in enumerate(zip(photos.photos, keypoints_px)):
        image = pycolmap.Image(name=photo.name, camera_id=photo.camera_idx + 1, image_id=idx + 1)
        database.write_image(image, use_image_id=True)
        camera = cameras.calibrations[photo.camera_idx].camera
        xy_px = without_skew(camera, places) + FROM_CORNER_PX
        database.write_keypoints(idx + 1, xy_px.astype(np.float32))


def _write_pair(database: pycolmap.Database, pair: VerifiedPair) -> None:
    geometry = pycolmap.TwoViewGeometry()
    geometry.config = int(_CONFIGURATIONS[pair.kind])
    geometry.inlier_matches = np.ascontiguousarray(pair.matches.keypoint_idx, np.uint32)
    first, second = pair.matches.first + 1, pair.matches.second + 1
    database.write_two_view_geometry(first, second, geometry)


def _colmap_camera(given: Calibration, camera_id: int) -> pycolmap.Camera:
    lens = given.camera
    centre = [lens.cx + FROM_CORNER_PX, lens.cy + FROM_CORNER_PX]
    if given.source != "board":
        model, parameters = "SIMPLE_RADIAL", [(lens.fx + lens.fy) / 2, *centre, lens.k1]
    else:
        bends = lens.coefficients("COLMAP", OPENCV, PlacementError)
        model, parameters = "FULL_OPENCV", [lens.fx, lens.fy, *centre, *bends, 0.0, 0.0, 0.0]
    camera = pycolmap.Camera(
        model=model, width=lens.width_px, height=lens.height_px, params=parameters
    )
    camera.camera_id = camera_id
    camera.has_prior_focal_length = True
    return camera


def _scene(
    model: pycolmap.Reconstruction,
    photos: PhotoSet,
    keypoints_px: Sequence[Points2],
    cameras: Cameras,
    own_sigmas_px: Sequence[Float64[np.ndarray, " k"]] | None,
) -> Scene:
    poses: list[Rigid | None] = [None] * len(photos.photos)
    for image_id in model.reg_image_ids():
        pose = model.image(image_id).cam_from_world()
        poses[image_id - 1] = Rigid(
            np.array(pose.rotation.matrix(), float), np.array(pose.translation, float)
        )
    ids = sorted(model.points3D)
    points = [model.points3D[point_id] for point_id in ids]
    elements = _elements(points)
    xy_px = np.empty((len(elements), 2))
    own_sigma_px = None if own_sigmas_px is None else np.empty(len(elements))
    for photo_idx, places in enumerate(keypoints_px):
        rows = elements[:, 0] == photo_idx
        xy_px[rows] = places[elements[rows, 1]]
        if own_sigmas_px is not None and own_sigma_px is not None:
            own_sigma_px[rows] = own_sigmas_px[photo_idx][elements[rows, 1]]
    return Scene(
        names=photos.names,
        cameras=tuple(
            _lens(model, idx + 1, given) for idx, given in enumerate(cameras.calibrations)
        ),
        camera_idx=tuple(photo.camera_idx for photo in photos.photos),
        camera_from_world=tuple(poses),
        points_in_world=np.array([point.xyz for point in points], float).reshape(-1, 3),
        observations=Observations(
            np.ascontiguousarray(elements[:, 0]),
            np.ascontiguousarray(elements[:, 2]),
            xy_px,
            own_sigma_px,
        ),
        verdicts=(),
    )


def _elements(points: Sequence[pycolmap.Point3D]) -> Int32[np.ndarray, "m 3"]:
    """Photo, keypoint and point index of every observation, sorted by point, then photo."""
    rows = [
        (element.image_id - 1, element.point2D_idx, point_idx)
        for point_idx, point in enumerate(points)
        for element in point.track.elements
    ]
    elements = np.array(rows, np.int32).reshape(-1, 3)
    return elements[np.lexsort((elements[:, 1], elements[:, 0], elements[:, 2]))]


def _lens(model: pycolmap.Reconstruction, camera_id: int, given: Calibration) -> Camera:
    if given.source == "board" or camera_id not in model.cameras:
        return given.camera
    focal, cx, cy, k1 = (float(value) for value in model.cameras[camera_id].params)
    return replace(
        given.camera.pinhole,
        fx=focal,
        fy=focal,
        cx=cx - FROM_CORNER_PX,
        cy=cy - FROM_CORNER_PX,
        k1=k1,
    )
