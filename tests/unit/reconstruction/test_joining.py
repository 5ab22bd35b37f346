"""Coded marks join photos where paint does not, and one that moved is left out by its number."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import PlacementError
from limbgram.core.geometry.frames import Rigid, fit_similarity
from limbgram.core.geometry.lens import LENS_SIZE, Camera, View
from limbgram.core.run import Run
from limbgram.findings import told
from limbgram.reconstruction import joining
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.features.detection import Features, Keypoints
from limbgram.reconstruction.joining import (
    join_by_marks,
    joins_better,
    leaves_open,
    shared_marks,
)
from limbgram.reconstruction.mapping.placement import MappingOptions, place
from limbgram.reconstruction.matching.coded_marks import with_marks
from limbgram.reconstruction.matching.matching import Matches, PairMatches
from limbgram.reconstruction.matching.static_background import StaticBackground
from limbgram.reconstruction.photos.photo import CameraGroup, Exif, Photo, PhotoSet
from limbgram.reconstruction.targets.marks import MarkDetections, PhotoMarks
from limbgram.reconstruction.twoview.verification import verify

PHOTOS, ARC, MARKS = 12, 6, 20
RADIUS_MM, SIDE_MM = 60.0, 18.0
NOISE_PX = 0.04
LENS = Camera(width_px=900, height_px=700, fx=1500.0, fy=1500.0, cx=450.0, cy=350.0)


def views() -> list[View]:
    found: list[View] = []
    for k in range(PHOTOS):
        turn = 2 * np.pi * k / PHOTOS
        centre = 900.0 * np.array([np.cos(turn), np.sin(turn), 0.3 + 0.1 * (k % 2)])
        pose = Rigid.looking_at(centre, np.zeros(3), np.array([0.0, 0.0, 1.0]))
        found.append(View(f"{k}.jpg", LENS, pose))
    return found


def on_skin(turn: np.ndarray, height_mm: np.ndarray) -> np.ndarray:
    return np.stack([RADIUS_MM * np.cos(turn), RADIUS_MM * np.sin(turn), height_mm], axis=-1)


def faces(view: View, places_mm: np.ndarray) -> np.ndarray:
    """Whether a photo looks at the skin at less than 65 degrees."""
    outward = places_mm * [1.0, 1.0, 0.0]
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    toward = view.centre_in_world - places_mm
    toward /= np.linalg.norm(toward, axis=-1, keepdims=True)
    return (outward * toward).sum(-1) > np.cos(np.radians(65))


def mark_corners_mm(mark: int, shift_mm: float = 0.0) -> np.ndarray:
    turn, height = 2 * np.pi * (0.381966 * mark % 1.0), -70.0 + 140.0 * mark / MARKS
    middle = on_skin(np.array(turn), np.array(height))
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    square = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * SIDE_MM
    up = np.array([0.0, 0.0, 1.0])
    return middle + square[:, :1] * across + square[:, 1:] * up + shift_mm * across


@dataclass(frozen=True)
class Walk:
    """Photos of two arcs whose paint has nothing in common."""

    photos: PhotoSet
    features: Features
    matches: Matches
    marks: MarkDetections


def walk(moved: int | None = None, most_marks: int = MARKS) -> Walk:
    """A capture; the mark `moved` lies elsewhere in every photo."""
    random = np.random.default_rng(3)
    turns, heights = random.uniform(0, 2 * np.pi, 1500), random.uniform(-90, 90, 1500)
    paint = on_skin(turns, heights)
    ids: list[np.ndarray] = []
    keypoints: list[Keypoints] = []
    shown: list[PhotoMarks] = []
    for k, view in enumerate(views()):
        arc = np.arange(len(paint)) % 2 == k // ARC  # what a photo of the other arc does not find
        own = np.flatnonzero(faces(view, paint) & arc)
        xy_px = view.project(paint[own]) + random.normal(0, NOISE_PX, (len(own), 2))
        ids.append(own)
        keypoints.append(
            Keypoints(
                xy_px=xy_px.astype(np.float32),
                scale_px=np.ones(len(own), np.float32),
                angle_deg=np.zeros(len(own), np.float32),
                descriptors=np.zeros((len(own), 128), np.uint8),
            )
        )
        corners: list[np.ndarray] = []
        seen: list[int] = []
        for mark in range(most_marks):
            at = mark_corners_mm(mark, 4.0 * k if mark == moved else 0.0)
            if faces(view, at).all():
                corners.append(view.project(at) + random.normal(0, NOISE_PX, (4, 2)))
                seen.append(mark)
        count = len(seen)
        shown.append(
            PhotoMarks(
                name=view.name,
                photo_idx=k,
                ids=np.array(seen, np.int32),
                corners_px=np.array(corners).reshape(-1, 4, 2),
                centres_px=np.array([one.mean(0) for one in corners]).reshape(-1, 2),
                sigmas_px=np.full(count, 0.01),
                bent=np.zeros(count, bool),
                doubtful_ids=np.zeros(0, np.int32),
                doubts=(),
            )
        )
    pairs: list[PairMatches] = []
    for first in range(PHOTOS):
        for second in range(first + 1, PHOTOS):
            _, here, there = np.intersect1d(ids[first], ids[second], return_indices=True)
            if len(here) < 20:
                continue
            pairs.append(
                PairMatches(
                    first=first,
                    second=second,
                    keypoint_idx=np.column_stack([here, there]).astype(np.int32),
                    xy_first_px=keypoints[first].xy_px[here].astype(float),
                    xy_second_px=keypoints[second].xy_px[there].astype(float),
                    correlation=np.ones(len(here), np.float32),
                )
            )
    photos = tuple(
        Photo(
            name=view.name,
            path=Path(view.name),
            width_px=LENS.width_px,
            height_px=LENS.height_px,
            exif=Exif(),
            sha256="",
            camera_idx=0,
        )
        for view in views()
    )
    group = CameraGroup(label="", width_px=LENS.width_px, height_px=LENS.height_px, exif=Exif())
    return Walk(
        PhotoSet(photos, (group,)),
        Features(tuple(keypoints)),
        Matches(pairs=tuple(pairs), pairs_tried=len(pairs), descriptor_matches=0),
        MarkDetections(dictionary="APRILTAG_36h11", photos=tuple(shown)),
    )


CAMERAS = Cameras(
    (Calibration(camera=LENS, covariance=np.zeros((LENS_SIZE, LENS_SIZE)), source="board"),)
)


def centre_rms_mm(found: dict[int, np.ndarray]) -> float:
    true = np.array([views()[k].centre_in_world for k in found])
    here = np.array(list(found.values()))
    return float(np.sqrt(np.mean((fit_similarity(here, true).apply(here) - true) ** 2)))


def joined_by_marks(made: Walk, placed_by_paint: int) -> joining.Joined:
    shown = joining.MarkedPhotos(
        photos=made.photos,
        features=made.features,
        matches=made.matches,
        marks=made.marks,
        still=StaticBackground(),
        cameras=CAMERAS,
        placed_by_paint=placed_by_paint,
    )
    return join_by_marks(shown, MappingOptions(), Run())


def test_marks_join_two_arcs_that_no_paint_joins() -> None:
    made = walk()
    pairs = verify(made.photos, made.matches, CAMERAS)
    by_paint = place(made.photos, made.features, pairs, CAMERAS)
    assert len(by_paint.placed) == ARC
    assert leaves_open(by_paint)
    joined = joined_by_marks(made, len(by_paint.placed))
    scene = joined.scene
    assert len(scene.placed) == PHOTOS
    assert not leaves_open(scene)
    assert joins_better(scene, by_paint)
    assert not joins_better(by_paint, scene)
    assert scene.marks is not None
    assert scene.marks.photos_by_paint == ARC
    assert scene.marks.ids == shared_marks(made.marks)
    assert scene.marks.left_out == ()
    centres = {k: scene.view(k).centre_in_world for k in scene.placed}
    assert 0.001 < centre_rms_mm(centres) < 0.5
    own = scene.observations.own_sigma_px
    assert own is not None
    shown = sum(len(one.ids) for one in made.marks.photos)
    assert 3.5 * shown < (own > 0).sum() <= 4 * shown  # corners alone, nearly all of them
    assert set(np.unique(own)) == {0.0, 0.05}


def test_a_mark_that_moved_is_left_out_and_named() -> None:
    made = walk(moved=7)
    joined = joined_by_marks(made, ARC)
    marks = joined.scene.marks
    assert marks is not None
    assert marks.left_out == (7,)
    assert "moved against the others" in told(marks.reasons[0])
    assert 7 not in marks.ids
    assert all(7 not in ids for ids in joined.coded.ids)
    centres = {k: joined.scene.view(k).centre_in_world for k in joined.scene.placed}
    assert len(centres) == PHOTOS
    assert centre_rms_mm(centres) < 0.5


def test_a_mark_that_stands_still_before_a_still_camera_belongs_to_the_room() -> None:
    made = walk()
    room = np.array([[100.0, 100.0], [130.0, 100.0], [130.0, 130.0], [100.0, 130.0]])
    photos = tuple(
        replace(
            one,
            ids=np.append(one.ids, np.int32(400)),
            corners_px=np.concatenate([one.corners_px, room[None] + 0.1 * (k % 2)]),
            centres_px=np.concatenate([one.centres_px, room.mean(0)[None]]),
            sigmas_px=np.append(one.sigmas_px, 0.01),
            bent=np.append(one.bent, False),
        )
        for k, one in enumerate(made.marks.photos)
    )
    flags = tuple(np.zeros(len(one), bool) for one in made.features.keypoints)
    still = StaticBackground(groups=(tuple(range(PHOTOS)),), keypoints=flags)
    given = with_marks(made.features, made.matches, replace(made.marks, photos=photos), still)
    assert given.coded.in_room == (400,)
    assert all(400 not in ids for ids in given.coded.ids)
    assert any(len(ids) for ids in given.coded.ids)


@pytest.mark.parametrize("marks", [0, 1])
def test_one_mark_alone_makes_no_pair(marks: int) -> None:
    made = walk(most_marks=marks)
    bare = replace(made.matches, pairs=())
    given = with_marks(made.features, bare, made.marks, StaticBackground())
    assert given.matches.pairs == ()
    assert shared_marks(made.marks) == tuple(range(marks))


@pytest.mark.slow
def test_marks_of_which_others_do_not_fit_each_time_join_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made, odd = walk(), iter([{1: "moved"}, {2: "moved"}, {3: "moved"}])
    monkeypatch.setattr(joining, "_odd_marks", lambda *_: next(odd))
    with pytest.raises(PlacementError, match="Marks 1, 2, 3 do not stay"):
        joined_by_marks(made, ARC)
