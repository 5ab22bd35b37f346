"""Cameras for photos: given calibrations where they fit, EXIF elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, Camera
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    cameras_for,
    focal_from_exif,
    label_of,
    with_square_pixels,
)
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, PhotoSet

CANON = Exif(make="Canon", model="Canon EOS 500D", lens="EF50mm f/1.8 II", focal_mm=50.0)
LABEL = "Canon EOS 500D EF50mm f/1.8 II"


def by(make: str, model: str, focal_mm: float) -> Exif:
    return Exif(make=make, model=model, focal_mm=focal_mm)


def photo_set(*sizes: tuple[int, int], exif: Exif = CANON) -> PhotoSet:
    return PhotoSet(
        (), tuple(CameraGroup(label="", width_px=w, height_px=h, exif=exif) for w, h in sizes)
    )


def calibrated(width_px: int = 4752, height_px: int = 3168) -> Calibration:
    camera = Camera(
        width_px=width_px, height_px=height_px, fx=11000.0, fy=11002.0, cx=2380.0, cy=1570.0, k1=0.1
    )
    variances = {"fx": 4.0, "fy": 4.0, "cx": 1.0, "cy": 1.0}
    variances |= {"k1": 1e-6, "k2": 1e-6, "p1": 1e-8, "p2": 1e-8}
    covariance = np.diag([variances.get(name, 0.0) for name in PARAMETERS])
    return Calibration(
        camera=camera,
        covariance=covariance,
        source="board",
        label=LABEL,
        focal_mm=50.0,
        rms_px=0.1,
    )


def test_a_calibration_of_the_same_size_is_taken_as_it_is() -> None:
    given = calibrated()
    assert cameras_for(photo_set((4752, 3168)), [given]).calibrations == (given,)


def test_a_smaller_copy_takes_the_calibration_with_it() -> None:
    (taken,) = cameras_for(photo_set((2376, 1584)), [calibrated()]).calibrations
    assert (taken.camera.width_px, taken.camera.height_px) == (2376, 1584)
    assert taken.camera.fx == pytest.approx(5500.0)
    assert taken.camera.cx == pytest.approx((2380.0 + 0.5) / 2 - 0.5)
    assert taken.camera.k1 == 0.1
    assert taken.sigmas[:4] == pytest.approx([1.0, 1.0, 0.5, 0.5])
    assert taken.sigmas[5] == pytest.approx(1e-3)


@pytest.mark.parametrize("size", [(1600, 1067), (894, 596), (893, 595)])
def test_a_copy_in_whole_pixels_shows_the_whole_picture(size: tuple[int, int]) -> None:
    """Whoever reduces a picture maps borders to borders, and rounds each side by itself."""
    given = calibrated()
    (taken,) = cameras_for(photo_set(size), [given]).calibrations
    points = np.array([(-0.2, -0.14, 1.0), (0.0, 0.0, 1.0), (0.2, 0.14, 1.0), (0.2, -0.14, 1.0)])
    shrunk = np.array(size) / [given.camera.width_px, given.camera.height_px]
    expected = (given.camera.project(points) + 0.5) * shrunk - 0.5
    np.testing.assert_allclose(taken.camera.project(points), expected, atol=1e-6)
    assert taken.sigmas[:4] == pytest.approx(given.sigmas[:4] * np.tile(shrunk, 2))
    assert with_square_pixels(taken) is taken


def test_each_group_takes_its_own() -> None:
    small, large = calibrated(1200, 800), calibrated()
    taken = cameras_for(photo_set((4752, 3168), (1200, 800)), [small, large])
    assert taken.calibrations == (large, small)


@pytest.mark.parametrize(
    ("size", "told"),
    [
        ((9504, 6336), "4752 x 3168, the photos are 9504 x 6336"),
        ((4752, 2673), "4752 x 3168, the photos are 4752 x 2673"),
    ],
)
def test_another_size_is_refused_with_both(size: tuple[int, int], told: str) -> None:
    with pytest.raises(CalibrationError, match=told):
        cameras_for(photo_set(size), [calibrated()])


@pytest.mark.parametrize(("left", "top", "scale"), [(0, 0, 1.0), (700, 500, 1.0), (300, 90, 0.8)])
def test_photos_that_were_cut_hold_the_true_lens_wherever_they_were_cut(
    left: int, top: int, scale: float
) -> None:
    """Beside whole ones they are no other camera; by themselves they are not known to be cut."""
    size = round(4000 * scale), round(2600 * scale)
    photos = photo_set((4752, 3168), size)
    whole, cut = cameras_for(photos, [calibrated()]).calibrations
    assert whole.camera == calibrated().camera
    true = calibrated().camera
    centre = np.array([true.cx - left, true.cy - top]) * scale
    off = np.array([cut.camera.fx, cut.camera.cx, cut.camera.cy]) - [true.fx * scale, *centre]
    assert (np.abs(off) < 2.0 * cut.sigmas[[0, 2, 3]]).all()
    assert cut.sigmas[2] < 0.25 * 4752
    assert (cut.camera.k1, cut.source) == (0.1, "guess")
    assert (cut.camera.width_px, cut.camera.height_px) == size
    with pytest.raises(CalibrationError):
        cameras_for(photo_set(size), [calibrated()])


@pytest.mark.parametrize("left", [0, 1300, 2752])
def test_an_upright_part_of_a_broad_picture_holds_the_true_lens_wherever_it_was_cut(
    left: int,
) -> None:
    """A limb that stands upright in it: the part fits as it is, and turned by a quarter too."""
    _, cut = cameras_for(photo_set((4752, 3168), (2000, 2800)), [calibrated()]).calibrations
    true = calibrated().camera
    off = np.array([cut.camera.cx, cut.camera.cy]) - [true.cx - left, true.cy - 100]
    assert (np.abs(off) < 2.0 * cut.sigmas[[2, 3]]).all()
    _, turned = cameras_for(photo_set((4752, 3168), (2000, 4000)), [calibrated()]).calibrations
    room_px = np.array([3168 - 2000, 4752 - 4000])
    assert turned.sigmas[2:4] == pytest.approx(room_px / np.sqrt(12.0), rel=1e-3)


def test_photos_that_were_cut_without_a_calibration_have_the_focal_length_of_whole_ones() -> None:
    whole, cut = cameras_for(photo_set((4752, 3168), (2400, 2100)), []).calibrations
    assert cut.camera.fx == pytest.approx(whole.camera.fx)
    assert cut.sigmas[2] > (4752 - 2400) / 4


def test_another_camera_or_zoom_is_refused() -> None:
    other = replace(CANON, model="Canon EOS 600D")
    with pytest.raises(CalibrationError, match=r"500D.*600D"):
        cameras_for(photo_set((4752, 3168), exif=other), [calibrated()])
    zoomed = replace(CANON, focal_mm=35.0)
    with pytest.raises(CalibrationError, match=r"50 mm.*35 mm"):
        cameras_for(photo_set((4752, 3168), exif=zoomed), [calibrated()])


@pytest.mark.parametrize("side", [1, -1])
def test_photos_that_a_program_turned_hold_the_true_lens_within_a_sigma(side: int) -> None:
    """Against the lens itself, turned to either side."""
    given = calibrated()
    given = replace(given, camera=replace(given.camera, p1=4e-4, p2=-3e-4))
    (taken,) = cameras_for(photo_set((3168, 4752)), [given]).calibrations
    lens = given.camera
    points = np.random.default_rng(1).uniform(-1, 1, (50, 3)) * [300.0, 200, 100] + [0, 0, 1500]
    stored = lens.project(points)
    if side == 1:  # clockwise: rows become columns from the right
        turned, turned_px = points * [1, -1, 1], (3167 - stored[:, 1], stored[:, 0])
    else:
        turned, turned_px = points * [-1, 1, 1], (stored[:, 1], 4751 - stored[:, 0])
    turned = turned[:, [1, 0, 2]]
    step = np.zeros(LENS_SIZE)
    step[[2, 3, 7, 8]] = np.array([-(1570 - 1583.5), 2380 - 2375.5, -3e-4, -4e-4]) * side
    true = taken.camera.with_parameters(taken.camera.packed + step)
    np.testing.assert_allclose(true.project(turned), np.column_stack(turned_px), atol=1e-6)
    moved = step[[2, 3, 7, 8]]
    within = taken.covariance[np.ix_([2, 3, 7, 8], [2, 3, 7, 8])]
    assert 0.99 < moved @ np.linalg.solve(within, moved) < 1.0  # beside it the lens's own sigmas
    assert np.linalg.eigvalsh(taken.covariance).min() > -1e-9
    assert taken.sigmas[:2] == pytest.approx([2.0, 2.0])


PHONE = Exif(make="Apple", model="iPhone 13 Pro", lens="back camera 5.7mm f/1.5", focal_mm=5.7)


@pytest.mark.parametrize(
    ("taken_with", "told"),
    [
        (replace(PHONE, focal_35mm=26.0), None),
        (replace(PHONE, focal_35mm=27.0), None),  # whole millimetres, rounded
        (replace(PHONE, focal_35mm=29.0, digital_zoom=1.1), "enlarged 1.1 times"),
        (replace(PHONE, focal_35mm=29.0), "26 mm in terms of 35-mm film.*29 mm"),
        (replace(PHONE, focal_35mm=26.0, digital_zoom=2.0), "enlarged 2 times"),
        (replace(PHONE, lens="back camera 9mm f/2.8", focal_mm=9.0), "back camera 9mm"),
        (replace(PHONE, lens=None, focal_mm=1.57), "5.7 mm.*1.57 mm"),
        (replace(PHONE, body="aaaaaaaa"), "another Apple iPhone 13 Pro"),
    ],
)
def test_a_phone_s_other_lens_or_zoom_is_refused(taken_with: Exif, told: str | None) -> None:
    given = replace(
        calibrated(4032, 3024),
        label=label_of(PHONE),
        focal_mm=5.7,
        focal_35mm=26.0,
        body="bbbbbbbb",
    )
    photos = photo_set((4032, 3024), exif=taken_with)
    if told is None:
        assert cameras_for(photos, [given]).calibrations == (given,)
        return
    with pytest.raises(CalibrationError, match=told):
        cameras_for(photos, [given])


def test_bodies_of_one_model_take_each_its_own_calibration() -> None:
    first, second = (
        replace(calibrated(), body=body, rms_px=rms_px)
        for body, rms_px in (("aaaaaaaa", 0.1), ("bbbbbbbb", 0.2))
    )
    groups = (replace(CANON, body="bbbbbbbb"), replace(CANON, body="aaaaaaaa"))
    photos = PhotoSet(
        (), tuple(CameraGroup(label="", width_px=4752, height_px=3168, exif=e) for e in groups)
    )
    assert cameras_for(photos, [first, second]).calibrations == (second, first)


def test_two_calibrations_that_fit_alike_are_refused() -> None:
    first = calibrated()
    second = replace(first, camera=replace(first.camera, fx=11100.0, fy=11102.0))
    with pytest.raises(CalibrationError, match="2 calibrations given fit"):
        cameras_for(photo_set((4752, 3168)), [first, second])
    assert cameras_for(photo_set((4752, 3168)), [first, first]).calibrations == (first,)
    named = replace(second, label="")  # of an unknown camera: the other says more
    assert cameras_for(photo_set((4752, 3168)), [named, first]).calibrations == (first,)


def test_a_digital_zoom_lengthens_the_guess_or_widens_its_sigma() -> None:
    by_sensor = focal_from_exif(replace(CANON, digital_zoom=1.5), 4752, 3168)
    assert by_sensor.focal_px == pytest.approx(1.5 * focal_from_exif(CANON, 4752, 3168).focal_px)
    counted = Exif(focal_35mm=39.0, digital_zoom=1.5)
    guess = focal_from_exif(counted, 4032, 3024)
    assert guess.focal_px == pytest.approx(39 / 43.267 * 5040, rel=1e-3)
    not_counted = guess.focal_px * 1.5
    assert (not_counted - guess.focal_px) / guess.focal_px < 2 * guess.relative_sigma


def test_photos_that_lost_their_exif_take_the_calibration_of_their_size() -> None:
    given = calibrated()
    assert cameras_for(photo_set((4752, 3168), exif=Exif()), [given]).calibrations == (given,)


def test_a_model_whose_name_is_the_beginning_of_another_is_not_taken_for_it() -> None:
    """A phone X10 of the same size is no X1; a file without a lens still fits its body's photos."""
    short, long = (
        Exif(make="Acme", model=f"Acme {model}", focal_mm=50.0) for model in ("X1", "X10")
    )
    for exif, label in ((long, "Acme X1"), (short, "Acme X10")):
        with pytest.raises(CalibrationError):
            cameras_for(photo_set((4752, 3168), exif=exif), [replace(calibrated(), label=label)])
    body = replace(calibrated(), label="Canon EOS 500D")
    assert cameras_for(photo_set((4752, 3168)), [body]).calibrations == (body,)
    bare = replace(CANON, lens=None)
    assert cameras_for(photo_set((4752, 3168), exif=bare), [calibrated()]).calibrations[0].camera.k1


