"""Measures: girths, widths, areas, volumes, lengths, with their uncertainty."""
