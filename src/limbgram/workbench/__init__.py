"""Workbench: the limb aligned, measured, compared and adjusted."""

from limbgram.workbench.limb import Landmark, Limb, LimbFrame, Side

__all__ = ["Landmark", "Limb", "LimbFrame", "Side"]
