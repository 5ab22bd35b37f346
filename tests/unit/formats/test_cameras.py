"""The COLMAP model and poses.json as other programs read them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pycolmap
import pytest
from PIL import Image

from limbgram.core.errors import ExportError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.formats.colmap import write_colmap, write_poses
from limbgram.formats.transforms import write_transforms
from limbgram.formats.undistorted import _jpeg_names, write_undistorted
from limbgram.reconstruction.mapping.scene import Explanation, Observations, OwnLenses, Scene
from limbgram.reconstruction.photos import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.report.lenses import own_lenses

CAMERA = Camera(
    width_px=2000, height_px=1500, fx=2400, fy=2410, cx=990, cy=760, k1=-0.1, k2=0.02, p1=1e-3
)
NAMES = ("photo one.jpg", "zwei.jpg", "drei.jpg", "lost.jpg")
NO_SCALE = Scale(unit="unitless", source="none", relative_sigma=float("nan"))


@pytest.fixture
def metric() -> MetricScene:
    """Three photos on an arc, the fourth not placed; photo 1 does not see the first 10 points."""
    points = np.random.default_rng(0).normal(size=(80, 3)) * 40
    up = np.array([0, 0, 1.0])
    poses = [
        Rigid.looking_at(np.array([400 * np.cos(a), 400 * np.sin(a), 90]), np.zeros(3), up)
        for a in (0, 0.5, 1.0)
    ]
    seen = [(photo, point) for photo in range(3) for point in range(10 * (photo == 1), 80)]
    photo_idx, point_idx = np.array(seen, np.int32).T.copy()
    xy_px = np.array([CAMERA.project(poses[i].apply(points[j])) for i, j in seen])
    scene = Scene(
        names=NAMES,
        cameras=(CAMERA,),
        camera_idx=(0, 0, 0, 0),
        camera_from_world=(*poses, None),
        points_in_world=points,
        observations=Observations(photo_idx, point_idx, xy_px),
        verdicts=(),
    )
    return MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))


def test_colmap_reprojects_every_point_to_its_own_pixel(
    metric: MetricScene, tmp_path: Path
) -> None:
    model = pycolmap.Reconstruction(write_colmap(metric, tmp_path / "colmap"))
    assert [model.images[k].name for k in sorted(model.images)] == list(NAMES[:3])
    assert model.num_points3D() == 80
    assert len(model.points3D[1].track.elements) == 2
    assert model.points3D[1].error == pytest.approx(0, abs=1e-9)
    worst = 0.0
    for idx, point in model.points3D.items():
        np.testing.assert_array_equal(point.xyz, metric.scene.points_in_world[idx - 1])
        for element in point.track.elements:
            image = model.images[element.image_id]
            xy = model.cameras[image.camera_id].img_from_cam(image.cam_from_world() * point.xyz)
            worst = max(worst, np.abs(image.points2D[element.point2D_idx].xy - xy).max())
            centre = metric.scene.view(element.image_id - 1).project(point.xyz)
            np.testing.assert_allclose(xy, centre + 0.5, atol=1e-6)
    assert worst < 1e-6


def test_photos_with_lenses_of_their_own_are_written_with_them(
    metric: MetricScene, tmp_path: Path
) -> None:
    shifts = np.zeros((4, LENS_SIZE))
    shifts[:3, 2] = [3.0, -2.0, 0.5]
    own = OwnLenses(
        deviations=("principal point",),
        values=shifts[:, 2:4] / CAMERA.width_px,
        spread=np.full(2, 0.01),
        shifts=shifts,
        chances=(1e-9,),
    )
    scene = replace(metric.scene, own=own)
    model = pycolmap.Reconstruction(write_colmap(replace(metric, scene=scene), tmp_path / "colmap"))
    assert len(model.cameras) == 3
    for photo in range(3):
        image = model.images[photo + 1]
        written = model.cameras[image.camera_id]
        assert written.params[2] == pytest.approx(CAMERA.cx + 0.5 + shifts[photo, 2], abs=1e-9)
    assert own_lenses(scene) == (), "solved for, and no fact"
    fact = Explanation(
        bodies="lenses", kind="principal point", photos=(0, 1), numbers=2, score=90.0, chance=1e-9,
        effect=0.4, low=0.3, high=0.5, variance_before=3.0, variance_after=1.0, floor=0.25,
    )  # fmt: skip
    small = replace(fact, failed=("size",))
    (told,) = own_lenses(replace(scene, lens_explanations=(fact,)))
    assert told.largest_px == pytest.approx(3.0)
    assert "by up to 3.0 px" in told.sentence
    assert own_lenses(replace(scene, lens_explanations=(small,))) == ()


def test_poses_are_camera_from_world(metric: MetricScene, tmp_path: Path) -> None:
    poses = json.loads(write_poses(metric, tmp_path / "poses.json").read_text())
    assert [image["name"] for image in poses["images"]] == list(NAMES[:3])
    assert poses["convention"]["pose"] == "x_camera = R x_world + t, camera from world"
    lens = poses["images"][0]["lens"]
    assert (lens["fx"], lens["k1"], lens["skew"], lens["width_px"]) == (2400, -0.1, 0, 2000)
    first = poses["images"][0]
    centre = -np.array(first["R"]).T @ first["t"]
    np.testing.assert_allclose(centre, [400, 0, 90], atol=1e-9)


@pytest.mark.parametrize(("k3", "model"), [(0.0, "OPENCV"), (0.01, "FULL_OPENCV")])
def test_the_simplest_model_that_holds_the_lens_is_written(
    metric: MetricScene, tmp_path: Path, k3: float, model: str
) -> None:
    lens = replace(CAMERA, k3=k3)
    scene = replace(metric.scene, cameras=(lens,))
    seen = scene.observations
    views = [scene.view(k) for k in range(3)]
    pairs = zip(seen.photo_idx, seen.point_idx)
    xy = [views[i].project(scene.points_in_world[j]) for i, j in pairs]
    scene = replace(scene, observations=replace(seen, xy_px=np.array(xy)))
    colours = np.random.default_rng(1).integers(0, 256, (80, 3), np.uint8)
    folder = write_colmap(replace(metric, scene=scene), tmp_path / "colmap", colours=colours)
    read = pycolmap.Reconstruction(folder)
    assert read.cameras[1].model.name == model
    for idx, point in read.points3D.items():
        np.testing.assert_array_equal(point.color, colours[idx - 1])


def test_transforms_look_along_minus_z_with_y_up(metric: MetricScene, tmp_path: Path) -> None:
    """A point projects to its pixel by the formulas that nerfstudio documents."""
    path = write_transforms(metric, tmp_path / "transforms.json", "../photos")
    tree = json.loads(path.read_text())
    assert [one["file_path"] for one in tree["frames"]] == [f"../photos/{n}" for n in NAMES[:3]]
    for idx, frame in enumerate(tree["frames"]):
        world_from_camera = np.array(frame["transform_matrix"])
        points = metric.scene.points_in_world
        x, y, z = (np.linalg.inv(world_from_camera) @ np.c_[points, np.ones(80)].T)[:3]
        assert (z < 0).all()
        x, y = x / -z, -y / -z
        r2 = x * x + y * y
        radial = 1 + frame["k1"] * r2 + frame["k2"] * r2**2
        p1, p2 = frame["p1"], frame["p2"]
        across = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        down = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        seen = np.c_[frame["fl_x"] * across + frame["cx"], frame["fl_y"] * down + frame["cy"]]
        np.testing.assert_allclose(seen, metric.scene.view(idx).project(points) + 0.5, atol=1e-6)


def near(x: float, y: float, radius_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the pixels within a circle in the picture."""
    reach = int(radius_px) + 1
    rows, columns = np.mgrid[
        max(0, int(y) - reach) : min(CAMERA.height_px, int(y) + reach + 1),
        max(0, int(x) - reach) : min(CAMERA.width_px, int(x) + reach + 1),
    ]
    within = np.hypot(columns - x, rows - y) < radius_px
    return rows[within], columns[within]


