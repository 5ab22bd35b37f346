"""Checking: whether a capture is good, while the patient is still there.

In      the photos, smaller copies of them, the calibrations and the scale board.
Out     a CaptureCheck: GO, or which photos to add and from where; every photo with what is wrong.
Method  The small copies are placed by the stages of a reconstruction. The points at which the
        cameras aim are the limb; sharpness and exposure are measured at full size where it lies in
        each photo, not on the room. A photo counts for the ring if it is placed, sharp and well
        exposed; the angles between those that count, seen from above, show what is missing.
Fails   never on photos that cannot be joined or scaled: that is its answer. PhotoError as reading.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import (
    CalibrationError,
    MatchingError,
    PlacementError,
    RegionError,
    ScaleError,
)
from limbgram.core.geometry.arrays import Points3
from limbgram.core.run import Run, in_parallel
from limbgram.reconstruction.calibration.cameras import Calibration, cameras_for
from limbgram.reconstruction.dense.region import limb_among
from limbgram.reconstruction.features.detection import FeatureOptions, Features, detect
from limbgram.reconstruction.mapping.ring import place
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.matching.matching import match
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import Photo, PhotoSet
from limbgram.reconstruction.photos.quality import (
    QualityOptions,
    brightest_luma,
    burnt_share,
    common_fault,
    edge_width_px,
    remarks,
)
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.finding import find_board
from limbgram.reconstruction.twoview.verification import verify

_FEWEST_LIMB_POINTS = 50
_ABOVE_FLOOR_MM = 3.0
_LOOKING_BYTES = 40
"""Bytes a pixel while the sharpness of a part of a photo is looked at."""


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """When a capture is called good."""

    features: FeatureOptions = field(default_factory=lambda: FeatureOptions(max_keypoints=4000))
    quality: QualityOptions = field(default_factory=QualityOptions)
    max_gap_deg: float = 40.0
    """Widest angle between neighbouring photos that count."""
    step_deg: float = 24.0
    """Between the photos that are asked for."""
    min_board_photos: int = 3
    """Photos in which the scale board must be found."""


DEFAULTS = CheckOptions()


@dataclass(frozen=True, kw_only=True)
class CheckedPhoto:
    """One photo as far as it was looked at."""

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
    counts: bool
    """Whether it is placed, sharp and well exposed."""
    remarks: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MissingPhotos:
    """Photos to add, and from where."""

    count: int
    azimuths_deg: tuple[float, ...]
    between: tuple[str, str]
    words: str


@dataclass(frozen=True, kw_only=True)
class CaptureCheck:
    """The answer, and what it rests on."""

    go: bool
    headline: str
    """The answer in one line."""
    findings: tuple[str, ...]
    """What stands in the way of GO."""
    photos: tuple[CheckedPhoto, ...]
    missing: tuple[MissingPhotos, ...]
    largest_gap_deg: float
    """Between photos that count; NaN where they could not be joined."""
    board_photos: int | None
    """Photos in which the board was found; None where none was looked for."""


def check_capture(
    photos: PhotoSet,
    small: PhotoSet,
    calibrations: Sequence[Calibration],
    board: Board | None,
    options: CheckOptions = DEFAULTS,
    run: Run | None = None,
) -> CaptureCheck:
    """Whether these photos will give a surface, all round and in millimetres.

    Args:
        small: The same photos in the same order, reduced.
    """
    run = run or Run()
    try:
        cameras = run(cameras_for, small, calibrations)
        features = run(detect, small, options.features)
        matches = run(match, small, features)
        pairs = run(verify, small, matches, cameras)
        scene = run(place, small, features, pairs, cameras)
    except (CalibrationError, MatchingError, PlacementError) as refusal:
        return _refused(photos, str(refusal), options)
    findings: list[str] = []
    detections = None if board is None else run(find_board, small, board)
    board_photos = None if detections is None else len(detections.photos)
    try:
        metric = to_millimetres(scene, detections, (), cameras=cameras)
    except ScaleError as refusal:
        findings.append(str(refusal))
        metric = to_millimetres(scene)
    if board_photos is not None and board_photos < options.min_board_photos and not findings:
        findings.append(
            f"The scale board is found in {board_photos} photos; {options.min_board_photos} are "
            "needed. Lay it flat beside the limb and take photos that show all of it."
        )
    try:
        limb = _limb_of(metric)
    except RegionError as refusal:
        findings.append(str(refusal))
        limb = metric.scene.points_in_world
    looked_at = run(look_at_limb, photos, small, features, metric, limb)
    fault = common_fault([one.photo for one in looked_at if one.placed], options.quality)
    if fault is not None:
        findings.append(fault)
    checked, missing = _judged(photos, looked_at, metric.scene, limb, options)
    gap_deg = max(_gaps_deg([one.azimuth_deg for one in checked if one.counts]), default=math.nan)
    findings += [one.words for one in missing]
    ring = metric.scene.ring
    if not missing and ring is not None and not ring.closed:
        findings.append(
            f"Neighbouring photos share few points: {ring.weakest_bridge} join the two sides of "
            "the weakest place. Paint the sock more densely there, or take more photos between."
        )
    placed = sum(one.placed for one in checked)
    facts = f"{placed} of {len(checked)} photos placed, largest gap {gap_deg:.0f} degrees"
    if board_photos is not None:
        facts += f", board in {board_photos}"
    return CaptureCheck(
        go=not findings,
        headline=f"GO: {facts}." if not findings else f"NOT YET: {findings[0]}",
        findings=tuple(findings),
        photos=checked,
        missing=missing,
        largest_gap_deg=float(gap_deg),
        board_photos=board_photos,
    )


@dataclass(frozen=True)
class _LookedAt:
    """A photo with its figures where the limb lies in it."""

    photo: Photo
    placed: bool
    features_per_cm2: float


def _limb_of(metric: MetricScene) -> Points3:
    """The points of what the cameras aim at, above the floor."""
    scene = metric.scene
    points = scene.points_in_world
    aim = aim_of(scene.views, points)
    if metric.floor_z_mm is not None:
        above = _ABOVE_FLOOR_MM if metric.scale.unit == "mm" else 0.0
        points = points[points[:, 2] > metric.floor_z_mm + above]
    return limb_among(points, aim, _FEWEST_LIMB_POINTS).points_mm


def look_at_limb(
    photos: PhotoSet, small: PhotoSet, features: Features, metric: MetricScene, limb: Points3
) -> list[_LookedAt]:
    """Sharpness and exposure at full size where the limb lies, and how dense its texture is."""
    scene = metric.scene

    def look(idx: int) -> _LookedAt:
        photo = photos.photos[idx]
        if scene.camera_from_world[idx] is None:
            return _LookedAt(photo, False, math.nan)
        view = scene.view(idx)
        xy_px = view.project(limb)
        inside = np.isfinite(xy_px).all(axis=1) & view.camera.contains(xy_px)
        if inside.sum() < 3:
            return _LookedAt(photo, True, math.nan)
        hull = cv2.convexHull(xy_px[inside].astype(np.float32))
        factor = photo.width_px / small.photos[idx].width_px
        left, top, width, height = (
            round(side * factor) for side in cv2.boundingRect(np.round(hull).astype(np.int32))
        )
        luma = load_luma(photo)[max(top, 0) : top + height, max(left, 0) : left + width]
        seen = replace(
            photo,
            sharpness=edge_width_px(luma),
            burnt=burnt_share(luma),
            brightest=brightest_luma(luma),
        )
        within = [
            cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0
            for x, y in features.keypoints[idx].xy_px
        ]
        density = math.nan
        if metric.scale.unit == "mm":
            away_mm = float(np.linalg.norm(view.centre_in_world - np.median(limb, axis=0)))
            pixel_cm = 0.1 * away_mm / view.camera.fx
            density = sum(within) / max(cv2.contourArea(hull) * pixel_cm**2, 1e-9)
        return _LookedAt(seen, True, density)

    each_mb = in_flight_mb(photos.photos, _LOOKING_BYTES)
    return in_parallel(look, range(len(photos.photos)), each_mb=each_mb)


def _judged(
    photos: PhotoSet,
    looked_at: Sequence[_LookedAt],
    scene: Scene,
    limb: Points3,
    options: CheckOptions,
) -> tuple[tuple[CheckedPhoto, ...], tuple[MissingPhotos, ...]]:
    """Every photo with what is wrong, and the photos that are missing between those that count."""
    on_limb = replace(photos, photos=tuple(one.photo for one in looked_at))
    said: dict[str, list[str]] = {}
    for remark in remarks(on_limb, options.quality):
        said.setdefault(remark.name, []).append(remark.text)
    azimuths_deg = _azimuths_deg(scene, limb)
    checked: list[CheckedPhoto] = []
    for idx, one in enumerate(looked_at):
        verdict = scene.verdicts[idx]
        told = said.get(one.photo.name, [])
        bad = any(text.startswith(("blurred", "overexposed", "underexposed")) for text in told)
        checked.append(
            CheckedPhoto(
                name=one.photo.name,
                placed=one.placed,
                points=verdict.points,
                edge_px=one.photo.sharpness if one.placed else math.nan,
                burnt=one.photo.burnt,
                features_per_cm2=one.features_per_cm2,
                azimuth_deg=float(azimuths_deg[idx]),
                counts=one.placed and not bad,
                remarks=(*([verdict.reason] if verdict.reason else []), *told),
            )
        )
    return tuple(checked), _missing(checked, options)


def _azimuths_deg(scene: Scene, limb: Points3) -> Float64[np.ndarray, " p"]:
    """Seen from above, counter-clockwise from the first placed photo; NaN where not placed."""
    found = np.full(len(scene.names), np.nan)
    middle = np.median(limb, axis=0)
    for idx in scene.placed:
        x, y, _ = scene.view(idx).centre_in_world - middle
        found[idx] = np.degrees(np.arctan2(y, x))
    return (found - found[scene.placed[0]]) % 360.0


def _gaps_deg(azimuths_deg: Sequence[float]) -> Float64[np.ndarray, " n"]:
    """From each photo, in their order round, to the next one."""
    around = np.sort(np.asarray(azimuths_deg, float))
    if not len(around):
        return np.zeros(0)
    return np.diff(around, append=around[0] + 360.0)


def _missing(checked: Sequence[CheckedPhoto], options: CheckOptions) -> tuple[MissingPhotos, ...]:
    around = sorted((one for one in checked if one.counts), key=lambda one: one.azimuth_deg)
    first = next((one.name for one in checked if one.placed), "")
    found: list[MissingPhotos] = []
    gaps = _gaps_deg([one.azimuth_deg for one in around])
    for one, following, gap in zip(around, [*around[1:], *around[:1]], gaps):
        if gap <= options.max_gap_deg:
            continue
        count = math.ceil(gap / options.step_deg) - 1
        places = tuple(
            float((one.azimuth_deg + gap * k / (count + 1)) % 360) for k in range(1, count + 1)
        )
        hours = ", ".join(dict.fromkeys(_clock(place) for place in places))
        words = (
            f"Add {count} photo{'s' if count > 1 else ''} between {one.name} and "
            f"{following.name}, where {gap:.0f} degrees are empty: at {hours} o'clock as seen from "
            f"above, where {first} stands at 12."
        )
        found.append(
            MissingPhotos(
                count=count, azimuths_deg=places, between=(one.name, following.name), words=words
            )
        )
    return tuple(sorted(found, key=lambda one: -one.count))


def _clock(azimuth_deg: float) -> str:
    """The hour at which a place stands, 12 where azimuth is 0; clocks turn clockwise."""
    return str(round(-azimuth_deg / 30.0) % 12 or 12)


def _refused(photos: PhotoSet, why: str, options: CheckOptions) -> CaptureCheck:
    said: dict[str, list[str]] = {}
    for remark in remarks(photos, options.quality):
        said.setdefault(remark.name, []).append(remark.text)
    return CaptureCheck(
        go=False,
        headline=f"NOT YET: {why}",
        findings=(why,),
        photos=tuple(
            CheckedPhoto(
                name=photo.name,
                placed=False,
                points=0,
                edge_px=math.nan,
                burnt=photo.burnt,
                features_per_cm2=math.nan,
                azimuth_deg=math.nan,
                counts=False,
                remarks=tuple(said.get(photo.name, ())),
            )
            for photo in photos.photos
        ),
        missing=(),
        largest_gap_deg=math.nan,
        board_photos=None,
    )
