"""The pipeline: photos to a mesh in millimetres, one line a stage.

In      photos, calibrated cameras (or none: EXIF), a scale board or known distances.
Out     a Reconstruction: every product, for export and report.
Method  the stages, called through a Run; a Run that keeps products makes it resumable.
Fails   with the refusal of the stage that cannot go on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from limbgram.core.errors import BudgetError, MatchingError, PlacementError, SurfaceError
from limbgram.core.known_words import require_known_words
from limbgram.core.mesh.mesh import Cloud, Mesh, Part
from limbgram.core.notebook import brief
from limbgram.core.run import Run
from limbgram.findings import Finding, note
from limbgram.reconstruction.budget import Resolution, depth_share, refuse_beyond, resolution_for
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    Cameras,
    cameras_for,
    contradicting_exif,
    of_one_file,
    without_files,
)
from limbgram.reconstruction.dense.estimation import estimate_depth
from limbgram.reconstruction.dense.fusion import fuse
from limbgram.reconstruction.dense.photo_depth import DenseOptions
from limbgram.reconstruction.dense.region import Region, RegionOptions, find_region
from limbgram.reconstruction.features.detection import FeatureOptions, Features, detect
from limbgram.reconstruction.joining import (
    MarkedPhotos,
    join_by_marks,
    joins_better,
    leaves_open,
    shared_marks,
)
from limbgram.reconstruction.lens_groups import ByLens
from limbgram.reconstruction.limb_groups import limb_groups
from limbgram.reconstruction.mapping.full_resolution_tracks import FollowingOptions, follow_points
from limbgram.reconstruction.mapping.placement import DEFAULTS as MAPPING
from limbgram.reconstruction.mapping.placement import MappingOptions, place, place_roughly
from limbgram.reconstruction.mapping.scene import Movement, Scene
from limbgram.reconstruction.mapping.verdicts import refuse_contradicted
from limbgram.reconstruction.matching.coded_marks import CodedKeypoints
from limbgram.reconstruction.matching.matching import (
    Matches,
    match,
    match_what_there_is,
)
from limbgram.reconstruction.matching.static_background import StaticBackground, find_still
from limbgram.reconstruction.measuring.measurement import MeasureOptions, measure
from limbgram.reconstruction.movement import (
    LabelledScene,
    Sides,
    corners_agree_better,
    find_bending,
    find_movement,
    held_against_board,
    limb_matches,
    limb_or_board,
    still_board,
    tell_sides,
    told_from_board,
    without_what_moved_beside,
)
from limbgram.reconstruction.photo_lenses import explain_lenses, files_contradicted, lenses_told
from limbgram.reconstruction.photos.lenses import copies_of
from limbgram.reconstruction.photos.photo import PhotoSet, naming_left_out
from limbgram.reconstruction.photos.reading import PhotoOptions, read_photos
from limbgram.reconstruction.poses import (
    Poses,
    Unplaced,
    above_floors,
    board_beside,
    board_of_object,
    may_be_turned_over,
    place_object,
)
from limbgram.reconstruction.scale.marks import mark_distances
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.scale.scaling import ScaleOptions, to_millimetres
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, TapedGirth
from limbgram.reconstruction.scale.taped_girths import TapeWitnesses, hold_tapes
from limbgram.reconstruction.surface.parts import PartOptions, Parts, tell_parts
from limbgram.reconstruction.surface.pivoting import pivot
from limbgram.reconstruction.surface.poisson import poisson
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.reconstruction.surface.repair import repair
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, Board, BoardDetections
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.reconstruction.targets.marks import MarkOptions, find_marks
from limbgram.reconstruction.targets.plates import MarkPlate
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.reconstruction.twoview.verification import verify
from limbgram.reconstruction.user_settings import MOST_TRIANGLES, Choices, SurfaceMethod


@dataclass(frozen=True, kw_only=True)
class Capture:
    """What the user gives: photos, and what is known about camera and scale."""

    sources: tuple[Path, ...]
    """Photo files, or folders of them."""
    calibrations: tuple[Calibration, ...] = ()
    """One for each camera; none: focal length from EXIF, refined in the adjustment."""
    board: Board | None = None
    """The scale board in the scene."""
    distances: tuple[KnownDistance, ...] = ()
    tapes: tuple[TapedGirth, ...] = ()
    """Girths taped on the limb: they set nothing and test the size of all."""
    plates: tuple[MarkPlate, ...] = ()
    """Scale bars, mats and rings with coded marks that lie in the scene."""


_REDUCED = FeatureOptions(max_megapixels=0.6, max_keypoints=4000)
"""Keypoints that photos are placed by where that places all of them."""
_REDUCED_KEYPOINTS = 200_000
"""About so many in all photos together suffice, where each has 2000."""


@dataclass(frozen=True, kw_only=True)
class PipelineOptions:
    """Options of every stage."""

    photos: PhotoOptions = field(default_factory=PhotoOptions)
    features: FeatureOptions = field(default_factory=FeatureOptions)
    """Keypoints that photos are placed by where reduced ones do not place them all."""
    mapping: MappingOptions = field(default_factory=MappingOptions)
    marks: MarkOptions = field(default_factory=MarkOptions)
    """How coded marks are found in the photos."""
    scale: ScaleOptions = field(default_factory=ScaleOptions)
    region: RegionOptions = field(default_factory=RegionOptions)
    surface: SurfaceMethod = "ball-pivoting"
    """How points become a surface: Ball Pivoting or Poisson."""
    parts: PartOptions = field(default_factory=PartOptions)
    most_triangles: int = MOST_TRIANGLES
    """Triangles of the mesh that is measured, at most, those of all parts together."""
    measuring: MeasureOptions = field(default_factory=MeasureOptions)

    def __post_init__(self) -> None:
        require_known_words(self)


DEFAULTS = PipelineOptions()
EDGE_PX = 4.5
"""Edges of the mesh that is measured, in pixels of the photos."""
_FEWEST_REDUCED = 2000
_ENOUGH_REDUCED = 1800
"""Keypoints in the middle one of reduced photos. Sparse paint shows fewer, and none to spare: of
5,700 points 2,300 would be left (limb_sparse15), with centres as good but for fewer places."""
_WORTH_REDUCING = 2.0
"""Only photos this many times the size of reduced ones are reduced. At 0.5 MP 0.972 instead of
0.983 of a limb came out (14 photos, seed 11)."""
_MOST_OF_THEM = 0.8
"""Share of the placed photos that the limb alone must place as well where it moved."""
_FIRM_POINTS = 60
"""Points in each photo from which placing by reduced photos is trusted."""


def options_for(choices: Choices) -> PipelineOptions:
    """Options of the stages from what a user decides."""
    return PipelineOptions(
        surface=choices.surface,
        most_triangles=choices.most_triangles,
        region=RegionOptions(box_mm=choices.box_mm, gap_mm=choices.gap_mm),
        parts=PartOptions(chosen=choices.part),
    )


@dataclass(frozen=True, kw_only=True)
class OtherPart:
    """A sizeable body beside the one that was meant."""

    part: Part
    mesh: Mesh | None
    """Measured in the same way; None where it could not be."""
    reason: Finding | None = None
    """Why it could not be."""


@dataclass(frozen=True, kw_only=True)
class Reconstruction:
    """Every product on the way, the mesh last."""

    photos: PhotoSet
    cameras: Cameras
    features: Features
    matches: Matches
    pairs: Pairs
    detections: BoardDetections | None
    metric: MetricScene
    region: Region
    cloud: Cloud
    resolution: Resolution
    mesh: Mesh
    """The part that was meant, measured."""
    tapes: TapeWitnesses
    others: tuple[OtherPart, ...] = ()
    still: StaticBackground = field(default_factory=StaticBackground)
    """What stands still before the camera while the object turns."""
    poses: Poses = field(default_factory=Poses)
    """Between which photos the object was turned over."""

    __repr__ = brief


def reconstruct(
    capture: Capture, options: PipelineOptions = DEFAULTS, run: Run | None = None
) -> Reconstruction:
    """A surface in millimetres from photos taken round a limb."""
    run = run or Run()
    photos = run(read_photos, capture.sources, options.photos)
    with naming_left_out(photos.set_aside):
        return _reconstructed(photos, capture, options, run)


def _reconstructed(
    photos: PhotoSet, capture: Capture, options: PipelineOptions, run: Run
) -> Reconstruction:
    """The same from photos that are read."""
    refuse_beyond(photos, run.memory_mb)
    cameras = run(cameras_for, photos, capture.calibrations)
    board = capture.board
    found = None if board is None else run(find_board, photos, board)
    dictionary = capture.plates[0].dictionary if capture.plates else KIT_DICTIONARY

    def place(cameras: Cameras) -> PlacedPhotos:
        placing = place_photos(photos, cameras, options, run, found, dictionary)
        return by_the_limb(placed_photos(photos, cameras, placing, found, run), options, run)

    placed = with_files_that_fit(photos, cameras, place, run)
    photos, cameras, placing, found = placed
    distances = capture.distances
    if capture.plates:
        seen = plate_distances(photos, cameras, capture.plates, options.marks, run)
        distances = (*distances, *seen)
    metric = run(
        to_millimetres,
        placing.scene,
        found,
        distances,
        options.scale,
        cameras,
        photos.quarter_turns,
    )
    region = run(find_region, photos, metric, options.region)
    share = depth_share(photos, DenseOptions.most_px, run.memory_mb)
    cloud = _dense(photos, metric, region, placing.poses, share, run)
    # an object that was turned over shows all its sides, and Ball Pivoting stops at sharp edges
    turned_over = bool(placing.poses.sides)
    wrapped = wrap(cloud, "poisson" if turned_over else options.surface, run)
    parts = run(tell_parts, wrapped, cloud, metric.scene.views, options.parts)
    if parts.sides_of_a_wall:
        parts = _wall_in_one(parts, cloud, metric, options.parts, run)
    if turned_over:
        measuring = replace(options.measuring, lay_back_overshoot=True)
        options = replace(options, measuring=measuring)

    def measured(number: int) -> tuple[Mesh, Resolution]:
        return _measured(photos, metric, cloud, parts, number, share, options, run)

    mesh, resolution = measured(parts.chosen)
    others = tuple(_if_it_can_be(part, lambda n: measured(n)[0]) for part in parts.others)
    tapes = run(hold_tapes, mesh, metric.floor_z_mm, capture.tapes)
    return Reconstruction(
        photos=photos,
        cameras=cameras,
        features=placing.features,
        matches=placing.matches,
        pairs=placing.pairs,
        detections=found,
        metric=metric,
        region=region,
        cloud=cloud,
        resolution=resolution,
        mesh=mesh,
        tapes=tapes,
        others=others,
        still=placing.still,
        poses=placing.poses,
    )


def plate_distances(
    photos: PhotoSet,
    cameras: Cameras,
    plates: Sequence[MarkPlate],
    options: MarkOptions,
    run: Run,
) -> tuple[KnownDistance, ...]:
    """The known lengths of all plates, each with the marks of its own dictionary."""
    lenses = tuple(cameras.calibrations[one.camera_idx].camera for one in photos.photos)
    found: list[KnownDistance] = []
    for dictionary in dict.fromkeys(one.dictionary for one in plates):
        marks = run(find_marks, photos, dictionary, lenses, options)
        found += mark_distances(marks, [one for one in plates if one.dictionary == dictionary])
    return tuple(found)


def _dense(
    photos: PhotoSet,
    metric: MetricScene,
    region: Region,
    poses: Poses,
    share: float,
    run: Run,
) -> Cloud:
    """Points of all depth maps; the maps, the largest product, are gone with this call."""
    dense = DenseOptions(most_px=round(share * DenseOptions.most_px))
    depths = run(estimate_depth, photos, metric, region, dense)
    if poses.sides:
        depths = above_floors(depths, metric, poses)
    return run(fuse, photos, metric, depths, region)


def _measured(
    photos: PhotoSet,
    metric: MetricScene,
    cloud: Cloud,
    parts: Parts,
    number: int,
    share: float,
    options: PipelineOptions,
    run: Run,
) -> tuple[Mesh, Resolution]:
    """One part of the surface, repaired, refined and measured, and how finely.

    Args:
        share: Of the pixels that depth maps should have had.
    """
    coarse = run(repair, parts, cloud, number)
    resolution = resolution_for(
        metric,
        coarse,
        beside_mm2=sum(part.area_mm2 for part in parts.parts if part.number != number),
        edge_px=EDGE_PX,
        most_triangles=options.most_triangles,
        depth_share=share,
        memory_mb=run.memory_mb,
    )
    even = run(refine, coarse, resolution.edge_mm)
    measuring = replace(
        options.measuring,
        photo_halvings=resolution.photo_halvings,
        matching=replace(options.measuring.matching, face_parts=resolution.face_parts),
    )
    return run(measure, photos, metric, even, measuring), resolution


@dataclass(frozen=True)
class Placing:
    """Placed photos, and by what."""

    features: Features
    matches: Matches
    pairs: Pairs
    scene: Scene
    still: StaticBackground
    poses: Poses = field(default_factory=Poses)
    followed: bool = False
    """Whether points of reduced photos were followed at full size."""
    coded: CodedKeypoints | None = None
    """Which keypoints are points of coded marks, where these joined the photos."""
    lenses: ByLens | None = None
    """Photos and cameras where the photos themselves told of other lenses than their files."""


def place_photos(
    photos: PhotoSet,
    cameras: Cameras,
    options: PipelineOptions,
    run: Run,
    found: BoardDetections | None = None,
    dictionary: str = KIT_DICTIONARY,
) -> Placing:
    """By paint; where that leaves photos out or the ring open, by coded marks too if these help.

    Args:
        dictionary: Of the coded marks.
    """
    try:
        placing = _by_paint(photos, cameras, options, run, found)
    except (MatchingError, PlacementError):
        marked = _by_marks(photos, cameras, options, run, dictionary, None)
        if marked is None:
            raise
        return marked
    if placing.poses.sides or not leaves_open(placing.scene):
        return placing
    if placing.lenses is not None:
        photos, cameras = placing.lenses.photos, placing.lenses.cameras
    marked = _by_marks(photos, cameras, options, run, dictionary, placing)
    if marked is None or not joins_better(marked.scene, placing.scene):
        return placing
    return marked


def _by_marks(
    photos: PhotoSet,
    cameras: Cameras,
    options: PipelineOptions,
    run: Run,
    dictionary: str,
    before: Placing | None,
) -> Placing | None:
    """The photos by paint and coded marks; None where no two of them share a mark that helps."""
    lenses = tuple(cameras.calibrations[one.camera_idx].camera for one in photos.photos)
    marks = run(find_marks, photos, dictionary, lenses, options.marks)
    if not shared_marks(marks):
        return None
    features, still = _moving_keypoints(photos, options.features, run)
    matches = still.moving_matches(run(match_what_there_is, photos, features))
    by_paint = 0 if before is None else len(before.scene.placed)
    shown = MarkedPhotos(
        photos=photos,
        features=features,
        matches=matches,
        marks=marks,
        still=still,
        cameras=cameras,
        placed_by_paint=by_paint,
    )
    try:
        joined = join_by_marks(shown, options.mapping, run)
    except (MatchingError, PlacementError):
        return None
    scene = joined.scene
    lenses = None
    if before is not None:
        scene, lenses = replace(scene, full_size=before.scene.full_size), before.lenses
    by_marks = Placing(joined.features, joined.matches, joined.pairs, scene, still)
    return replace(by_marks, coded=joined.coded, lenses=lenses)


def _by_paint(
    photos: PhotoSet,
    cameras: Cameras,
    options: PipelineOptions,
    run: Run,
    found: BoardDetections | None,
) -> Placing:
    """By keypoints of reduced photos, followed at full size; where that fails, by those of all.

    Lenses without a calibration are found from the scene's own points and need all of them; and
    where only some parts of an object show points, few points leave the others out of the region.
    Photos hardly larger than reduced ones gain nothing. The board tells whether the object was
    turned over; then the photos are placed by what lies on the object alone.
    """
    largest = max((one.width_px * one.height_px for one in photos.photos), default=0)
    if largest < _WORTH_REDUCING * 1e6 * _REDUCED.max_megapixels:
        return _by_full_size(photos, cameras, options, run, found)
    if any(calibration.source != "board" for calibration in cameras.calibrations):
        reduced = note("placing.reduced.lens")
    elif copies_of(photos):
        reduced = note("placing.reduced.sizes")
    else:
        reduced = _by_reduced(photos, cameras, options, run)
    if isinstance(reduced, Placing):
        features, matches, scene = reduced.features, reduced.matches, reduced.scene
        twice = run(limb_groups, photos, features, matches, scene, cameras).photos
        if not (twice or may_be_turned_over(scene, board_beside(found, reduced.still))):
            return reduced
        reduced = note("placing.reduced.turned_over")
    placing = _by_full_size(photos, cameras, options, run, found)
    return replace(placing, scene=replace(placing.scene, full_size=reduced))


def _moving_keypoints(
    photos: PhotoSet, detecting: FeatureOptions, run: Run
) -> tuple[Features, StaticBackground]:
    """Keypoints without those that stand still before a still camera, and what stands still."""
    features = run(detect, photos, detecting)
    still = run(find_still, features)
    return still.moving(features), still


def _by_reduced(
    photos: PhotoSet, cameras: Cameras, options: PipelineOptions, run: Run
) -> Placing | Finding:
    """All photos placed firmly, or why they are not."""
    share = _REDUCED_KEYPOINTS // max(len(photos.photos), 1)
    most = min(max(share, _FEWEST_REDUCED), _REDUCED.max_keypoints)
    try:
        reduced = replace(_REDUCED, max_keypoints=most)
        features, still = _moving_keypoints(photos, reduced, run)
        if np.median([len(keypoints) for keypoints in features.keypoints]) < _ENOUGH_REDUCED:
            return note("placing.reduced.few_points")
        matches = still.moving_matches(run(match, photos, features))
        pairs = run(verify, photos, matches, cameras)
        rough = run(place_roughly, photos, features, pairs, cameras, options.mapping)
        if lacking := _lacking(rough):
            return lacking
        following = FollowingOptions(mapping=options.mapping)
        scene = run(follow_points, photos, rough, cameras, following)
    except (MatchingError, PlacementError):
        return note("placing.reduced.few_matches")
    return _lacking(scene) or Placing(features, matches, pairs, scene, still, followed=True)


class PlacedPhotos(NamedTuple):
    """Placed photos with the lenses that hold for them, and the board's corners that count."""

    photos: PhotoSet
    cameras: Cameras
    placing: Placing
    found: BoardDetections | None
    """As if the board had held still beside the limb."""


