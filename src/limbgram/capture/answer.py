"""Answer: the check of a capture while the patient is still there."""

from dataclasses import dataclass

from limbgram.core.notebook import brief
from limbgram.findings import Finding
from limbgram.reconstruction.photos.photo import SetAside


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
