"""The closed surface against bodies of known size, and what hangs over on one."""

import numpy as np
import pytest

from limbgram.capture.camera_positions import Stand
from limbgram.capture.closed_surface import Underside, closed_surface, find_underside
from limbgram.capture.coverage import ShownProxy, coverage_from_prediction
from limbgram.capture.photos_to_add import photos_for_hidden_places
from limbgram.capture.prediction import Showing, predict
from limbgram.capture.proxy import plain_tube
from limbgram.core.geometry.lens import Camera, View
from limbgram.findings import Gravity
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.metric import MetricScene, Scale

UP = np.array([0.0, 0.0, 1.0])
CAMERA = Camera(width_px=1500, height_px=1000, fx=1800.0, fy=1800.0, cx=749.5, cy=499.5)
RADIUS, LENGTH = 35.0, 200.0
SLAB = np.array([180.0, 70.0, 24.0])
"""Lies on a post of RADIUS and LENGTH, and hangs over on one side: a foot that is held up."""
SLAB_LOW = np.array([-35.0, -35.0, LENGTH])


def ring(elevation_deg: float, photos: int = 16) -> list[View]:
    return [
        Stand(azimuth_deg=360.0 * k / photos, elevation_deg=elevation_deg, distance=900.0).view(
            CAMERA, np.array([20.0, 0.0, 110.0]), 0.0
        )
        for k in range(photos)
    ]


def on_sphere(count: int) -> np.ndarray:
    """Unit vectors, spread evenly."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z])


def raised_foot(below: bool) -> tuple[np.ndarray, np.ndarray]:
    """Points of a post with a slab on it, and their normals; those under the slab where asked."""
    rng = np.random.default_rng(4)
    turn, z = rng.uniform(0, 2 * np.pi, 1500), rng.uniform(0, LENGTH, 1500)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(1500)])
    places, normals = [RADIUS * out + z[:, None] * UP], [out]
    for axis in range(3):
        for side in (0.0, 1.0):
            across = np.delete(SLAB, axis)
            at = rng.uniform(size=(int(across.prod() / 30), 3))
            at[:, axis] = side
            normal = np.zeros_like(at)
            normal[:, axis] = 2 * side - 1
            spots = SLAB_LOW + at * SLAB
            if axis == 2 and not side:
                free = np.linalg.norm(spots[:, :2], axis=1) > RADIUS
                spots, normal = spots[free & below], normal[free & below]
            places.append(spots)
            normals.append(normal)
    return np.concatenate(places), np.concatenate(normals)


def underside(below: bool, views: list[View]) -> Underside:
    points, normals = raised_foot(below)
    surface = closed_surface(points, normals)
    assert surface is not None
    return find_underside(surface, UP, views, 2)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_a_ball_of_points_is_closed_in_any_unit(scale: float) -> None:
    rays = on_sphere(1500)
    surface = closed_surface(50 * scale * rays, rays)
    assert surface is not None
    far = np.linalg.norm(surface.mesh.vertices_mm, axis=1) / scale
    assert abs(np.median(far) - 50) < 2.0
    assert np.ptp(far) < 3.0
    assert not surface.guessed.any()
    outward = (surface.mesh.vertex_normals() * surface.mesh.vertices_mm).sum(axis=1)
    assert (outward > 0).all()


def test_the_far_side_of_what_one_side_shows_is_a_guess() -> None:
    rays = on_sphere(3000)
    cap = rays[:, 2] > 0.3
    surface = closed_surface(50 * rays[cap], rays[cap])
    assert surface is not None
    down = surface.mesh.vertex_normals() @ UP < -0.5
    up = surface.mesh.vertex_normals() @ UP > 0.5
    assert down.any()
    assert surface.guessed[down].mean() > 0.9
    assert not surface.guessed[up].any()


def test_a_part_of_which_one_side_is_shown_is_not_cut_off() -> None:
    """Toes from above: a sheet of points that stands out from the post."""
    points, normals = raised_foot(below=False)
    side = (points[:, 2] >= LENGTH) & (np.abs(normals[:, 2]) < 0.5)
    surface = closed_surface(points[~side], normals[~side])
    assert surface is not None
    end = SLAB_LOW[0] + SLAB[0]
    assert surface.mesh.vertices_mm[:, 0].max() > 0.85 * end
    assert find_underside(surface, UP, [*ring(28.0), *ring(50.0)], 2).share > 0.05


def test_points_that_enclose_nothing_have_no_surface() -> None:
    rays = on_sphere(400)
    assert closed_surface(50 * rays, -rays) is None


def test_what_hangs_over_is_hidden_from_photos_above_it() -> None:
    """The slab's underside beside the post is 9,300 of 112,000 square mm."""
    free = SLAB[0] * SLAB[1] - np.pi * RADIUS**2
    rest = (
        SLAB[0] * SLAB[1]
        + 2 * SLAB[2] * (SLAB[0] + SLAB[1])
        + np.pi * RADIUS * (2 * LENGTH + RADIUS)
    )
    found = underside(below=False, views=[*ring(28.0), *ring(50.0)])
    assert found.share == pytest.approx(free / (free + rest), rel=0.35)
    assert found.skin.mesh.vertices_mm[found.hidden, 2].min() > 0.6 * LENGTH


def test_photos_from_below_show_what_hangs_over() -> None:
    assert underside(below=True, views=[*ring(28.0), *ring(-35.0)]).share == 0.0


def test_the_end_that_a_limb_stands_on_is_not_asked_for() -> None:
    """A post alone: the disc under it faces down, and no photo shows it."""
    rng = np.random.default_rng(5)
    turn, z = rng.uniform(0, 2 * np.pi, 2500), rng.uniform(0, LENGTH, 2500)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(2500)])
    surface = closed_surface(RADIUS * out + z[:, None] * UP, out)
    assert surface is not None
    assert find_underside(surface, UP, ring(28.0), 2).share == 0.0


def test_what_hangs_over_is_told_below_the_limit_and_asked_for_above_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    views = [*ring(28.0), *ring(50.0)]
    limb = plain_tube(np.array([0.0, LENGTH]), np.array([RADIUS, RADIUS]), 20.0)
    prediction = predict(limb, views, Showing.alike(len(limb.mesh), len(views), 1.2, 20.0))
    scene = Scene(
        names=tuple(view.name for view in views),
        cameras=(CAMERA,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=np.zeros((0, 3)),
        observations=Observations(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2))),
        verdicts=(),
    )
    metric = MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=1e-4))
    found = underside(below=False, views=views)
    coverage = coverage_from_prediction(limb, prediction, in_mm=True)
    shown = ShownProxy(limb, prediction, coverage, 0.0, found)
    for most, gravity in ((2 * found.share, Gravity.DOUBT), (found.share / 2, Gravity.FAULT)):
        monkeypatch.setattr("limbgram.capture.photos_to_add.MAX_UNSEEN", most)
        _, findings, notes = photos_for_hidden_places(shown, metric, [], [])
        told = [
            one
            for one in (*findings, *notes)
            if one.code == "coach.overhang" or one.code.startswith("coach.unseen")
        ]
        assert [one.gravity for one in told] == [gravity]
        assert told[0].values["share"] == found.share
        assert told[0].values["count"] != 0
