"""Movement: a limb or a board that moves between the photos.

In      a Movement, the number of photos, a seed, and the limb's middle.
Out     room_from_limb or room_from_board of every photo, or the shape of a limb that bends.
Limits  nothing moves during a photo.
"""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.synthetic.props.limb import Limb


class MovementKind(Enum):
    """What moves, and when."""

    STEP = "step"
    """The limb shifts once, before the second half of the photos."""
    DRIFT = "drift"
    """The limb shifts evenly from the first photo to the last."""
    SWAY = "sway"
    """The limb is at a random place between rest and the full shift in every photo."""
    BEND = "bend"
    """Not rigid: in the second half of the photos the upper half of the limb leans over."""
    PUSHED_BOARD = "pushed-board"
    """The limb stands still; the board was pushed before the second half of the photos."""


@dataclass(frozen=True, kw_only=True)
class Movement:
    """How far something moves; the direction follows from the capture's seed."""

    kind: MovementKind = MovementKind.STEP
    shift_mm: float = 8.0
    """Largest shift of the limb's middle, of the board, or of the top of a limb that bends."""
    turn_deg_per_mm: float = 0.1
    """Rotation per millimetre of shift, about an axis through the middle."""


def shares_of(movement: Movement, photos: int, seed: int) -> Float64[np.ndarray, " n"]:
    """Fraction of the movement that each photo shows, 0 to 1."""
    match movement.kind:
        case MovementKind.DRIFT:
            return np.linspace(0.0, 1.0, photos)
        case MovementKind.SWAY:
            return np.random.default_rng((seed, 12)).uniform(0.0, 1.0, photos)
        case MovementKind.STEP | MovementKind.BEND | MovementKind.PUSHED_BOARD:
            return (np.arange(photos) >= photos / 2).astype(float)


def motions(movement: Movement, photos: int, seed: int, middle: Vector3) -> tuple[Rigid, ...]:
    """room_from_limb (or room_from_board) of every photo: turned about `middle` and shifted."""
    rng = np.random.default_rng((seed, 11))
    azimuth = rng.uniform(0.0, 2 * np.pi)
    elevation = np.radians(rng.uniform(-20.0, 20.0))
    if movement.kind is MovementKind.PUSHED_BOARD:
        elevation = 0.0
    level = np.cos(elevation)
    shift = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    axis = rng.normal(size=3)
    if movement.kind is MovementKind.PUSHED_BOARD:
        axis = np.array([0.0, 0.0, 1.0])
    axis = axis / np.linalg.norm(axis)
    angle = np.radians(movement.turn_deg_per_mm * movement.shift_mm)
    found: list[Rigid] = []
    for share in shares_of(movement, photos, seed):
        turn = Rigid.from_rotation_vector(share * angle * axis, np.zeros(3))
        translation = middle + share * movement.shift_mm * shift - turn.apply(middle[None])[0]
        found.append(Rigid(turn.rotation, translation))
    return tuple(found)


def bent(limb: Limb, lean_mm: float, seed: int) -> Limb:
    """The limb with its upper half sheared over, so that its top moves by `lean_mm`."""
    azimuth = np.random.default_rng((seed, 11)).uniform(0.0, 2 * np.pi)
    aside = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    heights = limb.mesh.vertices_mm[:, 2]
    middle, top = 0.5 * (heights.min() + heights.max()), heights.max()
    share = np.clip((heights - middle) / (top - middle), 0.0, None)
    moved = limb.mesh.vertices_mm + (lean_mm * share**2)[:, None] * aside
    slope = 2 * lean_mm * share / (top - middle)
    # Normals of a shear x' = x + s z follow its inverse transpose.
    normals = limb.normals.copy()
    normals[:, 2] -= slope * (limb.normals @ aside)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(limb, mesh=replace(limb.mesh, vertices_mm=moved), normals=normals)
