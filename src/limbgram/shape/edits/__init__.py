"""Edits: one function an operation, mesh to mesh."""
