"""Write an AOP file for a carver, and say what the format costs."""

from pathlib import Path

import limbgram
from shapes import stump

ready = limbgram.admit(stump(), "left")  # the side is confirmed by whoever looks at the patient
report = limbgram.write_aop(ready, Path("stump.aop"))
print(f"{report.spokes} spokes x {report.slices} slices")
print(f"surface within {report.above_cap_max_mm:.2f} mm, RMS {report.rms_mm:.3f} mm")
print(f"volume {report.volume_change:+.2%}")
