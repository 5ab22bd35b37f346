"""The limb: a surface with what a clinician knows of it.

A surface whose capture was judged red goes on saying so: by its name, which travels with every
copy, and from there by the limb file of whatever is made from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, Self, TypeVar

import numpy as np

from limbgram.core.errors import LimbgramError, MeasureError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.known_words import require_known_words
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import AnswersByMesh
from limbgram.core.notebook import brief
from limbgram.findings import Finding, doubt
from limbgram.workbench.anatomy.centreline import Centreline, straight_centreline
from limbgram.workbench.anatomy.directions import AnatomicalAxis, Anatomy
from limbgram.workbench.anatomy.kind import Kind
from limbgram.workbench.anatomy.known_kinds import KIND_NAMED, KINDS, KindName
from limbgram.workbench.anatomy.landmark import Landmark, Placed
from limbgram.workbench.anatomy.names import landmark_named, landmarks_by_identity
from limbgram.workbench.anatomy.surface_lines import LineSurface

__all__ = [
    "KINDS",
    "KIND_NAMED",
    "AlignedLimb",
    "AnyLimb",
    "Kind",
    "KindName",
    "Landmark",
    "Limb",
    "LimbFrame",
    "Origin",
    "Placed",
    "Side",
    "file_name_doubt",
    "marked_red",
    "names_apart",
]

Side = Literal["left", "right", "none"]
_MARK = "-RED"


@dataclass(frozen=True, kw_only=True)
class LimbFrame:
    """Where the limb's axes lie: origin on the long axis at the distal end,

    +Z proximal, +Y anterior, +X the patient's right.
    """

    limb_from_mesh: Rigid
    side: Side
    """As the clinician confirmed it; geometry is never flipped by it."""
    front_told: bool = True
    """False only of what a file declares that leaves the front open, as an AOP of ampscan does: it
    is no limb's frame until somebody says where the front lies."""

    def __post_init__(self) -> None:
        require_known_words(self)


@dataclass(frozen=True, kw_only=True)
class Origin:
    """A file that a shape was read of, or made from."""

    sha256: str
    mm_per_unit: float
    """As it was read."""
    mesh_from_origin: Rigid
    """From that file's axes to those of the shape's mesh, in millimetres."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """A limb: what every step of the workbench takes and gives; `AlignedLimb` where it has axes."""

    mesh: Mesh
    landmarks: tuple[Landmark, ...] = ()
    kind: KindName | None = None
    """None until somebody said it; it tells what the names of landmarks mean."""
    sock_mm: float = 0.0
    """Thickness of the sock that has been taken off the surface already."""
    name: str = ""
    """Of the file it came from, without folder; never a patient's."""
    origins: tuple[Origin, ...] = ()
    """Files that it is known to come from, the nearest first: by these a shape and what was made
    from it lie as they were made. Who gives the mesh other axes moves these along."""
    doubt: Finding | None = None
    """Why nothing may be made of it unchecked; kept in the limb file of whatever comes of it."""
    notes: tuple[Finding, ...] = ()
    """What was odd about that file and how it was taken."""

    __repr__ = brief

    def __post_init__(self) -> None:
        require_known_words(self)

    @property
    def side(self) -> Side:
        """The side, by its frame; none until aligned."""
        return "none"

    @property
    def known_limb_from_mesh(self) -> Rigid | None:
        """The motion from the mesh's frame to the limb's; None until aligned."""
        return None

    def aligned(self, refusal: LimbgramError | None = None) -> "AlignedLimb":
        """The same limb, with axes that are sure to be there.

        Args:
            refusal: Raised where it has none, in place of a MeasureError.
        """
        raise refusal or MeasureError("align.not_aligned", name=self.name or None)

    def with_frame(self, frame: LimbFrame) -> "AlignedLimb":
        return AlignedLimb(**self._without_frame(), frame=frame)

    def unaligned(self) -> "Limb":
        """The same limb without axes."""
        return Limb(**self._without_frame())

    def _without_frame(self) -> dict[str, Any]:
        return {one.name: getattr(self, one.name) for one in fields(Limb)}

    def with_mesh(self, mesh: Mesh) -> Self:
        return replace(self, mesh=mesh)

    def landmark(self, identity: str) -> Landmark:
        """The landmark at a place, under whatever name it was placed.

        Raises:
            MeasureError: it was not placed.
        """
        found = landmark_named(identity, self.landmarks)
        if found is None:
            raise MeasureError("anatomy.missing", names=(identity,), wanted_for=None)
        return found

    def axis(self, name: str) -> AnatomicalAxis:
        """An axis of its kind, such as "ankle", in the mesh's frame.

        Raises:
            MeasureError: the kind has none of that name, or a landmark that spans it is missing.
        """
        return self.anatomy.axis(name)

    @property
    def anatomy(self) -> Anatomy:
        """Its anatomical axes and landmarks, in the mesh's frame.

        Raises:
            MeasureError: nobody said what kind of limb it is.
        """
        if self.kind is None:
            raise MeasureError("anatomy.no_kind", kinds=KINDS)
        kind = KIND_NAMED[self.kind]
        motion = self.known_limb_from_mesh
        return Anatomy(
            kind=kind,
            places={
                name: one.position_mm for name, one in landmarks_by_identity(self.landmarks).items()
            },
            left=(None if self.side == "none" else self.side == "left") if kind.sided else False,
            frame=None if motion is None else motion.rotation,
            origin_mm=np.zeros(3) if motion is None else motion.inverse.translation,
            skin=LineSurface(mesh=self.mesh),
        )

    def centreline(self) -> Centreline:
        """The curve that sections and charts go by, from proximal to distal, in the mesh's frame.

        Raises:
            MeasureError: a landmark that it goes by is missing, or the limb is not aligned.
        """
        anatomy = self.anatomy
        if anatomy.kind.centreline is not None:
            return anatomy.centreline()
        axis = anatomy.axis("long axis")
        along = axis.along_mm(self.mesh.vertices_mm)
        ends = (axis.point_mm + axis.direction * end for end in (along.max(), along.min()))
        return straight_centreline(*ends)


