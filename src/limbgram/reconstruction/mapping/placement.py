"""Placement: camera poses of all photos and sparse points, in one scene.

In      keypoints, verified pairs, cameras.
Out     a Scene: poses, points, lenses, a verdict for every photo, and whether the ring closes.
Method  Keypoints refined by all window matches; incremental mapping (pycolmap) with the best
        connected matches, lenses free that no board calibrated, and, where that leaves photos out,
        with those of EXIF fixed or without the pairs that contradict chains of stronger ones, and
        from other initial pairs where the ring folded; photos that contradict their pairs or have
        too few points lose their pose; photos that were left out are placed by pairs and a few
        points (stragglers.py); tracks from all matches; bundle adjustment with the calibration as
        a prior; a few photos that were zoomed lose their pose too; lens deviations of single photos
        are set free where the residuals support them.
Fails   PlacementError: no scene, too few photos in it, or a scene that contradicts its pairs.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.known_words import require_known_words
from limbgram.findings import Finding, note
from limbgram.reconstruction.calibration.cameras import (
    Cameras,
    contradicting_exif,
    foreign_camera,
    from_exif,
)
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.bundle_adjustment import Adjusted, UnconstrainedPhotos, adjust
from limbgram.reconstruction.mapping.chains import (
    start_pairs,
    without_contradicting_pairs,
    without_planar_pairs,
)
from limbgram.reconstruction.mapping.lens_equations import LensEquations, zoomed_photos
from limbgram.reconstruction.mapping.lens_selection import with_supported_lenses
from limbgram.reconstruction.mapping.scene import Ring, Scene
from limbgram.reconstruction.mapping.stragglers import with_stragglers
from limbgram.reconstruction.mapping.tracks import with_all_tracks, with_best_connected_matches
from limbgram.reconstruction.mapping.verdicts import (
    contradicted,
    judge,
    photo_points,
    refined_keypoints,
    reverified,
)
from limbgram.reconstruction.mapping.zoom import (
    FocalOutliers,
    focal_outliers,
    odd_by_others,
    odd_focals,
    zoomed_by_solved_focals,
)
from limbgram.reconstruction.matching.coded_marks import CodedKeypoints
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.photos.quality import common_fault
from limbgram.reconstruction.twoview.pairs import Pairs

_BRIDGE_DEG = 60.0
_FEWEST_BRIDGES = 15
_CODED_WORTH = 2
"""Weight of a corner of a coded mark, which cannot be mistaken, over that of a keypoint."""
_FEWEST_HELD = 2
_OTHER_FOCAL = 0.1
"""Relative difference of focal length from which photos placed without a calibration contradict
it."""


_MAPPER_MATCHES = 400
"""Largest number of matches of a pair that the mapper gets; the final adjustment takes all."""
_TRACK_PX = 2.0
"""Largest Sampson distance, by the mapper's cameras, of a match that the adjustment takes."""
MIN_PHOTO_POINTS = 20
"""Fewest scene points of a placed photo, from its first resection on."""
_MAX_PHOTO_RMS_PX = 3.0
"""Largest RMS residual of a placed photo."""
_MAX_ZOOMED_SHARE = 0.2
"""Largest share of photos of another focal length that are set aside; more are used and named."""
MIN_PLACED = 3
"""Fewest photos that make a scene."""


@dataclass(frozen=True, kw_only=True)
class MappingOptions:
    """How photos are placed, and what a placed photo must show."""

    board_lenses: Literal["refine", "hold"] = "refine"
    """Whether lenses calibrated with a board move within their covariance or stay as they are."""
    photo_lenses: Literal["as asked", "never"] = "as asked"
    """Whether single photos get lenses of their own where the residuals ask for them."""
    min_placed_share: float = 0.5
    """Smallest part of the photos that makes a scene."""
    seed: int = 0
    """Seed of the mapper's random samples."""

    def __post_init__(self) -> None:
        require_known_words(self)


DEFAULTS = MappingOptions()


def place(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    options: MappingOptions = DEFAULTS,
    coded: CodedKeypoints | None = None,
) -> Scene:
    """Place the photos and their common points in one world frame of arbitrary scale.

    Args:
        coded: Which keypoints are points of coded marks.
    """
    try:
        scene = _mapped(photos, features, pairs, cameras, options, coded)
        return readjusted(scene, cameras, options)
    except PlacementError as refusal:
        cause = _foreign_camera_file(photos, features, pairs, cameras, options) or common_fault(
            photos.photos
        )
        if cause is None:
            raise
        raise PlacementError("placing.because", what=refusal.finding, cause=cause) from refusal


