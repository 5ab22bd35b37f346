"""The landmarks that a recipe's edits go by, though they do not name them."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.workbench.anatomy.known_kinds import KIND_NAMED
from limbgram.workbench.devices.landmark_uses import landmarks_of_edits
from limbgram.workbench.edits.arch_fill import ArchFill
from limbgram.workbench.edits.build_ups import BuildUps
from limbgram.workbench.edits.edit import Edit
from limbgram.workbench.edits.expansion import Expansion
from limbgram.workbench.edits.from_template import FromTemplate
from limbgram.workbench.edits.heel_skive import HeelSkive
from limbgram.workbench.edits.load import Load
from limbgram.workbench.edits.pad import Pad
from limbgram.workbench.edits.plantar_board import PlantarBoard
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.toe_bridge import ToeBridge
from limbgram.workbench.recipe.recipe import Entry, Recipe
from limbgram.workbench.templates.chart_field import ANGLES, node_heights
from limbgram.workbench.templates.files import encode_template
from limbgram.workbench.templates.template import Template, TemplateMark

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


def test_a_pad_s_height_goes_by_the_landmarks_of_the_centreline() -> None:
    pad = Pad(at=(0.0, 0.0, 0.0), depth_mm=1.0, width_mm=20.0, height_mm=20.0)
    assert {"medial malleolus", "heel", "first metatarsal head", "second toe"} <= places_of(pad)


def test_a_template_goes_by_the_landmarks_that_place_it() -> None:
    heights = node_heights(1.0)
    none = np.zeros((len(heights), ANGLES))
    template = Template(
        name="mine",
        pairs=1,
        sided=True,
        reference="lateral malleolus",
        marks=(TemplateMark(name="Kahnbein", height=0.5, angle_deg=-60.0),),
        heights=heights,
        displacement_mm=none,
        spread_mm=none * np.nan,
        known_pairs=none.astype(np.int64),
    )
    edit = FromTemplate(learned=encode_template(template).decode())
    recipe = Recipe(name="", entries=(Entry(edit=edit),))
    assert landmarks_of_edits(recipe, FOOT) == {"lateral malleolus", "Kahnbein"}
    curved = FromTemplate(learned=encode_template(replace(template, along="centreline")).decode())
    assert {"heel", "second toe", "lateral malleolus"} <= places_of(curved)
