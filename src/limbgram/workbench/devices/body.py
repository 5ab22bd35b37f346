"""Body: an aligned limb as trims and fittings see it: places by name, directions of anatomy.

All is in the limb frame. "Out" is away from the body's middle: lateral. The foot's directions lie
in the plane that it stands on, under the heel and both metatarsal heads, forwards from the heel to
the second toe.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Float64

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import square_to
from limbgram.core.mesh.mesh import Mesh, lengths, unit
from limbgram.core.mesh.sections import Z_AXIS, centroid_mm, cut
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.anatomy.names import named
from limbgram.workbench.edits.regions import position_mm
from limbgram.workbench.limb import AlignedLimb, Limb

Axes = Literal["limb", "foot"]
_FAR_MM = 3000.0
_HAIR_MM = 0.001
"""A line through a vertex may slip between its faces by rounding: those beside it do not."""
_ROUNDS = 3
"""Times that the plane is laid anew under the places that are lowest over it."""
_BEHIND, _BALL = 0.3, 0.2
"""Shares of the way from heel to ball: so far in front of the heel, and so far before and behind
the metatarsal heads, the foot is looked at for where it stands."""


@dataclass(frozen=True)
class Body:
    """A limb in its own frame."""

    limb: AlignedLimb

    @classmethod
    def of(cls, limb: Limb) -> "Body":
        """Raises:
        EditError: the limb is not aligned.
        """
        return cls(limb.aligned(EditError("edit.not_aligned")).in_limb_frame())

    @property
    def mesh(self) -> Mesh:
        return self.limb.mesh

    @property
    def right(self) -> bool:
        return self.limb.side == "right"

    def place_mm(self, name: str) -> Vector3:
        """Where a landmark lies.

        Raises:
            EditError: the limb has none of that name.
        """
        return position_mm(self.limb, name, "limb")

    def normal_at(self, place_mm: Vector3) -> Vector3:
        """Outward, of the face that lies nearest."""
        face = tree_on(self.mesh).closest(place_mm[None]).faces[0]
        return unit(self.mesh.face_normals()[face][None])[0]

    def outward(self) -> Vector3:
        """Lateral.

        Raises:
            EditError: nobody said which side the limb is of.
        """
        if self.limb.side == "none":
            raise EditError("device.no_side")
        return np.array([1.0 if self.right else -1.0, 0.0, 0.0])

    def require_marked(self, names: Iterable[str], wanted_for: str) -> None:
        """Refuse a limb that lacks landmarks.

        Raises:
            EditError: names all that it lacks.
        """
        lacks = tuple(name for name in names if named(name, self.limb.landmarks) is None)
        if lacks:
            raise EditError("anatomy.missing", names=lacks, wanted_for=wanted_for)

    def require_sides(self, names: Iterable[str]) -> None:
        """Refuse pairs of landmarks that lie the wrong way round: confused, or the other limb.

        Raises:
            EditError: names both.
        """
        known = {name: self.place_mm(name) for name in names}
        for outer, inner in _pairs(known):
            out = np.array([1.0, 0, 0]) if outer.startswith("right ") else self.outward()
            if (known[outer] - known[inner]) @ out <= 0:
                raise EditError("device.wrong_side", outer=outer, inner=inner)

    def directions(self, axes: Axes) -> Float64[np.ndarray, "3 3"]:
        """Rows: to the right, forwards and up."""
        return np.eye(3) if axes == "limb" else self._stand.directions

    def sole_mm(self) -> float:
        """How high the plane that the foot stands on lies along its own upward direction."""
        return self._stand.height_mm

    @cached_property
    def _stand(self) -> "_Stand":
        """Each point of a foot's trim asks for it."""
        heel, first, fifth, toe = (
            self.place_mm(name)
            for name in ("heel", "first metatarsal head", "fifth metatarsal head", "second toe")
        )
        stand = _plane(np.stack([heel, first, fifth]), heel, toe)
        for _ in range(_ROUNDS):
            stand = _lowered(self.mesh, stand, np.stack([heel, first, fifth]), toe)
        return stand

    def middle_mm(self, height_mm: float, at: str | None = None) -> Vector3:
        """Middle of the largest section at a height; one that is open is closed straight.

        at: landmark that told the height, for the refusal.

        Raises:
            EditError: there is no section at that height.
        """
        found = cut(self.mesh, [height_mm])
        if not found:
            heights = self.mesh.vertices_mm[:, 2]
            raise EditError(
                "device.trim.off_limb",
                at=at,
                point_mm=(0.0, 0.0, height_mm),
                lowest_mm=float(heights.min()),
                highest_mm=float(heights.max()),
            )
        return centroid_mm(max(found, key=lambda one: one.area_mm2(Z_AXIS)).points_mm)

    @cached_property
    def _scene(self) -> Any:
        """For rays; embreex has no types."""
        scene = EmbreeScene()
        TriangleMesh(scene, self.mesh.vertices_mm[self.mesh.faces].astype(np.float32))
        return scene

    def met_mm(self, through_mm: Vector3, seen_along: Vector3) -> Vector3 | None:
        """What is seen first along a line through a place, by who looks from far away.

        None where the line misses the surface, or slips through an opening and meets it from
        within.
        """
        met = self._met_by(through_mm, seen_along)
        if met is not None:
            return met
        hairs = _HAIR_MM * square_to(seen_along)
        for aside in (*hairs, *-hairs):
            met = self._met_by(through_mm + aside, seen_along)
            if met is not None:
                return met - aside
        return None

    def _met_by(self, through_mm: Vector3, seen_along: Vector3) -> Vector3 | None:
        """What this very line meets first, from outside."""
        face = self._first_face(through_mm, seen_along)
        if face < 0:
            return None
        a, b, c = self.mesh.vertices_mm[self.mesh.faces[face]]
        normal = np.cross(b - a, c - a)
        steep = float(normal @ seen_along)
        if steep >= 0:
            return None
        return through_mm + seen_along * float(normal @ (a - through_mm)) / steep

    def beside_mm(self, through_mm: Vector3, seen_along: Vector3) -> float:
        """How far a line through a place passes beside the limb; 0 where it meets it."""
        if self._first_face(through_mm, seen_along) >= 0:
            return 0.0
        away = self.mesh.vertices_mm - through_mm
        return float(lengths(away - np.outer(away @ seen_along, seen_along)).min())

    def _first_face(self, through_mm: Vector3, seen_along: Vector3) -> int:
        start = through_mm - _FAR_MM * seen_along
        met = self._scene.run(
            start[None].astype(np.float32), np.ascontiguousarray(seen_along[None], np.float32)
        )
        return int(np.asarray(met)[0])


