"""Deliverables: the files of a case for other programs, each written, read back and compared."""

from pathlib import Path

from limbgram.export import (
    write_cloud_ply,
    write_colmap,
    write_dxf,
    write_glb,
    write_obj,
    write_ply,
    write_poses,
    write_stl,
)
from limbgram.pipeline import Reconstruction
from limbgram.run import track


def deliver(done: Reconstruction, folder: Path, *, unscaled: bool) -> tuple[Path, ...]:
    """Write every deliverable into a folder; returns what was written.

    Raises:
        ExportError: a file did not read back as it was written, or there is no scale and
            `unscaled` does not say that this is wanted.
    """
    folder.mkdir(parents=True, exist_ok=True)
    mesh, scale = done.mesh, done.metric.scale
    writes = (
        lambda: write_stl(mesh, folder / "surface.stl", scale, unscaled=unscaled),
        lambda: write_dxf(mesh, folder / "surface.dxf", scale, unscaled=unscaled),
        lambda: write_ply(mesh, folder / "surface.ply", scale, unscaled=unscaled),
        lambda: write_obj(mesh, folder / "surface.obj", scale, unscaled=unscaled),
        lambda: write_glb(mesh, folder / "surface.glb", scale, unscaled=unscaled),
        lambda: write_cloud_ply(done.cloud, folder / "cloud.ply", scale, unscaled=unscaled),
        lambda: write_colmap(done.metric, folder / "colmap", unscaled=unscaled),
        lambda: write_poses(done.metric, folder / "poses.json", unscaled=unscaled),
    )
    return tuple(write() for write in track(writes))
