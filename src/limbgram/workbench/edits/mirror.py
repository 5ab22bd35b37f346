"""Mirror: left and right swapped."""

from dataclasses import replace
from typing import Literal

import numpy as np

from limbgram.core.errors import EditError
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import moved_by, require_aligned
from limbgram.workbench.limb import Limb


@edit(
    group="solids",
    order=3,
    effect=Effect(reports_displacement=False, start="follows"),
    guarded=False,
    example={"confirmed_side": "right"},
)
class Mirror(Edit):
    """Swap left and right."""

    confirmed_side: Literal["left", "right"]
    """The side that the limb is of afterwards: said here so that no mirror happens unnoticed."""

    words = spoken(
        en=Words(name="Mirror", title="The mirror", labels={"confirmed_side": "Side afterwards"}),
        de=Words(
            name="Spiegeln",
            title="Das Spiegeln",
            does="Links und rechts vertauschen.",
            labels={"confirmed_side": "Seite danach"},
            help={
                "confirmed_side": "Die Seite, zu der das Gliedmaß danach gehört: hier gesagt, "
                "damit nicht unbemerkt gespiegelt wird."
            },
            choices={"left": "links", "right": "rechts"},
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Reflect the limb in its own plane of left and right; landmarks and side go with it.

        Raises:
            EditError: the limb is not aligned, has no side, or has the confirmed side already.
        """
        aligned = require_aligned(limb)
        frame = aligned.frame
        if frame.side == "none":
            raise EditError("edit.mirror.no_side")
        if frame.side == self.confirmed_side:
            raise EditError(
                "edit.mirror.side",
                side=frame.side,
                other="left" if frame.side == "right" else "right",
            )
        motion, back = frame.limb_from_mesh, frame.limb_from_mesh.inverse
        flip = np.array([-1.0, 1.0, 1.0])
        turn = ((motion.rotation.T * flip) @ motion.rotation).astype(np.float32)

        def reflected(points: np.ndarray) -> np.ndarray:
            return moved_by(back, moved_by(motion, points) * flip)

        mesh = replace(
            limb.mesh,
            vertices_mm=reflected(limb.mesh.vertices_mm),
            faces=np.ascontiguousarray(limb.mesh.faces[:, ::-1]),
            **limb.mesh.of_vertices(lambda one, values: values @ turn if one.axis else values),
        )
        marks = tuple(
            replace(mark, position_mm=reflected(mark.position_mm[None])[0])
            for mark in limb.landmarks
        )
        framed = replace(frame, side=self.confirmed_side)
        return replace(aligned, mesh=mesh, landmarks=marks, frame=framed)
