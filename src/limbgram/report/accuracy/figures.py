"""Figures: everything that an assessment says, and what each figure of the glossary means.

Every class is one table of accuracy.json, every field one key. Where a field is a figure of the
glossary, its meaning (title, unit, definition) hangs on the field, so that no entry of the
glossary can be without a figure. NaN stands for what is not known; JSON has null for it. Lengths
are in mm, or in scene units where nothing gives the scale.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from limbgram.core.mesh.mesh import Relation
from limbgram.core.tape import AGREES_SIGMAS
from limbgram.findings import Finding
from limbgram.reconstruction.calibration.cameras import LensSource
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.scale.metric import StretchDoubt
from limbgram.reconstruction.scale.stated_lengths import PRINTED, LengthEnds

LENGTH = "length"
"""Stands for the unit of the case, mm or scene units."""
SHARE = "share"
"""A fraction, shown in percent."""


def length_unit(unit: Literal["mm", "unitless"]) -> str:
    """What a length of a case is called."""
    return "mm" if unit == "mm" else "scene units"


def meaning(title: str, unit: str, definition: str) -> Mapping[str, str]:
    """What a field is, for the glossary."""
    return {"title": title, "unit": unit, "definition": definition}


@dataclass(frozen=True, kw_only=True)
class PixelHistogram:
    """Residuals by their size, each coordinate."""

    edges_px: tuple[float, ...]
    x: tuple[int, ...]
    y: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class PhotoResiduals:
    """How well one photo fits."""

    name: str
    observations: int
    rms_px: float
    mean_x_px: float
    mean_y_px: float
    largest_px: float


@dataclass(frozen=True, kw_only=True)
class ResidualGrid:
    """Cells of the picture row after row, from the top left; NaN where a cell has too few."""

    rows: int
    columns: int
    width_px: int
    height_px: int
    observations: tuple[int, ...]
    mean_x_px: tuple[float, ...]
    mean_y_px: tuple[float, ...]
    rms_px: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Zone:
    """A ring round the middle of the picture, in shares of the way to the corner."""

    from_share: float
    to_share: float
    observations: int
    rms_px: float
    outward_px: float
    """Mean residual away from the middle."""


@dataclass(frozen=True, kw_only=True)
class CameraResiduals:
    """What all photos of one camera have in common."""

    camera: int
    observations: int
    grid: ResidualGrid
    zones: tuple[Zone, ...]
    systematic_px: float
    """RMS of one coordinate's mean over a cell, less what chance makes of it."""


@dataclass(frozen=True, kw_only=True)
class ResidualFigures:
    """How far the measured image points lie from where the scene puts them."""

    rms_px: float = field(
        metadata=meaning(
            "Residuals, RMS",
            "px",
            "Root mean square of one coordinate, measured minus projected, over all image points.",
        )
    )
    median_distance_px: float
    largest_px: float = field(
        metadata=meaning("Largest residual", "px", "Distance; farther ones were dropped.")
    )
    beyond_3_sigma_share: float = field(
        metadata=meaning(
            "Residuals beyond three sigmas",
            SHARE,
            "Of the robust sigma0; 0.27 % where errors are Gaussian.",
        )
    )
    histogram: PixelHistogram
    by_photo: tuple[PhotoResiduals, ...]
    by_camera: tuple[CameraResiduals, ...]


