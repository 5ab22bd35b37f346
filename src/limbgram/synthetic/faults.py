"""Faults of real cameras: what a photo has that an ideal camera would not give.

In      a Faults, the ideal camera, a seed, which photo.
Out     that photo's own camera, how the hand moved while its rows were read, its exposure and
        colours, and the limb with its cloth where it had crept to.
Limits  each fault is drawn from the seed and the photo's number alone, so that a capture with two
        of them has each as it is alone. A stabilised lens is taken to shift its whole image, with
        the middle of its distortion; that it also tilts a little is left out.
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
    """How strong each fault is; 0 is an ideal camera."""

    stabiliser_px: float = 0.0
    """Optical stabilisation: how far the principal point wanders from photo to photo, one standard
    deviation of x and of y each, in pixels of the photo. Usual: 0.0025 of the photo's width (10 px
    of 4000), a tenth to a fifth of the travel of a phone's lens, which turns the picture by up to
    a degree: hands that hold still for a photo tremble by a tenth of that."""
    breathing: float = 0.0
    """Refocusing: how far the principal distance changes from photo to photo, one standard
    deviation, as a share of it. A thin lens refocused from D to D' changes it by
    f (1/D' - 1/D): 0.0005 for a phone (f 4.3 mm, 0.5 m give or take 6 %), 0.002 for a 50 mm lens
    at 1.5 m."""
    readout_s: float = 0.0
    """Rolling shutter: how long the rows of a photo are read one after the other. Usual: 0.02 s for
    a phone (telephones of 2011 to 2023 were measured at 0.010 to 0.033 s); a mirrorless camera's
    electronic shutter takes as long, a mechanical one 0.003 s."""
    hand_deg_s: float = 2.0
    """How fast the hand turns the camera meanwhile, one standard deviation about each axis. Used
    with a rolling shutter alone. Held still for a photo, hands turn by 1 to 3 degrees a second."""
    hand_mm_s: float = 20.0
    """How fast it carries the camera meanwhile, one standard deviation along each axis."""
    pupil_mm: float = 0.0
    """Depth of field: diameter of the opening through which the light passes, focused at what the
    camera is aimed at. Usual: focal length over f-number: 2.4 for a phone's f 4.3 mm at f/1.8, 7.9
    for 50 mm at f/6.3. What is nearer or farther is blurred over pupil x f x |1/z - 1/focus|
    pixels."""
    denoise: float = 0.0
    """Noise reduction of a phone: 1 smooths over differences of 6 of 255 tones in brightness and
    four times that in colour, edges kept; 0 none."""
    sharpen: float = 0.0
    """Sharpening after it: how much of the difference to the photo blurred by 1 px is added to its
    brightness. Usual for phones: 0.8, which makes edges overshoot by a tenth."""
    stored_again: int = 0
    """JPEG quality of a second encoding, as by a browser or a messenger that passes the photo on
    (0: none), with colours at half resolution. Usual: 80."""
    exposure_ev: float = 0.0
    """Automatic exposure: how far it wanders from photo to photo, one standard deviation, in
    stops. Usual: 0.15."""
    tint: float = 0.0
    """Automatic white balance: how far red and blue wander against green, as a share. Usual:
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
    """How the camera moved while the rows of one photo were read.

    The pose that a view tells is that of the middle of the picture.
    """

    rows: int
    turn_rad: Vector3
    """From the first row to the last, about the axes of the camera's frame."""
    shift_mm: Vector3

    def at_row(self, row: float) -> Rigid:
        """The frame of the camera at a row from that of the picture's middle."""
        share = self._share(np.array([row]))[0]
        return Rigid.from_rotation_vector(share * self.turn_rad, share * self.shift_mm)

    def at_rows(self, points_in_camera: Points3, rows: Float64[np.ndarray, " n"]) -> Points3:
        """Points in the frames of the camera at their rows."""
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
    """How the hand moved during the photo; None where all rows are read at once."""
    if faults.readout_s == 0:
        return None
    hand = _rng(seed, session, photo_idx, 3).normal(0.0, 1.0, 6) * faults.readout_s
    turn_rad = np.radians(faults.hand_deg_s) * hand[:3]
    return Readout(rows, turn_rad, faults.hand_mm_s * hand[3:])


def exposure_of(
    faults: Faults, seed: int, session: Session, photo_idx: int
) -> Float64[np.ndarray, "3"]:
    """Factors of red, green and blue in one photo."""
    light, red, blue = _rng(seed, session, photo_idx, 4).normal(0.0, 1.0, 3)
    stops = 2.0 ** (faults.exposure_ev * light)
    return stops * np.array([1.0 + faults.tint * red, 1.0, 1.0 + faults.tint * blue])


def crept(limb: Limb, slid_mm: float, seed: int) -> Limb:
    """The limb of the same shape, its cloth slid down by up to `slid_mm`."""
    grid = limb.grid_mm.astype(float)
    favoured = np.random.default_rng((seed, 33)).uniform(0, 2 * np.pi)
    around = np.arctan2(grid[..., 1], grid[..., 0]) - favoured
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
