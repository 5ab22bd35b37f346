"""Warming up ends in a carver's program that is kept: after its capture, nothing may refuse."""

from pathlib import Path

from limbgram.cli.quality.warm_up import work_on_shape
from limbgram.shape.limb import Limb
from limbgram.synthetic import SMALL, stage_truth


def test_the_shape_of_the_small_capture_goes_as_far_as_a_program(tmp_path: Path) -> None:
    limb = Limb(mesh=stage_truth(SMALL).limb.mesh)
    work_on_shape(limb, tmp_path / "carve.gcode")
    assert (tmp_path / "carve.gcode").read_text("ascii").rstrip().endswith("M30")