def place_roughly(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    options: MappingOptions = DEFAULTS,
) -> Scene:
    """As `place`, but without the last adjustment, for points that are measured anew."""
    return _mapped(photos, features, pairs, cameras, options)


def _mapped(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    options: MappingOptions,
    coded: CodedKeypoints | None = None,
) -> Scene:
    """The scene of the best route, with tracks from all matches, not yet adjusted with them."""
    if not pairs.verified:
        raise PlacementError("placing.nothing_shared")
    keypoints_px = refined_keypoints(features, pairs)
    own_sigmas_px = None if coded is None else coded.own_sigmas_px()
    best, refusal = None, PlacementError("placing.no_start", pairs=len(pairs.verified))
    folded = False
    for route in _routes(cameras, pairs, len(photos.photos), _MAPPER_MATCHES):
        if route.for_folded and not folded:
            break
        try:
            one = _run_route(photos, keypoints_px, route, pairs, cameras, options, own_sigmas_px)
        except PlacementError as fault:
            refusal = fault
            continue
        folded = folded or one.is_folded
        if best is None or len(one.scene.placed) > len(best.scene.placed):
            best = one
        if len(best.scene.placed) == len(photos.photos):
            break
    if best is None:
        raise refusal
    scene = best.scene
    if MIN_PLACED <= len(scene.placed) < len(scene.names):
        by = _without_contradicted(pairs, best.dropped)
        scene = _with_stragglers(scene, keypoints_px, by, best.others, cameras, options, coded)
    _refuse_too_few(scene, options)
    scene = with_all_tracks(scene, keypoints_px, pairs, _TRACK_PX, coded)
    verdicts = judge(scene, photos, keypoints_px, pairs, best.others, best.dropped)
    return replace(scene, verdicts=verdicts, ring=ring_of(scene))


def _without_contradicted(pairs: Pairs, dropped: dict[int, Finding]) -> Pairs:
    """The pairs without those of photos that contradicted them.

    Such a photo shows a second rigid object, as the room in which a cast was turned over: many
    points of that support a wrong pose.
    """
    barred = {k for k, why in dropped.items() if why.code == "placing.photo.contradicted"}
    kept = tuple(one for one in pairs.verified if not {*one.matches.photos} & barred)
    return Pairs(kept, pairs.rejected)


def _with_stragglers(
    scene: Scene,
    keypoints_px: Sequence[Points2],
    pairs: Pairs,
    groups: Sequence[Scene],
    cameras: Cameras,
    options: MappingOptions,
    coded: CodedKeypoints | None,
) -> Scene:
    """The scene with the left-out photos that their pairs and few points place."""

    def rebuilt(scene: Scene) -> Scene:
        tracked = with_all_tracks(scene, keypoints_px, pairs, _TRACK_PX, coded)
        return _scene_of(_adjusted_with_camera_lenses(tracked, cameras, options))

    try:
        before = rebuilt(scene)
    except PlacementError:  # raised again by the final adjustment
        return scene
    left = {*range(len(scene.names))} - {*before.placed}
    theirs = tuple(one for one in pairs.verified if {*one.matches.photos} & left)
    solved = reverified(before, Pairs(theirs, pairs.rejected), cameras)
    joined = with_stragglers(before, keypoints_px, solved, groups, rebuilt)
    return joined if len(joined.placed) > len(scene.placed) else scene


@dataclass(frozen=True, kw_only=True)
class _Route:
    """One way to run the mapper."""

    held: tuple[bool, ...]
    """By camera, whether its lens is fixed."""
    pairs: Pairs
    start: tuple[int, int] | None = None
    """Initial pair; the mapper's choice if None."""
    for_folded: bool = False
    """Whether it is tried only after a ring folded."""


def _routes(cameras: Cameras, pairs: Pairs, photos: int, matches: int) -> Iterator[_Route]:
    """Ways to run the mapper, in order; the next is tried if photos were left out."""
    seeds = with_best_connected_matches(pairs, matches)
    lenses = tuple(_fixed_lenses(cameras))
    yield from (_Route(held=held, pairs=seeds) for held in lenses)
    chained = without_contradicting_pairs(pairs, photos)
    kept = with_best_connected_matches(chained, matches)
    if len(chained.verified) < len(pairs.verified):
        yield _Route(held=lenses[0], pairs=kept)
    solid = without_planar_pairs(chained)
    if 0 < len(solid.verified) < len(chained.verified):
        yield _Route(
            held=lenses[-1], pairs=with_best_connected_matches(solid, matches), for_folded=True
        )
    for start in start_pairs(chained):
        yield _Route(held=lenses[-1], pairs=kept, start=start, for_folded=True)


