"""Align a shape and measure it: girths as a taut tape reads them, volume between two heights."""

import limbgram
from shapes import stump

limb = stump()  # of a scan: limbgram.align(limbgram.read_limb(path), limbgram.AlignOptions(...))
options = limbgram.LimbMeasureOptions(spacing_mm=50, volumes_mm=((50.0, 150.0),))
measures = limbgram.measure_limb(limb, options)
for row in measures.rows:
    girth = row.figures["tape_mm"]
    if girth is not None:
        print(f"{row.height_mm:5.0f} mm up: girth {girth.value:.1f} mm")
for one in measures.volumes:
    print(f"from {one.low_mm:.0f} to {one.high_mm:.0f} mm: {one.volume_mm3.value / 1000:.1f} mL")
