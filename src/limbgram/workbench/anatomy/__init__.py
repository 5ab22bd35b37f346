"""Anatomy: what landmarks are, what they span, and which kinds of limb there are."""