def _fixed_lenses(cameras: Cameras) -> Iterator[tuple[bool, ...]]:
    """Which lenses the mapper keeps fixed: those of boards, then those of EXIF too.

    Few points do not determine a lens, and it diverges and loses photos: 1620 px by EXIF became
    6050 where 1670 were true. EXIF knows it well enough to place them all.
    """
    sources = [one.source for one in cameras.calibrations]
    yield tuple(one == "board" for one in sources)
    if "exif" in sources:
        yield tuple(one != "guess" for one in sources)


@dataclass(frozen=True)
class _RouteResult:
    """The scenes that one route of the mapper gave."""

    scene: Scene
    others: tuple[Scene, ...]
    """Smaller ones that could not be joined to it."""
    dropped: dict[int, Finding]
    """Photos whose pose was rejected, with the reason."""

    @property
    def is_folded(self) -> bool:
        """Whether some photos contradicted their pairs."""
        return any(one.code == "placing.photo.contradicted" for one in self.dropped.values())


def _run_route(
    photos: PhotoSet,
    keypoints_px: Sequence[Points2],
    route: _Route,
    pairs: Pairs,
    cameras: Cameras,
    options: MappingOptions,
    own_sigmas_px: Sequence[Float64[np.ndarray, " k"]] | None,
) -> _RouteResult:
    from limbgram.reconstruction.mapping.colmap import (  # loads pycolmap
        MapperSettings,
        map_incrementally,
    )

    settings = MapperSettings(MIN_PHOTO_POINTS, options.seed, route.start)
    found = map_incrementally(
        photos, keypoints_px, route.pairs, cameras, route.held, settings, own_sigmas_px
    )
    if not found:
        raise PlacementError("placing.no_start", pairs=len(pairs.verified))
    rough = _adjusted(found[0], cameras, options)
    dropped = _misplaced(rough, reverified(rough, pairs, cameras))
    return _RouteResult(without_photos(rough, set(dropped)), found[1:], dropped)


def readjusted(scene: Scene, cameras: Cameras, options: MappingOptions) -> Scene:
    """A scene with new observations, adjusted, less a few zoomed photos; its verdicts follow."""
    common = replace(scene, own=None)
    fixed = _adjusted_with_camera_lenses(common, cameras, options)
    lost = {*common.placed} - {*fixed.scene.placed}
    common = without_photos(common, lost)
    result = _with_supported_deviations(fixed, common, cameras, options)
    aside, odd = dict[int, Finding](), dict[int, Finding]()
    most = _MAX_ZOOMED_SHARE * len(fixed.scene.placed)
    if len(zoomed_by_solved_focals(result.scene)) <= most:
        while odd := _zoomed(fixed.scene, common, cameras, options):
            if len(aside) + len(odd) > most:
                break
            fixed = _adjusted_with_camera_lenses(
                without_photos(fixed.scene, set(odd)), cameras, options
            )
            common = without_photos(common, set(odd))
            aside |= odd
        if aside:
            result = _with_supported_deviations(fixed, common, cameras, options)
    adjusted = _scene_of(result)
    if adjusted.own is not None:
        odd = _confirmed_zooms(odd_focals(adjusted), adjusted, cameras) | zoomed_by_solved_focals(
            adjusted
        )
    reasons = {k: note("placing.photo.loose", points=0) for k in lost} | aside
    figures = photo_points(adjusted)
    verdicts = tuple(
        replace(
            one,
            placed=pose is not None,
            points=int(points),
            rms_px=float(rms_px) if pose is not None else math.nan,
            reason=reasons.get(k, one.reason),
            remark=odd.get(k),
        )
        for k, (one, pose, (points, rms_px)) in enumerate(
            zip(scene.verdicts, adjusted.camera_from_world, figures, strict=True)
        )
    )
    return replace(adjusted, verdicts=verdicts, ring=ring_of(adjusted))


def _zoomed(
    adjusted: Scene, before: Scene, cameras: Cameras, options: MappingOptions
) -> dict[int, Finding]:
    """Photos of another focal length than the others, with their findings.

    Args:
        before: The scene with all observations: the adjustment drops many of a zoomed photo.
    """
    judged = focal_outliers(adjusted)
    found = _odd_by_other_points(adjusted, before, judged, cameras, options)
    return _confirmed_zooms(found, adjusted, cameras)


