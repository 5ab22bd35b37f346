"""Telling: what a comparison means, for people in words and for machines as a tree."""
