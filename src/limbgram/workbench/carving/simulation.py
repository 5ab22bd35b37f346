"""Simulation: what a program of moves leaves of the blank, and how that compares with the shape.

In      moves of X, A and the tool's tip, as a machine makes them from the written program.
Out     the carved radius at every place of a fine grid; gouge and what was left.
Method  every move is walked in steps of a fraction of a cell, all axes in proportion; the ball and
        its shank take away what they meet. It knows nothing of how the toolpath was planned.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.interval import weighted_quantile
from limbgram.core.kernels import njit
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.carving.radial_rays import cast_radii
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.carving.setup import Blank

_CELL_MM = 0.5
_CELLS_ROUND = 720
_STEP_MM = 0.3
"""Between two such places a ball of 6 mm leaves 0.002 mm that the machine would take."""


@dataclass(frozen=True, kw_only=True)
class Moves:
    """Straight moves of all axes; the first place is where the machine stands."""

    x_mm: Float64[np.ndarray, " k"]
    a_deg: Float64[np.ndarray, " k"]
    """Of the tool round the work, counter-clockwise seen from +X."""
    tip_mm: Float64[np.ndarray, " k"]
    """Radius of the tool's tip; negative beyond the axis."""
    rapid: Bool[np.ndarray, " k"]
    """Of the move that ends at this place."""
    minutes: float


@dataclass(frozen=True)
class Carved:
    """The carved blank, as radii by place and angle."""

    x_mm: Float64[np.ndarray, " m"]
    a_deg: Float64[np.ndarray, " n"]
    radii_mm: Float64[np.ndarray, "m n"]
    """Of the outside."""
    hollows_mm: Float64[np.ndarray, "m n"]
    """Nearest to the axis that the tool came from the side, under what still stood outside."""

    def surface(self) -> Mesh:
        """The surface of the carved blank, from its first place that has a radius."""
        order = np.argsort((-self.a_deg) % 360)
        standing = int(np.argmax((self.radii_mm > 0).any(1)))
        return RadiusMap(
            thetas_deg=((-self.a_deg) % 360)[order],
            z_mm=self.x_mm[standing:],
            radii_mm=self.radii_mm[standing:, order],
        ).surface()


@dataclass(frozen=True, kw_only=True)
class CarveCheck:
    """Differences of the carved surface from the shape, along the shape's normals."""

    gouge_mm: float
    """Deepest cut into the shape."""
    scallop_mm: float
    """Ridges: 95 % of the surface has less left on it."""
    left_mm: float
    """The most left anywhere: in hollows narrower than the tool, and undercuts."""
    left_share: float
    """Part of the surface with more than 0.2 mm left."""
    rapid_hits: int
    """Rapid moves inside the blank; there must be none."""
    minutes: float
    carved: Carved


def simulate(moves: Moves, blank: Blank, ball_mm: float) -> Carved:
    """Remove from a blank what a ball-end tool meets on its moves."""
    count = max(2, int(np.ceil(blank.length_mm / _CELL_MM)))
    x_mm = blank.from_mm + (np.arange(count) + 0.5) * blank.length_mm / count
    a_deg = 360.0 / _CELLS_ROUND * np.arange(_CELLS_ROUND)
    radii = np.full((count, _CELLS_ROUND), float(blank.radius_mm))
    hollows = np.full_like(radii, np.inf)
    _carve(
        moves.x_mm,
        np.radians(moves.a_deg),
        moves.tip_mm + ball_mm,
        moves.rapid,
        ball_mm,
        float(x_mm[0]),
        blank.length_mm / count,
        radii,
        hollows,
    )
    return Carved(x_mm, a_deg, radii, hollows)


def check_carving(moves: Moves, blank: Blank, ball_mm: float, mesh_in_limb: Mesh) -> CarveCheck:
    """Simulate carving, and compare the result with the shape."""
    carved = simulate(moves, blank, ball_mm)
    thetas = (-carved.a_deg) % 360
    order = np.argsort(thetas)
    cast = cast_radii(mesh_in_limb, thetas[order], carved.x_mm)
    back = np.argsort(order)
    wanted = cast.outermost_mm[:, back]
    there = wanted > 0
    signed = _left_mm(carved, wanted, cast.beneath_mm[:, back], mesh_in_limb)[there]
    area = wanted[there] / wanted[there].sum()
    left = np.maximum(signed, 0)
    return CarveCheck(
        gouge_mm=float(max(0.0, -signed.min())),
        scallop_mm=weighted_quantile(left, area, 0.95),
        left_mm=float(left.max()),
        left_share=float(area[left > 0.2].sum()),
        rapid_hits=_rapid_hits(moves, blank),
        minutes=moves.minutes,
        carved=carved,
    )


