"""Following: one limb over time, and how well scans repeat."""

from limbgram.shape.comparing.following.repeatability import (
    BlandAltman,
    Repeatability,
    bland_altman,
    repeatability,
)
from limbgram.shape.comparing.following.repeats import Repeats, repeats
from limbgram.shape.comparing.following.series import (
    FollowOptions,
    Series,
    Visit,
    follow,
)
from limbgram.shape.comparing.following.trend import Trend, fit_trend

__all__ = [
    "BlandAltman",
    "FollowOptions",
    "Repeatability",
    "Repeats",
    "Series",
    "Trend",
    "Visit",
    "bland_altman",
    "fit_trend",
    "follow",
    "repeatability",
    "repeats",
]
