"""Solids: holes filled, walls given, sides swapped."""
