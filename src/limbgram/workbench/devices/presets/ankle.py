"""Trims of ankle-foot orthoses: solid, leaf spring, hinged, ground reaction; SMO, UCBL, insole.

An edge begins behind, goes down in front of or behind the ankle, along the foot's wall to the toes,
and back on the other side. The lateral half is written; the medial one is its mirror with landmarks
and measures of its own.
"""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.trims import Amount, Loop, Measure, Trim, TrimPoint, mirrored_points
from limbgram.workbench.kinds.foot import USUAL_TRIM_MM

_OTHER = {
    "lateral malleolus": "medial malleolus",
    "medial malleolus": "lateral malleolus",
    "fifth metatarsal head": "first metatarsal head",
    "first metatarsal head": "fifth metatarsal head",
    "ankle_lateral_mm": "ankle_medial_mm",
    "wall_lateral_mm": "wall_medial_mm",
    "top, lateral behind": "top, medial behind",
    "top, lateral": "top, medial",
    "calf, lateral": "calf, medial",
    "shin, lateral": "shin, medial",
    "spring, lateral": "spring, medial",
    "ankle, lateral": "ankle, medial",
    "heel, lateral": "heel, medial",
    "wall, lateral": "wall, medial",
    "wall end, lateral": "wall end, medial",
    "toes, lateral": "toes, medial",
    "plate end, lateral": "plate end, medial",
    "joint, lateral": "joint, medial",
    "below, lateral": "below, medial",
}

TOP = Measure(
    name="below_fibula_mm",
    usual=USUAL_TRIM_MM,
    within=Within(15, 40),
    en="Upper edge, below the fibula head",
    de="Oberer Rand, unter dem Wadenbeinköpfchen",
)
ANKLE_LATERAL = Measure(
    name="ankle_lateral_mm",
    usual=12.0,
    within=Within(5, 15),
    en="Ankle, in front of the lateral malleolus",
    de="Knöchel, vor dem Außenknöchel",
)
ANKLE_MEDIAL = Measure(
    name="ankle_medial_mm",
    usual=12.0,
    within=Within(5, 15),
    en="Ankle, in front of the medial malleolus",
    de="Knöchel, vor dem Innenknöchel",
)
BEHIND_LATERAL = Measure(
    name="ankle_lateral_mm",
    usual=8.0,
    within=Within(3, 15),
    en="Ankle, behind the lateral malleolus",
    de="Knöchel, hinter dem Außenknöchel",
)
BEHIND_MEDIAL = Measure(
    name="ankle_medial_mm",
    usual=8.0,
    within=Within(3, 15),
    en="Ankle, behind the medial malleolus",
    de="Knöchel, hinter dem Innenknöchel",
)
WALL_LATERAL = Measure(
    name="wall_lateral_mm",
    usual=30.0,
    within=Within(20, 45),
    en="Side wall, height over the sole, lateral",
    de="Seitenwand, Höhe über der Sohle, lateral",
)
WALL_MEDIAL = Measure(
    name="wall_medial_mm",
    usual=34.0,
    within=Within(20, 45),
    en="Side wall, height over the sole, medial",
    de="Seitenwand, Höhe über der Sohle, medial",
)
WALL_END = Measure(
    name="wall_end_mm",
    usual=8.0,
    within=Within(0, 15),
    en="Wall end, behind the metatarsal heads",
    de="Ende der Wand, hinter den Mittelfußköpfchen",
)
TOE_EDGE = Measure(
    name="toe_edge_mm",
    usual=9.0,
    within=Within(6, 14),
    en="Toe plate, height of its edge over the sole",
    de="Zehenplatte, Randhöhe über der Sohle",
)
_HEEL_PLACE = TrimPoint(name="heel", at="heel", seen_from="posterior", axes="foot")


def _calf(front_deg: float) -> tuple[TrimPoint, ...]:
    """The upper edge from behind to the front corner, and the front edge of the calf."""
    return (
        TrimPoint(
            name="top, lateral behind",
            at="fibula head",
            up_mm="-below_fibula_mm",
            around_deg=125.0,
        ),
        TrimPoint(
            name="top, lateral",
            at="fibula head",
            up_mm=("-below_fibula_mm", -14.0),
            around_deg=front_deg,
        ),
        TrimPoint(
            name="calf, lateral",
            at="fibula head",
            towards="lateral malleolus",
            share=0.45,
            around_deg=front_deg,
        ),
    )


