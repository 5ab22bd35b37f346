"""Capture: what is done before computing, while the patient is still there.

`coach` says whether photos are good, or which to add. It uses the first stages of a reconstruction.
"""
