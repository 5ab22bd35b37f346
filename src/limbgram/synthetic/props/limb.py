"""The limb: a closed surface of known shape, standing with its distal end up.

In      a kind of limb, a seed, and a mesh step.
Out     a Limb: a grid of rings from the middle of the flat cut, over its rim and up the
        skin to the distal pole. The triangles of this grid are both the truth and what is rendered.
Method  A profile of radii turned about a bent axis, with non-circular sections, Gaussian bumps for
        bone and muscle along the normals, then fine relief of random plane waves. An optional fin
        is a thin upright ridge on the limb's side, as an ear or the blade of a bone; it is raised
        out of the skin, so that the surface stays closed, and columns are denser on its flanks.
Frame   world: z up from the table, millimetres; the axis starts at (0, 0, base_mm).
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final, Literal

import numpy as np
from jaxtyping import Bool, Float32, Float64
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from limbgram.core.geometry.arrays import Faces, Points3, Vector3
from limbgram.core.geometry.frames import turn_rad
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic.props.details import PLAIN, RingGrid, SkinDetails, details_mm

_FIN_HEIGHT_MM = 12.0
"""Height of the fin above the skin."""
_FIN_LENGTH_MM = 60.0
_FIN_MIDDLE = 0.45
"""Its middle, as a fraction of the limb's height."""
_FIN_ANGLE = np.radians(-40.0)
_FINE = 20_000
"""Samples round a section, from which columns are placed."""


def _fin_height_mm(
    angles: NDArray[np.float64],
    height: NDArray[np.float64],
    radius_mm: NDArray[np.float64],
    limb_mm: float,
    thickness_mm: float,
) -> Float64[np.ndarray, "n c"]:
    """Height of the fin above the skin; at half of it the fin has `thickness_mm`."""
    aside = turn_rad(angles, _FIN_ANGLE) * radius_mm
    along = 1 / (1 + np.abs((height - _FIN_MIDDLE * limb_mm) / (_FIN_LENGTH_MM / 2)) ** 6)
    return _FIN_HEIGHT_MM * along / (1 + np.abs(aside / (thickness_mm / 2)) ** 8)


def _column_angles(radius_mm: float, step_mm: float, thickness_mm: float) -> NDArray[np.float64]:
    """Angles of the columns, at equal arc length on the section through the fin's middle."""
    if thickness_mm == 0:
        count = round(2 * np.pi * radius_mm / step_mm)
        return 2 * np.pi * np.arange(count) / count
    angles = np.linspace(0, 2 * np.pi, _FINE + 1)
    at = np.array([[_FIN_MIDDLE]])
    rise = _fin_height_mm(angles, at, np.array([[radius_mm]]), 1.0, thickness_mm)[0]
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(angles) * radius_mm, np.diff(rise)))])
    count = round(length[-1] / step_mm)
    return np.interp(length[-1] * np.arange(count) / count, length, angles)


_CUT_RING_MM = 3.0
_WAVES = 48
_COARSEST_MM = 40.0
"""Longest wavelength of the relief."""


@dataclass(frozen=True, kw_only=True)
class Relief:
    """Fine relief of skin and knit: a sum of random plane waves."""

    rms_mm: float = 0.2
    """RMS height; 0 for a smooth limb."""
    finest_mm: float = 5.0
    """Shortest wavelength."""
    growth: float = 0.7
    """Exponent of amplitude over wavelength: 0 for equal amplitudes, as of wrinkles, 0.7 for skin,
    more for smoother skin."""


class LimbKind(Enum):
    """Which limb; each has its own bones and proportions."""

    TRANSTIBIAL = "transtibial"
    TRANSFEMORAL = "transfemoral"
    BULBOUS = "bulbous"


@dataclass(frozen=True)
class _Bump:
    """A Gaussian hill (or hollow) on the skin, `angle_deg` from anterior towards lateral."""

    angle_deg: float
    height: float
    """Fraction of the limb's height, 0 at the cut and 1 at the distal end."""
    rise_mm: float
    around_mm: float
    along_mm: float


@dataclass(frozen=True)
class _Proportions:
    """Proportions of one kind of limb."""

    height_mm: float
    heights: tuple[float, ...]
    """Fractions of the height at which `radii_mm` are given."""
    radii_mm: tuple[float, ...]
    dome: float
    """Fraction of the height taken by the rounded distal end."""
    oval: float
    """Relative amplitude of the section's second harmonic."""
    triangle: float
    """Relative amplitude of its third harmonic."""
    bumps: tuple[_Bump, ...]