@dataclass(frozen=True, kw_only=True)
class Rays:
    """How many photos see a scene point."""

    mean: float = field(
        metadata=meaning("Rays per point, mean", "", "Photos that see a scene point.")
    )
    median: float
    two_share: float = field(
        metadata=meaning(
            "Points with two rays",
            SHARE,
            "Share of the points that two photos see: a third photo would check them.",
        )
    )
    numbers: tuple[int, ...]
    """Numbers of rays that are counted; the last one holds what lies beyond."""
    points: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class Angles:
    """Largest angle between any two rays of a point."""

    median_deg: float = field(
        metadata=meaning(
            "Intersection angle, median", "deg", "Largest angle between any two rays of a point."
        )
    )
    low_deg: float = field(
        metadata=meaning(
            "Intersection angle, 5 %", "deg", "5 % of the points have a smaller angle."
        )
    )
    narrow_share: float
    edges_deg: tuple[float, ...]
    points: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class PointSigma:
    """Formal sigma of a scene point along the direction that its rays fix worst."""

    median: float = field(
        metadata=meaning(
            "Sigma of a scene point, median",
            LENGTH,
            "Formal, along the direction its rays fix worst, cameras exact; three to four times "
            "too small by experience.",
        )
    )
    p95: float


@dataclass(frozen=True, kw_only=True)
class Overlap:
    """Points that two placed photos share; a photo's own points on the diagonal."""

    names: tuple[str, ...]
    shared_points: tuple[tuple[int, ...], ...]
    best_partner: tuple[int, ...]
    partners: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class RingFigures:
    """The walk round the object."""

    largest_gap_deg: float = field(
        metadata=meaning(
            "Widest gap between photos",
            "deg",
            "Angle without a photo, seen from the object, in the plane that fits the cameras best.",
        )
    )
    weakest_bridge_points: int = field(
        metadata=meaning(
            "Weakest bridge",
            "points",
            "Fewest scene points that join the photos on both sides of a place in the ring.",
        )
    )
    closed: bool


@dataclass(frozen=True, kw_only=True)
class NetworkFigures:
    """How many rays meet in a point, at what angles, and how much is left over to check."""

    points: int = field(metadata=meaning("Points", "", "Scene points of the adjustment."))
    observations: int = field(
        metadata=meaning("Image points", "", "Measured images of scene points.")
    )
    unknowns: int
    redundancy: int = field(
        metadata=meaning(
            "Redundancy",
            "",
            "Measured coordinates less unknowns (6 a photo, 3 a point, 7 of the frame given back); "
            "lens parameters are observed by their calibration and count nil.",
        )
    )
    redundancy_share: float = field(
        metadata=meaning(
            "Mean redundancy number",
            "",
            "Redundancy over measured coordinates: what share of an error shows in its residual.",
        )
    )
    sigma0_px: float = field(
        metadata=meaning(
            "Sigma0 (a posteriori)",
            "px",
            "sqrt(sum of squared residuals / redundancy): standard deviation of one measured "
            "coordinate.",
        )
    )
    sigma0_robust_px: float = field(
        metadata=meaning(
            "Sigma0, robust",
            "px",
            "Standard deviation of one measured coordinate, from the median of the residuals of "
            "points with three rays or more.",
        )
    )
    rays: Rays
    angles: Angles
    point_sigma: PointSigma
    overlap: Overlap
    ring: RingFigures | None


@dataclass(frozen=True, kw_only=True)
class KnownLength:
    """A length that was given, beside what the scene makes of it."""

    label: str
    between: LengthEnds
    known_mm: float
    measured_mm: float
    error_mm: float
    error: float
    """A fraction of the known length."""
    sigma_mm: float


CHECK_TELLS = 0.01
"""Of the length: a check length or a tape checks the size where its two sigmas are no more. 1 % of
a girth of 350 mm is less than two plies of sock, and a print fitted to the page is 3 % off or more.
A tape reaches 1 % on a girth of 300 mm that does not taper."""


def independent_checks(
    control: Sequence[KnownLength], check: Sequence[KnownLength]
) -> tuple[KnownLength, ...]:
    """The check lengths that tell, on another piece than every length that set the scale.

    Each distance that was given by hand was measured by itself.
    """
    print_set_it = any(one.between in PRINTED for one in control)
    return tuple(
        one
        for one in check
        if not (print_set_it and one.between in PRINTED)
        and AGREES_SIGMAS * one.sigma_mm <= CHECK_TELLS * one.known_mm
    )


