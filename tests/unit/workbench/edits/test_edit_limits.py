"""What an edit may be given: lengths, places, and how many of them, at their limits."""

from collections.abc import Callable

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.workbench.edits.editing import do_edit, require_valid
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.refinement import edge_for_falloff_mm
from limbgram.workbench.edits.regions import on_surface, require_ring
from limbgram.workbench.limb import Limb


def refused(act: Callable[[], object]) -> str:
    """The code of the refusal; empty where it is taken."""
    try:
        act()
    except EditError as error:
        return error.finding.code
    return ""


def test_no_length_is_beyond_two_metres() -> None:
    assert not refused(lambda: require_valid(PlaneCut(height_mm=2000.0)))
    assert refused(lambda: require_valid(PlaneCut(height_mm=2000.1))) == "edit.longer_than_limb"


@pytest.mark.parametrize("way", ["forward_deg", "right_deg"])
def test_a_cut_across_the_limb_leans_by_80_degrees_at_most(way: str) -> None:
    for sign in (1.0, -1.0):
        assert not refused(lambda s=sign: require_valid(PlaneCut(height_mm=80.0, **{way: 80 * s})))
        assert refused(lambda s=sign: require_valid(PlaneCut(height_mm=80.0, **{way: 80.1 * s})))


@pytest.mark.parametrize(("off_mm", "code"), [(9.9, ""), (10.1, "edit.point.off_surface")])
def test_a_place_lies_within_10_mm_of_the_surface(limb: Limb, off_mm: float, code: str) -> None:
    """Of the side of the tube, whose radius is 40 mm."""
    place = limb.frame.limb_from_mesh.inverse.apply(np.array([[0.0, 40.0 + off_mm, 100.0]]))
    assert refused(lambda: on_surface(limb, place)) == code


def test_a_ring_has_three_places_at_least() -> None:
    places = ["front", "right", "behind"]
    assert not refused(lambda: require_ring(places))
    assert refused(lambda: require_ring(places[:2])) == "edit.ring.few"


@pytest.mark.parametrize(("length_mm", "edge_mm"), [(2.0, 0.4), (8.0, 1.0), (40.0, 5.0)])
def test_what_fades_has_eight_edges_but_none_below_0_4_mm(length_mm: float, edge_mm: float) -> None:
    assert edge_for_falloff_mm(length_mm) == edge_mm


@pytest.mark.parametrize(("height_mm", "code"), [(160.9, ""), (161.1, "edit.levels.off_shape")])
def test_a_level_a_millimetre_beyond_an_end_is_meant_to_be_the_end(
    limb: Limb, height_mm: float, code: str
) -> None:
    """The tube ends at 160 mm."""
    levels = Reduction(heights_mm=(height_mm,), per_cent=(2.0,), of="girth")
    assert refused(lambda: do_edit(limb, levels)) == code