_PROPORTIONS = {
    LimbKind.TRANSTIBIAL: _Proportions(
        270.0,
        (0.0, 0.25, 0.5, 0.75, 1.0),
        (57.0, 54.0, 51.0, 44.0, 36.0),
        0.18,
        0.045,
        0.035,
        (
            _Bump(0, 0.19, 8.5, 17, 20),  # patella
            _Bump(0, 0.33, -3.0, 10, 11),  # patellar tendon
            _Bump(0, 0.41, 4.5, 9, 12),  # tibial tuberosity
            _Bump(-6, 0.53, 3.2, 7, 22),  # tibial crest, in three parts
            _Bump(-9, 0.67, 3.2, 7, 22),
            _Bump(-8, 0.81, 3.4, 8, 18),
            _Bump(105, 0.37, 6.0, 10, 12),  # head of the fibula
            _Bump(85, 0.87, 2.5, 9, 10),  # cut end of the fibula
            _Bump(-65, 0.35, 4.0, 20, 16),  # medial flare
            _Bump(180, 0.26, -7.0, 26, 24),  # back of the knee
            _Bump(175, 0.55, 8.0, 38, 42),  # calf
        ),
    ),
    LimbKind.TRANSFEMORAL: _Proportions(
        250.0,
        (0.0, 0.25, 0.5, 0.75, 1.0),
        (78.0, 73.0, 66.0, 57.0, 47.0),
        0.24,
        0.07,
        0.02,
        (
            _Bump(95, 0.5, -6.0, 30, 55),  # flat of the lateral wall
            _Bump(100, 0.88, 4.5, 13, 13),  # cut end of the femur
            _Bump(-80, 0.12, 8.0, 28, 14),  # adductor roll
            _Bump(-80, 0.24, -4.0, 30, 8),
            _Bump(20, 0.45, 5.0, 28, 45),  # rectus femoris
            _Bump(165, 0.4, 6.0, 34, 40),  # hamstrings
        ),
    ),
    LimbKind.BULBOUS: _Proportions(
        230.0,
        (0.0, 0.25, 0.5, 0.75, 1.0),
        (52.0, 48.0, 45.0, 51.0, 50.0),
        0.30,
        0.05,
        0.03,
        (
            _Bump(0, 0.2, 7.0, 16, 18),
            _Bump(-5, 0.5, 3.5, 8, 30),
            _Bump(100, 0.38, 5.0, 10, 11),
            _Bump(180, 0.28, -5.0, 24, 20),
            _Bump(150, 0.85, 5.0, 18, 16),  # soft tissue that hangs over
            _Bump(-100, 0.8, 4.0, 16, 14),
        ),
    ),
}


@dataclass(frozen=True, kw_only=True)
class Limb:
    """The true surface, closed, and its chart: the grid of rings that textures lie on."""

    mesh: Mesh
    normals: Points3
    """Outward unit normals of the vertices, for shading."""
    cut: Bool[np.ndarray, " n"]
    """Vertices inside the flat cut; those of the rim belong to the skin."""
    grid_mm: Float32[np.ndarray, "rows columns 3"]
    """The same vertices as a chart: rows from cut to pole; the last column repeats the first."""
    chart: Float32[np.ndarray, "f 3 2"]
    """Column and row of each face's corners in the chart."""
    base_mm: float
    """Height of the cut above the table."""
    height_mm: float
    side: Literal["left", "right"]
    """Of the patient."""
    anterior_rad: float
    """Azimuth of the anterior direction in the world."""

    def place_mm(self, angle_deg: float, share: float) -> Vector3:
        """The vertex near an angle from anterior towards lateral and a share of the height.

        A degree counts as much as a millimetre, which it is about at the radius of a limb.
        """
        points = self.mesh.vertices_mm
        towards = 1.0 if self.side == "right" else -1.0
        angles = np.arctan2(points[:, 1], points[:, 0]) - self.anterior_rad
        off_deg = np.abs((np.degrees(towards * angles) - angle_deg + 180) % 360 - 180)
        height_mm = self.base_mm + share * self.height_mm
        return points[np.argmin(off_deg + np.abs(points[:, 2] - height_mm))]


TRANSTIBIAL_PLACES: Final = {
    "patellar tendon": (0.0, 0.33),
    "tibial tubercle": (0.0, 0.43),
    "fibula head": (105.0, 0.38),
    "popliteal crease": (180.0, 0.27),
    "tibia end": (0.0, 0.87),
}
"""Arguments of `Limb.place_mm` for the landmarks of a transtibial limb."""
_RELIEF = Relief()


