"""Capture: what is done before computing, while the patient is still there.

`coach` says whether photos are good, or which to add and from where, and how sure the surface will
be (`prediction`, on a `proxy` of the limb, from `stands`). It uses the first stages of a
reconstruction.
"""
