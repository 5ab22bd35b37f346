"""How sure the measured surface is: a sigma per vertex, and what all vertices share."""

from limbgram.measuring.uncertainty.sigma import CAMERAS, OFFSET, SCALE, with_sigma

__all__ = ["CAMERAS", "OFFSET", "SCALE", "with_sigma"]
