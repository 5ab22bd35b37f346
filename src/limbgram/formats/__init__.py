"""Formats: shapes in and out of files, in millimetres.

Each format has one file, its reader and its writer together. A reader refuses what it cannot be
sure of; a writer reads its file back and compares it before the file takes its name.
"""

from limbgram.formats.aop.cost import AopReport
from limbgram.formats.aop.writing import AopOptions, Own, write_aop
from limbgram.formats.dxf import PolyfaceReport, write_dxf, write_polyface_dxf
from limbgram.formats.gate import admit, in_limb_frame, sure_in_limb_frame
from limbgram.formats.gcode.control import Control
from limbgram.formats.gcode.machine import Machine, read_machine, write_machine
from limbgram.formats.gcode.writing import GcodeReport, write_gcode
from limbgram.formats.glb import write_glb
from limbgram.formats.limb_file import write_limb, write_limb_file
from limbgram.formats.obj import write_obj
from limbgram.formats.ply import write_cloud_ply, write_ply
from limbgram.formats.reading import SUFFIXES, ShapeFile, read_limb, read_shape
from limbgram.formats.stl import write_stl
from limbgram.formats.units import mm_per_unit_of

__all__ = [
    "SUFFIXES",
    "AopOptions",
    "AopReport",
    "Control",
    "GcodeReport",
    "Machine",
    "Own",
    "PolyfaceReport",
    "ShapeFile",
    "admit",
    "in_limb_frame",
    "mm_per_unit_of",
    "read_limb",
    "read_machine",
    "read_shape",
    "sure_in_limb_frame",
    "write_aop",
    "write_cloud_ply",
    "write_dxf",
    "write_gcode",
    "write_glb",
    "write_limb",
    "write_limb_file",
    "write_machine",
    "write_obj",
    "write_ply",
    "write_polyface_dxf",
    "write_stl",
]