def placed_photos(
    photos: PhotoSet,
    cameras: Cameras,
    placing: Placing,
    found: BoardDetections | None,
    run: Run,
) -> PlacedPhotos:
    """With the lenses that the photos told, and of an object that was turned its own board."""
    if placing.lenses is not None:
        photos, cameras = placing.lenses.photos, placing.lenses.cameras
    if found is not None and (placing.still.groups or placing.poses.sides):
        found = run(board_of_object, found, placing.still, placing.poses)
    return PlacedPhotos(photos, cameras, placing, found)


def with_files_that_fit(
    photos: PhotoSet, cameras: Cameras, place: Callable[[Cameras], PlacedPhotos], run: Run
) -> PlacedPhotos:
    """Photos placed with the camera files given, but those that they contradict as a fact.

    A file of another focal length bends the scene, and all sigmas that rest on it are too small.
    It is left out for photos of every size: few of one size may not contradict it by themselves.
    Bent far enough, photos of one scene look like those of two poses: where nothing is placed, and
    the headers contradict a file too, the file is told, and not what seems to follow from it.

    Raises:
        PlacementError: `place` raised it, or without that file the photos cannot be placed.
    """
    try:
        placed = place(cameras)
    except PlacementError as refusal:
        doubt = contradicting_exif(photos, cameras)
        if doubt is None or refusal.finding.code == "placing.because":  # it tells the cause itself
            raise
        raise PlacementError.of(doubt) from refusal
    facts = files_contradicted(placed.placing.scene)
    if not facts or placed.placing.lenses is not None:  # with the file the photos told of a zoom
        return placed
    files = cameras.calibrations
    told = [files[photos.photos[one.photos[0]].camera_idx] for one in facts]
    wrong = tuple(
        k for k, file in enumerate(files) if any(of_one_file(file, other) for other in told)
    )
    try:
        freed = place(run(without_files, cameras, photos.cameras, wrong))
    except (MatchingError, PlacementError) as refusal:
        findings = lenses_told(placed.placing.scene, placed.cameras, photos)
        foreign = next(one for one in findings if one.code == "lens.foreign")
        raise PlacementError.of(foreign) from refusal
    scene = freed.placing.scene
    explained = replace(scene, lens_explanations=(*facts, *scene.lens_explanations))
    return freed._replace(placing=replace(freed.placing, scene=explained))


