"""Trunk: a torso for a spinal orthosis.

Sensitive places: EPUAP, NPIAP, PPPIA, Prevention and Treatment of Pressure Ulcers/Injuries (2019):
bony prominences; axillae for the vessels and nerves that run through them.

Directions: the trunk's axis from sacrum to seventh cervical vertebra, and to the patient's right
along the iliac spines, square to it. Lengths of the sheet count along the trunk's axis from the
waist.

Its sections follow no bent centreline. Forms of the trade take girths and widths at levels told
from the waist (oandpacademy.com), and a brace's counter-rotation works square to the transverse
plane (M. Rigo, 2017, doi 10.1186/s13013-017-0114-2), so that rotation by level is that of a level
section. Square to a curved spine, a girth would change with the side bend alone. Build-ups are
general trade knowledge, without a source.
"""

from dataclasses import replace

from limbgram.workbench.anatomy.kind import (
    Angle,
    Cross,
    Distance,
    Joint,
    Kind,
    Line,
    Midpoint,
    Place,
    Section,
    SensitivePlace,
    Square,
)
from limbgram.workbench.kinds.transfemoral import GLUTEAL_FOLD, ILIAC_CREST

SEVENTH_CERVICAL_VERTEBRA = Place(
    "seventh cervical vertebra",
    en=("c7", "vertebra prominens"),
    de=("siebter Halswirbel", "7. Halswirbel", "HWK 7", "Prominens"),
    facing="posterior",
    level=6,
)
STERNAL_NOTCH = Place(
    "sternal notch",
    en=("suprasternal notch", "jugular notch"),
    de=("Drosselgrube", "Jugulum", "Incisura jugularis"),
    facing="anterior",
    level=6,
)
AXILLA = Place("axilla", en=("armpit",), de=("Achsel", "Achselhöhle"))
RIGHT_AXILLA = Place(
    "right axilla",
    en=("right armpit",),
    de=("rechte Achsel", "Achsel rechts", "rechte Achselhöhle"),
    facing="right",
    level=5,
)
LEFT_AXILLA = Place(
    "left axilla",
    en=("left armpit",),
    de=("linke Achsel", "Achsel links", "linke Achselhöhle"),
    facing="left",
    level=5,
)
XIPHOID = Place(
    "xiphoid",
    en=("xiphoid process",),
    de=("Schwertfortsatz", "Processus xiphoideus"),
    facing="anterior",
    level=4,
)
NAVEL = Place(
    "navel",
    en=("umbilicus", "belly button"),
    de=("Nabel", "Bauchnabel"),
    facing="anterior",
    level=3,
)
RIGHT_ILIAC_SPINE = Place(
    "right iliac spine",
    en=("right asis",),
    de=("rechter Darmbeinstachel", "Darmbeinstachel rechts", "SIAS rechts"),
    facing="anterior",
    half="right",
    level=2,
)
LEFT_ILIAC_SPINE = Place(
    "left iliac spine",
    en=("left asis",),
    de=("linker Darmbeinstachel", "Darmbeinstachel links", "SIAS links"),
    facing="anterior",
    half="left",
    level=2,
)
SACRUM = Place("sacrum", de=("Kreuzbein",), facing="posterior", level=2)
RIGHT_TROCHANTER = Place(
    "right trochanter",
    en=("right greater trochanter",),
    de=("rechter Rollhügel", "Rollhügel rechts", "Trochanter rechts"),
    facing="right",
    level=1,
)
LEFT_TROCHANTER = Place(
    "left trochanter",
    en=("left greater trochanter",),
    de=("linker Rollhügel", "Rollhügel links", "Trochanter links"),
    facing="left",
    level=1,
)
PUBIC_SYMPHYSIS = Place(
    "pubic symphysis",
    en=("symphysis",),
    de=("Schambeinfuge", "Symphyse"),
    facing="anterior",
    level=1,
)
FIRST_THORACIC_VERTEBRA = Place(
    "first thoracic vertebra",
    en=("t1",),
    de=("erster Brustwirbel", "1. Brustwirbel", "BWK 1"),
    facing="posterior",
)
SEVENTH_THORACIC_VERTEBRA = Place(
    "seventh thoracic vertebra",
    en=("t7",),
    de=("siebter Brustwirbel", "7. Brustwirbel", "BWK 7"),
    facing="posterior",
)
TWELFTH_THORACIC_VERTEBRA = Place(
    "twelfth thoracic vertebra",
    en=("t12",),
    de=("zwölfter Brustwirbel", "12. Brustwirbel", "BWK 12"),
    facing="posterior",
    level=4,
)
THIRD_LUMBAR_VERTEBRA = Place(
    "third lumbar vertebra",
    en=("l3",),
    de=("dritter Lendenwirbel", "3. Lendenwirbel", "LWK 3"),
    facing="posterior",
    level=3,
)
RIGHT_SCAPULAR_SPINE = Place(
    "right scapular spine",
    en=("right spine of the scapula",),
    de=("rechte Schulterblattgräte", "Schulterblattgräte rechts"),
    facing="posterior",
    half="right",
)
LEFT_SCAPULAR_SPINE = Place(
    "left scapular spine",
    en=("left spine of the scapula",),
    de=("linke Schulterblattgräte", "Schulterblattgräte links"),
    facing="posterior",
    half="left",
)
RIGHT_INFERIOR_ANGLE = Place(
    "right inferior angle",
    en=("right inferior angle of the scapula",),
    de=("rechter unterer Schulterblattwinkel", "unterer Schulterblattwinkel rechts"),
    facing="posterior",
    half="right",
)
LEFT_INFERIOR_ANGLE = Place(
    "left inferior angle",
    en=("left inferior angle of the scapula",),
    de=("linker unterer Schulterblattwinkel", "unterer Schulterblattwinkel links"),
    facing="posterior",
    half="left",
)
RIGHT_NIPPLE = Place(
    "right nipple", de=("rechte Brustwarze", "Brustwarze rechts"), facing="anterior", half="right"
)
LEFT_NIPPLE = Place(
    "left nipple", de=("linke Brustwarze", "Brustwarze links"), facing="anterior", half="left"
)
RIGHT_WAIST = Place(
    "right waist",
    en=("waist right",),
    de=("rechte Taille", "Taille rechts"),
    facing="right",
    level=3,
)
LEFT_WAIST = Place(
    "left waist", en=("waist left",), de=("linke Taille", "Taille links"), facing="left", level=3
)
RIGHT_INFRAMAMMARY_FOLD = Place(
    "right inframammary fold",
    en=("right fold under the breast", "under the right breast"),
    de=("rechte Unterbrustfalte", "Unterbrustfalte rechts", "Brustumschlagfalte rechts"),
    facing="anterior",
    half="right",
)
LEFT_INFRAMAMMARY_FOLD = Place(
    "left inframammary fold",
    en=("left fold under the breast", "under the left breast"),
    de=("linke Unterbrustfalte", "Unterbrustfalte links", "Brustumschlagfalte links"),
    facing="anterior",
    half="left",
)
RIGHT_ILIAC_CREST = Place(
    "right iliac crest", de=("rechter Beckenkamm", "Beckenkamm rechts"), facing="right"
)
LEFT_ILIAC_CREST = Place(
    "left iliac crest", de=("linker Beckenkamm", "Beckenkamm links"), facing="left"
)
RIGHT_TENTH_RIB = Place(
    "right tenth rib",
    en=("right rib 10",),
    de=("rechte zehnte Rippe", "zehnte Rippe rechts", "10. Rippe rechts"),
    facing="right",
)
LEFT_TENTH_RIB = Place(
    "left tenth rib",
    en=("left rib 10",),
    de=("linke zehnte Rippe", "zehnte Rippe links", "10. Rippe links"),
    facing="left",
)
COCCYX = Place("coccyx", en=("tailbone",), de=("Steißbein",), facing="posterior", level=1)

