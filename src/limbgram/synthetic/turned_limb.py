"""Turned limb: captures in which the limb is turned, and not only the camera carried round it.

In      a Turning or TurnedOver, how many photos there are, the limb's vertices.
Out     room_from_limb of every photo.
Method  `Turning` is a turntable or a stool under a still camera: each photo shows the limb further
        round. `TurnedOver` is a cast that stands for the first half of the photos and lies on its
        side, its cut open to view, for the others.
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
    """How far a patient on a stool leans to and fro besides, one standard deviation."""
    board_turns: bool = True
    """Whether the board turns with the limb, or lies still in the room."""
    behind: bool = True
    """Whether a patterned screen stands still behind the limb."""
    before: bool = False
    """Whether patterned strips stand still nearer to the camera than the limb."""


@dataclass(frozen=True, kw_only=True)
class TurnedOver:
    """A cast that stands for the first half of the photos and lies for the others."""


def room_from_limb(
    turning: Turning | TurnedOver, photos: int, rings: int, skin: Points3, seed: int
) -> tuple[Rigid, ...]:
    """Where the limb is in the room, photo by photo."""
    match turning:
        case Turning():
            return _turning(turning, photos, rings, seed)
        case TurnedOver():
            lying = _lying(skin, seed)
            standing = standing_photos(photos)
            return (Rigid.identity(),) * standing + (lying,) * (photos - standing)


def standing_photos(photos: int) -> int:
    """How many photos show a cast that is turned over standing."""
    return photos - photos // 2


def _turning(turning: Turning, photos: int, rings: int, seed: int) -> tuple[Rigid, ...]:
    """Once round for every ring, in steps that a hand would make."""
    rng = np.random.default_rng((seed, 12))
    a_ring = -(-photos // rings)
    poses: list[Rigid] = []
    for k in range(photos):
        angle = np.radians((k % a_ring + rng.uniform(-0.16, 0.16)) * 360.0 / a_ring)
        turn = Rigid.from_rotation_vector(np.array([0.0, 0.0, angle]), np.zeros(3))
        leant = rng.normal(0.0, 1.0, 5) * turning.sway_mm
        # a patient of a metre and a half leans by as much at the limb as he shifts
        lean = np.array([leant[0] / 500.0, leant[1] / 500.0, leant[2] / 200.0])
        sway = Rigid.from_rotation_vector(lean, np.array([leant[3], leant[4], 0.0]))
        poses.append(sway @ turn)
    return tuple(poses)


def _lying(skin: Points3, seed: int) -> Rigid:
    """On its side on the table, its middle where the stand was, turned anyhow."""
    rng = np.random.default_rng((seed, 13))
    side = rng.uniform(0.0, 2.0 * np.pi)
    axis = np.array([np.cos(side), np.sin(side), 0.0]) * np.radians(_LYING_DEG)
    tipped = Rigid.from_rotation_vector(axis, np.zeros(3))
    turn = np.array([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
    laid = Rigid.from_rotation_vector(turn, np.zeros(3)) @ tipped
    places = laid.apply(skin)
    low, high = places.min(0), places.max(0)
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return Rigid(laid.rotation, laid.translation - middle)
