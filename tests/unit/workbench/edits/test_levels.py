"""Per cent by level and presets: girths and areas change by what is stated."""

import math

import numpy as np
import pytest

from limbgram.core.errors import EditError
from limbgram.core.mesh.topology import volume_mm3
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.increase import Increase
from limbgram.workbench.edits.liner import LINERS, Liner
from limbgram.workbench.edits.reduction import Reduction
from limbgram.workbench.edits.sock import Sock
from limbgram.workbench.edits.sock_ply import SockPly
from limbgram.workbench.limb import Limb


def radii_mm(limb: Limb) -> tuple[np.ndarray, np.ndarray]:
    """Heights and radii of the vertices on the tube."""
    points = limb.frame.limb_from_mesh.apply(limb.mesh.vertices_mm)
    tube = points[:, 2] > 41
    return points[tube, 2], np.hypot(points[tube, 0], points[tube, 1])


def test_girths_shrink_by_their_per_cent_and_between_levels_in_proportion(limb: Limb) -> None:
    edit = Reduction(heights_mm=(60, 120), per_cent=(2, 6), of="girth")
    heights, radii = radii_mm(do_edit(limb, edit))
    expected = 40 * (1 - np.interp(heights, [60, 120], [0.02, 0.06]))
    np.testing.assert_allclose(radii, expected, rtol=1e-9)


def test_heights_count_from_a_landmark_if_one_is_named(limb: Limb) -> None:
    edit = Reduction(heights_mm=(-40, 20), per_cent=(2, 6), of="girth", above="front")
    heights, radii = radii_mm(do_edit(limb, edit))
    expected = 40 * (1 - np.interp(heights, [60, 120], [0.02, 0.06]))
    np.testing.assert_allclose(radii, expected, rtol=1e-9)


def test_volume_changes_by_its_per_cent(limb: Limb) -> None:
    more = do_edit(limb, Increase(heights_mm=(0,), per_cent=(7,), of="volume"))
    assert volume_mm3(more.mesh) / volume_mm3(limb.mesh) == pytest.approx(1.07, rel=1e-9)
    less = do_edit(limb, Reduction(heights_mm=(0,), per_cent=(7,), of="girth"))
    assert volume_mm3(less.mesh) / volume_mm3(limb.mesh) == pytest.approx(0.93**2, rel=1e-9)


def test_the_sock_comes_off_once_and_is_remembered(limb: Limb) -> None:
    bare = do_edit(limb, Sock(thickness_mm=2.0))
    heights, radii = radii_mm(bare)
    tube = heights > 50
    np.testing.assert_allclose(radii[tube], 40 - 2 / math.cos(math.pi / 72), rtol=1e-5)
    assert bare.sock_mm == 2.0
    with pytest.raises(EditError, match="2 mm of sock are off this surface already"):
        do_edit(bare, Sock(thickness_mm=0.3))


@pytest.mark.parametrize("thickness_mm", [0.0, -0.3, 25.0, math.nan])
def test_no_sock_is_that_thick(limb: Limb, thickness_mm: float) -> None:
    with pytest.raises(EditError, match=r"thickness_mm\) goes above 0 and up to 20 mm"):
        do_edit(limb, Sock(thickness_mm=thickness_mm))


def test_plies_and_liners_follow_what_is_published(limb: Limb) -> None:
    whole = volume_mm3(limb.mesh)
    room = do_edit(limb, SockPly(plies=2))
    assert volume_mm3(room.mesh) / whole == pytest.approx(1.022, rel=1e-9)
    tight = do_edit(limb, SockPly(plies=-1))
    assert volume_mm3(tight.mesh) / whole == pytest.approx(0.989, rel=1e-9)
    for name, least, most in (("alpha-3mm", 3, 5), ("alpha-6mm", 5, 7), ("alpha-9mm", 7, 9)):
        for share, per_cent in ((0.0, least), (1.0, most)):
            edited = do_edit(limb, Liner(name=name, share=share))  # pyright: ignore
            assert volume_mm3(edited.mesh) / whole == pytest.approx(1 - per_cent / 100, rel=1e-9)
    heights, radii = radii_mm(do_edit(limb, Liner(name="iceross-original", share=0.5)))
    np.testing.assert_allclose(radii, 40 * (1 - 0.04 * heights / 160), rtol=1e-9)


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (Reduction(heights_mm=(1, 2), per_cent=(1,), of="girth"), "one for each level"),
        (Reduction(heights_mm=(2, 1), per_cent=(1, 1), of="girth"), "rising"),
        (
            Reduction(heights_mm=(1,), per_cent=(-1,), of="girth"),
            r"per_cent\) goes from 0 to 50 %, not -1",
        ),
        (Reduction(heights_mm=(1,), per_cent=(1,), of="girth", above="heel"), "heel"),
        (
            Reduction(heights_mm=(1,), per_cent=(math.nan,), of="girth"),
            r"per_cent\) goes from 0 to 50 %",
        ),
        (Reduction(heights_mm=(300,), per_cent=(1,), of="girth"), "from -?0.0 to 160.0 mm"),
        (Reduction(heights_mm=(-90, -9), per_cent=(1, 2), of="girth"), "nearest lies at -9.0"),
        (Reduction(heights_mm=(170, 500), per_cent=(1, 2), of="volume"), "nearest lies at 170.0"),
    ],
)
def test_what_makes_no_sense_is_refused(limb: Limb, edit: Reduction, reason: str) -> None:
    with pytest.raises(EditError, match=reason):
        do_edit(limb, edit)


def test_levels_beyond_the_ends_count_as_long_as_the_limb_lies_between(limb: Limb) -> None:
    wide = Reduction(heights_mm=(-40, 360), per_cent=(0, 10), of="girth")
    heights, radii = radii_mm(do_edit(limb, wide))
    np.testing.assert_allclose(radii, 40 * (1 - 0.1 * (heights + 40) / 400), rtol=1e-9)
    assert do_edit(limb, Reduction(heights_mm=(160.5,), per_cent=(1,), of="girth"))


@pytest.mark.parametrize("proximal_mm", [330.0, 1999.0])
def test_a_liner_does_not_taper_to_a_height_that_no_limb_cut_short_has(
    limb: Limb, proximal_mm: float
) -> None:
    with pytest.raises(EditError, match=r"to 160\.0 mm along the axis"):
        do_edit(limb, Liner(name="iceross-original", proximal_mm=proximal_mm))
    tapered = do_edit(limb, Liner(name="iceross-original", share=1.0, proximal_mm=320.0))
    heights, radii = radii_mm(tapered)
    most = LINERS["iceross-original"].most_per_cent / 100
    np.testing.assert_allclose(radii, 40 * (1 - most * heights / 320), rtol=1e-9)


def test_a_limb_without_axis_is_refused(limb: Limb) -> None:
    loose = Limb(mesh=limb.mesh)
    with pytest.raises(EditError, match="Align"):
        do_edit(loose, Reduction(heights_mm=(1,), per_cent=(1,), of="girth"))
