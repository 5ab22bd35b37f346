"""Transfemoral: a residual limb above the knee.

Sensitive places: C. M. Schuch, Atlas of Limb Prosthetics ch. 20B; E. Neumann et al., J Prosthet
Orthot 17(1), 2005, found the peaks at ischium, adductor longus tendon and in Scarpa's triangle. The
ischial tuberosity is no place of this list: it is meant to bear.
"""

from limbgram.workbench.anatomy.kind import (
    Distance,
    Kind,
    Line,
    Midpoint,
    Place,
    Section,
    SensitivePlace,
)
from limbgram.workbench.kinds.transtibial import DISTAL_END

ANTERIOR_SUPERIOR_ILIAC_SPINE = Place(
    "anterior superior iliac spine",
    en=("asis", "iliac spine"),
    de=(
        "vorderer oberer Darmbeinstachel",
        "Darmbeinstachel",
        "Spina iliaca anterior superior",
        "SIAS",
    ),
    facing="anterior",
    level=5,
)
ILIAC_CREST = Place("iliac crest", de=("Beckenkamm", "Darmbeinkamm", "Crista iliaca"))
GREATER_TROCHANTER = Place(
    "greater trochanter",
    en=("trochanter", "trochanter major"),
    de=("großer Rollhügel", "Rollhügel", "Trochanter major"),
    facing="lateral",
    level=4,
)
ISCHIAL_TUBEROSITY = Place(
    "ischial tuberosity",
    en=("ischium", "sit bone"),
    de=("Sitzbein", "Sitzbeinhöcker", "Tuber ischiadicum", "Sitzbeinknorren"),
    facing="posterior",
    level=3,
)
ADDUCTOR_LONGUS_TENDON = Place(
    "adductor longus tendon",
    en=("adductor tendon", "adductor longus"),
    de=(
        "Sehne des langen Anziehers",
        "Adduktorensehne",
        "Adduktorenstrang",
        "Adductor-longus-Sehne",
        "Adduktor-longus-Sehne",
    ),
    facing="medial",
    level=3,
)
PERINEUM = Place("perineum", en=("crotch",), de=("Damm", "Schritt"), facing="medial", level=3)
PUBIC_RAMUS = Place(
    "pubic ramus",
    en=("pubis", "ischiopubic ramus"),
    de=("Schambeinast", "Schambein", "Ramus", "Ramus ossis ischii", "Sitzbeinast"),
)
FEMUR_END = Place(
    "femur end",
    en=("distal femur", "end of femur", "end of the femur"),
    de=(
        "Oberschenkelknochenende",
        "Femurende",
        "distaler Femur",
        "distales Femurende",
        "Femurstumpf",
        "Femurstumpfende",
    ),
    level=1,
)
GLUTEAL_FOLD = Place("gluteal fold", en=("gluteal crease",), de=("Gesäßfalte", "Glutealfalte"))

KIND = Kind(
    name="transfemoral",
    order=2,
    words={"en": "Transfemoral", "de": "Oberschenkel"},
    sided=True,
    round_ended=True,
    places=(
        ANTERIOR_SUPERIOR_ILIAC_SPINE,
        GREATER_TROCHANTER,
        ISCHIAL_TUBEROSITY,
        ADDUCTOR_LONGUS_TENDON,
        PERINEUM,
        FEMUR_END,
        DISTAL_END.at(0),
        ILIAC_CREST,
        PUBIC_RAMUS,
        GLUTEAL_FOLD,
    ),
    sensitive=(
        SensitivePlace(
            name="anterior superior iliac spine",
            why="bone under the skin",
            reach_mm=12.0,
            also=("right iliac spine", "left iliac spine", "iliac crest"),
        ),
        SensitivePlace(name="greater trochanter", why="bone under the skin", reach_mm=15.0),
        SensitivePlace(name="adductor longus tendon", why="tendon under the skin", reach_mm=10.0),
        SensitivePlace(name="perineum", why="soft tissue that bears no pressure", reach_mm=15.0),
        SensitivePlace(name="pubic ramus", why="bone under the skin", reach_mm=12.0),
        SensitivePlace(name="femur end", why="cut end of bone", reach_mm=15.0),
    ),
    directions=(
        Line(
            name="femur",
            start=Midpoint(("femur end",), otherwise=("distal end",)),
            end=Midpoint(("greater trochanter",)),
        ),
    ),
    sheet=(
        Distance(
            name="ischium_to_end_mm",
            en="Ischium to the distal end, along the axis",
            de="Sitzbein bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("ischial tuberosity",)),
            along="long axis",
        ),
        Distance(
            name="trochanter_to_femur_end_mm",
            en="Greater trochanter to the end of the femur",
            de="Großer Rollhügel bis Femurende",
            start=Midpoint(("femur end",)),
            end=Midpoint(("greater trochanter",)),
        ),
        Distance(
            name="perineum_to_end_mm",
            en="Perineum to the distal end, along the axis",
            de="Schritt bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("perineum",)),
            along="long axis",
        ),
        Section(
            name="perineum_girth_mm",
            en="Girth at the perineum",
            de="Umfang in Schritthöhe",
            at=Midpoint(("perineum",)),
            normal="long axis",
        ),
    ),
)
