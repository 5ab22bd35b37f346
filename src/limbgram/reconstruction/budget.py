"""Budget: image resolutions of depth and measurement, chosen to fit the memory.

In      the photos, the scene and the surface found in it; the memory that may be used.
Out     how many pixels depth is measured at, and the Resolution of the surface.
Method  peaks told beforehand from counts and pixels, by sums that were measured on captures of 8 to
        60 photos of 1 to 48 MP (docs/method/speed.md). How much is worked on at a time follows the
        budget by itself (`run.in_parallel`) and changes nothing; what is decided here changes the
        result, so it depends on nothing but the options, the capture and the budget, and is told.
Fails   BudgetError: the smallest size, too, needs more. It is raised before the work.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32

from limbgram.core.errors import BudgetError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import PROGRAM_MB
from limbgram.findings import Finding, note
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.measuring.imagery import imagery_mb
from limbgram.reconstruction.photos.decoding import in_flight_mb
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.targets.board_detection import SEARCH_BYTES

_EQUILATERAL = 3**0.5 / 4
"""Area of an equilateral triangle over its squared side."""
_MOST_MADE = 1.08
"""Triangles that `refine` makes, at most, over equilateral ones of the edge asked for: 0.9 to 1.07
on surfaces whose triangles were from half as large to 3.5 times as large."""
_PAIR_BYTES = 4 * 4 / 3
"""A pixel while a pair is matched: both photos' pyramids, and one more as it is made (twice)."""
_PLACED_MB, _KEPT_MB = 16.0, 8.0
"""A photo while all are placed, and of its products afterwards."""
_DEPTH_BYTES = 30.0
"""A pixel of the reduced photos together, at every second of which depth is measured and fused: 20
of 15 photos of 15 MP, 9 of 31 of 13 MP that their object fills, less where the object is small."""
_LEAST_DEPTH = 0.25
"""Share of the depth maps' pixels below which is not gone."""
_TRIANGLE_BYTES = 1100.0
"""A triangle of the mesh that is measured."""
_MOST_HALVINGS = 3
_PICTURES_MB = 600.0
"""Photos in the measurement beyond which they are halved where their pixels are too fine for the
triangles anyway. 60 phone photos of 12 megapixels take 500, 30 of 48 would take 1000."""
_SLACK = 1.25
"""How much longer the edges may be that halved photos allow than those that the triangles do."""


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """How finely a surface is measured, and what keeps it from being finer."""

    edge_mm: float
    """Edges of the measured mesh, in the scene's unit."""
    face_parts: int
    """Parts in which a face's edge is sampled, so that all pixels serve the measurement."""
    photo_halvings: int
    """How often the photos were halved for the measurement."""
    depth_share: float
    """Pixels of the depth maps over what the options ask for."""
    notes: tuple[Finding, ...]
    """What was done at a lower size than the photos allow, and why; empty where nothing was."""


def refuse_beyond(photos: PhotoSet, memory_mb: float) -> None:
    """Raise BudgetError where no size would do."""
    count = len(photos.photos)
    needs_mb = {
        "pairs": PROGRAM_MB + _KEPT_MB * count + in_flight_mb(photos.photos, _PAIR_BYTES),
        "placing": PROGRAM_MB + _PLACED_MB * count,
        "board": PROGRAM_MB + _KEPT_MB * count + in_flight_mb(photos.photos, SEARCH_BYTES),
    }
    worst = max(needs_mb, key=lambda what: needs_mb[what])
    if needs_mb[worst] > memory_mb:
        largest = max(photo.width_px * photo.height_px for photo in photos.photos)
        raise BudgetError(
            "memory.photos",
            count=count,
            megapixels=largest / 1e6,
            needs_gb=needs_mb[worst] / 1024,
            allowed_gb=memory_mb / 1024,
            stage=worst,
        )


def depth_share(photos: PhotoSet, most_px: int, memory_mb: float) -> float:
    """Share of `most_px`, or of all pixels where they are fewer, at which depth maps fit."""
    there_px = min(most_px, sum(photo.width_px * photo.height_px for photo in photos.photos))
    free_mb = memory_mb - PROGRAM_MB - _KEPT_MB * len(photos.photos)
    fitting_px = max(free_mb, 0.0) * 2**20 / _DEPTH_BYTES
    return 1.0 if fitting_px >= there_px else max(_LEAST_DEPTH, fitting_px / most_px)