def by_the_limb(placed: PlacedPhotos, options: PipelineOptions, run: Run) -> PlacedPhotos:
    """The photos placed by the limb alone where it moved; and what their lenses explain."""
    settled = _settled(placed, options, run)
    scene = settled.placing.scene
    lenses = run(explain_lenses, scene, placed.cameras, settled.found)
    explained = replace(scene, lens_explanations=lenses)
    return settled._replace(placing=replace(settled.placing, scene=explained))


def _settled(placed: PlacedPhotos, options: PipelineOptions, run: Run) -> PlacedPhotos:
    """The photos placed by the limb alone where it moved; otherwise as they are.

    An object that was turned before a still camera, or turned over, moved on purpose.
    """
    photos, cameras, placing, found = placed
    if placing.still.groups or placing.poses.sides:
        return placed

    features, matches = placing.features, placing.matches  # those beside the limb too

    def labelled(one: Placing) -> LabelledScene:
        return LabelledScene(
            photos=photos,
            features=features,
            matches=matches,
            scene=one.scene,
            sides=run(tell_sides, photos, features, one.scene, found),
            cameras=cameras,
            detections=found,
        )

    def told(one: Placing, movement: Movement, seen: LabelledScene) -> PlacedPhotos:
        bent = run(find_bending, replace(seen, scene=one.scene))
        scene = replace(one.scene, movement=movement, bending=bent.movement)
        return placed._replace(placing=replace(one, scene=scene))

    seen = labelled(placing)
    motion = run(find_movement, seen)
    movement, scene = motion.movement, placing.scene
    if not movement.moved:
        return told(placing, movement, seen)
    if found is not None:
        movement = run(held_against_board, seen, motion)
    if movement.beside:
        scene = run(without_what_moved_beside, photos, scene, cameras, options.mapping)
        placing = replace(placing, scene=scene)
    elif found is not None:
        movement = run(told_from_board, seen, motion)
    alone = _by_limb_alone(photos, cameras, placing, seen.sides, options, run)
    if alone is None:
        return told(placing, movement, seen)
    if movement.pushed:
        return told(alone, movement, labelled(alone))
    if movement.beside and found is not None and corners_agree_better(found, scene, alone.scene):
        return told(placing, movement, seen)
    seen_alone = labelled(alone)
    again = run(find_movement, seen_alone)
    if not again.movement.moved:
        return told(placing, movement, seen)
    by_limb = again.movement if movement.moved else limb_or_board(again.movement)
    settled = told(alone, replace(by_limb, alone=True), seen_alone)
    if found is not None:
        found = run(still_board, found, settled.placing.scene, again)
    return settled._replace(found=found)


