"""Body: an aligned limb with its landmarks by name and its anatomical directions, for trims.

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
from limbgram.core.geometry.frames import plane_basis
from limbgram.core.mesh.mesh import Mesh, lengths, unit
from limbgram.core.mesh.sections import Z_AXIS, centroid_mm, cut
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.anatomy.directions import LEAST_MM, LEAST_SINE
from limbgram.workbench.anatomy.names import landmark_named
from limbgram.workbench.edits.regions import position_mm
from limbgram.workbench.limb import AlignedLimb, Limb

Axes = Literal["limb", "foot"]
_FAR_MM = 3000.0
_NUDGE_MM = 0.001
"""A ray through a vertex may slip between the faces round it by rounding; rays this far beside it
do not."""
_PLANE_ROUNDS = 3
"""How often the plane is fitted again to the lowest places of the foot."""
_HEEL_SHARE, _BALL_SHARE = 0.3, 0.2
"""Shares of the length from heel to ball: the foot can touch the ground up to this far in front of
the heel, and this far before and behind the metatarsal heads."""
_STANDS_ON = ("heel", "first metatarsal head", "fifth metatarsal head")


@dataclass(frozen=True)
class Body:
    """A limb in its own frame."""

    limb: AlignedLimb

    @classmethod
    def of(cls, limb: Limb) -> "Body":
        """The body of an aligned limb.

        Raises:
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
        """Outward normal of the nearest face."""
        face = tree_on(self.mesh).closest(place_mm[None]).faces[0]
        return unit(self.mesh.face_normals()[face][None])[0]

    def lateral(self) -> Vector3:
        """The lateral direction.

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
        lacks = tuple(name for name in names if landmark_named(name, self.limb.landmarks) is None)
        if lacks:
            raise EditError("anatomy.missing", names=lacks, wanted_for=wanted_for)

    def require_sides(self, names: Iterable[str]) -> None:
        """Refuse pairs of landmarks that lie the wrong way round: confused, or the other limb.

        Raises:
            EditError: names both.
        """
        known = {name: self.place_mm(name) for name in names}
        for outer, inner in _lateral_and_medial(known):
            out = np.array([1.0, 0, 0]) if outer.startswith("right ") else self.lateral()
            if (known[outer] - known[inner]) @ out <= 0:
                raise EditError("device.wrong_side", outer=outer, inner=inner)

    def directions(self, axes: Axes) -> Float64[np.ndarray, "3 3"]:
        """Rows: to the right, forwards and up."""
        return np.eye(3) if axes == "limb" else self._standing_plane.directions

    def sole_height_mm(self) -> float:
        """Height of the plane that the foot stands on, along the foot's upward direction."""
        return self._standing_plane.height_mm

    @cached_property
    def _standing_plane(self) -> "_StandingPlane":
        """The plane that the foot stands on; kept, because each point of a foot's trim needs it."""
        heel, first, fifth, toe = (self.place_mm(name) for name in (*_STANDS_ON, "second toe"))
        three = np.stack([heel, first, fifth])
        _require_plane(three, toe)
        stand = _plane_through(three, heel, toe)
        for _ in range(_PLANE_ROUNDS):
            stand = _plane_under_foot(self.mesh, stand, three, toe)
        return stand

    def section_centre_mm(self, height_mm: float, at: str | None = None) -> Vector3:
        """Centroid of the largest section at a height; open sections are closed straight.

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
    def _ray_scene(self) -> Any:
        """The mesh as a scene for ray casting; embreex has no types."""
        scene = EmbreeScene()
        TriangleMesh(scene, self.mesh.vertices_mm[self.mesh.faces].astype(np.float32))
        return scene

    def first_hit_mm(self, through_mm: Vector3, seen_along: Vector3) -> Vector3 | None:
        """The first point of the surface on a line through a place, looking from far away.

        None where the line misses the surface, or passes through an opening and hits it from
        inside.
        """
        met = self._first_hit_exactly(through_mm, seen_along)
        if met is not None:
            return met
        nudges = _NUDGE_MM * plane_basis(seen_along)
        for aside in (*nudges, *-nudges):
            met = self._first_hit_exactly(through_mm + aside, seen_along)
            if met is not None:
                return met - aside
        return None

    def _first_hit_exactly(self, through_mm: Vector3, seen_along: Vector3) -> Vector3 | None:
        """The first point of the surface on exactly this line, hit from outside."""
        face = self._first_face_hit(through_mm, seen_along)
        if face < 0:
            return None
        a, b, c = self.mesh.vertices_mm[self.mesh.faces[face]]
        normal = np.cross(b - a, c - a)
        steep = float(normal @ seen_along)
        if steep >= 0:
            return None
        return through_mm + seen_along * float(normal @ (a - through_mm)) / steep

    def miss_distance_mm(self, through_mm: Vector3, seen_along: Vector3) -> float:
        """Distance at which a line through a place misses the limb; 0 where it hits it."""
        if self._first_face_hit(through_mm, seen_along) >= 0:
            return 0.0
        away = self.mesh.vertices_mm - through_mm
        return float(lengths(away - np.outer(away @ seen_along, seen_along)).min())

    def _first_face_hit(self, through_mm: Vector3, seen_along: Vector3) -> int:
        start = through_mm - _FAR_MM * seen_along
        met = self._ray_scene.run(
            start[None].astype(np.float32), np.ascontiguousarray(seen_along[None], np.float32)
        )
        return int(np.asarray(met)[0])


_OPPOSITE = {"lateral ": "medial ", "right ": "left ", "fifth meta": "first meta"}


def _lateral_and_medial(names: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Pairs among the names: lateral and medial, right and left, fifth and first metatarsal."""
    known = set(names)
    for name in sorted(known):
        for outer, inner in _OPPOSITE.items():
            other = inner + name.removeprefix(outer)
            if name.startswith(outer) and other in known:
                yield name, other


