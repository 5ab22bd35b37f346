"""Truth files: the truth of a capture as PLY and JSON.

In      a Truth, and the number of photos that see each vertex of the limb.
Out     mesh.ply (x, y, z, ncam, cap; faces), cameras.json, board.json, notes.json.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt8

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import PARAMETERS, Camera, View
from limbgram.core.typed import tree_of
from limbgram.findings import as_json
from limbgram.formats.ply import face_rows
from limbgram.synthetic.faults import Faults
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.bent import BentShape
from limbgram.synthetic.props.board import LaidBoard, PrintedBoard
from limbgram.synthetic.props.gauges import calibrated_values
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.paint import places_mm
from limbgram.synthetic.props.scan import Scan
from limbgram.synthetic.props.stickers import sticker_places_mm
from limbgram.synthetic.truth import Truth, ideal_camera
from limbgram.synthetic.turned_limb import TurnedOver, Turning

_RIM_MM = 6.0


def write_record(
    folder: Path, truth: Truth, options: CaptureOptions, seen_by: UInt8[np.ndarray, " n"]
) -> None:
    """Write the truth into `folder`."""
    # The cut of a cast that is turned over is visible, and so measured.
    hidden = truth.limb.cut & (not isinstance(options.turning, TurnedOver))
    _write_mesh(folder / "mesh.ply", truth.limb, hidden, seen_by)
    _write_json(folder / "cameras.json", _cameras(truth, ideal_camera(options)))
    _write_json(folder / "board.json", _boards(truth, options))
    _write_json(folder / "notes.json", _notes(truth, options, seen_by))
    if options.gauge is not None:
        _write_json(folder / "artefact.json", calibrated_values(options.gauge))


def _write_mesh(
    path: Path, limb: Limb, hidden: Bool[np.ndarray, " n"], seen_by: UInt8[np.ndarray, " n"]
) -> None:
    vertices = np.empty(len(seen_by), [("xyz", "<f4", 3), ("ncam", "u1"), ("cap", "u1")])
    vertices["xyz"], vertices["ncam"], vertices["cap"] = limb.mesh.vertices_mm, seen_by, hidden
    faces = face_rows(limb.mesh.faces)
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment units mm",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        "property uchar ncam",
        "property uchar cap",
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    path.write_bytes("\n".join(header).encode() + vertices.tobytes() + faces.tobytes())


def _cameras(truth: Truth, camera: Camera) -> dict[str, Any]:
    return {
        "convention": "OpenCV: X_cam = R X_world + t, x right, y down, z forward, mm; pixel "
        "centre of the top-left pixel = (0, 0); distortion k1,k2,p1,p2 (k3=0), Brown-Conrady",
        "world": "mm, z up, table top z=0",
        "intrinsics": {
            "width": camera.width_px,
            "height": camera.height_px,
            **{name: getattr(camera, name) for name in ("fx", "fy", "cx", "cy", "skew")},
        },
        "distortion": {name: getattr(camera, name) for name in ("k1", "k2", "p1", "p2")},
        "images": [
            _pose(view)
            | _own_lens(view.camera, camera)
            | _moved(truth.room_from_limb[k], "room_from_limb")
            for k, view in enumerate(truth.views)
        ],
        "calibration": [
            _pose(view) | _own_lens(view.camera, camera) for view in truth.calibration_views
        ],
    }


def _pose(view: View) -> dict[str, Any]:
    pose = view.camera_from_world
    return {
        "name": view.name,
        "R": pose.rotation.tolist(),
        "t": pose.translation.tolist(),
        "C": pose.centre.tolist(),
    }


def _own_lens(camera: Camera, ideal: Camera) -> dict[str, Any]:
    """Parameters of a photo's lens that differ from `intrinsics`; empty if none does."""
    own = {name: getattr(camera, name) for name in PARAMETERS}
    different = {name: value for name, value in own.items() if value != getattr(ideal, name)}
    return {"own_lens": different} if different else {}


def _moved(motion: Rigid, name: str) -> dict[str, Any]:
    """Motion of limb or board in one photo; empty for the identity."""
    if (motion.matrix_3x4 == Rigid.identity().matrix_3x4).all():
        return {}
    return {name: {"R": motion.rotation.tolist(), "t": motion.translation.tolist()}}


def _boards(truth: Truth, options: CaptureOptions) -> dict[str, Any]:
    turning = options.turning
    carried = isinstance(turning, Turning) and turning.board_turns
    bench = truth.calibration_board
    inner = bench.printed.board.inner
    boards: dict[str, Any] = {
        "calibration_board": {
            "type": "checkerboard",
            "inner_x": inner[0],
            "inner_y": inner[1],
            "square_mm": bench.printed.square_mm,
            **_spoiled(bench.printed),
            **_place(bench),
            "comment": "frame of the calibration session: the board's table, z up",
        }
    }
    if truth.board is not None:
        printed = truth.board.printed
        boards["scene_board"] = {
            "type": "charuco",
            "squares_x": printed.board.columns,
            "squares_y": printed.board.rows,
            "square_mm": printed.square_mm,
            "marker_mm": printed.marker_mm,
            "nominal_square_mm": printed.board.square_mm,
            "dictionary": f"DICT_{printed.board.dictionary}",
            "legacy": False,
            **_spoiled(printed),
            **_place(truth.board),
            "corners_world_mm": truth.board.corners_in_world().tolist(),
            "rotates_with_object": carried,
            **_pushes(truth),
        }
    return boards


