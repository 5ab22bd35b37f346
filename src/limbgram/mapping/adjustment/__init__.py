"""The final adjustment of photos, lenses and points, with the calibration as a prior."""

from limbgram.mapping.adjustment.body import Body
from limbgram.mapping.adjustment.solution import Adjusted, adjust

__all__ = ["Adjusted", "Body", "adjust"]
