"""Formats: its names, each imported when it is first used."""

from .aop.cost import AopReport
from .aop.writing import AopOptions, SourceGrid, write_aop
from .dxf import write_dxf
from .dxf_r12 import PolyfaceReport, write_polyface_dxf, write_r12_dxf
from .export_checks import admit, in_limb_frame, sure_in_limb_frame
from .gcode.control import Control
from .gcode.machine import Machine, read_machine, write_machine
from .gcode.writing import GcodeReport, write_gcode
from .glb import write_glb
from .limb_file import write_limb, write_limb_file
from .obj import write_obj
from .ply import write_cloud_ply, write_ply
from .reading import SUFFIXES, ShapeFile, read_limb, read_shape
from .stl import write_stl
from .threemf import write_3mf
from .units import mm_per_unit_of
from .vtp import write_vtp

__all__ = [
    "SUFFIXES",
    "AopOptions",
    "AopReport",
    "Control",
    "GcodeReport",
    "Machine",
    "PolyfaceReport",
    "ShapeFile",
    "SourceGrid",
    "admit",
    "in_limb_frame",
    "mm_per_unit_of",
    "read_limb",
    "read_machine",
    "read_shape",
    "sure_in_limb_frame",
    "write_3mf",
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
    "write_r12_dxf",
    "write_stl",
    "write_vtp",
]
