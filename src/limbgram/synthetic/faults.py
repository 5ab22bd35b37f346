"""Faults of real captures: camera, hand, exposure and cloth.

In      a Faults, the ideal camera, a seed, which photo.
Out     the photo's own camera, the camera's motion during the readout, its exposure and white
        balance, and the limb with its cloth slid down.
Limits  each fault is drawn from the seed and the photo's index alone, so that it is the same with
        and without others. Stabilisation shifts the image together with the centre of its
        distortion; the tilt of a stabilised lens is left out.
"""

from dataclasses import dataclass, fields, replace
from enum import Enum

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.synthetic.props.limb import Limb


class Session(Enum):
    """Which photos: those of the limb or those of the calibration board."""

    RING = 30
    CALIBRATION = 31


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Strength of each fault; 0 is an ideal camera."""

    stabiliser_px: float = 0.0
    """Optical stabilisation: standard deviation of the principal point from photo to photo, in x
    and in y, in pixels of the photo. Usual: 0.0025 of the photo's width (10 px
    of 4000), a tenth to a fifth of the travel of a phone's lens, which turns the picture by up to
    a degree: hands that hold still for a photo tremble by a tenth of that."""
    breathing: float = 0.0
    """Refocusing: relative standard deviation of the principal distance from photo to photo. A thin
    lens refocused from D to D' changes it by f (1/D' - 1/D): 0.0005 for a phone (f 4.3 mm, 0.5 m
    give or take 6 %), 0.002 for a 50 mm lens at 1.5 m."""
    readout_s: float = 0.0
    """Rolling shutter: time from the first row of a photo to the last. Usual: 0.02 s for
    a phone (telephones of 2011 to 2023 were measured at 0.010 to 0.033 s); a mirrorless camera's
    electronic shutter takes as long, a mechanical one 0.003 s."""
    hand_deg_s: float = 2.0
    """Standard deviation of the camera's angular velocity about each axis; used with a rolling
    shutter alone. Hands that hold still for a photo turn by 1 to 3 degrees a second."""
    hand_mm_s: float = 20.0
    """Standard deviation of its velocity along each axis."""
    pupil_mm: float = 0.0
    """Depth of field: diameter of the entrance pupil, focused at the middle of the picture. Usual:
    focal length over f-number: 2.4 for a phone's f 4.3 mm at f/1.8, 7.9 for 50 mm at f/6.3. The
    blur is pupil x f x |1/z - 1/focus| pixels."""
    denoise: float = 0.0
    """Noise reduction of a phone: 1 smooths over differences of 6 of 255 tones in brightness and
    four times that in colour, edges kept; 0 none."""
    sharpen: float = 0.0
    """Sharpening after it: amount of the unsharp mask on the luma, with a blur of 1 px. Usual for
    phones: 0.8, which makes edges overshoot by a tenth."""
    stored_again: int = 0
    """JPEG quality of a second encoding, as by a browser or a messenger that passes the photo on
    (0: none), with colours at half resolution. Usual: 80."""
    exposure_ev: float = 0.0
    """Automatic exposure: its standard deviation from photo to photo, in stops. Usual: 0.15."""
    tint: float = 0.0
    """Automatic white balance: relative standard deviation of red and blue against green. Usual:
    0.04."""
    creep_mm: float = 0.0
    """How far the cloth slides down the limb from the first photo to the last, at its open end;
    none at the distal end, and a third as far on one side as on the other. Usual: 0.3."""
    background_mm: float = 0.0
    """How far posters, leaflets and boxes are moved between photos, each way. Usual where people
    pass by: 30."""

    def __post_init__(self) -> None:
        if any(getattr(self, one.name) < 0 for one in fields(self)):
            raise OptionsError("made.camera_fault")
        if self.stored_again > 100:
            raise OptionsError("made.jpeg_quality", quality=self.stored_again)


@dataclass(frozen=True)
class Readout:
    """Rolling shutter of one photo: the camera's motion during the readout.

    The pose of a view holds at the middle of the picture.
    """

    rows: int
    turn_rad: Vector3
    """Rotation vector from the first row to the last, in the camera frame."""
    shift_mm: Vector3

    def at_row(self, row: float) -> Rigid:
        """row_from_middle: from the camera frame at the picture's middle to that at a row."""
        share = self._share(np.array([row]))[0]
        return Rigid.from_rotation_vector(share * self.turn_rad, share * self.shift_mm)

    def at_rows(self, points_in_camera: Points3, rows: Float64[np.ndarray, " n"]) -> Points3:
        """Points in the camera frames of their rows."""
        share = self._share(rows)[:, None]
        turned = Rotation.from_rotvec(share * self.turn_rad).apply(points_in_camera)
        return turned + share * self.shift_mm

    def _share(self, rows: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
        return (rows + 0.5) / self.rows - 0.5


def camera_in_photo(
    ideal: Camera, faults: Faults, seed: int, session: Session, photo_idx: int
) -> Camera:
    """The camera as it was when one photo was taken."""
    camera = ideal
    if faults.stabiliser_px > 0:
        dx, dy = _rng(seed, session, photo_idx, 1).normal(0.0, faults.stabiliser_px, 2)
        camera = replace(camera, cx=camera.cx + dx, cy=camera.cy + dy)
    if faults.breathing > 0:
        longer = 1.0 + _rng(seed, session, photo_idx, 2).normal(0.0, faults.breathing)
        camera = replace(camera, fx=camera.fx * longer, fy=camera.fy * longer)
    return camera


def readout_of(
    faults: Faults, rows: int, seed: int, session: Session, photo_idx: int
) -> Readout | None:
    """The rolling shutter of a photo; None if all rows are read at once."""
    if faults.readout_s == 0:
        return None
    hand = _rng(seed, session, photo_idx, 3).normal(0.0, 1.0, 6) * faults.readout_s
    turn_rad = np.radians(faults.hand_deg_s) * hand[:3]
    return Readout(rows, turn_rad, faults.hand_mm_s * hand[3:])


def exposure_of(
    faults: Faults, seed: int, session: Session, photo_idx: int
) -> Float64[np.ndarray, "3"]:
    """Exposure and white balance of one photo: factors of red, green and blue."""
    light, red, blue = _rng(seed, session, photo_idx, 4).normal(0.0, 1.0, 3)
    exposure = 2.0 ** (faults.exposure_ev * light)
    return exposure * np.array([1.0 + faults.tint * red, 1.0, 1.0 + faults.tint * blue])


def crept(limb: Limb, slid_mm: float, seed: int) -> Limb:
    """The same limb with its cloth, the texture, slid down by up to `slid_mm`."""
    grid = limb.grid_mm.astype(float)
    most_at_rad = np.random.default_rng((seed, 33)).uniform(0, 2 * np.pi)
    around = np.arctan2(grid[..., 1], grid[..., 0]) - most_at_rad
    height = np.clip((grid[..., 2] - limb.base_mm) / limb.height_mm, 0.0, 1.0)
    slid = slid_mm * (1.0 - height) * (2.0 + np.cos(around)) / 3.0
    steps = np.linalg.norm(np.diff(grid, axis=0), axis=2)
    steps = np.concatenate([steps, steps[-1:]])
    # rows of the flat cut lie level, and the sock ends at its rim
    level = np.abs(np.diff(grid[..., 2], axis=0)) < 1e-3 * steps[:-1]
    slid[:-1][level] = 0.0
    up = slid / np.maximum(steps, 1e-6)
    at = limb.chart.astype(int)
    chart = limb.chart.copy()
    chart[..., 1] += up[at[..., 1], at[..., 0]]
    return replace(limb, chart=chart)


def _rng(seed: int, session: Session, photo_idx: int, fault: int) -> np.random.Generator:
    return np.random.default_rng((seed, session.value, photo_idx, fault))
