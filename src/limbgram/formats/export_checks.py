"""Export checks: what must hold before a shape goes to a machine.

A mirrored or wrongly sized model is noticed only when it is cut, or worse, worn. A surface that
folds or intersects itself is printed and carved as it is.
"""

from dataclasses import replace
from pathlib import Path

from limbgram.core.errors import CarveError, FoldedShapeError, OptionsError
from limbgram.core.mesh.folds import ANY_SHAPE, Folds, find_branching, find_folds, unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import doubt, note
from limbgram.formats.units import extent_of, is_likely
from limbgram.workbench.bodies import left_out_findings, without_loose
from limbgram.workbench.frame.alignment import AlignOptions, require_landmarks_agree
from limbgram.workbench.limb import AlignedLimb, AnyLimb, Limb, Side


def admit(limb: Limb, side: Side | None) -> AlignedLimb:
    """The limb in its own frame, after its alignment, side and size were checked.

    Args:
        side: As somebody confirms it now, not as stored.

    Raises:
        OptionsError: nobody confirmed the side.
        CarveError: another side than it was aligned for, turned inside out, or of a size that no
            limb has.
        MeasureError: not aligned, or its landmarks contradict the side or the front.
    """
    limb = limb.aligned()
    if side is None:
        raise OptionsError("export.gate.side_unconfirmed", side=limb.side)
    if side != limb.side:
        raise CarveError("export.gate.side_contradicted", said=side, side=limb.side)
    aligned = sure_in_limb_frame(limb).aligned()
    if volume_mm3(aligned.mesh) <= 0:
        raise CarveError("export.gate.inside_out")
    extent_mm = extent_of(aligned.mesh)
    if not is_likely(extent_mm):
        raise CarveError("export.gate.size", extent_mm=extent_mm)
    return aligned


def sure_in_limb_frame(limb: Limb) -> Limb:
    """The limb in its frame, without folds, if its landmarks agree with side and front as kept.

    `align` asks the same; a limb file may be older than that, or corrected by hand since.

    Raises:
        MeasureError: a landmark lies far from where it belongs.
        FoldedShapeError: its surface branches, or folds where that cannot be laid back.
    """
    if isinstance(limb, AlignedLimb):
        options = AlignOptions(side=limb.side)
        require_landmarks_agree(limb, limb.limb_from_mesh, options)
    return without_folds(in_limb_frame(limb))


def without_folds(limb: AnyLimb) -> AnyLimb:
    """The limb with its folds flattened, and a note of that; unchanged if nothing folds.

    Loose bodies, which no file holds, are not checked; where the limb folds they are removed.

    Raises:
        FoldedShapeError: the surface branches, or folds where that cannot be laid back.
    """
    outside = without_loose(limb.mesh)
    _require_manifold(outside.mesh)
    found = unfolded(outside.mesh, ANY_SHAPE)
    if len(found.left):
        raise _folded(outside.mesh, find_folds(outside.mesh, ANY_SHAPE))
    if not found.vertices:
        return limb
    laid_back = note("export.folds_laid_back", points=found.vertices, farthest_mm=found.farthest_mm)
    notes = (laid_back, *left_out_findings(len(outside.loose), outside.loose))
    return replace(limb, mesh=found.mesh, notes=(*limb.notes, *notes))


def as_kept(limb: AnyLimb, path: Path) -> AnyLimb:
    """The limb as a file that is no export may hold it: without folds, except in a PLY.

    A PLY is a working file. It keeps the scan's surface, and a doubt says where that folds.

    Raises:
        FoldedShapeError: as `without_folds`, of any other kind of file.
    """
    if path.suffix.lower() != ".ply":
        return without_folds(limb)
    outside = without_loose(limb.mesh).mesh
    folds = find_folds(outside, ANY_SHAPE)
    if not len(folds):
        return limb
    x, y, z = (float(one) for one in folds.first_mm(outside))
    told = doubt("export.folds_kept", places=len(folds), point_mm=(x, y, z))
    return replace(limb, notes=(*limb.notes, told))


def require_unfolded(mesh: Mesh) -> None:
    """Refuse a surface that branches, folds over or intersects itself.

    Raises:
        FoldedShapeError: says where.
    """
    _require_manifold(mesh)
    folds = find_folds(mesh, ANY_SHAPE)
    if len(folds):
        raise _folded(mesh, folds)


def _require_manifold(mesh: Mesh) -> None:
    branching = find_branching(mesh.faces)
    if len(branching):
        x, y, z = mesh.vertices_mm[mesh.faces[branching[0]]].mean(0).tolist()
        raise FoldedShapeError("export.branching", triangles=len(branching), point_mm=(x, y, z))


def _folded(mesh: Mesh, folds: Folds) -> FoldedShapeError:
    x, y, z = (float(one) for one in folds.first_mm(mesh))
    return FoldedShapeError("export.folded", places=len(folds), point_mm=(x, y, z))


def in_limb_frame(limb: Limb) -> Limb:
    """The limb with its mesh and landmarks in the limb frame; as it is if it has none."""
    return limb.in_limb_frame() if isinstance(limb, AlignedLimb) else limb
