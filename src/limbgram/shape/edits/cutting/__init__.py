"""Cutting: triangles really split along a plane or a curve."""
