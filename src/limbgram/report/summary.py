"""The summary: the figures of a case for machines, and its verdict for people.

In      the products of one reconstruction, its accuracy, what each stage cost.
Out     a JSON tree (SCHEMA) that the page shows and `summary.json` keeps.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Timing
from limbgram.reconstruction.mapping.scene import PhotoVerdict
from limbgram.reconstruction.photos.photo import PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import remarks
from limbgram.reconstruction.pipeline import Reconstruction
from limbgram.reconstruction.scale.metric import Scale
from limbgram.report.document.page import finite
from limbgram.report.drawings.charts import image_scales
from limbgram.report.parts import parts_tree
from limbgram.workbench.limb import marked_red

SCHEMA = "limbgram-summary/2"
MOST_LEFT_OUT = 0.05
"""Of the surface: what it lacks of itself beyond this part is told below the verdict."""

INTENDED_USE = (
    "limbgram measures the outer shape of a limb or a model of it. It is not a cleared medical "
    "device: a qualified professional verifies dimensions before anything is made from them."
)

Json = dict[str, Any]


def summarise(
    done: Reconstruction, assessed: Json, timings: Sequence[Timing], reused: Sequence[str] = ()
) -> Json:
    """Everything that can be said of a reconstruction in figures; NaN becomes None.

    Args:
        assessed: The tree of its accuracy: the verdict is that one's, word by word.
    """
    scene, scale = done.metric.scene, done.metric.scale
    residuals = scene.residuals_px()
    tree: Json = {
        "schema": SCHEMA,
        "verdict": {
            "light": assessed["light"],
            "headline": assessed["headline"],
            "reasons": assessed["reasons"],
            "facts": facts(
                scale,
                scene.verdicts,
                done.photos.set_aside,
                left_out_share(done.mesh),
                len(done.others),
            ),
        },
        "intended_use": INTENDED_USE,
        "unit": scale.unit,
        "scale": _scale(scale),
        "photos": _photos(done),
        "set_aside": [asdict(part) for part in (*done.photos.set_aside, *scale.set_aside)],
        "cameras": [
            {"label": one.label, "source": one.source, **asdict(camera)}
            for one, camera in zip(done.cameras.calibrations, scene.cameras, strict=True)
        ],
        "matches": {
            "pairs_tried": done.matches.pairs_tried,
            "before_correlation": done.matches.descriptor_matches,
            "after_correlation": sum(len(pair) for pair in done.matches.pairs),
            "verified_pairs": len(done.pairs.verified),
            "verified": sum(len(pair.matches) for pair in done.pairs.verified),
        },
        "scene": {
            "placed": len(scene.placed),
            "points": len(scene.points_in_world),
            "observations": len(scene.observations.xy_px),
            "rms_px": float(np.sqrt(np.nanmean(residuals**2))),
        },
        "image_scale": [asdict(one) for one in image_scales(done.photos, done.metric)],
        "cloud": {"points": len(done.cloud), "spacing": done.cloud.spacing_mm},
        "resolution": asdict(done.resolution),
        "mesh": mesh_figures(done.mesh),
        "parts": _named(parts_tree(done), assessed["light"]),
        "stages": [
            {**asdict(timing), "reused": name in reused}
            for name, timing in zip(_kept_names(timings), timings, strict=True)
        ],
    }
    return finite(tree)


def _named(parts: list[Json], light: str) -> list[Json]:
    """Files of a red result have its mark in their names."""
    return [
        {**part, "file": marked_red(Path(part["file"])).name}
        if light == "red" and part["file"]
        else part
        for part in parts
    ]


def _kept_names(timings: Sequence[Timing]) -> list[str]:
    """Under which name each stage's product is kept: a second part's repair is `repair-2`."""
    names: list[str] = []
    for k, timing in enumerate(timings):
        before = sum(one.stage == timing.stage for one in timings[:k])
        names.append(timing.stage.replace(" ", "_") + f"-{before + 1}" * (before > 0))
    return names


def facts(
    scale: Scale,
    verdicts: Sequence[PhotoVerdict],
    set_aside: Sequence[SetAside],
    left_out: float = 0.0,
    others: int = 0,
) -> str:
    """The line below the verdict: scale, its check, photos placed, what was left out."""
    placed = sum(verdict.placed for verdict in verdicts)
    parts = [_scale_sentence(scale), f"{placed} of {len(verdicts)} photos placed"]
    if set_aside:
        plural = "file was" if len(set_aside) == 1 else "files were"
        parts.append(f"{len(set_aside)} {plural} set aside")
    if left_out > MOST_LEFT_OUT:
        parts.append(
            f"{left_out:.0%} of the measured surface was torn off or in crumbs, and is not in it: "
            "look whether the wanted side is there"
        )
    if others:
        plural = "body is" if others == 1 else "bodies are"
        parts.append(f"{others} other {plural} kept in files of their own (see the parts)")
    return "; ".join(parts) + "."


def left_out_share(mesh: Mesh) -> float:
    """What the surface lacks of itself though it was measured, as a part of its area."""
    return 0.0 if mesh.repairs is None else mesh.repairs.island_share


def _scale_sentence(scale: Scale) -> str:
    if scale.unit == "unitless":
        return "NO SCALE: the size of this surface is not known"
    source = "the board" if scale.source == "board" else "known distances"
    checks = [length for length in scale.lengths if length.role == "check"]
    if not checks:
        return f"Millimetres by {source}, not checked by any other length"
    worst = max(checks, key=lambda length: abs(length.error))
    rms = math.sqrt(sum(length.error**2 for length in checks) / len(checks))
    return (
        f"Millimetres by {source}, checked on {len(checks)} other lengths: they agree to "
        f"{rms:.3%} (worst {abs(worst.error):.3%}, {worst.label})"
    )


def mesh_figures(mesh: Mesh) -> Json:
    """Size of a mesh; the volume counts where the surface is closed."""
    normals = mesh.face_normals()
    first = mesh.vertices_mm[mesh.faces[:, 0]]
    size = np.ptp(mesh.vertices_mm, axis=0)
    return {
        "vertices": len(mesh),
        "faces": len(mesh.faces),
        "size": [float(side) for side in size],
        "area": float(np.linalg.norm(normals, axis=1).sum() / 2),
        "volume": float(np.einsum("fc,fc->", first, normals) / 6) if is_closed(mesh) else None,
        "left_out_share": left_out_share(mesh),
        "filled_share": 0.0 if mesh.filled is None else float(mesh.filled.mean()),
        "open_edges": open_edges(mesh),
    }


def is_closed(mesh: Mesh) -> bool:
    return open_edges(mesh) == 0


def open_edges(mesh: Mesh) -> int:
    """Edges that do not have exactly two faces."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
    _, counts = np.unique(edges[:, 0] * len(mesh) + edges[:, 1], return_counts=True)
    return int((counts != 2).sum())


def _scale(scale: Scale) -> Json:
    return {
        "source": scale.source,
        "relative_sigma": scale.relative_sigma,
        "lengths": [{**asdict(length), "error": length.error} for length in scale.lengths],
    }


def _photos(done: Reconstruction) -> list[Json]:
    said = _remarks(done.photos)
    return [
        {
            "name": photo.name,
            "placed": verdict.placed,
            "points": verdict.points,
            "rms_px": verdict.rms_px,
            "reason": verdict.reason,
            "remarks": said.get(photo.name, []),
            "features": len(keypoints),
            "edge_width_px": photo.sharpness,
        }
        for photo, verdict, keypoints in zip(
            done.photos.photos,
            done.metric.scene.verdicts,
            done.features.keypoints,
            strict=True,
        )
    ]


def _remarks(photos: PhotoSet) -> dict[str, list[str]]:
    said: dict[str, list[str]] = {}
    for remark in remarks(photos):
        said.setdefault(remark.name, []).append(remark.text)
    return said
