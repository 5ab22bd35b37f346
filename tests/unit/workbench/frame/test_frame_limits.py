"""How far a statement may lie from what the file and the landmarks say: to the degree."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.frames import Rigid
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.frame.landmarks import likely_meant
from limbgram.workbench.limb import Landmark, Limb, LimbFrame

FRONT = np.array([0.0, 1.0, 0.0])


def codes(limb: Limb, options: AlignOptions) -> list[str]:
    """Of the notes of an alignment, or of its refusal."""
    try:
        return [one.code for one in align(limb, options).notes]
    except LimbgramError as refused:
        return [refused.finding.code]


def about_z(degrees: float) -> Rigid:
    return Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(degrees)]), np.zeros(3))


@pytest.mark.parametrize(
    ("off_deg", "code"),
    [(9.9, []), (10.1, ["align.front.off_file"]), (59.9, ["align.front.off_file"]),
     (60.1, ["align.front.against_file"])],
)  # fmt: skip
def test_the_front_may_lie_10_degrees_off_the_files_and_60_with_a_note(
    stump: Limb, off_deg: float, code: list[str]
) -> None:
    declared = LimbFrame(limb_from_mesh=about_z(off_deg), side="right")
    options = AlignOptions(side="right", anterior=FRONT, declared=declared)
    assert codes(replace(stump, landmarks=()), options) == code


def with_head(stump: Limb, off_deg: float, from_axis_mm: float) -> Limb:
    """A fibula head, which belongs at the right, so far from there."""
    x, y = from_axis_mm * np.cos(np.radians(off_deg)), from_axis_mm * np.sin(np.radians(off_deg))
    head = Landmark(name="fibula head", position_mm=np.array([x, y, 170.0]))
    return replace(stump, landmarks=(head,))


@pytest.mark.parametrize(
    ("off_deg", "from_axis_mm", "refused"),
    [(59.0, 50.0, False), (61.0, 50.0, True), (180.0, 14.9, False), (180.0, 15.2, True)],
)
def test_a_landmark_lies_within_60_degrees_of_its_side_unless_it_lies_on_the_axis(
    stump: Limb, off_deg: float, from_axis_mm: float, refused: bool
) -> None:
    limb = with_head(stump, off_deg, from_axis_mm)
    options = AlignOptions(side="right", anterior=FRONT, axis=np.array([0.0, 0.0, 1.0]))
    found = codes(limb, options)
    assert ("align.landmark.elsewhere" in found) == refused


@pytest.mark.parametrize(("off_deg", "refused"), [(99.0, False), (101.0, True)])
def test_a_landmark_of_a_foot_lies_within_100_degrees(
    stump: Limb, off_deg: float, refused: bool
) -> None:
    limb = with_head(stump, off_deg, 50.0)
    (head,) = limb.landmarks
    limb = replace(limb, landmarks=(replace(head, name="lateral malleolus"),), kind="foot")
    options = AlignOptions(
        side="right", kind="foot", anterior=FRONT, axis=np.array([0.0, 0.0, 1.0])
    )
    assert ("align.landmark.elsewhere" in codes(limb, options)) == refused


@pytest.mark.parametrize(("lean_deg", "refused"), [(44.8, False), (45.2, True)])
def test_the_fitted_axis_lies_within_45_degrees_of_what_is_proximal(
    stump: Limb, lean_deg: float, refused: bool
) -> None:
    lean = np.array([np.sin(np.radians(lean_deg)), 0.0, np.cos(np.radians(lean_deg))])
    options = AlignOptions(side="right", anterior=FRONT, proximal=lean)
    assert ("align.axis.across" in codes(replace(stump, landmarks=()), options)) == refused


@pytest.mark.parametrize(("lean_deg", "refused"), [(44.8, False), (45.2, True)])
def test_a_limb_is_turned_by_a_plumb_line_that_leans_45_degrees(
    stump: Limb, lean_deg: float, refused: bool
) -> None:
    upper = Landmark(name="over", position_mm=np.array([0.0, 50.0, 170.0]))
    reach = 40.0 * np.tan(np.radians(lean_deg))
    lower = Landmark(name="under", position_mm=np.array([0.0, 50.0 - reach, 130.0]))
    options = AlignOptions(
        side="right", anterior=FRONT, axis=np.array([0.0, 0.0, 1.0]), plumb=("over", "under")
    )
    found = codes(replace(stump, landmarks=(upper, lower)), options)
    assert ("align.plumb" in found) == refused


@pytest.mark.parametrize(("flexion_deg", "refused"), [(120.0, False), (120.1, True)])
def test_no_joint_bends_beyond_120_degrees(stump: Limb, flexion_deg: float, refused: bool) -> None:
    options = AlignOptions(side="right", kind="transtibial", flexion_deg=flexion_deg)
    assert ("align.flexion" in codes(stump, options)) == refused


def test_four_letters_of_five_are_a_slip_of_the_pen() -> None:
    """difflib counts both names: 2 x 9 of 22 letters are 0.82, 2 x 8 of 22 are 0.73."""
    assert likely_meant("fibula hexd", None) == "fibula head"
    assert likely_meant("fixxlx xead", None) is None


@pytest.mark.parametrize("named", ["axis", "proximal", "anterior"])
@pytest.mark.parametrize("given", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (np.inf, 0.0, 0.0)])
def test_a_direction_has_a_length(
    stump: Limb, named: str, given: tuple[float, float, float]
) -> None:
    stated = {"anterior": FRONT, named: np.array(given)}
    assert codes(stump, AlignOptions(side="right", **stated)) == ["options.no_direction"]
