"""The check of a capture against what is known of it: who is missing, who is blurred, who stands
where."""

import io
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from limbgram.capture.answer import CaptureCheck
from limbgram.cases.capture_check import CaptureWatch, check_sources
from limbgram.cli.main import app
from limbgram.core.errors import PhotoError
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.formats.camera import write_camera
from limbgram.reconstruction.calibration.cameras import Calibration
from limbgram.report.drawings.coverage import coverage_picture
from limbgram.services.parse_capture import DEFAULT_BOARD, parse_board
from limbgram.synthetic import CaptureOptions, make_capture
from limbgram.synthetic.capture import Capture

PHOTOS = 14


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    options = CaptureOptions(
        seed=31, photos=PHOTOS, width_px=720, height_px=480, distance_mm=1300.0,
        calibration_photos=0, mesh_step_mm=1.2, samples=2,
    )  # fmt: skip
    return make_capture(tmp_path_factory.mktemp("check") / "capture", options)


@pytest.fixture(scope="module")
def watch(capture: Capture, lens_of: Callable[[Capture], Calibration]) -> Iterator[CaptureWatch]:
    """A check that looks at each photo, and at each pair, once for all tests of this file."""
    with CaptureWatch([lens_of(capture)], parse_board(DEFAULT_BOARD)) as watch:
        yield watch


@pytest.fixture(scope="module")
def whole(capture: Capture, watch: CaptureWatch) -> CaptureCheck:
    """What is told of all photos."""
    return watch.check(list(capture.photos))


def true_azimuths_deg(capture: Capture) -> np.ndarray:
    middle = capture.truth.limb.mesh.vertices_mm.mean(0)
    away = np.array([view.centre_in_world for view in capture.truth.views]) - middle
    around = np.degrees(np.arctan2(away[:, 1], away[:, 0]))
    return (around - around[0]) % 360


def test_a_good_capture_is_told_to_go(capture: Capture, whole: CaptureCheck) -> None:
    found = whole
    assert found.go, found.headline
    assert told(found.headline).startswith(f"GO: {PHOTOS} of {PHOTOS} photos placed")
    assert found.board_photos is not None
    assert found.board_photos >= 10
    turns = np.array([photo.azimuth_deg for photo in found.photos])
    off = (turns - true_azimuths_deg(capture) + 180) % 360 - 180
    assert np.abs(off).max() < 4  # the middle of the points is not quite that of the mesh
    assert 20 < found.largest_gap_deg < 40
    assert all(0.15 < photo.edge_px < 0.9 for photo in found.photos)
    assert all(1 < photo.features_per_cm2 < 100 for photo in found.photos)
    assert found.coverage is not None
    assert found.coverage.measured > 0.97
    pixel_mm = 1300.0 / capture.truth.views[0].camera.fx
    assert 0.05 < found.coverage.sigma_middle_mm / pixel_mm < 0.13
    assert f"± {1.96 * found.coverage.sigma_middle_mm:.2f} mm" in told(found.headline)


