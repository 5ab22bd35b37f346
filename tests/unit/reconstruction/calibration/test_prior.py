"""Cameras for photos: given calibrations where they fit, EXIF elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import CalibrationError
from limbgram.core.geometry.lens import Camera
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for, focal_from_exif
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
    covariance = np.diag([4.0, 4.0, 1.0, 1.0, 0.0, 1e-6, 1e-6, 1e-8, 1e-8, 0.0])
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


def test_each_group_takes_its_own() -> None:
    small, large = calibrated(1200, 800), calibrated()
    taken = cameras_for(photo_set((4752, 3168), (1200, 800)), [small, large])
    assert taken.calibrations == (large, small)


@pytest.mark.parametrize(
    ("size", "told"),
    [
        ((3168, 4752), "turned by a quarter"),
        ((9504, 6336), "4752 x 3168, the photos are 9504 x 6336"),
        ((4752, 2673), "4752 x 3168, the photos are 4752 x 2673"),
    ],
)
def test_another_size_is_refused_with_both(size: tuple[int, int], told: str) -> None:
    with pytest.raises(CalibrationError, match=told):
        cameras_for(photo_set(size), [calibrated()])


def test_another_camera_or_zoom_is_refused() -> None:
    other = replace(CANON, model="Canon EOS 600D")
    with pytest.raises(CalibrationError, match=r"500D.*600D"):
        cameras_for(photo_set((4752, 3168), exif=other), [calibrated()])
    zoomed = replace(CANON, focal_mm=35.0)
    with pytest.raises(CalibrationError, match=r"50 mm.*35 mm"):
        cameras_for(photo_set((4752, 3168), exif=zoomed), [calibrated()])


def test_photos_that_lost_their_exif_take_the_calibration_of_their_size() -> None:
    given = calibrated()
    assert cameras_for(photo_set((4752, 3168), exif=Exif()), [given]).calibrations == (given,)


@pytest.mark.parametrize(
    ("exif", "size", "focal_px", "sigma"),
    [
        (Exif(focal_35mm=26.0), (4032, 3024), 26 / 43.267 * 5040, 0.05),
        (CANON, (2376, 1584), 50 / 22.3 * 2376, 0.07),
        (by("Meizu", "m1 note", 3.81), (1552, 2096), 1717.4, 0.07),
        (by("Canon", "Canon EOS 5D Mark III", 50.0), (5760, 3840), 8000, 0.07),
        (by("Canon", "Canon EOS R7", 50.0), (4460, 2973), 10000, 0.07),
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
