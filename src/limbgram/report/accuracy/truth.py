"""Against the truth: signed distances, girths, volume, and whether the sigmas say what is so."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import COVER, MAD_TO_SIGMA, rms
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.notebook import brief
from limbgram.report.accuracy.figures import (
    DistanceHistogram,
    SigmaPart,
    SigmaTest,
    TrueGirth,
    TruthFigures,
)
from limbgram.report.alignment import (
    Truth,
    align_by_cameras,
    align_by_surface,
    align_from_anywhere,
    measured_samples,
    signed_mm,
)
from limbgram.report.comparison import sections

Alignment = Literal["surface", "cameras", "frame"]
"""surface: rigid fit of the surface; cameras: of the camera places alone; frame: none at all."""

FEWEST_CAMERAS = 3
_NEAR_MM = (0.1, 0.25, 0.5, 1.0)
_BINS = 61
_SHOWN_QUANTILE = 0.995
_SIGMA_BINS = 10
_WORDS = {
    "surface": "rigid fit of the measured surface (point to plane, six degrees of freedom, no "
    "scale)",
    "cameras": "rigid fit of the camera centres alone; the surface takes no part",
    "frame": "none: both are taken to lie in one frame already",
}


@dataclass(frozen=True, kw_only=True)
class KnownTruth:
    """The true surface, what it is, and how ours is laid onto it."""

    kind: str
    """Such as "a mesh file": its name may be a patient's."""
    truth: Truth
    centres_mm: Points3
    """Our camera centres, in the order of the truth's; none where it has none."""
    alignment: Alignment = "surface"

    __repr__ = brief


@dataclass(frozen=True)
class Compared:
    """Figures, and each vertex's signed distance from the truth; NaN where there is none."""

    figures: TruthFigures
    off_mm: Float64[np.ndarray, " n"]


def truth_figures(mesh: Mesh, known: KnownTruth, pixel_mm: float) -> Compared:
    """Compare with the truth; `pixel_mm` is the size of a pixel on the object."""
    truth, centres_mm, alignment = known.truth, known.centres_mm, known.alignment
    samples = mesh.vertices_mm[measured_samples(mesh)]
    if alignment == "surface" and len(centres_mm) < FEWEST_CAMERAS:
        # Sections are cut across our own vertical: the truth's frame may lie anyhow.
        truth = truth.moved(align_from_anywhere(samples, truth).inverse)
    pose, scale_error = _aligned(samples, centres_mm, truth, alignment)
    placed = mesh.moved(pose)
    all_mm, seen = signed_mm(placed.vertices_mm, truth)
    compared = seen & mesh.measured
    if not compared.any():
        raise MeasureError(
            "No part of the measured surface lies near the truth. Is it the truth of this limb, "
            "in millimetres? Without cameras in common the alignment starts from the shapes alone."
        )
    off_mm = all_mm[compared]
    missed_mm = (
        TriangleTree.of(placed.vertices_mm, placed.faces)
        .closest(truth.vertices_mm[truth.seen])
        .distances_mm
    )
    girths, volume_error = sections(placed, truth)
    centres_off = (pose.apply(centres_mm) - truth.centres_mm) if len(centres_mm) else None
    low, high = np.quantile(off_mm, [0.25, 0.75])
    figures = TruthFigures(
        kind=known.kind,
        rms_px=rms(off_mm) / pixel_mm,
        alignment=_WORDS[alignment],
        vertices=len(off_mm),
        rms_mm=rms(off_mm),
        p95_mm=float(np.quantile(np.abs(off_mm), 0.95)),
        mean_mm=float(off_mm.mean()),
        median_mm=float(np.median(off_mm)),
        iqr_mm=float(high - low),
        largest_mm=float(np.abs(off_mm).max()),
        within=_shares_within(np.abs(off_mm)),
        covered=_shares_within(missed_mm),
        scale_error=scale_error,
        girths=tuple(
            TrueGirth(
                height_mm=one.height_mm,
                measured_mm=one.measured_mm,
                true_mm=one.true_mm,
                error_mm=one.error_mm,
            )
            for one in girths
            if np.isfinite(one.error_mm)
        ),
        volume_error=volume_error,
        camera_rms_mm=math.nan if centres_off is None else rms(centres_off),
        histogram=_histogram(off_mm),
        sigma=None if mesh.sigma_mm is None else sigma_test(off_mm, mesh.sigma_mm[compared]),
    )
    return Compared(figures, np.where(compared, all_mm, np.nan))


def sigma_test(off_mm: Float64[np.ndarray, " n"], sigma_mm: np.ndarray) -> SigmaTest:
    """Error over sigma: its robust spread is 1 where sigmas are honest, above 1 where too small."""
    known = np.isfinite(sigma_mm) & (sigma_mm > 0)
    error, sigma = off_mm[known], sigma_mm[known].astype(np.float64)
    ratio = error / sigma
    order = np.argsort(sigma, kind="stable")
    parts = [part for part in np.array_split(order, _SIGMA_BINS) if len(part)]
    return SigmaTest(
        vertices=len(error),
        robust_spread=float(MAD_TO_SIGMA * np.median(np.abs(ratio))),
        rms_spread=rms(ratio),
        within_sigma_share=float(np.mean(np.abs(ratio) <= 1)),
        within_95_share=float(np.mean(np.abs(ratio) <= COVER)),
        rank_correlation=_rank_correlation(np.abs(error), sigma),
        by_sigma=tuple(
            SigmaPart(sigma_mm=float(np.median(sigma[part])), rms_error_mm=rms(error[part]))
            for part in parts
        ),
    )


def _aligned(
    samples: Points3,
    centres_mm: Float64[np.ndarray, "photos 3"],
    truth: Truth,
    alignment: Alignment,
) -> tuple[Rigid, float]:
    """truth_from_world and the scale error that a similarity would take away."""
    match alignment:
        case "frame":
            pose = Rigid.identity()
        case "cameras":
            pose = align_by_cameras(centres_mm, truth)
        case "surface":
            known = len(centres_mm) >= FEWEST_CAMERAS
            start = align_by_cameras(centres_mm, truth) if known else Rigid.identity()
            fit = align_by_surface(samples, truth, start)
            return fit.truth_from_world, fit.scale_error
    return pose, align_by_surface(samples, truth, pose).scale_error


def _rank_correlation(first: Float64[np.ndarray, " n"], second: Float64[np.ndarray, " n"]) -> float:
    """Spearman's; NaN where one of the two does not vary."""
    if np.ptp(first) == 0 or np.ptp(second) == 0:
        return math.nan
    from scipy.stats import rankdata  # all of scipy.stats takes a quarter of a second to import

    return float(np.corrcoef(rankdata(first), rankdata(second))[0, 1])


def _shares_within(off_mm: Float64[np.ndarray, " n"]) -> dict[str, float]:
    """Shares of the distances within each of a few limits."""
    return {f"{near} mm": float(np.mean(off_mm <= near)) for near in _NEAR_MM}


def _histogram(off_mm: Float64[np.ndarray, " n"]) -> DistanceHistogram:
    reach = max(float(np.quantile(np.abs(off_mm), _SHOWN_QUANTILE)), 1e-6)
    edges = np.linspace(-reach, reach, _BINS + 1)
    vertices = np.histogram(np.clip(off_mm, -reach, reach), edges)[0]
    return DistanceHistogram(edges_mm=tuple(edges.tolist()), vertices=tuple(vertices.tolist()))
