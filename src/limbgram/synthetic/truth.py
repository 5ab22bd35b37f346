"""The truth of a capture: limb, cameras and boards, exact and without rendering.

In      CaptureOptions.
Out     a Truth, and `surface_points`: sampled points with the views that see them.
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
from limbgram.synthetic.turned_limb import TurnedOver, Turning, standing_photos, turned_limb_poses

BASE_MM = 60.0
_AIM = 0.2
"""Fraction of the limb's height at which the camera aims, so that the board is in the picture."""
_AIM_AT_GAUGE = 0.5
"""The same for a gauge, both of whose ends count alike."""
_FIRST_PHOTO, _FIRST_CALIBRATION_PHOTO = 1001, 901


@dataclass(frozen=True)
class Truth:
    """A capture before its pictures are taken."""

    limb: Limb
    views: tuple[View, ...]
    """Poses in the limb's frame, which is the room's if nothing moves."""
    calibration_views: tuple[View, ...]
    """Poses in the frame of the calibration board's own table."""
    board: LaidBoard | None
    calibration_board: LaidBoard
    room_from_limb: tuple[Rigid, ...]
    """By view; identities if the limb holds still."""
    room_from_board: tuple[Rigid, ...]
    """By view: motion of the board from its place in `board`."""

    def in_room(self, view_idx: int) -> View:
        """A view with its pose in the room."""
        view = self.views[view_idx]
        limb_from_room = self.room_from_limb[view_idx].inverse
        return replace(view, camera_from_world=view.camera_from_world @ limb_from_room)


@dataclass(frozen=True)
class SurfacePoints:
    """Points on the limb's skin with outward unit normals."""

    points_in_world: Points3
    normals_in_world: Points3
    seen: Bool[np.ndarray, "n views"]
    """Whether each view sees the point."""


def stage_truth(options: CaptureOptions) -> Truth:
    """Build the limb, place the boards, and decide where every photo is taken from."""
    limb = _limb_or_gauge(options)
    camera = ideal_camera(options)
    aim = _AIM if options.gauge is None else _AIM_AT_GAUGE
    target = np.array([0.0, 0.0, BASE_MM + aim * limb.height_mm])
    bench = lay_alone(options.calibration_board, options.seed)
    board_poses = over_board(
        bench.outline_in_world(), camera, options.calibration_photos, options.seed
    )
    board = None if options.board is None else lay_beside(options.board, options.seed)
    room_from_limb, room_from_board = _motions(options, limb, target, board)
    last_skin = room_from_limb[-1].apply(limb.mesh.vertices_mm)
    ring = _cameras_from_room(options, target, last_skin)
    return Truth(
        limb=limb,
        views=tuple(
            View(
                f"IMG_{_FIRST_PHOTO + k}.jpg",
                camera_in_photo(camera, options.faults, options.seed, Session.RING, k),
                pose @ motion,
            )
            for k, (pose, motion) in enumerate(zip(ring, room_from_limb, strict=True))
        ),
        calibration_views=tuple(
            View(
                f"CAL_{_FIRST_CALIBRATION_PHOTO + k:04d}.jpg",
                camera_in_photo(camera, options.faults, options.seed, Session.CALIBRATION, k),
                pose,
            )
            for k, pose in enumerate(board_poses)
        ),
        board=board,
        calibration_board=bench,
        room_from_limb=room_from_limb,
        room_from_board=room_from_board,
    )


def ideal_camera(options: CaptureOptions) -> Camera:
    """The camera without faults."""
    return camera_of(options.lens, options.width_px, options.height_px, options.distance_mm)


def _motions(
    options: CaptureOptions, limb: Limb, limb_middle: Vector3, board: LaidBoard | None
) -> tuple[tuple[Rigid, ...], tuple[Rigid, ...]]:
    """room_from_limb and room_from_board of every photo."""
    photos, movement = options.photos, options.movement
    still = (Rigid.identity(),) * photos
    if options.turning is not None:
        turned = turned_limb_poses(
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
    """camera_from_room of every photo."""
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


def _limb_or_gauge(options: CaptureOptions) -> Limb:
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
    """Random vertices of the skin, uniform by area, each seen by two views or more."""
    visible = np.stack(in_parallel(lambda view: seen(view, truth.limb), truth.views), -1)
    mesh = truth.limb.mesh
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    shares = np.bincount(mesh.faces.ravel(), np.repeat(areas, 3), len(mesh.vertices_mm))
    shares[truth.limb.cut | (visible.sum(1) < 2)] = 0.0
    rng = np.random.default_rng((seed, 9))
    chosen = np.sort(rng.choice(len(shares), count, replace=False, p=shares / shares.sum()))
    return SurfacePoints(mesh.vertices_mm[chosen], truth.limb.normals[chosen], visible[chosen])
