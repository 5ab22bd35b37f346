"""The glossary: every figure of an assessment with its unit and what exactly it is.

`path` leads into the tree; `LENGTH` stands for the unit of the case, mm or scene units.
"""

from dataclasses import dataclass
from typing import Any

from limbgram.report.accuracy.evidence import Json

LENGTH = "length"
SHARE = "share"
"""A fraction in the tree, shown in percent."""


@dataclass(frozen=True)
class Term:
    """One figure."""

    path: str
    title: str
    unit: str
    definition: str


TERMS = (
    Term("expected.p95_mm", "Expected error, 95 %", LENGTH,
         "Distance along the normal within which 95 % of the measured surface is expected to lie "
         "from the limb, Gaussian errors assumed. From the vertex sigmas where there are any."),
    Term("expected.rms_mm", "Expected error, RMS", LENGTH,
         "Root mean square of the same, weighted by area."),
    Term("truth.rms_mm", "Distance to the truth, RMS", LENGTH,
         "Root mean square signed distance of the measured vertices from the true surface, after "
         "the alignment that is stated; no scale is fitted."),
    Term("truth.rms_px", "Distance to the truth, RMS, in pixels", "px",
         "The same over the size of a pixel on the object."),
    Term("truth.p95_mm", "Distance to the truth, 95 %", LENGTH,
         "95 % quantile of the absolute distance."),
    Term("truth.mean_mm", "Mean signed distance to the truth (bias)", LENGTH,
         "Mean signed distance of the measured vertices, by the shortest way, not along radii; "
         "positive: our surface lies outside the truth."),
    Term("truth.iqr_mm", "Interquartile range (IQR)", LENGTH,
         "75 % less 25 % quantile of the signed distance."),
    Term("truth.largest_mm", "Largest distance", LENGTH, "Largest absolute distance."),
    Term("truth.within.0.1 mm", "Within 0.1 mm", SHARE,
         "Share of the measured vertices no farther than this from the truth."),
    Term("truth.within.0.25 mm", "Within 0.25 mm", SHARE, "Likewise."),
    Term("truth.covered.0.1 mm", "Covered within 0.1 mm", SHARE,
         "Share of the true vertices that three photos or more see with our surface this near."),
    Term("truth.covered.0.25 mm", "Covered within 0.25 mm", SHARE, "Likewise."),
    Term("truth.scale_error", "Scale error", SHARE,
         "By how much our surface is too large: what a similarity would take away on top of the "
         "alignment."),
    Term("truth.volume_error", "Volume error", SHARE,
         "Of the volume between the 10 % and the 90 % quantile of the seen truth's height."),
    Term("truth.camera_rms_mm", "Camera places, RMS", LENGTH,
         "Distance of the camera centres from the true ones after the same alignment."),
    Term("truth.sigma.robust_spread", "Error over sigma, robust spread", "",
         "1.4826 times the median of |error / sigma|: 1 where sigmas are honest, above 1 where "
         "they are too small."),
    Term("truth.sigma.within_95_share", "Inside the 95 % interval", SHARE,
         "Share of vertices with |error| below 1.96 sigma; 95 % where sigmas are honest."),
    Term("truth.sigma.rank_correlation", "Rank correlation of |error| and sigma", "",
         "Spearman's; above 0 where larger sigmas mark larger errors."),
    Term("surface.around.missing_share", "Directions round the limb without surface", SHARE,
         "Of sixty level directions from the middle at each of thirty heights, those in which no "
         "measured surface lies. The middle is that of a circle through the surface there."),
    Term("surface.around.widest_gap_deg", "Widest gap in the surface", "deg",
         "Directions in a row without measured surface; median over the heights."),
    Term("surface.around.open_share", "Surface missing beyond one brim", SHARE,
         "Area that would close the open rims, less one brim and less rims on the table, over the "
         "area of the closed whole."),
    Term("images.distance_over_stated", "Distance over that in EXIF", "",
         "Distance of the camera by this scale over the distance at which EXIF says that the lens "
         "was focused; median over photos. Far from 1: the scale is in doubt."),
    Term("surface.sigma.rms_mm", "Sigma of the surface, RMS", LENGTH,
         "Standard deviation of a vertex along its normal, root mean square by area."),
    Term("surface.sigma.median_mm", "Sigma, median", LENGTH, "Half of the area is surer."),
    Term("surface.sigma.p95_mm", "Sigma, 95 %", LENGTH, "95 % of the area is surer."),
    Term("surface.sigma.shared_rms_mm", "Shared part of sigma", LENGTH,
         "What all vertices have in common: cameras, lens, scale. It does not average out in "
         "girths and volumes."),
    Term("surface.sigma.correlation_mm", "Reach of the other errors", LENGTH,
         "Distance over which the rest of a vertex's error is like its neighbours'."),
    Term("surface.measured_share", "Measured", SHARE, "Share of the area that photos measured."),
    Term("surface.filled_share", "Filled in", SHARE,
         "Share of the area that was closed by interpolation: fewer than two photos see it."),
    Term("surface.left_out_share", "Left out", SHARE,
         "Area that was measured and is not in the surface though it is its own: crumbs that hang "
         "on nothing, and pieces torn off by a bare strip, as a share of the surface with them. "
         "The other side of a wall and bodies apart are parts with files of their own."),
    Term("surface.photos_per_place.median", "Photos per place", "photos",
         "Median number of photos that see a place of the surface, at 65 degrees or squarer."),
    Term("surface.photos_per_place.below_3_share", "Seen by fewer than three photos", SHARE,
         "Share of the surface; nothing checks the measurement there."),
    Term("surface.area", "Area", "length^2", "Of the delivered surface."),
    Term("lengths.check_worst", "Worst check length", SHARE,
         "Largest relative error of a known length that did not set the scale."),
    Term("lengths.check_rms", "Check lengths, RMS", SHARE, "Root mean square of their errors."),
    Term("lengths.control_rms", "Control lengths, RMS", SHARE,
         "The same of the lengths that set the scale: how well they fit, not how true they are."),
    Term("lengths.relative_sigma", "Sigma of the scale", SHARE,
         "Standard deviation of the scale factor by leaving out one photo after the other; without "
         "errors that all photos share and without an error of the board's print."),
    Term("residuals.rms_px", "Residuals, RMS", "px",
         "Root mean square of one coordinate, measured minus projected, over all image points."),
    Term("residuals.largest_px", "Largest residual", "px", "Distance; farther ones were dropped."),
    Term("residuals.beyond_3_sigma_share", "Residuals beyond three sigmas", SHARE,
         "Of the robust sigma0; 0.27 % where errors are Gaussian."),
    Term("network.sigma0_px", "Sigma0 (a posteriori)", "px",
         "sqrt(sum of squared residuals / redundancy): standard deviation of one measured "
         "coordinate."),
    Term("network.sigma0_robust_px", "Sigma0, robust", "px",
         "The same from the median of the residuals of points with three rays or more."),
    Term("network.redundancy", "Redundancy", "",
         "Measured coordinates less unknowns (6 a photo, 3 a point, 7 of the frame given back); "
         "lens parameters are observed by their calibration and count nil."),
    Term("network.redundancy_share", "Mean redundancy number", "",
         "Redundancy over measured coordinates: what share of an error shows in its residual."),
    Term("network.points", "Points", "", "Scene points of the adjustment."),
    Term("network.observations", "Image points", "", "Measured images of scene points."),
    Term("network.rays.mean", "Rays per point, mean", "", "Photos that see a scene point."),
    Term("network.rays.two_share", "Points with two rays", SHARE, "Nothing checks these but F."),
    Term("network.angles.median_deg", "Intersection angle, median", "deg",
         "Largest angle between any two rays of a point."),
    Term("network.angles.low_deg", "Intersection angle, 5 %", "deg", "5 % are smaller."),
    Term("network.point_sigma.median", "Sigma of a scene point, median", LENGTH,
         "Formal, along the direction its rays fix worst, cameras exact; three to four times too "
         "small by experience."),
    Term("network.ring.largest_gap_deg", "Widest gap between photos", "deg",
         "Angle without a photo, seen from the object, in the plane that fits the cameras best."),
    Term("network.ring.weakest_bridge_points", "Weakest bridge", "points",
         "Fewest scene points that join the photos on both sides of a place in the ring."),
    Term("poses.centre_median", "Sigma of a camera's place, median", LENGTH,
         "All three coordinates together, from the covariance of the adjustment; what moves the "
         "whole scene carries nothing."),
    Term("poses.centre_largest", "Sigma of a camera's place, largest", LENGTH, "Likewise."),
    Term("poses.rotation_median_deg", "Sigma of a camera's turn, median", "deg", "Likewise."),
    Term("images.pixel", "Pixel on the object", LENGTH, "Median over photos: distance / f in px."),
    Term("images.distance", "Distance", LENGTH, "Median over photos, along the optical axis."),
    Term("images.edge_width_px", "Edge width", "px",
         "Gaussian sigma of a photo's sharpest edges in the worst direction; median over photos."),
    Term("images.noise_grey", "Image noise", "grey levels",
         "Standard deviation of a pixel in plain parts, of 256 levels, after JPEG."),
)  # fmt: skip


def value_at(tree: Any, path: str) -> Any:
    """What a path leads to; None where the tree ends before."""
    while path:
        if not isinstance(tree, dict):
            return None
        key = next((k for k in tree if path == k or path.startswith(f"{k}.")), None)
        if key is None:
            return None
        tree, path = tree[key], path[len(key) + 1 :]
    return tree


def glossary_tree() -> Json:
    """Title, unit and definition by path, for machines."""
    return {
        term.path: {"title": term.title, "unit": term.unit, "definition": term.definition}
        for term in TERMS
    }
