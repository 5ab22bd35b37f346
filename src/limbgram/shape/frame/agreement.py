"""Agreement: side and front as stated, against the landmarks and the shape's own file.

A wrong side is worn; so whatever is known of the limb is held against what is said of it.
"""

import numpy as np

from limbgram.errors import MeasureError
from limbgram.geometry.rigid import Rigid
from limbgram.shape.frame.landmarks import known_anywhere, likely_meant
from limbgram.shape.frame.stated import AlignOptions, outward
from limbgram.shape.limb import Limb

_SAME_FRONT_DEG = 10.0
_SAME_TILT_DEG, _SAME_PLACE_MM = 0.01, 0.01


def require_side_of_file(options: AlignOptions) -> None:
    """Refuse another side than the shape's own file names.

    Raises:
        MeasureError: with both sides.
    """
    declared = options.declared
    if declared is None or declared.side in ("none", options.side):
        return
    raise MeasureError(
        f"The shape's own file says that it is a {declared.side} limb, and the side stated is "
        f"{options.side!r}. Check it on the patient. If the file is wrong, have it corrected where "
        f"it came from; to make the other side's shape of it, align it as {declared.side} and use "
        "the edit `mirror`."
    )


def require_landmarks_agree(limb: Limb, frame: Rigid, options: AlignOptions) -> None:
    """Refuse a side, or an anterior direction, that the landmarks contradict.

    Raises:
        MeasureError: a landmark lies far from the side on which places of its name lie, whether
            or not anybody says what kind of limb it is.
    """
    for mark in limb.landmarks:
        expected = outward(known_anywhere(mark.name, limb.kind), options.side)
        x, y, _ = frame.apply(mark.position_mm[None])[0]
        if not expected or abs(complex(x, y)) < options.near_axis_mm:
            continue
        off_deg = _between_deg(complex(x, y), expected)
        if off_deg > options.most_contradiction_deg:
            raise MeasureError(
                f"Landmark {mark.name!r} lies {off_deg:.0f} degrees from where it belongs on a "
                f"limb of side {options.side!r}. The side or the front is wrong, the landmark lies "
                "in another place, or the shape is mirrored. Check them before anything is made "
                "from it; `limbgram align` picks a landmark anew (--landmark) and sets the side."
            )


def front_of_file(frame: Rigid, options: AlignOptions) -> tuple[str, ...]:
    """What to note if the front differs from that of the shape's own file.

    Raises:
        MeasureError: it differs too far.
    """
    if options.declared is None:
        return ()
    x, y, _ = frame.rotation @ options.declared.limb_from_mesh.rotation[1]
    off_deg = _between_deg(complex(x, y), 1j)
    if off_deg > options.most_contradiction_deg:
        raise MeasureError(
            f"The front lies {off_deg:.0f} degrees from where the shape's own file has it: the "
            "angles of an AOP count from the front. Leave --anterior out to take the file's, and "
            "check the landmarks; if the file is wrong, have it corrected where it came from."
        )
    if off_deg < _SAME_FRONT_DEG:
        return ()
    return (f"the front lies {off_deg:.0f} degrees from where the shape's own file has it",)


def moved_from_file(frame: Rigid, options: AlignOptions) -> tuple[str, ...]:
    """What to note where the axis or the origin of the shape's own file was not kept."""
    if options.declared is None:
        return ()
    own = options.declared.limb_from_mesh
    tilted_deg = float(np.degrees(np.arccos(min(float(frame.rotation[2] @ own.rotation[2]), 1.0))))
    x, y, z = frame.apply(own.inverse.translation[None])[0]
    if tilted_deg < _SAME_TILT_DEG and max(abs(x), abs(y), abs(z)) < _SAME_PLACE_MM:
        return ()
    return (
        "the shape's own file has another axis or origin, which were not kept as another axis or "
        f"flexion was asked for: tilted by {tilted_deg:.2f} degrees, and its origin lies "
        f"{np.hypot(x, y):.2f} mm beside the axis and {z:+.2f} mm along it. Heights and radii "
        "change with that",
    )


def other_side_before(limb: Limb, options: AlignOptions) -> tuple[str, ...]:
    """What to note if the limb was aligned for another side."""
    if limb.frame is None or limb.frame.side in ("none", options.side):
        return ()
    return (
        f"the limb was aligned as {limb.frame.side!r} before and is {options.side!r} now: check it "
        "on the patient",
    )


def odd_names(limb: Limb) -> tuple[str, ...]:
    """What to note of landmarks whose names tell nothing, but nearly do."""
    meant = ((mark.name, likely_meant(mark.name, limb.kind)) for mark in limb.landmarks)
    return tuple(
        f"landmark {name!r} is a name of no template and tells neither side nor front: was "
        f"{other!r} meant? Then pick it by that name, and move the limb file away to lose the other"
        for name, other in meant
        if other is not None
    )


def _between_deg(one: complex, other: complex) -> float:
    return float(abs(np.degrees(np.angle(one * np.conj(other)))))
