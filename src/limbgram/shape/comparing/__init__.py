"""Comparing: two shapes, or one limb over time."""

from limbgram.shape.comparing.comparing import CompareOptions, Comparison, compare
from limbgram.shape.comparing.radial import SpokeOptions
from limbgram.shape.comparing.registration import WAYS, Alignment, IcpOptions, RegistrationOptions
from limbgram.shape.comparing.telling.verdict import IQR_LIMIT_MM, MRE_LIMIT_MM, Verdict, verdict

__all__ = [
    "IQR_LIMIT_MM",
    "MRE_LIMIT_MM",
    "WAYS",
    "Alignment",
    "CompareOptions",
    "Comparison",
    "IcpOptions",
    "RegistrationOptions",
    "SpokeOptions",
    "Verdict",
    "compare",
    "verdict",
]
