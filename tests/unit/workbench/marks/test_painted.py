"""Painted marks against their true places on a synthetic capture, with things that are none."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import trimesh

from limbgram.cases import case_assessment as painted
from limbgram.cases.case_assessment import painted_marks_of
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.paint import MAGENTA, SockSpot, places_mm, scattered_spots
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.marks import finding
from limbgram.workbench.marks.finding import (
    PaintedMarks,
    find_painted_marks,
    shift_by_hidden_mm,
    sigma_of_median_mm,
)
from limbgram.workbench.marks.pixels import LEAST_COSINE, ColouredPixels, SurfaceRays
from limbgram.workbench.marks.spots import spots_of

RED = (203, 32, 44)
MARKS = scattered_spots(4)
OF_A_DABS_COLOUR = SockSpot(around=0.55, height=0.5, colour=RED, diameter_mm=10.0)
OF_A_DABS_COLOUR_TOO = SockSpot(around=0.2, height=0.7, colour=RED, diameter_mm=10.0)
SPOTS = (*MARKS, OF_A_DABS_COLOUR, OF_A_DABS_COLOUR_TOO)
Colour = tuple[int, int, int]
FoundBy = Callable[[Colour | None], PaintedMarks]


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    options = replace(SMALL, photos=13, calibration_photos=0, spots=SPOTS, samples=2)
    return make_capture(tmp_path_factory.mktemp("painted") / "capture", options)


@pytest.fixture(scope="module")
def found_by(capture: Capture) -> FoundBy:
    """What is found in the capture's photos, by colour."""
    photos = photos_of(capture.folder / "images")
    return cache(lambda colour: found_in(capture, photos, colour))


def found_in(capture: Capture, photos: PhotoSet, colour: Colour | None) -> PaintedMarks:
    return find_painted_marks(photos.photos, capture.truth.views, capture.truth.limb.mesh, colour)


def photos_of(folder: Path) -> PhotoSet:
    return read_photos([folder])


def true_places(capture: Capture) -> np.ndarray:
    return np.stack(places_mm(capture.truth.limb, MARKS))


@pytest.mark.parametrize("colour", [None, MAGENTA, (255, 0, 255)])
def test_marks_are_found_where_they_were_painted_and_nothing_else_is(
    capture: Capture, found_by: FoundBy, colour: Colour | None
) -> None:
    marks = found_by(colour).marks
    apart = np.linalg.norm(
        np.stack([mark.position_mm for mark in marks])[:, None] - true_places(capture), axis=2
    )
    assert len(marks) == len(MARKS)
    assert sorted(apart.argmin(1).tolist()) == list(range(len(MARKS)))
    assert 1e-4 < apart.min(1).max() < 0.6  # lower: the answer came out of pixels
    for mark, error_mm in zip(marks, apart.min(1).tolist(), strict=True):
        assert error_mm < 3 * mark.sigma_mm < 3.0
        assert 3 <= len(mark.photos) <= mark.looking < len(capture.photos)
        assert mark.diameter_mm == pytest.approx(MARKS[0].diameter_mm, abs=1.2)
        assert 0 < mark.spread_mm < 1.0
        red, green, blue = map(int, mark.colour)
        assert red > green + 60
        assert blue > green + 60
    normalised = apart.min(1) / np.array([mark.sigma_mm for mark in marks])
    assert 0.3 < np.sqrt((normalised**2).mean()) < 2.0  # about sqrt(2): along two directions


def toe(radius_mm: float) -> Mesh:
    """A toe along y with its tip, half a sphere, at the origin."""
    whole = trimesh.creation.capsule(height=60, radius=radius_mm, count=[96, 96]).subdivide()
    x, y, z = np.asarray(whole.vertices).T
    places = np.column_stack([x, z - z.max(), -y])
    return Mesh(vertices_mm=places, faces=np.asarray(whole.faces).astype(np.int32))


def ring_round_toe(elevation_deg: float) -> list[View]:
    """14 photos from 420 mm, all from above."""
    lens = Camera(width_px=1600, height_px=1200, fx=2200.0, fy=2200.0, cx=800.0, cy=600.0)
    middle = np.array([0.0, -30.0, 0.0])
    views = []
    for k in range(14):
        turn, rise = 2 * np.pi * k / 14 + 0.1, np.radians(elevation_deg)
        away = [np.cos(rise) * np.sin(turn), np.cos(rise) * np.cos(turn), np.sin(rise)]
        pose = Rigid.looking_at(middle + 420 * np.array(away), middle, np.array([0.0, 0, 1]))
        views.append(View(f"{k}.jpg", lens, pose))
    return views


