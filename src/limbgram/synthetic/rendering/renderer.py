"""The renderer: what a camera sees of the scene, in linear light, several samples a pixel.

In      a View and a Stage: panels, a mesh, its painted chart.
Out     a picture in linear light; the limb's silhouette; the vertices that a camera sees.
Method  The mesh goes through the exact lens and is rasterised on a lattice of samples (its
        triangles are about a pixel, so that linear interpolation inside them is exact to
        0.001 px); panels are met by rays. A pixel is sampled `samples` x `samples` times
        where limb, print or an edge is in it, and once elsewhere.
Limits  nothing casts a shadow of its own: there is the one painted under the limb, and the straight
        edge that Light brings.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, UInt8

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic.faults import Readout
from limbgram.synthetic.props.board import CALIBRATION_BOARD, PrintedBoard
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.room import MARGIN_MM, Panel
from limbgram.synthetic.rendering.casting import rasterise, shade
from limbgram.synthetic.rendering.shading import Light, Panels, Triangles

SAMPLES = 4
_BUFFER_SAMPLES = 4_000_000
_STEEPEST = np.cos(np.radians(75.0))
_OCCLUSION_MM = 2.0
_LATTICE_PX = 4
_ROW_STEPS = 4
"""A row moves by a thousandth of the step before: four reach 1e-9 px."""

LinearPicture = Float32[np.ndarray, "h w 3"]


@dataclass(frozen=True)
class Stage:
    """All that can be seen: panels, and the limb on its stand with its painted chart."""

    panels: tuple[Panel, ...]
    limb: Limb | None = None
    stand: Mesh | None = None
    skin: UInt8[np.ndarray, "rows columns 4"] | None = None
    room_from_limb: Rigid = field(default_factory=Rigid.identity)
    """Where limb and stand are; panels stay in the room."""


def render(
    view: View,
    stage: Stage,
    light: Light,
    samples: int = SAMPLES,
    readout: Readout | None = None,
) -> LinearPicture:
    """What the camera sees in this light, which is in its frame; `samples` along a pixel's side.

    With a readout every row is drawn from where the camera was when it was read.
    """
    camera = view.camera
    picture = np.zeros((camera.height_px, camera.width_px, 3), np.float32)
    panels = _panels(stage.panels, view.camera_from_world)
    triangles = _triangles(view, stage, readout)
    left, right = _columns(triangles, camera.width_px)
    step = max(1, _BUFFER_SAMPLES // (samples**2 * max(1, right - left)))
    step = step if readout is None else 1
    for top in range(0, camera.height_px, step):
        rows = picture[top : top + step]
        shape = len(rows) * samples, (right - left) * samples
        nearness, face = np.zeros(shape, np.float32), np.full(shape, -1, np.int32)
        rasterise(
            nearness,
            face,
            left,
            top,
            samples,
            triangles.screen,
            triangles.points,
            triangles.faces,
        )
        seen_by_row = panels
        if readout is not None:
            placed = readout.at_row(float(top)) @ view.camera_from_world
            seen_by_row = _placed(panels, stage.panels, placed)
        shade(
            rows, top, samples, left, nearness, face, camera.packed, seen_by_row, triangles, light
        )
    return picture


def nearness_of(view: View, stage: Stage) -> Float32[np.ndarray, "h w"]:
    """1 / depth by pixel, 0 where nothing is.

    The mesh is drawn pixel by pixel; panels are met on a lattice and filled in, exact to 4 px at
    their edges.
    """
    camera = view.camera
    columns = np.append(np.arange(0, camera.width_px - 1, _LATTICE_PX), camera.width_px - 1)
    rows = np.append(np.arange(0, camera.height_px - 1, _LATTICE_PX), camera.height_px - 1)
    lattice = np.stack(np.meshgrid(columns.astype(float), rows.astype(float)), axis=-1)
    ideal = camera.normalize(lattice)
    rays = np.concatenate([ideal, np.ones((*ideal.shape[:2], 1))], axis=-1)
    near = np.zeros(ideal.shape[:2])
    for row in _rows(stage.panels, view.camera_from_world):
        facing = rays @ row[9:12]
        inverse = np.where(facing < 0, facing / min(float(row[9:12] @ row[:3]), -1e-9), 0.0)
        reached = rays / np.maximum(inverse, 1e-9)[..., None] - row[:3]
        right, down = reached @ row[3:6], reached @ row[6:9]
        inside = (right >= 0) & (right <= row[12]) & (down >= 0) & (down <= row[13])
        near = np.where(inside & (inverse > near), inverse, near)
    wide, high = np.arange(camera.width_px), np.arange(camera.height_px)
    across = np.interp(wide, columns, np.arange(len(columns))).astype(np.float32)
    along = np.interp(high, rows, np.arange(len(rows))).astype(np.float32)
    met = cv2.remap(near.astype(np.float32), *np.meshgrid(across, along), cv2.INTER_LINEAR)
    triangles = _triangles(view, stage)
    drawn = np.zeros((camera.height_px, camera.width_px), np.float32)
    face = np.full(drawn.shape, -1, np.int32)
    rasterise(drawn, face, 0, 0, 1, triangles.screen, triangles.points, triangles.faces)
    return np.where(drawn > 0, drawn, met)


def silhouette(view: View, limb: Limb) -> Bool[np.ndarray, "h w"]:
    """Pixels whose centre shows the limb."""
    return _drawn(view, limb.mesh) > 0


def seen(view: View, limb: Limb) -> Bool[np.ndarray, " n"]:
    """Vertices in the picture, not hidden by the limb, seen less than 75 degrees obliquely."""
    nearness = _drawn(view, limb.mesh)
    points = view.camera_from_world.apply(limb.mesh.vertices_mm)
    xy = view.camera.project(points)
    inside = view.camera.contains(xy)
    normals = limb.normals @ view.camera_from_world.rotation.T
    facing = -(normals * points).sum(1) / np.linalg.norm(points, axis=1)
    at = np.where(inside[:, None], np.rint(xy), 0).astype(int)
    depth = 1 / np.maximum(nearness[at[:, 1], at[:, 0]], 1e-9)
    return inside & (facing > _STEEPEST) & (points[:, 2] < depth + _OCCLUSION_MM)


def _drawn(view: View, mesh: Mesh) -> Float32[np.ndarray, "h w"]:
    """1 / depth of the mesh at pixel centres, 0 where it is not."""
    points = view.camera_from_world.apply(mesh.vertices_mm)
    nearness = np.zeros((view.camera.height_px, view.camera.width_px), np.float32)
    face = np.full(nearness.shape, -1, np.int32)
    rasterise(nearness, face, 0, 0, 1, view.camera.project(points), points, mesh.faces)
    return nearness


def _triangles(view: View, stage: Stage, readout: Readout | None = None) -> Triangles:
    """Limb and stand as the camera sees them; an empty stage gives no triangles."""
    meshes = [part for part in (stage.limb and stage.limb.mesh, stage.stand) if part]
    points = np.concatenate([np.zeros((0, 3)), *(mesh.vertices_mm for mesh in meshes)])
    normals = np.zeros((0, 3)) if stage.limb is None else stage.limb.normals
    if stage.stand is not None:
        normals = np.concatenate([normals, stage.stand.vertex_normals()])
    starts = np.cumsum([0, *(len(mesh.vertices_mm) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    camera_from_limb = view.camera_from_world @ stage.room_from_limb
    points = camera_from_limb.apply(points)
    if readout is not None:
        points = _read_by_rows(points, view, readout)
    limb_faces = len(faces[0]) if stage.limb is not None else 0
    chart = np.zeros((0, 3, 2), np.float32) if stage.limb is None else stage.limb.chart
    skin = np.zeros((2, 2, 4), np.uint8) if stage.skin is None else stage.skin
    fine = 1 if stage.limb is None else (len(skin) - 1) // (len(stage.limb.grid_mm) - 1)
    return Triangles(
        screen=view.camera.project(points),
        points=points,
        normals=normals @ camera_from_limb.rotation.T,
        faces=np.concatenate([np.zeros((0, 3), np.int32), *faces]).astype(np.int32),
        limb_faces=limb_faces,
        chart=chart,
        skin=skin,
        skin_fine=fine,
    )


def _read_by_rows(points: Points3, view: View, readout: Readout) -> Points3:
    """Points in the camera's frame at the row that reads each: where the row agrees with itself."""
    placed = points
    for _ in range(_ROW_STEPS):
        rows = view.camera.project(placed)[:, 1]
        placed = readout.at_rows(points, np.nan_to_num(rows))
    return placed


