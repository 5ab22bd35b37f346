"""Kinds of limb, one file each: what is asked of a limb, and what its landmarks mean."""
