"""Stated: what the clinician says of a limb that is to be aligned, and where names say it faces."""

from dataclasses import dataclass, field

from limbgram.geometry.arrays import Vector3
from limbgram.shape.frame.axis import AxisOptions
from limbgram.shape.frame.landmarks import Facing, LandmarkName
from limbgram.shape.limb import Kind, LimbFrame, Side

_OUTWARD: dict[Facing, complex] = {"anterior": 1j, "posterior": -1j, "right": 1, "left": -1}
"""In the limb frame, x + i y; medial and lateral follow from the side."""


@dataclass(frozen=True, kw_only=True)
class AlignOptions:
    """What the clinician states. Directions are in the mesh's frame."""

    side: Side
    kind: Kind | None = None
    """Which names tell what; None for the kind that the limb is known to be, if it is."""
    axis: Vector3 | None = None
    """Long axis, pointing proximally, in place of the fit; the brim does not overrule it."""
    fit_anew: bool = False
    """Fit the long axis, and turn by landmarks, although the shape's own file has its axes."""
    proximal: Vector3 | None = None
    """Roughly towards the body, where landmarks and brim do not tell."""
    anterior: Vector3 | None = None
    """Roughly forwards, in place of landmarks."""
    plumb: tuple[str, str] | None = None
    """Upper and lower landmark that shall lie one above the other in the side view."""
    flexion_deg: float = 0.0
    """Turned further about the side-to-side axis; positive takes the proximal end backwards."""
    declared: LimbFrame | None = None
    """What the shape's own file says, as an AOP does: never overruled in side or proximal end, and

    its axis and origin are kept unless an axis is stated or to be fitted."""
    most_contradiction_deg: float = 60.0
    """Landmarks further than this from the side on which their names lie are contradicted, and so
    is a file by another front."""
    most_off_axis_deg: float = 45.0
    """A fitted axis further than this from what is stated to be proximal is not the limb's."""
    most_flexion_deg: float = 120.0
    near_axis_mm: float = 15.0
    """Landmarks nearer to the axis than this lie on no side of it."""
    fit: AxisOptions = field(default_factory=AxisOptions)

    @property
    def kept(self) -> LimbFrame | None:
        """The frame of the shape's own file, where nothing takes its axis away."""
        return self.declared if self.axis is None and not self.fit_anew else None


def outward(known: LandmarkName | None, side: Side) -> complex:
    """Direction in the limb frame in which a landmark should lie from the axis; 0 if untold."""
    if known is None:
        return 0
    if known.facing in ("medial", "lateral"):
        lateral = {"right": 1, "left": -1, "none": 0}[side]
        return lateral if known.facing == "lateral" else -lateral
    return _OUTWARD.get(known.facing, 0)
