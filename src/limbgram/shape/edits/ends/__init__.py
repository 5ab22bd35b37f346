"""Ends: the proximal and the distal end of the limb."""
