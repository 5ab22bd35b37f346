"""Refusals say which edit refused, in both languages, whichever helper found the reason."""

from dataclasses import replace

import pytest

from limbgram.core.errors import EditError, MeasureError, refusals_about
from limbgram.findings import sentence
from limbgram.workbench.edits.distal_end import DistalEnd
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS, do_edit, require_valid
from limbgram.workbench.edits.extension import Extension
from limbgram.workbench.edits.flare import Flare
from limbgram.workbench.edits.liner import Liner
from limbgram.workbench.edits.plane_cut import PlaneCut
from limbgram.workbench.edits.regions import points_in_limb_frame
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.roll import Roll
from limbgram.workbench.edits.sock_ply import SockPly
from limbgram.workbench.limb import Limb
from limbgram.workbench.recipe.file import make_edit


def test_helpers_refusals_are_told_of_the_edit_that_ran_them(limb: Limb) -> None:
    """Five edits that meet the same refusal deep inside: each is the subject of its own."""
    unaligned = limb.unaligned()
    told = {
        PlaneCut: ("The plane cut", "Der ebene Schnitt"),
        Extension: ("The extension", "Die Randerhöhung"),
        Flare: ("The flare", "Das Ausstellen des Randes"),
        Roll: ("The roll", "Die Taillenrinne"),
        DistalEnd: ("The distal end", "Das Formen des distalen Endes"),
    }
    for kind, (english, german) in told.items():
        with pytest.raises(EditError) as refused:
            do_edit(unaligned, make_edit(name_of(kind), dict(kind.about.example), "the test"))
        found = refused.value.finding
        assert found.code == "edit.not_aligned"
        assert sentence(found) == f"{english} needs to know where the limb's axis lies."
        assert sentence(found, "de") == f"{german} muss wissen, wo die Achse des Gliedmaßes liegt."


@pytest.mark.parametrize("kind", EDITS, ids=name_of)
def test_every_refusal_says_which_edit_it_is_of(kind: type[Edit], limb: Limb) -> None:
    """On a limb without frame and landmarks, and on one that lacks landmarks alone."""
    edit = make_edit(name_of(kind), dict(kind.about.example), "the test")
    subjects: list[object] = []
    for shape in (replace(limb.unaligned(), landmarks=()), replace(limb, landmarks=())):
        try:
            do_edit(shape, edit)
        except EditError as error:
            subjects.append(error.finding.values["what"])
    assert set(subjects) <= {kind.title}


def test_numbers_beyond_their_range_are_refused_of_their_edit() -> None:
    with pytest.raises(EditError) as refused:
        require_valid(Extension(length_mm=-3.0))
    assert refused.value.finding.values["what"] == "The extension"


def test_the_kind_of_limb_is_refused_in_the_readers_language(limb: Limb) -> None:
    edit = make_edit(name_of(Repose), dict(Repose.about.example), "the test")
    with pytest.raises(EditError) as refused:
        do_edit(limb, edit)
    assert refused.value.finding.code == "edit.kind"
    assert sentence(refused.value.finding, "de").startswith("Das Stellen eines Gelenks ist für")


@pytest.mark.parametrize("kind", [DistalEnd, Liner, SockPly], ids=name_of)
def test_what_is_worn_on_a_residual_limb_is_not_for_a_foot(kind: type[Edit], limb: Limb) -> None:
    edit = make_edit(name_of(kind), dict(kind.about.example), "the test")
    for fitting in (None, "transtibial", "transfemoral", "arm", "cast", "socket"):
        do_edit(replace(limb, kind=fitting), edit)
    for other in ("foot", "torso", "head"):
        with pytest.raises(EditError) as refused:
            do_edit(replace(limb, kind=other), edit)
        assert refused.value.finding.code == "edit.kind"
        assert "None" not in sentence(refused.value.finding)


def test_the_innermost_name_counts_and_other_refusals_pass() -> None:
    with pytest.raises(EditError) as refused, refusals_about("outer"), refusals_about("inner"):
        raise EditError("edit.branches")
    assert refused.value.finding.values == {"what": "inner"}
    assert str(refused.value).startswith("inner would leave")
    with pytest.raises(MeasureError) as other, refusals_about("outer"):
        raise MeasureError("anatomy.missing", names=("heel",), wanted_for=None)
    assert "what" not in other.value.finding.values


def test_a_roll_that_misses_the_limb_is_refused(limb: Limb) -> None:
    heights = points_in_limb_frame(limb)[:, 2]
    low, high = float(heights.min()), float(heights.max())
    for at_mm in (low - 20.5, high + 20.5):
        with pytest.raises(EditError) as refused:
            do_edit(limb, Roll(depth_mm=3.0, band_mm=20.0, at_mm=at_mm))
        assert refused.value.finding.code == "edit.levels.off_shape"
        assert refused.value.finding.values["nearest_mm"] == at_mm
    do_edit(limb, Roll(depth_mm=3.0, band_mm=20.0, at_mm=high + 19.5))