def pixels_of_disc(
    view: View, mesh: Mesh, caster: SurfaceRays, middle_mm: np.ndarray, reach_mm: float
) -> ColouredPixels:
    """What a photo shows of a disc on the surface, as `coloured_pixels` tells it."""
    xy = view.project(mesh.vertices_mm)
    left, top = np.floor(xy.min(0)).astype(int) - 4
    right, bottom = np.ceil(xy.max(0)).astype(int) + 4
    rows, columns = np.mgrid[top:bottom, left:right]
    seen = np.column_stack([columns.ravel(), rows.ravel()]).astype(float)
    rays = view.camera.rays(seen) @ view.camera_from_world.rotation
    hit, places, cosines = caster.first(view.centre_in_world, rays)
    own = hit & (cosines > LEAST_COSINE)
    own &= np.linalg.norm(places - middle_mm, axis=1) <= reach_mm
    depths = view.camera_from_world.apply(places[own])[:, 2]
    count = int(own.sum())
    return ColouredPixels(
        shape=(int(bottom - top), int(right - left)),
        at=(seen[own][:, ::-1] - [top, left]).astype(np.int32),
        hue_rad=np.full(count, -1.0, np.float32),
        saturation=np.ones(count, np.float32),
        colours=np.full((count, 3), 200, np.uint8),
        points_mm=places[own].astype(np.float32),
        areas_mm2=((depths / view.camera.fx) ** 2 / cosines[own]).astype(np.float32),
    )


@pytest.mark.parametrize(
    ("radius_mm", "below_deg", "elevation_deg", "within_mm"),
    [
        (8.0, 0.0, 35.0, 0.4),  # the middle of the photos' middles was 1.06 mm off
        (8.0, 20.0, 15.0, 0.3),  # 0.59
        (12.0, 0.0, 35.0, 0.05),  # 0.42
        (6.0, 20.0, 35.0, 2.0),  # half of it is hidden from all photos
        (50.0, 0.0, 35.0, 0.05),
    ],
)
def test_a_mark_on_a_tip_is_found_with_its_side_that_few_photos_show(
    radius_mm: float, below_deg: float, elevation_deg: float, within_mm: float
) -> None:
    """A disc of 8 mm in front of a toe, seen from above by photos that each show a part of it."""
    mesh = toe(radius_mm)
    caster, tree = SurfaceRays(mesh), TriangleTree.of(mesh.vertices_mm, mesh.faces)
    below = np.radians(below_deg)
    middle = radius_mm * np.array([0.0, np.cos(below) - 1, -np.sin(below)])
    middle = tree.closest(middle[None]).points_mm[0]
    reach_mm = 2 * radius_mm * np.sin(4.0 / radius_mm / 2)
    views = ring_round_toe(elevation_deg)
    pixels = [pixels_of_disc(view, mesh, caster, middle, reach_mm) for view in views]
    spots = spots_of(pixels, np.array([-1.0]), 1)[0].spots
    (mark,) = finding._agreed_places(spots, views, caster, tree).marks
    error_mm = float(np.linalg.norm(mark.position_mm - middle))
    assert error_mm < within_mm
    assert error_mm < 1.96 * mark.sigma_mm
    if within_mm < 1:
        assert mark.diameter_mm == pytest.approx(8.0, abs=0.5)
        assert mark.sigma_mm < 0.7


def test_what_is_hidden_of_a_disc_shifts_its_middle() -> None:
    """Points of a disc of 10 mm, of which a straight line hides some."""
    steps = np.linspace(-10, 10, 1001)
    x, y = (one.ravel() for one in np.meshgrid(steps, steps))
    disc = np.column_stack([x, y])[np.hypot(x, y) <= 10]
    for line_mm in (9.0, 5.0, 2.0, 0.0, -3.0):
        seen = disc[disc[:, 0] < line_mm]
        middle = seen.mean(0)
        radius = 10 * np.sqrt(len(seen) / len(disc))
        hidden = np.arccos(min((line_mm - middle[0]) / radius, 1.0)) / np.pi
        expected = pytest.approx(-middle[0], rel=0.02, abs=0.02)
        assert shift_by_hidden_mm(float(radius), float(hidden)) == expected
    assert shift_by_hidden_mm(5.0, 0.0) == 0.0


@pytest.mark.parametrize("count", [3, 4, 5, 8, 20])
def test_the_sigma_of_a_place_holds_95_of_100_however_few_photos_tell_it(count: int) -> None:
    draw = np.random.default_rng(count)
    held = []
    for places in 0.4 * draw.normal(size=(3000, count, 2)):
        middle = np.median(places, axis=0)
        away_mm = np.linalg.norm(places - middle, axis=1)
        held.append(np.abs(middle) < 1.96 * sigma_of_median_mm(away_mm, np.zeros(count)))
    assert 0.93 < np.mean(held) < 0.97