def _confirmed_zooms(odd: dict[int, Finding], scene: Scene, cameras: Cameras) -> dict[int, Finding]:
    """Those whose zoom is a fact by the test of single focal lengths (lens_equations.py)."""
    if not odd:
        return odd
    zoomed = zoomed_photos(LensEquations.of(scene, cameras.calibrations))
    return {k: said for k, said in odd.items() if k in zoomed and not zoomed[k].failed}


def _odd_by_other_points(
    adjusted: Scene,
    before: Scene,
    judged: FocalOutliers,
    cameras: Cameras,
    options: MappingOptions,
) -> dict[int, Finding]:
    """The odd photos, and suspected ones that are odd by points of the other photos alone."""
    odd, suspected = judged.odd, judged.suspected
    few = len(suspected) <= _MAX_ZOOMED_SHARE * len(adjusted.placed)
    if not few or {*suspected} == {*odd}:
        return odd
    try:
        others = _adjusted_with_camera_lenses(
            without_photos(before, {*suspected}), cameras, options
        ).scene
    except PlacementError:  # the scene cannot do without them
        return odd
    poses = [
        before.camera_from_world[photo] if photo in suspected else pose
        for photo, pose in enumerate(others.camera_from_world)
    ]
    seen = before.observations
    theirs = seen.some(~np.isin(seen.photo_idx, suspected))
    rank = {photo: k for k, photo in enumerate(others.placed)}
    known = np.isin(theirs.photo_idx, others.placed)
    held = triangulate(
        others.views,
        np.array([rank[photo] for photo in theirs.photo_idx[known].tolist()], np.int32),
        theirs.point_idx[known],
        theirs.xy_px[known],
        len(before.points_in_world),
    ).points_in_world
    placed = np.asarray(np.isfinite(held).all(axis=1), np.bool_)
    by_others = replace(
        before,
        cameras=others.cameras,
        camera_from_world=tuple(poses),
        points_in_world=held,
        observations=seen.some(placed[seen.point_idx]),
    )
    return odd | odd_by_others(suspected, by_others)


def _foreign_camera_file(
    photos: PhotoSet, features: Features, pairs: Pairs, cameras: Cameras, options: MappingOptions
) -> Finding | None:
    """Finding that a camera file is of another lens, if the photos can be placed without it."""
    if all(one.source != "board" for one in cameras.calibrations):
        return None
    by_exif = contradicting_exif(photos, cameras)
    if by_exif is not None:
        return by_exif
    free = Cameras(tuple(from_exif(group) for group in photos.cameras))
    try:
        scene = _adjusted(_mapped(photos, features, pairs, free, options), free, options)
    except PlacementError:
        return None
    used = sorted({scene.camera_idx[photo] for photo in scene.placed})
    given = [cameras.calibrations[k].camera.fx for k in used]
    shown = [scene.cameras[k].fx for k in used]
    worst = max(range(len(used)), key=lambda k: abs(np.log(given[k] / shown[k])))
    if abs(given[worst] / shown[worst] - 1.0) < _OTHER_FOCAL:
        return None
    return foreign_camera(given[worst], shown[worst], "placed")


def _adjusted(scene: Scene, cameras: Cameras, options: MappingOptions) -> Scene:
    """The adjusted scene, with lens deviations of single photos where residuals support them."""
    common = replace(scene, own=None)
    adjusted = _adjusted_with_camera_lenses(common, cameras, options)
    common = without_photos(common, {*common.placed} - {*adjusted.scene.placed})
    return _scene_of(_with_supported_deviations(adjusted, common, cameras, options))


def _adjusted_with_camera_lenses(
    scene: Scene, cameras: Cameras, options: MappingOptions
) -> Adjusted:
    """The scene adjusted with one lens for each camera, without photos that lose all their points.

    Raises:
        PlacementError: no two photos share points.
    """
    try:
        return adjust(
            scene,
            cameras.calibrations,
            hold_board_lenses=options.board_lenses == "hold",
        )
    except UnconstrainedPhotos as lost:
        if len(scene.placed) - len(lost.photos) < _FEWEST_HELD:
            raise PlacementError("placing.unheld") from lost
        return _adjusted_with_camera_lenses(without_photos(scene, {*lost.photos}), cameras, options)
    except np.linalg.LinAlgError as fault:
        raise PlacementError("placing.unheld") from fault