_TOP_BEHIND = TrimPoint(
    name="top, behind", at="fibula head", up_mm="-below_fibula_mm", around_deg=180.0
)
_SHIN = TrimPoint(
    name="shin, lateral",
    at="fibula head",
    towards="lateral malleolus",
    share=0.75,
    around_deg=78.0,
)
_ANKLE = TrimPoint(
    name="ankle, lateral", at="lateral malleolus", ahead_mm="ankle_lateral_mm", seen_from="lateral"
)
_WALL = TrimPoint(
    name="wall, lateral",
    at="heel",
    towards="fifth metatarsal head",
    share=0.68,
    above_sole_mm="wall_lateral_mm",
    axes="foot",
)
_WALL_END = TrimPoint(
    name="wall end, lateral",
    at="fifth metatarsal head",
    ahead_mm="-wall_end_mm",
    above_sole_mm=16.0,
    axes="foot",
)
_TO_TOES = (
    TrimPoint(
        name="toes, lateral",
        at="fifth metatarsal head",
        towards="second toe",
        share=0.6,
        above_sole_mm="toe_edge_mm",
        axes="foot",
    ),
)
_TOES = TrimPoint(
    name="toes", at="second toe", above_sole_mm="toe_edge_mm", axes="foot", seen_from="anterior"
)
_TO_PLATE_END = (
    TrimPoint(
        name="plate end, lateral",
        at="fifth metatarsal head",
        towards="first metatarsal head",
        share=0.22,
        ahead_mm=("-wall_end_mm", -8.0),
        axes="foot",
        seen_from="plantar",
    ),
)
_PLATE_END = TrimPoint(
    name="plate end",
    at="fifth metatarsal head",
    towards="first metatarsal head",
    share=0.5,
    ahead_mm=("-wall_end_mm", -8.0),
    axes="foot",
    seen_from="plantar",
)


def _round(
    behind: TrimPoint, lateral: tuple[TrimPoint, ...], front: TrimPoint
) -> tuple[TrimPoint, ...]:
    """Points from behind along the lateral side to the front, and back on the medial side.

    The top follows the fibula's head on both sides: the upper edge is level.
    """
    return (behind, *lateral, front, *mirrored_points(lateral, _OTHER))


SOLID = Trim(
    loops=(
        Loop(
            name="edge",
            points=_round(
                _TOP_BEHIND,
                (*_calf(72.0), _SHIN, _ANKLE, _WALL, _WALL_END, *_TO_TOES),
                _TOES,
            ),
            keeps=_HEEL_PLACE,
        ),
    ),
    measures=(TOP, ANKLE_LATERAL, ANKLE_MEDIAL, WALL_LATERAL, WALL_MEDIAL, WALL_END, TOE_EDGE),
)

SPRING_WIDTH = Measure(
    name="spring_width_mm",
    usual=34.0,
    within=Within(22, 45),
    en="Narrowest width behind, above the ankle",
    de="Schmalste Breite hinten, über dem Knöchel",
)
SPRING_HEIGHT = Measure(
    name="spring_height_mm",
    usual=30.0,
    within=Within(20, 40),
    en="Height of the narrowest place over the ankle axis",
    de="Höhe der schmalsten Stelle über der Knöchelachse",
)
LEAF_SPRING = Trim(
    loops=(
        Loop(
            name="edge",
            points=_round(
                _TOP_BEHIND,
                (
                    *_calf(90.0),
                    TrimPoint(
                        name="spring, lateral",
                        at="lateral malleolus",
                        towards="medial malleolus",
                        share=0.5,
                        up_mm="spring_height_mm",
                        out_mm="0.5*spring_width_mm",
                        seen_from="posterior",
                    ),
                    TrimPoint(
                        name="ankle, lateral",
                        at="lateral malleolus",
                        ahead_mm="-ankle_lateral_mm",
                        up_mm=-6.0,
                        seen_from="lateral",
                    ),
                    _WALL,
                    _WALL_END,
                    *_TO_PLATE_END,
                ),
                _PLATE_END,
            ),
            keeps=_HEEL_PLACE,
        ),
    ),
    measures=(
        *(TOP, SPRING_WIDTH, SPRING_HEIGHT, BEHIND_LATERAL, BEHIND_MEDIAL),
        *(WALL_LATERAL, WALL_MEDIAL, WALL_END),
    ),
)

JOINT_GAP = Measure(
    name="joint_gap_mm",
    usual=3.0,
    within=Within(1.5, 8),
    en="Edge at the ankle joint, from its axis",
    de="Rand am Knöchelgelenk, von der Achse",
)
EAR = Measure(
    name="ear_mm",
    usual=18.0,
    within=Within(14, 22),
    en="Half width of the ear at the joint",
    de="Halbe Breite der Lasche am Gelenk",
    yields=True,
)
CALF_BELOW = Measure(
    name="above_ankle_mm",
    usual=40.0,
    within=Within(25, 60),
    en="Lower edge of the calf part behind, over the malleolus",
    de="Unterrand des Wadenteils hinten, über dem Knöchel",
)


