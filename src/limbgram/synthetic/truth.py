"""The truth: where everything is, known exactly before a picture is taken.

In      CaptureOptions.
Out     a Truth: the limb, the views, the boards. Its views and `surface_points` give later
        stages something to test against without a picture being rendered.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.run import in_parallel
from limbgram.synthetic.faults import Session, camera_in_photo
from limbgram.synthetic.movement import MovementKind, motions
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import (
    camera_of,
    film_round,
    on_tripod,
    over_board,
    walk_round,
)
from limbgram.synthetic.props.bent import BentShape, limb_of_bent
from limbgram.synthetic.props.board import LaidBoard, lay_alone, lay_beside
from limbgram.synthetic.props.gauges import make_gauge
from limbgram.synthetic.props.limb import Limb, make_limb
from limbgram.synthetic.props.scan import Scan, limb_of_scan
from limbgram.synthetic.rendering.renderer import seen
from limbgram.synthetic.turned_limb import TurnedOver, Turning, room_from_limb, standing_photos

BASE_MM = 60.0
_AIM = 0.2
"""Fraction of the limb's height that is looked at, so that the board is in the picture."""
_AIM_AT_GAUGE = 0.5
"""The same of a gauge: both ends of a bar count alike."""
_FIRST_PHOTO, _FIRST_CALIBRATION_PHOTO = 1001, 901


@dataclass(frozen=True)
class Truth:
    """A capture before its pictures are taken."""

    limb: Limb
    views: tuple[View, ...]
    """Cameras in the limb's frame, which is the room's where nothing moves."""
    calibration_views: tuple[View, ...]
    """Their world frame is the calibration board's table, not the limb's."""
    board: LaidBoard | None
    calibration_board: LaidBoard
    room_from_limb: tuple[Rigid, ...]
    """By view: where the limb stands in the room; all the same where it holds still."""
    room_from_board: tuple[Rigid, ...]
    """By view: how the board was moved from the place that `board` tells."""

    def in_room(self, view_idx: int) -> View:
        """A view with its pose in the room."""
        view = self.views[view_idx]
        back = self.room_from_limb[view_idx].inverse
        return replace(view, camera_from_world=view.camera_from_world @ back)


@dataclass(frozen=True)
class SurfacePoints:
    """Points on the limb's skin with outward unit normals."""

    points_in_world: Points3
    normals_in_world: Points3
    seen: Bool[np.ndarray, "n views"]
    """Which view sees which point."""


def stage_truth(options: CaptureOptions) -> Truth:
    """Build the limb, place the boards, and decide where every photo is taken from."""
    limb = _what_stands_there(options)
    camera = ideal_camera(options)
    aim = _AIM if options.gauge is None else _AIM_AT_GAUGE
    target = np.array([0.0, 0.0, BASE_MM + aim * limb.height_mm])
    bench = lay_alone(options.calibration_board, options.seed)
    tilted = over_board(bench.outline_in_world(), camera, options.calibration_photos, options.seed)
    board = None if options.board is None else lay_beside(options.board, options.seed)
    limb_moves, board_moves = _motions(options, limb, target, board)
    ring = _cameras_from_room(options, target, limb_moves[-1].apply(limb.mesh.vertices_mm))
    return Truth(
        limb=limb,
        views=tuple(
            View(
                f"IMG_{_FIRST_PHOTO + k}.jpg",
                camera_in_photo(camera, options.faults, options.seed, Session.RING, k),
                pose @ limb_in_room,
            )
            for k, (pose, limb_in_room) in enumerate(zip(ring, limb_moves, strict=True))
        ),
        calibration_views=tuple(
            View(
                f"CAL_{_FIRST_CALIBRATION_PHOTO + k:04d}.jpg",
                camera_in_photo(camera, options.faults, options.seed, Session.CALIBRATION, k),
                pose,
            )
            for k, pose in enumerate(tilted)
        ),
        board=board,
        calibration_board=bench,
        room_from_limb=limb_moves,
        room_from_board=board_moves,
    )


def ideal_camera(options: CaptureOptions) -> Camera:
    """The camera without its faults: every photo's own where it has none."""
    return camera_of(options.lens, options.width_px, options.height_px, options.distance_mm)


def _motions(
    options: CaptureOptions, limb: Limb, limb_middle: Vector3, board: LaidBoard | None
) -> tuple[tuple[Rigid, ...], tuple[Rigid, ...]]:
    """room_from_limb and room_from_board of every photo."""
    photos, movement = options.photos, options.movement
    still = (Rigid.identity(),) * photos
    if options.turning is not None:
        turned = room_from_limb(
            options.turning, photos, options.rings, limb.mesh.vertices_mm, options.seed
        )
        carried = isinstance(options.turning, Turning) and options.turning.board_turns
        return turned, turned if carried else still
    if movement is None or movement.kind is MovementKind.BEND:
        return still, still
    if movement.kind is MovementKind.PUSHED_BOARD and board is not None:
        middle = board.outline_in_world().mean(0)
        return still, motions(movement, photos, options.seed, middle)
    return motions(movement, photos, options.seed, limb_middle), still


def _cameras_from_room(
    options: CaptureOptions, target: Vector3, last_skin: Points3
) -> tuple[Rigid, ...]:
    """Where the photographer stands in the room, photo by photo."""
    distance_mm, photos = options.distance_mm, options.photos
    rings, seed = options.rings, options.seed
    if options.filmed:
        return film_round(target, distance_mm, photos, seed)
    match options.turning:
        case Turning():
            return on_tripod(target, distance_mm, photos, rings, seed)
        case TurnedOver():
            standing = standing_photos(photos)
            middle = 0.5 * (last_skin.min(0) + last_skin.max(0))
            return (
                *walk_round(target, distance_mm, standing, rings, seed),
                *walk_round(middle, distance_mm, photos - standing, rings, seed + 1),
            )
        case None:
            return walk_round(target, distance_mm, photos, rings, seed, options.elevations_deg)


def _what_stands_there(options: CaptureOptions) -> Limb:
    if options.gauge is not None:
        return make_gauge(options.gauge, options.mesh_step_mm, BASE_MM)
    step_mm, relief, details = options.mesh_step_mm, options.relief, options.details
    match options.scan:
        case BentShape() as bent:
            return limb_of_bent(bent, options.seed, step_mm, BASE_MM, relief, details)
        case Scan() as scan:
            return limb_of_scan(scan, options.seed, step_mm, BASE_MM, relief, details)
        case None:
            kind, fin_mm = options.kind, options.fin_mm
            return make_limb(kind, options.seed, step_mm, BASE_MM, fin_mm, relief, details)


def surface_points(truth: Truth, count: int, seed: int = 0) -> SurfacePoints:
    """Random vertices of the skin, each seen by two views or more, spread evenly by area."""
    visible = np.stack(in_parallel(lambda view: seen(view, truth.limb), truth.views), -1)
    mesh = truth.limb.mesh
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    shares = np.bincount(mesh.faces.ravel(), np.repeat(areas, 3), len(mesh.vertices_mm))
    shares[truth.limb.cut | (visible.sum(1) < 2)] = 0.0
    rng = np.random.default_rng((seed, 9))
    chosen = np.sort(rng.choice(len(shares), count, replace=False, p=shares / shares.sum()))
    return SurfacePoints(mesh.vertices_mm[chosen], truth.limb.normals[chosen], visible[chosen])