def resolution_for(
    metric: MetricScene,
    surface: Mesh,
    *,
    edge_px: float,
    most_triangles: int,
    depth_share: float,
    memory_mb: float,
    beside_mm2: float = 0.0,
) -> Resolution:
    """How finely to measure a surface: by its pixels, unless triangles or memory run out.

    Args:
        edge_px: Edges that the pixels of the photos allow.
        most_triangles: Edges grow until this surface and what is measured beside it have no more
            than these.
        beside_mm2: Area of that.
    """
    finest = edge_px * pixel_on_object(metric)
    area = 0.5 * float(np.linalg.norm(surface.face_normals(), axis=1).sum())
    whole = (area + beside_mm2) * _MOST_MADE
    shortest = float(np.sqrt(whole / (_EQUILATERAL * most_triangles)))
    kept_mb = PROGRAM_MB + _KEPT_MB * len(metric.scene.names)
    needs_mb: list[float] = []
    for halvings in range(_MOST_HALVINGS + 1):
        by_pixels = finest * 2**halvings
        triangles = area / (_EQUILATERAL * max(by_pixels, shortest) ** 2)
        mesh_mb = triangles * _TRIANGLE_BYTES / 2**20
        pictures_mb = imagery_mb(metric.scene.views, surface.vertices_mm, halvings)
        needs_mb.append(kept_mb + mesh_mb + pictures_mb)
        too_fine = pictures_mb > _PICTURES_MB and 2 * by_pixels <= _SLACK * shortest
        if needs_mb[-1] <= memory_mb and not too_fine:
            break
    halvings = len(needs_mb) - 1
    if needs_mb[-1] > memory_mb:
        raise BudgetError(
            "memory.surface",
            needs_gb=needs_mb[-1] / 1024,
            allowed_gb=memory_mb / 1024,
            parts=2**_MOST_HALVINGS,
        )
    by_pixels = finest * 2**halvings
    notes = _photos_notes(halvings, needs_mb[0], memory_mb, depth_share)
    if shortest > by_pixels:
        edges = note(
            "memory.edges",
            edge=shortest,
            finest=finest,
            unit="mm" if metric.scale.unit == "mm" else "unit",
            triangles=most_triangles,
            beside=beside_mm2 > 0.0,
        )
        notes = (*notes, edges)
    return Resolution(
        edge_mm=max(by_pixels, shortest),
        face_parts=max(1, round(shortest / by_pixels)),
        photo_halvings=halvings,
        depth_share=depth_share,
        notes=notes,
    )


def _photos_notes(
    halvings: int, whole_mb: float, memory_mb: float, depth_share: float
) -> tuple[Finding, ...]:
    """What was done with reduced photos, and why.

    Args:
        whole_mb: What photos of full size need.
    """
    notes: list[Finding] = []
    allowed_gb, whole_gb = memory_mb / 1024, whole_mb / 1024
    if depth_share < 1.0:
        notes.append(note("memory.depth_reduced", share=depth_share, allowed_gb=allowed_gb))
    told = {"parts": 2**halvings, "needs_gb": whole_gb}
    if halvings and whole_mb <= memory_mb:
        notes.append(note("memory.finer_than_triangles", **told))
    elif halvings:
        notes.append(note("memory.photos_reduced", **told, allowed_gb=allowed_gb))
    return tuple(notes)


def pixel_on_object(metric: MetricScene) -> float:
    """Size of a photo's pixel on the object: the median over all observations."""
    scene = metric.scene
    sizes = [
        scene.view(k).camera_from_world.apply(scene.points_in_world[_seen_by(scene, k)])[:, 2]
        / scene.view(k).camera.fx
        for k in scene.placed
    ]
    return float(np.median(np.concatenate(sizes)))


def _seen_by(scene: Scene, photo_idx: int) -> Int32[np.ndarray, " k"]:
    observed = scene.observations
    return observed.point_idx[observed.photo_idx == photo_idx]
