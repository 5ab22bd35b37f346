"""Presets: trims by class name, as data: points at landmarks, measures with their ranges.

Classes and positions of ankle-foot orthoses follow Eddison et al. 2022 (The Foot 53, 101924); the
wall in front of a quadrilateral socket Wheeless' Textbook of Orthopaedics. Ranges are otherwise
general knowledge of the trade, to be set by a clinic, and no advice.
"""