@dataclass(frozen=True)
class _StandingPlane:
    """The plane that a foot stands on."""

    directions: Float64[np.ndarray, "3 3"]
    height_mm: float


def _require_plane(three: Float64[np.ndarray, "3 3"], toe: Vector3) -> None:
    """Refuse landmarks that span no plane, or no direction in it.

    Raises:
        EditError: heel and metatarsal heads lie on one line, or the toe over the heel.
    """
    sides, ahead = three[1:] - three[0], toe - three[0]
    up = np.cross(*sides)
    if not np.linalg.norm(up) > LEAST_SINE * lengths(sides).prod():
        raise EditError("anatomy.on_line", name="plantar", names=_STANDS_ON)
    up = unit(up[None])[0]
    if np.linalg.norm(ahead - (ahead @ up) * up) < LEAST_MM:
        raise EditError("anatomy.on_point", name="foot", names=(_STANDS_ON[0], "second toe"))


def _plane_through(
    three: Float64[np.ndarray, "3 3"], heel: Vector3, toe: Vector3
) -> _StandingPlane:
    up = np.cross(three[1] - three[0], three[2] - three[0])
    up = unit((up * np.copysign(1.0, up[2]))[None])[0]
    ahead = unit(((toe - heel) - ((toe - heel) @ up) * up)[None])[0]
    return _StandingPlane(np.stack([np.cross(ahead, up), ahead, up]), float((three @ up).mean()))


def _plane_under_foot(
    mesh: Mesh, stand: _StandingPlane, marks: Float64[np.ndarray, "3 3"], toe: Vector3
) -> _StandingPlane:
    """The plane through the lowest places near the heel and both metatarsal heads."""
    right, ahead, up = stand.directions
    heel, balls = marks[0], marks[1:] - marks[0]
    along, across = (mesh.vertices_mm - heel) @ ahead, (mesh.vertices_mm - heel) @ right
    length, middle = float((balls @ ahead).mean()), float((balls @ right).mean())
    fifth_is = np.sign((balls[1] - balls[0]) @ right)
    forefoot = np.abs(along / length - 1) < _BALL_SHARE
    near = (
        along < _HEEL_SHARE * length,
        forefoot & ((across - middle) * fifth_is < 0),
        forefoot & ((across - middle) * fifth_is >= 0),
    )
    heights = mesh.vertices_mm @ up
    lowest = [
        mesh.vertices_mm[np.flatnonzero(part)[heights[part].argmin()]] if part.any() else mark
        for part, mark in zip(near, marks, strict=True)
    ]
    return _plane_through(np.stack(lowest), heel, toe)