@dataclass(frozen=True, kw_only=True)
class TapedLength:
    """A girth that was taped, beside the surface's own."""

    place: str
    height_mm: float | None
    """Above the table; None: at the widest place."""
    read_mm: float
    measured_mm: float
    error_mm: float
    error: float
    sigma_mm: float
    """Standard deviation of the difference: of the tape and of the surface's girth."""
    reason: Finding | None
    """Why there is no figure; None where there is one."""


@dataclass(frozen=True, kw_only=True)
class BoardSeen:
    """How well the scale board is seen."""

    board: str
    photos: int
    placed_photos: int
    corners: int
    corners_per_photo: float
    diagonal_mm: float


@dataclass(frozen=True, kw_only=True)
class LengthFigures:
    """What sets the scale (control), what tests it (check), and how well the board is seen."""

    unit: Literal["mm", "unitless"]
    source: Literal["board", "distances", "none"]
    relative_sigma: float = field(
        metadata=meaning(
            "Sigma of the scale",
            SHARE,
            "Standard deviation of the scale factor by leaving out one photo after the other, and "
            "half of the board's stretch; without errors that all photos share and without an "
            "error that the whole print has.",
        )
    )
    board_stretch: float = field(
        metadata=meaning(
            "Stretch of the board",
            SHARE,
            "How much longer the board is along its x than along its y; 0 where the photos do "
            "not show any.",
        )
    )
    stretch_doubt: StretchDoubt
    """What may have stretched it, beside its print."""
    control: tuple[KnownLength, ...]
    check: tuple[KnownLength, ...]
    control_rms: float = field(
        metadata=meaning(
            "Control lengths, RMS",
            SHARE,
            "Root mean square of the relative errors of the lengths that set the scale: how well "
            "they fit, not how true they are.",
        )
    )
    check_rms: float = field(
        metadata=meaning(
            "Check lengths, RMS",
            SHARE,
            "Root mean square of the relative errors of the known lengths that did not set the "
            "scale.",
        )
    )
    check_worst: float = field(
        metadata=meaning(
            "Worst check length",
            SHARE,
            "Largest relative error of a known length that did not set the scale.",
        )
    )
    check_worst_label: str
    checked_by_another_piece: bool
    """Whether a check length that is known to 1 % lies on another piece than every length that set
    the scale (`independent_checks`). Everything printed counts as one piece, because one printer
    makes all of it too large together; a distance given by hand is a piece of its own."""
    tapes: tuple[TapedLength, ...]
    board: BoardSeen | None


@dataclass(frozen=True, kw_only=True)
class LensParameter:
    """One parameter of a lens before and after the adjustment."""

    name: str
    unit: str
    value: float
    sigma: float
    calibrated: float
    calibrated_sigma: float
    moved_sigmas: float
    """By how many sigmas of the calibration it moved."""
    contradicted_sigmas: float
    """The same over the sigma that the move has where calibration and photos agree."""
    held: bool


@dataclass(frozen=True, kw_only=True)
class Correlations:
    """Correlations of the parameters that are free, in this order."""

    order: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]


LENS_SOURCES: dict[LensSource, str] = {
    "board": "calibrated with a board",
    "exif": "guessed from EXIF",
    "guess": "guessed, as EXIF tells nothing of it",
}
"""Where lenses are known from, in words."""


@dataclass(frozen=True, kw_only=True)
class ContradictedFile:
    """A camera file that the photos contradict, and that was not used."""

    given_px: float
    """Its focal length."""
    shown_px: float
    """That of the photos."""
    sigmas: float
    """How many sigmas of both lie between them."""


@dataclass(frozen=True, kw_only=True)
class LensFigures:
    """A camera of the capture."""

    camera: int
    label: str
    source: LensSource
    width_px: int
    height_px: int
    calibration_rms_px: float
    parameters: tuple[LensParameter, ...]
    correlations: Correlations | None
    contradicted: ContradictedFile | None = None

    @property
    def name(self) -> str:
        """For people."""
        return self.label or f"camera {self.camera + 1}"


