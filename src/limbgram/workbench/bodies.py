"""Bodies: which pieces of a shape are the limb, and which are left out.

Left out  what lies inside another body, such as bones inside the skin; and loose bodies, far
          smaller than the limb and apart from it, such as a crumb of a scan.
Refused   by whoever needs one limb: bodies of comparable size apart from each other, such as two
          legs in one file.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Int64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Faces, Vector3
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.signed_distance import SignedSurface
from limbgram.core.mesh.topology import boundary_half_edges, face_components, with_faces
from limbgram.findings import Finding, doubt, note
from limbgram.workbench.limb import AnyLimb

_MOST_TESTED = 64
"""Pieces of a shape that are held against each other, the largest first; the rest are scraps."""
_LEAST_RIVAL_SHARE = 0.2
"""Of the limb's area: what lies apart and is smaller is loose, what is larger a limb of its own."""
_TOUCHING_MM = 0.1
_PATCH_MM = 10.0
"""An open piece that lies as near is a patch of a limb with gaps, not a loose body."""
_MOST_NAMED = 3
FrameOfPlaces = Literal["file", "limb"]
Done = Literal["left out", "not measured", "written too"]
"""What became of bodies that are no limb."""


@dataclass(frozen=True, kw_only=True)
class SeparateBody:
    """A body that lies apart from the limb."""

    place_mm: Vector3
    """Middle of its box, in the frame of the mesh that was looked at."""
    size_mm: float
    """Longest side of its box."""
    area_share: float
    """Of the limb's."""


@dataclass(frozen=True)
class OuterShape:
    """A shape without the bodies that are left out."""

    mesh: Mesh
    inside: int = 0
    """Number of bodies inside others."""
    loose: tuple[SeparateBody, ...] = ()
    rivals: tuple[SeparateBody, ...] = ()
    """Bodies of comparable size, which stay in the mesh."""

    @property
    def bodies_left_out(self) -> int:
        return self.inside + len(self.loose)

    def require_one_limb(self) -> None:
        """Refuse a shape that holds several limbs.

        Raises:
            MeasureError: bodies of comparable size lie apart from each other.
        """
        if self.rivals:
            raise MeasureError(
                "limb.several", count=len(self.rivals) + 1, shares=_area_shares(self.rivals)
            )


def outer_bodies(mesh: Mesh) -> OuterShape:
    """The mesh without loose bodies, and without pieces inside others that face the same way.

    The walls of hollows face the other way, and stay.
    """
    found = _sorted_bodies(mesh)
    return found.without(mesh, found.inner | found.gone)


def without_loose(mesh: Mesh) -> OuterShape:
    """The mesh without loose bodies; bodies inside the limb are counted, and stay."""
    found = _sorted_bodies(mesh)
    left = found.without(mesh, found.gone)
    if not (left.loose and left.inside):
        return left
    # What lay inside a loose body is loose itself, now that this one is gone.
    rest = without_loose(left.mesh)
    return replace(rest, loose=left.loose + rest.loose)


def outside_of(limb: AnyLimb, place: str | None = None, *, as_bones: bool = False) -> AnyLimb:
    """The limb without the bodies left out, with notes of them.

    Args:
        place: What the notes call it; None: the limb.
    """
    found = outer_bodies(limb.mesh)
    notes = list(left_out_findings(found.bodies_left_out, found.loose, place, as_bones=as_bones))
    if found.rivals:
        count, shares = len(found.rivals) + 1, _area_shares(found.rivals)
        notes.append(doubt("limb.rivals.mixed", count=count, shares=shares))
    if not notes:
        return limb
    return replace(limb, mesh=found.mesh, notes=(*limb.notes, *notes))


