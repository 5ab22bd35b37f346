"""Deliverables: the files of a case for other programs, each written, read back and compared."""

from functools import partial
from pathlib import Path

from limbgram.core.run import track
from limbgram.formats.colmap import write_colmap, write_poses
from limbgram.formats.export_checks import require_unfolded
from limbgram.formats.ply import write_cloud_ply, write_ply
from limbgram.formats.stl import write_stl
from limbgram.formats.table import FORMATS
from limbgram.formats.transforms import write_transforms
from limbgram.reconstruction.mapping.colours import point_colours
from limbgram.reconstruction.pipeline import Reconstruction
from limbgram.report.parts import part_file
from limbgram.workbench.limb import marked_red


def surface_of(folder: Path, suffix: str = ".ply") -> Path:
    """The delivered surface; its name depends on the verdict."""
    plain = folder / f"surface{suffix}"
    red = marked_red(plain)
    return red if red.is_file() and not plain.is_file() else plain


def deliver(
    done: Reconstruction, folder: Path, *, unscaled: bool, red: bool = False
) -> tuple[Path, ...]:
    """Write every deliverable into a folder; returns what was written.

    Files leave the case by mail or on the way to a carver, and keep their names: so the name tells
    a red result, `surface-RED.stl`, not a note beside the file.

    Raises:
        ExportError: a surface folds over or through itself, a file did not read back as it was
            written, or there is no scale and `unscaled` does not say that this is wanted.
    """
    for surface in (done.mesh, *(one.mesh for one in done.others if one.mesh is not None)):
        require_unfolded(surface)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob(part_file("*", "*")):
        old.unlink()  # an earlier run may have found other parts
    mesh, unit = done.mesh, done.metric.scale.unit

    def named(name: str) -> Path:
        return marked_red(folder / name) if red else folder / name

    writes = (
        *(
            partial(one.write, mesh, named(f"surface{one.suffix}"), unit, unscaled=unscaled)
            for one in FORMATS
            if one.write is not None
        ),
        lambda: write_cloud_ply(done.cloud, named("cloud.ply"), unit, unscaled=unscaled),
        lambda: write_colmap(
            done.metric,
            folder / "colmap",
            colours=point_colours(done.photos, done.metric.scene),
            unscaled=unscaled,
        ),
        lambda: write_transforms(
            done.metric, folder / "transforms.json", "../photos", unscaled=unscaled
        ),
        lambda: write_poses(done.metric, folder / "poses.json", unscaled=unscaled),
    )
    parts = (
        partial(write, other.mesh, named(part_file(other.part.number, kind)), unit)
        for other in done.others
        if other.mesh is not None
        for kind, write in (("stl", write_stl), ("ply", write_ply))
    )
    return tuple(
        write() for write in track((*writes, *(partial(one, unscaled=unscaled) for one in parts)))
    )