def _spoiled(printed: PrintedBoard) -> dict[str, Any]:
    """Stretch and sag of a print; empty if it has neither."""
    faults = {"stretch_down_columns": printed.stretch, "sag_along_rows_mm": printed.sag_mm}
    return {name: strength for name, strength in faults.items() if strength}


def _pushes(truth: Truth) -> dict[str, Any]:
    """Motion of the board from its place, by photo; empty if it stayed."""
    moved = {
        view.name: _moved(motion, "room_from_board")
        for view, motion in zip(truth.views, truth.room_from_board, strict=True)
    }
    return {"pushed": moved} if any(moved.values()) else {}


def _place(laid: LaidBoard) -> dict[str, Any]:
    return {
        "board_frame": "X_world = R X_board + t; origin outer corner of the first square, "
        "x right, y down as printed, z into the plate",
        "R": laid.world_from_board.rotation.tolist(),
        "t": laid.world_from_board.translation.tolist(),
    }


def _notes(
    truth: Truth, options: CaptureOptions, seen_by: UInt8[np.ndarray, " n"]
) -> dict[str, Any]:
    limb, lens = truth.limb, options.lens
    corners = limb.mesh.vertices_mm[limb.mesh.faces]
    areas = 0.5 * np.linalg.norm(limb.mesh.face_normals(), axis=1)
    visible = ((seen_by >= 3) & ~limb.cut)[limb.mesh.faces].all(1)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    return {
        "set": f"synthetic_{_kind(options)}_{options.seed}",
        "kind": _kind(options) if options.gauge is None else options.gauge.kind,
        "gauge": None if options.gauge is None else tree_of(options.gauge),
        **_scan(options.scan),
        "shape_seed": options.seed,
        "paint": options.paint.value,
        "paint_coverage": options.coverage,
        **({"paint_bare": options.bare} if options.bare else {}),
        **({"paint_uneven": options.uneven} if options.uneven else {}),
        **({"details": tree_of(options.details)} if options.details.any else {}),
        "spots": [
            {
                "place_mm": place.tolist(),
                "colour": list(spot.colour),
                "diameter_mm": spot.diameter_mm,
            }
            for spot, place in zip(options.spots, places_mm(limb, options.spots), strict=True)
        ],
        "stickers": [
            {"mark_id": one.mark_id, "place_mm": place.tolist(), "side_mm": one.side_mm}
            for one, place in zip(
                options.stickers, sticker_places_mm(limb, options.stickers), strict=True
            )
        ],
        "turntable": isinstance(options.turning, Turning),
        **_movement(options),
        "object_height_mm": limb.height_mm,
        "z_bottom_mm": limb.base_mm,
        "triangles": len(limb.mesh.faces),
        "volume_ml_closed": float(volume) / 1000,
        "area_mm2": float(areas[~limb.cut[limb.mesh.faces].any(1)].sum()),
        "visible_area_mm2": float(areas[visible].sum()),
        "visible_rule": "vertex seen by >=3 photos: in frame, incidence < 75 deg, unoccluded; "
        "flat cap excluded",
        "mm_per_px_at_object": options.distance_mm / ideal_camera(options).fx,
        "body": {
            "make": lens.make,
            "model": lens.model,
            "lens": lens.name,
            "focal_mm": lens.focal_mm,
            "sensor_w_mm": lens.sensor_width_mm,
            "fnumber": lens.aperture,
        },
        **_faulty(options),
        "shaken": [truth.views[k].name for k in options.shaken],
        "roi": {
            "z_min": limb.base_mm + _RIM_MM,
            "comment": "measured surface = mesh minus 'cap'; the 6 mm above the cut are left out",
        },
    }


def _kind(options: CaptureOptions) -> str:
    return options.kind.value if options.scan is None else "scan"


def _scan(scan: Scan | BentShape | None) -> dict[str, Any]:
    """The file of the shape, by its hash, and notes on what was made of it."""
    if scan is None:
        return {}
    about = {"sha256": scan.sha256, "mm_per_unit": scan.mm_per_unit, "side": scan.side}
    return {"scan": about | {"notes": [as_json(note) for note in scan.notes]}}


def _faulty(options: CaptureOptions) -> dict[str, Any]:
    """Faults of the camera; empty for an ideal one."""
    return {} if options.faults == Faults() else {"faults": tree_of(options.faults)}


def _movement(options: CaptureOptions) -> dict[str, Any]:
    if options.movement is None:
        return {}
    told = {"kind": options.movement.kind.value, "shift_mm": options.movement.shift_mm}
    return {"movement": told | {"turn_deg_per_mm": options.movement.turn_deg_per_mm}}


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")