def left_out_findings(
    bodies: int,
    loose: tuple[SeparateBody, ...],
    place: str | None = None,
    *,
    frame: FrameOfPlaces = "file",
    done: Done = "left out",
    as_bones: bool = False,
) -> tuple[Finding, ...]:
    """Findings about the bodies left out; none where there are none.

    Args:
        bodies: All of them, the loose ones too.
        frame: In which the loose ones' places are given.
    """
    found: list[Finding] = []
    if inside := bodies - len(loose):
        found.append(_inside_findings(inside, place, done, as_bones=as_bones))
    if loose:
        found.append(
            note(
                "limb.bodies.loose",
                count=len(loose),
                place=place,
                bodies=tuple(_place_and_size(body) for body in loose[:_MOST_NAMED]),
                more=len(loose) > _MOST_NAMED,
                frame=frame,
                done=done,
            )
        )
    return tuple(found)


def kept_findings(found: OuterShape) -> tuple[Finding, ...]:
    """Findings about a file that keeps bodies which do not belong to the limb's surface."""
    said: list[Finding] = []
    if found.inside:
        said.append(_inside_findings(found.inside, None, "written too", as_bones=True))
    if found.rivals:
        count, shares = len(found.rivals) + 1, _area_shares(found.rivals)
        said.append(doubt("limb.rivals.written", count=count, shares=shares))
    return tuple(said)


def _inside_findings(count: int, place: str | None, done: Done, *, as_bones: bool) -> Finding:
    return note("limb.bodies.inside", count=count, place=place, done=done, as_bones=as_bones)


def _place_and_size(body: SeparateBody) -> Finding:
    x, y, z = body.place_mm.tolist()
    return note("limb.bodies.one", size_mm=body.size_mm, x_mm=x, y_mm=y, z_mm=z)


def _area_shares(rivals: tuple[SeparateBody, ...]) -> tuple[float, ...]:
    """Areas of the first rivals, as shares of the largest body's."""
    return tuple(body.area_share for body in rivals[:_MOST_NAMED])


def _inner_bodies(mesh: Mesh, pieces: np.ndarray) -> list[int]:
    sizes = np.bincount(pieces)
    largest = np.argsort(-sizes, kind="stable")[:_MOST_TESTED]
    by_piece = np.argsort(pieces, kind="stable")
    starts = np.cumsum(sizes) - sizes
    bodies = [_BodyBox.of(mesh, by_piece[starts[k] : starts[k] + sizes[k]]) for k in largest]
    inner = [_is_inside_another(mesh, body, bodies) for body in bodies]
    return [int(k) for k, is_inner in zip(largest, inner) if is_inner]


@dataclass(frozen=True, kw_only=True)
class _SortedBodies:
    """The bodies besides the limb, and their faces."""

    inner: Bool[np.ndarray, " f"]
    gone: Bool[np.ndarray, " f"]
    """Those of loose bodies."""
    inside: int = 0
    loose: tuple[SeparateBody, ...] = ()
    rivals: tuple[SeparateBody, ...] = ()

    def without(self, mesh: Mesh, faces: Bool[np.ndarray, " f"]) -> OuterShape:
        kept = mesh if not faces.any() else with_faces(mesh, mesh.faces[~faces])
        return OuterShape(kept, inside=self.inside, loose=self.loose, rivals=self.rivals)


def _sorted_bodies(mesh: Mesh) -> _SortedBodies:
    """Bodies inside others; and what lies apart from the largest one and from all that joins it."""
    none = np.zeros(len(mesh.faces), np.bool_)
    pieces = face_components(mesh.faces)
    if not pieces.max(initial=0):
        return _SortedBodies(inner=none, gone=none)
    inside = _inner_bodies(mesh, pieces)
    inner = np.isin(pieces, inside)
    outer = mesh if not inside else with_faces(mesh, mesh.faces[~inner])
    pieces = np.unique(pieces[~inner], return_inverse=True)[1]
    found = _SortedBodies(inner=inner, gone=none, inside=len(inside))
    if not pieces.max(initial=0):
        return found
    areas = np.bincount(pieces, np.linalg.norm(outer.face_normals(), axis=1))
    apart = np.flatnonzero(_separate_pieces(outer, pieces, int(areas.argmax())))
    apart = apart[np.argsort(-areas[apart], kind="stable")]
    shares = areas[apart] / areas.max()
    bodies = [
        _separate_body(outer, outer.faces[pieces == piece], float(share))
        for piece, share in zip(apart, shares)
    ]
    gone = none.copy()
    gone[~inner] = np.isin(pieces, apart[shares < _LEAST_RIVAL_SHARE])
    return replace(
        found,
        gone=gone,
        loose=tuple(body for body in bodies if body.area_share < _LEAST_RIVAL_SHARE),
        rivals=tuple(body for body in bodies if body.area_share >= _LEAST_RIVAL_SHARE),
    )


