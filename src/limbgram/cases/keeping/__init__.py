"""Keeping: products on disk, keyed by what made them."""
