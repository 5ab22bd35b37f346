"""Turned limb: captures in which the limb is turned between the photos.

In      a Turning or TurnedOver, the number of photos, the limb's vertices.
Out     room_from_limb of every photo.
Method  `Turning` is a turntable or a stool before a fixed camera. `TurnedOver` is a cast that
        stands in the first half of the photos and lies on its side, its cut visible, in the
        others.
"""

from dataclasses import dataclass

import numpy as np

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid

_LYING_DEG = 90.0


@dataclass(frozen=True, kw_only=True)
class Turning:
    """The camera stands still, once for each ring, and the limb turns before it."""

    sway_mm: float = 0.0
    """Standard deviation by which a patient on a stool sways from photo to photo."""
    board_turns: bool = True
    """Whether the board turns with the limb, or lies still in the room."""
    behind: bool = True
    """Whether a patterned screen stands still behind the limb."""
    before: bool = False
    """Whether patterned strips stand still nearer to the camera than the limb."""


@dataclass(frozen=True, kw_only=True)
class TurnedOver:
    """A cast that stands for the first half of the photos and lies for the others."""


def turned_limb_poses(
    turning: Turning | TurnedOver, photos: int, rings: int, skin: Points3, seed: int
) -> tuple[Rigid, ...]:
    """room_from_limb of every photo."""
    match turning:
        case Turning():
            return _turning(turning, photos, rings, seed)
        case TurnedOver():
            lying = _lying(skin, seed)
            standing = standing_photos(photos)
            return (Rigid.identity(),) * standing + (lying,) * (photos - standing)


def standing_photos(photos: int) -> int:
    """Number of photos that show a cast that is turned over while it stands."""
    return photos - photos // 2


def _turning(turning: Turning, photos: int, rings: int, seed: int) -> tuple[Rigid, ...]:
    """One revolution for every ring, in uneven steps, as by hand."""
    rng = np.random.default_rng((seed, 12))
    per_ring = -(-photos // rings)
    poses: list[Rigid] = []
    for k in range(photos):
        angle = np.radians((k % per_ring + rng.uniform(-0.16, 0.16)) * 360.0 / per_ring)
        turn = Rigid.from_rotation_vector(np.array([0.0, 0.0, angle]), np.zeros(3))
        swayed_mm = rng.normal(0.0, 1.0, 5) * turning.sway_mm
        # Rotations by these arms, mm, move the limb about as far as the shift does.
        lean_rad = swayed_mm[:3] / np.array([500.0, 500.0, 200.0])
        sway = Rigid.from_rotation_vector(lean_rad, np.array([swayed_mm[3], swayed_mm[4], 0.0]))
        poses.append(sway @ turn)
    return tuple(poses)


def _lying(skin: Points3, seed: int) -> Rigid:
    """room_from_limb on its side on the table, at a random azimuth, its middle at the origin."""
    rng = np.random.default_rng((seed, 13))
    side = rng.uniform(0.0, 2.0 * np.pi)
    axis = np.array([np.cos(side), np.sin(side), 0.0]) * np.radians(_LYING_DEG)
    tipped = Rigid.from_rotation_vector(axis, np.zeros(3))
    turn = np.array([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
    laid = Rigid.from_rotation_vector(turn, np.zeros(3)) @ tipped
    lying = laid.apply(skin)
    low, high = lying.min(0), lying.max(0)
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return Rigid(laid.rotation, laid.translation - middle)