def _columns(triangles: Triangles, width_px: int) -> tuple[int, int]:
    """First and last pixel column that the mesh can touch."""
    if len(triangles.screen) == 0:
        return 0, 0
    low, high = triangles.screen[:, 0].min(), triangles.screen[:, 0].max()
    left = int(np.clip(np.floor(low) - 1, 0, width_px))
    return left, int(np.clip(np.ceil(high) + 2, left, width_px))


def _panels(panels: tuple[Panel, ...], camera_from_world: Rigid) -> Panels:
    """Panels in the camera frame, their textures one after the other."""
    rows = _rows(panels, camera_from_world)
    kinds: list[tuple[int, int, int]] = []
    texels = [np.zeros((0, 3), np.uint8)]
    board = CALIBRATION_BOARD
    first = 0
    for panel in panels:
        if isinstance(panel.picture, PrintedBoard):
            board = panel.picture
            kinds.append((0, 0, 0))
            continue
        kinds.append((first, *panel.picture.shape[:2]))
        texels.append(panel.picture.reshape(-1, 3))
        first += len(texels[-1])
    return Panels(
        rows=rows,
        bounds=_bounds(rows),
        kinds=np.array(kinds, np.int64),
        texels=np.concatenate(texels),
        cells=board.board.cells(),
        square_mm=board.square_mm,
        marker_mm=board.marker_mm,
        margin_mm=MARGIN_MM,
    )


