"""Photos to add follow from the photos as they were held, not as the sensor stores them."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from limbgram.capture.camera_positions import Stand, quarter_turned
from limbgram.capture.coverage import ShownProxy, coverage_from_prediction
from limbgram.capture.photos_to_add import photos_for_hidden_places
from limbgram.capture.prediction import Showing, predict
from limbgram.capture.proxy import plain_tube
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.metric import MetricScene, Scale

LYING = Camera(width_px=1500, height_px=1000, fx=1800.0, fy=1800.0, cx=749.5, cy=499.5)
LIMB = plain_tube(np.array([0.0, 640.0]), np.array([35.0, 35.0]), 20.0)
"""So long that it fits into upright pictures alone."""
QUARTER = Rotation.from_euler("z", 90, degrees=True).as_matrix()


def asked_after(views: list[View]) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Azimuths and elevations of the photos to add to these."""
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(views[0].camera,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
    )
    floor_z_mm = float(LIMB.mesh.vertices_mm[:, 2].min()) - 10.0
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4)
    metric = MetricScene(scene=scene, scale=scale, floor_z_mm=floor_z_mm)
    found = predict(LIMB, views, Showing.alike(len(LIMB.mesh), len(views), 1.2, 20.0))
    shown = ShownProxy(LIMB, found, coverage_from_prediction(LIMB, found, in_mm=True), 0.0, None)
    asked, _, _ = photos_for_hidden_places(shown, metric, [], [])
    return [(one.azimuths_deg, one.elevations_deg) for one in asked]


def test_upright_photos_ask_for_the_same_however_the_sensor_stores_them() -> None:
    """A phone held upright, of half a round: its sensor lies, or its pictures were turned."""
    stands = [Stand(azimuth_deg=20.0 * k, elevation_deg=10.0, distance=900.0) for k in range(9)]
    turned = [
        one.view(quarter_turned(LYING), LIMB.middle, 0.0, f"{one.azimuth_deg}") for one in stands
    ]
    stored: list[View] = []
    for view in turned:
        pose = view.camera_from_world
        held = Rigid(QUARTER @ pose.rotation, QUARTER @ pose.translation)
        stored.append(replace(view, camera=LYING, camera_from_world=held))
    asked = asked_after(stored)
    assert asked
    assert asked == asked_after(turned)
