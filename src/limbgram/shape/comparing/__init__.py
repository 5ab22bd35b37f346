"""Comparing: two shapes, or one limb over time."""
