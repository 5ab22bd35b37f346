"""Capture: what is done before computing, while the patient is still there.

`coach` says whether photos are good, or which to add and from where, and how sure the surface will
be (`prediction`, on a `proxy` of the limb, from `camera_positions`). `plan` says beforehand
how a limb is photographed so that it becomes as sure as asked. Both use the first stages of a
reconstruction.
"""
