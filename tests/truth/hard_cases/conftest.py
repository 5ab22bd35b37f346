"""A limb photographed close by from one side, with true cameras, under lights that mislead."""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.reconstruction.mapping.scene import Observations, Scene
from limbgram.reconstruction.measuring.measurement import MeasureOptions, measure
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.scale.metric import MetricScene, Scale
from limbgram.reconstruction.surface.brim import BrimOptions
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.synthetic.photographer import Lens, camera_of
from limbgram.synthetic.props.limb import Limb, LimbKind, make_limb
from limbgram.synthetic.props.paint import Paint, Painting, bake
from limbgram.synthetic.props.room import make_room
from limbgram.synthetic.rendering.developing import developed, softened
from limbgram.synthetic.rendering.renderer import RenderScene, render
from limbgram.synthetic.rendering.shading import Lighting, light_of, shadow_edge

SEED, BASE_MM, DISTANCE_MM = 11, 60.0, 900.0
STEP_MM, EDGE_MM, TEXEL_MM = 1.2, 1.5, 0.25
START_ERROR_MM = 0.3
FIN_MM = 4.0
WHOLE = camera_of(Lens(), 864, 576, DISTANCE_MM)
CAMERA = Camera(
    width_px=400, height_px=300, fx=WHOLE.fx, fy=WHOLE.fy, cx=203.0, cy=146.0, k1=-0.08, k2=0.05
)
PIXEL_MM = DISTANCE_MM / WHOLE.fx
ROOM = make_room(SEED, under_stand=True)
FACE_POINTS = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2]]) / 6
WITHOUT_NOTCHES = MeasureOptions(brim=BrimOptions(most_share=0.0))
"""The pieces measured here have no level brim to be closed."""


@cache
def limb_of(fin_mm: float) -> Limb:
    return make_limb(LimbKind.TRANSTIBIAL, SEED, STEP_MM, BASE_MM, fin_mm)


@cache
def skin_of(fin_mm: float) -> np.ndarray:
    return bake(limb_of(fin_mm), Painting(Paint.DABS, 0.55), SEED, TEXEL_MM)


@cache
def fin_tip() -> np.ndarray:
    """Where the limb with a fin stands out furthest from the limb without."""
    points = limb_of(FIN_MM).mesh.vertices_mm
    return points[np.argmax(tree_of(0.0).closest(points).distances_mm)]


@cache
def tree_of(fin_mm: float) -> TriangleTree:
    mesh = limb_of(fin_mm).mesh
    return TriangleTree.of(mesh.vertices_mm, mesh.faces)