_OPPOSITE = {"lateral ": "medial ", "right ": "left ", "fifth meta": "first meta"}


def _pairs(names: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Of a lateral and a medial place, or a right and a left one."""
    known = set(names)
    for name in sorted(known):
        for outer, inner in _OPPOSITE.items():
            other = inner + name.removeprefix(outer)
            if name.startswith(outer) and other in known:
                yield name, other


@dataclass(frozen=True)
class _Stand:
    """The plane that a foot stands on."""

    directions: Float64[np.ndarray, "3 3"]
    height_mm: float


def _plane(three: Float64[np.ndarray, "3 3"], heel: Vector3, toe: Vector3) -> _Stand:
    up = np.cross(three[1] - three[0], three[2] - three[0])
    up = unit((up * np.sign(up[2]))[None])[0]
    ahead = unit(((toe - heel) - ((toe - heel) @ up) * up)[None])[0]
    return _Stand(np.stack([np.cross(ahead, up), ahead, up]), float((three @ up).mean()))


def _lowered(mesh: Mesh, stand: _Stand, marks: Float64[np.ndarray, "3 3"], toe: Vector3) -> _Stand:
    """The plane through the lowest places near heel and both metatarsal heads, as it stands."""
    right, ahead, up = stand.directions
    heel, balls = marks[0], marks[1:] - marks[0]
    along, across = (mesh.vertices_mm - heel) @ ahead, (mesh.vertices_mm - heel) @ right
    length, middle = float((balls @ ahead).mean()), float((balls @ right).mean())
    fifth_is = np.sign((balls[1] - balls[0]) @ right)
    forefoot = np.abs(along / length - 1) < _BALL
    near = (
        along < _BEHIND * length,
        forefoot & ((across - middle) * fifth_is < 0),
        forefoot & ((across - middle) * fifth_is >= 0),
    )
    heights = mesh.vertices_mm @ up
    lowest = [
        mesh.vertices_mm[np.flatnonzero(part)[heights[part].argmin()]] if part.any() else mark
        for part, mark in zip(near, marks, strict=True)
    ]
    return _plane(np.stack(lowest), heel, toe)