@dataclass(frozen=True, kw_only=True)
class PhotoPose:
    """How surely one photo is placed."""

    name: str
    centre: float
    rotation_deg: float


@dataclass(frozen=True, kw_only=True)
class PoseFigures:
    """Sigma of every photo's place and turn, all three coordinates together."""

    centre_median: float = field(
        metadata=meaning(
            "Sigma of a camera's place, median",
            LENGTH,
            "All three coordinates together, from the covariance of the adjustment; what moves the "
            "whole scene carries nothing.",
        )
    )
    centre_largest: float = field(
        metadata=meaning(
            "Sigma of a camera's place, largest",
            LENGTH,
            "All three coordinates together, of the photo that is placed least surely.",
        )
    )
    rotation_median_deg: float = field(
        metadata=meaning(
            "Sigma of a camera's turn, median",
            "deg",
            "About all three axes together, from the covariance of the adjustment.",
        )
    )
    by_photo: tuple[PhotoPose, ...]


@dataclass(frozen=True, kw_only=True)
class OtherBody:
    """A sizeable body beside this surface."""

    number: int
    relation: Relation
    area: float


@dataclass(frozen=True, kw_only=True)
class Opening:
    """A hole of the surface: length of its rim, and where its middle is."""

    rim: float
    middle: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Around:
    """How much of the limb is missing, seen from its own middle."""

    missing_share: float = field(
        metadata=meaning(
            "Directions round the limb without surface",
            SHARE,
            "Of sixty level directions from the middle at each of thirty heights, those in which "
            "no measured surface lies. The middle is that of a circle through the surface there.",
        )
    )
    widest_gap_deg: float = field(
        metadata=meaning(
            "Widest gap in the surface",
            "deg",
            "Directions in a row without measured surface; median over the heights.",
        )
    )
    open_share: float = field(
        metadata=meaning(
            "Surface missing beyond one brim",
            SHARE,
            "Area that would close the open rims, less one brim and less rims on the table, over "
            "the area of the closed whole.",
        )
    )


@dataclass(frozen=True, kw_only=True)
class PhotosPerPlace:
    """How many photos see a place of the surface squarely enough to measure it."""

    median: float = field(
        metadata=meaning(
            "Photos per place",
            "photos",
            "Median number of photos that see a place of the surface, at 65 degrees or squarer.",
        )
    )
    below_3_share: float = field(
        metadata=meaning(
            "Seen by fewer than three photos",
            SHARE,
            "Share of the surface; nothing checks the measurement there.",
        )
    )
    places: tuple[int, ...]
    """Number of places that no photo sees, that one sees, and so on."""


