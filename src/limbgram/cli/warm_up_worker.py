"""Warm-up worker: the second process of `limbgram warm-up`; it compiles the later stages.

In      the folder in which the first process writes its capture, and one to write into.
Out     compiled code in the cache that both share.
Method  inputs from the truth instead of earlier stages: the limb's vertices as the cloud, the true
        views as the scene, and the photos as soon as they exist.
Fails   as the stages do, or if the capture never appears: then the first compiles the rest.
Runs as `python -P -m limbgram.cli.warm_up_worker CAPTURE FOLDER`.
"""

import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool

from limbgram.capture.closed_surface import closed_surface
from limbgram.core.errors import EditError
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.run import Run
from limbgram.formats.dxf_r12 import write_polyface_dxf
from limbgram.formats.gcode.writing import write_gcode
from limbgram.reconstruction.mapping.scene import Observations, PhotoVerdict, Scene
from limbgram.reconstruction.matching.windows import build_pyramid, follow
from limbgram.reconstruction.measuring.measurement import measure
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.reconstruction.surface.parts import tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.reconstruction.surface.repair import repair
from limbgram.synthetic.options import SMALL, CaptureOptions
from limbgram.synthetic.truth import Truth, stage_truth
from limbgram.workbench.carving.setup import CarveOptions
from limbgram.workbench.edits.edit import name_of
from limbgram.workbench.edits.editing import EDITS, do_edit
from limbgram.workbench.edits.offset import offset
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.relieve import Relieve
from limbgram.workbench.edits.thickness import wall_thickness
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.geodesic import shortest_path
from limbgram.workbench.measures.measuring import measure_limb
from limbgram.workbench.recipe.file import make_edit

CAPTURE = replace(SMALL, photos=14, samples=2, mesh_step_mm=1.8)
"""The smallest capture that passes all stages."""
_LOOK_S = 0.2
_LONGEST_S = 120.0
"""Timeout for the capture to appear."""
_EDGE_MM = 1.6


def compile_later_stages(
    capture: Path, folder: Path, run: Run, options: CaptureOptions = CAPTURE
) -> Mesh | None:
    """Compile surface, measurement and workbench; returns the surface if it was measured."""
    truth = stage_truth(options)
    scene = _scene(truth)
    cloud = _cloud(truth.limb.mesh, truth.limb.cut, options.mesh_step_mm)
    wrapped = run(pivot, cloud)
    parts = run(tell_parts, wrapped, cloud, scene.scene.views)
    even = run(refine, run(repair, parts, cloud), _EDGE_MM)
    measured = None
    if _appears(capture):
        photos = run(read_photos, (capture / "images",))
        measured = run(measure, photos, scene, even)
    run(work_on_shape, Limb(mesh=truth.limb.mesh), folder / "ahead.gcode")
    return measured


def work_on_shape(limb: Limb, program: Path) -> None:
    """Run what the workbench compiles."""
    up = np.array([0.0, 0.0, 1.0])
    limb = align(limb, AlignOptions(side="none", axis=up, anterior=np.array([0.0, 1.0, 0.0])))
    offset(limb.mesh, -0.5)
    near, far = limb.mesh.vertices_mm[limb.mesh.faces[0, [0, 1]]]
    shortest_path(limb.mesh, near, far)
    middle_mm = float(np.ptp(limb.mesh.vertices_mm[:, 2])) / 2
    PlaneCut(height_mm=middle_mm, capped=True).apply(limb)
    measure_limb(limb)
    wall_thickness(limb.mesh)
    _edit_in_every_way(PlaneCut(height_mm=middle_mm).apply(limb))
    write_gcode(limb, program, CarveOptions(scallop_mm=0.5, tolerance_mm=0.04))
    write_polyface_dxf(limb.mesh, program.with_suffix(".dxf"))
    few = slice(None, None, 50)
    closed_surface(limb.mesh.vertices_mm[few], limb.mesh.vertex_normals()[few])
    _follow()


def _edit_in_every_way(limb: Limb) -> None:
    """Apply the example of each edit; edits that this limb refuses are skipped."""
    place = limb.aligned().mesh_in_limb.vertices_mm[limb.mesh.faces[0, 0]]
    x, y, z = place.tolist()
    do_edit(limb, Relieve(at=(x, y, z), depth_mm=4.0, falloff_mm=20.0))
    for kind in EDITS:
        with suppress(EditError):
            do_edit(limb, make_edit(name_of(kind), kind.about.example, "warm-up"))


def _follow() -> None:
    """Track a point between photos, which the small photos of the capture do not need."""
    noise = np.random.default_rng(1).integers(0, 256, (128, 128), dtype=np.uint8)
    photo, expected = build_pyramid(noise), np.array([[64.0, 1.0, 0.0, 64.0, 0.0, 1.0]])
    follow(photo, photo, expected[:, [0, 3]], expected)


def _appears(capture: Path) -> bool:
    """Wait for the capture, which is written atomically; False on timeout."""
    give_up = time.monotonic() + _LONGEST_S
    while not capture.is_dir() and time.monotonic() < give_up:
        time.sleep(_LOOK_S)
    return capture.is_dir()


def _cloud(limb: Mesh, cut: Bool[np.ndarray, " n"], step_mm: float) -> Cloud:
    """The skin's vertices as a cloud, as if fused from depth maps."""
    skin = np.flatnonzero(~cut)
    normals = limb.vertex_normals()[skin]
    return Cloud(
        points_mm=limb.vertices_mm[skin].astype(np.float32),
        normals=normals.astype(np.float32),
        colours=np.full((len(skin), 3), 128, np.uint8),
        views=np.full(len(skin), 3, np.uint16),
        spacing_mm=step_mm,
    )


def _scene(truth: Truth) -> MetricScene:
    """The true cameras as a scene, with a small covariance."""
    names = tuple(view.name for view in truth.views)
    numbers = POSE_SIZE * len(names) + LENS_SIZE
    scene = Scene(
        names=names,
        cameras=(truth.views[0].camera,),
        camera_idx=(0,) * len(names),
        camera_from_world=tuple(view.camera_from_world for view in truth.views),
        points_in_world=truth.limb.mesh.vertices_mm[:1],
        observations=Observations(
            np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, 2), float)
        ),
        verdicts=tuple(
            PhotoVerdict(name=name, placed=True, points=0, rms_px=0.0) for name in names
        ),
        camera_covariance=1e-8 * np.eye(numbers),
    )
    scale = Scale(unit="mm", source="board", relative_sigma=1e-4, by_cameras=np.zeros(numbers))
    return MetricScene(scene=scene, scale=scale, floor_z_mm=0.0)


def main() -> None:
    capture, folder = map(Path, sys.argv[1:])
    compile_later_stages(capture, folder, Run())


if __name__ == "__main__":
    main()
