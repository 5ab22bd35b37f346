"""A program for a small mill with Grbl, whose Y turns: tried line by line before it is kept."""

from pathlib import Path

import limbgram
from limbgram.core.errors import LimbgramError
from limbgram.workbench.carving.setup import FAST
from shapes import stump

carving = limbgram.CarveOptions(**FAST)
control = limbgram.Control(dialect="grbl")
report = limbgram.write_gcode(stump(), Path("stump.nc"), carving, control)
print(f"{report.lines} lines, {control.letter} from {report.rotary_deg[0]:.0f} degrees")
print(f"into the shape by {report.check.gouge_mm:.3f} mm at most")
try:
    mist = limbgram.Control(dialect="grbl", coolant="mist")
    limbgram.write_gcode(stump(), Path("mist.nc"), carving, mist)
except LimbgramError as refused:
    print(f"Refused: {refused}")