@pytest.mark.parametrize(
    ("exif", "size", "focal_px", "sigma"),
    [
        (Exif(focal_35mm=26.0), (4032, 3024), 26 / 43.267 * 5040, 0.05),
        (CANON, (2376, 1584), 50 / 22.3 * 2376, 0.07),
        (by("Meizu", "m1 note", 3.81), (1552, 2096), 1717.4, 0.07),
        (by("Canon", "Canon EOS 5D Mark III", 50.0), (5760, 3840), 8000, 0.07),
        (by("Canon", "Canon EOS R7", 50.0), (4460, 2973), 10000, 0.07),
        (by("Canon", "Canon EOS R6m2", 36.0), (6000, 4000), 6000, 0.07),
        (by("Canon", "Canon EOS Ra", 36.0), (6720, 4480), 6720, 0.07),
        (by("RICOH IMAGING COMPANY, LTD.", "PENTAX K-1 Mark II", 35.9), (7360, 4912), 7360, 0.07),
        (by("SONY", "ILCE-7M3", 35.8), (6000, 4000), 6000, 0.07),
        (by("SONY", "ILCE-6400", 23.5), (6000, 4000), 6000, 0.07),
        (by("NIKON CORPORATION", "NIKON D850", 35.9), (8256, 5504), 8256, 0.07),
        (by("NIKON CORPORATION", "NIKON D5600", 23.5), (6000, 4000), 6000, 0.07),
        (Exif(focal_mm=4.2), (4000, 3000), 4800, 0.3),
        (Exif(), (3000, 4000), 4800, 0.3),
    ],
)
def test_the_most_telling_tag_gives_the_focal_length(
    exif: Exif, size: tuple[int, int], focal_px: float, sigma: float
) -> None:
    guess = focal_from_exif(exif, *size)
    assert guess.focal_px == pytest.approx(focal_px, rel=1e-3)
    assert guess.relative_sigma == sigma
    assert guess.source == ("guess" if sigma == 0.3 else "exif")


