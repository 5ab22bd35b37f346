"""Extension: the brim raised to a level edge."""

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.workbench.edits.brim import brim_loop
from limbgram.workbench.edits.edit import AboveZeroMm, Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import (
    moved_by,
    points_in_limb_frame,
    require_aligned,
    section_centres_mm,
    smooth_normals,
    with_surface_added,
)
from limbgram.workbench.limb import Limb

_STEEPEST = 0.5
"""Slope with which an extension may begin, mm outwards for each mm up."""
_SLOPE_WINDOW_SHARE = 0.1
"""Share of the brim over which that slope is averaged, to either side."""
_MOST_TRIANGLE_ROWS = 100
"""Most rows of triangles in an extension: a refined brim would give it millions."""


@edit(
    group="ends",
    order=1,
    effect=Effect(reports_displacement=False),
    everyday=True,
    example={"length_mm": 20.0},
)
class Extension(Edit):
    """Raise the brim along the limb's axis to a level edge."""

    length_mm: AboveZeroMm
    """From the highest point of the brim as it is to the new, level edge."""

    words = spoken(
        en=Words(name="Raise the brim", title="The extension"),
        de=Words(
            name="Rand erhöhen",
            title="Die Randerhöhung",
            does="Den Rand längs der Achse bis zu einer ebenen Kante erhöhen.",
            labels={"length_mm": "Länge"},
            help={
                "length_mm": "Vom höchsten Punkt des jetzigen Randes bis zur neuen, ebenen Kante."
            },
        ),
    )

    def apply(self, limb: Limb) -> Limb:
        """Add a wall from the brim to a level edge: it goes on with the slope, then turns upright.

        Raises:
            EditError: no open brim, or a wall that would cut through the limb.
        """
        loop = brim_loop(limb)
        points = points_in_limb_frame(limb)
        start = points[loop]
        rise = start[:, 2].max() + self.length_mm - start[:, 2]
        slope = _brim_slopes(limb, loop, points)
        edge = np.linalg.norm(np.roll(start, -1, axis=0) - start, axis=1)
        rows = max(2, int(np.ceil(rise.max() / max(float(np.median(edge)), 0.5))))
        rows = min(rows, _MOST_TRIANGLE_ROWS)
        share = (np.arange(1, rows + 1) / rows)[:, None]
        up = share * rise
        out = (share - share**2 / 2) * rise * slope[:, 2]
        ring = np.stack(
            [start[:, 0] + out * slope[:, 0], start[:, 1] + out * slope[:, 1], start[:, 2] + up],
            axis=2,
        )
        count = len(loop)
        number = np.concatenate(
            [loop[None], len(limb.mesh) + np.arange(rows * count).reshape(rows, -1)]
        )
        here, ahead = number, np.roll(number, -1, axis=1)
        # The old faces run along the loop; the new ones below each row run against it.
        one = np.stack([ahead[:-1], here[:-1], here[1:]], axis=-1)
        two = np.stack([ahead[:-1], here[1:], ahead[1:]], axis=-1)
        faces = np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)]).astype(np.int32)
        places = moved_by(require_aligned(limb).limb_from_mesh.inverse, ring.reshape(-1, 3))
        like = np.tile(loop, rows).astype(np.int64)
        return limb.with_mesh(with_surface_added(limb.mesh, places, like, faces))


def _brim_slopes(
    limb: Limb, loop: Int64[np.ndarray, " b"], points: Float64[np.ndarray, "n 3"]
) -> Float64[np.ndarray, "b 3"]:
    """At each vertex of the brim: direction outwards (x, y), and mm outwards for each mm up."""
    motion = require_aligned(limb).limb_from_mesh
    normals = np.einsum("nj,ij->ni", smooth_normals(limb.mesh)[loop], motion.rotation)
    outward = (points - section_centres_mm(limb, points))[loop, :2]
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12)
    across = (normals[:, :2] * outward).sum(1)
    steep = np.clip(-normals[:, 2] / np.maximum(across, 0.2), -_STEEPEST, _STEEPEST)
    reach = max(1, int(_SLOPE_WINDOW_SHARE * len(loop)))
    around = sum((np.roll(steep, shift) for shift in range(-reach, reach + 1)), np.zeros(len(loop)))
    return np.column_stack([outward, around / (2 * reach + 1)])
