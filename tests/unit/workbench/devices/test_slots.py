"""Slots over the corners of their ranges: as far inside drawn edges as asked, or refused."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest
from scipy.spatial import KDTree

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.mesh.topology import face_components
from limbgram.workbench.devices.device import devices
from limbgram.workbench.devices.layout import Opening
from limbgram.workbench.devices.making import Order, Preview, make_device, preview_device
from limbgram.workbench.devices.proof import require_solid
from limbgram.workbench.devices.trims import amount_of
from limbgram.workbench.limb import Limb

DEVICES = devices()
TRUNK = (
    *("chest_strap_mm", "waist_strap_mm", "pelvis_strap_mm", "chest_strap_below_mm"),
    *("waist_strap_up_mm", "pelvis_strap_above_mm", "slots_back_mm", "gap_mm"),
    *("wall_mm", "over_pubis_mm", "below_axilla_mm"),
)
CALF = ("below_fibula_mm", "strap_below_mm", "strap_mm", "strap_back_mm")
OF_CALF = ("solid-afo", "posterior-leaf-spring", "hinged-afo-calf")
_FIRST_RUN = (1, 1, 0, 1, 1, 1, 0, 0, 0, 1, 0)
TWELVE = (*(np.roll(_FIRST_RUN, k) for k in range(11)), np.zeros(11, int))
"""Plackett and Burman 1946: of each two of eleven measures, all four pairs of ends, thrice each."""
BOTH_ENDS = (0, 3, 4, 7)
"""Of the runs of a calf: each measure twice at either end."""
PLACES = ("device.opening.edge", "device.slot.no_room")
FINE_MM = 1.6
"""Edges of triangles beside openings: a hole's vertices begin so far within its side."""


def at_ends(name: str, measures: tuple[str, ...], ends: tuple[int, ...]) -> dict[str, float]:
    known = {one.name: one.within for one in DEVICES[name].measures("printed")}
    return {
        one: (known[one].least, known[one].most)[end]
        for one, end in zip(measures, ends, strict=True)
    }


def hole_of(preview: Preview, opening: Opening) -> Points3:
    """Vertices in an opening."""
    layout = preview.layout
    inside = layout.beyond_mm > 0
    faces = np.flatnonzero(inside[layout.positive.faces].all(1))
    pieces = face_components(layout.positive.faces[faces])
    middles = layout.positive.vertices_mm[layout.positive.faces[faces]].mean(1)
    own = pieces == pieces[np.linalg.norm(middles - opening.middle_mm, axis=1).argmin()]
    return layout.positive.vertices_mm[np.unique(layout.positive.faces[faces[own]])]


def require_inside(preview: Preview) -> None:
    """Straight ways from holes to edges, which are hardly shorter than those over the surface."""
    curves = {one.name: one.curve.points_mm for one in preview.drawn.edges}
    by_name = {one.name: one for one in preview.device.slots if one.strap}
    for opening in preview.openings:
        slot = by_name[opening.name]
        hole = hole_of(preview, opening)
        assert np.ptp(hole[:, 2]) == pytest.approx(opening.length_mm, abs=2 * FINE_MM + 2.0)
        for one in slot.inside:
            margin_mm = amount_of(one.margin_mm, preview.values)
            if one.edge in curves:
                line = curves[one.edge]
                if one.stretch is not None:
                    at = {h.point: h.point_mm for h in preview.drawn.handles}
                    first, last = (int(KDTree(line).query(at[p])[1]) for p in one.stretch)
                    line = np.roll(line, -first, axis=0)[: (last - first) % len(line) + 1]
                own_mm = float(KDTree(line).query(hole)[0].min())
            else:
                own_mm = float(np.abs(hole[:, 0]).min()) - preview.values["gap_mm"] / 2
            assert 0.93 * margin_mm - 0.3 < own_mm < margin_mm + FINE_MM, (slot.name, one.edge)


def require_in_place(refusal: EditError) -> None:
    told = refusal.finding
    assert told.code in PLACES, str(refusal)
    assert np.shape(told.values["point_mm"]) == (3,)
    assert told.values["labels"]


def corners(name: str) -> list[dict[str, float]]:
    if name in OF_CALF:
        half = [ends for ends in product((0, 1), repeat=len(CALF)) if sum(ends) % 2 == 0]
        return [at_ends(name, CALF, ends) for ends in half]  # of each three measures, all ends
    return [at_ends(name, TRUNK, tuple(run)) for run in TWELVE]


CORNERS = [
    (name, number)
    for name in (*OF_CALF, "tlso-front", "tlso-back")
    for number in range(len(corners(name)))
]


@pytest.mark.parametrize(
    ("name", "runs"),
    [
        ("posterior-leaf-spring", BOTH_ENDS),
        *(pytest.param(one, range(8), marks=pytest.mark.slow) for one in OF_CALF),
        *(
            pytest.param(one, range(12), marks=pytest.mark.slow)
            for one in ("tlso-front", "tlso-back")
        ),
    ],
)
def test_slots_keep_their_margins_at_the_corners_of_their_ranges(
    bodies: dict[str, Limb], name: str, runs: Sequence[int]
) -> None:
    refusals: list[EditError] = []
    tried = [corners(name)[run] for run in runs]
    for values in tried:
        order = Order(device=name, made="printed", values=values)
        try:
            preview = preview_device(bodies[DEVICES[name].kind], order)
        except EditError as refusal:
            refusals.append(refusal)
        else:
            assert dict(preview.values) | values == dict(preview.values)
            require_inside(preview)
    for refusal in refusals:
        require_in_place(refusal)
    assert len(tried) - len(refusals) >= 4


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number"), CORNERS)
def test_a_device_at_a_corner_of_its_straps_is_one_solid_or_refused(
    bodies: dict[str, Limb], name: str, number: int
) -> None:
    order = Order(device=name, made="printed", values={**corners(name)[number], "wall_mm": 5.0})
    try:
        made = make_device(bodies[DEVICES[name].kind], order)
    except EditError as refusal:
        told = refusal
    else:
        require_solid(made.solid)
        assert made.wall.off_mm < 0.05
        return
    require_in_place(told)
