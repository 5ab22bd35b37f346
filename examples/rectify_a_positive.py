"""Adjust a positive by a recipe: room over bone, pressure on the tendon, and what needs a word."""

import limbgram
from shapes import stump

limb = stump()
recipe = limbgram.Recipe(name="first fitting")


def with_edit(recipe: limbgram.Recipe, kind: str, **parameters: object) -> limbgram.Recipe:
    return limbgram.added(recipe, limbgram.make_edit(kind, parameters, "The new edit"))


# relieve builds the positive up and gives room; load carves it in and presses.
recipe = with_edit(recipe, "relieve", at="fibula head", depth_mm=3.0, falloff_mm=18.0)
recipe = with_edit(recipe, "load", at="patellar tendon", depth_mm=4.0, falloff_mm=20.0)
done = limbgram.replay(recipe, limb)
for line in done.ledger.lines:
    change_ml = 0.0 if line.volume is None else line.volume.after_ml - line.volume.before_ml
    print(f"{line.edit}: {change_ml:+.1f} mL")

# A load on a nerve is done only if somebody says that it is meant.
try:
    with_edit(recipe, "load", at="fibula head", depth_mm=2.0, falloff_mm=12.0)
except limbgram.LimbgramError as refused:
    print("Refused:", refused)
