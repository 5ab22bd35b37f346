"""Carving: the way of a tool round a turning blank, and the proof of it."""
