"""The renderer: what a camera sees of the scene, in linear light, several samples a pixel.

In      a View and a RenderScene: panels, a mesh, its texture.
Out     a picture in linear light; the limb's silhouette; the vertices that a camera sees.
Method  The mesh is projected through the exact lens and rasterised (its triangles are about a
        pixel, so that linear interpolation inside them is exact to 0.001 px); panels are ray cast.
        A pixel has `samples` x `samples` samples if limb, print or an edge is in it, and one
        elsewhere.
Limits  no cast shadows, except the one painted under the limb and the straight edge of Light.
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
from limbgram.synthetic.rendering.developing import LinearPicture
from limbgram.synthetic.rendering.shading import Light, Panels, Triangles

SAMPLES = 4
_BUFFER_SAMPLES = 4_000_000
_STEEPEST = np.cos(np.radians(75.0))
_OCCLUSION_MM = 2.0
_LATTICE_PX = 4
_ROW_STEPS = 4
"""Fixed-point steps for the row that reads a point: each is a thousandth of the last, four reach
1e-9 px."""


@dataclass(frozen=True)
class RenderScene:
    """What is rendered: panels, and the limb on its stand with its texture."""

    panels: tuple[Panel, ...]
    limb: Limb | None = None
    stand: Mesh | None = None
    skin: UInt8[np.ndarray, "rows columns 4"] | None = None
    room_from_limb: Rigid = field(default_factory=Rigid.identity)
    """Pose of limb and stand; panels are in the room's frame."""


