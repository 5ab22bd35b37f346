"""Compare: two shapes, or one limb over time."""

from limbgram.workbench.compare.comparison import CompareOptions, Comparison, compare
from limbgram.workbench.compare.icp import IcpOptions
from limbgram.workbench.compare.messages import IQR_LIMIT_MM, MRE_LIMIT_MM, Verdict, verdict
from limbgram.workbench.compare.registration import WAYS, Alignment, RegistrationOptions

__all__ = [
    "IQR_LIMIT_MM",
    "MRE_LIMIT_MM",
    "WAYS",
    "Alignment",
    "CompareOptions",
    "Comparison",
    "IcpOptions",
    "RegistrationOptions",
    "Verdict",
    "compare",
    "verdict",
]
