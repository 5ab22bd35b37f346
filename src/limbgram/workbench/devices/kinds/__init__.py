"""Kinds of devices, one file each. Of heads there is none: they are measured, and no more."""
