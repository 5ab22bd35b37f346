"""Template: a rectification that follows landmarks, as it is kept and applied."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.shape.limb import Side
from limbgram.shape.templates.charts import Chart
from limbgram.shape.templates.fields import Field


@dataclass(frozen=True, kw_only=True)
class TemplateMark:
    """A landmark's place on the chart."""

    name: str
    height: float
    angle_deg: float
    """From the front towards the lateral side."""

    @property
    def place(self) -> Chart:
        return np.array([self.height, np.radians(self.angle_deg)])


@dataclass(frozen=True, kw_only=True)
class Template:
    """Displacements along the outward normal over the chart of a limb."""

    name: str
    pairs: int
    """Before-and-after pairs that it was learned from."""
    sided: bool
    """False if made from limbs without side, where +X is called lateral."""
    reference: str
    """Landmark at chart height 1."""
    marks: tuple[TemplateMark, ...]
    heights: Float64[np.ndarray, " h"]
    """Chart heights of the nodes."""
    displacement_mm: Field
    """Positive outwards; 0 where nothing is significant."""
    spread_mm: Field
    """Standard deviation between pairs; NaN where fewer than two pairs know the place."""
    known_pairs: Int64[np.ndarray, "h a"]
    """Pairs that know each node."""

    def suits(self, side: Side) -> bool:
        """Whether a limb of this side has the template's lateral side."""
        return self.sided == (side != "none")
