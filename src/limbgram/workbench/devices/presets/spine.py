"""Trims of spinal orthoses: an upper and a lower edge; they open in front or behind."""

from collections.abc import Mapping
from itertools import product

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import Slot
from limbgram.workbench.devices.trims import (
    Loop,
    Measure,
    Trim,
    TrimPoint,
    mirrored_points,
    point_round_axis,
)

_PAIRED = ("axilla", "trochanter", "iliac spine")
_OTHER = {
    **{f"right {name}": f"left {name}" for name in _PAIRED},
    **{f"left {name}": f"right {name}" for name in _PAIRED},
    **{
        f"{name}, right": f"{name}, left"
        for name in ("arm", "back", "chest", "side", "seat", "groin")
    },
}

MEASURES = (
    Measure(
        name="front_top_mm",
        usual=20.0,
        within=Within(-20, 90),
        en="Upper edge in front, over the xiphoid",
        de="Oberer Rand vorn, über dem Schwertfortsatz",
    ),
    Measure(
        name="below_axilla_mm",
        usual=25.0,
        within=Within(20, 30),
        en="Upper edge at the sides, below the axilla",
        de="Oberer Rand seitlich, unter der Achsel",
    ),
    Measure(
        name="back_top_mm",
        usual=20.0,
        within=Within(0, 40),
        en="Upper edge behind, over the sides' edge",
        de="Oberer Rand hinten, über dem seitlichen Rand",
    ),
    Measure(
        name="over_pubis_mm",
        usual=15.0,
        within=Within(5, 40),
        en="Lower edge in front, over the pubic symphysis",
        de="Unterer Rand vorn, über der Schambeinfuge",
    ),
    Measure(
        name="groin_mm",
        usual=30.0,
        within=Within(15, 45),
        en="Lower edge at the groin, below the iliac spine",
        de="Unterer Rand an der Leiste, unter dem Darmbeinstachel",
    ),
    Measure(
        name="over_trochanter_mm",
        usual=15.0,
        within=Within(0, 50),
        en="Lower edge at the sides, over the trochanter",
        de="Unterer Rand seitlich, über dem Rollhügel",
    ),
    Measure(
        name="over_coccyx_mm",
        usual=22.0,
        within=Within(15, 40),
        en="Lower edge behind, over the coccyx",
        de="Unterer Rand hinten, über dem Steißbein",
    ),
)
GAP = Measure(
    name="gap_mm",
    usual=30.0,
    within=Within(10, 80),
    en="Width of the opening",
    de="Breite der Öffnung",
)
VENT = Measure(
    name="vent_mm",
    usual=0.0,
    within=Within(0, 12),
    en="Diameter of vents at the waist, nine to each side in front and behind; 0 for none",
    de="Durchmesser der Lüftungslöcher in der Taille, neun je Seite vorn und hinten; 0 für keine",
)
VENTS_APART = Measure(
    name="vents_apart_mm",
    usual=25.0,
    within=Within(18, 40),
    en="From vent to vent",
    de="Von Loch zu Loch",
)
VENTILATION = (VENT, VENTS_APART)


def _vents(quarters_deg: Mapping[str, float]) -> tuple[Slot, ...]:
    """Three rows of three holes round the middle of each quarter, at the height of the navel."""
    return tuple(
        Slot(
            name=f"vent, {quarter}, row {row + 2}, hole {column + 2}",
            at=TrimPoint(
                name="vent",
                at="navel",
                up_mm=f"{row}*vents_apart_mm",
                around_deg=middle_deg,
                round_mm=f"{column}*vents_apart_mm",
            ),
            length_mm="vent_mm",
            width_mm="vent_mm",
        )
        for (quarter, middle_deg), row, column in product(
            quarters_deg.items(), (-1, 0, 1), (-1, 0, 1)
        )
    )


VENTS = _vents(
    {"front, right": 55.0, "back, right": 125.0, "back, left": 235.0, "front, left": 305.0}
)


_TOP_RIGHT = (
    point_round_axis(
        "back, right", "right axilla", ("-below_axilla_mm", "back_top_mm", -4.0), 135.0
    ),
    point_round_axis("arm, right", "right axilla", "-below_axilla_mm", 90.0),
    point_round_axis("chest, right", "xiphoid", ("0.9*front_top_mm", 12.0), 42.0),
)
_BOTTOM_RIGHT = (
    point_round_axis("seat, right", "coccyx", ("over_coccyx_mm", 2.0), 142.0),
    point_round_axis("side, right", "right trochanter", "over_trochanter_mm", 90.0),
    point_round_axis("groin, right", "right iliac spine", "-groin_mm", 45.0),
)
FRONT_TOP = point_round_axis("front", "xiphoid", "front_top_mm", 0.0)
FRONT_BOTTOM = point_round_axis("front", "pubic symphysis", "over_pubis_mm", 0.0)
BACK_TOP = point_round_axis("back", "right axilla", ("-below_axilla_mm", "back_top_mm"), 180.0)
BACK_BOTTOM = point_round_axis("back", "coccyx", "over_coccyx_mm", 180.0)
_WAIST = TrimPoint(name="navel", at="navel", seen_from="anterior")
THORACOLUMBOSACRAL = Trim(
    loops=(
        Loop(
            name="upper edge",
            points=(
                BACK_TOP,
                *_TOP_RIGHT,
                FRONT_TOP,
                *mirrored_points(_TOP_RIGHT, _OTHER),
            ),
            keeps=_WAIST,
        ),
        Loop(
            name="lower edge",
            points=(
                BACK_BOTTOM,
                *_BOTTOM_RIGHT,
                FRONT_BOTTOM,
                *mirrored_points(_BOTTOM_RIGHT, _OTHER),
            ),
            keeps=_WAIST,
        ),
    ),
    measures=MEASURES,
)
