"""Bodies of known form: a foot with its shank, cone limbs and a trunk, aligned, with landmarks.

Each is the level of a smooth function, so that every place on it can be told.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.spatial import KDTree

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.isosurface import level_surface
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.surface.remeshing import refine
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.limb import AlignedLimb, Kind, Landmark, Limb, LimbFrame, Side

Field = Callable[[np.ndarray], np.ndarray]


def ellipsoid(middle: tuple, sizes: tuple, power: float = 2.0) -> Field:
    """A superellipsoid; what it gives is about a distance."""
    least = min(sizes)

    def inside(p: np.ndarray) -> np.ndarray:
        share = (np.abs((p - np.array(middle)) / np.array(sizes)) ** power).sum(-1)
        return (share ** (1 / power) - 1) * least

    return inside


def cone(low: tuple, low_mm: float, high: tuple, high_mm: float, flat: float = 1.0) -> Field:
    """A straight limb with round ends; `flat` narrows it from front to back."""

    def inside(p: np.ndarray) -> np.ndarray:
        a, b = np.array(low, float), np.array(high, float)
        at = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
        off = (p - a - at[..., None] * (b - a)) * np.array([1, 1 / flat, 1])
        return np.linalg.norm(off, axis=-1) - (low_mm + at * (high_mm - low_mm))

    return inside


def together(fields: list[Field], blend_mm: float) -> Field:
    def inside(p: np.ndarray) -> np.ndarray:
        values = np.stack([one(p) for one in fields])
        return -blend_mm * np.log(np.exp(-values / blend_mm).sum(0))

    return inside


def surface(field: Field, low: tuple, high: tuple, cell_mm: float, top_mm: float | None) -> Mesh:
    counts = np.ceil((np.array(high) - np.array(low)) / cell_mm).astype(int) + 1
    grid = np.array(low) + cell_mm * np.moveaxis(np.indices(counts), 0, -1)
    values = -field(grid)
    for axis in range(3):
        for end in (0, -1):
            values[tuple(end if k == axis else slice(None) for k in range(3))] = -1.0
    whole = refine(level_surface(values, np.array(low, float), cell_mm), 0.8 * cell_mm)
    whole = whole.with_vertices(settled(field, whole.vertices_mm))
    return whole if top_mm is None else keep_positive(whole, top_mm - whole.vertices_mm[:, 2]).mesh


def settled(field: Field, places: np.ndarray) -> np.ndarray:
    """Places on the level itself, by Newton's method."""
    for _ in range(5):
        steps = 1e-4 * np.eye(3)
        slope = np.stack([(field(places + d) - field(places - d)) / 2e-4 for d in steps], axis=1)
        steep = np.maximum((slope**2).sum(1), 0.05)
        places = places - np.clip(field(places) / steep, -1, 1)[:, None] * slope
    return places


def limb_of(mesh: Mesh, places: dict[str, tuple], kind: Kind | None, side: Side) -> Limb:
    """With landmarks at the vertices nearest to the places; a left one is the right one mirrored.

    Its mesh lies elsewhere than its limb frame.
    """
    marks = {
        name: mesh.vertices_mm[KDTree(mesh.vertices_mm).query(at)[1]] for name, at in places.items()
    }
    if side == "left":
        turn = np.array([-1.0, 1, 1])
        mesh = Mesh(vertices_mm=mesh.vertices_mm * turn, faces=mesh.faces[:, ::-1].copy())
        marks = {name: at * turn for name, at in marks.items()}
    motion = Rigid.from_rotation_vector(np.array([0.2, -0.1, 0.4]), np.array([30.0, -7.0, 11.0]))
    back = motion.inverse
    return AlignedLimb(
        mesh=mesh.with_vertices(back.apply(mesh.vertices_mm)),
        frame=LimbFrame(limb_from_mesh=motion, side=side),
        kind=kind,
        landmarks=tuple(
            Landmark(name=name, position_mm=back.apply(at[None])[0]) for name, at in marks.items()
        ),
    )


FOOT_PLACES = {
    "lateral malleolus": (45, -14, 72),
    "medial malleolus": (-45, -4, 80),
    "fibula head": (60, -20, 330),
    "medial tibial condyle": (-60, 0, 335),
    "tibial tubercle": (0, 60, 320),
    "heel": (0, -65, 20),
    "navicular": (-45, 50, 45),
    "first metatarsal head": (-48, 115, 15),
    "fifth metatarsal head": (50, 95, 12),
    "fifth metatarsal base": (45, 35, 20),
    "second toe": (-5, 180, 14),
    "first toe": (-20, 180, 14),
}


