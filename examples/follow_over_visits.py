"""Follow a limb over three visits: how fast it shrinks, and how sure that is."""

from datetime import date

import limbgram
from shapes import stump

visits = [
    limbgram.Visit(limb=stump(top_mm=58.0, bottom_mm=50.0), day=date(2026, 3, 2)),
    limbgram.Visit(limb=stump(top_mm=57.6, bottom_mm=49.7), day=date(2026, 3, 16)),
    limbgram.Visit(limb=stump(top_mm=57.2, bottom_mm=49.4), day=date(2026, 3, 30)),
]
series = limbgram.follow(visits)
print(f"{series.change_mm3 / 1000:+.1f} mL, +- {series.change_95_mm3 / 1000:.1f} mL in 95 of 100")
print(series.finding)
