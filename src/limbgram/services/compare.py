"""Compare: two shapes, one limb over time, or repeated captures of an unchanged one.

In      limbs, the first of them the one to compare with; how they are laid on each other.
Out     Comparison, Series or Repeats: differences are second less first.
Fails   MeasureError: the shapes cannot be laid on each other, or share no level. OptionsError: days
        or weights that do not go with the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Annotated

from limbgram.core.errors import OptionsError
from limbgram.core.request_fields import AtMost, Flag, Within
from limbgram.services.parse_text import DAY, WEIGHT
from limbgram.workbench.compare import comparison, over_time
from limbgram.workbench.compare.comparison import CompareOptions, Comparison
from limbgram.workbench.compare.over_time import FollowOptions, Repeats, Series, Visit
from limbgram.workbench.compare.registration import RegistrationOptions, Way
from limbgram.workbench.limb import Limb


@dataclass(frozen=True, kw_only=True)
class CompareRequest:
    """How shapes are laid on each other, and where they are measured."""

    align: Way = "auto"
    """How they are laid on each other; never scaled. auto: as they lie where one was made from the
    other; else by three landmarks or more that both have; else by both alignments, where shape
    alone leaves the place along the axis open; else icp. Repeated captures go by icp."""
    weights: Annotated[
        tuple[Annotated[tuple[str, float], WEIGHT], ...], AtMost(100), Flag("weight")
    ] = ()
    """Weight of a landmark, with --align landmarks: NAME=0.5."""
    brim_mm: Annotated[float, Within(0, 1000), Flag("brim")] = 5.0
    """Strip along open edges left out, mm."""
    spacing_mm: Annotated[float, Within(1, 500), Flag("every")] = 20.0
    """Spacing of the levels, mm."""

    def options(self) -> CompareOptions:
        """As the workbench takes them.

        Raises:
            OptionsError: weights where no landmark is weighed.
        """
        if self.weights and self.align != "landmarks":
            raise OptionsError("options.compare.weight")
        return CompareOptions(
            registration=RegistrationOptions(
                way=self.align, brim_mm=self.brim_mm, landmark_weights=dict(self.weights)
            ),
            spacing_mm=self.spacing_mm,
        )


@dataclass(frozen=True, kw_only=True)
class FollowRequest:
    """What several shapes of one limb are."""

    days: Annotated[tuple[Annotated[date, DAY], ...], Flag("day")] = ()
    """Day of each shape, 2026-03-31, in their order: follow a limb."""
    repeatability_per_cent: Annotated[float, Flag("repeatability")] = 1.0
    """With --day: one standard deviation of a volume, %, taken where scans carry none."""
    repeats: bool = False
    """The shapes are captures of one unchanged limb."""

    def require_for(self, shapes: int) -> None:
        """Refuse what says nothing of so many shapes.

        Raises:
            OptionsError: one shape, days that are not one for each, or more shapes than two that
                are neither.
        """
        if shapes < 2:
            raise OptionsError("options.compare.one_shape")
        if self.repeats and self.days:
            raise OptionsError("options.compare.repeats_and_days")
        if self.days and len(self.days) != shapes:
            raise OptionsError("options.compare.days", days=len(self.days), shapes=shapes)
        if shapes > 2 and not self.days and not self.repeats:
            raise OptionsError("options.compare.kind_missing", shapes=shapes)


def compare(first: Limb, second: Limb, ask: CompareRequest) -> Comparison:
    """Where two shapes differ, by how much, and whether it matters for the fit.

    Raises:
        MeasureError: they cannot be laid on each other, or share no level.
    """
    return comparison.compare(first, second, ask.options())


def follow(
    limbs: Sequence[Limb], ask: CompareRequest, over: FollowRequest
) -> Comparison | Series | Repeats:
    """Several shapes of one limb: over time where days are given, else repeats; two are compared.

    Raises:
        OptionsError: they are said to be nothing, or in contradiction.
        MeasureError: as `compare`.
    """
    over.require_for(len(limbs))
    options = ask.options()
    if over.repeats:
        return over_time.repeats(limbs, options)
    if not over.days:
        return comparison.compare(limbs[0], limbs[1], options)
    visits = [Visit(limb=limb, day=day) for limb, day in zip(limbs, over.days, strict=True)]
    share = over.repeatability_per_cent / 100
    return over_time.follow(visits, FollowOptions(compare=options, assumed_volume_share=share))