def _ear(name: str, ahead: Amount, up: Amount) -> TrimPoint:
    return TrimPoint(
        name=name, at="lateral malleolus", ahead_mm=ahead, up_mm=up, seen_from="lateral"
    )


HINGED_CALF = Trim(
    loops=(
        Loop(
            name="edge",
            points=_round(
                _TOP_BEHIND,
                (
                    *_calf(72.0),
                    _SHIN,
                    _ear("ankle, lateral", "ear_mm", ("joint_gap_mm", 16.0)),
                    _ear("joint, lateral", 0.0, "joint_gap_mm"),
                    _ear("below, lateral", "-ear_mm", ("joint_gap_mm", 16.0)),
                ),
                TrimPoint(
                    name="below, behind",
                    at="lateral malleolus",
                    up_mm="above_ankle_mm",
                    around_deg=180.0,
                ),
            ),
            keeps=TrimPoint(
                name="calf",
                at="fibula head",
                towards="lateral malleolus",
                share=0.5,
                around_deg=180.0,
            ),
        ),
    ),
    measures=(TOP, JOINT_GAP, EAR, CALF_BELOW),
)
HINGED_FOOT = Trim(
    loops=(
        Loop(
            name="edge",
            points=_round(
                TrimPoint(
                    name="heel, behind", at="lateral malleolus", up_mm=-20.0, around_deg=180.0
                ),
                (
                    _ear("below, lateral", "-ear_mm", ("-joint_gap_mm", -10.0)),
                    _ear("joint, lateral", 0.0, "-joint_gap_mm"),
                    _ear("ankle, lateral", "ear_mm", ("-joint_gap_mm", -8.0)),
                    _WALL,
                    _WALL_END,
                    *_TO_TOES,
                ),
                _TOES,
            ),
            keeps=_HEEL_PLACE,
        ),
    ),
    measures=(JOINT_GAP, EAR, WALL_LATERAL, WALL_MEDIAL, WALL_END, TOE_EDGE),
)

FRONT_TOP = Measure(
    name="over_tubercle_mm",
    usual=8.0,
    within=Within(0, 15),
    en="Upper edge in front, over the tibial tubercle",
    de="Oberer Rand vorn, über dem Schienbeinhöcker",
)
BACK_BELOW = Measure(
    name="back_below_mm",
    usual=90.0,
    within=Within(60, 130),
    en="Upper edge behind, below the fibula head",
    de="Oberer Rand hinten, unter dem Wadenbeinköpfchen",
)
FRONT_SHELL = Measure(
    name="shell_below_mm",
    usual=110.0,
    within=Within(80, 140),
    en="Lower edge of the front shell, below the tibial tubercle",
    de="Unterrand der Vorderschale, unter dem Schienbeinhöcker",
)
_OPENING_LATERAL = (
    TrimPoint(
        name="shin, lateral",
        at="tibial tubercle",
        up_mm=("-shell_below_mm", -12.0),
        around_deg=62.0,
    ),
    _ANKLE,
    _WALL,
    _WALL_END,
    *_TO_TOES,
)
GROUND_REACTION = Trim(
    loops=(
        Loop(
            name="upper edge",
            points=_round(
                TrimPoint(
                    name="top, behind", at="fibula head", up_mm="-back_below_mm", around_deg=180.0
                ),
                (
                    TrimPoint(
                        name="top, lateral behind",
                        at="fibula head",
                        up_mm=("-0.75*back_below_mm", -6.0),
                        around_deg=130.0,
                    ),
                    TrimPoint(
                        name="top, lateral",
                        at="fibula head",
                        up_mm="-below_fibula_mm",
                        around_deg=80.0,
                    ),
                ),
                TrimPoint(
                    name="top, front",
                    at="tibial tubercle",
                    up_mm="over_tubercle_mm",
                    around_deg=0.0,
                ),
            ),
            keeps=_HEEL_PLACE,
        ),
        Loop(
            name="front opening",
            points=_round(
                TrimPoint(
                    name="shell, below",
                    at="tibial tubercle",
                    up_mm="-shell_below_mm",
                    around_deg=0.0,
                ),
                _OPENING_LATERAL,
                _TOES,
            ),
            keeps=_HEEL_PLACE,
        ),
    ),
    measures=(
        *(FRONT_TOP, TOP, BACK_BELOW, FRONT_SHELL, ANKLE_LATERAL, ANKLE_MEDIAL),
        *(WALL_LATERAL, WALL_MEDIAL, WALL_END, TOE_EDGE),
    ),
)