_AXILLAE = Midpoint(("right axilla", "left axilla"))
_WAIST = Midpoint(("right waist", "left waist"), otherwise=("navel",))
_ASIS = Midpoint(("right iliac spine", "left iliac spine"))
_TROCHANTERS = Midpoint(("right trochanter", "left trochanter"))
_L3 = Midpoint(("third lumbar vertebra",))
_SACRUM, _C7 = Midpoint(("sacrum",)), Midpoint(("seventh cervical vertebra",))


def _levels(name: str, en: str, de: str, at: Midpoint) -> tuple[Section, ...]:
    """What forms ask of a level: girth, widths, how far it is turned, and its two halves."""
    across = Section(name="", en="", de="", at=at, normal="trunk", along="to the right")
    halves = "the plane through sacrum and C7, square to the iliac spines, parts the halves"
    return (
        replace(across, name=f"{name}_girth_mm", en=f"Girth: {en}", de=f"Umfang: {de}", along=""),
        replace(
            across,
            name=f"{name}_ml_mm",
            en=f"Width side to side: {en}",
            de=f"Breite seitlich: {de}",
            what="width",
        ),
        replace(
            across,
            name=f"{name}_ap_mm",
            en=f"Depth front to back: {en}",
            de=f"Tiefe von vorn nach hinten: {de}",
            what="width",
            along="forward",
        ),
        replace(
            across,
            name=f"{name}_rotation_deg",
            en=f"Rotation of the section against the iliac spines: {en}",
            de=f"Drehung des Querschnitts zu den Darmbeinstacheln: {de}",
            what="turn",
            note="the section's longest principal axis; right side forward is positive",
        ),
        replace(
            across,
            name=f"{name}_right_half_cm2",
            en=f"Area of the right half: {en}",
            de=f"Fläche der rechten Hälfte: {de}",
            what="half along",
            parted=_SACRUM,
            note=halves,
        ),
        replace(
            across,
            name=f"{name}_left_half_cm2",
            en=f"Area of the left half: {en}",
            de=f"Fläche der linken Hälfte: {de}",
            what="half against",
            parted=_SACRUM,
            note=halves,
        ),
    )


