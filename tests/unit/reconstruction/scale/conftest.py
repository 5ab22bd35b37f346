"""A capture with known truth: a capsule on a table beside a board, photographed from a ring."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid, Similarity
from limbgram.core.geometry.lens import Camera, View
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, Pick
from limbgram.reconstruction.targets.board import Board, BoardDetections, PhotoCorners

BOARD = Board(
    kind="charuco", columns=7, rows=5, square_mm=30.0, marker_mm=22.0, dictionary="4X4_50"
)
LENS = Camera(width_px=2400, height_px=1600, fx=5500.0, fy=5500.0, cx=1210.0, cy=790.0, k1=-0.1)
WORLD_FROM_BOARD = Rigid(
    np.diag([1.0, -1.0, -1.0]) @ Rotation.from_euler("z", 20, degrees=True).as_matrix(),
    np.array([-60.0, -90.0, 2.5]),
)
"""Board frame to the room: millimetres, z up, table at z = 0, board plate 2.5 mm thick."""
SCENE_FROM_ROOM = Similarity(
    0.0371, Rotation.from_rotvec([0.4, 2.0, -1.0]).as_matrix(), np.array([3.0, -5.0, 9.0])
)


@dataclass(frozen=True)
class Capture:
    """The scene in its arbitrary frame, with what is needed to make detections and picks."""

    room_views: tuple[View, ...]
    scene: Scene

    def detections(
        self, noise_px: float = 0.0, seed: int = 0, stretch_x: float = 1.0
    ) -> BoardDetections:
        """Corners of the board in all photos; `stretch_x` is how wrong it was printed."""
        draw = np.random.default_rng(seed)
        printed = BOARD.corners_mm * (stretch_x, 1.0, 1.0)
        in_room = WORLD_FROM_BOARD.apply(printed)
        ids = np.arange(len(printed), dtype=np.int32)
        photos = []
        for k, view in enumerate(self.room_views):
            xy = view.project(in_room) + draw.normal(scale=noise_px, size=(len(ids), 2))
            photos.append(photo_corners(view.name, k, ids, xy))
        return BoardDetections(
            board=BOARD, corners_mm=BOARD.corners_mm, photos=tuple(photos), set_aside=()
        )

    def corners_in_scene(self) -> np.ndarray:
        """Where the board's corners are in the scene's frame."""
        return SCENE_FROM_ROOM.apply(WORLD_FROM_BOARD.apply(BOARD.corners_mm))

    def distance(
        self, label: str, first_mm: np.ndarray, second_mm: np.ndarray, photos: tuple[int, ...]
    ) -> KnownDistance:
        """The true distance between two points of the room, picked without error."""
        ends = [
            tuple(
                Pick(self.room_views[k].name, *map(float, self.room_views[k].project(end[None])[0]))
                for k in photos
            )
            for end in (first_mm, second_mm)
        ]
        length = float(np.linalg.norm(first_mm - second_mm))
        return KnownDistance(label=label, length_mm=length, first=ends[0], second=ends[1])


def photo_corners(name: str, photo_idx: int, ids: np.ndarray, xy_px: np.ndarray) -> PhotoCorners:
    return PhotoCorners(
        name=name,
        photo_idx=photo_idx,
        ids=ids,
        xy_px=xy_px,
        sigmas_px=np.full(len(ids), 0.05),
        blur_px=1.0,
        step_px=100.0,
        doubtful_ids=np.zeros(0, np.int32),
        doubtful_xy_px=np.zeros((0, 2)),
        doubts=(),
    )


def capsule(count: int, seed: int) -> np.ndarray:
    """Points on an upright capsule: radius 50, from z = 20 to 300."""
    draw = np.random.default_rng(seed)
    normals = draw.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = draw.uniform(70, 250, count)
    ends = np.where(normals[:, 2] > 0, 250.0, 70.0)
    side = draw.random(count) < 0.7
    flat = normals[:, :2] / np.linalg.norm(normals[:, :2], axis=1, keepdims=True)
    wall = np.column_stack([50 * flat, heights])
    cap = 50 * normals + np.column_stack([np.zeros((count, 2)), ends])
    return np.where(side[:, None], wall, cap)


def table(count: int, seed: int) -> np.ndarray:
    draw = np.random.default_rng(seed)
    points = np.column_stack([draw.uniform(-350, 350, (count, 2)), np.zeros(count)])
    return points[np.linalg.norm(points[:, :2], axis=1) > 60]


def ring(count: int, distance_mm: float = 1500.0, turned: bool = False) -> tuple[View, ...]:
    """Views from a ring 35 degrees above the table; `turned` holds the camera on its side."""
    target = np.array([0.0, 0.0, 150.0])
    turn = Rigid(
        Rotation.from_euler("z", 90 if turned else 0, degrees=True).as_matrix(), np.zeros(3)
    )
    views = []
    for k in range(count):
        angle = 2 * np.pi * k / count + 0.1
        rise = np.radians(35 + 5 * np.sin(3 * angle))
        centre = target + distance_mm * np.array(
            [np.cos(rise) * np.sin(angle), -np.cos(rise) * np.cos(angle), np.sin(rise)]
        )
        pose = Rigid.looking_at(centre, target, np.array([0.0, 0.0, 1.0]))
        views.append(View(f"photo{k:02d}.jpg", LENS, turn @ pose))
    return tuple(views)


def scene_of(views: tuple[View, ...], points: np.ndarray) -> Scene:
    nothing = np.zeros(0, np.int32)
    return Scene(
        names=tuple(view.name for view in views),
        cameras=(LENS,),
        camera_idx=(0,) * len(views),
        camera_from_world=tuple(view.camera_from_world for view in views),
        points_in_world=points,
        observations=Observations(nothing, nothing, np.zeros((0, 2))),
        verdicts=(),
    )


@pytest.fixture(scope="session")
def capture() -> Capture:
    views = ring(12)
    points = np.concatenate([capsule(3000, 1), table(900, 2)])
    noise = np.random.default_rng(3).normal(scale=0.05, size=points.shape)
    return Capture(views, scene_of(views, points + noise).moved(SCENE_FROM_ROOM))


@pytest.fixture(scope="session")
def turned_capture() -> Capture:
    """The same with every camera held on its side, and no table in sight."""
    views = ring(12, turned=True)
    return Capture(views, scene_of(views, capsule(3000, 1)).moved(SCENE_FROM_ROOM))


@pytest.fixture(scope="session")
def shaken() -> "type[Shaken]":
    return Shaken


@dataclass(frozen=True)
class Shaken:
    """Poses with independent errors, as an adjustment leaves them."""

    capture: Capture
    shift_mm: float
    turn_deg: float
    seed: int

    @property
    def scene(self) -> Scene:
        draw = np.random.default_rng(self.seed)
        poses = []
        for pose in self.capture.scene.camera_from_world:
            assert pose is not None
            turn = Rotation.from_rotvec(draw.normal(scale=np.radians(self.turn_deg), size=3))
            shift = SCENE_FROM_ROOM.scale * draw.normal(scale=self.shift_mm, size=3)
            poses.append(Rigid(turn.as_matrix() @ pose.rotation, pose.translation + shift))
        return replace(self.capture.scene, camera_from_world=tuple(poses))