def make_limb(
    kind: LimbKind,
    seed: int,
    step_mm: float,
    base_mm: float,
    fin_mm: float = 0.0,
    relief: Relief = _RELIEF,
    details: SkinDetails = PLAIN,
) -> Limb:
    """Build a limb, with a fin of this thickness; one seed gives one person, left or right."""
    rng = np.random.default_rng((seed, 1))
    plan = _PROPORTIONS[kind]
    size = rng.uniform(0.94, 1.06)
    side = rng.choice([-1.0, 1.0])
    yaw = rng.uniform(0, 2 * np.pi)
    height = plan.height_mm * size * rng.uniform(0.95, 1.03)
    profile = _profile(plan, size, height, step_mm, rng)
    columns = _column_angles(profile[:, 0].max(), step_mm, fin_mm)
    angles = yaw + np.sort(side * columns % (2 * np.pi))
    skin = _skin(plan, profile, side * (angles - yaw), height, rng, fin_mm)
    directions = np.stack([np.cos(angles), np.sin(angles)], -1)
    bend = rng.uniform(-8, 8, 2) * (skin[..., 2:] / height) ** 2
    skin = np.concatenate([skin[..., :1] * directions + bend, skin[..., 2:]], -1)
    skin = with_relief(skin, relief, rng)
    body_side = "right" if side > 0 else "left"
    return limb_of_skin(skin, details, seed, base_mm, body_side, float(yaw))


def limb_of_skin(
    skin: RingGrid,
    details: SkinDetails,
    seed: int,
    base_mm: float,
    side: Literal["left", "right"],
    anterior_rad: float,
) -> Limb:
    """Close a skin to a limb, with details along its normals, its rim level at `base_mm`."""
    if details.any:
        skin = _with_details(skin, details, seed)
    skin[0, :, 2] = 0.0
    skin[-1] = skin[-1].mean(0)
    skin[..., 2] += base_mm
    grid = np.concatenate([cut_rings(skin[0]), skin])
    return limb_of_grid(grid, len(grid) - len(skin), base_mm, side, anterior_rad)


def with_relief(skin: RingGrid, relief: Relief, rng: np.random.Generator) -> RingGrid:
    """The skin, rows from its rim to its pole, with the fine relief along its normals."""
    return skin + _normals(skin) * _relief_mm(skin, relief, rng)[..., None]


def _with_details(skin: RingGrid, details: SkinDetails, seed: int) -> RingGrid:
    """The skin with knit, veins, scars and wrinkles along its normals."""
    return skin + _normals(skin) * details_mm(skin, details, seed)[..., None]


def _profile(
    plan: _Proportions, size: float, height_mm: float, step_mm: float, rng: np.random.Generator
) -> Float64[np.ndarray, "n 2"]:
    """Radius and height along the skin, at equal steps from the cut to the pole."""
    radii = np.array(plan.radii_mm) * size * rng.uniform(0.96, 1.04, len(plan.radii_mm))
    radius = PchipInterpolator(np.array(plan.heights) * height_mm, radii)
    shoulder = height_mm * (1 - plan.dome)
    straight = np.linspace(0, shoulder, 2000)[:-1]
    angle = np.linspace(0, np.pi / 2, 2000)
    dome = shoulder + (height_mm - shoulder) * np.sin(angle)
    heights = np.concatenate([straight, dome])
    r = radius(heights) * np.concatenate([np.ones(len(straight)), np.cos(angle)])
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(r), np.diff(heights)))])
    at = np.linspace(0, length[-1], round(length[-1] / step_mm) + 1)
    even = np.column_stack([np.interp(at, length, r), np.interp(at, length, heights)])
    even[-1] = 0.0, height_mm
    return even


def _skin(
    plan: _Proportions,
    profile: Float64[np.ndarray, "n 2"],
    angles: Float64[np.ndarray, " c"],
    height_mm: float,
    rng: np.random.Generator,
    fin_mm: float,
) -> RingGrid:
    """Radius, 0 and height of every grid point; `angles` are from anterior towards lateral."""
    radius, height = profile[:, :1], profile[:, 1:]
    fade = np.clip(radius / radius.max(), 0, 1)
    phase = rng.uniform(-0.2, 0.2, 2)
    section = 1 + fade * (
        plan.oval * np.cos(2 * (angles + phase[0]))
        + plan.triangle * np.cos(3 * (angles + phase[1]))
    )
    slope = np.gradient(profile[:, 0]), np.gradient(profile[:, 1])
    outward = np.stack([slope[1], -slope[0]], -1) / np.hypot(*slope)[:, None]
    rise = np.zeros((len(profile), len(angles)))
    for bump in plan.bumps:
        centre = np.radians(bump.angle_deg + rng.uniform(-6, 6))
        at = (bump.height + rng.uniform(-0.02, 0.02)) * height_mm
        around = turn_rad(angles, centre) * radius / bump.around_mm
        along = (height - at) / bump.along_mm
        rise += bump.rise_mm * rng.uniform(0.8, 1.2) * np.exp(-0.5 * (around**2 + along**2))
    rise += _scar_mm(radius * np.cos(angles), height, height_mm)
    if fin_mm > 0:
        rise += _fin_height_mm(angles, height, radius, height_mm, fin_mm)
    rise[-1] = rise[-2].mean()
    r = radius * section + rise * outward[:, :1]
    z = height + rise * outward[:, 1:]
    return np.stack([r, np.zeros_like(r), z], -1)