def render(
    view: View,
    scene: RenderScene,
    light: Light,
    samples: int = SAMPLES,
    readout: Readout | None = None,
) -> LinearPicture:
    """Render a view.

    Args:
        light: In the camera frame.
        samples: Samples along a pixel's side.
        readout: Rolling shutter: each row is rendered from the pose at which it was read.
    """
    camera = view.camera
    picture = np.zeros((camera.height_px, camera.width_px, 3), np.float32)
    panels = _panels(scene.panels, view.camera_from_world)
    triangles = _triangles(view, scene, readout)
    left, right = _columns(triangles, camera.width_px)
    step = max(1, _BUFFER_SAMPLES // (samples**2 * max(1, right - left)))
    step = step if readout is None else 1
    for top in range(0, camera.height_px, step):
        rows = picture[top : top + step]
        shape = len(rows) * samples, (right - left) * samples
        inverse_depth, face = np.zeros(shape, np.float32), np.full(shape, -1, np.int32)
        rasterise(
            inverse_depth,
            face,
            left,
            top,
            samples,
            triangles.screen,
            triangles.points,
            triangles.faces,
        )
        row_panels = panels
        if readout is not None:
            row_from_world = readout.at_row(float(top)) @ view.camera_from_world
            row_panels = _at_pose(panels, scene.panels, row_from_world)
        shade(
            rows,
            top,
            samples,
            left,
            inverse_depth,
            face,
            camera.packed,
            row_panels,
            triangles,
            light,
        )
    return picture


def inverse_depth_of(view: View, scene: RenderScene) -> Float32[np.ndarray, "h w"]:
    """1 / depth of each pixel, 0 where nothing is.

    Panels are ray cast on a lattice of 4 px and interpolated.
    """
    camera = view.camera
    columns = np.append(np.arange(0, camera.width_px - 1, _LATTICE_PX), camera.width_px - 1)
    rows = np.append(np.arange(0, camera.height_px - 1, _LATTICE_PX), camera.height_px - 1)
    lattice = np.stack(np.meshgrid(columns.astype(float), rows.astype(float)), axis=-1)
    ideal = camera.normalize(lattice)
    rays = np.concatenate([ideal, np.ones((*ideal.shape[:2], 1))], axis=-1)
    on_lattice = np.zeros(ideal.shape[:2])
    for row in _rows(scene.panels, view.camera_from_world):
        facing = rays @ row[9:12]
        inverse = np.where(facing < 0, facing / min(float(row[9:12] @ row[:3]), -1e-9), 0.0)
        reached = rays / np.maximum(inverse, 1e-9)[..., None] - row[:3]
        right, down = reached @ row[3:6], reached @ row[6:9]
        inside = (right >= 0) & (right <= row[12]) & (down >= 0) & (down <= row[13])
        on_lattice = np.where(inside & (inverse > on_lattice), inverse, on_lattice)
    wide, high = np.arange(camera.width_px), np.arange(camera.height_px)
    across = np.interp(wide, columns, np.arange(len(columns))).astype(np.float32)
    along = np.interp(high, rows, np.arange(len(rows))).astype(np.float32)
    of_panels = cv2.remap(
        on_lattice.astype(np.float32), *np.meshgrid(across, along), cv2.INTER_LINEAR
    )
    triangles = _triangles(view, scene)
    of_mesh = np.zeros((camera.height_px, camera.width_px), np.float32)
    face = np.full(of_mesh.shape, -1, np.int32)
    rasterise(of_mesh, face, 0, 0, 1, triangles.screen, triangles.points, triangles.faces)
    return np.where(of_mesh > 0, of_mesh, of_panels)


def silhouette(view: View, limb: Limb) -> Bool[np.ndarray, "h w"]:
    """Pixels whose centre shows the limb."""
    return _mesh_inverse_depth(view, limb.mesh) > 0


def seen(view: View, limb: Limb) -> Bool[np.ndarray, " n"]:
    """Which vertices a view sees: in the picture, not occluded, at under 75 degrees incidence."""
    inverse_depth = _mesh_inverse_depth(view, limb.mesh)
    points = view.camera_from_world.apply(limb.mesh.vertices_mm)
    xy = view.camera.project(points)
    inside = view.camera.contains(xy)
    normals = limb.normals @ view.camera_from_world.rotation.T
    facing = -(normals * points).sum(1) / np.linalg.norm(points, axis=1)
    at = np.where(inside[:, None], np.rint(xy), 0).astype(int)
    depth = 1 / np.maximum(inverse_depth[at[:, 1], at[:, 0]], 1e-9)
    return inside & (facing > _STEEPEST) & (points[:, 2] < depth + _OCCLUSION_MM)


def _mesh_inverse_depth(view: View, mesh: Mesh) -> Float32[np.ndarray, "h w"]:
    """1 / depth of the mesh at pixel centres, 0 where it is not."""
    points = view.camera_from_world.apply(mesh.vertices_mm)
    inverse_depth = np.zeros((view.camera.height_px, view.camera.width_px), np.float32)
    face = np.full(inverse_depth.shape, -1, np.int32)
    rasterise(inverse_depth, face, 0, 0, 1, view.camera.project(points), points, mesh.faces)
    return inverse_depth


def _triangles(view: View, scene: RenderScene, readout: Readout | None = None) -> Triangles:
    """Limb and stand in the camera frame; no triangles without them."""
    meshes = [part for part in (scene.limb and scene.limb.mesh, scene.stand) if part]
    points = np.concatenate([np.zeros((0, 3)), *(mesh.vertices_mm for mesh in meshes)])
    normals = np.zeros((0, 3)) if scene.limb is None else scene.limb.normals
    if scene.stand is not None:
        normals = np.concatenate([normals, scene.stand.vertex_normals()])
    starts = np.cumsum([0, *(len(mesh.vertices_mm) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    camera_from_limb = view.camera_from_world @ scene.room_from_limb
    points = camera_from_limb.apply(points)
    if readout is not None:
        points = _read_by_rows(points, view, readout)
    limb_faces = len(faces[0]) if scene.limb is not None else 0
    chart = np.zeros((0, 3, 2), np.float32) if scene.limb is None else scene.limb.chart
    skin = np.zeros((2, 2, 4), np.uint8) if scene.skin is None else scene.skin
    fine = 1 if scene.limb is None else (len(skin) - 1) // (len(scene.limb.grid_mm) - 1)
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
    """Points in the camera frame of the row that reads each, by fixed-point iteration."""
    in_camera = points
    for _ in range(_ROW_STEPS):
        rows = view.camera.project(in_camera)[:, 1]
        in_camera = readout.at_rows(points, np.nan_to_num(rows))
    return in_camera


def _columns(triangles: Triangles, width_px: int) -> tuple[int, int]:
    """First and last pixel column that the mesh can touch."""
    if len(triangles.screen) == 0:
        return 0, 0
    low, high = triangles.screen[:, 0].min(), triangles.screen[:, 0].max()
    left = int(np.clip(np.floor(low) - 1, 0, width_px))
    return left, int(np.clip(np.ceil(high) + 2, left, width_px))


def _panels(panels: tuple[Panel, ...], camera_from_world: Rigid) -> Panels:
    """Panels in the camera frame, their textures concatenated."""
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


def _at_pose(panels: Panels, in_world: tuple[Panel, ...], camera_from_world: Rigid) -> Panels:
    """The same panels for another pose."""
    rows = _rows(in_world, camera_from_world)
    return panels._replace(rows=rows, bounds=_bounds(rows))


def _rows(panels: tuple[Panel, ...], camera_from_world: Rigid) -> Float64[np.ndarray, "panels 18"]:
    """The panels in the camera frame, as `Panels.rows` has them."""
    if not panels:
        return np.zeros((0, 18))
    rotation = camera_from_world.rotation
    right = np.array([panel.right for panel in panels]) @ rotation.T
    down = np.array([panel.down for panel in panels]) @ rotation.T
    origin = camera_from_world.apply(np.array([panel.origin for panel in panels]))
    sizes = np.array([panel.size_mm for panel in panels])
    prints = np.array([panel.print_from_panel for panel in panels])
    return np.concatenate([origin, right, down, np.cross(down, right), sizes, prints], axis=1)


def _bounds(rows: Float64[np.ndarray, "n 18"]) -> Float64[np.ndarray, "n 4"]:
    """Bounds of each panel in ideal coordinates; infinite if it reaches behind the camera."""
    across, along = rows[:, 12:13] * rows[:, 3:6], rows[:, 13:14] * rows[:, 6:9]
    corners = rows[:, None, :3] + np.stack([0 * across, along, across, across + along], axis=1)
    behind = corners[..., 2].min(axis=1, initial=np.inf) <= 1.0
    flat = corners[..., :2] / np.where(behind[:, None], 1.0, corners[..., 2])[..., None]
    low, high = flat.min(axis=1) - 1e-9, flat.max(axis=1) + 1e-9
    everywhere = np.array([-np.inf, -np.inf, np.inf, np.inf])
    return np.where(behind[:, None], everywhere, np.concatenate([low, high], axis=1))
