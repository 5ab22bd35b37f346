"""Spine: a trunk shifted, turned and bent by level, the pelvis staying, as a positive is corrected.

In      an aligned trunk; heights, and how far each level is shifted, turned and tilted.
Out     the trunk with its levels moved; landmarks go with them.
Method  Cubic curves through the levels with the slopes of PCHIP, level at both ends, nothing below
        the first. A bend makes a curve of the long axis, and a section stays plane and square to
        it. Half way through the bend the axis is straight and the sections lie level: heights count
        there, so a level is tilted by half its angle the other way before, as a wedge is cut that
        the level halves. In its plane a section takes half the turn, the shift, half the turn. So
        the same edit with opposite signs brings the shape back exactly.
Fails   EditError: the lists differ in length, heights do not rise, or the strain is beyond what is
        done.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from jaxtyping import Float64
from scipy.spatial.transform import Rotation

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.request_fields import Within
from limbgram.findings import note
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import (
    displaced,
    height_mm,
    moved_by,
    points_in_limb_frame,
    require_aligned,
)
from limbgram.workbench.edits.repose import (
    MOST_STRAIN,
    MOST_STRAIN_ACCEPTED,
    angle_findings,
    largest_strain,
)
from limbgram.workbench.limb import Limb

ShiftMm = Annotated[float, Within(-60, 60)]
TurnDeg = Annotated[float, Within(-30, 30)]
_STEP_MM = 1.0
"""Along the axis, between places to which a bend is summed."""
_ROUNDS, _CONVERGED_MM = 100, 1e-11


@edit(
    group="orthosis",
    order=3,
    effect=Effect(reports_displacement=False, start="follows"),
    kinds=("torso",),
    example={"heights_mm": (50.0, 150.0, 300.0), "right_mm": (0.0, 10.0, 0.0)},
)
class Spine(Edit):
    """Shift, turn and bend a trunk by level, as a positive is corrected; the pelvis stays."""

    heights_mm: tuple[float, ...]
    """Of the levels, rising; the first one and all below stay as they are."""
    right_mm: tuple[ShiftMm, ...] = ()
    """To the patient's right, by level."""
    forward_mm: tuple[ShiftMm, ...] = ()
    """Forwards, by level."""
    turn_deg: tuple[TurnDeg, ...] = ()
    """About the long axis, right side forwards, by level."""
    bend_right_deg: tuple[TurnDeg, ...] = ()
    """Tilt of the level to the patient's right, by level; what lies above the last goes on so."""
    bend_back_deg: tuple[TurnDeg, ...] = ()
    """Tilt of the level backwards, by level: positive adds lordosis, negative takes it away."""
    above: str = ""
    """Landmark from which heights count; without it from the limb's origin."""
    beyond: bool = False
    """Somebody means a strain of more than 25 per cent."""

    words = spoken(
        en=Words(
            name="Shift, turn and bend by level",
            title="The correction by level",
            labels={
                "right_mm": "To the right",
                "forward_mm": "Forwards",
                "bend_right_deg": "Bend to the right",
                "bend_back_deg": "Bend backwards",
            },
        ),
        de=Words(
            name="Nach Höhe verschieben, drehen und neigen",
            title="Die Korrektur nach Höhe",
            does="Einen Rumpf nach Höhe verschieben, drehen und neigen, wie man ein Positiv "
            "korrigiert; das Becken bleibt.",
            labels={
                "heights_mm": "Höhen",
                "right_mm": "Nach rechts",
                "forward_mm": "Nach vorn",
                "turn_deg": "Drehung",
                "bend_right_deg": "Neigung nach rechts",
                "bend_back_deg": "Neigung nach hinten",
                "above": "Über",
                "beyond": "Gewollt",
            },
            help={
                "heights_mm": "Der Ebenen, steigend; die erste und alles darunter bleiben.",
                "right_mm": "Zur rechten Seite des Patienten, je Ebene.",
                "forward_mm": "Nach vorn, je Ebene.",
                "turn_deg": "Um die Längsachse, rechte Seite nach vorn, je Ebene.",
                "bend_right_deg": "Wie weit sich die Ebene zur rechten Seite des Patienten neigt, "
                "je Ebene; was über der letzten liegt, folgt ihr.",
                "bend_back_deg": "Wie weit sich die Ebene nach hinten neigt, je Ebene: positiv "
                "mehr Lordose, negativ weniger.",
                "above": "Landmarke, von der Höhen zählen; sonst vom Ursprung des Gliedmaßes.",
                "beyond": "Mehr als 25 Prozent Dehnung sind gewollt.",
            },
        ),
    )

    def check(self) -> None:
        """Refuse lists that do not belong together.

        Raises:
            EditError: they differ in length, or heights do not rise.
        """
        moves = (self.right_mm, self.forward_mm, self.turn_deg, *self._bends)
        lists = [one for one in moves if one]
        rising = all(low < high for low, high in zip(self.heights_mm, self.heights_mm[1:]))
        if len(self.heights_mm) < 2 or not rising or not lists:
            raise EditError("edit.spine.heights")
        if any(len(one) != len(self.heights_mm) or one[0] != 0 for one in lists):
            raise EditError("edit.spine.lists", levels=len(self.heights_mm))

    def apply(self, limb: Limb) -> Limb:
        """Move the levels, and tell how far the surface was strained, and how it is bent.

        Raises:
            EditError: the limb is not aligned, or the strain is beyond what is done.
        """
        aligned = require_aligned(limb)
        base = np.array([0.0, 0.0, height_mm(limb, 0.0, self.above)])
        before, after = self._axis_at_share(-0.5), self._axis_at_share(0.5)
        z, flat = before.levels_of(points_in_limb_frame(limb) - base)
        half = np.radians(self._at(self.turn_deg, z)) / 2
        shift = np.column_stack([self._at(self.right_mm, z), self._at(self.forward_mm, z)])
        points = after.points_on_levels(z, _rotated(_rotated(flat, half) + shift, half)) + base
        back = moved_by(aligned.limb_from_mesh.inverse, points)
        strain = largest_strain(limb.mesh.faces, limb.mesh.vertices_mm, back)
        most = MOST_STRAIN_ACCEPTED if self.beyond else MOST_STRAIN
        if strain > most:
            raise EditError("edit.spine.strain", strain=strain, most=most, beyond=self.beyond)
        moved = displaced(limb, back)
        bent = zip(("side bend", "extension"), self._bends, strict=True)
        told = [
            one for joint, values in bent if values for one in angle_findings(limb, moved, joint)
        ]
        return replace(moved, notes=(*moved.notes, note("edit.spine.done", strain=strain), *told))

    @property
    def _bends(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return self.bend_right_deg, self.bend_back_deg

    def _axis_at_share(self, share: float) -> "_BentAxis":
        """The axis bent by a share of the whole; heights from the landmark."""

        def tilts(z_mm: Float64[np.ndarray, " n"]) -> Points3:
            """Rotation vectors in rad: backwards about the axis to the right, to the right about
            the axis forwards."""
            right, back = (self._at(values, z_mm) for values in self._bends)
            return np.radians(np.column_stack([back, right, np.zeros(len(z_mm))])) * share

        return _BentAxis.of(tilts, self.heights_mm[0], self.heights_mm[-1])

    def _at(
        self, values: tuple[float, ...], z_mm: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, " n"]:
        """Values of the smooth curve through the levels; constant beyond the last."""
        if not values:
            return np.zeros(len(z_mm))
        from scipy.interpolate import (  # a tenth of a second, for spines alone
            CubicHermiteSpline,
            PchipInterpolator,
        )

        held = np.clip(z_mm, self.heights_mm[0], self.heights_mm[-1])
        slopes = np.asarray(
            PchipInterpolator(self.heights_mm, values).derivative()(self.heights_mm)
        )
        slopes[[0, -1]] = 0.0  # it leaves the pelvis without a bend
        return np.asarray(CubicHermiteSpline(self.heights_mm, values, slopes)(held))


def _rotated(
    points: Float64[np.ndarray, "n 2"], angles_rad: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n 2"]:
    x, y = points.T
    cosine, sine = np.cos(angles_rad), np.sin(angles_rad)
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])


