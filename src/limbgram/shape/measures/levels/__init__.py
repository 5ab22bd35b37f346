"""Levels: what is measured at one height, and between two."""
