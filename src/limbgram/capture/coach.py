"""Coach: whether a capture is good, while the patient is still there.

In      the photos, smaller copies of them, the calibrations and the scale board.
Out     a CaptureCheck: GO, or which photos to add and from where; every photo with what is wrong;
        how sure the surface will be in each place.
Method  The small copies are placed by the stages of a reconstruction. The points at which the
        cameras aim are the limb; sharpness and exposure are measured at full size where it lies in
        each photo, not on the room. A photo counts if it is placed, sharp and well exposed. The
        angles between those that count, seen from above, show what is missing round the limb: what
        the verdict of the case would name holds the answer back, narrower gaps are advice. A
        proxy through its points, in cells, shows what too few photos see, and the expected sigma
        of each cell follows from the photos that see it (`prediction`).
        Where the limb turns before a still camera, what stands still in the pictures is left out,
        as in a reconstruction; a board that stands still tells no size.
        A Coach keeps what was found of each photo and each pair, so that one more photo costs the
        work on that photo.
Fails   never on photos that cannot be joined or scaled: that is its answer. PhotoError as reading.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64

from limbgram.capture.camera_positions import (
    Stand,
    clock,
    height_of,
    shows_squarely,
    stand_of,
    stands_to_add,
)
from limbgram.capture.prediction import Prediction, Showing, narrowest_deg, predict
from limbgram.capture.proxy import COLUMNS, LimbProxy, gaps_mm, proxy_of
from limbgram.core.errors import (
    CalibrationError,
    MatchingError,
    PlacementError,
    RegionError,
    ScaleError,
)
from limbgram.core.geometry.arrays import GreyImage, Points3, Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.interval import COVER
from limbgram.core.notebook import brief
from limbgram.core.run import Run, in_parallel
from limbgram.findings import Finding, Gravity, Value, doubt, fault, note
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras, cameras_for
from limbgram.reconstruction.dense.region import (
    RegionOptions,
    aimed_at,
    limb_among,
    refuse_few,
)
from limbgram.reconstruction.features.detection import (
    FeatureOptions,
    Features,
    Keypoints,
    detect,
)
from limbgram.reconstruction.mapping.ring import MappingOptions
from limbgram.reconstruction.mapping.scene import Movement, Scene
from limbgram.reconstruction.mapping.zoom import zoomed_photos
from limbgram.reconstruction.matching.matching import (
    Candidate,
    MatchedPair,
    Matches,
    joined,
    match_pairs,
    pairs_worth_matching,
)
from limbgram.reconstruction.matching.static_background import Still, find_still
from limbgram.reconstruction.movement import bending_found, lens_doubt, movement_found
from limbgram.reconstruction.photo_lenses import lenses_told
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.lenses import lens_notes
from limbgram.reconstruction.photos.masks import load_mask, mask_notes
from limbgram.reconstruction.photos.photo import Photo, PhotoSet, SetAside
from limbgram.reconstruction.photos.quality import (
    SPOILT,
    QualityOptions,
    brightest_luma,
    burnt_share,
    common_fault,
    edge_width_px,
    exposed_in,
    remarks,
)
from limbgram.reconstruction.pipeline import PipelineOptions, Placing, by_the_limb
from limbgram.reconstruction.poses import Poses, board_of_object, place_object
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.verification import TwoViewOptions, verify

_FEWEST_LIMB_POINTS = 50
_ABOVE_FLOOR_MM = 3.0
_BLOCKS_ACROSS = 240
_SAME_BOX = 0.05
"""Of its sides: a limb that lies no further off in a photo than this was looked at already."""
_OTHER_RING_DEG = 8.0
"""Between the heights of photos of one ring and those of the next: hands waver by half of it."""
_BARE_PX = 24.0
"""Pixels of the small copies to the nearest feature point beyond which paint is missing: measured
surfaces are 1.7 times less sure there than where paint is dense."""
_BARE_SHARE = 0.25
"""Of a region that lies so far from paint: less is a gap between dabs."""
_SQUARELY_DEG = 65.0
"""Between normal and ray: photos that measure a place."""
_LOOKING_BYTES = 40
"""Bytes a pixel while the sharpness of a part of a photo is looked at."""


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """When a capture is called good."""

    features: FeatureOptions = field(
        default_factory=lambda: FeatureOptions(max_keypoints=4000, max_megapixels=0.8)
    )
    quality: QualityOptions = field(default_factory=QualityOptions)
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


@dataclass(frozen=True, kw_only=True)
class CaptureCheck:
    """The answer, and what it rests on."""

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
    return Coach(calibrations, board, options).check(photos, small, run)


class Coach:
    """Checks a capture again and again while it grows, and keeps what it knows of each photo.

    A photo is known by its content. A pair keeps the matches of when it was first compared.
    """

    def __init__(
        self,
        calibrations: Sequence[Calibration],
        board: Board | None,
        options: CheckOptions = DEFAULTS,
    ) -> None:
        self._calibrations = tuple(calibrations)
        self._board = board
        self._options = options
        self._keypoints: dict[str, Keypoints] = {}
        self._matched: dict[tuple[str, str], MatchedPair] = {}
        self._verified: dict[tuple[str, str], VerifiedPair | None] = {}
        self._standing: dict[str, Bool[np.ndarray, " n"]] = {}
        self._seen: dict[str, _Looked] = {}

    def check(self, photos: PhotoSet, small: PhotoSet, run: Run | None = None) -> CaptureCheck:
        """Whether these photos are good; those known from an earlier check cost little."""
        found = self._checked(photos, small, run or Run())
        aside = (note("coach.left_out", name=k.name, reason=k.reason) for k in photos.set_aside)
        notes = (*aside, *mask_notes(photos), *found.notes)
        return replace(found, notes=notes, set_aside=photos.set_aside)

    def _checked(self, photos: PhotoSet, small: PhotoSet, run: Run) -> CaptureCheck:
        options = self._options
        try:
            cameras = run(cameras_for, photos, self._calibrations).reduced(small.cameras)
            features = self._features(small, run)
            still = run(find_still, features)
            features = still.moving(features)
            self._forget_changed(small, still)
            matches, pairs = self._pairs(small, features, cameras, run)
            detections = None if self._board is None else run(find_board, small, self._board)
            mapping, twoview = MappingOptions(), TwoViewOptions()
            placed = place_object(
                small, features, matches, pairs, cameras, detections, run, mapping, twoview
            )
        except (CalibrationError, MatchingError, PlacementError) as refusal:
            return _refused(photos, refusal.finding, options)
        if placed.lenses is not None:
            small, cameras = placed.lenses.photos, placed.lenses.cameras
        poses = placed.poses
        placing = Placing(features, placed.matches, placed.pairs, placed.scene, still, poses)
        if placed.scene.ring is not None and placed.scene.ring.closed:
            # while it is open, more photos are to come, and an arc bends as if the limb moved
            settled = by_the_limb(small, cameras, placing, detections, PipelineOptions(), run)
            placing, detections = settled.placing, settled.found
        findings: list[Finding] = []
        scene = placing.scene
        if detections is not None and (still.groups or poses.sides):
            detections = board_of_object(detections, still, poses)
        board_photos = None if detections is None else len(detections.photos)
        try:
            metric = to_millimetres(scene, detections, (), cameras=cameras)
        except ScaleError as refusal:
            findings.append(refusal.finding)
            metric = to_millimetres(scene)
        if board_photos is not None and board_photos < options.min_board_photos and not findings:
            least = options.min_board_photos
            findings.append(fault("coach.board_unseen", photos=board_photos, least=least))
        found = True
        try:
            limb = limb_shown(metric)
        except RegionError as refusal:
            findings.append(refusal.finding)
            limb, found = metric.scene.points_in_world, False
        looked_at = run(look_at_limb, photos, small, features, metric, limb, self._seen)
        seen = _Seen(photos, small, metric, limb, looked_at, found)
        motion = motion_told(metric, limb)
        findings += motion.findings(cameras)
        lenses = tuple(lenses_told(metric.scene, cameras))
        findings += [one for one in lenses if one.gravity is Gravity.FAULT]
        answer = _answer(seen, findings, board_photos, options)
        turned = (*_turning_notes(still), *_turned_over_notes(poses, small))
        said = (one for one in lenses if one.gravity is not Gravity.FAULT)
        notes = (*motion.notes(), *answer.notes, *turned, *lens_notes(small), *said)
        return replace(answer, notes=notes, kept_still=_kept_still(metric.scene))

    def _features(self, small: PhotoSet, run: Run) -> Features:
        """Keypoints of all photos; only new ones are looked for."""
        new = tuple(one for one in small.photos if one.sha256 not in self._keypoints)
        if new:
            found = run(detect, replace(small, photos=new), self._options.features)
            self._keypoints |= {one.sha256: own for one, own in zip(new, found.keypoints)}
        return Features(tuple(self._keypoints[one.sha256] for one in small.photos))

    def _forget_changed(self, small: PhotoSet, still: Still) -> None:
        """Drop what is known of pairs of photos in which other keypoints stand still than before.

        What stands still is told the better the more photos a still camera took; matches count
        the keypoints that are left.
        """
        flags = still.keypoints or [
            np.zeros(len(self._keypoints[one.sha256]), np.bool_) for one in small.photos
        ]
        now = {one.sha256: own for one, own in zip(small.photos, flags, strict=True)}
        changed = {
            name
            for name, own in now.items()
            if name in self._standing and not np.array_equal(self._standing[name], own)
        }
        self._standing |= now
        if changed:
            self._matched = {k: v for k, v in self._matched.items() if not changed & {*k}}
            self._verified = {k: v for k, v in self._verified.items() if not changed & {*k}}

    def _pairs(
        self, small: PhotoSet, features: Features, cameras: Cameras, run: Run
    ) -> tuple[Matches, Pairs]:
        """Matches and verified pairs; only what was not compared before is matched."""

        def named(first: int, second: int) -> tuple[str, str]:
            return small.photos[first].sha256, small.photos[second].sha256

        candidates = run(pairs_worth_matching, small, features)
        new = tuple(c for c in candidates if named(c.first, c.second) not in self._matched)
        for one in run(match_pairs, small, features, new) if new else ():
            self._matched[named(one.pair.first, one.pair.second)] = one
        matched = [_renumbered(self._matched[named(c.first, c.second)], c) for c in candidates]
        matches = joined(small, matched)
        fresh = [p for p in matches.pairs if named(p.first, p.second) not in self._verified]
        if fresh:
            held = run(verify, small, replace(matches, pairs=tuple(fresh)), cameras)
            self._verified |= {named(pair.first, pair.second): None for pair in fresh}
            for one in held.verified:
                self._verified[named(one.matches.first, one.matches.second)] = one
        verified: list[VerifiedPair] = []
        for pair in matches.pairs:
            kept = self._verified[named(pair.first, pair.second)]
            if kept is not None:
                own = replace(kept.matches, first=pair.first, second=pair.second)
                verified.append(replace(kept, matches=own))
        return matches, Pairs(tuple(verified), matches.pairs_tried - len(verified))


def _kept_still(scene: Scene) -> bool | None:
    """Whether the limb kept still and kept its shape; None where either is not known."""
    seen = (scene.movement, scene.bending)
    if any(one is not None and one.moved for one in seen):
        return False
    if any(one is None or one.kind == "unknown" for one in seen):
        return None
    return True


@dataclass(frozen=True)
class MotionTold:
    """How the limb moved and bent, in a unit that means something to people."""

    scene: Scene
    unit: str

    def findings(self, cameras: Cameras) -> Iterator[Finding]:
        """That the limb bent, or moved where its own points do not place the photos."""
        scene, unit = self.scene, self.unit
        movement, bending = scene.movement, scene.bending
        if movement is not None and movement.moved and not movement.alone:
            yield fault("coach.moved", how=movement_found(movement, scene.names, unit))
        if bending is not None and bending.moved:
            lens = lens_doubt(scene, cameras)
            yield fault("coach.bent", how=bending_found(bending, scene.names, unit, lens))

    def notes(self) -> Iterator[Finding]:
        """That it moved as one piece, or what lies round it did: the surface will do without."""
        scene, unit = self.scene, self.unit
        movement = scene.movement
        if movement is not None and movement.moved and movement.alone:
            yield doubt("coach.moved_alone", how=movement_found(movement, scene.names, unit))
        elif movement is not None and (movement.beside or movement.pushed or movement.misfit):
            yield movement_found(movement, scene.names, unit)
        if scene.bending is not None and scene.bending.misfit:
            yield bending_found(scene.bending, scene.names, unit)


def motion_told(metric: MetricScene, limb: Points3) -> MotionTold:
    """In mm, or as shares of the limb's length where nothing gives a size.

    Args:
        limb: Points of what the cameras aim at.
    """
    scene = metric.scene
    if metric.scale.unit == "mm":
        return MotionTold(scene, "mm")
    middle = limb - limb.mean(axis=0)
    axis = np.linalg.svd(middle, full_matrices=False)[2][0]
    in_length = 100.0 / float(np.ptp(middle @ axis))

    def shares(movement: Movement | None) -> Movement | None:
        return None if movement is None else movement.scaled(in_length)

    told = replace(scene, movement=shares(scene.movement), bending=shares(scene.bending))
    return MotionTold(told, "% of the limb's length")


def _turning_notes(still: Still) -> tuple[Finding, ...]:
    """What a still camera was seen by, and what the hours mean then."""
    if not still.groups:
        return ()
    return (*still.notes, note("coach.turn_the_limb"))


def _turned_over_notes(poses: Poses, small: PhotoSet) -> tuple[Finding, ...]:
    """That the hours of a photo count for its own pose of the object."""
    if not poses.sides:
        return ()
    return (note("coach.turned_over", sides=poses.names(small)),)


def _renumbered(known: MatchedPair, candidate: Candidate) -> MatchedPair:
    """The same matches; photos have other numbers once one comes between."""
    pair = replace(known.pair, first=candidate.first, second=candidate.second)
    return replace(known, pair=pair)


def _answer(
    seen: "_Seen", findings: list[Finding], board_photos: int | None, options: CheckOptions
) -> CaptureCheck:
    """All that was found, as one answer."""
    scene = seen.metric.scene
    spoilt = common_fault([one.photo for one in seen.looked_at if one.placed])
    if spoilt is not None:
        findings.append(spoilt)
    zoomed = [one.name for one in scene.verdicts if one.remark]
    if zoomed:
        findings.append(zoomed_photos(zoomed, len(scene.names)))
    checked, missing = _judged(seen.photos, seen.looked_at, scene, seen.limb, options)
    gap_deg = max(_gaps_deg([one.azimuth_deg for one in checked if one.counts]), default=math.nan)
    ring = scene.ring
    shown = _shown(seen, checked, options) if seen.found else None
    asked: tuple[MissingPhotos, ...] = ()
    said: list[Finding] = []
    notes: tuple[Finding, ...] = ()
    if shown is not None:
        asked, said, notes = _asked_for(shown, seen.metric, checked, missing, options)
    closed = ring is not None and ring.closed
    if closed and not findings and not said and _may_stay(missing, checked, options):
        advice = (note("coach.surer", asked=one.asked) for one in missing)
        missing, notes = (), (*advice, *notes)
    findings += [one.asked for one in missing]
    if not missing and ring is not None and not closed:
        findings.append(fault("coach.weak_bridge", points=ring.weakest_bridge))
    findings += said
    counting = sum(one.counts for one in checked)
    if not findings and counting < options.fewest_round:
        findings.append(fault("coach.few_count", counting=counting, least=options.fewest_round))
    expected_mm = None
    if shown is not None and math.isfinite(shown.coverage.sigma_middle_mm):
        expected_mm = COVER * shown.coverage.sigma_middle_mm
    go = note(
        "coach.go",
        placed=sum(one.placed for one in checked),
        photos=len(checked),
        gap_deg=float(gap_deg),
        board=board_photos,
        expected_mm=expected_mm,
    )
    return CaptureCheck(
        go=not findings,
        headline=go if not findings else fault("coach.not_yet", why=findings[0]),
        findings=tuple(findings),
        photos=checked,
        missing=(*missing, *asked),
        largest_gap_deg=float(gap_deg),
        board_photos=board_photos,
        coverage=None if shown is None else shown.coverage,
        notes=notes,
    )


@dataclass(frozen=True)
class _LookedAt:
    """A photo with its figures where the limb lies in it."""

    photo: Photo
    placed: bool
    features_per_cm2: float
    slopes: "_Slopes | None" = None


@dataclass(frozen=True)
class _Seen:
    """What an answer is made of."""

    photos: PhotoSet
    small: PhotoSet
    metric: MetricScene
    limb: Points3
    looked_at: Sequence[_LookedAt]
    found: bool
    """Whether these points are the limb; otherwise they are all there are."""


@dataclass(frozen=True)
class _Slopes:
    """Mean square of the grey slope in blocks of a full-size photo, grey levels a pixel."""

    energy: Float32[np.ndarray, "h w"]
    block_px: float
    """Side of a block, full-size pixels."""

    @classmethod
    def of(cls, luma: GreyImage) -> "_Slopes":
        across = cv2.Sobel(luma, cv2.CV_32F, 1, 0, ksize=1, scale=0.5)
        down = cv2.Sobel(luma, cv2.CV_32F, 0, 1, ksize=1, scale=0.5)
        height, width = luma.shape
        block_px = max(1.0, width / _BLOCKS_ACROSS)
        size = max(1, round(width / block_px)), max(1, round(height / block_px))
        energy = cv2.resize(across * across + down * down, size, interpolation=cv2.INTER_AREA)
        return cls(cv2.blur(energy, (3, 3)).astype(np.float32), width / size[0])

    def at(self, xy_px: Float64[np.ndarray, "n 2"]) -> Float64[np.ndarray, " n"]:
        """Root mean square round these full-size pixels; 0 outside the photo."""
        rows, columns = self.energy.shape
        known = np.isfinite(xy_px).all(axis=1)
        x, y = np.where(known, xy_px.T, -1.0) / self.block_px
        inside = known & (x >= 0) & (y >= 0) & (x < columns) & (y < rows)
        # beside the lens a place may lie farther off than an integer holds
        row, column = np.clip(y, 0, rows - 1).astype(int), np.clip(x, 0, columns - 1).astype(int)
        return np.where(inside, np.sqrt(self.energy[row, column].astype(np.float64)), 0.0)


@dataclass(frozen=True)
class _Looked:
    """What is kept of a full-size photo: it need not be decoded again while the limb stays put."""

    box: tuple[int, int, int, int]
    seen: Photo
    slopes: _Slopes


def limb_shown(metric: MetricScene) -> Points3:
    """The points of what the cameras aim at, above the floor.

    Raises:
        RegionError: too few points lie where the photos look, or two objects could be meant.
    """
    scene = metric.scene
    points = scene.points_in_world
    aim = aim_of(scene.views, points)
    usable = aimed_at(scene, aim)  # as the reconstruction will ask
    if metric.floor_z_mm is not None:
        # without a size there is no board either, and the floor's own points lie about its plane
        in_mm = metric.scale.unit == "mm"
        above = _ABOVE_FLOOR_MM if in_mm else RegionOptions().floor_clearance * aim.reach
        usable &= points[:, 2] > metric.floor_z_mm + above
    refuse_few(int(usable.sum()), _FEWEST_LIMB_POINTS)
    return limb_among(points[usable], aim, _FEWEST_LIMB_POINTS).points_mm


def look_at_limb(
    photos: PhotoSet,
    small: PhotoSet,
    features: Features,
    metric: MetricScene,
    limb: Points3,
    known: dict[str, "_Looked"],
) -> list[_LookedAt]:
    """Sharpness and exposure at full size where the limb lies, and how dense its texture is.

    Args:
        known: What was seen earlier, by content; it is added to.
    """
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
        box = (max(left, 0), max(top, 0), left + width, top + height)
        looked = known.get(photo.sha256)
        if looked is None or not _alike(looked.box, box):
            luma, mask = load_luma(photo), load_mask(photo)
            limb_at = np.zeros(luma.shape, np.uint8)
            cv2.fillConvexPoly(limb_at, np.round(hull * factor).astype(np.int32), 1)
            # the outline of a bent limb spans a part of what lies behind it
            where = (limb_at > 0) & exposed_in(luma, mask)
            part = slice(box[1], box[3]), slice(box[0], box[2])
            seen = replace(
                photo,
                sharpness=edge_width_px(luma[part], None if mask is None else mask[part]),
                burnt=burnt_share(luma[part], where[part]),
                brightest=brightest_luma(luma[part], where[part]),
            )
            looked = _Looked(box, seen, _Slopes.of(luma))
            known[photo.sha256] = looked
        seen = replace(looked.seen, path=photo.path, camera_idx=photo.camera_idx)
        within = [
            cv2.pointPolygonTest(hull, (float(x), float(y)), False) >= 0
            for x, y in features.keypoints[idx].xy_px
        ]
        density = math.nan
        if metric.scale.unit == "mm":
            away_mm = float(np.linalg.norm(view.centre_in_world - np.median(limb, axis=0)))
            pixel_cm = 0.1 * away_mm / view.camera.fx
            density = sum(within) / max(cv2.contourArea(hull) * pixel_cm**2, 1e-9)
        return _LookedAt(seen, True, density, looked.slopes)

    each_mb = in_flight_mb(photos.photos, _LOOKING_BYTES)
    return in_parallel(look, range(len(photos.photos)), each_mb=each_mb)


def _alike(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> bool:
    """Whether two boxes (left, top, right, bottom) hold nearly the same."""
    sides = max(one[2] - one[0], 1), max(one[3] - one[1], 1)
    return all(abs(one[k] - other[k]) <= _SAME_BOX * sides[k % 2] for k in range(4))


def _judged(
    photos: PhotoSet,
    looked_at: Sequence[_LookedAt],
    scene: Scene,
    limb: Points3,
    options: CheckOptions,
) -> tuple[tuple[CheckedPhoto, ...], tuple[MissingPhotos, ...]]:
    """Every photo with what is wrong, and the photos that are missing between those that count."""
    on_limb = replace(photos, photos=tuple(one.photo for one in looked_at))
    said: dict[str, list[Finding]] = {}
    for remark in remarks(on_limb, options.quality):
        said.setdefault(remark.name, []).append(remark.finding)
    stands = _stands(scene, limb)
    checked: list[CheckedPhoto] = []
    for idx, one in enumerate(looked_at):
        verdict = scene.verdicts[idx]
        own = said.get(one.photo.name, [])
        bad = any(found.code in SPOILT for found in own)
        named = _named_in(verdict.reason)
        checked.append(
            CheckedPhoto(
                name=one.photo.name,
                placed=one.placed,
                points=verdict.points,
                edge_px=one.photo.sharpness if one.placed else math.nan,
                burnt=one.photo.burnt,
                features_per_cm2=one.features_per_cm2,
                azimuth_deg=stands[idx].azimuth_deg,
                elevation_deg=stands[idx].elevation_deg,
                counts=one.placed and not bad,
                remarks=(
                    *(found for found in (verdict.reason, verdict.remark) if found is not None),
                    *(found for found in own if found.code not in named),
                ),
            )
        )
    return tuple(checked), missing_round(checked, options)


def _named_in(reason: Finding | None) -> set[str]:
    """Codes of the remarks that a verdict names itself."""
    measured = () if reason is None else reason.values.get("measured")
    found = measured if isinstance(measured, tuple) else ()
    return {one.code for one in found if isinstance(one, Finding)}


def _stands(scene: Scene, limb: Points3) -> list[Stand]:
    """Where every photo was taken; NaN where it is not placed."""
    middle = np.median(limb, axis=0)
    unknown = Stand(azimuth_deg=math.nan, elevation_deg=math.nan, distance=math.nan)
    found = [unknown] * len(scene.names)
    first_rad = _first_rad(scene, middle)
    for idx in scene.placed:
        found[idx] = stand_of(scene.view(idx).centre_in_world, middle, first_rad)
    return found


def _first_rad(scene: Scene, middle: Vector3) -> float:
    """Direction of azimuth 0 in the plane of x and y: where the first placed photo stands."""
    x, y, _ = scene.view(scene.placed[0]).centre_in_world - middle
    return float(np.arctan2(y, x))


def _gaps_deg(azimuths_deg: Sequence[float]) -> Float64[np.ndarray, " n"]:
    """From each photo, in their order round, to the next one."""
    around = np.sort(np.asarray(azimuths_deg, float))
    if not len(around):
        return np.zeros(0)
    return np.diff(around, append=around[0] + 360.0)


def missing_round(
    checked: Sequence[CheckedPhoto], options: CheckOptions = DEFAULTS
) -> tuple[MissingPhotos, ...]:
    """Photos to add where neighbouring photos that count lie too far apart, most of them first."""
    around = sorted((one for one in checked if one.counts), key=lambda one: one.azimuth_deg)
    first = first_placed(checked)
    found: list[MissingPhotos] = []
    gaps = _gaps_deg([one.azimuth_deg for one in around])
    limit_deg = min(options.max_gap_ratio * _usual_gap_deg(around), options.widest_gap_deg)
    for one, following, gap in zip(around, [*around[1:], *around[:1]], gaps):
        if gap <= max(options.max_gap_deg, limit_deg):
            continue
        count = max(math.ceil(gap / options.step_deg) - 1, 1)
        places = tuple(
            float((one.azimuth_deg + gap * k / (count + 1)) % 360) for k in range(1, count + 1)
        )
        height_deg = (one.elevation_deg + following.elevation_deg) / 2
        asked = fault(
            "coach.add_between",
            count=count,
            before=one.name,
            after=following.name,
            gap_deg=float(gap),
            hours=_hours(places),
            first=first,
            height=height_of(height_deg),
        )
        found.append(
            MissingPhotos(
                count=count,
                azimuths_deg=places,
                elevations_deg=(height_deg,) * count,
                between=(one.name, following.name),
                asked=asked,
            )
        )
    return tuple(sorted(found, key=lambda one: -one.count))


def _hours(azimuths_deg: Iterable[float]) -> tuple[int, ...]:
    """The hours at which places stand, each once."""
    return tuple(dict.fromkeys(clock(azimuth) for azimuth in azimuths_deg))


def _may_stay(
    gaps: Sequence[MissingPhotos], checked: Sequence[CheckedPhoto], options: CheckOptions
) -> bool:
    """Whether the verdict of the case would name none of the gaps in a walk.

    A photo that was taken in a gap and does not count is to be taken again.
    """
    around = {one.name: one.azimuth_deg for one in checked if one.counts}
    spoilt_deg = [one.azimuth_deg for one in checked if one.placed and not one.counts]
    for gap in gaps:
        if gap.between is None:
            return False
        start, end = (around[name] for name in gap.between)
        width = (end - start) % 360.0
        if width > options.widest_gap_deg or any((k - start) % 360.0 < width for k in spoilt_deg):
            return False
    return True


def first_placed(checked: Sequence[CheckedPhoto]) -> str:
    """The photo that stands at 12 o'clock."""
    return next((one.name for one in checked if one.placed), "")


