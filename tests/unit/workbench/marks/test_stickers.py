"""Stickers on a round limb: placed by the photos that show them, named by a file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from limbgram.cli.main import app
from limbgram.core.errors import OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.findings import note, told
from limbgram.reconstruction.targets.marks import MarkDetections, PhotoMarks
from limbgram.services.parse_text import sticker_names
from limbgram.workbench.marks.stickers import place_stickers

CAMERA = Camera(width_px=3000, height_px=2000, fx=5000.0, fy=5000.0, cx=1499.5, cy=999.5, k1=-0.08)
RADIUS_MM, HALF_MM = 50.0, 6.0
UP = np.array([0.0, 0.0, 1.0])


def view(k: int, deg: float) -> View:
    around = np.radians(deg)
    centre = 900.0 * np.array([np.cos(around), np.sin(around), 0.3])
    return View(f"{k}.jpg", CAMERA, Rigid.looking_at(centre, np.zeros(3), UP))


VIEWS = [view(k, deg) for k, deg in enumerate((-40.0, -15.0, 5.0, 30.0, 50.0))]


def corners_mm(deg: float) -> np.ndarray:
    """A sticker on a cylinder about z, its corners clockwise as seen from outside."""
    width = HALF_MM / RADIUS_MM
    places = [(-width, HALF_MM), (width, HALF_MM), (width, -HALF_MM), (-width, -HALF_MM)]
    return np.array(
        [
            (RADIUS_MM * np.cos(np.radians(deg) + a), RADIUS_MM * np.sin(np.radians(deg) + a), z)
            for a, z in places
        ]
    )


def detections(
    photos: list[int], noise_px: float = 0.0, doubt: str = "", ids: tuple[int, ...] = (12,)
) -> MarkDetections:
    rng = np.random.default_rng(1)
    corners = corners_mm(10.0)
    return MarkDetections(
        dictionary="APRILTAG_36H11",
        photos=tuple(
            PhotoMarks(
                name=VIEWS[k].name,
                photo_idx=k,
                ids=np.array(ids, np.int32),
                corners_px=np.array([VIEWS[k].project(corners)] * len(ids))
                + rng.normal(0, noise_px, (len(ids), 4, 2)),
                centres_px=np.zeros((len(ids), 2)),
                sigmas_px=np.full(len(ids), 0.02),
                bent=np.ones(len(ids), bool),
                doubtful_ids=np.array([30] if doubt else [], np.int32),
                doubts=(note("said.as_is", message=doubt),) if doubt else (),
            )
            for k in photos
        ),
    )


def test_a_sticker_lies_under_its_middle_and_keeps_its_side() -> None:
    found = place_stickers(detections([0, 1, 2, 3], noise_px=0.05), VIEWS)
    assert found.lost == ()
    (one,) = found.placed
    straight_out = np.array([np.cos(np.radians(10)), np.sin(np.radians(10)), 0.0])
    chord_mm = RADIUS_MM * np.cos(HALF_MM / RADIUS_MM)
    assert 1e-5 < np.linalg.norm(one.position_mm - chord_mm * straight_out) < 0.05
    assert one.side_mm == pytest.approx(2 * HALF_MM, abs=0.05)
    assert 0.002 < one.sigma_mm < 0.05
    assert one.photos == ("0.jpg", "1.jpg", "2.jpg", "3.jpg")


@pytest.mark.parametrize("photos", [[1, 3], [0, 2, 4], [0, 1, 2, 3, 4]])
def test_the_sigma_of_a_stickers_corners_holds_95_of_100_however_few_photos_tell_it(
    photos: list[int],
) -> None:
    """Corners are read 0.3 px off; how far, the disagreement of so few photos tells badly.

    The middle of four corners is twice as sure as each of them.
    """
    rng = np.random.default_rng(len(photos))
    exact = detections(photos)
    off, told_mm = [], []
    straight_out = np.array([np.cos(np.radians(10)), np.sin(np.radians(10)), 0.0])
    middle = RADIUS_MM * np.cos(HALF_MM / RADIUS_MM) * straight_out
    for _ in range(800):
        read = tuple(
            replace(one, corners_px=one.corners_px + rng.normal(0, 0.3, (1, 4, 2)))
            for one in exact.photos
        )
        (one,) = place_stickers(replace(exact, photos=read), VIEWS).placed
        off.append(2 * (one.position_mm - middle))
        told_mm.append(one.sigma_mm)
    # Told is the mean over all directions: each is brought to that by its own spread.
    spread = np.sqrt(np.mean(np.square(off), axis=0))
    alike = np.array(off) / spread * np.sqrt(np.mean(spread**2))
    assert 0.93 < np.mean(np.abs(alike) < 1.96 * np.array(told_mm)[:, None]) < 0.97


def test_a_photo_that_shows_it_elsewhere_is_left_out() -> None:
    found = detections([0, 1, 2, 3, 4])
    found.photos[2].corners_px[0] += 25.0
    (one,) = place_stickers(found, VIEWS).placed
    assert one.photos == ("0.jpg", "1.jpg", "3.jpg", "4.jpg")
    found.photos[1].corners_px[0] -= 30.0
    found.photos[3].corners_px[0] += np.array([60.0, 0.0])
    after = place_stickers(found, VIEWS)
    assert after.placed == ()
    assert after.lost[0].reason == note("landmark.sticker.moved")


def test_a_sticker_that_one_photo_shows_or_none_believes_says_why() -> None:
    found = place_stickers(detections([1], doubt="the photo shows this mark twice"), VIEWS)
    assert [one.mark_id for one in found.lost] == [12, 30]
    assert found.lost[0].reason == note("landmark.sticker.few", count=1, least=2)
    assert found.lost[1].reason.code == "landmark.sticker.doubted"
    assert "twice" in told(found.lost[1].reason)


def test_names_are_read_and_what_is_no_number_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "names.json"
    file.write_text('{"12": " fibula head", "3": "tibial tubercle"}')
    assert sticker_names(file) == {12: "fibula head", 3: "tibial tubercle"}
    for text in ('{"x2": "fibula head"}', '["fibula head"]', '{"12": 5}', "no json"):
        file.write_text(text)
        with pytest.raises(OptionsError, match="names no stickers"):
            sticker_names(file)


def test_stickers_without_photos_are_refused(tmp_path: Path) -> None:
    shape = tmp_path / "limb.stl"
    shape.write_bytes(trimesh.creation.capsule(height=200.0, radius=50.0).export(file_type="stl"))
    names = tmp_path / "names.json"
    names.write_text('{"12": "fibula head"}')
    words = ["align", str(shape), "--side", "left", "--stickers", str(names)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 2
    assert "--photos" in result.output
