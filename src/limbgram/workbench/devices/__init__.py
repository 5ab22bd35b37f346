"""Devices: what is worn, made of an aligned positive.

`trims` are the edges of a device as curves on the surface, `thickness` says how thick it is at each
place, `shell` makes the solid of both, `fittings` joins what has sharp edges, `proof` holds the
result against what was asked; `kinds` has one file a device.
"""
