"""Proximal: which way along the axis the body lies, and what contradicts it.

In      a limb, its axis, and what is stated.
Out     the axis's direction, pointing to the body; notes.
Method  a statement tells, then the shape's own file, then landmarks by level, then the open brim.
        All that tell must agree; only --axis, which is stated exactly, goes over the brim.
Fails   MeasureError: nothing tells, two contradict each other, or the fit is no limb's axis.
"""

import numpy as np
from jaxtyping import Int64

from limbgram.errors import MeasureError
from limbgram.geometry.arrays import Points3, Vector3
from limbgram.shape.frame.axis import Axis
from limbgram.shape.frame.landmarks import known_name
from limbgram.shape.frame.stated import AlignOptions
from limbgram.shape.limb import Limb
from limbgram.surface.mesh import Mesh
from limbgram.surface.topology import boundary_loops

_SMALL_OPENING = 0.25
"""Of the largest opening: pieces of a ragged brim are larger, and holes left by a scanner smaller.
"""
_BRIM_WIDTH = 0.5
"""Of the limb's width: an opening that is narrower is a hole."""


def proximal_of(limb: Limb, axis: Axis, options: AlignOptions) -> tuple[Vector3, tuple[str, ...]]:
    """The axis's direction, pointing to the body, and what is odd about it."""
    stated = axis.direction if options.axis is not None else options.proximal
    of_file = None if options.declared is None else options.declared.limb_from_mesh.rotation[2]
    if options.axis is None:
        _require_long_way(limb, axis, options, stated if stated is not None else of_file)
    said, rise, brim = (
        _along(stated, axis),
        _rise_of_landmarks(limb, axis),
        _brim_side(limb, axis),
    )
    told = said or _along(of_file, axis)
    if said * _along(of_file, axis) < 0:
        raise MeasureError(
            "--axis or --proximal points the other way than the file says: the heights of an AOP "
            "rise proximally, and turned over its left would be right. Leave the direction out, or "
            "have the file corrected where it came from."
        )
    if told * rise < 0:
        raise MeasureError(
            "The landmarks lie the other way up than --axis, --proximal or the file says. Check "
            "which is wrong; the template of names orders them from distal to proximal."
        )
    sense = told or rise
    if sense * brim < 0:
        return _over_the_brim(axis, options, "landmarks say" if not told else "is stated")
    sense = sense or brim
    if not sense:
        raise MeasureError(
            "Nothing tells which end of the limb is proximal: it has no landmarks at different "
            "levels and no open brim at one end. Say it by --proximal, such as --proximal +z."
        )
    return np.sign(sense) * axis.direction, ()


def _over_the_brim(
    axis: Axis, options: AlignOptions, source: str
) -> tuple[Vector3, tuple[str, ...]]:
    """The stated axis, although the shape is open at its distal end; nothing less exact will do."""
    if options.axis is not None:
        return axis.direction, (
            "the shape's opening, or what no photo saw of it, lies at the distal end of the stated "
            "--axis: check that it points to the body",
        )
    raise MeasureError(
        f"The shape is open, or unseen, at the end that is distal by what {source}, and a limb is "
        "at the proximal one. Check which way the shape lies, and its landmarks. If the body does "
        "lie opposite to the opening, state the axis itself, pointing to the body: "
        f"--axis={_typed(axis.direction)} or --axis={_typed(-axis.direction)}."
    )


def _require_long_way(limb: Limb, axis: Axis, options: AlignOptions, told: Vector3 | None) -> None:
    """Refuse a fit that runs across what is proximal, as one from heel to toe does."""
    if told is None:
        if limb.kind == "foot":
            raise MeasureError(
                "A foot may be longest from heel to toe, so its axis is not taken from its shape "
                "alone. Say roughly where the leg is by --proximal, such as --proximal +z."
            )
        return
    off_deg = np.degrees(np.arccos(min(abs(_along(told, axis)), 1.0)))
    if off_deg > options.most_off_axis_deg:
        raise MeasureError(
            f"The shape is longest {off_deg:.0f} degrees away from what is said to be proximal: "
            f"along {_typed(axis.direction)}. Check the direction; or if the limb's axis is not "
            f"where the shape is longest, as of a foot, state it: --axis={_typed(told)}."
        )


def _along(direction: Vector3 | None, axis: Axis) -> float:
    """Cosine between a direction and the axis; 0 if there is none."""
    if direction is None:
        return 0.0
    return float(direction @ axis.direction / np.linalg.norm(direction))


def _rise_of_landmarks(limb: Limb, axis: Axis) -> float:
    """Positive if landmarks of higher level lie further along the axis."""
    if limb.kind is None:
        return 0.0
    found = ((mark, known_name(mark.name, limb.kind)) for mark in limb.landmarks)
    marks = [(mark, known.level) for mark, known in found if known is not None]
    levels = np.array([level for _, level in marks], np.float64)
    heights = np.array([mark.position_mm @ axis.direction for mark, _ in marks])
    rise = np.subtract.outer(levels, levels) * np.subtract.outer(heights, heights)
    return float(rise.sum())


def _brim_side(limb: Limb, axis: Axis) -> float:
    """Positive if the open brim, or the part that no photo saw, lies at the far end of the axis.

    A hole is no brim: a brim is about as wide as the limb, and small openings do not count beside
    a large one.
    """
    mesh = limb.mesh
    edge = mesh.vertices_mm[_large_openings(mesh)]
    if not len(edge) and mesh.filled is not None:
        edge = mesh.vertices_mm[mesh.filled]
    if not len(edge) or _width_mm(edge, axis) < _BRIM_WIDTH * _width_mm(mesh.vertices_mm, axis):
        return 0.0
    along = mesh.vertices_mm @ axis.direction
    share = float((edge @ axis.direction > (along.min() + along.max()) / 2).mean())
    return 1.0 if share > 0.9 else -1.0 if share < 0.1 else 0.0


def _large_openings(mesh: Mesh) -> Int64[np.ndarray, " k"]:
    """Vertices on the open edges, without those round openings much smaller than the largest."""
    loops = boundary_loops(mesh.faces)
    if not loops:
        return np.zeros(0, np.int64)
    across_mm = [float(np.linalg.norm(np.ptp(mesh.vertices_mm[loop], axis=0))) for loop in loops]
    least_mm = _SMALL_OPENING * max(across_mm)
    large = [loop for loop, size_mm in zip(loops, across_mm, strict=True) if size_mm >= least_mm]
    return np.concatenate(large).astype(np.int64)


def _width_mm(points: Points3, axis: Axis) -> float:
    """Root mean square distance from the points' middle, across the axis."""
    off = points - points.mean(0)
    return float(np.linalg.norm(off - np.outer(off @ axis.direction, axis.direction))) / np.sqrt(
        len(points)
    )


def _typed(direction: Vector3) -> str:
    """A direction as it may be typed."""
    unit = direction / np.linalg.norm(direction)
    return ",".join(f"{value + 0.0:.4g}" for value in np.round(unit, 4))