@dataclass(frozen=True, kw_only=True)
class AlignedLimb(Limb):
    """A limb whose axes are known; what measures, devices and files for carvers are made of."""

    frame: LimbFrame

    __repr__ = brief

    @property
    def side(self) -> Side:
        return self.frame.side

    @property
    def known_limb_from_mesh(self) -> Rigid:
        return self.limb_from_mesh

    def aligned(self, refusal: LimbgramError | None = None) -> "AlignedLimb":  # noqa: ARG002
        return self

    @property
    def limb_from_mesh(self) -> Rigid:
        return self.frame.limb_from_mesh

    @property
    def mesh_in_limb(self) -> Mesh:
        """The mesh with its vertices in the limb frame, made once: so is what is made of it."""
        motion = self.limb_from_mesh
        asked = motion.rotation.tobytes(), motion.translation.tobytes()
        return _in_limb(self.mesh, asked, lambda: self.mesh.moved(motion))

    @property
    def landmarks_in_limb_mm(self) -> Points3:
        if not self.landmarks:
            return np.empty((0, 3))
        return self.limb_from_mesh.apply(np.stack([mark.position_mm for mark in self.landmarks]))

    def landmark_in_limb_mm(self, mark: Landmark) -> Vector3:
        return self.limb_from_mesh.apply(mark.position_mm[None])[0]

    def with_vertices_in_limb(self, vertices_in_limb_mm: Points3) -> Self:
        """The limb with its vertices moved to places given in the limb frame."""
        back = self.limb_from_mesh.inverse
        return self.with_mesh(self.mesh.with_vertices(back.apply(vertices_in_limb_mm)))

    def in_limb_frame(self) -> "AlignedLimb":
        """The limb with its mesh and landmarks in the limb frame."""
        motion = self.limb_from_mesh
        return replace(
            self,
            mesh=self.mesh_in_limb,
            landmarks=tuple(
                replace(mark, position_mm=self.landmark_in_limb_mm(mark)) for mark in self.landmarks
            ),
            frame=LimbFrame(limb_from_mesh=Rigid.identity(), side=self.side),
            origins=tuple(
                replace(origin, mesh_from_origin=motion @ origin.mesh_from_origin)
                for origin in self.origins
            ),
        )


_in_limb = AnswersByMesh[Mesh](most=1)

AnyLimb = TypeVar("AnyLimb", bound=Limb)
"""What a step gives back as it took it: aligned or not."""


def names_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Names made unique: repeated ones get a number."""
    taken = set(names)
    found: list[str] = []
    for name in names:
        own, number = name, 1
        while own in found or (number > 1 and own in taken):
            number += 1
            own = f"{name} ({number})"
        found.append(own)
    return tuple(found)


def marked_red(path: Path) -> Path:
    """The name of a red result: surface.stl becomes surface-RED.stl."""
    return path.with_name(f"{path.stem}{_MARK}{path.suffix}")


def file_name_doubt(name: str) -> Finding | None:
    """A doubt about a file by its name, such as one of a red result."""
    stem = Path(name).stem.removesuffix("-unitless")
    return doubt("verdict.red_shape") if stem.endswith(_MARK) else None