@dataclass(frozen=True, kw_only=True)
class SurfaceSigma:
    """How sure the measured surface is, along its normal, weighted by area."""

    rms_mm: float = field(
        metadata=meaning(
            "Sigma of the surface, RMS",
            LENGTH,
            "Standard deviation of a vertex along its normal, root mean square by area.",
        )
    )
    median_mm: float = field(
        metadata=meaning("Sigma, median", LENGTH, "Half of the area is surer.")
    )
    p95_mm: float = field(metadata=meaning("Sigma, 95 %", LENGTH, "95 % of the area is surer."))
    shared_rms_mm: float = field(
        metadata=meaning(
            "Shared part of sigma",
            LENGTH,
            "What all vertices have in common: cameras, lens, scale. It does not average out in "
            "girths and volumes.",
        )
    )
    shares_mm: dict[str, float]
    """Part of each shared source, by its name."""
    own_rms_mm: float
    correlation_mm: float = field(
        metadata=meaning(
            "Reach of the other errors",
            LENGTH,
            "Distance over which the rest of a vertex's error is like its neighbours'.",
        )
    )
    expected_error_p95_mm: float
    edges_mm: tuple[float, ...]
    area_share: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class SurfaceFigures:
    """What of the surface was measured, where it is open, how sure each vertex is.

    Areas are shared out to vertices, a third of each triangle to each corner, so that a share is a
    share of the surface and not of a number of vertices.
    """

    vertices: int
    faces: int
    size: tuple[float, ...]
    height_from: float
    area: float = field(metadata=meaning("Area", "length^2", "Of the delivered surface."))
    measured_share: float = field(
        metadata=meaning("Measured", SHARE, "Share of the area that photos measured.")
    )
    filled_share: float = field(
        metadata=meaning(
            "Filled in",
            SHARE,
            "Share of the area that was closed by interpolation: fewer than two photos see it.",
        )
    )
    left_out_share: float = field(
        metadata=meaning(
            "Left out",
            SHARE,
            "Area that was measured and is not in the surface though it is its own: crumbs that "
            "hang on nothing, and pieces torn off by a bare strip, as a share of the surface with "
            "them. The other side of a wall and bodies apart are parts with files of their own.",
        )
    )
    other_parts: tuple[OtherBody, ...]
    part_given: bool
    holes_filled: int
    openings: tuple[Opening, ...]
    around: Around
    photos_per_place: PhotosPerPlace
    sigma: SurfaceSigma | None


@dataclass(frozen=True, kw_only=True)
class PhotoFigures:
    """What one photo is worth."""

    name: str
    placed: bool
    reason: Finding | None
    remarks: tuple[Finding, ...]
    zoomed: bool
    """Used though its focal length is not that of the others."""
    points: int
    edge_width_px: float
    burnt_share: float
    distance: float
    pixel: float


@dataclass(frozen=True, kw_only=True)
class ImageFigures:
    """Noise, sharpness and size of a pixel on the object; NaN for the noise without the files."""

    photos: int
    placed: int
    set_aside: tuple[SetAside, ...]
    pixel: float = field(
        metadata=meaning("Pixel on the object", LENGTH, "Median over photos: distance / f in px.")
    )
    distance: float = field(
        metadata=meaning("Distance", LENGTH, "Median over photos, along the optical axis.")
    )
    distance_over_stated: float = field(
        metadata=meaning(
            "Distance over that in EXIF",
            "",
            "Distance of the camera by this scale over the distance at which EXIF says that the "
            "lens was focused; median over photos. Far from 1: the scale is in doubt.",
        )
    )
    edge_width_px: float = field(
        metadata=meaning(
            "Edge width",
            "px",
            "Gaussian sigma of a photo's sharpest edges in the worst direction; median over "
            "photos.",
        )
    )
    noise_grey: float = field(
        metadata=meaning(
            "Image noise",
            "grey levels",
            "Standard deviation of a pixel in plain parts, of 256 levels, after JPEG.",
        )
    )
    by_photo: tuple[PhotoFigures, ...]


@dataclass(frozen=True, kw_only=True)
class TrueGirth:
    """A girth of ours beside the true one."""

    height_mm: float
    measured_mm: float
    true_mm: float
    error_mm: float


@dataclass(frozen=True, kw_only=True)
class DistanceHistogram:
    """Signed distances from the truth; the ends hold what lies beyond."""

    edges_mm: tuple[float, ...]
    vertices: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class SigmaPart:
    """A tenth of the vertices: the sigma they claim and the error they have."""

    sigma_mm: float
    rms_error_mm: float


