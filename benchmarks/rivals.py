"""Rivals that are installed, on the same photos and the same calibration, each in its own process.

    python benchmarks/rivals.py pycolmap IMAGES CAMERA.json OUT
    python benchmarks/rivals.py sparse IMAGES OUT

pycolmap    features, exhaustive matching, incremental mapping with our lens held; its poses.
sparse      the same with all its defaults and no lens given; its seconds, step by step: what
            cost.py measures the whole of limbgram by.
OpenMVS     where its programs are on the PATH: undistorted photos and poses of pycolmap, then
            densify, reconstruct and refine at its own defaults.
"""

import json
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from harness import described

OPENMVS = ("InterfaceCOLMAP", "DensifyPointCloud", "ReconstructMesh", "RefineMesh")


def installed() -> list[str]:
    """Rivals that can be run here."""
    return ["pycolmap"] + (["openmvs"] if all(map(shutil.which, OPENMVS)) else [])


def run_pycolmap(images: Path, camera_file: Path, out: Path) -> Path:
    """Sparse scene of all photos; returns the folder of its largest model."""
    camera: dict[str, Any] = json.loads(camera_file.read_text())
    lens = camera["parameters"]
    reader = pycolmap.ImageReaderOptions()
    reader.camera_model = "FULL_OPENCV"
    values = [lens["fx"], lens["fy"], lens["cx"] + 0.5, lens["cy"] + 0.5]
    values += [lens[name] for name in ("k1", "k2", "p1", "p2", "k3")] + [0.0, 0.0, 0.0]
    reader.camera_params = ",".join(map(repr, values))
    database = out / "database.db"
    pycolmap.extract_features(
        database, images, camera_mode=pycolmap.CameraMode.SINGLE, reader_options=reader
    )
    pycolmap.match_exhaustive(database)
    options = pycolmap.IncrementalPipelineOptions()
    options.ba_refine_focal_length = False
    options.ba_refine_principal_point = False
    options.ba_refine_extra_params = False
    models = pycolmap.incremental_mapping(database, images, out / "sparse", options)
    if not models:
        raise SystemExit("pycolmap placed no photos")
    best = max(models, key=lambda idx: models[idx].num_reg_images())
    write_poses(models[best], out / "poses.json")
    return out / "sparse" / str(best)


def run_sparse(images: Path, out: Path) -> None:
    """Write sparse.json: seconds of extracting, matching and mapping, and photos placed."""
    database = out / "database.db"
    cpu_s: dict[str, float] = {}
    before_s, start = _cpu_s(), time.perf_counter()

    def spent(step: str) -> None:
        cpu_s[step] = round(_cpu_s() - before_s - sum(cpu_s.values()), 2)

    pycolmap.extract_features(database, images)
    spent("extract")
    pycolmap.match_exhaustive(database)
    spent("match")
    models = pycolmap.incremental_mapping(database, images, out / "sparse")
    spent("map")
    placed = max((model.num_reg_images() for model in models.values()), default=0)
    wall_s = round(time.perf_counter() - start, 2)
    said = {"steps_cpu_s": cpu_s, "sparse_cpu_s": round(sum(cpu_s.values()), 2)}
    (out / "sparse.json").write_text(
        json.dumps(said | {"sparse_wall_s": wall_s, "placed": placed}, indent=1) + "\n"
    )


def _cpu_s() -> float:
    """Of this process and all its threads."""
    spent = os.times()
    return spent.user + spent.system


def write_poses(model: pycolmap.Reconstruction, path: Path) -> None:
    """Poses in the form of our own poses.json; in a frame and scale of its own."""
    poses: list[dict[str, Any]] = []
    for image in model.images.values():
        if image.has_pose:
            pose = image.cam_from_world()
            rotation = np.array(pose.rotation.matrix()).tolist()
            poses.append(
                {"name": image.name, "R": rotation, "t": list(map(float, pose.translation))}
            )
    path.write_text(json.dumps({"images": poses}))


def run_openmvs(images: Path, camera_file: Path, out: Path) -> None:
    """Mesh at OpenMVS's defaults, in the frame and scale of pycolmap's scene."""
    model = run_pycolmap(images, camera_file, out)
    dense = out / "dense"
    pycolmap.undistort_images(dense, model, images)
    steps = (
        ("InterfaceCOLMAP", "-i", str(dense), "-o", "scene.mvs"),
        ("DensifyPointCloud", "scene.mvs"),
        ("ReconstructMesh", "scene_dense.mvs", "-p", "scene_dense.ply"),
        ("RefineMesh", "scene_dense.mvs", "-m", "scene_dense_mesh.ply", "-o", "surface.mvs"),
    )
    for step in steps:
        subprocess.run([*step, "-w", str(out)], check=True, stdout=subprocess.DEVNULL)


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("rival", choices=["pycolmap", "openmvs", "sparse"])
    parser.add_argument("images", type=Path)
    parser.add_argument("camera", type=Path, nargs="?", help="not for sparse")
    parser.add_argument("out", type=Path)
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True)
    if chosen.rival == "sparse":
        run_sparse(chosen.images, chosen.out)
        return
    run = run_pycolmap if chosen.rival == "pycolmap" else run_openmvs
    run(chosen.images, chosen.camera, chosen.out)


if __name__ == "__main__":
    main()