def make_foot(side: Side = "right", size: float = 1.0) -> Limb:
    """A foot of superellipses with its shank: 240 mm long, open at 350 mm."""
    mesh = _foot_mesh()
    places = {name: tuple(size * np.array(at)) for name, at in FOOT_PLACES.items()}
    return limb_of(mesh.with_vertices(size * mesh.vertices_mm), places, "foot", side)


@cache
def _foot_mesh() -> Mesh:
    field = together(
        [
            cone((0, -8, 75), 34, (0, -8, 380), 56, 1.15),
            ellipsoid((0, -25, 32), (34, 42, 34), 2.3),
            ellipsoid((2, 60, 26), (44, 120, 28), 2.6),
            ellipsoid((0, 24, 55), (30, 50, 40), 2.2),
            ellipsoid((34, -14, 72), (11, 14, 16)),
            ellipsoid((-34, -4, 80), (11, 14, 16)),
        ],
        5.0,
    )
    return surface(field, (-90, -110, -30), (90, 220, 400), 6.0, 350.0)


STUMP_PLACES = {
    "mid patella": (0, 60, 195),
    "patellar tendon": (0, 58, 170),
    "tibial tubercle": (0, 57, 150),
    "fibula head": (58, -8, 155),
    "medial tibial condyle": (-60, 0, 165),
    "popliteal crease": (0, -58, 178),
    "tibia end": (0, 25, 15),
    "distal end": (0, 0, 0),
    "medial femoral epicondyle": (-60, 0, 205),
    "lateral femoral epicondyle": (60, 0, 205),
}


@cache
def make_stump(side: Side = "right", size: float = 1.0) -> Limb:
    """A right transtibial cone limb, open at 260 mm."""
    field = together([cone((0, 0, 45), 45, (0, 0, 330), 70, 0.9)], 1.0)
    mesh = surface(field, (-100, -100, -20), (100, 100, 300), 6.0, 260.0)
    places = {name: tuple(size * np.array(at)) for name, at in STUMP_PLACES.items()}
    return limb_of(mesh.with_vertices(size * mesh.vertices_mm), places, "transtibial", side)


THIGH_PLACES = {
    "anterior superior iliac spine": (30, 85, 330),
    "greater trochanter": (90, 0, 290),
    "ischial tuberosity": (-35, -80, 262),
    "adductor longus tendon": (-75, 40, 262),
    "perineum": (-90, 0, 258),
    "gluteal fold": (0, -85, 245),
    "distal end": (0, 0, 0),
}


@cache
def make_thigh(side: Side = "right", size: float = 1.0) -> Limb:
    """A right transfemoral cone limb, open at 380 mm."""
    field = together([cone((0, 0, 55), 55, (0, 0, 420), 100, 0.95)], 1.0)
    mesh = surface(field, (-130, -130, -20), (130, 130, 420), 8.0, 380.0)
    places = {name: tuple(size * np.array(at)) for name, at in THIGH_PLACES.items()}
    return limb_of(mesh.with_vertices(size * mesh.vertices_mm), places, "transfemoral", side)


TRUNK_PLACES = {
    "sternal notch": (0, 75, 430),
    "xiphoid": (0, 95, 300),
    "navel": (0, 95, 170),
    "right axilla": (150, 0, 400),
    "left axilla": (-150, 0, 400),
    "right waist": (130, 0, 190),
    "left waist": (-130, 0, 190),
    "right iliac spine": (100, 75, 90),
    "left iliac spine": (-100, 75, 90),
    "pubic symphysis": (0, 95, 20),
    "sacrum": (0, -95, 90),
    "coccyx": (0, -95, 30),
    "right trochanter": (165, 0, 30),
    "left trochanter": (-165, 0, 30),
    "seventh cervical vertebra": (0, -75, 450),
}


@cache
def make_trunk() -> Limb:
    """A trunk with a waist, open at both ends."""

    def field(p: np.ndarray) -> np.ndarray:
        z = p[..., 2]
        wide = 150 - 22 * np.exp(-(((z - 190) / 80) ** 2)) + 12 * np.exp(-(((z - 20) / 60) ** 2))
        share = (np.abs(p[..., 0] / wide) ** 2.4 + np.abs(p[..., 1] / (0.63 * wide)) ** 2.4) ** (
            1 / 2.4
        )
        return (share - 1) * 90

    mesh = surface(field, (-190, -130, -60), (190, 130, 500), 14.0, 470.0)
    mesh = keep_positive(mesh, mesh.vertices_mm[:, 2] + 30).mesh
    return limb_of(mesh, TRUNK_PLACES, "torso", "none")