def test_a_spot_in_one_photo_only_is_left_out_and_said(capture: Capture, tmp_path: Path) -> None:
    folder = tmp_path / "images"
    shutil.copytree(capture.folder / "images", folder)
    view = capture.truth.views[0]
    mesh = capture.truth.limb.mesh
    facing = view.centre_in_world - mesh.vertices_mm.mean(0)
    facing[2] = 0.0
    along = (mesh.vertex_normals() @ facing) / np.linalg.norm(facing)
    level = np.abs(mesh.vertices_mm[:, 2] - mesh.vertices_mm[:, 2].mean()) < 5
    spot = mesh.vertices_mm[np.where(level, along, -1).argmax()]
    picture = cv2.imread(str(folder / view.name))
    x, y = np.rint(view.project(spot[None])[0]).astype(int).tolist()
    cv2.circle(picture, (x, y), 6, MAGENTA[::-1], -1, cv2.LINE_AA)
    cv2.imwrite(str(folder / view.name), picture, [cv2.IMWRITE_JPEG_QUALITY, 95])

    found = found_in(capture, photos_of(folder), MAGENTA)

    assert len(found.marks) == len(MARKS)
    assert all(np.linalg.norm(mark.position_mm - spot) > 5 for mark in found.marks)
    beside = [one for one in found.left_out if np.linalg.norm(one.position_mm - spot) < 1.5]
    assert len(beside) == 1
    assert beside[0].reason.code == "landmark.spot.few"
    assert beside[0].reason.values["showing"] == 1


def test_a_mark_that_many_squarely_looking_photos_do_not_show_is_left_out(
    capture: Capture, found_by: FoundBy, monkeypatch: pytest.MonkeyPatch
) -> None:
    lenient = found_by(MAGENTA)
    shown = min(len(mark.photos) for mark in lenient.marks)
    monkeypatch.setattr(finding, "_LEAST_PHOTOS", shown + 1)
    strict = found_in(capture, photos_of(capture.folder / "images"), MAGENTA)
    assert len(strict.marks) < len(lenient.marks) == len(MARKS)
    assert len(strict.marks) + len(strict.left_out) >= len(MARKS)


def test_a_colour_that_the_paint_has_is_told(found_by: FoundBy) -> None:
    assert found_by(MAGENTA).shared_share < 0.3
    assert found_by(RED).shared_share > 0.5


def test_a_colour_that_no_pixel_has_is_not_called_the_paints(capture: Capture) -> None:
    found = find_painted_marks((), (), capture.truth.limb.mesh, MAGENTA)
    assert (found.marks, found.left_out, found.shared_share) == ((), (), 0.0)


def test_grey_is_no_colour_for_marks(capture: Capture) -> None:
    with pytest.raises(OptionsError, match="near to grey"):
        found_in(capture, photos_of(capture.folder / "images"), (90, 90, 90))


@pytest.fixture
def case(capture: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> CaseFolder:
    """A case that keeps the true surface, and whose photos are all set aside."""
    scene = SimpleNamespace(placed=(), views=())
    kept = SimpleNamespace(
        mesh=capture.truth.limb.mesh, metric=SimpleNamespace(scene=scene), photos=None
    )
    monkeypatch.setattr(painted, "kept_evidence", lambda _: kept)
    return CaseFolder(tmp_path)


def about_its_axis(mesh: Mesh, turn_deg: float) -> Mesh:
    middle = mesh.vertices_mm.mean(0)
    turn = Rigid.from_rotation_vector(np.array([0, 0, np.radians(turn_deg)]), np.zeros(3))
    return mesh.with_vertices(turn.apply(mesh.vertices_mm - middle) + middle)


@pytest.mark.parametrize("turn_deg", [3.0, 10.0, 30.0])
def test_a_limb_turned_about_its_axis_is_refused(
    capture: Capture, case: CaseFolder, turn_deg: float
) -> None:
    mesh = about_its_axis(capture.truth.limb.mesh, turn_deg)
    with pytest.raises(OptionsError, match="not of this shape as it lies now"):
        painted_marks_of(case, mesh, None)
    moved = mesh.with_vertices(mesh.vertices_mm + np.array([40.0, 0.0, 0.0]))
    with pytest.raises(OptionsError, match=r"surface\.ply"):
        painted_marks_of(case, moved, None)


def _thinned(mesh: Mesh, edge_mm: float) -> Mesh:
    """One vertex for every cell of a grid."""
    cells = np.floor(mesh.vertices_mm / edge_mm).astype(int)
    _, kept, of_vertex = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    faces = of_vertex.reshape(-1)[mesh.faces].astype(np.int32)
    whole = (faces != np.roll(faces, 1, axis=1)).all(1)
    return Mesh(vertices_mm=mesh.vertices_mm[kept], faces=faces[whole])


def test_what_was_made_of_the_cases_surface_is_taken(capture: Capture, case: CaseFolder) -> None:
    """In single precision, in part edited, thinned out, or with the sock taken off."""
    mesh = capture.truth.limb.mesh
    single = mesh.with_vertices(mesh.vertices_mm.astype(np.float32).astype(np.float64))
    swollen = mesh.vertices_mm.copy()
    upper = swollen[:, 2] > np.quantile(swollen[:, 2], 0.7)
    swollen[upper, :2] *= 1.3
    thinned = _thinned(mesh, 5.0)
    assert len(thinned.faces) < len(mesh.faces) / 4
    for made in (single, mesh.with_vertices(swollen), thinned, offset(mesh, -2.0)):
        assert painted_marks_of(case, made, None).marks == ()