@dataclass(frozen=True, kw_only=True)
class _BentAxis:
    """A long axis that is bent between two heights, with plane levels square to it."""

    tilts: Callable[[Float64[np.ndarray, " n"]], Points3]
    """Tilts of levels, as rotation vectors."""
    axis: Callable[[Float64[np.ndarray, " n"]], Points3]
    """Points of the axis, by heights between the two ends."""
    low_mm: float
    high_mm: float

    @classmethod
    def of(
        cls,
        tilts: Callable[[Float64[np.ndarray, " n"]], Points3],
        low_mm: float,
        high_mm: float,
    ) -> "_BentAxis":
        """The axis, integrated along its length by Simpson's rule."""
        from scipy.interpolate import CubicHermiteSpline  # a tenth of a second, for spines alone

        z = np.linspace(low_mm, high_mm, max(2, round((high_mm - low_mm) / _STEP_MM)) + 1)
        ways, middles = _axis_directions(tilts(z)), _axis_directions(tilts((z[1:] + z[:-1]) / 2))
        steps = (ways[1:] + 4 * middles + ways[:-1]) / 6 * np.diff(z)[:, None]
        places = np.cumsum(np.vstack([(0.0, 0.0, low_mm), steps]), axis=0)
        axis = CubicHermiteSpline(z, places, ways)
        return cls(tilts=tilts, axis=axis, low_mm=low_mm, high_mm=high_mm)

    def points_on_levels(self, z_mm: Float64[np.ndarray, " n"], flat_mm: Points2) -> Points3:
        """Points by the height of their level and their place in its plane."""
        turns = Rotation.from_rotvec(self.tilts(z_mm))
        return self._at(z_mm) + turns.apply(np.column_stack([flat_mm, np.zeros(len(z_mm))]))

    def levels_of(self, points_mm: Points3) -> tuple[Float64[np.ndarray, " n"], Points2]:
        """The height of the level on which each point lies, and its place in that plane.

        Found by going along the axis by how far a point lies off the level: that ends where no
        level meets its neighbour in the body. Where one does, the strain is beyond all bounds.
        """
        z = points_mm[:, 2]
        low, high = float(z.min()), float(z.max())
        for _ in range(_ROUNDS):
            off = np.einsum("nk,nk->n", points_mm - self._at(z), _axis_directions(self.tilts(z)))
            z = np.clip(z + off, 2 * low - high, 2 * high - low)
            if np.abs(off).max(initial=0.0) < _CONVERGED_MM:
                break
        turns = Rotation.from_rotvec(self.tilts(z))
        return z, turns.apply(points_mm - self._at(z), inverse=True)[:, :2]

    def _at(self, z_mm: Float64[np.ndarray, " n"]) -> Points3:
        """Points on the axis; it is straight beyond its ends."""
        held = np.clip(z_mm, self.low_mm, self.high_mm)
        return self.axis(held) + (z_mm - held)[:, None] * _axis_directions(self.tilts(held))


def _axis_directions(turns: Points3) -> Points3:
    """Directions of the axis through tilted levels."""
    return Rotation.from_rotvec(turns).apply((0.0, 0.0, 1.0))