def _usual_gap_deg(around: Sequence[CheckedPhoto]) -> float:
    """The mean gap of the ring that has most photos.

    A second ring at another height falls between the photos of the first: by all photos together
    the usual gap would seem smaller than anybody walked, and a good walk be held back.
    """
    rings: list[list[CheckedPhoto]] = []
    for one in sorted(around, key=lambda one: one.elevation_deg):
        if rings and one.elevation_deg - rings[-1][-1].elevation_deg < _OTHER_RING_DEG:
            rings[-1].append(one)
        else:
            rings.append([one])
    return 360.0 / max(map(len, rings), default=1)


@dataclass(frozen=True)
class _Shown:
    """The limb's proxy, and what the photos that count show of it."""

    proxy: LimbProxy
    prediction: Prediction
    coverage: Coverage
    thin: float
    """Share of the limb of which no two photos stand near enough to each other to find depth."""
    bare: tuple[Finding, ...] = ()
    """Regions in which paint is missing."""


def _shown(seen: _Seen, checked: Sequence[CheckedPhoto], options: CheckOptions) -> _Shown:
    """Photos and expected sigma of every cell, by the photos that count."""
    scene, small, looked_at = seen.metric.scene, seen.small, seen.looked_at
    proxy = proxy_of(seen.limb, scene.view(scene.placed[0]).centre_in_world)
    counted = [idx for idx, one in enumerate(checked) if one.counts]
    views = [scene.view(idx) for idx in counted]
    ratio = np.array(
        [small.photos[idx].width_px / looked_at[idx].photo.width_px for idx in counted]
    )
    slopes = [
        np.zeros(len(proxy.mesh)) if own is None else own.at(_full_px(view, proxy, by))
        for view, by, own in zip(views, ratio, (looked_at[idx].slopes for idx in counted))
    ]
    # pixels of the small copies, whose feature points these are: large photos find finer ones
    gap_px = gaps_mm(proxy, seen.limb) / _usual_pixel(views, proxy)
    prediction = predict(
        proxy,
        views,
        Showing(
            pixel_ratio=ratio,
            edge_px=np.nan_to_num(np.array([checked[idx].edge_px for idx in counted])),
            slope=np.stack(slopes, axis=1) if slopes else np.zeros((len(proxy.mesh), 0)),
            relative_sigma=float(np.nan_to_num(seen.metric.scale.relative_sigma)),
            gap_px=gap_px,
        ),
    )
    in_mm = seen.metric.scale.unit == "mm"
    bare = tuple(_bare_regions(proxy, prediction, gap_px))
    apart_deg = narrowest_deg(proxy, views, _SQUARELY_DEG)
    wide = np.isfinite(apart_deg) & (apart_deg > options.widest_pair_deg)
    coverage = coverage_of(proxy, prediction, in_mm)
    return _Shown(proxy, prediction, coverage, prediction.share(wide, proxy), bare)


