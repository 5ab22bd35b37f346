"""What cameras and scale do to a surface, on moves whose effect is known."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.core.geometry.lens import Camera, View, with_pose_step
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.measuring.thin_plate import tangent_axes
from limbgram.reconstruction.measuring.uncertainty import SharedErrors, shared_errors
from limbgram.reconstruction.scale.metric import MetricScene, Scale

PHOTOS = 8
CAMERA = Camera(width_px=900, height_px=700, fx=1800.0, fy=1810.0, cx=450.0, cy=352.0, k1=-0.1)
UNKNOWNS = 6 * PHOTOS + 10


def ring_scene() -> Scene:
    poses: list[Rigid] = []
    for k in range(PHOTOS):
        turn = 2 * np.pi * k / PHOTOS
        centre = 600.0 * np.array([np.cos(turn), np.sin(turn), 0.3 + 0.1 * (k % 2)])
        poses.append(Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 0.0, 1.0])))
    return Scene(
        names=tuple(f"{k}.jpg" for k in range(PHOTOS)),
        cameras=(CAMERA,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(poses),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
    )


def ball() -> Mesh:
    body = trimesh.creation.icosphere(subdivisions=3, radius=45.0)
    return Mesh(
        vertices_mm=np.asarray(body.vertices, float), faces=np.asarray(body.faces, np.int32)
    )


def found(scene: Scene, by_cameras: np.ndarray | None, relative_sigma: float) -> SharedErrors:
    mesh = ball()
    axes = tangent_axes(mesh.vertex_normals())
    facing = np.empty((PHOTOS, len(mesh)))
    for k, view in enumerate(scene.views):
        rays = view.centre_in_world - mesh.vertices_mm
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        facing[k] = np.einsum("ni,ni->n", rays, axes[:, 2])
    seen = np.argsort(-facing, axis=0)[:4].T.astype(np.int32)
    scale = Scale(unit="mm", source="board", relative_sigma=relative_sigma, by_cameras=by_cameras)
    metric = MetricScene(scene=scene, scale=scale)
    return shared_errors(mesh, axes, seen, np.ones(len(mesh), bool), metric)


def test_a_scale_error_grows_the_surface() -> None:
    errors = found(ring_scene(), None, 1e-3)
    np.testing.assert_allclose(errors.modes_mm[:, 0], 0.045, rtol=1e-3)
    assert errors.modes_mm.shape[1] == 1


def grown(scene: Scene) -> np.ndarray:
    """Camera numbers of the same scene one per cent larger."""
    step = np.zeros(UNKNOWNS)
    for k, view in enumerate(scene.views):
        step[6 * k + 3 : 6 * k + 6] = 0.01 * view.camera_from_world.translation
    return step


def test_cameras_that_all_move_away_grow_the_surface_where_nothing_sets_the_scale() -> None:
    scene, step = ring_scene(), grown(ring_scene())
    scene = replace(scene, camera_covariance=np.outer(step, step))
    errors = found(scene, np.zeros(UNKNOWNS), 0.0)
    np.testing.assert_allclose(np.abs(errors.modes_mm[:, 1]), 0.45, rtol=1e-3)
    without = found(scene, None, 0.0)
    assert np.abs(without.modes_mm).max() < 1e-3


def test_a_board_seen_by_the_same_cameras_undoes_that() -> None:
    scene, step = ring_scene(), grown(ring_scene())
    scene = replace(scene, camera_covariance=np.outer(step, step))
    by_cameras = -0.01 * step / (step @ step)
    assert np.abs(found(scene, by_cameras, 0.0).modes_mm).max() < 1e-6


def test_a_photo_that_moves_alone_bends_the_surface() -> None:
    step = np.zeros(UNKNOWNS)
    step[3] = 0.2
    errors = found(replace(ring_scene(), camera_covariance=np.outer(step, step)), None, 0.0)
    strongest = np.abs(errors.modes_mm[:, 1])
    assert 0.05 < strongest.max() < 0.5
    assert np.median(strongest) < 0.3 * strongest.max()


def test_the_world_frame_does_not_matter() -> None:
    random = np.random.default_rng(4)
    root = 1e-4 * random.normal(size=(UNKNOWNS, UNKNOWNS)) / np.sqrt(UNKNOWNS)
    root[48:] = 0.0
    scene = replace(ring_scene(), camera_covariance=root @ root.T)
    there = Similarity(
        0.02, Rigid.from_rotation_vector(np.array([0.3, -1.0, 0.4]), np.zeros(3)).rotation,
        np.array([30.0, -700.0, 55.0]),
    )  # fmt: skip
    back = scene.moved(there).moved(there.inverse)
    np.testing.assert_allclose(
        back.camera_covariance, scene.camera_covariance, atol=1e-9 * 1e-4, rtol=1e-6
    )


def test_the_covariance_in_another_frame_speaks_of_the_same_moves() -> None:
    """A drawn step, applied in both frames, moves a point's pixel alike."""
    scene = ring_scene()
    step = np.zeros(UNKNOWNS)
    step[:6] = [2e-6, -1e-6, 3e-6, 0.0005, 0.001, -0.002]
    there = Similarity(0.02, np.eye(3)[[1, 2, 0]], np.array([30.0, -700.0, 55.0]))
    moved = replace(scene, camera_covariance=np.outer(step, step)).moved(there)
    assert moved.camera_covariance is not None
    values, vectors = np.linalg.eigh(moved.camera_covariance)
    new_step = vectors[:, -1] * np.sqrt(values[-1])
    new_step *= np.sign(new_step[0] * step[0])
    point = np.array([[12.0, -20.0, 31.0]])
    pixels = [
        _pixel(scene.view(0), step, point) - scene.view(0).project(point),
        _pixel(moved.view(0), new_step, there.apply(point))
        - moved.view(0).project(there.apply(point)),
    ]
    np.testing.assert_allclose(pixels[0], pixels[1], rtol=1e-3)
    assert np.abs(pixels[0]).max() > 1e-3


def _pixel(view: View, step: np.ndarray, point: np.ndarray) -> np.ndarray:
    row = with_pose_step(view.packed, step[:6])
    pose = Rigid(row[:9].reshape(3, 3), row[9:12])
    return View(view.name, view.camera, pose).project(point)


@pytest.mark.parametrize("number", [0, 2])
def test_a_lens_error_reaches_the_surface(number: int) -> None:
    step = np.zeros(UNKNOWNS)
    step[48 + number] = 1.0
    errors = found(replace(ring_scene(), camera_covariance=np.outer(step, step)), None, 0.0)
    assert np.abs(errors.modes_mm[:, 1]).max() > 1e-4