def test_a_guess_says_that_it_is_one() -> None:
    (guess,) = cameras_for(photo_set((2376, 1584)), []).calibrations
    camera, sigmas = guess.camera, guess.sigmas
    assert guess.source == "exif"
    assert (camera.cx, camera.cy) == (1187.5, 791.5)
    assert 0.05 * camera.fx < sigmas[0] < 0.1 * camera.fx
    assert 10 < sigmas[2] < 60
    assert sigmas[4] == sigmas[9] == 0.0
    aspect = np.array([-1.0, 1.0]) / camera.fx
    assert np.sqrt(aspect @ guess.covariance[:2, :2] @ aspect) == pytest.approx(0.001)
    assert np.linalg.eigvalsh(guess.covariance).min() > -1e-9


def oblong(ratio: float) -> Calibration:
    """A calibration whose pixels are not square; fy is known twice as well as fx."""
    found = calibrated()
    camera = replace(found.camera, fx=10_000.0 * ratio, fy=10_000.0)
    covariance = found.covariance.copy()
    covariance[:4, :4] = 0.0
    covariance[[0, 1, 2], [0, 1, 2]] = 400.0, 100.0, 25.0
    covariance[0, 2] = covariance[2, 0] = 50.0
    return replace(found, camera=camera, covariance=covariance)


