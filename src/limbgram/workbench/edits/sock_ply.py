"""Sock plies: the shape made larger or smaller by what socks take up.

One ply is about 1.1 % of volume: J. Sanders et al., J Rehabil Res Dev 49(4), 2012.
"""

from typing import Annotated

from limbgram.core.request_fields import Within
from limbgram.workbench.edits.edit import RESIDUAL_LIMBS, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.increase import Increase
from limbgram.workbench.edits.levels import change_by_levels
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.limb import Limb

PLY_VOLUME_PER_CENT = 1.1


@edit(
    group="levels",
    order=4,
    effect=Effect(moves_skin=True),
    kinds=RESIDUAL_LIMBS,
    example={"plies": 2.0},
)
class SockPly(Edit):
    """Make the shape larger by sock plies of 1.1 % of volume each, or smaller by negative ones."""

    plies: Annotated[float, Within(-20, 20)]
    """How many; negative ones make it smaller."""

    words = spoken(
        en=Words(name="By sock plies", title="The change by sock plies"),
        de=Words(
            name="Nach Strumpflagen",
            title="Die Änderung nach Strumpflagen",
            does="Die Form um Strumpflagen von je 1,1 % des Volumens größer machen, mit negativen "
            "kleiner.",
            labels={"plies": "Lagen"},
            help={"plies": "Wie viele; negative machen kleiner."},
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Change the volume of every section by plies."""
        per_cent = (PLY_VOLUME_PER_CENT * abs(self.plies),)
        if self.plies < 0:
            less = Reduction(heights_mm=(0.0,), per_cent=per_cent, of="volume")
            return change_by_levels(limb, less, -1.0)
        more = Increase(heights_mm=(0.0,), per_cent=per_cent, of="volume")
        return change_by_levels(limb, more, 1.0)