SMO_TOP = Measure(
    name="above_malleoli_mm",
    usual=30.0,
    within=Within(20, 40),
    en="Upper edge, over the malleoli",
    de="Oberer Rand, über den Knöcheln",
)
SMO_LATERAL = Measure(
    name="ankle_lateral_mm",
    usual=18.0,
    within=Within(14, 24),
    en="Front edge, in front of the lateral malleolus",
    de="Vorderrand, vor dem Außenknöchel",
)
SMO_MEDIAL = Measure(
    name="ankle_medial_mm",
    usual=18.0,
    within=Within(14, 24),
    en="Front edge, in front of the medial malleolus",
    de="Vorderrand, vor dem Innenknöchel",
)
SUPRAMALLEOLAR = Trim(
    loops=(
        Loop(
            name="edge",
            points=_round(
                TrimPoint(
                    name="top, behind",
                    at="lateral malleolus",
                    up_mm="above_malleoli_mm",
                    around_deg=180.0,
                ),
                (
                    TrimPoint(
                        name="top, lateral",
                        at="lateral malleolus",
                        up_mm="above_malleoli_mm",
                        around_deg=95.0,
                    ),
                    TrimPoint(
                        name="ankle, lateral",
                        at="lateral malleolus",
                        ahead_mm="ankle_lateral_mm",
                        up_mm=4.0,
                        seen_from="lateral",
                    ),
                    _WALL,
                    _WALL_END,
                    *_TO_PLATE_END,
                ),
                _PLATE_END,
            ),
            keeps=_HEEL_PLACE,
        ),
    ),
    measures=(SMO_TOP, SMO_LATERAL, SMO_MEDIAL, WALL_LATERAL, WALL_MEDIAL, WALL_END),
)

CUP = Measure(
    name="cup_mm",
    usual=30.0,
    within=Within(25, 35),
    en="Heel cup, height over the sole",
    de="Fersenschale, Höhe über der Sohle",
)
UCBL_LATERAL = Measure(
    name="wall_lateral_mm",
    usual=24.0,
    within=Within(18, 32),
    en="Side wall, height over the sole, lateral",
    de="Seitenwand, Höhe über der Sohle, lateral",
)
UCBL_MEDIAL = Measure(
    name="wall_medial_mm",
    usual=32.0,
    within=Within(22, 44),
    en="Side wall, height over the sole, medial, over the navicular",
    de="Seitenwand, Höhe über der Sohle, medial, über dem Kahnbein",
)


def _insole(measures: tuple[Measure, ...]) -> Trim:
    """A heel cup with side walls that ends behind the metatarsal heads."""
    return Trim(
        loops=(
            Loop(
                name="edge",
                points=_round(
                    TrimPoint(
                        name="heel, behind",
                        at="heel",
                        above_sole_mm="cup_mm",
                        axes="foot",
                        seen_from="posterior",
                    ),
                    (
                        TrimPoint(
                            name="heel, lateral",
                            at="heel",
                            towards="fifth metatarsal head",
                            share=0.25,
                            above_sole_mm="cup_mm",
                            axes="foot",
                        ),
                        TrimPoint(
                            name="wall, lateral",
                            at="heel",
                            towards="fifth metatarsal head",
                            share=0.6,
                            above_sole_mm="wall_lateral_mm",
                            axes="foot",
                        ),
                        TrimPoint(
                            name="wall end, lateral",
                            at="fifth metatarsal head",
                            ahead_mm=("-wall_end_mm", -4.0),
                            above_sole_mm=("0.25*wall_lateral_mm", 4.0),
                            axes="foot",
                        ),
                        *_TO_PLATE_END,
                    ),
                    _PLATE_END,
                ),
                keeps=TrimPoint(
                    name="sole", at="heel", ahead_mm=30.0, axes="foot", seen_from="plantar"
                ),
            ),
        ),
        measures=measures,
    )


UCBL = _insole((CUP, UCBL_LATERAL, UCBL_MEDIAL, WALL_END))

INSOLE = _insole(
    (
        Measure(
            name="cup_mm",
            usual=14.0,
            within=Within(10, 25),
            en="Heel cup, height over the sole",
            de="Fersenschale, Höhe über der Sohle",
        ),
        Measure(
            name="wall_lateral_mm",
            usual=12.0,
            within=Within(8, 18),
            en="Lateral flange, height over the sole",
            de="Lateraler Rand, Höhe über der Sohle",
        ),
        Measure(
            name="wall_medial_mm",
            usual=18.0,
            within=Within(10, 28),
            en="Medial flange, height over the sole",
            de="Medialer Rand, Höhe über der Sohle",
        ),
        WALL_END,
    ),
)
