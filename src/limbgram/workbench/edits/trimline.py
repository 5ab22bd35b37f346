"""Trimline: the limb cut along a curve drawn on its surface."""

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.cutting import Part, keep_positive
from limbgram.workbench.edits.edit import Edit, Effect, Words, edit, spoken
from limbgram.workbench.edits.regions import (
    FrameName,
    Place,
    draw_curve,
    find_sides,
    fine_along,
    on_surface,
    points_in_limb_frame,
    position_mm,
    require_ring,
)
from limbgram.workbench.limb import Limb

_EDGE_MM = 1.5
"""Edges along a trimline before it is cut."""


@edit(
    group="cuts",
    order=2,
    effect=Effect(),
    rarely=("positions_in",),
    example={"through": ["fibula head", [1.0, 2.5, 3.0], "patellar tendon"]},
)
class Trimline(Edit):
    """Cut along a closed curve drawn on the surface."""

    through: tuple[Place, ...]
    """Points in order round the limb, on the surface; the curve through them is smooth."""
    keep: Part = "distal"
    """Which part stays."""
    positions_in: FrameName = "limb"
    """Frame of coordinates."""

    words = spoken(
        en=Words(
            name="Trimline",
            title="The trimline",
            labels={"keep": "Which part stays"},
            choices={"distal": "the distal part", "proximal": "the proximal part"},
        ),
        de=Words(
            name="Randlinie",
            title="Die Randlinie",
            does="Längs einer geschlossenen, auf die Fläche gezeichneten Linie schneiden.",
            labels={
                "through": "Durch die Punkte",
                "keep": "Welcher Teil bleibt",
                "positions_in": "Koordinaten gelten",
            },
            help={
                "through": "Punkte der Reihe nach um das Gliedmaß, auf der Fläche; die Linie durch "
                "sie ist glatt.",
                "keep": "Welcher Teil bleibt.",
                "positions_in": "Koordinatensystem der Punkte.",
            },
            choices={"distal": "der distale Teil", "proximal": "der proximale Teil"},
        ),
    )

    def check(self) -> None:
        require_ring(self.through, self.title)

    def apply(self, limb: Limb) -> Limb:
        """Cut along a curve; triangles across it are split, so the new brim follows it.

        Raises:
            EditError: the curve does not part the surface in two.
        """
        what = self.title
        picked = np.stack(
            [position_mm(limb, place, self.positions_in, what) for place in self.through]
        )
        curve = draw_curve(limb.mesh, on_surface(limb, picked, what), what)
        fine = fine_along(limb.mesh, curve, _EDGE_MM)
        sides = find_sides(fine, curve, what)
        heights = points_in_limb_frame(limb.with_mesh(fine), what)[:, 2]
        left_is_kept = _is_kept(fine, sides.left, heights, self.keep)
        apart = np.where(
            np.isfinite(sides.signed_mm), sides.signed_mm, np.where(sides.left, 1e3, -1e3)
        )
        cut = keep_positive(fine, apart if left_is_kept else -apart)
        return limb.with_mesh(cut.mesh)


def _is_kept(
    mesh: Mesh, left: Bool[np.ndarray, " n"], heights: Float64[np.ndarray, " n"], keep: Part
) -> bool:
    """Whether the part to the left of the curve is the one to keep, by the middles of both."""
    areas = np.linalg.norm(mesh.face_normals(), axis=1)
    middle, share = heights[mesh.faces].mean(1), left[mesh.faces].mean(1)
    of_left = (areas * share * middle).sum() / (areas * share).sum()
    of_right = (areas * (1 - share) * middle).sum() / (areas * (1 - share)).sum()
    return bool((of_left > of_right) == (keep == "proximal"))
