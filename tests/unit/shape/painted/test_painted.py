"""Painted marks against their true places on a synthetic capture, with things that are none."""

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from limbgram.cases.assessing import painted
from limbgram.cases.assessing.painted import painted_marks_of
from limbgram.cases.folder import CaseFolder
from limbgram.errors import OptionsError
from limbgram.photos import PhotoSet, read_photos
from limbgram.shape.painted import PaintedMarks, PaintedOptions, find_painted_marks
from limbgram.synthetic import (
    MAGENTA,
    SMALL,
    Capture,
    PaintedSpot,
    make_capture,
    places_mm,
    scattered_spots,
)

RED = (203, 32, 44)
MARKS = scattered_spots(4)
OF_A_DABS_COLOUR = PaintedSpot(around=0.55, height=0.5, colour=RED, diameter_mm=10.0)
OF_A_DABS_COLOUR_TOO = PaintedSpot(around=0.2, height=0.7, colour=RED, diameter_mm=10.0)
SPOTS = (*MARKS, OF_A_DABS_COLOUR, OF_A_DABS_COLOUR_TOO)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    options = replace(SMALL, photos=13, calibration_photos=0, spots=SPOTS)
    return make_capture(tmp_path_factory.mktemp("painted") / "capture", options)


def found_in(capture: Capture, photos: PhotoSet, options: PaintedOptions) -> PaintedMarks:
    return find_painted_marks(photos.photos, capture.truth.views, capture.truth.limb.mesh, options)


def photos_of(folder: Path) -> PhotoSet:
    return read_photos([folder])


def true_places(capture: Capture) -> np.ndarray:
    return np.stack(places_mm(capture.truth.limb, MARKS))


@pytest.mark.parametrize("colour", [None, MAGENTA, (255, 0, 255)])
def test_marks_are_found_where_they_were_painted_and_nothing_else_is(
    capture: Capture, colour: tuple[int, int, int] | None
) -> None:
    options = PaintedOptions(colour=colour)
    marks = found_in(capture, photos_of(capture.folder / "images"), options).marks
    apart = np.linalg.norm(
        np.stack([mark.position_mm for mark in marks])[:, None] - true_places(capture), axis=2
    )
    assert len(marks) == len(MARKS)
    assert sorted(apart.argmin(1).tolist()) == list(range(len(MARKS)))
    assert 1e-4 < apart.min(1).max() < 0.6  # lower: the answer came out of pixels
    for mark in marks:
        assert 3 <= len(mark.photos) <= mark.looking < len(capture.photos)
        assert mark.diameter_mm == pytest.approx(MARKS[0].diameter_mm, abs=1.2)
        assert 0 < mark.sigma_mm <= mark.spread_mm < 1.0
        red, green, blue = map(int, mark.colour)
        assert red > green + 60
        assert blue > green + 60


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

    found = found_in(capture, photos_of(folder), PaintedOptions(colour=MAGENTA))

    assert len(found.marks) == len(MARKS)
    assert all(np.linalg.norm(mark.position_mm - spot) > 5 for mark in found.marks)
    beside = [one for one in found.left_out if np.linalg.norm(one.position_mm - spot) < 1.5]
    assert len(beside) == 1
    assert beside[0].reason.startswith("1 of ")


def test_a_mark_that_many_squarely_looking_photos_do_not_show_is_left_out(
    capture: Capture,
) -> None:
    photos = photos_of(capture.folder / "images")
    lenient = found_in(capture, photos, PaintedOptions(colour=MAGENTA, least_photos=2))
    shown = min(len(mark.photos) for mark in lenient.marks)
    strict = found_in(capture, photos, PaintedOptions(colour=MAGENTA, least_photos=shown + 1))
    assert len(strict.marks) < len(lenient.marks) == len(MARKS)
    assert len(strict.marks) + len(strict.left_out) >= len(MARKS)


def test_a_colour_that_the_paint_has_is_told(capture: Capture) -> None:
    photos = photos_of(capture.folder / "images")
    assert found_in(capture, photos, PaintedOptions(colour=MAGENTA)).shared_share < 0.3
    assert found_in(capture, photos, PaintedOptions(colour=RED)).shared_share > 0.5


def test_grey_is_no_colour_for_marks(capture: Capture) -> None:
    with pytest.raises(OptionsError, match="near to grey"):
        found_in(capture, photos_of(capture.folder / "images"), PaintedOptions(colour=(90, 90, 90)))


def test_photos_of_another_shape_are_refused(
    capture: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    mesh = capture.truth.limb.mesh

    monkeypatch.setattr(painted, "kept_evidence", lambda _: SimpleNamespace(mesh=mesh))
    moved = mesh.with_vertices(mesh.vertices_mm + np.array([40.0, 0.0, 0.0]))
    with pytest.raises(OptionsError, match="not of this shape"):
        painted_marks_of(CaseFolder(tmp_path), moved, PaintedOptions())
