"""Comparison with truth: a reconstructed surface against its exact truth.

In      a Mesh, the truth's mesh and which of it the photos show, and camera centres of both.
Out     a TruthComparison, mm and fractions.
Method  rigid alignment alone (camera centres, then point to plane), so that a wrong scale stays
        in the figures; girth and volume between the same two heights of both. Where the truth has
        several outlines at a height, the girths are of its largest, and of what of ours lies nearer
        to that than to the others. A girth is that of a tape drawn taut round all pieces of an
        outline, each at the smoothing length, so that it bridges a tear.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.spatial import ConvexHull, KDTree

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.smoothed_length import STEPS_PER_MM, smoothed
from limbgram.core.interval import rms
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import Z_AXIS, Section, cut, level_segments
from limbgram.report.alignment import (
    Truth,
    align_by_cameras,
    align_by_surface,
    measured_samples,
    signed_mm,
)

_SECTIONS = 40
_GIRTHS = (0.2, 0.4, 0.6, 0.8)
"""Heights at which girths are compared, as shares of the seen height."""
_NEAR_MM = 0.25
_LEAST_MM = 10.0
"""Of outline: less is no girth."""


@dataclass(frozen=True, kw_only=True)
class TruthComparison:
    """How far a surface is from the truth."""

    rms_mm: float
    p95_mm: float
    mean_mm: float
    """Signed; positive: the surface lies outside the truth."""
    scale_error: float
    """Fraction by which the surface is too large."""
    covered: float
    """Share of the seen truth with the surface within 0.25 mm."""
    girth_heights_mm: tuple[float, ...]
    """Of the compared girths, in the truth's frame."""
    girth_errors_mm: tuple[float, ...]
    volume_error: float
    """Fraction, between the lowest and the highest compared height."""
    camera_rms_mm: float
    """Of the camera centres after the alignment."""


def compare_with_truth(mesh: Mesh, centres_mm: Points3, truth: Truth) -> TruthComparison:
    """Compare a surface with the truth; `centres_mm` are its cameras in the truth's order."""
    samples = mesh.vertices_mm[measured_samples(mesh)]
    fit = align_by_surface(samples, truth, align_by_cameras(centres_mm, truth))
    placed = mesh.moved(fit.truth_from_world)
    off_mm, seen = signed_mm(fit.truth_from_world.apply(samples), truth)
    off_mm = off_mm[seen]
    back = TriangleTree.of(placed.vertices_mm, placed.faces)
    missed_mm = back.closest(truth.vertices_mm[truth.seen]).distances_mm
    girths, volume_error = sections(placed, truth)
    cameras_mm = fit.truth_from_world.apply(centres_mm) - truth.centres_mm
    return TruthComparison(
        rms_mm=rms(off_mm),
        p95_mm=float(np.quantile(np.abs(off_mm), 0.95)),
        mean_mm=float(off_mm.mean()),
        scale_error=fit.scale_error,
        covered=float(np.mean(missed_mm < _NEAR_MM)),
        girth_heights_mm=tuple(girth.height_mm for girth in girths),
        girth_errors_mm=tuple(girth.error_mm for girth in girths),
        volume_error=volume_error,
        camera_rms_mm=rms(cameras_mm),
    )


@dataclass(frozen=True)
class Girth:
    """A girth of both surfaces at one height of the truth."""

    height_mm: float
    measured_mm: float
    true_mm: float

    @property
    def error_mm(self) -> float:
        return self.measured_mm - self.true_mm


def girth_mm(pieces: Sequence[Section]) -> float:
    """Circumference of a cut across z as a taut tape reads it; NaN of too little."""
    return _taut_mm(_smoothed_length_mm(pieces))


def _smoothed_length_mm(pieces: Sequence[Section]) -> Points2:
    """All pieces of a cut at the smoothing length, one behind the other."""
    lines = [smoothed(piece.points_mm[:, :2], closed=piece.closed) for piece in pieces]
    return np.concatenate([np.empty((0, 2)), *lines])


def _taut_mm(points: Points2) -> float:
    if len(points) < _LEAST_MM * STEPS_PER_MM:
        return float("nan")
    return float(ConvexHull(points).area)  # of two dimensions: length


def area_mm2(segments: Float64[np.ndarray, "n 2 2"]) -> float:
    """Area inside closed outlines, counter-clockwise ones positive (Green's theorem)."""
    (ax, ay), (bx, by) = segments[:, 0].T, segments[:, 1].T
    return float((ax * by - bx * ay).sum() / 2)


def sections(placed: Mesh, truth: Truth) -> tuple[tuple[Girth, ...], float]:
    """Girths at a few heights, and the error of the volume between the outer ones, a fraction."""
    both = placed, Mesh(vertices_mm=truth.vertices_mm, faces=truth.faces)
    seen_mm = truth.vertices_mm[truth.seen, 2]
    low, high = np.quantile(seen_mm, 0.02), np.quantile(seen_mm, 0.98)
    heights = (low + (high - low) * np.array(_GIRTHS)).tolist()
    pieces = [cut(mesh, heights) for mesh in both]
    girths = tuple(
        _girth(height, *([one for one in own if one.offset_mm == height] for own in pieces))
        for height in heights
    )
    ends = np.quantile(seen_mm, 0.1), np.quantile(seen_mm, 0.9)
    cuts = (level_segments(one, np.linspace(ends[0], ends[1], _SECTIONS)) for one in both)
    volumes = [sum(area_mm2(one.at(k)) for k in range(_SECTIONS)) for one in cuts]
    return girths, float(volumes[0] / volumes[1] - 1)


def _girth(height_mm: float, ours: Sequence[Section], theirs: Sequence[Section]) -> Girth:
    """Girth of the truth's largest outline; all pieces of a torn outline count as one.

    Ours may be torn into pieces, so each of its points goes with the outline next to it.
    """
    points = _smoothed_length_mm(ours)
    if len(theirs) < 2 or not all(piece.closed for piece in theirs):
        return Girth(height_mm, _taut_mm(points), girth_mm(theirs))
    largest, *others = sorted(theirs, key=lambda piece: -piece.area_mm2(Z_AXIS))
    off, off_others = (
        KDTree(_smoothed_length_mm(outlines)).query(points)[0] for outlines in ([largest], others)
    )
    return Girth(height_mm, _taut_mm(points[off < off_others]), girth_mm([largest]))
