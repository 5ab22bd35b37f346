"""Marking: where on the limb an edit works: places, heights, curves, and distances over it."""
