"""Warming up ends in a carver's program that is kept: after its capture, nothing may refuse."""

from pathlib import Path

from limbgram.cli.warm_up import work_on_shape
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth
from limbgram.workbench.limb import Limb


def test_the_shape_of_the_small_capture_goes_as_far_as_a_program(tmp_path: Path) -> None:
    limb = Limb(mesh=stage_truth(SMALL).limb.mesh)
    work_on_shape(limb, tmp_path / "carve.gcode")
    assert (tmp_path / "carve.gcode").read_text("ascii").rstrip().endswith("M30")
