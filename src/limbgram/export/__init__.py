"""Export: files for other programs, each read back and compared before it takes its name."""

from limbgram.export.dxf import write_dxf
from limbgram.export.gltf import write_glb
from limbgram.export.obj import write_obj
from limbgram.export.ply import write_cloud_ply, write_ply
from limbgram.export.stl import write_stl

__all__ = [
    "write_cloud_ply",
    "write_dxf",
    "write_glb",
    "write_obj",
    "write_ply",
    "write_stl",
]
