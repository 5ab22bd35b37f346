"""Coach: the check of a capture while the patient is still there.

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
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int32

from limbgram.capture.answer import (
    CaptureCheck,
    CheckedPhoto,
    MissingPhotos,
)
from limbgram.capture.camera_positions import Stand, stand_of
from limbgram.capture.coverage import CheckedScene, show_proxy
from limbgram.capture.criteria import FEATURES, FEWEST_ROUND, MIN_BOARD_PHOTOS
from limbgram.capture.limb_in_photos import (
    InspectedPhoto,
    InspectionCache,
    inspect_limb,
    known_by,
    limb_points,
)
from limbgram.capture.limb_motion import kept_still, limb_motion
from limbgram.capture.photos_to_add import (
    first_direction_rad,
    gaps_deg,
    gaps_tolerable,
    photos_for_gaps,
    photos_for_hidden_places,
)
from limbgram.core.errors import (
    CalibrationError,
    MatchingError,
    PlacementError,
    RegionError,
    ScaleError,
)
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import Camera
from limbgram.core.interval import COVER
from limbgram.core.run import Run
from limbgram.findings import Finding, Gravity, fault, note
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras, cameras_for
from limbgram.reconstruction.features.detection import Features, Keypoints, detect
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.mapping.zoom import zoomed_photos
from limbgram.reconstruction.matching.matching import (
    Candidate,
    MatchedPair,
    Matches,
    PairMatches,
    joined,
    match_pairs,
    pairs_worth_matching,
)
from limbgram.reconstruction.matching.static_background import StaticBackground, find_still
from limbgram.reconstruction.photo_lenses import lenses_told
from limbgram.reconstruction.photos.lenses import lens_notes
from limbgram.reconstruction.photos.masks import mask_notes
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.quality import UNUSABLE_REMARKS, common_fault, remarks_by_photo
from limbgram.reconstruction.pipeline import (
    PipelineOptions,
    PlacedPhotos,
    by_the_limb,
    place_pairs,
    placed_photos,
    with_files_that_fit,
)
from limbgram.reconstruction.poses import Poses, Unplaced
from limbgram.reconstruction.scale.displaced_board import tipped_photos
from limbgram.reconstruction.scale.metric import Scale
from limbgram.reconstruction.scale.scaling import to_millimetres
from limbgram.reconstruction.targets.board import Board
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.reconstruction.twoview.pairs import Pairs, VerifiedPair
from limbgram.reconstruction.twoview.verification import verify


def check_capture(
    photos: PhotoSet,
    small: PhotoSet,
    calibrations: Sequence[Calibration],
    board: Board | None,
    run: Run | None = None,
) -> CaptureCheck:
    """Check whether these photos will give a surface, all round and in millimetres.

    Args:
        small: The same photos in the same order, reduced.
    """
    return Coach(calibrations, board).check(photos, small, run)


class _VerifiedPair(NamedTuple):
    """A verified pair, with what it was verified by."""

    by: Int32[np.ndarray, "m 2"]
    """The matches that were tried."""
    lenses: tuple[Camera, Camera]
    """With which."""
    pair: VerifiedPair | None


class Coach:
    """Checks a capture again and again while it grows, and keeps what it knows of each photo.

    A photo is known by its content and its mask. A pair keeps the matches of when it was first
    compared.
    """

    def __init__(
        self,
        calibrations: Sequence[Calibration],
        board: Board | None,
    ) -> None:
        self._calibrations = tuple(calibrations)
        self._board = board
        self._keypoints: dict[str, Keypoints] = {}
        self._matched: dict[tuple[str, str], MatchedPair] = {}
        self._verified: dict[tuple[str, str], _VerifiedPair] = {}
        self._standing: dict[str, Bool[np.ndarray, " n"]] = {}
        self._seen: dict[str, InspectionCache] = {}

    def check(self, photos: PhotoSet, small: PhotoSet, run: Run | None = None) -> CaptureCheck:
        """Check whether these photos are good; those known from an earlier check cost little."""
        found = self._check_photos(photos, small, run or Run())
        aside = (note("coach.left_out", name=k.name, reason=k.reason) for k in photos.set_aside)
        notes = (*aside, *mask_notes(photos), *found.notes)
        return replace(found, notes=notes, set_aside=photos.set_aside)

    def _check_photos(self, photos: PhotoSet, small: PhotoSet, run: Run) -> CaptureCheck:
        try:
            placed = self._placed(photos, small, run)
        except (CalibrationError, MatchingError, PlacementError) as refusal:
            return _refused_answer(photos, refusal.finding)
        small, cameras, placing, detections = placed
        findings: list[Finding] = []
        try:
            metric = to_millimetres(
                placing.scene, detections, (), cameras=cameras, quarter_turns=small.quarter_turns
            )
        except ScaleError as refusal:
            findings.append(refusal.finding)
            metric = to_millimetres(placing.scene, quarter_turns=small.quarter_turns)
        findings += tipped_board_finding(metric.scale)
        board_photos = None if detections is None else len(detections.photos)
        if board_photos is not None and board_photos < MIN_BOARD_PHOTOS and not findings:
            unseen = fault("coach.board_unseen", photos=board_photos, least=MIN_BOARD_PHOTOS)
            findings.append(unseen)
        found = True
        try:
            limb_idx = limb_points(metric)
        except RegionError as refusal:
            findings.append(refusal.finding)
            limb_idx, found = np.arange(len(metric.scene.points_in_world)), False
        limb = metric.scene.points_in_world[limb_idx]
        looked_at = run(inspect_limb, photos, small, placing.features, metric, limb, self._seen)
        seen = CheckedScene(photos, small, metric, limb_idx, looked_at, found)
        motion = limb_motion(metric, limb)
        findings += motion.findings(cameras)
        lenses = tuple(lenses_told(metric.scene, cameras, photos))
        findings += [one for one in lenses if one.gravity is Gravity.FAULT]
        answer = _answer_of(seen, findings, board_photos)
        turned = (*_turning_notes(placing.still), *_turned_over_notes(placing.poses, small))
        said = (one for one in lenses if one.gravity is not Gravity.FAULT)
        notes = (*motion.notes(), *answer.notes, *turned, *lens_notes(small), *said)
        return replace(answer, notes=notes, kept_still=kept_still(metric.scene))

    def _placed(self, photos: PhotoSet, small: PhotoSet, run: Run) -> PlacedPhotos:
        """The reduced photos with their poses, found from what is known of each photo and pair."""
        cameras = run(cameras_for, photos, self._calibrations).reduced(small.cameras)
        features = self._features(small, run)
        still = run(find_still, features)
        features = still.moving(features)
        self._forget_changed(small, still)
        detections = None if self._board is None else run(find_board, small, self._board)

        def place(cameras: Cameras) -> PlacedPhotos:
            matches, pairs = self._pairs(small, features, still, cameras, run)
            unplaced = Unplaced(
                photos=small,
                features=features,
                still=still,
                matches=matches,
                pairs=pairs,
                cameras=cameras,
                detections=detections,
            )
            placing = place_pairs(unplaced, run)
            placed = placed_photos(small, cameras, placing, detections, run)
            if placing.scene.ring is None or not placing.scene.ring.closed:
                return placed  # more photos are to come, and an arc bends as if the limb moved
            return by_the_limb(placed, PipelineOptions(), run)

        return with_files_that_fit(small, cameras, place, run)

    def _features(self, small: PhotoSet, run: Run) -> Features:
        """Keypoints of all photos; only new photos are processed."""
        new = tuple(one for one in small.photos if known_by(one) not in self._keypoints)
        if new:
            found = run(detect, replace(small, photos=new), FEATURES)
            self._keypoints |= {known_by(one): own for one, own in zip(new, found.keypoints)}
        return Features(tuple(self._keypoints[known_by(one)] for one in small.photos))

    def _forget_changed(self, small: PhotoSet, still: StaticBackground) -> None:
        """Drop what is known of pairs of photos in which other keypoints stand still than before.

        What stands still is told the better the more photos a still camera took; matches count
        the keypoints that are left.
        """
        flags = still.keypoints or [
            np.zeros(len(self._keypoints[known_by(one)]), np.bool_) for one in small.photos
        ]
        now = {known_by(one): own for one, own in zip(small.photos, flags, strict=True)}
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
        self,
        small: PhotoSet,
        features: Features,
        still: StaticBackground,
        cameras: Cameras,
        run: Run,
    ) -> tuple[Matches, Pairs]:
        """Matches and verified pairs; only what was not compared before is matched.

        A pair is verified anew where other matches than before are left of it: how the picture of
        a still camera moved is known better with each photo.
        """

        def named(first: int, second: int) -> tuple[str, str]:
            return known_by(small.photos[first]), known_by(small.photos[second])

        candidates = run(pairs_worth_matching, small, features)
        new = tuple(c for c in candidates if named(c.first, c.second) not in self._matched)
        for one in run(match_pairs, small, features, new) if new else ():
            self._matched[named(one.pair.first, one.pair.second)] = one
        matched = [
            _with_new_indices(self._matched[named(c.first, c.second)], c) for c in candidates
        ]
        matches = still.moving_matches(joined(small, matched))

        def lenses(pair: PairMatches) -> tuple[Camera, Camera]:
            first, second = (small.photos[k].camera_idx for k in (pair.first, pair.second))
            return cameras.calibrations[first].camera, cameras.calibrations[second].camera

        def known(pair: PairMatches) -> bool:
            before = self._verified.get(named(pair.first, pair.second))
            if before is None or before.lenses != lenses(pair):
                return False
            return np.array_equal(before.by, pair.keypoint_idx)

        fresh = [pair for pair in matches.pairs if not known(pair)]
        if fresh:
            held = run(verify, small, replace(matches, pairs=tuple(fresh)), cameras)
            found = {one.matches.photos: one for one in held.verified}
            for pair in fresh:
                own = found.get((pair.first, pair.second))
                tried = _VerifiedPair(pair.keypoint_idx, lenses(pair), own)
                self._verified[named(pair.first, pair.second)] = tried
        verified: list[VerifiedPair] = []
        for pair in matches.pairs:
            kept = self._verified[named(pair.first, pair.second)].pair
            if kept is not None:
                own = replace(kept.matches, first=pair.first, second=pair.second)
                verified.append(replace(kept, matches=own))
        return matches, Pairs(tuple(verified), matches.pairs_tried - len(verified))


def tipped_board_finding(scale: Scale) -> list[Finding]:
    """That photos show the board in another plane: the object may stand in the scene twice."""
    tipped = tipped_photos(scale.set_aside)
    if not tipped:
        return []
    return [fault("coach.board_tipped", photos=len(tipped), others=tipped[0].values["others"])]


def _turning_notes(still: StaticBackground) -> tuple[Finding, ...]:
    """Notes on a still camera, and on the meaning of the hours then."""
    if not still.groups:
        return ()
    return (*still.notes, note("coach.turn_the_limb"))


def _turned_over_notes(poses: Poses, small: PhotoSet) -> tuple[Finding, ...]:
    """That the hours of a photo count for its own pose of the object."""
    if not poses.sides:
        return ()
    return (note("coach.turned_over", sides=poses.names(small)),)


def _with_new_indices(known: MatchedPair, candidate: Candidate) -> MatchedPair:
    """Known matches with new photo indices, after photos were added between."""
    pair = replace(known.pair, first=candidate.first, second=candidate.second)
    return replace(known, pair=pair)


def _answer_of(
    seen: "CheckedScene", findings: list[Finding], board_photos: int | None
) -> CaptureCheck:
    """The answer from all that was found."""
    scene = seen.metric.scene
    spoilt = common_fault([one.photo for one in seen.looked_at if one.placed], placed=True)
    if spoilt is not None:
        findings.append(spoilt)
    zoomed = [one.name for one in scene.verdicts if one.remark]
    if zoomed:
        findings.append(zoomed_photos(zoomed, len(scene.names)))
    checked, missing = _judged_photos(seen.photos, seen.looked_at, scene, seen.limb)
    gap_deg = max(gaps_deg([one.azimuth_deg for one in checked if one.counts]), default=math.nan)
    ring = scene.ring
    shown = show_proxy(seen, checked) if seen.found else None
    asked: tuple[MissingPhotos, ...] = ()
    said: list[Finding] = []
    notes: tuple[Finding, ...] = ()
    if shown is not None:
        asked, said, notes = photos_for_hidden_places(shown, seen.metric, checked, missing)
    closed = ring is not None and ring.closed
    if closed and not findings and not said and gaps_tolerable(missing, checked):
        advice = (note("coach.surer", asked=one.asked) for one in missing)
        missing, notes = (), (*advice, *notes)
    findings += [one.asked for one in missing]
    if not missing and ring is not None and not closed:
        findings.append(fault("coach.weak_bridge", points=ring.weakest_bridge))
    findings += said
    counting = sum(one.counts for one in checked)
    if not findings and counting < FEWEST_ROUND:
        findings.append(fault("coach.few_count", counting=counting, least=FEWEST_ROUND))
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


def _judged_photos(
    photos: PhotoSet,
    looked_at: Sequence[InspectedPhoto],
    scene: Scene,
    limb: Points3,
) -> tuple[tuple[CheckedPhoto, ...], tuple[MissingPhotos, ...]]:
    """Every photo with its remarks, and the photos missing between those that count."""
    on_limb = replace(photos, photos=tuple(one.photo for one in looked_at))
    said = remarks_by_photo(on_limb)
    stands = _stands_of_photos(scene, limb)
    checked: list[CheckedPhoto] = []
    for idx, one in enumerate(looked_at):
        verdict = scene.verdicts[idx]
        own = said.get(one.photo.name, [])
        bad = any(found.code in UNUSABLE_REMARKS for found in own)
        named = _remark_codes_in(verdict.reason)
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
    return tuple(checked), photos_for_gaps(checked)


def _remark_codes_in(reason: Finding | None) -> set[str]:
    """Codes of the remarks that a verdict names itself."""
    measured = () if reason is None else reason.values.get("measured")
    found = measured if isinstance(measured, tuple) else ()
    return {one.code for one in found if isinstance(one, Finding)}


def _stands_of_photos(scene: Scene, limb: Points3) -> list[Stand]:
    """Azimuth and elevation of every photo; NaN where it is not placed."""
    middle = np.median(limb, axis=0)
    unknown = Stand(azimuth_deg=math.nan, elevation_deg=math.nan, distance=math.nan)
    found = [unknown] * len(scene.names)
    first_rad = first_direction_rad(scene, middle)
    for idx in scene.placed:
        found[idx] = stand_of(scene.view(idx).centre_in_world, middle, first_rad)
    return found


def _refused_answer(photos: PhotoSet, why: Finding) -> CaptureCheck:
    said = remarks_by_photo(photos)
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
