"""Spine: a trunk shifted and turned by level, the pelvis staying, as a positive is corrected.

In      an aligned trunk; heights, and how far each level is shifted and turned.
Out     the trunk with its levels moved; landmarks go with them.
Method  Cubic curves through the levels with the slopes of PCHIP, level at both ends, nothing below
        the first. A section stays in its plane: half the turn, the shift, half the turn. So the
        same edit with opposite signs brings the shape back exactly.
Fails   EditError: the lists differ in length, heights do not rise, or the strain is beyond what is
        done.
"""

from dataclasses import replace
from typing import Annotated

import numpy as np
from jaxtyping import Float64
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from limbgram.core.errors import EditError
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
from limbgram.workbench.edits.repose import MOST_STRAIN, MOST_STRAIN_ACCEPTED, largest_strain
from limbgram.workbench.limb import Limb

ShiftMm = Annotated[float, Within(-60, 60)]
TurnDeg = Annotated[float, Within(-30, 30)]


@edit(
    group="orthosis",
    order=3,
    effect=Effect(reports_displacement=False, start="follows"),
    kinds=("torso",),
    example={"heights_mm": (50.0, 150.0, 300.0), "right_mm": (0.0, 10.0, 0.0)},
)
class Spine(Edit):
    """Shift and turn a trunk by level, as a positive is corrected; the pelvis stays."""

    heights_mm: tuple[float, ...]
    """Of the levels, rising; the first one and all below stay as they are."""
    right_mm: tuple[ShiftMm, ...] = ()
    """To the patient's right, by level."""
    forward_mm: tuple[ShiftMm, ...] = ()
    """Forwards, by level."""
    turn_deg: tuple[TurnDeg, ...] = ()
    """About the long axis, right side forwards, by level."""
    above: str = ""
    """Landmark from which heights count; without it from the limb's origin."""
    beyond: bool = False
    """Somebody means a strain of more than 25 per cent."""

    words = spoken(
        en=Words(name="Shift and turn by level", title="The correction by level"),
        de=Words(
            name="Nach Höhe verschieben und drehen",
            title="Die Korrektur nach Höhe",
            does="Einen Rumpf nach Höhe verschieben und drehen, wie man ein Positiv korrigiert; "
            "das Becken bleibt.",
            labels={
                "heights_mm": "Höhen",
                "right_mm": "Nach rechts",
                "forward_mm": "Nach vorn",
                "turn_deg": "Drehung",
                "above": "Über",
                "beyond": "Gewollt",
            },
            help={
                "heights_mm": "Der Ebenen, steigend; die erste und alles darunter bleiben.",
                "right_mm": "Zur rechten Seite des Patienten, je Ebene.",
                "forward_mm": "Nach vorn, je Ebene.",
                "turn_deg": "Um die Längsachse, rechte Seite nach vorn, je Ebene.",
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
        lists = [one for one in (self.right_mm, self.forward_mm, self.turn_deg) if one]
        rising = all(low < high for low, high in zip(self.heights_mm, self.heights_mm[1:]))
        if len(self.heights_mm) < 2 or not rising or not lists:
            raise EditError("edit.spine.heights")
        if any(len(one) != len(self.heights_mm) or one[0] != 0 for one in lists):
            raise EditError("edit.spine.lists", levels=len(self.heights_mm))

    def apply(self, limb: Limb) -> Limb:
        """Move the levels, and tell how far the surface was strained.

        Raises:
            EditError: the limb is not aligned, or the strain is beyond what is done.
        """
        aligned = require_aligned(limb)
        base = height_mm(limb, 0.0, self.above)
        points = points_in_limb_frame(limb)
        z = points[:, 2] - base
        half = np.radians(self._at(self.turn_deg, z)) / 2
        shift = np.column_stack([self._at(self.right_mm, z), self._at(self.forward_mm, z)])
        flat = _turned(_turned(points[:, :2], half) + shift, half)
        after = np.column_stack([flat, points[:, 2]])
        back = moved_by(aligned.limb_from_mesh.inverse, after)
        strain = largest_strain(limb.mesh.faces, limb.mesh.vertices_mm, back)
        if strain > (MOST_STRAIN_ACCEPTED if self.beyond else MOST_STRAIN):
            raise EditError("edit.spine.strain", strain=strain, most=MOST_STRAIN)
        moved = displaced(limb, back)
        return replace(moved, notes=(*moved.notes, note("edit.spine.done", strain=strain)))

    def _at(
        self, values: tuple[float, ...], z_mm: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, " n"]:
        """A fair curve through the levels; beyond the last it goes on level."""
        if not values:
            return np.zeros(len(z_mm))
        held = np.clip(z_mm, self.heights_mm[0], self.heights_mm[-1])
        slopes = np.asarray(
            PchipInterpolator(self.heights_mm, values).derivative()(self.heights_mm)
        )
        slopes[[0, -1]] = 0.0  # it leaves the pelvis without a bend
        return np.asarray(CubicHermiteSpline(self.heights_mm, values, slopes)(held))


def _turned(
    points: Float64[np.ndarray, "n 2"], angles_rad: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, "n 2"]:
    x, y = points.T
    cosine, sine = np.cos(angles_rad), np.sin(angles_rad)
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