def _separate_pieces(mesh: Mesh, pieces: np.ndarray, main: int) -> Bool[np.ndarray, " p"]:
    """Pieces outside the limb and clear of its main body and of all that joins it."""
    count = int(pieces.max()) + 1
    piece_of = np.full(len(mesh.vertices_mm), main)
    piece_of[mesh.faces.ravel()] = np.repeat(pieces, 3)
    reach_mm = np.full(count, _TOUCHING_MM)
    reach_mm[piece_of[boundary_half_edges(mesh.faces).ravel()]] = _PATCH_MM
    free = np.arange(count) != main
    joining = ~free
    while joining.any() and free.any():
        # All of it, not what joined last: from the wall of a hollow alone, outside is inside.
        surface = with_faces(mesh, mesh.faces[~free[pieces]])
        ids = np.flatnonzero(free[piece_of])
        away = SignedSurface(surface.vertices_mm, surface.faces).query(mesh.vertices_mm[ids])
        nearest = np.full(count, np.inf)
        np.minimum.at(nearest, piece_of[ids], np.abs(away.signed_mm))
        votes = np.bincount(piece_of[ids], np.where(away.signed_mm > 0, 1.0, -1.0), count)
        joining = free & ((nearest <= reach_mm) | (votes <= 0))
        free &= ~joining
    return free


def _separate_body(mesh: Mesh, faces: Faces, share: float) -> SeparateBody:
    corners = mesh.vertices_mm[faces.ravel()]
    low, high = corners.min(0), corners.max(0)
    return SeparateBody(
        place_mm=(low + high) / 2, size_mm=float((high - low).max()), area_share=share
    )


@dataclass(frozen=True)
class _BodyBox:
    face_ids: Int64[np.ndarray, " k"]
    low_mm: Vector3
    high_mm: Vector3

    @classmethod
    def of(cls, mesh: Mesh, face_ids: Int64[np.ndarray, " k"]) -> "_BodyBox":
        corners = mesh.vertices_mm[mesh.faces[face_ids].ravel()]
        return cls(face_ids, corners.min(0), corners.max(0))


def _is_inside_another(mesh: Mesh, body: _BodyBox, others: list[_BodyBox]) -> bool:
    own = mesh.faces[body.face_ids]
    if _signed_volume(mesh, own) <= 0:
        return False
    place_mm = mesh.vertices_mm[own[0, 0]]
    return any(
        (body.low_mm >= other.low_mm).all()
        and (body.high_mm <= other.high_mm).all()
        and _winding(mesh, mesh.faces[other.face_ids], place_mm) > 0.5
        for other in others
        if other is not body
    )


def _signed_volume(mesh: Mesh, faces: Faces) -> float:
    a, b, c = (mesh.vertices_mm[faces[:, k]] - mesh.vertices_mm[faces[0, 0]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)))


def _winding(mesh: Mesh, faces: Faces, place_mm: Vector3) -> float:
    """Winding number of a surface at a place, by solid angles (Van Oosterom and Strackee 1983)."""
    a, b, c = (mesh.vertices_mm[faces[:, k]] - place_mm for k in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    over = np.einsum("ij,ij->i", a, np.cross(b, c))
    under = la * lb * lc + lc * (a * b).sum(1) + la * (b * c).sum(1) + lb * (c * a).sum(1)
    return float(np.arctan2(over, under).sum() / (2 * np.pi))