def _scar_mm(
    forward_mm: np.ndarray, height: np.ndarray, height_mm: float
) -> Float64[np.ndarray, "n c"]:
    """Surgical scar: a groove across the distal end, a little behind the middle."""
    on_end = 1 / (1 + np.exp(-(height - 0.86 * height_mm) / 4.0))
    return -1.3 * on_end * np.exp(-0.5 * ((forward_mm + 6.0) / 2.6) ** 2)


def _relief_mm(
    points: RingGrid, options: Relief, rng: np.random.Generator
) -> Float64[np.ndarray, "n c"]:
    """Height of every point above the smooth skin."""
    lengths = np.geomspace(options.finest_mm, _COARSEST_MM, _WAVES)
    directions = rng.normal(size=(_WAVES, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    phases = rng.uniform(0, 2 * np.pi, _WAVES)
    weights = lengths**options.growth
    weights *= options.rms_mm * np.sqrt(2) / np.linalg.norm(weights)
    relief = np.zeros(points.shape[:-1])
    for length, direction, phase, weight in zip(lengths, directions, phases, weights, strict=True):
        relief += weight * np.sin(points @ (direction * 2 * np.pi / length) + phase)
    return relief


def _normals(grid: RingGrid) -> RingGrid:
    """Outward unit normals of a grid whose rows are closed."""
    around = np.roll(grid, -1, 1) - np.roll(grid, 1, 1)
    along = np.gradient(grid, axis=0)
    normals = np.cross(around, along)
    normals[-1] = [0.0, 0.0, 1.0]
    return normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)


def cut_rings(rim: Points3) -> Float64[np.ndarray, "rings n 3"]:
    """Concentric rings of the flat cut, from its middle to just inside the rim."""
    middle = rim.mean(0)
    widest = np.linalg.norm(rim - middle, axis=1).max()
    shares = np.linspace(0, 1, round(widest / _CUT_RING_MM) + 1)[:-1]
    return middle + shares[:, None, None] * (rim - middle)


def limb_of_grid(
    grid: RingGrid,
    cut_rows: int,
    base_mm: float,
    side: Literal["left", "right"],
    anterior_rad: float,
) -> Limb:
    """Triangulate rings to a closed mesh; the first and the last row are single vertices."""
    rows, columns = grid.shape[:2]
    vertices = np.concatenate([grid[:1, 0], grid[1:-1].reshape(-1, 3), grid[-1:, 0]])
    ids = np.arange((rows - 2) * columns).reshape(rows - 2, columns) + 1
    first = np.zeros((1, columns), int)
    last = np.full((1, columns), len(vertices) - 1)
    ids = np.concatenate([first, ids, last])
    ids = np.concatenate([ids, ids[:, :1]], 1)
    a, b, c, d = ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]
    column, row = np.meshgrid(np.arange(columns), np.arange(rows - 1))
    lower = np.stack([a, b, c], -1), ((0, 0), (1, 0), (1, 1))
    upper = np.stack([a, c, d], -1), ((0, 0), (1, 1), (0, 1))
    faces, chart = [], []
    for (corners, steps), whole in ((lower, slice(1, None)), (upper, slice(None, -1))):
        at = np.stack([np.stack([column + i, row + j], -1) for i, j in steps], -2)
        faces.append(corners[whole].reshape(-1, 3))
        chart.append(at[whole].reshape(-1, 3, 2))
    closed = np.concatenate([grid, grid[:, :1]], 1)
    skin: Faces = np.concatenate(faces).astype(np.int32)
    cut = np.zeros(len(vertices), bool)
    cut[: 1 + (cut_rows - 1) * columns] = True
    mesh = Mesh(vertices_mm=vertices.astype(np.float32).astype(float), faces=skin)
    return Limb(
        mesh=mesh,
        normals=mesh.vertex_normals(),
        cut=cut,
        grid_mm=closed.astype(np.float32),
        chart=np.concatenate(chart).astype(np.float32),
        base_mm=base_mm,
        height_mm=float(vertices[:, 2].max() - base_mm),
        side=side,
        anterior_rad=anterior_rad,
    )
