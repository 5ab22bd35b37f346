"""Resampling: other triangles on the same surface."""