def test_a_missing_side_is_named_with_its_place(capture: Capture, watch: CaptureWatch) -> None:
    photos = list(capture.photos)
    del photos[5:8]
    found = watch.check(photos)
    assert not found.go
    assert len(found.missing) == 1
    missing = found.missing[0]
    assert missing.between == (capture.photos[4].name, capture.photos[8].name)
    assert missing.count in (3, 4)
    true = true_azimuths_deg(capture)
    for place in missing.azimuths_deg:
        assert true[4] < place < true[8]
    assert "o'clock as seen from above" in told(found.headline)
    assert all(15 < height < 45 for height in missing.elevations_deg)
    coverage = found.coverage
    assert coverage is not None
    column = round(float(np.mean(missing.azimuths_deg)) / 15) % coverage.columns
    behind = (column + coverage.columns // 2) % coverage.columns
    assert max(row[column] or 0 for row in coverage.photos[: coverage.side_rows]) <= 2
    assert min(row[behind] or 0 for row in coverage.photos[: coverage.side_rows]) >= 3
    drawn = np.asarray(Image.open(io.BytesIO(coverage_picture(found).tobytes())).convert("RGB"))
    asked = (drawn == np.array([11, 96, 118])).all(axis=2)
    assert asked.sum() > 100  # the photos to add, in the colour of what is to be done
    assert (drawn == np.array([92, 122, 133])).all(axis=2).sum() > 1000


@pytest.mark.slow
def test_a_step_that_was_left_out_is_advice(capture: Capture, watch: CaptureWatch) -> None:
    """All is joined across it and seen, and the verdict of the case would not name it."""
    photos = list(capture.photos)
    left_out = photos.pop(6)
    found = watch.check(photos)
    assert found.go, found.headline
    assert 40 < found.largest_gap_deg < 60
    assert found.missing == ()
    (advice,) = (one for one in found.notes if "empty" in told(one))
    assert photos[5].name in told(advice)
    assert photos[6].name in told(advice)
    assert left_out.name not in told(advice)


@pytest.mark.slow
def test_a_blurred_photo_does_not_count(
    capture: Capture, watch: CaptureWatch, tmp_path: Path
) -> None:
    """Only the limb is blurred; the room round it stays sharp."""
    photos = list(capture.photos)
    with Image.open(photos[6]) as picture:
        exif, pixels = picture.getexif(), np.asarray(picture)
    mask = cv2.imread(str(capture.folder / "truth" / "masks" / f"{photos[6].stem}.png"), 0) > 0
    soft = cv2.GaussianBlur(pixels, (0, 0), 3.0)
    spoiled = np.where(
        cv2.dilate(mask.astype(np.uint8), np.ones((9, 9)))[:, :, None] > 0, soft, pixels
    )
    photos[6] = tmp_path / photos[6].name
    Image.fromarray(spoiled).save(photos[6], quality=97, exif=exif)
    found = watch.check(photos)
    one = found.photos[6]
    assert not one.counts
    assert one.edge_px > 2 or not one.placed
    assert not found.go  # twice the step is empty there now
    assert found.missing[0].between == (photos[5].name, photos[7].name)


def test_photos_that_do_not_join_are_the_answer_and_no_error(
    capture: Capture, watch: CaptureWatch
) -> None:
    found = watch.check([capture.photos[0], capture.photos[5], capture.photos[10]])
    assert not found.go
    assert told(found.headline).startswith("NOT YET")
    assert not found.missing or all(one.count for one in found.missing)


@pytest.mark.slow
def test_without_the_board_it_is_said(capture: Capture) -> None:
    found = check_sources(
        list(capture.photos[:6]),
        [],
        parse_board("charuco:5x4:30:22:6X6_50"),
        Run(),
    )
    assert not found.go
    assert any("board" in told(one).lower() for one in found.findings)


@pytest.mark.slow
def test_a_capture_that_grows_is_told_the_same_and_known_photos_cost_nothing(
    capture: Capture,
    tmp_path: Path,
    lens_of: Callable[[Capture], Calibration],
) -> None:
    lens, board = lens_of(capture), parse_board(DEFAULT_BOARD)
    whole = check_sources(list(capture.photos), [lens], board, Run())
    with CaptureWatch([lens], board) as watch:
        shutil.copy(capture.photos[0], tmp_path)
        with pytest.raises(PhotoError, match="can be read so far: 1;"):
            watch.check([tmp_path])
        for photo in capture.photos[1:11]:
            shutil.copy(photo, tmp_path)
        (tmp_path / "notes.txt").write_text("not a photo")
        part = watch.check([tmp_path])
        assert not part.go
        assert len(part.photos) == 11
        for photo in capture.photos[11:]:
            shutil.copy(photo, tmp_path)
        run, again = Run(), Run()
        found = watch.check([tmp_path], run)
        assert watch.check([tmp_path], again) == found
        stages, before = ([one.stage for one in each.timings] for each in (again, run))
        assert not {*stages} & {"read photos", "reduce photos", "detect", "match pairs"}
        # The limb's own matches are verified in both, where it is asked whether it moved.
        assert stages.count("verify") == before.count("verify") - 1
    assert found.go
    assert [one.name for one in found.photos] == [one.name for one in whole.photos]
    assert found.coverage is not None
    assert whole.coverage is not None
    expected = whole.coverage.sigma_middle_mm
    assert found.coverage.sigma_middle_mm == pytest.approx(expected, rel=0.05)
    turns = [one.azimuth_deg for one in found.photos]
    np.testing.assert_allclose(turns, [one.azimuth_deg for one in whole.photos], atol=0.5)


@pytest.mark.slow
def test_the_command_watches_until_go(
    capture: Capture, tmp_path: Path, lens_of: Callable[[Capture], Calibration]
) -> None:
    camera = tmp_path / "camera.json"
    write_camera(camera, lens_of(capture))
    asked = ["check", str(capture.folder / "images"), "--camera", str(camera), "--watch"]
    said = CliRunner().invoke(app, [*asked, "--json", "--picture", str(tmp_path / "ring.png")])
    assert said.exit_code == 0, said.output
    assert json.loads(said.stdout)["go"]
    assert (tmp_path / "ring.png").stat().st_size > 10_000


@pytest.mark.slow
def test_masks_hide_the_room_from_the_check(
    capture: Capture,
    whole: CaptureCheck,
    tmp_path: Path,
    lens_of: Callable[[Capture], Calibration],
) -> None:
    limb = capture.truth.limb.mesh.vertices_mm
    for view, photo in zip(capture.truth.views, capture.photos, strict=True):
        hull = cv2.convexHull(np.round(view.project(limb)).astype(np.int32))
        mask = np.zeros((view.camera.height_px, view.camera.width_px), np.uint8)
        Image.fromarray(cv2.fillConvexPoly(mask, hull, 255)).save(tmp_path / f"{photo.stem}.png")
    found = check_sources(
        list(capture.photos), [lens_of(capture)], parse_board(DEFAULT_BOARD), Run(),
        masks=tmp_path,
    )  # fmt: skip
    assert found.go, found.headline
    assert f"All {PHOTOS} photos have masks" in told(found.notes[0])
    shown, all_of_it = (np.mean([p.points for p in one.photos]) for one in (found, whole))
    assert 0.3 * all_of_it < shown < 0.95 * all_of_it
    assert found.board_photos == whole.board_photos
    nothing = tmp_path / "nothing"
    nothing.mkdir()
    with pytest.raises(PhotoError, match="is named as the mask of a photo"):
        check_sources(list(capture.photos), [], None, Run(), masks=nothing)