def _placed(panels: Panels, known: tuple[Panel, ...], camera_from_world: Rigid) -> Panels:
    """The same panels for another pose."""
    rows = _rows(known, camera_from_world)
    return panels._replace(rows=rows, bounds=_bounds(rows))


def _rows(panels: tuple[Panel, ...], camera_from_world: Rigid) -> Float64[np.ndarray, "panels 18"]:
    """Where the panels are in the camera's frame, as `Panels.rows` has it."""
    if not panels:
        return np.zeros((0, 18))
    turn = camera_from_world.rotation.T
    right = np.array([panel.right for panel in panels]) @ turn
    down = np.array([panel.down for panel in panels]) @ turn
    origin = camera_from_world.apply(np.array([panel.origin for panel in panels]))
    sizes = np.array([panel.size_mm for panel in panels])
    prints = np.array([panel.print_from_panel for panel in panels])
    return np.concatenate([origin, right, down, np.cross(down, right), sizes, prints], axis=1)


def _bounds(rows: Float64[np.ndarray, "n 18"]) -> Float64[np.ndarray, "n 4"]:
    """Where panels can appear on the ideal plane; everywhere if they reach behind the camera."""
    across, along = rows[:, 12:13] * rows[:, 3:6], rows[:, 13:14] * rows[:, 6:9]
    corners = rows[:, None, :3] + np.stack([0 * across, along, across, across + along], axis=1)
    behind = corners[..., 2].min(axis=1, initial=np.inf) <= 1.0
    flat = corners[..., :2] / np.where(behind[:, None], 1.0, corners[..., 2])[..., None]
    low, high = flat.min(axis=1) - 1e-9, flat.max(axis=1) + 1e-9
    everywhere = np.array([-np.inf, -np.inf, np.inf, np.inf])
    return np.where(behind[:, None], everywhere, np.concatenate([low, high], axis=1))
