"""Transtibial: a residual limb below the knee.

Sensitive places: S. Kapp, D. Cummings, Atlas of Limb Prosthetics (2nd ed. 1992) ch. 18B, and the
tradition since C. Radcliffe, J. Foort, The Patellar-Tendon-Bearing Below-Knee Prosthesis (1961):
tibial crest and tubercle, distal tibia, fibular head, distal fibula and hamstring tendons bear
little; the patellar tendon, the medial tibial flare, the popliteal area and the muscles beside the
tibia bear. W. Lee, M. Zhang, A. Mak, Arch Phys Med Rehabil 86(4), 2005: pain is tolerated least
over the fibular head and the distal ends, most over the patellar tendon. C. Epps, J. Hile,
Inter-Clinic Inf Bull 3(11), 1964: before casting are marked patella, tubercle, fibular head and
crest, bone spurs, adherent scars and neuromas. G. Nehme, S. Ghalambor, J Prosthet Orthot 26(4),
2014: relief areas. Reaches are the rounded half width of the bone under the skin, general trade
knowledge; those of the peroneal nerve: W. Ryan et al., Clin Anat 16(6), 2003: 32 +- 10 mm from the
apex of the fibular head it enters its tunnel on the fibula's neck; C. Thi et al., Int J Morphol
Physiol 6(1), 2018: its deep branch leaves 26 mm (19 to 38) from it.

Build-ups give room over what bears little; their heights are general trade knowledge, without a
source. What bears, such as the patellar tendon, is carved in by edits of its own.
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

MID_PATELLA = Place(
    "mid patella",
    en=("patella", "kneecap", "middle of the patella"),
    de=(
        "Mitte der Kniescheibe",
        "Kniescheibe",
        "Kniescheibenmitte",
        "Patellamitte",
        "Patella Mitte",
        "Mitte Patella",
    ),
    facing="anterior",
    level=5,
)
PATELLAR_TENDON = Place(
    "patellar tendon",
    en=(
        "patellar tendon bar",
        "patella tendon",
        "patella tendon bar",
        "patellar ligament",
        "mpt",
        "mid patellar tendon",
        "ptb",
    ),
    de=("Patellasehne", "Kniescheibensehne", "Kniescheibenband", "Patellaband"),
    facing="anterior",
    level=4,
)
MEDIAL_TIBIAL_CONDYLE = Place(
    "medial tibial condyle",
    en=("medial tibial plateau",),
    de=(
        "innerer Schienbeinkopf",
        "medialer Tibiakondylus",
        "Condylus medialis tibiae",
        "mediales Tibiaplateau",
        "medialer Schienbeinkopf",
    ),
    facing="medial",
    level=4,
)
MEDIAL_TIBIAL_FLARE = Place(
    "medial tibial flare",
    en=("medial flare",),
    de=("innere Schienbeinfläche", "mediale Tibiafläche", "Tibiaflanke medial"),
)
LATERAL_TIBIAL_CONDYLE = Place(
    "lateral tibial condyle",
    en=("lateral tibial plateau",),
    de=(
        "äußerer Schienbeinkopf",
        "lateraler Tibiakondylus",
        "Condylus lateralis tibiae",
        "laterales Tibiaplateau",
        "lateraler Schienbeinkopf",
    ),
)
POPLITEAL_CREASE = Place(
    "popliteal crease",
    en=("popliteal area", "popliteal fossa", "popliteal"),
    de=("Kniekehlenfalte", "Kniekehle", "Fossa poplitea"),
    facing="posterior",
    level=4,
)
TIBIAL_TUBERCLE = Place(
    "tibial tubercle",
    en=("tibial tuberosity", "tuberosity of the tibia"),
    de=(
        "Schienbeinhöcker",
        "Tuberositas tibiae",
        "Tuberositas",
        "Tibiahöcker",
        "Schienbeinrauigkeit",
    ),
    facing="anterior",
    level=3,
)
FIBULA_HEAD = Place(
    "fibula head",
    en=(
        "fibular head",
        "head of fibula",
        "head of the fibula",
        "fib",
        "fib head",
        "apex of the fibula",
    ),
    de=(
        "Wadenbeinköpfchen",
        "Fibulakopf",
        "Fibulaköpfchen",
        "Wadenbeinkopf",
        "Caput fibulae",
        "Fibulakopfspitze",
        "Fibulaspitze",
    ),
    facing="lateral",
    level=3,
)
FIBULA_NECK = Place(
    "fibula neck",
    en=("fibular neck", "neck of the fibula"),
    de=("Wadenbeinhals", "Fibulahals", "Collum fibulae"),
)
PERONEAL_NERVE = Place(
    "peroneal nerve",
    en=("common peroneal nerve", "common fibular nerve"),
    de=(
        "Wadenbeinnerv",
        "Nervus peroneus",
        "Nervus fibularis",
        "Peroneusnerv",
        "Nervus peroneus communis",
        "Nervus fibularis communis",
        "N. peroneus",
    ),
)
TIBIAL_CREST = Place(
    "tibial crest",
    en=("crest of the tibia", "shin", "tib", "anterior tibia"),
    de=(
        "Schienbeinkante",
        "Tibiakante",
        "Tibiavorderkante",
        "Crista tibiae",
        "Schienbeinvorderkante",
        "Margo anterior tibiae",
        "Tibiakamm",
    ),
    facing="anterior",
    level=2,
)
FIBULA_END = Place(
    "fibula end",
    en=("distal fibula", "end of fibula", "end of the fibula"),
    de=(
        "Wadenbeinende",
        "Fibulaende",
        "distale Fibula",
        "distales Fibulaende",
        "Fibulastumpf",
        "Fibulastumpfende",
        "Wadenbeinstumpf",
    ),
    facing="lateral",
    level=1,
)
TIBIA_END = Place(
    "tibia end",
    en=("te", "distal tibia", "end of tibia", "end of the tibia"),
    de=(
        "Schienbeinende",
        "Tibiaende",
        "distale Tibia",
        "distales Tibiaende",
        "Tibiastumpf",
        "Tibiastumpfende",
        "Schienbeinstumpf",
    ),
    facing="anterior",
    level=1,
)
DISTAL_END = Place(
    "distal end",
    en=("end of the stump", "end of the limb"),
    de=("distales Ende", "Stumpfende", "Stumpfspitze"),
    level=0,
)
HAMSTRING_TENDON = Place(
    "hamstring tendon",
    en=("hamstrings", "hamstring"),
    de=("Kniesehne", "Hamstringsehne", "Kniebeugersehne", "ischiokrurale Sehne"),
)
MEDIAL_HAMSTRING_TENDON = Place(
    "medial hamstring tendon",
    en=("medial hamstrings",),
    de=(
        "innere Kniesehne",
        "mediale Kniebeugersehne",
        "Semitendinosussehne",
        "mediale Hamstringsehne",
    ),
)
LATERAL_HAMSTRING_TENDON = Place(
    "lateral hamstring tendon",
    en=("lateral hamstrings", "biceps femoris tendon"),
    de=(
        "äußere Kniesehne",
        "laterale Kniebeugersehne",
        "Bizepssehne",
        "Bicepssehne",
        "laterale Hamstringsehne",
    ),
)
FEMORAL_CONDYLE = Place(
    "femoral condyle",
    en=("condyle of the femur",),
    de=("Oberschenkelknorren", "Femurkondylus", "Femurkondyle"),
)
MEDIAL_FEMORAL_CONDYLE = Place(
    "medial femoral condyle",
    de=(
        "innerer Oberschenkelknorren",
        "medialer Femurkondylus",
        "Condylus medialis femoris",
        "mediale Femurkondyle",
    ),
)
LATERAL_FEMORAL_CONDYLE = Place(
    "lateral femoral condyle",
    de=(
        "äußerer Oberschenkelknorren",
        "lateraler Femurkondylus",
        "Condylus lateralis femoris",
        "laterale Femurkondyle",
    ),
)
MEDIAL_FEMORAL_EPICONDYLE = Place(
    "medial femoral epicondyle",
    en=("medial epicondyle of the femur",),
    de=(
        "innerer Oberschenkelepikondylus",
        "medialer Femurepikondylus",
        "Epicondylus medialis femoris",
        "mediale Femurepikondyle",
    ),
)
LATERAL_FEMORAL_EPICONDYLE = Place(
    "lateral femoral epicondyle",
    en=("lateral epicondyle of the femur",),
    de=(
        "äußerer Oberschenkelepikondylus",
        "lateraler Femurepikondylus",
        "Epicondylus lateralis femoris",
        "laterale Femurepikondyle",
    ),
)
ADDUCTOR_TUBERCLE = Place("adductor tubercle", de=("Adduktorenhöcker", "Tuberculum adductorium"))
ANTERIOR_COMPARTMENT = Place(
    "anterior compartment",
    en=("pretibial muscles", "anterior tibial muscle", "tibialis anterior", "lateral tibial flare"),
    de=(
        "Schienbeinmuskel",
        "vordere Muskelloge",
        "Tibialis-anterior-Loge",
        "Musculus tibialis anterior",
        "M. tibialis anterior",
    ),
)
CALF = Place(
    "calf",
    en=("gastrocnemius", "calf muscle"),
    de=("Wade", "Wadenmuskel", "Gastroknemius", "Musculus gastrocnemius"),
)
FIBULA_HEAD_BEARS_NOT = SensitivePlace(
    name="fibula head",
    why="bone, and the common peroneal nerve winds round the fibula's neck under the skin",
    reach_mm=25.0,
    also=("fibula neck", "peroneal nerve"),
)
TIBIAL_CREST_BEARS_NOT = SensitivePlace(
    name="tibial crest", why="bone edge under the skin", reach_mm=8.0
)
TIBIAL_TUBERCLE_BEARS_NOT = SensitivePlace(
    name="tibial tubercle", why="bone under the skin", reach_mm=5.0
)

CUT_END = SensitivePlace(name="distal end", why="the cut ends of bone lie under it", reach_mm=15.0)

KIND = Kind(
    name="transtibial",
    order=1,
    words={"en": "Transtibial", "de": "Unterschenkel"},
    sided=True,
    round_ended=True,
    places=(
        MID_PATELLA,
        PATELLAR_TENDON,
        MEDIAL_TIBIAL_CONDYLE,
        POPLITEAL_CREASE,
        TIBIAL_TUBERCLE,
        FIBULA_HEAD,
        TIBIAL_CREST,
        FIBULA_END,
        TIBIA_END,
        DISTAL_END,
        MEDIAL_TIBIAL_FLARE,
        LATERAL_TIBIAL_CONDYLE,
        FIBULA_NECK,
        PERONEAL_NERVE,
        HAMSTRING_TENDON,
        MEDIAL_HAMSTRING_TENDON,
        LATERAL_HAMSTRING_TENDON,
        FEMORAL_CONDYLE,
        MEDIAL_FEMORAL_CONDYLE,
        LATERAL_FEMORAL_CONDYLE,
        MEDIAL_FEMORAL_EPICONDYLE,
        LATERAL_FEMORAL_EPICONDYLE,
        ADDUCTOR_TUBERCLE,
        ANTERIOR_COMPARTMENT,
        CALF,
    ),
    sensitive=(
        SensitivePlace(name="mid patella", why="bone under the skin", reach_mm=15.0),
        TIBIAL_TUBERCLE_BEARS_NOT,
        TIBIAL_CREST_BEARS_NOT,
        FIBULA_HEAD_BEARS_NOT,
        SensitivePlace(name="fibula end", why="cut end of bone", reach_mm=12.0),
        SensitivePlace(name="tibia end", why="cut end of bone", reach_mm=15.0),
        CUT_END,
        SensitivePlace(
            name="hamstring tendon",
            why="tendon that rises when the knee bends",
            reach_mm=8.0,
            also=("medial hamstring tendon", "lateral hamstring tendon"),
        ),
        SensitivePlace(
            name="femoral condyle",
            why="bone under the skin",
            reach_mm=12.0,
            also=(
                "medial femoral condyle",
                "lateral femoral condyle",
                "adductor tubercle",
                "medial femoral epicondyle",
                "lateral femoral epicondyle",
            ),
        ),
    ),
    directions=(
        Line(
            name="tibia",
            start=Midpoint(("tibia end",), otherwise=("distal end",)),
            end=Midpoint(("tibial tubercle",)),
        ),
        Line(
            name="knee",
            start=Midpoint(("medial femoral epicondyle",)),
            end=Midpoint(("lateral femoral epicondyle",)),
        ),
    ),
    sheet=(
        Distance(
            name="patellar_tendon_to_end_mm",
            en="Patellar tendon to the distal end, along the axis",
            de="Patellasehne bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("patellar tendon",)),
            along="long axis",
        ),
        Distance(
            name="tubercle_to_tibia_end_mm",
            en="Tibial tubercle to the end of the tibia",
            de="Schienbeinhöcker bis Schienbeinende",
            start=Midpoint(("tibia end",)),
            end=Midpoint(("tibial tubercle",)),
        ),
        Distance(
            name="fibula_length_mm",
            en="Head of the fibula to its end",
            de="Wadenbeinköpfchen bis Wadenbeinende",
            start=Midpoint(("fibula end",)),
            end=Midpoint(("fibula head",)),
        ),
        Distance(
            name="condyles_ml_mm",
            en="Width at the femoral epicondyles",
            de="Breite an den Oberschenkelepikondylen",
            start=Midpoint(("medial femoral epicondyle",)),
            end=Midpoint(("lateral femoral epicondyle",)),
        ),
        Section(
            name="patellar_tendon_girth_mm",
            en="Girth at the patellar tendon",
            de="Umfang an der Patellasehne",
            at=Midpoint(("patellar tendon",)),
            normal="long axis",
        ),
        Section(
            name="tubercle_girth_mm",
            en="Girth at the tibial tubercle",
            de="Umfang am Schienbeinhöcker",
            at=Midpoint(("tibial tubercle",)),
            normal="long axis",
        ),
    ),
    presets={
        "fibula head": 5.0,
        "tibial crest": 2.5,
        "tibia end": 4.0,
        "fibula end": 3.0,
        "hamstring tendon": 3.0,
        "medial hamstring tendon": 3.0,
        "lateral hamstring tendon": 3.0,
    },
)
