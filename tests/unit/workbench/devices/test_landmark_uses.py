"""The landmarks that a recipe's edits go by, though they do not name them."""

import pytest

from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.devices.landmark_uses import landmarks_of_edits
from limbgram.workbench.edits.arch_fill import ArchFill
from limbgram.workbench.edits.build_ups import BuildUps
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.expansion import Expansion
from limbgram.workbench.edits.heel_skive import HeelSkive
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.plantar_board import PlantarBoard
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.toe_bridge import ToeBridge
from limbgram.workbench.recipe.recipe import Entry, Recipe

FOOT = KIND_NAMED["foot"]
PLACES = {one.identity for one in FOOT.places}


def places_of(edit: Edit, *, on: bool = True) -> set[str]:
    recipe = Recipe(name="", entries=(Entry(edit=edit, on=on),))
    return PLACES & landmarks_of_edits(recipe, FOOT)


def test_build_ups_go_by_the_preset_without_what_stays() -> None:
    assert places_of(BuildUps(without=("heel",))) == set(FOOT.presets) - {"heel"}
    assert places_of(BuildUps(), on=False) == set()


@pytest.mark.parametrize("kind", [ArchFill, Expansion, HeelSkive, PlantarBoard, ToeBridge])
def test_what_edits_a_sole_goes_by_the_frame_of_the_sole(kind: type[Edit]) -> None:
    used = places_of(kind())
    assert {"heel", "first metatarsal head", "fifth metatarsal head", "second toe"} <= used
    assert ("navicular" in used) == (kind is not ToeBridge)


def test_a_joint_that_is_set_to_an_angle_goes_by_what_the_angle_is_read_from() -> None:
    told, read = (
        places_of(Repose(joint="hindfoot", **turn)) for turn in ({"by_deg": 3.0}, {"to_deg": 3.0})
    )
    assert told < read
    assert {"medial calcaneus", "achilles insertion"} <= read - told


def test_an_edit_at_a_place_goes_by_that_place() -> None:
    assert places_of(Load(at="heel", depth_mm=1.0, falloff_mm=5.0)) == {"heel"}
