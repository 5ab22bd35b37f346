"""Lighting: the room's lamp, the camera's flash, shine, and a shadow's edge.

Shares are those of a white page that faces the flash at its reference distance.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from limbgram.errors import OptionsError
from limbgram.geometry.arrays import Vector3
from limbgram.geometry.rigid import Rigid
from limbgram.photos.decoding import LINEAR_OF_SRGB
from limbgram.synthetic.rendering.shading import Light

LAMP_IN_WORLD = np.array([900.0, -700.0, 1900.0])
_FLASH_IN_CAMERA = np.array([0.0, -90.0, 0.0])
_STEP_ASIDE_MM = 25.0


class Shadow(Enum):
    """What stands before the lamp: a straight edge, so that half of the limb is dark."""

    NONE = "none"
    STANDING = "standing"
    """Something in the room: the edge lies at the same place in every photo."""
    MOVING = "moving"
    """Somebody who walks about: the edge lies elsewhere on the limb in every photo."""


@dataclass(frozen=True, kw_only=True)
class Lighting:
    """How much light comes from where."""

    ambient: float = 0.40
    lamp: float = 0.28
    flash: float = 0.42
    """The camera's own, 90 mm over the lens; its light falls with the square of the distance."""
    gloss: float = 1.0
    """Shine of the flash on the paint: 1 is fabric paint, 12 wet paint that burns out."""
    polish: float = 24.0
    """Exponent of the shine: the larger, the smaller the highlight."""
    shadow: Shadow = Shadow.NONE

    def __post_init__(self) -> None:
        if min(self.ambient, self.lamp, self.flash, self.gloss) < 0 or self.polish < 1:
            raise OptionsError("This light cannot be made: shares are 0 or more, polish 1 or more.")


def shadow_edge(lighting: Lighting, middle_in_world: Vector3, seed: int, photo_idx: int) -> Vector3:
    """Normal, towards the dark, of the plane through the lamp that parts light from shadow.

    The edge passes the limb's middle; if it moves, up to 25 mm beside it. Zero for no shadow.
    """
    if lighting.shadow is Shadow.NONE:
        return np.zeros(3)
    rng = np.random.default_rng((seed, 11))
    ray = middle_in_world - LAMP_IN_WORLD
    across = np.cross(ray, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    lean = np.radians(rng.uniform(-20, 20))
    aside_mm = 0.0
    if lighting.shadow is Shadow.MOVING:
        rng = np.random.default_rng((seed, 12, photo_idx))
        lean += np.radians(rng.uniform(-20, 20))
        aside_mm = rng.uniform(-_STEP_ASIDE_MM, _STEP_ASIDE_MM)
    upward = np.array([0.0, 0.0, 1.0]) * np.cos(lean) + across * np.sin(lean)
    normal = np.cross(ray + aside_mm * across, upward)
    return normal / np.linalg.norm(normal)


def light_of(
    lighting: Lighting, camera_from_world: Rigid, flash_mm: float, edge_in_world: Vector3
) -> Light:
    """The light as a camera sees it; a white page that faces the flash at `flash_mm` has 0.8."""
    return Light(
        up=camera_from_world.rotation[:, 2].copy(),
        lamp=camera_from_world.apply(LAMP_IN_WORLD),
        flash=_FLASH_IN_CAMERA,
        edge=camera_from_world.rotation @ edge_in_world,
        ambient=float(lighting.ambient),
        lamp_strength=float(lighting.lamp),
        flash_strength=float(lighting.flash),
        flash_mm=float(flash_mm),
        gloss=float(lighting.gloss),
        polish=float(lighting.polish),
        linear=LINEAR_OF_SRGB,
    )