def _left_mm(
    carved: Carved,
    wanted_mm: Float64[np.ndarray, "m n"],
    beneath_mm: Float64[np.ndarray, "m n"],
    mesh: Mesh,
) -> Float64[np.ndarray, "m n"]:
    """Distance of the carved from the wanted surface, negative where it lies deeper.

    Where a ray meets the shape from a to b and all of that is gone, the middle of it tells how
    deep the cut was.
    """
    through = np.minimum(carved.radii_mm, carved.hollows_mm)
    reached = np.where((beneath_mm == 0) & (through < wanted_mm), through, carved.radii_mm)
    radii = np.where(reached < beneath_mm, (beneath_mm + wanted_mm) / 2, reached)
    angles = np.radians(carved.a_deg)
    x, y = -radii * np.sin(angles), radii * np.cos(angles)
    points = np.stack([x, y, np.broadcast_to(carved.x_mm[:, None], x.shape)], axis=-1)
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    away = tree.closest(points.reshape(-1, 3)).distances_mm.reshape(x.shape)
    return np.where(radii < wanted_mm, -away, away)


def _rapid_hits(moves: Moves, blank: Blank) -> int:
    """Number of rapid moves into or through the blank; straight out is no hit."""
    change = np.abs(np.diff(moves.x_mm)) + np.abs(np.diff(moves.a_deg))
    inwards = moves.tip_mm[1:] < moves.tip_mm[:-1]
    within = np.minimum(moves.tip_mm[1:], moves.tip_mm[:-1]) < blank.radius_mm
    return int((moves.rapid[1:] & within & ((change > 0) | inwards)).sum())


@njit(cache=True, nogil=True)
def _carve(
    x_mm: np.ndarray,
    angles: np.ndarray,
    centres: np.ndarray,
    rapid: np.ndarray,
    ball: float,
    first_x: float,
    cell: float,
    radii: np.ndarray,
    hollows: np.ndarray,
):
    rows, columns = radii.shape
    bin_rad = 2 * math.pi / columns
    cosines = np.cos(bin_rad * np.arange(columns))
    sines = np.sin(bin_rad * np.arange(columns))
    for k in range(1, x_mm.shape[0]):
        if rapid[k]:
            continue
        dx, da, dc = x_mm[k] - x_mm[k - 1], angles[k] - angles[k - 1], centres[k] - centres[k - 1]
        reach = max(abs(dx), abs(da) * max(centres[k], centres[k - 1], ball), abs(dc))
        steps = max(1, int(math.ceil(reach / _STEP_MM)))
        for step in range(1, steps + 1):
            share = step / steps
            x = x_mm[k - 1] + share * dx
            angle = (angles[k - 1] + share * da) % (2 * math.pi)
            centre = centres[k - 1] + share * dc
            turned_cos, turned_sin = math.cos(angle), math.sin(angle)
            here = int(angle / bin_rad + 0.5)
            low = max(0, int(math.ceil((x - ball - first_x) / cell)))
            high = min(rows - 1, int(math.floor((x + ball - first_x) / cell)))
            for row in range(low, high + 1):
                away = first_x + row * cell - x
                room2 = ball * ball - away * away
                if room2 <= 0:
                    continue
                room = math.sqrt(room2)
                # The ball at or over the axis: everything on its side goes.
                wide = columns // 4
                if centre > room:
                    wide = min(wide, int(math.asin(room / centre) / bin_rad) + 1)
                for side in range(-wide, wide + 1):
                    column = here + side
                    if column < 0:
                        column += columns
                    elif column >= columns:
                        column -= columns
                    # cosine and sine of the angle between the cell and the tool
                    along = cosines[column] * turned_cos + sines[column] * turned_sin
                    if centre * along - room >= radii[row, column]:
                        continue  # even right under the tool its end would not come so deep
                    across = sines[column] * turned_cos - cosines[column] * turned_sin
                    free2 = room2 - (centre * across) ** 2
                    if free2 <= 0 or along <= 0:
                        continue
                    free = math.sqrt(free2)
                    inner = max(centre * along - free, 0.0)
                    outer = centre * along + free
                    slant = abs(across)
                    if room * along >= centre * slant:
                        outer = room / max(slant, 1e-12)
                    if outer >= radii[row, column]:
                        radii[row, column] = min(radii[row, column], inner)
                    else:
                        hollows[row, column] = min(hollows[row, column], inner)
