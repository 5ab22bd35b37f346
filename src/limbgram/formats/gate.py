"""The gate: what must hold before a shape goes to a machine that cannot ask.

A mirrored or wrongly sized model is found when it is cut, or worse, worn. A surface that folds or
passes through itself is printed and carved as it stands.
"""

from dataclasses import replace

import numpy as np

from limbgram.core.errors import CarveError, FoldedShapeError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.folds import ANY_SHAPE, Folds, find_branching, find_folds, unfolded
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.findings import note
from limbgram.formats.units import LIKELY_MM
from limbgram.workbench.bodies import left_out, without_loose
from limbgram.workbench.frame.alignment import AlignOptions, require_landmarks_agree
from limbgram.workbench.limb import Landmark, Limb, LimbFrame, Side


def admit(limb: Limb, side: Side | None) -> Limb:
    """The limb in its own frame, once alignment, side and size are sure.

    Args:
        side: As somebody confirms it now, not as it was kept.

    Raises:
        OptionsError: nobody confirmed the side.
        CarveError: not aligned, another side than it was aligned for, turned inside out, or of
            a size that no limb has.
        MeasureError: its landmarks contradict the side or the front.
    """
    if limb.frame is None:
        raise CarveError(
            "The shape is not aligned, so a carver would not know its axis, its front and its "
            "side. Run `limbgram align` first."
        )
    if side is None:
        raise OptionsError(
            f"The side must be confirmed before anything is carved. The shape was aligned as "
            f"{limb.frame.side!r}: check it on the patient, and say --side left, right or none."
        )
    if side != limb.frame.side:
        raise CarveError(
            f"The side is not sure: you say {side!r} and the shape was aligned as "
            f"{limb.frame.side!r}. One of them is wrong. Check it on the patient, and align again "
            "if it was the alignment."
        )
    aligned = sure_in_limb_frame(limb)
    if volume_mm3(aligned.mesh) <= 0:
        raise CarveError("The shape is inside out: it has no volume to carve. Repair it first.")
    extent_mm = float(np.ptp(aligned.mesh.vertices_mm, axis=0).max())
    if not LIKELY_MM[0] <= extent_mm <= LIKELY_MM[1]:
        raise CarveError(
            f"The shape is {extent_mm:.3g} mm long, which no limb is. Its unit is probably wrong: "
            "read it again with --unit, and align it again."
        )
    return aligned


def sure_in_limb_frame(limb: Limb) -> Limb:
    """The limb in its frame, without folds, if its landmarks agree with side and front as kept.

    `align` asks the same; a limb file may be older than that, or corrected by hand since.

    Raises:
        MeasureError: a landmark lies far from where it belongs.
        FoldedShapeError: its surface branches, or folds where that cannot be laid back.
    """
    if limb.frame is not None:
        options = AlignOptions(side=limb.frame.side)
        require_landmarks_agree(limb, limb.frame.limb_from_mesh, options)
    return without_folds(in_limb_frame(limb))


def without_folds(limb: Limb) -> Limb:
    """The limb with what its surface folds laid back, and a note of it; as it is if nothing folds.

    Loose bodies, which no file holds, are not looked at: where the limb folds they go here.

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
    said = (
        f"the surface folded over or through itself; {found.vertices:,} of its points went back "
        f"among their neighbours, by up to {found.farthest_mm:.1f} mm, and count as filled in"
    )
    notes = (note("said.as_is", message=said), *left_out(len(outside.loose), outside.loose))
    return replace(limb, mesh=found.mesh, notes=(*limb.notes, *notes))


def require_unfolded(mesh: Mesh) -> None:
    """Refuse a surface that branches, folds over or passes through itself.

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
        x, y, z = mesh.vertices_mm[mesh.faces[branching[0]]].mean(0)
        raise FoldedShapeError(
            f"Not written: at {len(branching)} triangles the surface branches, touches itself in a "
            f"point or turns inside out, the first near ({x:.1f}, {y:.1f}, {z:.1f}) mm. A printer "
            "or a carver takes that literally. Clean the shape by `limbgram edit`, or mend it in "
            "the program that it comes from."
        )


def _folded(mesh: Mesh, folds: Folds) -> FoldedShapeError:
    x, y, z = folds.first_mm(mesh)
    places = "1 place" if len(folds) == 1 else f"{len(folds)} places"
    return FoldedShapeError(
        f"Not written: the surface folds over or through itself at {places}, the first near "
        f"({x:.1f}, {y:.1f}, {z:.1f}) mm. A printer or a carver takes that literally. Smooth or "
        "cut it there by `limbgram edit`, or mend it in the program that it comes from."
    )


def in_limb_frame(limb: Limb) -> Limb:
    """The limb with its mesh and landmarks in the limb frame; as it is if it has none."""
    if limb.frame is None:
        return limb
    motion = limb.frame.limb_from_mesh
    return replace(
        limb,
        mesh=limb.mesh.with_vertices(motion.apply(limb.mesh.vertices_mm)),
        landmarks=tuple(
            Landmark(name=mark.name, position_mm=motion.apply(mark.position_mm[None])[0])
            for mark in limb.landmarks
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side=limb.frame.side),
        origins=tuple(
            replace(origin, mesh_from_origin=motion @ origin.mesh_from_origin)
            for origin in limb.origins
        ),
    )