def _with_supported_deviations(
    adjusted: Adjusted, before: Scene, cameras: Cameras, options: MappingOptions
) -> Adjusted:
    """The adjustment with the lens deviations that it supports, if the options allow any."""
    if options.board_lenses == "hold" or options.photo_lenses == "never":
        return adjusted
    return with_supported_lenses(adjusted, before, cameras.calibrations)


def _scene_of(adjusted: Adjusted) -> Scene:
    """The adjusted scene with its sigma and covariances."""
    return replace(
        adjusted.scene,
        sigma_px=adjusted.sigma_px,
        lens_covariance=adjusted.lens_covariance,
        camera_covariance=adjusted.covariance,
    )


def _misplaced(scene: Scene, pairs: Pairs) -> dict[int, Finding]:
    """Placed photos whose pose is rejected, with the reason."""
    wrong, figures = contradicted(scene, pairs), photo_points(scene)
    reasons: dict[int, Finding] = {}
    for photo in scene.placed:
        points, rms_px = figures[photo]
        if points < MIN_PHOTO_POINTS:
            reasons[photo] = note("placing.photo.loose", points=round(points))
        elif rms_px > _MAX_PHOTO_RMS_PX:
            reasons[photo] = note(
                "placing.photo.misses", rms_px=float(rms_px), most_px=_MAX_PHOTO_RMS_PX
            )
        elif wrong[photo]:
            reasons[photo] = note("placing.photo.contradicted")
    return reasons


def _refuse_too_few(scene: Scene, options: MappingOptions) -> None:
    """Raise if too few photos are placed."""
    placed, count = len(scene.placed), len(scene.names)
    if placed < MIN_PLACED or placed < options.min_placed_share * count:
        missing = tuple(
            name for name, pose in zip(scene.names, scene.camera_from_world) if pose is None
        )
        raise PlacementError("placing.too_few", placed=placed, count=count, missing=missing)


def without_photos(scene: Scene, photos: set[int]) -> Scene:
    """The scene without the poses and observations of some photos."""
    seen = scene.observations
    keep = ~np.isin(seen.photo_idx, sorted(photos))
    poses = [
        None if photo in photos else pose for photo, pose in enumerate(scene.camera_from_world)
    ]
    return replace(
        scene,
        camera_from_world=tuple(poses),
        observations=seen.some(keep),
        camera_covariance=_covariance_without(scene, photos),
    )


def _covariance_without(scene: Scene, photos: set[int]) -> Float64[np.ndarray, "u u"] | None:
    """Covariance of the remaining poses and lenses."""
    if scene.camera_covariance is None:
        return None
    left = np.array([photo not in photos for photo in scene.placed])
    poses = np.repeat(left, POSE_SIZE)
    lenses = len(scene.camera_covariance) - len(poses)
    of_photos = scene.own is not None
    kept = np.r_[poses, np.repeat(left, LENS_SIZE) if of_photos else np.ones(lenses, bool)]
    return scene.camera_covariance[np.ix_(kept, kept)]


def ring_of(scene: Scene) -> Ring:
    """Angular gaps between the photos as seen from the object, and the points that bridge them."""
    placed = np.array(scene.placed)
    centres = np.array([view.centre_in_world for view in scene.views])
    plane = np.linalg.svd(centres - centres.mean(0))[2][:2]
    outward = (centres - np.median(scene.points_in_world, axis=0)) @ plane.T
    angles = np.degrees(np.arctan2(outward[:, 1], outward[:, 0])) % 360.0
    order = np.argsort(angles)
    gaps = np.diff(angles[order], append=angles[order[0]] + 360.0)

    seen = np.zeros((len(scene.points_in_world), len(scene.names)), bool)
    seen[scene.observations.point_idx, scene.observations.photo_idx] = True
    worth = np.ones(len(scene.points_in_world), np.int64)
    if scene.observations.own_sigma_px is not None:
        coded = scene.observations.own_sigma_px > 0
        worth[scene.observations.point_idx[coded]] = _CODED_WORTH
    bridges: list[int] = []
    for start in angles[order]:
        before, after = (start - angles) % 360.0 < _BRIDGE_DEG, (angles - start) % 360.0 > 0.0
        after &= (angles - start) % 360.0 < _BRIDGE_DEG
        both = seen[:, placed[before]].any(1) & seen[:, placed[after]].any(1)
        bridges.append(int(worth[both].sum()))
    narrow = float(gaps.max()) < _BRIDGE_DEG
    return Ring(
        largest_gap_deg=float(gaps.max()),
        weakest_bridge=min(bridges),
        closed=narrow and min(bridges) >= _FEWEST_BRIDGES,
    )
