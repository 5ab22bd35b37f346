"""The measured surface against a painted ball whose photos are computed point by point."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.folds import find_folds
from limbgram.core.mesh.mesh import Mesh, Repairs
from limbgram.core.mesh.topology import boundary_half_edges, with_faces
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.measuring.measurement import MeasureOptions, measure
from limbgram.reconstruction.measuring.measurement_pass import ResidualOptions
from limbgram.reconstruction.measuring.uncertainty import GAPS
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale

RADIUS_MM = 40.0
PIXEL_MM = 0.4
CAMERA = Camera(
    width_px=360, height_px=330, fx=1000.0, fy=1004.0, cx=182.3, cy=161.9, k1=-0.12, p1=0.001
)
NOISE_GREY = 1.5
FLOOR_MM = -30.0
FACE_POINTS = np.random.default_rng(1).dirichlet(np.ones(3), 8)
"""The surface is what lies on the faces: on a ball, corners stand out and middles lie in."""
SCALE = Scale(unit="mm", source="board", relative_sigma=0.0)


@dataclass(frozen=True)
class Ball:
    """Photos of the ball and its scene."""

    photos: Path
    metric: MetricScene
    known: dict[tuple[float, int], Mesh] = field(default_factory=dict)
    """Measured surfaces, by what their start was."""

    def measured(self, error_mm: float, subdivisions: int = 5) -> Mesh:
        """The surface measured from such a start, computed once for all tests."""
        key = error_mm, subdivisions
        if key not in self.known:
            photos = read_photos([self.photos])
            self.known[key] = measure(photos, self.metric, _start(error_mm, subdivisions))
        return self.known[key]


Paint = Callable[[np.ndarray], np.ndarray]
"""Grey values of points (n, 3) on the ball."""


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Ball:
    random = np.random.default_rng(7)
    waves = random.normal(size=(40, 3)) * 0.9
    phases = random.uniform(0, 2 * np.pi, 40)

    def paint(points: np.ndarray) -> np.ndarray:
        return np.clip(120 + 9 * np.sin(points @ waves.T + phases).sum(-1), 10, 245)

    return _photographed(tmp_path_factory.mktemp("ball"), paint, random)


def _photographed(
    folder: Path, paint: Paint, random: np.random.Generator, *, cut: bool = False
) -> Ball:
    """Ten photos from all sides of a ball painted so; cut: of its upper half over a floor."""
    names: list[str] = []
    poses: list[Rigid] = []
    for k in range(10):
        turn = 2 * np.pi * (k + random.uniform(-0.2, 0.2)) / 10
        centre = 400.0 * np.array([np.cos(turn), np.sin(turn), random.uniform(0.1, 0.5)])
        pose = Rigid.looking_at(centre, random.normal(size=3), np.array([0.0, 0.0, 1.0]))
        names.append(f"ball{k:02d}.png")
        poses.append(pose)
        grey = _photo_of_ball(View(names[-1], CAMERA, pose), paint, cut=cut)
        noisy = np.clip(grey * (1 - 0.02 * k) + random.normal(0, NOISE_GREY, grey.shape), 0, 255)
        cv2.imwrite(str(folder / names[-1]), np.round(noisy).astype(np.uint8))
    scene = Scene(
        names=tuple(names),
        cameras=(CAMERA,),
        camera_idx=(0,) * 10,
        camera_from_world=tuple(poses),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
    )
    return Ball(folder, MetricScene(scene=scene, scale=SCALE))


def _photo_of_ball(view: View, paint: Paint, *, cut: bool) -> np.ndarray:
    """Exact rays through four points of every pixel."""
    total = np.zeros((CAMERA.height_px, CAMERA.width_px))
    for dx in (-0.25, 0.25):
        for dy in (-0.25, 0.25):
            x, y = np.meshgrid(np.arange(CAMERA.width_px) + dx, np.arange(CAMERA.height_px) + dy)
            rays = CAMERA.rays(np.stack([x, y], -1)) @ view.camera_from_world.rotation
            eye = view.centre_in_world
            along = rays @ eye
            inside = along**2 - (eye @ eye - RADIUS_MM**2)
            distance = -along - np.sqrt(np.maximum(inside, 0))
            hit = eye + distance[..., None] * rays
            behind, there = np.full(inside.shape, 30.0), inside > 0
            if cut:
                there &= hit[..., 2] > 0
                down = np.minimum(rays[..., 2], -1e-3)
                floor = eye + ((FLOOR_MM - eye[2]) / down)[..., None] * rays
                behind = paint(floor.reshape(-1, 3)).reshape(inside.shape)
            behind[there] = paint(hit[there])
            total += behind
    return total / 4


def _start(error_mm: float, subdivisions: int = 5) -> Mesh:
    """A ball that is `error_mm` too large, with a wave of the same height on it."""
    shape = trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS_MM)
    vertices = np.asarray(shape.vertices)
    wave = error_mm * (1 + np.sin(vertices[:, :1] / 5))
    return Mesh(
        vertices_mm=vertices * (1 + wave / RADIUS_MM), faces=np.asarray(shape.faces, np.int32)
    )


def _errors_mm(mesh: Mesh) -> np.ndarray:
    return np.linalg.norm(mesh.vertices_mm, axis=1) - RADIUS_MM


def test_the_ball_is_measured_to_a_small_part_of_a_pixel(ball: Ball) -> None:
    start, result = _start(0.5 * PIXEL_MM), ball.measured(0.5 * PIXEL_MM)
    errors = _on_faces_mm(result)
    assert result.filled is not None
    assert np.mean(~result.filled) > 0.5
    assert np.sqrt(np.mean(_errors_mm(start) ** 2)) > 0.5 * PIXEL_MM
    assert 0.002 * PIXEL_MM < np.sqrt(np.mean(errors**2)) < 0.08 * PIXEL_MM
    assert abs(np.mean(errors)) < 0.02 * PIXEL_MM


def test_errors_scatter_as_the_sigmas_say(ball: Ball) -> None:
    result = ball.measured(0.5 * PIXEL_MM)
    assert result.sigma_mm is not None
    assert result.filled is not None
    known = np.isfinite(result.sigma_mm)
    assert np.array_equal(known, ~result.filled)
    ratio = _errors_mm(result)[known] / result.sigma_mm[known]
    assert 0.7 < 1.4826 * np.median(np.abs(ratio)) < 1.3


def test_a_half_pixel_error_in_the_cameras_shows(ball: Ball) -> None:
    """The check can fail: the same photos with every pixel half a pixel off give another ball."""
    shifted = replace(CAMERA, cy=CAMERA.cy + 0.5)
    scene = ball.metric.scene
    moved = Scene(
        names=scene.names,
        cameras=(shifted,),
        camera_idx=scene.camera_idx,
        camera_from_world=scene.camera_from_world,
        points_in_world=scene.points_in_world,
        observations=scene.observations,
        verdicts=(),
    )
    result = measure(read_photos([ball.photos]), MetricScene(scene=moved, scale=SCALE), _start(0.0))
    assert result.filled is not None
    measured = ~result.filled
    height = result.vertices_mm[measured, 2] / RADIUS_MM
    lift_mm = np.sum(height * _errors_mm(result)[measured]) / np.sum(height**2)
    assert 0.3 * PIXEL_MM < lift_mm < 0.7 * PIXEL_MM


def test_what_no_photo_sees_is_called_filled_and_stays(ball: Ball) -> None:
    start, result = _start(0.1 * PIXEL_MM), ball.measured(0.1 * PIXEL_MM)
    bottom = start.vertices_mm[:, 2] < -0.97 * RADIUS_MM
    assert result.filled is not None
    assert result.filled[bottom].all()
    np.testing.assert_allclose(
        result.vertices_mm[bottom], start.vertices_mm[bottom], atol=0.5 * PIXEL_MM
    )


@pytest.mark.slow
def test_the_surface_ends_within_half_a_window_of_a_sharp_edge(tmp_path: Path) -> None:
    """A bowl that ends at height 0; depth maps went on to -12 mm, over a floor painted as it is."""
    random = np.random.default_rng(7)
    waves, phases = random.normal(size=(40, 3)) * 0.9, random.uniform(0, 2 * np.pi, 40)

    def paint(points: np.ndarray) -> np.ndarray:
        return np.clip(120 + 9 * np.sin(points @ waves.T + phases).sum(-1), 10, 245)

    bowl = _photographed(tmp_path, paint, random, cut=True)
    whole = _start(0.3 * PIXEL_MM)
    past = with_faces(whole, whole.faces[(whole.vertices_mm[whole.faces, 2] > -12.0).all(1)])
    result = measure(read_photos([bowl.photos]), bowl.metric, past)
    height_mm, half_window_mm = result.vertices_mm[:, 2], 4 * PIXEL_MM
    assert height_mm.min() > -half_window_mm
    row_mm = 0.83
    assert height_mm[boundary_half_edges(result.faces)[:, 0]].max() < 2.5 * row_mm


def test_a_crumpled_start_is_measured_without_folds(ball: Ball) -> None:
    """Vertices of three places, shuffled: no move along normals puts them in order again."""
    start = _start(0.1 * PIXEL_MM)
    random = np.random.default_rng(2)
    vertices = start.vertices_mm.copy()
    level = np.abs(vertices[:, 2]) < 0.4 * RADIUS_MM
    places = random.choice(np.flatnonzero(level), 3, replace=False)
    for middle in places:
        near = np.linalg.norm(start.vertices_mm - start.vertices_mm[middle], axis=1) < 4.0
        vertices[near] += random.normal(scale=1.0, size=(int(near.sum()), 3))
    whole = Repairs(islands_dropped=0, island_share=0.0, holes_filled=0)
    crumpled = replace(start.with_vertices(vertices), repairs=whole)
    assert len(find_folds(crumpled)) > 50
    result = measure(read_photos([ball.photos]), ball.metric, crumpled)
    assert not len(find_folds(result))
    assert result.repairs is not None
    assert result.filled is not None
    assert result.sigma_mm is not None
    assert 5 < result.repairs.laid_back < 300
    assert np.isnan(result.sigma_mm[result.filled]).all()
    far = (
        np.linalg.norm(result.vertices_mm[:, None] - start.vertices_mm[places], axis=2).min(1) > 8.0
    )
    assert np.sqrt(np.mean(_errors_mm(result)[far & ~result.filled] ** 2)) < 0.1 * PIXEL_MM
    assert np.abs(_errors_mm(result)).max() < 1.5


def test_given_filled_vertices_are_never_called_measured(ball: Ball) -> None:
    start = _start(0.1 * PIXEL_MM)
    filled = start.vertices_mm[:, 0] > 0.5 * RADIUS_MM
    given = Mesh(vertices_mm=start.vertices_mm, faces=start.faces, filled=filled)
    result = measure(
        read_photos([ball.photos]),
        ball.metric,
        given,
        MeasureOptions(joint_rounds=0),
    )
    assert result.filled is not None
    assert result.filled[filled].all()


def _on_faces_mm(mesh: Mesh) -> np.ndarray:
    """Errors of points spread over the measured faces."""
    assert mesh.filled is not None
    corners = mesh.vertices_mm[mesh.faces[(~mesh.filled)[mesh.faces].all(1)]]
    points = np.einsum("sk,fkj->fsj", FACE_POINTS, corners).reshape(-1, 3)
    return np.linalg.norm(points, axis=1) - RADIUS_MM


def test_pixels_between_far_vertices_serve_too(ball: Ball) -> None:
    """Edges of 7.5 pixels: four times the samples a face make the surface better, and known so."""
    photos, start = read_photos([ball.photos]), _start(0.5 * PIXEL_MM, subdivisions=4)
    few, many = (
        measure(
            photos, ball.metric, start, MeasureOptions(matching=ResidualOptions(face_parts=parts))
        )
        for parts in (1, 2)
    )
    rms_few, rms_many = (np.sqrt(np.var(_on_faces_mm(mesh))) for mesh in (few, many))
    assert 0.5 * rms_few < rms_many < 0.93 * rms_few
    assert few.sigma_mm is not None
    assert many.sigma_mm is not None
    flat_mm2 = _flatness_mm(start) ** 2  # vertices of both stand out alike where faces are flat
    noise_few = np.sqrt(np.nanmedian(few.sigma_mm) ** 2 - flat_mm2)
    noise_many = np.sqrt(np.nanmedian(many.sigma_mm) ** 2 - flat_mm2)
    assert noise_many < 0.9 * noise_few


def test_flat_faces_hold_the_volume_of_the_ball(ball: Ball) -> None:
    """Vertices stand out by the chordal deviation, and the faces between them make up for it."""
    for subdivisions in (5, 4):
        result = ball.measured(0.1 * PIXEL_MM, subdivisions)
        assert result.filled is not None
        measured = ~result.filled
        faces = result.faces[measured[result.faces].all(1)]
        corners = result.vertices_mm[faces]
        volume_mm3 = np.abs(np.linalg.det(corners)).sum() / 6
        radius_mm = np.cbrt(3 * volume_mm3 / _solid_angles(corners).sum())
        chordal_mm = result.chordal_deviations_mm()[measured].mean()
        assert _errors_mm(result)[measured].mean() == pytest.approx(chordal_mm, rel=0.15)
        assert abs(radius_mm - RADIUS_MM) < 0.15 * chordal_mm


def test_paint_all_over_leaves_no_gaps(ball: Ball) -> None:
    result = ball.measured(0.1 * PIXEL_MM)
    assert result.shared_mm is not None
    assert result.filled is not None
    gaps_mm = result.shared_mm[~result.filled, result.shared_sources.index(GAPS)]
    assert np.quantile(gaps_mm, 0.95) < 0.005 * PIXEL_MM


def _solid_angles(corners: np.ndarray) -> np.ndarray:
    """Of triangles (f, 3, 3) seen from the origin, after van Oosterom and Strackee 1983."""
    a, b, c = np.moveaxis(corners / np.linalg.norm(corners, axis=2, keepdims=True), 1, 0)
    sides = (a * b).sum(1) + (b * c).sum(1) + (c * a).sum(1)
    return 2 * np.arctan2(np.abs((a * np.cross(b, c)).sum(1)), 1 + sides)


def _flatness_mm(mesh: Mesh) -> float:
    """How far corners of flat faces stand out of the ball: edge^2 / 8 R."""
    edges = mesh.vertices_mm[mesh.faces] - np.roll(mesh.vertices_mm[mesh.faces], 1, axis=1)
    return float(np.mean((edges**2).sum(-1)) / (8 * RADIUS_MM))


@pytest.mark.slow
def test_gaps_that_start_sunk_come_up_round_by_round(tmp_path: Path) -> None:
    """Depth maps span what lies between dabs as a chord does, here by 0.75 px."""
    random = np.random.default_rng(3)
    middles = random.normal(size=(150, 3))
    dabs = KDTree(RADIUS_MM * middles / np.linalg.norm(middles, axis=1, keepdims=True))
    dab_mm, rim_mm = 2.2, 0.4

    def paint(points: np.ndarray) -> np.ndarray:
        return 150 - 60 * np.clip((dab_mm - dabs.query(points)[0]) / rim_mm + 0.5, 0, 1)

    bare = _photographed(tmp_path, paint, np.random.default_rng(7))
    true = _start(0.0)
    gap = np.clip((dabs.query(true.vertices_mm)[0] - dab_mm) / 4.0, 0, 1)
    start = true.with_vertices(true.vertices_mm * (1 - 0.3 * gap / RADIUS_MM)[:, None])
    sunk: list[float] = []
    for rounds in (1, 3):
        options = MeasureOptions(joint_rounds=rounds)
        result = measure(read_photos([bare.photos]), bare.metric, start, options)
        assert result.sigma_mm is not None
        between = np.isfinite(result.sigma_mm) & (dabs.query(result.vertices_mm)[0] > 4.0)
        sunk.append(float(np.mean(_errors_mm(result)[between])))
    assert sunk[0] < -0.1
    assert 0.85 * sunk[0] < sunk[1] < 0


def test_photos_of_half_size_measure_the_same_ball(ball: Ball) -> None:
    """Pixel centres are kept: half a pixel of the full photo would be 0.2 mm of height here."""
    photos, start = read_photos([ball.photos]), _start(0.5 * PIXEL_MM, subdivisions=4)
    result = measure(photos, ball.metric, start, MeasureOptions(photo_halvings=1))
    errors = _on_faces_mm(result)
    assert np.sqrt(np.mean(errors**2)) < 0.2 * PIXEL_MM
    assert abs(np.mean(errors)) < 0.04 * PIXEL_MM
    assert result.filled is not None
    assert result.sigma_mm is not None
    measured = ~result.filled
    height = result.vertices_mm[measured, 2] / RADIUS_MM
    lift_mm = np.sum(height * _errors_mm(result)[measured]) / np.sum(height**2)
    assert abs(lift_mm) < 0.05 * PIXEL_MM
    ratio = _errors_mm(result)[measured] / result.sigma_mm[measured]
    assert 0.7 < 1.4826 * np.median(np.abs(ratio)) < 1.3