def _usual_pixel(views: Sequence[View], proxy: LimbProxy) -> float:
    """Of a photo in the middle of the limb, in units of the scene."""
    away = [
        float(view.camera_from_world.apply(proxy.middle[None])[0, 2])
        / math.sqrt(view.camera.fx * view.camera.fy)
        for view in views
    ]
    return float(np.median(np.abs(away))) if away else math.inf


def _bare_regions(
    proxy: LimbProxy, prediction: Prediction, gap_px: Float64[np.ndarray, " n"]
) -> list[Finding]:
    """Regions of which much is farther from paint than can be bridged, though photos see it."""
    bare = (gap_px > _BARE_PX) & (prediction.squarely >= 2) & proxy.known
    return [
        note("coach.region.bare", region=title, share=float(bare[cells].mean()))
        for title, cells in _cells_of_regions(proxy)
        if cells.any() and bare[cells].mean() > _BARE_SHARE
    ]


def _full_px(view: View, proxy: LimbProxy, ratio: float) -> Float64[np.ndarray, "n 2"]:
    """Where the cells lie in the full-size photo."""
    return (view.project(proxy.mesh.vertices_mm) + 0.5) / ratio - 0.5


def coverage_of(proxy: LimbProxy, prediction: Prediction, in_mm: bool) -> Coverage:
    """A prediction as it is told: cell by cell, by regions, and in all."""
    sigma_mm = prediction.sigma_mm if in_mm else np.full(len(proxy.mesh), np.nan)
    regions = _regions(proxy, prediction, sigma_mm)
    known = proxy.by_row(proxy.known)
    photos, sigmas = proxy.by_row(prediction.squarely), proxy.by_row(sigma_mm)
    unsure = [one for one in regions if math.isfinite(one.sigma_mm)]
    weakest = max(unsure, key=lambda one: one.sigma_mm, default=None)
    return Coverage(
        rows=proxy.rows,
        side_rows=proxy.side_rows,
        columns=COLUMNS,
        photos=tuple(
            tuple(int(n) if there else None for n, there in zip(row, own))
            for row, own in zip(photos, known)
        ),
        sigma_mm=tuple(
            tuple(float(s) if there and np.isfinite(s) else None for s, there in zip(row, own))
            for row, own in zip(sigmas, known)
        ),
        places=tuple(
            tuple((float(x), float(y), float(z)) for x, y, z in row)
            for row in proxy.mesh.vertices_mm[:-1].reshape(proxy.rows, COLUMNS, 3)
        ),
        length=proxy.length,
        radius=proxy.radius,
        measured=prediction.share(prediction.squarely >= 2, proxy),
        well=prediction.share(prediction.squarely >= 3, proxy),
        sigma_middle_mm=prediction.middle_sigma_mm(proxy) if in_mm else math.nan,
        regions=regions,
        weakest=None
        if weakest is None
        else note(
            "coach.region.weakest", region=weakest.name, expected_mm=COVER * weakest.sigma_mm
        ),
    )


