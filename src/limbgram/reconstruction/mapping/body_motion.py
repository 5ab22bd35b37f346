"""Body motion: which photos a body's points connect, and a body's motion by photo."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from scipy.sparse import csr_array

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.topology import components
from limbgram.findings import Finding
from limbgram.reconstruction.mapping.scene import Movement, Scene

_FEWEST_POINTS = 15
_FEWEST_SHARED = 8
"""Points that two photos must share to be connected, and that a photo must share with two others:
one that shares points with single photos only slips along them. Of 12 photos one with 7 seemed to
move by 1.4 % of the distance, and did not; those that kept still have 11 and more."""
MOTION_SIZE = 6
"""Parameters of a rigid motion: rotation, and shift."""


def connected_photos(scene: Scene) -> tuple[int, ...]:
    """The largest set of photos that shared points connect, each with enough of them."""
    seen = scene.observations
    count = np.bincount(seen.photo_idx, minlength=len(scene.names))
    sees = csr_array(
        (np.ones(len(seen.photo_idx), np.int32), (seen.photo_idx, seen.point_idx)),
        shape=(len(scene.names), len(scene.points_in_world)),
    )
    shared = (sees @ sees.T).toarray()
    enough = (count >= _FEWEST_POINTS) & (points_in_three_photos(scene) >= _FEWEST_SHARED)
    graph = (shared >= _FEWEST_SHARED) & enough[:, None] & enough[None]
    label = components(np.argwhere(graph), len(graph))
    sizes = np.bincount(label[enough], minlength=1) if enough.any() else np.zeros(1)
    return tuple(np.flatnonzero(enough & (label == int(sizes.argmax()))).tolist())


def points_in_three_photos(scene: Scene) -> Int64[np.ndarray, " n"]:
    """By photo, the number of its points that three photos or more show."""
    seen = scene.observations
    shown = np.bincount(seen.point_idx, minlength=len(scene.points_in_world))
    tied = seen.photo_idx[shown[seen.point_idx] > 2]
    return np.bincount(tied, minlength=len(scene.names)).astype(np.int64)


@dataclass(frozen=True, kw_only=True)
class BodyMotion:
    """A Movement with the rigid motion of each photo."""

    movement: Movement
    middle: Vector3
    """Centre of the first body, in its scene's world; rotations are about it."""
    motions: Float64[np.ndarray, "n 6"]
    """Rotation (axis times angle, rad) and shift of the second body from its place in the photos
    that the Movement refers to; zero if unknown. World frame and unit of the first."""

    @classmethod
    def unknown(cls, photos: int, reason: Finding | None, chance: float = 1.0) -> "BodyMotion":
        """A motion of which nothing is known."""
        unknown = Movement.unknown(photos, reason, chance)
        return cls(movement=unknown, middle=np.zeros(3), motions=np.zeros((photos, MOTION_SIZE)))

    def in_photo(self, photo: int) -> Rigid:
        """The motion of the second body in one photo, as a transformation of the world."""
        turn = Rigid.from_rotation_vector(self.motions[photo, :3], np.zeros(3))
        shift = self.middle + self.motions[photo, 3:] - turn.apply(self.middle[None])[0]
        return Rigid(turn.rotation, shift)
