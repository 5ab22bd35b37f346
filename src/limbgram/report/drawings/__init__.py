"""Drawings: one figure each, from products."""
