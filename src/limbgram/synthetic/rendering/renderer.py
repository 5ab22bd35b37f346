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

import numpy as np
from jaxtyping import Bool, Float32, Float64, UInt8

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic.props.board import CALIBRATION_BOARD, PrintedBoard
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.room import MARGIN_MM, Panel
from limbgram.synthetic.rendering.casting import rasterise, shade
from limbgram.synthetic.rendering.shading import Light, Panels, Triangles

SAMPLES = 4
_BUFFER_SAMPLES = 4_000_000
_STEEPEST = np.cos(np.radians(75.0))
_OCCLUSION_MM = 2.0

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


def render(view: View, stage: Stage, light: Light, samples: int = SAMPLES) -> LinearPicture:
    """What the camera sees in this light, which is in its frame; `samples` along a pixel's side."""
    camera = view.camera
    picture = np.zeros((camera.height_px, camera.width_px, 3), np.float32)
    panels = _panels(stage.panels, view.camera_from_world)
    triangles = _triangles(view, stage)
    left, right = _columns(triangles, camera.width_px)
    step = max(1, _BUFFER_SAMPLES // (samples**2 * max(1, right - left)))
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
        shade(rows, top, samples, left, nearness, face, camera.packed, panels, triangles, light)
    return picture


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


def _triangles(view: View, stage: Stage) -> Triangles:
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


def _columns(triangles: Triangles, width_px: int) -> tuple[int, int]:
    """First and last pixel column that the mesh can touch."""
    if len(triangles.screen) == 0:
        return 0, 0
    low, high = triangles.screen[:, 0].min(), triangles.screen[:, 0].max()
    left = int(np.clip(np.floor(low) - 1, 0, width_px))
    return left, int(np.clip(np.ceil(high) + 2, left, width_px))


def _panels(panels: tuple[Panel, ...], camera_from_world: Rigid) -> Panels:
    """Panels in the camera frame, their textures one after the other."""
    turn = camera_from_world.rotation
    rows, bounds, kinds = [], [], []
    texels = [np.zeros((0, 3), np.uint8)]
    board = CALIBRATION_BOARD
    first = 0
    for panel in panels:
        right, down = turn @ panel.right, turn @ panel.down
        origin = camera_from_world.apply(panel.origin)
        rows.append(np.concatenate([origin, right, down, np.cross(down, right), panel.size_mm]))
        bounds.append(_bounds(rows[-1]))
        if isinstance(panel.picture, PrintedBoard):
            board = panel.picture
            kinds.append((0, 0, 0))
            continue
        kinds.append((first, *panel.picture.shape[:2]))
        texels.append(panel.picture.reshape(-1, 3))
        first += len(texels[-1])
    return Panels(
        rows=np.array(rows),
        bounds=np.array(bounds),
        kinds=np.array(kinds, np.int64),
        texels=np.concatenate(texels),
        cells=board.board.cells(),
        square_mm=board.square_mm,
        marker_mm=board.marker_mm,
        margin_mm=MARGIN_MM,
    )


def _bounds(row: Float64[np.ndarray, "14"]) -> Float64[np.ndarray, "4"]:
    """Where a panel can appear on the ideal plane; everywhere if it reaches behind the camera."""
    corners = row[:3] + np.array(
        [i * row[12] * row[3:6] + j * row[13] * row[6:9] for i in (0, 1) for j in (0, 1)]
    )
    if corners[:, 2].min() <= 1.0:
        return np.array([-np.inf, -np.inf, np.inf, np.inf])
    flat = corners[:, :2] / corners[:, 2:]
    return np.concatenate([flat.min(0), flat.max(0)]) + np.array([-1e-9, -1e-9, 1e-9, 1e-9])
