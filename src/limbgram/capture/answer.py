"""Answer: the check of a capture while the patient is still there, and its criteria."""

from dataclasses import dataclass, field

from limbgram.core.notebook import brief
from limbgram.findings import Finding
from limbgram.reconstruction.features.detection import (
    FeatureOptions,
)
from limbgram.reconstruction.photos.photo import SetAside


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """Criteria by which a capture counts as good."""

    features: FeatureOptions = field(
        default_factory=lambda: FeatureOptions(max_keypoints=4000, max_megapixels=0.8)
    )
    max_gap_deg: float = 40.0
    """Widest angle between neighbouring photos that count, unless"""
    max_gap_ratio: float = 1.4
    """the mean gap of the fullest ring is nearly as wide: few photos, evenly spread, up to"""
    widest_gap_deg: float = 60.0
    """this angle, up to which the verdict of a case stays green; where nothing else is amiss, wider
    gaps than those two are advice up to here."""
    step_deg: float = 24.0
    """Between the photos that are asked for."""
    min_board_photos: int = 3
    """Photos in which the scale board must be found."""
    least_photos: int = 2
    """That a place must be seen by: fewer do not measure it;"""
    wanted_photos: int = 3
    """and so many where photos are asked for anyway."""
    max_unseen: float = 0.05
    """Share of the limb that fewer photos may see: what the verdict of a case allows."""
    max_sigma_mm: float = 0.3
    """Expected sigma beyond which a place is called unsure: 0.6 mm in 95 of 100, the same."""
    widest_pair_deg: float = 35.0
    """Between two photos that show a place squarely: up to here depth is found in most places."""
    fewest_round: int = 10
    """Photos that must count all the way round. Three rings of 9 were refused or red, one of them
    after a GO; of 11 rings of 10 the six that showed the board well came out good."""
    max_thin: float = 0.3
    """Share of the limb for which all of them may stand wider. Ten good captures of 10 to 12 photos
    have 0.11 at most; one of 9, with 0.73, came out full of holes."""
    most_added: int = 6
    """Photos that are asked for at a time because of places that too few see."""


DEFAULTS = CheckOptions()


@dataclass(frozen=True, kw_only=True)
class CheckedPhoto:
    """One photo as far as it was checked."""

    name: str
    placed: bool
    points: int
    """Scene points seen in it."""
    edge_px: float
    """Width of the sharpest edges on the limb, px of the photo; NaN where it is not placed."""
    burnt: float
    """Share of the limb that is burnt out."""
    features_per_cm2: float
    """Keypoints of the small copy on the limb; NaN where the size is not known."""
    azimuth_deg: float
    """From above, counter-clockwise from the first placed photo; NaN where it is not placed."""
    elevation_deg: float
    """Of the camera above level, seen from the limb's middle."""
    counts: bool
    """Whether it is placed, sharp and well exposed."""
    remarks: tuple[Finding, ...]


@dataclass(frozen=True, kw_only=True)
class MissingPhotos:
    """Photos to add, and from where."""

    count: int
    azimuths_deg: tuple[float, ...]
    elevations_deg: tuple[float, ...]
    """Above level, one for each azimuth."""
    between: tuple[str, str] | None
    """Photos on either side of a gap; None where a place is seen by too few."""
    asked: Finding
    """The same as a request."""


@dataclass(frozen=True, kw_only=True)
class CoveredRegion:
    """A part of the limb: a third of its height, and the side that faces an hour; or its end."""

    name: Finding
    photos: int
    """That measure the middle one of its cells, six at most."""
    unseen: float
    """Share of it that fewer than two photos see."""
    sigma_mm: float
    """Expected, of its middle cell; NaN where it is not measured or there is no size."""


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """What the photos that count will measure, on the limb's proxy, cell by cell.

    Rows from below upwards, the last ones on the upper end; columns counter-clockwise, azimuth 0
    first. None stands for what is not measured, or is no part of the limb.
    """

    rows: int
    side_rows: int
    columns: int
    photos: tuple[tuple[int | None, ...], ...]
    """Photos that show the cell squarely enough, six at most."""
    sigma_mm: tuple[tuple[float | None, ...], ...]
    places: tuple[tuple[tuple[float, float, float], ...], ...]
    """Middles of the cells in the scene."""
    length: float
    """Of the limb along its axis, in the scene's unit."""
    radius: float
    measured: float
    """Share of the limb that two photos or more see."""
    well: float
    """Share that three or more see."""
    sigma_middle_mm: float
    """Half of what is measured is expected to be surer; NaN where there is no size."""
    regions: tuple[CoveredRegion, ...]
    weakest: Finding | None
    """The region with the least sure middle; None where there is none."""

    __repr__ = brief


@dataclass(frozen=True, kw_only=True)
class CaptureCheck:
    """The answer of a check, and what it is based on."""

    go: bool
    headline: Finding
    """The answer in one line."""
    findings: tuple[Finding, ...]
    """What stands in the way of GO."""
    photos: tuple[CheckedPhoto, ...]
    missing: tuple[MissingPhotos, ...]
    largest_gap_deg: float
    """Between photos that count; NaN where they could not be joined."""
    board_photos: int | None
    """Photos in which the board was found; None where none was looked for."""
    coverage: Coverage | None = None
    """None where the limb was not found."""
    notes: tuple[Finding, ...] = ()
    """What does not stand in the way of GO and is worth a look."""
    kept_still: bool | None = None
    """Whether the limb kept still and kept its shape; None where that is not known: while the ring
    is open nobody looks."""
    set_aside: tuple[SetAside, ...] = ()
    """Files that were not looked at, and why; the notes say it in words."""

    __repr__ = brief
