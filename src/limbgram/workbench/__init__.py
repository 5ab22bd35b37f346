"""Workbench: the limb aligned, measured, compared and adjusted."""

from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame, Side

__all__ = ["AlignedLimb", "Landmark", "Limb", "LimbFrame", "Side"]