def test_undistorted_photos_show_each_point_where_a_pinhole_camera_does(
    metric: MetricScene, tmp_path: Path
) -> None:
    """Photos with a bright spot round every point; in the new ones the spots lie by the model."""
    for idx, name in enumerate(NAMES[:3]):
        picture = np.zeros((CAMERA.height_px, CAMERA.width_px), np.uint8)
        for x, y in metric.scene.view(idx).project(metric.scene.points_in_world[::20]):
            rows, columns = near(x, y, 6)
            picture[rows, columns] = 255
        Image.fromarray(np.stack([picture] * 3, axis=2)).save(tmp_path / name, quality=95)
    Image.fromarray(np.zeros((1500, 2000, 3), np.uint8)).save(tmp_path / NAMES[3])
    photos = read_photos([tmp_path])
    order = [NAMES.index(name) for name in photos.names]
    photos = replace(photos, photos=tuple(photos.photos[order.index(k)] for k in range(4)))
    written = write_undistorted(photos, metric, tmp_path / "straight")
    model = pycolmap.Reconstruction(written / "sparse")
    assert {one.model.name for one in model.cameras.values()} == {"PINHOLE"}
    for image in model.images.values():
        seen = np.asarray(Image.open(written / "images" / image.name).convert("L"), float)
        camera = model.cameras[image.camera_id]
        for point in metric.scene.points_in_world[::20]:
            x, y = camera.img_from_cam(image.cam_from_world() * point) - 0.5
            rows, columns = near(x, y, 12)
            weight = seen[rows, columns]
            middle = [(weight * columns).sum(), (weight * rows).sum()] / weight.sum()
            assert np.hypot(*(middle - (x, y))) < 0.3
    tree = json.loads((written / "transforms.json").read_text())
    for frame, name in zip(tree["frames"], NAMES[:3], strict=True):
        assert (written / frame["file_path"]).name == name
        assert (written / frame["file_path"]).is_file()
        assert {frame[k] for k in ("k1", "k2", "k3", "p1", "p2")} == {0.0}
        assert (frame["fl_x"], frame["cx"]) == (CAMERA.fx, CAMERA.cx + 0.5)
    # What OpenMVS asks of such a folder: PINHOLE, numbers that are there, a track for each point.
    for image in model.images.values():
        assert image.camera_id in model.cameras
        assert (written / "images" / image.name).is_file()
    for point in model.points3D.values():
        assert point.track.length() > 0
        assert {seen.image_id for seen in point.track.elements} <= set(model.images)
    colours = [one.color for k, one in model.points3D.items() if (k - 1) % 20 == 0]
    assert np.min(colours) > 200  # the spots
    with pytest.raises(ExportError, match="is there already"):
        write_undistorted(photos, metric, tmp_path / "straight")


def test_cameras_without_scale_need_asking(metric: MetricScene, tmp_path: Path) -> None:
    unitless = replace(metric, scale=NO_SCALE)
    for write, name in ((write_colmap, "colmap"), (write_poses, "poses.json")):
        with pytest.raises(ExportError, match="no scale"):
            write(unitless, tmp_path / name)
        assert "unitless" in write(unitless, tmp_path / name, unscaled=True).name


@pytest.mark.parametrize(
    "names",
    [("a.jpg", "a.png", "a-1.jpg", "a-2.jpg"), ("IMG.jpg", "img.png", "b.jpg")],
    ids=["numbers", "case"],
)
def test_no_undistorted_photo_takes_the_name_of_another(names: tuple[str, ...]) -> None:
    found = _jpeg_names(names)
    assert len({name.casefold() for name in found}) == len(names)
    assert found[-1] == names[-1]  # a photo whose stem no other has keeps it
