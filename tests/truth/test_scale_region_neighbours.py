"""Scale, region and neighbours on captures with truth, from true cameras in an arbitrary frame."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid, Similarity, fit_similarity
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense.region import find_region, footprint
from limbgram.reconstruction.dense.source_views import select_source_views
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board

SETS = ("limb_ring15", "foot_ring24")
SCENE_FROM_ROOM = Similarity(
    0.0371, Rotation.from_rotvec([0.4, 2.0, -1.0]).as_matrix(), np.array([3.0, -5.0, 9.0])
)


@dataclass(frozen=True)
class Truth:
    """What the renderer knows, and a scene made from it."""

    folder: Path
    photos: PhotoSet
    views: tuple[View, ...]
    surface_mm: np.ndarray
    """Vertices above the cut that at least three photos see."""
    board: dict
    scene: Scene
    """True cameras and noisy points of limb, table and background, in an arbitrary frame."""


@cache
def load(data_folder: Path, name: str) -> Truth:
    folder = data_folder / "rendered" / name
    photos = read_photos([folder / "images"])
    cameras = json.loads((folder / "truth/cameras.json").read_text())
    lens, distortion = cameras["intrinsics"], cameras["distortion"]
    camera = Camera(
        width_px=lens["width"],
        height_px=lens["height"],
        **{key: lens[key] for key in ("fx", "fy", "cx", "cy")},
        **distortion,
    )
    views = tuple(
        View(one["name"], camera, Rigid(np.array(one["R"]), np.array(one["t"])))
        for one in cameras["images"]
    )
    mesh = trimesh.load(folder / "truth/mesh.ply", process=False)
    flags = mesh.metadata["_ply_raw"]["vertex"]["data"]
    z_min = json.loads((folder / "truth/notes.json").read_text())["roi"]["z_min"]
    seen = (flags["ncam"] >= 3).ravel() & (flags["cap"] == 0).ravel()
    seen &= mesh.vertices[:, 2] > z_min
    scene = noisy_scene(views, mesh.vertices[seen], mesh.vertex_normals[seen])
    board = json.loads((folder / "truth/board.json").read_text())["scene_board"]
    return Truth(folder, photos, views, mesh.vertices[seen], board, scene)


def noisy_scene(views: tuple[View, ...], vertices: np.ndarray, normals: np.ndarray) -> Scene:
    """5000 points of the limb with 0.15 mm noise, 2000 of the table, 600 of the room."""
    draw = np.random.default_rng(11)
    chosen = draw.choice(len(vertices), 5000, replace=False)
    limb = vertices[chosen] + draw.normal(0, 0.15, (5000, 3))
    table = np.column_stack([draw.uniform(-500, 500, (2000, 2)), draw.normal(0, 0.3, 2000)])
    room = draw.uniform((-2500, -2500, -700), (2500, 2500, 1500), (600, 3))
    room = room[np.linalg.norm(room[:, :2], axis=1) > 700]
    up = np.tile([0.0, 0.0, 1.0], (len(table) + len(room), 1))
    points = np.concatenate([limb, table, room])
    facing = np.concatenate([normals[chosen], up])
    toward = np.array([view.centre_in_world - points for view in views])
    toward /= np.linalg.norm(toward, axis=2, keepdims=True)
    sees = np.einsum("vnk,nk->vn", toward, facing) > np.cos(np.radians(60))
    photo_idx, point_idx = (rows.astype(np.int32) for rows in np.nonzero(sees))
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(views[0].camera,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points,
        observations=Observations(photo_idx, point_idx, np.zeros((len(photo_idx), 2))),
        verdicts=(),
    )
    return scene.moved(SCENE_FROM_ROOM)


@cache
def scaled(data_folder: Path, name: str) -> MetricScene:
    truth = load(data_folder, name)
    board = Board(
        kind="charuco", columns=7, rows=5, square_mm=30.0, marker_mm=22.0, dictionary="4X4_50"
    )
    return to_millimetres(truth.scene, find_board(truth.photos, board))


def world_from_room(metric: MetricScene, truth: Truth) -> Similarity:
    room = np.array([view.centre_in_world for view in truth.views])
    return fit_similarity(room, np.array([view.centre_in_world for view in metric.scene.views]))


@pytest.mark.parametrize("name", SETS)
def test_scale_and_frame_by_the_board(data_folder: Path, name: str) -> None:
    truth, metric = load(data_folder, name), scaled(data_folder, name)
    found = world_from_room(metric, truth)
    assert abs(found.scale - 1) < 1e-4
    assert abs(found.scale - 1) < 5 * metric.scale.relative_sigma < 5e-4
    assert all(abs(one.error) < 5e-4 for one in metric.scale.lengths)
    np.testing.assert_allclose(found.rotation[:, 2], [0, 0, 1], atol=2e-4)
    assert metric.floor_z_mm == 0.0
    table_z = found.apply(np.zeros((1, 3)))[0, 2]
    assert table_z == pytest.approx(-truth.board["t"][2], abs=0.1)
    first = Rigid(np.array(truth.board["R"]), np.array(truth.board["t"])).apply(np.zeros((1, 3)))
    np.testing.assert_allclose(metric.board_corners_mm[0], found.apply(first)[0], atol=0.1)


@pytest.mark.parametrize("name", SETS)
def test_the_region_is_the_limb(data_folder: Path, name: str) -> None:
    truth, metric = load(data_folder, name), scaled(data_folder, name)
    region = find_region(truth.photos, metric)
    found = world_from_room(metric, truth)
    assert region.contains(found.apply(truth.surface_mm)).mean() >= 0.999
    for view in metric.scene.views:
        area, lost = footprint_against_mask(truth, region, view)
        assert 1.0 < area < 1.6
        assert lost < 1e-3


def footprint_against_mask(truth: Truth, region, view: View) -> tuple[float, float]:
    """Area over the true mask's, and the share of the mask that it misses, at quarter scale."""
    path = truth.folder / "truth/masks" / view.name.replace("jpg", "png")
    mask = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    mask = cv2.resize(mask, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA) > 127
    crop = footprint(region, view, 0.25)
    height, width = crop.mask.shape
    covered = np.zeros_like(mask)
    covered[crop.y0 : crop.y0 + height, crop.x0 : crop.x0 + width] = crop.mask
    return covered.sum() / mask.sum(), (mask & ~covered).sum() / mask.sum()


@pytest.mark.parametrize("name", SETS)
def test_every_photo_has_neighbours_at_useful_angles(data_folder: Path, name: str) -> None:
    truth, metric = load(data_folder, name), scaled(data_folder, name)
    neighbours = select_source_views(metric, find_region(truth.photos, metric))
    middle = world_from_room(metric, truth).apply(truth.surface_mm.mean(0)[None])[0]
    toward = np.array([view.centre_in_world - middle for view in metric.scene.views])
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    for k, chosen in enumerate(neighbours):
        assert 2 <= len(chosen) <= 6
        angles_deg = np.degrees(np.arccos(toward[list(chosen)] @ toward[k]))
        assert np.all((angles_deg > 2) & (angles_deg < 50))
        assert angles_deg[0] < 32
