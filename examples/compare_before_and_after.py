"""Two shapes of one limb: how far apart their surfaces lie, and where."""

import numpy as np

import limbgram
from shapes import stump

before, after = stump(), stump(top_mm=56.0)  # the brim is 2 mm smaller in radius
found = limbgram.compare(before, after)
distance = found.deviation.on_first.difference_mm
print(f"{np.nanmin(distance):+.2f} to {np.nanmax(distance):+.2f} mm")
print(found)