@dataclass(frozen=True, kw_only=True)
class SigmaTest:
    """Error over sigma: its robust spread is 1 where sigmas are honest, above 1 if too small."""

    vertices: int
    robust_spread: float = field(
        metadata=meaning(
            "Error over sigma, robust spread",
            "",
            "1.4826 times the median of |error / sigma|: 1 where sigmas are honest, above 1 where "
            "they are too small.",
        )
    )
    rms_spread: float
    within_sigma_share: float
    within_95_share: float = field(
        metadata=meaning(
            "Inside the 95 % interval",
            SHARE,
            "Share of vertices with |error| below 1.96 sigma; 95 % where sigmas are honest.",
        )
    )
    rank_correlation: float = field(
        metadata=meaning(
            "Rank correlation of |error| and sigma",
            "",
            "Spearman's; above 0 where larger sigmas mark larger errors.",
        )
    )
    by_sigma: tuple[SigmaPart, ...]


@dataclass(frozen=True, kw_only=True)
class TruthFigures:
    """The surface beside a known truth."""

    kind: str
    """What the truth is, such as "a mesh file"."""
    rms_px: float = field(
        metadata=meaning(
            "Distance to the truth, RMS, in pixels",
            "px",
            "Root mean square signed distance from the true surface over the size of a pixel on "
            "the object.",
        )
    )
    alignment: str
    vertices: int
    rms_mm: float = field(
        metadata=meaning(
            "Distance to the truth, RMS",
            LENGTH,
            "Root mean square signed distance of the measured vertices from the true surface, "
            "after the alignment that is stated; no scale is fitted.",
        )
    )
    p95_mm: float = field(
        metadata=meaning(
            "Distance to the truth, 95 %", LENGTH, "95 % quantile of the absolute distance."
        )
    )
    mean_mm: float = field(
        metadata=meaning(
            "Mean signed distance to the truth (bias)",
            LENGTH,
            "Mean signed distance of the measured vertices, by the shortest way, not along radii; "
            "positive: our surface lies outside the truth.",
        )
    )
    median_mm: float
    iqr_mm: float = field(
        metadata=meaning(
            "Interquartile range (IQR)",
            LENGTH,
            "75 % less 25 % quantile of the signed distance.",
        )
    )
    largest_mm: float = field(
        metadata=meaning("Largest distance", LENGTH, "Largest absolute distance.")
    )
    within: dict[str, float] = field(
        metadata={
            "0.1 mm": meaning(
                "Within 0.1 mm",
                SHARE,
                "Share of the measured vertices no farther than 0.1 mm from the truth.",
            ),
            "0.25 mm": meaning(
                "Within 0.25 mm",
                SHARE,
                "Share of the measured vertices no farther than 0.25 mm from the truth.",
            ),
        }
    )
    covered: dict[str, float] = field(
        metadata={
            "0.1 mm": meaning(
                "Covered within 0.1 mm",
                SHARE,
                "Share of the true vertices that three photos or more see with our surface within "
                "0.1 mm.",
            ),
            "0.25 mm": meaning(
                "Covered within 0.25 mm",
                SHARE,
                "Share of the true vertices that three photos or more see with our surface within "
                "0.25 mm.",
            ),
        }
    )
    scale_error: float = field(
        metadata=meaning(
            "Scale error",
            SHARE,
            "By how much our surface is too large: what a similarity would take away on top of the "
            "alignment.",
        )
    )
    girths: tuple[TrueGirth, ...]
    volume_error: float = field(
        metadata=meaning(
            "Volume error",
            SHARE,
            "Of the volume between the 10 % and the 90 % quantile of the seen truth's height.",
        )
    )
    camera_rms_mm: float = field(
        metadata=meaning(
            "Camera places, RMS",
            LENGTH,
            "Distance of the camera centres from the true ones after the same alignment.",
        )
    )
    histogram: DistanceHistogram
    sigma: SigmaTest | None