def _by_limb_alone(
    photos: PhotoSet,
    cameras: Cameras,
    placing: Placing,
    sides: Sides,
    options: PipelineOptions,
    run: Run,
) -> Placing | None:
    """The same photos by the matches on the limb; None where these do not place them."""
    matches = limb_matches(placing.matches, sides)
    features, before = placing.features, placing.scene
    try:
        pairs = run(verify, photos, matches, cameras)
        if placing.followed:
            rough = run(place_roughly, photos, features, pairs, cameras, options.mapping)
            following = FollowingOptions(mapping=options.mapping)
            scene = run(follow_points, photos, rough, cameras, following)
        else:
            mapping = options.mapping
            scene = run(place, photos, features, pairs, cameras, mapping, placing.coded)
    except (MatchingError, PlacementError):
        return None
    if len(scene.placed) < _MOST_OF_THEM * len(before.placed):
        return None
    scene = replace(scene, full_size=before.full_size, marks=before.marks)
    return replace(placing, matches=matches, pairs=pairs, scene=scene)


def _by_full_size(
    photos: PhotoSet,
    cameras: Cameras,
    options: PipelineOptions,
    run: Run,
    found: BoardDetections | None,
) -> Placing:
    features, still = _moving_keypoints(photos, options.features, run)
    matches = still.moving_matches(run(match, photos, features))
    pairs = run(verify, photos, matches, cameras)
    unplaced = Unplaced(
        photos=photos,
        features=features,
        still=still,
        matches=matches,
        pairs=pairs,
        cameras=cameras,
        detections=found,
    )
    return place_pairs(unplaced, run, options.mapping)


