"""Each vertex's standard deviation where other programs show it: PLY, VTP, and trimesh."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import limbgram
from shapes import stump

mesh = stump().mesh
height = mesh.vertices_mm[:, 2]
mesh = replace(mesh, sigma_mm=(0.05 + 0.001 * height).astype(np.float32))  # as of a real scan
limbgram.write_ply(mesh, Path("sigma.ply"), "mm")  # for CloudCompare and MeshLab
limbgram.write_vtp(mesh, Path("sigma.vtp"), "mm")  # point data sigma_mm for ParaView
print(mesh)
print(mesh.to_trimesh().vertex_attributes["sigma_mm"].max())
print(limbgram.read_limb("sigma.ply").mesh.sigma_mm[:3])
