"""Deliverables: the files of a case for other programs, each written, read back and compared."""

from functools import partial
from pathlib import Path

from limbgram.export import (
    write_cloud_ply,
    write_dxf,
    write_glb,
    write_obj,
    write_ply,
    write_stl,
)
from limbgram.export.colmap import write_colmap, write_poses
from limbgram.pipeline import Reconstruction
from limbgram.report.parts import part_file
from limbgram.run import track


def deliver(done: Reconstruction, folder: Path, *, unscaled: bool) -> tuple[Path, ...]:
    """Write every deliverable into a folder; returns what was written.

    Raises:
        ExportError: a file did not read back as it was written, or there is no scale and
            `unscaled` does not say that this is wanted.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob(part_file("*", "*")):
        old.unlink()  # of a run that found other parts
    mesh, unit = done.mesh, done.metric.scale.unit
    writes = (
        lambda: write_stl(mesh, folder / "surface.stl", unit, unscaled=unscaled),
        lambda: write_dxf(mesh, folder / "surface.dxf", unit, unscaled=unscaled),
        lambda: write_ply(mesh, folder / "surface.ply", unit, unscaled=unscaled),
        lambda: write_obj(mesh, folder / "surface.obj", unit, unscaled=unscaled),
        lambda: write_glb(mesh, folder / "surface.glb", unit, unscaled=unscaled),
        lambda: write_cloud_ply(done.cloud, folder / "cloud.ply", unit, unscaled=unscaled),
        lambda: write_colmap(done.metric, folder / "colmap", unscaled=unscaled),
        lambda: write_poses(done.metric, folder / "poses.json", unscaled=unscaled),
    )
    parts = (
        partial(write, other.mesh, folder / part_file(other.part.number, kind), unit)
        for other in done.others
        if other.mesh is not None
        for kind, write in (("stl", write_stl), ("ply", write_ply))
    )
    return tuple(
        write() for write in track((*writes, *(partial(one, unscaled=unscaled) for one in parts)))
    )