def place_pairs(unplaced: Unplaced, run: Run, mapping: MappingOptions = MAPPING) -> Placing:
    """Photos placed by their verified pairs; what stands still is not among these.

    Raises:
        PlacementError: see `place_object`; a scene that its own pairs tear.
    """
    placed = place_object(unplaced, run, mapping)
    if not placed.poses.sides:
        cameras = unplaced.cameras if placed.lenses is None else placed.lenses.cameras
        refuse_contradicted(placed.scene, placed.pairs, cameras)
    return Placing(
        features=unplaced.features,
        matches=placed.matches,
        pairs=placed.pairs,
        scene=placed.scene,
        still=unplaced.still,
        poses=placed.poses,
        lenses=placed.lenses,
    )


def _lacking(scene: Scene) -> Finding | None:
    """What a scene lacks for all photos to stand firmly; None where they do."""
    missing = len(scene.names) - len(scene.placed)
    if missing:
        return note("placing.reduced.unplaced", photos=missing)
    if scene.ring is None or not scene.ring.closed:
        return note("placing.reduced.gap")
    if min(one.points for one in scene.verdicts) < _FIRM_POINTS:
        return note("placing.reduced.loose")
    return None


def _wall_in_one(
    torn: Parts, cloud: Cloud, metric: MetricScene, options: PartOptions, run: Run
) -> Parts:
    """Both sides of a wall as one body where a closed surface joins them, else as they are.

    Ball Pivoting stops at the rim of a pot, which is narrower than its balls.
    """
    wrapped = run(poisson, cloud)
    whole = run(tell_parts, wrapped, cloud, metric.scene.views, options)
    return whole if whole.joins(torn) else torn


def _if_it_can_be(part: Part, measured: Callable[[int], Mesh]) -> OtherPart:
    """A part beside the meant one, measured; what it refuses does not stop the meant one."""
    try:
        return OtherPart(part=part, mesh=measured(part.number))
    except (SurfaceError, BudgetError) as refusal:
        return OtherPart(part=part, mesh=None, reason=refusal.finding)


def wrap(cloud: Cloud, method: SurfaceMethod, run: Run) -> Mesh:
    """The surface through the points, by the chosen method."""
    return run(pivot if method == "ball-pivoting" else poisson, cloud)