def test_a_calibration_of_almost_square_pixels_is_held_to_square_ones() -> None:
    """The weighted mean of both focal lengths, and what hangs on them follows."""
    given = oblong(1.004)
    held = with_square_pixels(given)
    mean = 10_000.0 + 40.0 * 100.0 / (100.0 + 400.0)
    assert held.camera.fx == pytest.approx(mean, abs=0.1)
    assert held.camera.fy == pytest.approx(mean, abs=0.1)
    assert held.camera.cx == pytest.approx(given.camera.cx - 40.0 * 50.0 / 500.0, abs=0.01)
    assert held.camera.k1 == given.camera.k1
    assert held.sigmas[0] == pytest.approx(np.sqrt(100.0 * 400.0 / 500.0), rel=0.01)
    ratio = held.covariance[0, 0] + held.covariance[1, 1] - 2 * held.covariance[0, 1]
    assert np.sqrt(ratio) == pytest.approx(1.0, rel=0.01), "a ten thousandth, as sound ones are"
    assert np.linalg.eigvalsh(held.covariance)[0] > -1e-9


@pytest.mark.parametrize("ratio", [1.0, 1.0009, 0.9991, 1.067, 1.33])
def test_square_pixels_and_those_meant_to_be_oblong_are_left_alone(ratio: float) -> None:
    given = oblong(ratio)
    assert with_square_pixels(given) is given
