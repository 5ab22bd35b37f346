"""Workshop: limbs on disk, and files for carvers and CAD programs."""

from limbgram.export.workshop.aop import AopOptions, AopReport, Own, write_aop
from limbgram.export.workshop.gate import admit, in_limb_frame, sure_in_limb_frame
from limbgram.export.workshop.gcode import (
    Control,
    GcodeReport,
    Machine,
    read_machine,
    write_gcode,
    write_machine,
)
from limbgram.export.workshop.limb_file import write_limb, write_limb_file
from limbgram.export.workshop.polyface import PolyfaceReport, write_polyface_dxf

__all__ = [
    "AopOptions",
    "AopReport",
    "Control",
    "GcodeReport",
    "Machine",
    "Own",
    "PolyfaceReport",
    "admit",
    "in_limb_frame",
    "read_machine",
    "sure_in_limb_frame",
    "write_aop",
    "write_gcode",
    "write_limb",
    "write_limb_file",
    "write_machine",
    "write_polyface_dxf",
]