@dataclass(frozen=True, kw_only=True)
class BudgetPart:
    """One part of the expected error, one standard deviation."""

    part: str
    sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class ExpectedError:
    """The error to expect on the surface, and what it is made of."""

    basis: Literal["vertex sigmas", "points of the scene"]
    rms_mm: float = field(
        metadata=meaning(
            "Expected error, RMS",
            LENGTH,
            "Root mean square distance along the normal that is expected between the measured "
            "surface and the limb, weighted by area.",
        )
    )
    p95_mm: float = field(
        metadata=meaning(
            "Expected error, 95 %",
            LENGTH,
            "Distance along the normal within which 95 % of the measured surface lies from the "
            "limb in 95 of 100 captures, Gaussian errors assumed. From the vertex sigmas where "
            "there are any, and from how well these are known.",
        )
    )
    budget: tuple[BudgetPart, ...]


@dataclass(frozen=True, kw_only=True)
class ExplanationFigures:
    """One of the things that may have happened between two bodies, or to lenses, while the photos
    were taken."""

    bodies: str
    """limb and room, halves, limb and board; lenses: what lenses of photos explain; board: its own
    shape."""
    kind: str
    """step, drift, photo (one alone), sway, or rest: what no term explains; principal point, focal
    length, rolling shutter: each photo has one of its own; camera file: all differ from it; bend:
    the board is no plane."""
    photos: tuple[str, ...]
    """Those that show the second body elsewhere than most do, or have another lens."""
    told: bool
    """Whether it is told as a fact."""
    matters: bool
    """Whether its effect may be as large as shows on the surface."""
    failed: tuple[str, ...]
    """What it did not stand: chance, lens, size, one photo, lenses of photos, model."""
    score: float
    """Twice the logarithm of likelihood that it gains, less what its numbers cost."""
    chance: float
    effect: float
    """Largest motion of a point of the limb, in the case's unit, and its interval of 95 %."""
    low: float
    high: float
    is_share: bool = False
    """Whether these are shares of the focal length instead."""
    variance_before: float
    """Of what both bodies leave, over that of the adjustments; without the term and with it."""
    variance_after: float


@dataclass(frozen=True, kw_only=True)
class MovementFigures:
    """How the limb moved against its surroundings between the photos."""

    kind: str
    """still, step, drift, restless or unknown."""
    found: Finding
    """Whether it kept still."""
    photos: tuple[str, ...]
    """Those that show it elsewhere than the largest group does."""
    alone: bool
    """Whether the photos were placed by the limb's own points alone."""
    misfit: bool
    """Whether limb and surroundings fit worse than chance explains, and only the cause is not
    known: the limb moved, or the lens is another than was found."""
    unexplained: bool
    """Whether something that would show on the surface is not decided: no error is stated."""
    explanations: tuple[ExplanationFigures, ...]
    """Of limb and surroundings, of the limb's halves, of lenses, each the most likely first."""
    shift: float = field(
        metadata=meaning(
            "Movement of the limb",
            LENGTH,
            "Largest shift of the limb's middle against its surroundings between two photos; 0 "
            "where chance explains what is seen.",
        )
    )
    turn_deg: float = field(
        metadata=meaning("Turn of the limb", "deg", "Largest turn that came with the shift.")
    )
    chance: float = field(
        metadata=meaning(
            "Chance of the movement",
            "",
            "That photos without any movement look as much like it (F test, corrected for all "
            "that was tried).",
        )
    )
    bent: Finding | None
    """Whether it kept its shape; None where nobody looked."""
    bending_misfit: bool
    """The same of the limb's two halves."""
    bending: float = field(
        metadata=meaning(
            "Bending of the limb",
            LENGTH,
            "Largest shift of one half of the limb's length against the other, at the middle of "
            "the first, between two photos; 0 where chance explains what is seen.",
        )
    )


@dataclass(frozen=True, kw_only=True)
class Figures:
    """All figures of an assessment."""

    residuals: ResidualFigures
    network: NetworkFigures
    lengths: LengthFigures
    cameras: tuple[LensFigures, ...]
    poses: PoseFigures | None
    surface: SurfaceFigures
    images: ImageFigures
    movement: MovementFigures | None
    truth: TruthFigures | None
    expected: ExpectedError
