"""Verdict light: green, amber or red, as every verdict says it."""

from typing import Literal

Light = Literal["green", "amber", "red"]
