"""The photographer: a camera, and hand-held poses round the limb and over a board.

In      a Lens, the picture's size, the target, and a seed.
Out     a Camera, and camera_from_world poses on irregular rings or over a tilted board.
"""

from dataclasses import dataclass

import numpy as np

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid, towards
from limbgram.core.geometry.lens import Camera

_UP = np.array([0.0, 0.0, 1.0])
_ELEVATIONS_DEG = (28.0, 50.0, 40.0)
_TRIES = 400


@dataclass(frozen=True, kw_only=True)
class Lens:
    """Camera body and lens as in EXIF, with the distortion, which EXIF lacks."""

    make: str = "Canon"
    model: str = "Canon EOS 500D"
    name: str = "EF50mm f/1.8 II"
    focal_mm: float = 50.0
    """Nominal focal length; the principal distance is longer when focused near."""
    sensor_width_mm: float = 22.3
    aperture: float = 6.3
    k1: float = -0.085
    k2: float = 0.06
    p1: float = 0.0004
    p2: float = -0.0003
    principal_x: float = 0.004
    """Principal point right of the middle of the picture, as a fraction of its width."""
    principal_y: float = -0.005
    """Principal point below the middle of the picture, as a fraction of its width."""


def camera_of(lens: Lens, width_px: int, height_px: int, focus_mm: float) -> Camera:
    """The camera focused at `focus_mm` (thin lens: principal distance f D / (D - f))."""
    if focus_mm <= 2 * lens.focal_mm:
        raise OptionsError("made.too_near", focal_mm=lens.focal_mm, focus_mm=focus_mm)
    distance_mm = lens.focal_mm * focus_mm / (focus_mm - lens.focal_mm)
    focal_px = distance_mm * width_px / lens.sensor_width_mm
    return Camera(
        width_px=width_px,
        height_px=height_px,
        fx=focal_px,
        fy=focal_px,
        cx=(width_px - 1) / 2 + lens.principal_x * width_px,
        cy=(height_px - 1) / 2 + lens.principal_y * width_px,
        k1=lens.k1,
        k2=lens.k2,
        p1=lens.p1,
        p2=lens.p2,
    )


def walk_round(
    target: Vector3,
    distance_mm: float,
    photos: int,
    rings: int,
    seed: int,
    elevations_deg: tuple[float, ...] = (),
) -> tuple[Rigid, ...]:
    """Poses on `rings` irregular rings at different heights, the first ring the fullest."""
    rng = np.random.default_rng((seed, 4))
    shares = np.array([1.0, 0.6, 0.6])[:rings]
    counts = np.rint(shares / shares.sum() * photos).astype(int)
    counts[0] += photos - counts.sum()
    poses: list[Rigid] = []
    for count, elevation_deg in zip(counts, elevations_deg or _ELEVATIONS_DEG, strict=False):
        start = rng.uniform(0, 360)
        for k in range(count):
            azimuth = np.radians(start + (k + rng.uniform(-0.16, 0.16)) * 360 / count)
            elevation = np.radians(elevation_deg + rng.uniform(-6, 6))
            away = towards(azimuth, elevation)
            centre = target + away * distance_mm * rng.uniform(0.94, 1.06)
            poses.append(_aimed(centre, target + rng.uniform(-14, 14, 3), rng.normal(0, 2.5)))
    return tuple(poses)


def on_tripod(
    target: Vector3, distance_mm: float, photos: int, rings: int, seed: int
) -> tuple[Rigid, ...]:
    """Poses of a camera that stands still, once for each ring, while the limb turns."""
    rng = np.random.default_rng((seed, 14))
    per_ring = -(-photos // rings)
    azimuth = rng.uniform(0, 2 * np.pi)
    poses: list[Rigid] = []
    for elevation_deg in _ELEVATIONS_DEG[:rings]:
        elevation = np.radians(elevation_deg + rng.uniform(-6, 6))
        away = towards(azimuth, elevation)
        aim = target + rng.uniform(-14, 14, 3)
        poses += [_aimed(target + away * distance_mm, aim, rng.normal(0, 1.0))] * per_ring
    return tuple(poses[:photos])


def film_round(target: Vector3, distance_mm: float, frames: int, seed: int) -> tuple[Rigid, ...]:
    """Poses of a film: a little more than once round, at varying height and speed."""
    rng = np.random.default_rng((seed, 6))
    time = np.arange(frames) / frames

    def swaying(amplitude: float, waves: int = 3) -> np.ndarray:
        phases, sizes = rng.uniform(0, 2 * np.pi, waves), rng.uniform(0.3, 1.0, waves)
        turns = 2 * np.pi * np.arange(1, waves + 1)[:, None] * time
        sway = (sizes[:, None] * np.sin(turns + phases[:, None])).sum(0)
        return amplitude * sway / np.abs(sway).max()

    azimuth = np.radians(rng.uniform(0, 360) + 372.0 * time + swaying(14.0))
    elevation = np.radians(_ELEVATIONS_DEG[0] + 6.0 + swaying(12.0))
    distance = distance_mm * (1.0 + swaying(0.05))
    aims = target + np.column_stack([swaying(12.0), swaying(12.0), swaying(12.0)])
    rolls_deg = swaying(4.0)
    centres = target + towards(azimuth, elevation) * distance[:, None]
    return tuple(_aimed(*at) for at in zip(centres, aims, rolls_deg, strict=True))


def over_board(outline: Points3, camera: Camera, photos: int, seed: int) -> tuple[Rigid, ...]:
    """Poses that see the whole outline of a flat board, tilted by up to 40 degrees.

    The board's place in the picture varies, so that the corners are covered, and the camera is
    turned by a further 90 degrees from photo to photo.
    """
    rng = np.random.default_rng((seed, 5))
    middle = outline.mean(0)
    span = float(np.linalg.norm(outline.max(0) - outline.min(0)))
    near = camera.fx * span / min(camera.width_px, camera.height_px)
    poses: list[Rigid] = []
    for k in range(photos):
        corner = np.array([(-1, -1), (1, 1), (1, -1), (-1, 1), (0, 0)][k % 5], float)
        for attempt in range(_TRIES):
            tilt = np.radians(rng.uniform(2, 40) if k % 5 == 4 else rng.uniform(12, 40))
            azimuth = rng.uniform(0, 2 * np.pi)
            away = np.array(
                [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]
            )
            centre = middle + away * near * rng.uniform(0.62, 1.0)
            pose = _aimed(centre, middle, rng.uniform(-12, 12) + 90.0 * (k % 4))
            shift = corner * (1 - attempt / _TRIES) * np.array([0.3, 0.25])
            pose = _aimed_beside(pose, shift * camera.width_px / camera.fx)
            if camera.contains(camera.project(pose.apply(outline)), 0.012 * camera.width_px).all():
                poses.append(pose)
                break
        else:
            raise OptionsError("made.narrow_picture")
    return tuple(poses)


def _aimed(centre: Vector3, target: Vector3, roll_deg: float) -> Rigid:
    """A camera at `centre` that looks at `target`, turned about its axis by `roll_deg`."""
    level = Rigid.looking_at(centre, target, _UP)
    return Rigid.from_rotation_vector(np.array([0, 0, np.radians(roll_deg)]), np.zeros(3)) @ level


def _aimed_beside(pose: Rigid, shift: np.ndarray) -> Rigid:
    """The camera turned so that what was in the middle appears at `shift` (radians)."""
    turn = Rigid.from_rotation_vector(np.array([-shift[1], shift[0], 0.0]), np.zeros(3))
    return turn @ pose