def axes_at(height_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A point of the axis, and the horizontal directions of the fin and across it."""
    middle = np.array([0.0, 0.0, height_mm])
    out = fin_tip() * np.array([1.0, 1.0, 0.0])
    out /= np.linalg.norm(out)
    return middle, out, np.cross([0.0, 0.0, 1.0], out)


def views_at(height_mm: float) -> tuple[View, ...]:
    """Seven photos on an arc of 150 degrees, low and high in turn."""
    rng = np.random.default_rng(SEED)
    middle, out, across = axes_at(height_mm)
    views: list[View] = []
    for k, azimuth_deg in enumerate(np.linspace(-75, 75, 7)):
        turn = np.radians(azimuth_deg + rng.uniform(-4, 4))
        rise = np.radians((4, 28)[k % 2] + rng.uniform(-4, 4))
        away = np.cos(rise) * (np.cos(turn) * out + np.sin(turn) * across)
        away[2] = np.sin(rise)
        target = middle + rng.uniform(-5, 5, 3)
        centre = target + DISTANCE_MM * rng.uniform(0.95, 1.05) * away
        pose = Rigid.looking_at(centre, target, np.array([0.0, 0.0, 1.0]))
        views.append(View(f"photo{k}.png", CAMERA, pose))
    return tuple(views)


@dataclass(frozen=True)
class Shots:
    """Photos on disk, their true views, and the limb that is in them."""

    folder: Path
    views: tuple[View, ...]
    fin_mm: float

    def grey(self) -> list[np.ndarray]:
        return [cv2.imread(str(self.folder / view.name), 0).astype(float) for view in self.views]

    def sees(self, points_mm: np.ndarray, normals: np.ndarray, most_deg: float) -> np.ndarray:
        """By view, which points it sees less obliquely than this, hidden or not."""
        rays = np.stack([view.centre_in_world for view in self.views])[:, None] - points_mm
        cosines = (rays * normals).sum(-1) / np.linalg.norm(rays, axis=-1)
        return cosines > np.cos(np.radians(most_deg))

    def metric(self) -> MetricScene:
        none = np.zeros(0, np.int32)
        scene = Scene(
            names=tuple(view.name for view in self.views),
            cameras=(CAMERA,),
            camera_idx=(0,) * len(self.views),
            camera_from_world=tuple(view.camera_from_world for view in self.views),
            points_in_world=np.zeros((0, 3)),
            observations=Observations(none, none, np.zeros((0, 2))),
            verdicts=(),
        )
        return MetricScene(scene=scene, scale=Scale(unit="mm", source="board", relative_sigma=0.0))


@dataclass(frozen=True)
class Measured:
    """A measured surface beside the truth."""

    shots: Shots
    mesh: Mesh

    def samples(self) -> np.ndarray:
        """Points on the faces of measured vertices."""
        assert self.mesh.filled is not None
        faces = self.mesh.faces[~self.mesh.filled[self.mesh.faces].any(1)]
        return np.einsum("sk,fkj->fsj", FACE_POINTS, self.mesh.vertices_mm[faces]).reshape(-1, 3)

    def normals(self, points_mm: np.ndarray) -> np.ndarray:
        """Of the truth beside points."""
        normals = limb_of(self.shots.fin_mm).mesh.face_normals()
        normals = normals[tree_of(self.shots.fin_mm).closest(points_mm).faces]
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def errors_mm(self, points_mm: np.ndarray) -> np.ndarray:
        """Distance to the truth, positive outside."""
        near = tree_of(self.shots.fin_mm).closest(points_mm)
        normals = limb_of(self.shots.fin_mm).mesh.face_normals()[near.faces]
        return near.distances_mm * np.sign(((points_mm - near.points_mm) * normals).sum(1))


def photograph(folder: Path, lighting: Lighting, height_mm: float, fin_mm: float = 0.0) -> Shots:
    folder.mkdir()
    shots = Shots(folder, views_at(height_mm), fin_mm)
    stage = RenderScene(ROOM, limb_of(fin_mm), None, skin_of(fin_mm))
    middle, out, _ = axes_at(height_mm)
    for k, view in enumerate(shots.views):
        edge = shadow_edge(lighting, middle + 50 * out, SEED, k)
        light = light_of(lighting, view.camera_from_world, DISTANCE_MM, edge)
        picture = softened(render(view, stage, light), 0.5)
        pixels = developed(picture, 1.0, np.random.default_rng((SEED, k)))
        cv2.imwrite(str(folder / view.name), pixels[..., ::-1])
    return shots


def start_mesh(fin_mm: float, low_mm: float, high_mm: float) -> Mesh:
    """The side of the true limb that is photographed, with smooth noise along its normals."""
    limb = limb_of(fin_mm)
    _, out, across = axes_at(0.0)
    points = limb.mesh.vertices_mm
    facing = points @ out > 0.4 * np.abs(points @ across)
    keep = facing & ~limb.cut & (points[:, 2] >= low_mm) & (points[:, 2] < high_mm)
    part = with_faces(limb.mesh, limb.mesh.faces[keep[limb.mesh.faces].all(1)])
    mesh = refine(part, EDGE_MM)
    rng = np.random.default_rng(5)
    waves = rng.normal(size=(30, 3)) * 2 * np.pi / rng.uniform(8, 25, (30, 1)) / np.sqrt(3)
    noise = np.sin(mesh.vertices_mm @ waves.T + rng.uniform(0, 6.28, 30)).sum(1)
    noise *= START_ERROR_MM / noise.std()
    return mesh.with_vertices(mesh.vertices_mm + noise[:, None] * mesh.vertex_normals())


def measured(shots: Shots, start: Mesh) -> Measured:
    photos = read_photos([shots.folder / view.name for view in shots.views])
    return Measured(shots, measure(photos, shots.metric(), start, WITHOUT_NOTCHES))


class Bench:
    """What the tests ask for, with the clean capture kept."""

    pixel_mm = PIXEL_MM
    seed = SEED

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.height_mm = float(fin_tip()[2])
        self.axes = axes_at(self.height_mm)

    @cached_property
    def clean(self) -> Measured:
        return self.lit("clean", Lighting())

    def start(self, fin_mm: float = 0.0) -> Mesh:
        return start_mesh(fin_mm, self.height_mm - 50, self.height_mm + 50)

    def lit(self, name: str, lighting: Lighting) -> Measured:
        shots = photograph(self.folder / name, lighting, self.height_mm)
        return measured(shots, self.start())

    @cached_property
    def shots_of_fin(self) -> Shots:
        return photograph(self.folder / "fin", Lighting(), self.height_mm, FIN_MM)

    def fin(self, chosen: slice = slice(None)) -> Measured:
        """The limb with a fin, measured in some of its photos."""
        shots = replace(self.shots_of_fin, views=self.shots_of_fin.views[chosen])
        return measured(shots, self.start(FIN_MM))

    def at_brim(self) -> Measured:
        shots = photograph(self.folder / "brim", Lighting(), BASE_MM + 35.0)
        return measured(shots, start_mesh(0.0, 0.0, BASE_MM + 70.0))

    def above_skin_mm(self, points_mm: np.ndarray) -> np.ndarray:
        """How far points are from the limb without a fin."""
        return tree_of(0.0).closest(points_mm).distances_mm

    @property
    def truth_with_fin(self) -> Mesh:
        return limb_of(FIN_MM).mesh


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return Bench(tmp_path_factory.mktemp("hard"))
