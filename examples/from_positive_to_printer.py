"""Make a socket's shell over a positive: a wall of 4 mm, closed, written and read back as STL."""

from pathlib import Path

import limbgram
from shapes import stump

limb = stump()
wall = limbgram.make_edit("wall", {"thickness_mm": 4.0, "side": "outward"}, "The wall")
socket = limbgram.do_edit(limb, wall)
written = limbgram.write_stl(limbgram.in_limb_frame(socket).mesh, Path("socket.stl"), "mm")
print(written.name, f"{len(socket.mesh.faces):,} triangles")
