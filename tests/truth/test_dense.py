"""Cloud of rendered limbs from true cameras, against the true surface."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.dense.estimation import estimate_depth
from limbgram.reconstruction.dense.fusion import fuse
from limbgram.reconstruction.dense.photo_depth import DenseOptions
from limbgram.reconstruction.dense.region import Region
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale

PHOTOS, FIRST = 6, 3


def true_scene(capture: Path, surface: trimesh.Trimesh) -> Scene:
    """Views and points as they are, seen where they face a photo."""
    truth = json.loads((capture / "truth/cameras.json").read_text())
    lens = truth["intrinsics"]
    camera = Camera(
        width_px=lens["width"], height_px=lens["height"], fx=lens["fx"], fy=lens["fy"],
        cx=lens["cx"], cy=lens["cy"], skew=lens["skew"], **truth["distortion"],
    )  # fmt: skip
    images = sorted(truth["images"], key=lambda image: image["name"])
    images = images[FIRST : FIRST + PHOTOS]
    poses = [Rigid(np.array(image["R"]), np.array(image["t"])) for image in images]
    names = tuple(image["name"] for image in images)
    chosen = np.random.default_rng(0).choice(len(surface.vertices), 3000, replace=False)
    points, normals = surface.vertices[chosen], surface.vertex_normals[chosen]
    rows = []
    for k, pose in enumerate(poses):
        rays = pose.centre - points
        facing = (rays * normals).sum(1) > 0.4 * np.linalg.norm(rays, axis=1)
        rows += [(k, point) for point in np.flatnonzero(facing)]
    photo_idx, point_idx = np.array(rows).T
    views = [View(name, camera, pose) for name, pose in zip(names, poses)]
    xy = [views[k].project(points[point][None])[0] for k, point in rows]
    return Scene(
        names=names,
        cameras=(camera,),
        camera_idx=(0,) * PHOTOS,
        camera_from_world=tuple(poses),
        points_in_world=np.asarray(points, float),
        observations=Observations(
            photo_idx.astype(np.int32), point_idx.astype(np.int32), np.array(xy)
        ),
        verdicts=tuple(PhotoVerdict(name=n, placed=True, points=1, rms_px=0.1) for n in names),
    )


def region_round(surface: trimesh.Trimesh, cell_mm: float = 8.0) -> Region:
    """The cubes that hold the true surface, and their neighbours."""
    origin = surface.vertices.min(0) - 2 * cell_mm
    cells = np.unique(((surface.vertices - origin) / cell_mm).astype(int), axis=0)
    occupied = np.zeros(cells.max(0) + 3, bool)
    for shift in np.ndindex(3, 3, 3):
        occupied[tuple((cells + shift - np.array([1, 1, 1])).T)] = True
    return Region(origin_mm=origin, cell_mm=cell_mm, occupied=occupied)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["limb_ring15", "foot_ring24"])
def test_six_photos_at_a_third_of_their_pixels_meet_the_true_surface(
    data_folder: Path, name: str
) -> None:
    capture = data_folder / "rendered" / name
    surface = trimesh.load(capture / "truth/mesh.ply", process=False)
    assert isinstance(surface, trimesh.Trimesh)
    scene = true_scene(capture, surface)
    photos = read_photos([capture / "images" / photo for photo in scene.names])
    metric = MetricScene(
        scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4), floor_z_mm=0.0
    )
    region = region_round(surface)
    maps = estimate_depth(photos, metric, region, DenseOptions(most_px=1_000_000))
    cloud = fuse(photos, metric, maps, region)

    away, vertex = KDTree(surface.vertices).query(cloud.points_mm)
    normals = surface.vertex_normals[vertex]
    height = ((cloud.points_mm - surface.vertices[vertex]) * normals).sum(1)
    sure = cloud.views >= 4
    assert np.mean(away[sure] < 1.0) > 0.99
    height = height[sure & (away < 1.0)]
    assert 0.01 < height.std() < 0.1
    assert abs(height.mean()) < 0.03
    assert np.median((cloud.normals * normals).sum(1)) > np.cos(np.radians(4))