def _regions(
    proxy: LimbProxy, prediction: Prediction, sigma_mm: Float64[np.ndarray, " n"]
) -> tuple[CoveredRegion, ...]:
    """Thirds of the side by quarter hours of a clock, and the end."""
    return tuple(
        _region(title, cells, prediction, sigma_mm) for title, cells in _cells_of_regions(proxy)
    )


def _cells_of_regions(proxy: LimbProxy) -> list[tuple[Finding, Bool[np.ndarray, " n"]]]:
    """The regions by name, from below upwards, and which cells are theirs."""
    row, column = np.divmod(np.arange(len(proxy.mesh)), COLUMNS)
    third = np.minimum(row * len(_THIRDS) // proxy.side_rows, len(_THIRDS) - 1)
    found: list[tuple[Finding, Bool[np.ndarray, " n"]]] = []
    for part, name in enumerate(_THIRDS):
        for hour in range(0, 12, _HOURS):
            middle = -hour * COLUMNS / 12 % COLUMNS
            off = np.abs((column - middle + COLUMNS / 2) % COLUMNS - COLUMNS / 2)
            cells = (row < proxy.side_rows) & (third == part) & (off <= _HOURS * COLUMNS / 24)
            found.append((note("coach.region.side", third=name, hour=hour or 12), cells))
    end = (row >= proxy.side_rows) & proxy.known
    if end.any():
        found.append((note("coach.region.end"), end))
    return found


_THIRDS = ("lower", "middle", "upper")
_HOURS = 2
"""Hours of the clock that a region is wide."""


def _region(
    name: Finding,
    cells: np.ndarray,
    prediction: Prediction,
    sigma_mm: Float64[np.ndarray, " n"],
) -> CoveredRegion:
    own = sigma_mm[cells]
    measured = np.isfinite(own)
    return CoveredRegion(
        name=name,
        photos=int(np.median(prediction.photos[cells])),
        unseen=float(np.mean(prediction.squarely[cells] < 2)),
        sigma_mm=float(np.median(own[measured])) if measured.any() else math.nan,
    )


def _asked_for(
    shown: _Shown,
    metric: MetricScene,
    checked: Sequence[CheckedPhoto],
    missing: Sequence[MissingPhotos],
    options: CheckOptions,
) -> tuple[tuple[MissingPhotos, ...], list[Finding], tuple[Finding, ...]]:
    """Photos for places that too few see, the findings that they belong to, and notes."""
    proxy, prediction = shown.proxy, shown.prediction
    unseen = prediction.share(prediction.squarely < options.least_photos, proxy)
    unsure = prediction.share(prediction.sigma_mm > options.max_sigma_mm, proxy)
    findings: list[Finding] = []
    asked: tuple[MissingPhotos, ...] = ()
    first = first_placed(checked)
    if unseen > options.max_unseen:
        asked = _for_places(shown, metric, missing, options)
        part: dict[str, Value] = {"share": float(unseen), "least": options.least_photos}
        if asked:
            count, places = sum(one.count for one in asked), _grouped(asked)
            added = fault("coach.unseen.add", count=count, places=places, first=first, **part)
            findings.append(added)
        elif missing:
            findings.append(fault("coach.unseen.coming", **part))
        else:
            findings.append(fault("coach.unseen.blocked", **part))
    if shown.thin > options.max_thin:
        steps = replace(options, max_gap_deg=options.widest_pair_deg, max_gap_ratio=0.0)
        between = () if missing or asked else missing_round(checked, steps)
        asked = (*asked, *between)
        thin = fault(
            "coach.thin",
            share=float(shown.thin),
            widest_deg=options.widest_pair_deg,
            parts=len(between),
            places=_grouped(between),
            first=first,
        )
        findings.append(thin)
    if metric.scale.unit == "mm" and unsure > options.max_unseen:
        most_mm = COVER * options.max_sigma_mm
        findings.append(fault("coach.unsure", share=float(unsure), most_mm=most_mm))
    notes: list[Finding] = []
    if not proxy.known[-1]:
        notes.append(note("coach.no_upper_end"))
    if shown.bare:
        notes.append(doubt("coach.unpainted", regions=shown.bare, first=first))
    if shown.coverage.weakest is not None:
        notes.append(note("coach.least_sure", weakest=shown.coverage.weakest))
    return asked, findings, tuple(notes)


def _for_places(
    shown: _Shown,
    metric: MetricScene,
    missing: Sequence[MissingPhotos],
    options: CheckOptions,
) -> tuple[MissingPhotos, ...]:
    """Photos that would show what too few show, one entry each, from below upwards.

    Args:
        missing: Photos that are asked for already; what they will show is not asked for again.
    """
    scene, proxy = metric.scene, shown.proxy
    away = [np.linalg.norm(view.centre_in_world - proxy.middle) for view in scene.views]
    distance, camera = float(np.median(away)), scene.views[0].camera
    first_rad = _first_rad(scene, proxy.middle)
    coming = [
        replace(one, distance=distance).view(camera, proxy.middle, first_rad)
        for part in missing
        for one in _stands_of(part)
    ]
    stands = stands_to_add(
        proxy,
        shown.prediction.squarely + shows_squarely(proxy, coming).sum(axis=1),
        options.wanted_photos,
        camera,
        distance,
        first_rad,
        metric.floor_z_mm,
        options.most_added,
    )
    by_height = sorted(stands, key=lambda one: (one.elevation_deg, one.azimuth_deg))
    return tuple(
        MissingPhotos(
            count=1,
            azimuths_deg=(one.azimuth_deg,),
            elevations_deg=(one.elevation_deg,),
            between=None,
            asked=fault(
                "coach.add_at", hour=clock(one.azimuth_deg), height=height_of(one.elevation_deg)
            ),
        )
        for one in by_height
    )


def _stands_of(asked: MissingPhotos) -> list[Stand]:
    return [
        Stand(azimuth_deg=azimuth, elevation_deg=elevation, distance=math.nan)
        for azimuth, elevation in zip(asked.azimuths_deg, asked.elevations_deg)
    ]


def _grouped(asked: Sequence[MissingPhotos]) -> tuple[Finding, ...]:
    """Hours by height: "at 2, 4 o'clock, 25 degrees above level"."""
    stands = [one for part in asked for one in _stands_of(part)]
    return tuple(
        note("coach.stands", hours=_hours(one.azimuth_deg for one in group), height=height)
        for height, group in groupby(stands, key=lambda one: height_of(one.elevation_deg))
    )


def _refused(photos: PhotoSet, why: Finding, options: CheckOptions) -> CaptureCheck:
    said: dict[str, list[Finding]] = {}
    for remark in remarks(photos, options.quality):
        said.setdefault(remark.name, []).append(remark.finding)
    return CaptureCheck(
        go=False,
        headline=fault("coach.not_yet", why=why),
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
                elevation_deg=math.nan,
                counts=False,
                remarks=tuple(said.get(photo.name, ())),
            )
            for photo in photos.photos
        ),
        missing=(),
        largest_gap_deg=math.nan,
        board_photos=None,
    )