KIND = Kind(
    name="torso",
    order=4,
    words={"en": "Trunk", "de": "Rumpf"},
    sided=False,
    places=(
        SEVENTH_CERVICAL_VERTEBRA,
        STERNAL_NOTCH,
        RIGHT_AXILLA,
        LEFT_AXILLA,
        XIPHOID,
        TWELFTH_THORACIC_VERTEBRA,
        RIGHT_WAIST,
        LEFT_WAIST,
        NAVEL,
        THIRD_LUMBAR_VERTEBRA,
        RIGHT_ILIAC_SPINE,
        LEFT_ILIAC_SPINE,
        SACRUM,
        RIGHT_TROCHANTER,
        LEFT_TROCHANTER,
        PUBIC_SYMPHYSIS,
        COCCYX,
        AXILLA,
        FIRST_THORACIC_VERTEBRA,
        SEVENTH_THORACIC_VERTEBRA,
        RIGHT_SCAPULAR_SPINE,
        LEFT_SCAPULAR_SPINE,
        RIGHT_INFERIOR_ANGLE,
        LEFT_INFERIOR_ANGLE,
        RIGHT_NIPPLE,
        LEFT_NIPPLE,
        RIGHT_INFRAMAMMARY_FOLD,
        LEFT_INFRAMAMMARY_FOLD,
        RIGHT_ILIAC_CREST,
        LEFT_ILIAC_CREST,
        RIGHT_TENTH_RIB,
        LEFT_TENTH_RIB,
        ILIAC_CREST,
        GLUTEAL_FOLD,
    ),
    sensitive=(
        SensitivePlace(name="seventh cervical vertebra", why="bone under the skin", reach_mm=10.0),
        SensitivePlace(name="sternal notch", why="windpipe and bone under the skin", reach_mm=10.0),
        SensitivePlace(
            name="right axilla",
            why="vessels and nerves of the arm",
            reach_mm=15.0,
            also=("axilla",),
        ),
        SensitivePlace(name="left axilla", why="vessels and nerves of the arm", reach_mm=15.0),
        SensitivePlace(name="xiphoid", why="thin bone under the skin", reach_mm=10.0),
        SensitivePlace(
            name="right iliac spine",
            why="bone under the skin",
            reach_mm=12.0,
            also=("iliac crest", "right iliac crest"),
        ),
        SensitivePlace(
            name="left iliac spine",
            why="bone under the skin",
            reach_mm=12.0,
            also=("left iliac crest",),
        ),
        SensitivePlace(name="sacrum", why="bone under the skin", reach_mm=12.0, also=("coccyx",)),
        SensitivePlace(name="right trochanter", why="bone under the skin", reach_mm=15.0),
        SensitivePlace(name="left trochanter", why="bone under the skin", reach_mm=15.0),
        SensitivePlace(name="pubic symphysis", why="bone under the skin", reach_mm=12.0),
    ),
    directions=(
        Line(name="trunk", start=_SACRUM, end=_C7),
        Line(
            name="iliac spines",
            start=Midpoint(("left iliac spine",)),
            end=Midpoint(("right iliac spine",)),
        ),
        Square(name="to the right", of="iliac spines", to="trunk"),
        Line(name="pelvis forward", start=_SACRUM, end=_ASIS),
        Line(name="axillae", start=Midpoint(("left axilla",)), end=Midpoint(("right axilla",))),
        Cross(name="forward", first="trunk", second="to the right"),
        Line(name="lower back", start=_SACRUM, end=Midpoint(("third lumbar vertebra",))),
        Line(name="chest", start=_L3, end=_C7),
        Line(
            name="upper back",
            start=Midpoint(("third lumbar vertebra",)),
            end=Midpoint(("twelfth thoracic vertebra",)),
        ),
    ),
    sheet=(
        Angle(
            name="shoulder_to_pelvis_rotation_deg",
            en="Rotation of the axillae against the iliac spines, right side forward positive",
            de="Drehung der Achseln gegen die Darmbeinstacheln, rechts nach vorn positiv",
            of="iliac spines",
            to="axillae",
            about="trunk",
        ),
        Angle(
            name="lordosis_deg",
            en="Lordosis of the back's surface, T12 to L3 to sacrum",
            de="Lordose der Rückenfläche, BWK 12 über LWK 3 zum Kreuzbein",
            of="lower back",
            to="upper back",
            about="to the right",
        ),
        Angle(
            name="side_bend_deg",
            en="Side bend, L3 to C7 against the line of the iliac spines, to the right positive",
            de="Seitneigung, LWK 3 bis HWK 7 gegen die Linie der Darmbeinstacheln, nach rechts "
            "positiv",
            of="iliac spines",
            to="chest",
            about="pelvis forward",
            zero_deg=-90.0,
        ),
        Distance(
            name="plumb_right_mm",
            en="C7 beside the sacrum, to the right",
            de="HWK 7 neben dem Kreuzbein, nach rechts",
            start=_SACRUM,
            end=_C7,
            along="right",
            note="square to the limb frame; to the plumb line, if it was aligned as it stood",
        ),
        Distance(
            name="plumb_forward_mm",
            en="C7 in front of the sacrum",
            de="HWK 7 vor dem Kreuzbein",
            start=_SACRUM,
            end=_C7,
            along="anterior",
            note="as plumb_right_mm",
        ),
        *_levels("axilla", "axilla", "Achselhöhe", _AXILLAE),
        Section(
            name="breast_girth_mm",
            en="Girth: breast, at the nipples",
            de="Umfang: Brust, Höhe der Brustwarzen",
            at=Midpoint(("right nipple", "left nipple")),
            normal="trunk",
        ),
        Section(
            name="under_breast_girth_mm",
            en="Girth: under the breast",
            de="Umfang: Unterbrust",
            at=Midpoint(("right inframammary fold", "left inframammary fold")),
            normal="trunk",
        ),
        *_levels("xiphoid", "xiphoid", "Schwertfortsatz", Midpoint(("xiphoid",))),
        *_levels("waist", "waist", "Taille", _WAIST),
        *_levels("asis", "iliac spines", "Darmbeinstacheln", _ASIS),
        *_levels("trochanter", "trochanters", "Rollhügel", _TROCHANTERS),
        Distance(
            name="waist_to_sternal_notch_mm",
            en="Waist up to the sternal notch",
            de="Taille bis Drosselgrube",
            start=_WAIST,
            end=Midpoint(("sternal notch",)),
            along="trunk",
        ),
        Distance(
            name="waist_to_nipple_mm",
            en="Waist up to the nipple line",
            de="Taille bis Brustwarzenlinie",
            start=_WAIST,
            end=Midpoint(("right nipple", "left nipple")),
            along="trunk",
        ),
        Distance(
            name="waist_to_xiphoid_mm",
            en="Waist up to the xiphoid",
            de="Taille bis Schwertfortsatz",
            start=_WAIST,
            end=Midpoint(("xiphoid",)),
            along="trunk",
        ),
        Distance(
            name="waist_to_scapular_spine_mm",
            en="Waist up to the scapular spine",
            de="Taille bis Schulterblattgräte",
            start=_WAIST,
            end=Midpoint(("right scapular spine", "left scapular spine")),
            along="trunk",
        ),
        Distance(
            name="waist_to_inferior_angle_mm",
            en="Waist up to the inferior angle of the scapula",
            de="Taille bis zum unteren Schulterblattwinkel",
            start=_WAIST,
            end=Midpoint(("right inferior angle", "left inferior angle")),
            along="trunk",
        ),
        Distance(
            name="waist_to_axilla_mm",
            en="Waist up to the axilla",
            de="Taille bis Achsel",
            start=_WAIST,
            end=_AXILLAE,
            along="trunk",
        ),
        Distance(
            name="waist_to_asis_mm",
            en="Waist down to the iliac spines",
            de="Taille bis Darmbeinstacheln",
            start=_ASIS,
            end=_WAIST,
            along="trunk",
        ),
        Distance(
            name="waist_to_pubis_mm",
            en="Waist down to the pubis",
            de="Taille bis Schambeinfuge",
            start=Midpoint(("pubic symphysis",)),
            end=_WAIST,
            along="trunk",
        ),
        Distance(
            name="waist_to_trochanter_mm",
            en="Waist down to the trochanters",
            de="Taille bis Rollhügel",
            start=_TROCHANTERS,
            end=_WAIST,
            along="trunk",
        ),
        Distance(
            name="waist_to_coccyx_mm",
            en="Waist down to the coccyx",
            de="Taille bis Steißbein",
            start=Midpoint(("coccyx",)),
            end=_WAIST,
            along="trunk",
        ),
        Distance(
            name="waist_to_gluteal_fold_mm",
            en="Waist down to the gluteal fold",
            de="Taille bis Gesäßfalte",
            start=Midpoint(("gluteal fold",)),
            end=_WAIST,
            along="trunk",
        ),
    ),
    joints=(
        Joint(
            name="side bend",
            de="Seitneigung",
            sense={"en": "at L3, to the right positive", "de": "bei LWK 3, nach rechts positiv"},
            axis="pelvis forward",
            reads="side_bend_deg",
            centre=_L3,
            upper=_SACRUM,
            lower=_C7,
        ),
        Joint(
            name="extension",
            de="Extension",
            sense={"en": "at L3, backwards positive", "de": "bei LWK 3, nach hinten positiv"},
            axis="iliac spines",
            reads="lordosis_deg",
            centre=_L3,
            upper=_SACRUM,
            lower=_C7,
        ),
    ),
    presets={
        "right iliac spine": 6.0,
        "left iliac spine": 6.0,
        "right iliac crest": 6.0,
        "left iliac crest": 6.0,
        "right tenth rib": 5.0,
        "left tenth rib": 5.0,
        "right inferior angle": 5.0,
        "left inferior angle": 5.0,
    },
)
