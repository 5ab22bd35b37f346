"""Photos: where the pixels are and what EXIF says about the camera. Pixels load on demand.

Pixels are used in the orientation in which the sensor stored them, so that a photo and the
calibration of its camera agree however the camera was held; `quarter_turns` turns a picture
upright for people. Nothing is ever written back to a photo.
"""

import hashlib
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from limbgram.core.errors import Cancelled, LimbgramError
from limbgram.core.notebook import brief
from limbgram.findings import Finding, Value, note


@dataclass(frozen=True, kw_only=True)
class Exif:
    """What the file says about the camera; None where it says nothing."""

    make: str | None = None
    model: str | None = None
    lens: str | None = None
    body: str | None = None
    """Tells one body from others of its model: a hash of its serial number, never that itself."""
    focal_mm: float | None = None
    focal_35mm: float | None = None
    """Focal length that gives the same picture on film of 36 x 24 mm."""
    digital_zoom: float | None = None
    """How much of its sensor's picture the camera enlarged; None where it did not, or is silent."""
    aperture: float | None = None
    subject_m: float | None = None
    """Distance at which the lens says that it was focused."""
    taken: str | None = None
    """When, by the camera's own clock, to the fraction of a second that it tells."""
    quarter_turns: int = 0
    """Clockwise quarter turns that show the stored pixels upright."""
    mirrored: bool = False

    @property
    def turns_of_up(self) -> int:
        """Clockwise quarter turns that bring up to the top; a swap before them reverses them."""
        return -self.quarter_turns % 4 if self.mirrored else self.quarter_turns


@dataclass(frozen=True, kw_only=True)
class Photo:
    """One readable photo; its pixels load with `photos.reading.load_luma` and `load_colour`."""

    name: str
    path: Path
    width_px: int
    height_px: int
    exif: Exif
    sha256: str
    camera_idx: int
    """Group of photos from one camera at one size (`PhotoSet.cameras`)."""
    mask_path: Path | None = None
    mask_told: bool = True
    """False where the mask may have been drawn on the photo as stored or as seen."""
    cut_out: bool = False
    """Whether its own opacity hides a part of it (`photos.masks.load_mask`)."""
    bits: int | None = None
    """Of sixteen bits a sample, those that the capture uses; None of a photo with eight."""
    sharpness: float = float("nan")
    """Width of the sharpest edges, px (smaller is sharper); see `photos.quality`."""
    burnt: float = float("nan")
    """Share of what it shows that is at the upper end of the scale, 0 to 1 (`photos.quality`)."""
    brightest: float = float("nan")
    """Luma that one pixel in a hundred of what it shows exceeds, 0 to 255."""

    @property
    def masked(self) -> bool:
        """Whether only a part of it is to be used."""
        return self.mask_path is not None or self.cut_out


@dataclass(frozen=True)
class SetAside:
    """A part that was left out, and why: told to the user by name."""

    name: str
    reason: Finding


def left_out(set_aside: Sequence[SetAside]) -> tuple[Finding, ...]:
    """What was left out and why, each to go on a line of its own (`{left_out:lines}`)."""
    return tuple(note("photo.left_out", name=one.name, reason=one.reason) for one in set_aside)


@contextmanager
def naming_left_out(set_aside: Sequence[SetAside]) -> Generator[None]:
    """Have a refusal name what was left out as well: there the cause may lie."""
    try:
        yield
    except Cancelled:
        raise
    except LimbgramError as refusal:
        if not set_aside:
            raise
        raise type(refusal)(
            "photo.some_left_out", refusal=refusal.finding, left_out=left_out(set_aside)
        ) from refusal


@dataclass(frozen=True, kw_only=True)
class CameraGroup:
    """Photos of one camera at one size and focal length."""

    label: str
    width_px: int
    height_px: int
    exif: Exif
    longer: float | None = None
    """Focal length over that of the other photos, where these tell two lenses and files do not."""
    cut_out: bool = False
    """Whether what they show tells that they were cut out of larger ones, though no size does."""
    file_px: tuple[int, int] | None = None
    """Width and height of the photos that these are small copies of; None of photos themselves."""


_LISTED_AT_MOST = 6


def first_of(names: Sequence[str], most: int = _LISTED_AT_MOST) -> dict[str, Value]:
    """The first few names, and how many more there are: values of a finding."""
    return {"names": tuple(names[:most]), "more": max(len(names) - most, 0)}


def digest_of(sha256s: Iterable[str]) -> str:
    """Hash of photos' own hashes, in the order of their names."""
    return hashlib.sha256("".join(sha256s).encode()).hexdigest()


@dataclass(frozen=True)
class PhotoSet:
    """The photos of one capture, sorted by name, and the files that were set aside."""

    photos: tuple[Photo, ...]
    cameras: tuple[CameraGroup, ...]
    set_aside: tuple[SetAside, ...] = ()

    __repr__ = brief

    @property
    def digest(self) -> str:
        """Hash of the photos' own hashes: tells one capture from another without any name."""
        return digest_of(photo.sha256 for photo in self.photos)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(photo.name for photo in self.photos)

    @property
    def quarter_turns(self) -> tuple[int, ...]:
        """Of each photo, as `Exif.turns_of_up`."""
        return tuple(photo.exif.turns_of_up for photo in self.photos)
