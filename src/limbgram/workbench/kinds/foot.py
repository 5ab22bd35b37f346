"""Foot and ankle: a foot with its shank, or a cast of it.

Sensitive places: International Committee of the Red Cross, Ankle-Foot Orthosis, manufacturing
guidelines: malleoli, navicular and the fifth metatarsal's base are built up.

Directions and signs. The ankle axis runs through the tips of the malleoli, the shank from their
middle to that of fibula head and medial tibial condyle (or the tubercle); the plantar plane lies
under heel and both metatarsal heads (through the heel and the heads themselves, where not all three
places under them were marked; heights over the sole have no answer there), the foot's axis in it
from heel to second toe. Build-ups are general trade knowledge, without a source.

Lines between places that lie near each other hang on where these were placed: by 2.5 degrees for a
millimetre on a child's heel. So the surface tells them, and landmarks choose its parts: the heel's
bisection goes through the middles of the heel's sections square to it, from the height of the
calcaneus's sides to that of the Achilles tendon's insertion, behind those sides; the forefoot's
varus and valgus are those of the plane under the metatarsal heads against it; adduction is the
angle of the lines that halve the hindfoot and the forefoot, seen on the sole.

The subtalar axis runs through the heel, 42 degrees above the plantar plane and 23 medially of the
foot's axis: means as V. Inman gives them (The Joints of the Ankle, 1976); others have 16 degrees
medially, and persons lie far apart. No landmark tells it: it is an editable default, no finding.
"""

from limbgram.workbench.anatomy.kind import (
    Angle,
    Arch,
    BentCentreline,
    Cross,
    Distance,
    Extent,
    Extreme,
    Joint,
    Kind,
    LandmarkFrame,
    Line,
    Midpoint,
    Place,
    Plane,
    Section,
    SensitivePlace,
    Share,
    SurfaceAxis,
    Tilted,
)
from limbgram.workbench.kinds.transtibial import (
    FIBULA_HEAD,
    FIBULA_HEAD_BEARS_NOT,
    MEDIAL_TIBIAL_CONDYLE,
    TIBIAL_CREST,
    TIBIAL_CREST_BEARS_NOT,
    TIBIAL_TUBERCLE,
    TIBIAL_TUBERCLE_BEARS_NOT,
)

MEDIAL_MALLEOLUS = Place(
    "medial malleolus",
    en=("inner ankle",),
    de=("Innenknöchel", "medialer Malleolus", "Malleolus medialis", "Knöchel innen"),
    facing="medial",
    level=3,
)
LATERAL_MALLEOLUS = Place(
    "lateral malleolus",
    en=("outer ankle",),
    de=("Außenknöchel", "lateraler Malleolus", "Malleolus lateralis", "Knöchel außen"),
    facing="lateral",
    level=3,
)
NAVICULAR = Place(
    "navicular",
    en=("navicular tuberosity", "tuberosity of the navicular"),
    de=("Kahnbein", "Os naviculare", "Tuberositas ossis navicularis", "Naviculare"),
    facing="medial",
    level=2,
)
HEEL = Place("heel", de=("Ferse", "Fersenpunkt"), facing="posterior", level=1)
FIRST_METATARSAL_HEAD = Place(
    "first metatarsal head",
    en=("mt1 head", "1st metatarsal head"),
    de=(
        "Großzehenballen",
        "Mittelfußköpfchen 1",
        "Metatarsalköpfchen 1",
        "MFK 1",
        "MTK 1",
        "erstes Mittelfußköpfchen",
        "Großzehengrundgelenk",
    ),
    facing="anterior",
    level=1,
)
FIFTH_METATARSAL_HEAD = Place(
    "fifth metatarsal head",
    en=("mt5 head", "5th metatarsal head"),
    de=(
        "Kleinzehenballen",
        "Mittelfußköpfchen 5",
        "Metatarsalköpfchen 5",
        "MFK 5",
        "MTK 5",
        "fünftes Mittelfußköpfchen",
        "Kleinzehengrundgelenk",
    ),
    facing="anterior",
    level=1,
)
FIFTH_METATARSAL_BASE = Place(
    "fifth metatarsal base",
    en=("base of the fifth metatarsal", "mt5 base", "5th metatarsal base", "styloid process"),
    de=(
        "Basis des fünften Mittelfußknochens",
        "Metatarsale-5-Basis",
        "Basis Metatarsale 5",
        "Mittelfußbasis 5",
    ),
)
ACHILLES_TENDON = Place("achilles tendon", en=("calcaneal tendon",), de=("Achillessehne",))
SECOND_TOE = Place(
    "second toe",
    en=("tip of the second toe",),
    de=("zweite Zehe", "Zehe 2", "D2"),
    facing="anterior",
    level=1,
)
PLANTAR_HEEL = Place(
    "plantar heel",
    en=("heel plantar", "under the heel"),
    de=("Fersensohle", "Ferse plantar"),
    level=0,
)
PLANTAR_FIRST_METATARSAL_HEAD = Place(
    "plantar first metatarsal head",
    en=("mt1 head plantar",),
    de=("Großzehenballen plantar", "MTK 1 plantar"),
    facing="anterior",
    level=0,
)
PLANTAR_FIFTH_METATARSAL_HEAD = Place(
    "plantar fifth metatarsal head",
    en=("mt5 head plantar",),
    de=("Kleinzehenballen plantar", "MTK 5 plantar"),
    facing="anterior",
    level=0,
)
MEDIAL_CALCANEUS = Place(
    "medial calcaneus",
    en=("medial heel", "medial side of the heel"),
    de=("Ferse innen", "mediales Fersenbein", "Calcaneus medial"),
    facing="medial",
    level=1,
)
LATERAL_CALCANEUS = Place(
    "lateral calcaneus",
    en=("lateral heel", "lateral side of the heel"),
    de=("Ferse außen", "laterales Fersenbein", "Calcaneus lateral"),
    facing="lateral",
    level=1,
)
SUSTENTACULUM = Place(
    "sustentaculum",
    en=("sustentaculum tali",),
    de=("Sustentaculum tali", "Sustentaculum"),
    facing="medial",
)
ACHILLES_INSERTION = Place(
    "achilles insertion",
    en=("insertion of the achilles tendon",),
    de=("Achillessehnenansatz", "Ansatz der Achillessehne"),
    facing="posterior",
    level=2,
)
FIRST_TOE = Place(
    "first toe",
    en=("great toe", "hallux", "tip of the great toe"),
    de=("Großzehe", "große Zehe", "Hallux", "Großzehenspitze"),
    facing="anterior",
    level=1,
)
FIFTH_TOE = Place(
    "fifth toe",
    en=("little toe", "tip of the little toe"),
    de=("Kleinzehe", "kleine Zehe", "Kleinzehenspitze"),
    facing="anterior",
)
INSTEP = Place(
    "instep",
    en=("instep crease", "anterior ankle"),
    de=("Rist", "Spann", "Sprunggelenksbeuge"),
    facing="anterior",
    level=2,
)

_MALLEOLI = Midpoint(("medial malleolus", "lateral malleolus"))
_BALL = Midpoint(("first metatarsal head", "fifth metatarsal head"))
_HEEL, _TOE = Midpoint(("heel",)), Midpoint(("second toe",))
_MT1, _MT5 = Midpoint(("first metatarsal head",)), Midpoint(("fifth metatarsal head",))
_KNEE = Midpoint(("fibula head", "medial tibial condyle"), otherwise=("tibial tubercle",))
_SOLE = (
    Midpoint(("plantar heel",), otherwise=("heel",)),
    Midpoint(("plantar first metatarsal head",), otherwise=("first metatarsal head",)),
    Midpoint(("plantar fifth metatarsal head",), otherwise=("fifth metatarsal head",)),
)
_UNDER_HEEL = Midpoint(("plantar heel",))
_UNDER_MT1 = Midpoint(("plantar first metatarsal head",))
_UNDER_MT5 = Midpoint(("plantar fifth metatarsal head",))
_UNDER_BALL = Midpoint(("plantar first metatarsal head", "plantar fifth metatarsal head"))
_CALCANEUS = Midpoint(("medial calcaneus", "lateral calcaneus"))
_MIDFOOT = Midpoint(("navicular", "fifth metatarsal base"))

USUAL_TRIM_MM = 22.0
"""Below the head of the fibula: where the upper edge of an ankle-foot orthosis usually lies."""

KIND = Kind(
    name="foot",
    order=3,
    words={"en": "Foot and ankle", "de": "Fuß und Sprunggelenk"},
    sided=True,
    long=False,
    upright=LandmarkFrame(up="shank", forward="foot"),
    places=(
        TIBIAL_TUBERCLE.at(5),
        FIBULA_HEAD.at(5),
        MEDIAL_TIBIAL_CONDYLE.at(5),
        TIBIAL_CREST.at(4),
        MEDIAL_MALLEOLUS,
        LATERAL_MALLEOLUS,
        NAVICULAR,
        INSTEP,
        ACHILLES_INSERTION,
        HEEL,
        MEDIAL_CALCANEUS,
        LATERAL_CALCANEUS,
        FIRST_METATARSAL_HEAD,
        FIFTH_METATARSAL_HEAD,
        PLANTAR_HEEL,
        PLANTAR_FIRST_METATARSAL_HEAD,
        PLANTAR_FIFTH_METATARSAL_HEAD,
        FIFTH_METATARSAL_BASE.at(1),
        FIRST_TOE,
        SECOND_TOE,
        FIFTH_TOE,
        SUSTENTACULUM,
        ACHILLES_TENDON,
    ),
    sensitive=(
        TIBIAL_TUBERCLE_BEARS_NOT,
        FIBULA_HEAD_BEARS_NOT,
        TIBIAL_CREST_BEARS_NOT,
        SensitivePlace(name="medial malleolus", why="bone under the skin", reach_mm=12.0),
        SensitivePlace(name="lateral malleolus", why="bone under the skin", reach_mm=12.0),
        SensitivePlace(name="navicular", why="bone under the skin", reach_mm=10.0),
        SensitivePlace(name="first metatarsal head", why="bone under the skin", reach_mm=10.0),
        SensitivePlace(name="fifth metatarsal head", why="bone under the skin", reach_mm=8.0),
        SensitivePlace(name="fifth metatarsal base", why="bone under the skin", reach_mm=8.0),
        SensitivePlace(
            name="achilles tendon",
            why="tendon under the skin",
            reach_mm=8.0,
            also=("achilles insertion",),
        ),
    ),
    directions=(
        Line(
            name="ankle",
            start=Midpoint(("medial malleolus",)),
            end=Midpoint(("lateral malleolus",)),
        ),
        Line(name="shank", start=_MALLEOLI, end=_KNEE),
        Plane(name="plantar", through=_SOLE, towards=_MALLEOLI),
        Plane(name="sole", through=(_UNDER_HEEL, _UNDER_MT1, _UNDER_MT5), towards=_MALLEOLI),
        Line(name="foot", start=_HEEL, end=_TOE, within="plantar"),
        Line(name="ball", start=_MT1, end=_MT5),
        Cross(name="lateral", first="foot", second="plantar"),
        Line(name="heel to instep", start=_HEEL, end=Midpoint(("instep",))),
        Cross(name="across heel and instep", first="heel to instep", second="lateral"),
        Line(name="heel to toe", start=_HEEL, end=_TOE),
        Line(name="toes", start=_UNDER_BALL, end=_TOE),
        SurfaceAxis(
            name="heel bisection",
            how="halves across",
            along="plantar",
            towards="lateral",
            start=_CALCANEUS,
            end=Midpoint(("achilles insertion",)),
            whole=_HEEL,
            none=_CALCANEUS,
        ),
        SurfaceAxis(
            name="under the forefoot",
            how="under",
            along="lateral",
            towards="plantar",
            start=_SOLE[1],
            end=_SOLE[2],
            whole=_SOLE[0],
            none=_MALLEOLI,
            reach=0.25,
        ),
        Tilted(name="subtalar", along="foot", above="plantar", up_deg=42.0, medial_deg=23.0),
        SurfaceAxis(
            name="hindfoot",
            how="halves",
            along="foot",
            towards="lateral",
            start=_HEEL,
            end=_MIDFOOT,
            whole=_SOLE[0],
            none=_MALLEOLI,
        ),
        SurfaceAxis(
            name="forefoot",
            how="halves",
            along="foot",
            towards="lateral",
            start=_MIDFOOT,
            end=_BALL,
            whole=_SOLE[0],
            none=_MALLEOLI,
        ),
    ),
    centreline=BentCentreline(
        nodes=(_KNEE, Midpoint(("medial malleolus", "lateral malleolus", "heel")), _BALL, _TOE),
        reference="lateral malleolus",
    ),
    sheet=(
        Angle(
            name="ankle_deg",
            en="Ankle, shank to plantar plane; 90 is plantigrade",
            de="Sprunggelenk, Unterschenkel zur Plantarebene; 90 ist plantigrad",
            of="foot",
            to="shank",
            about="lateral",
        ),
        Angle(
            name="dorsiflexion_deg",
            en="Dorsiflexion",
            de="Dorsalextension",
            of="shank",
            to="plantar",
            about="lateral",
        ),
        Angle(
            name="shank_to_vertical_deg",
            en="Shank to vertical, incline positive",
            de="Unterschenkel zur Lotrechten, Vorneigung positiv",
            of="shank",
            to="plantar",
            about="lateral",
            pitch=(_HEEL, _BALL),
            note="dorsiflexion + atan(heel-sole differential / heel to ball)",
        ),
        Angle(
            name="hindfoot_deg",
            en="Hindfoot, varus positive",
            de="Rückfuß, Varus positiv",
            of="shank",
            to="heel bisection",
            about="foot",
            note="bisection of the heel's surface to the shank",
        ),
        Angle(
            name="forefoot_deg",
            en="Forefoot to hindfoot, varus positive",
            de="Vorfuß zum Rückfuß, Varus positiv",
            of="heel bisection",
            to="under the forefoot",
            about="foot",
            zero_deg=90.0,
            note="plane under the metatarsal heads to the bisection of the heel's surface",
        ),
        Angle(
            name="forefoot_adduction_deg",
            en="Forefoot adduction",
            de="Vorfußadduktion",
            of="hindfoot",
            to="forefoot",
            about="plantar",
            note="lines that halve the surface of hindfoot and forefoot, seen on the sole",
        ),
        Angle(
            name="toe_out_deg",
            en="Toe-out against the ankle axis",
            de="Außenrotation des Fußes zur Knöchelachse",
            of="foot",
            to="ankle",
            about="plantar",
            zero_deg=-90.0,
        ),
        Angle(
            name="toes_up_deg",
            en="Toes up: from under the ball to the second toe, against the plantar plane",
            de="Zehen hoch: von unter dem Ballen zur zweiten Zehe, gegen die Plantarebene",
            of="sole",
            to="toes",
            about="lateral",
            zero_deg=-90.0,
        ),
        Extent(
            name="foot_length_mm",
            en="Foot length, rearmost to foremost along the foot",
            de="Fußlänge, hinterster bis vorderster Punkt entlang des Fußes",
            along="foot",
            up="plantar",
            below=_MALLEOLI,
        ),
        Distance(
            name="heel_to_second_toe_mm",
            en="Heel to second toe along the foot",
            de="Ferse bis zweite Zehe, entlang des Fußes",
            start=_HEEL,
            end=_TOE,
            along="foot",
        ),
        Distance(
            name="heel_to_mt1_mm",
            en="Heel to first metatarsal head, along the foot",
            de="Ferse bis Großzehenballen, entlang des Fußes",
            start=_HEEL,
            end=_MT1,
            along="foot",
        ),
        Distance(
            name="heel_to_mt5_mm",
            en="Heel to fifth metatarsal head, along the foot",
            de="Ferse bis Kleinzehenballen, entlang des Fußes",
            start=_HEEL,
            end=_MT5,
            along="foot",
        ),
        Distance(name="ball_width_mm", en="Ball width", de="Ballenbreite", start=_MT1, end=_MT5),
        Section(
            name="ball_girth_mm",
            en="Ball girth",
            de="Ballenumfang",
            at=_BALL,
            normal="centreline",
            holds="ball",
        ),
        Section(
            name="instep_girth_mm",
            en="Instep girth, at the navicular across the centreline",
            de="Ristumfang, am Kahnbein quer zur Mittellinie",
            at=Midpoint(("navicular",)),
            normal="centreline",
        ),
        Section(
            name="short_heel_girth_mm",
            en="Short heel girth, heel to instep",
            de="Fersenumfang, Ferse zum Rist",
            at=Midpoint(("heel", "instep")),
            normal="across heel and instep",
        ),
        Distance(
            name="heel_width_mm",
            en="Heel width",
            de="Fersenbreite",
            start=Midpoint(("medial calcaneus",)),
            end=Midpoint(("lateral calcaneus",)),
            along="lateral",
        ),
        Distance(
            name="navicular_height_mm",
            en="Height of the navicular",
            de="Höhe des Kahnbeins",
            start=_UNDER_HEEL,
            end=Midpoint(("navicular",)),
            along="sole",
        ),
        Arch(
            name="arch_height_mm",
            en="Height of the arch at its apex",
            de="Höhe des Längsgewölbes am Scheitel",
            start=_UNDER_HEEL,
            end=_UNDER_MT1,
            base="sole",
            what="height",
            note="highest place of the sole on the line from under the heel to under MT1",
        ),
        Arch(
            name="heel_to_arch_apex_mm",
            en="Under the heel to the arch's apex, towards the first metatarsal head",
            de="Fersensohle bis Gewölbescheitel, zum Großzehenballen",
            start=_UNDER_HEEL,
            end=_UNDER_MT1,
            base="sole",
            what="place",
        ),
        Distance(
            name="truncated_length_mm",
            en="Truncated length, heel to first metatarsal head",
            de="Verkürzte Fußlänge, Ferse bis Großzehenballen",
            start=_HEEL,
            end=_MT1,
            along="foot",
        ),
        Share(
            name="navicular_height_per_cent",
            en="Height of the navicular over truncated length",
            de="Höhe des Kahnbeins zu verkürzter Fußlänge",
            part="navicular_height_mm",
            whole="truncated_length_mm",
        ),
        Distance(
            name="medial_malleolus_height_mm",
            en="Height of the medial malleolus",
            de="Höhe des Innenknöchels",
            start=_UNDER_HEEL,
            end=Midpoint(("medial malleolus",)),
            along="sole",
        ),
        Distance(
            name="lateral_malleolus_height_mm",
            en="Height of the lateral malleolus",
            de="Höhe des Außenknöchels",
            start=_UNDER_HEEL,
            end=Midpoint(("lateral malleolus",)),
            along="sole",
        ),
        Distance(
            name="malleoli_width_mm",
            en="Width of the malleoli",
            de="Knöchelbreite",
            start=Midpoint(("medial malleolus",)),
            end=Midpoint(("lateral malleolus",)),
        ),
        Extreme(
            name="smallest_ankle_girth_mm",
            en="Smallest girth above the ankle",
            de="Kleinster Umfang über dem Knöchel",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="smallest",
        ),
        Extreme(
            name="smallest_ankle_girth_height_mm",
            en="Its height above the ankle axis",
            de="Seine Höhe über der Knöchelachse",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="smallest",
            height_from=_MALLEOLI,
        ),
        Extreme(
            name="smallest_ankle_width_mm",
            en="ML width at the smallest girth above the ankle",
            de="ML-Breite am kleinsten Umfang über dem Knöchel",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="smallest",
            width_along="lateral",
            note="calliper across the foot's axis",
        ),
        Extreme(
            name="calf_girth_mm",
            en="Largest girth of the calf",
            de="Größter Wadenumfang",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="largest",
        ),
        Extreme(
            name="calf_girth_height_mm",
            en="Its height above the ankle axis",
            de="Seine Höhe über der Knöchelachse",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="largest",
            height_from=_MALLEOLI,
        ),
        Extreme(
            name="calf_width_mm",
            en="ML width at the largest girth of the calf",
            de="ML-Breite am größten Wadenumfang",
            normal="shank",
            between=(_MALLEOLI, _KNEE),
            which="largest",
            width_along="lateral",
            note="calliper across the foot's axis",
        ),
        Section(
            name="calf_trim_girth_mm",
            en=f"Girth of the calf at the usual upper edge, {USUAL_TRIM_MM:g} mm below the head of "
            "the fibula",
            de=f"Wadenumfang am üblichen oberen Rand, {USUAL_TRIM_MM:g} mm unter dem "
            "Wadenbeinköpfchen",
            at=Midpoint(("fibula head",)),
            normal="shank",
            beyond_mm=-USUAL_TRIM_MM,
        ),
        Section(
            name="calf_trim_width_mm",
            en="ML width of the calf there",
            de="ML-Breite der Wade dort",
            at=Midpoint(("fibula head",)),
            normal="shank",
            beyond_mm=-USUAL_TRIM_MM,
            what="width",
            along="lateral",
            note="calliper across the foot's axis",
        ),
        Distance(
            name="fibula_head_height_mm",
            en="Height of the head of the fibula",
            de="Höhe des Wadenbeinköpfchens",
            start=_UNDER_HEEL,
            end=Midpoint(("fibula head",)),
            along="sole",
        ),
    ),
    joints=(
        Joint(
            name="ankle",
            de="Sprunggelenk",
            sense={"en": "dorsiflexion positive", "de": "Dorsalextension positiv"},
            axis="ankle",
            reads="ankle_deg",
            centre=_MALLEOLI,
            upper=_KNEE,
            lower=_BALL,
            rigid=("medial malleolus", "lateral malleolus"),
        ),
        Joint(
            name="hindfoot",
            de="Rückfuß",
            sense={
                "en": "varus and supination about the subtalar axis positive",
                "de": "Varus und Supination um die subtalare Achse positiv",
            },
            axis="subtalar",
            reads="hindfoot_deg",
            centre=Midpoint(("heel",)),
            parted=Midpoint(("medial malleolus", "lateral malleolus", "heel")),
            upper=_KNEE,
            lower=_BALL,
            square="plantar",
            rigid=("medial malleolus", "lateral malleolus"),
        ),
        Joint(
            name="forefoot",
            de="Vorfuß",
            sense={"en": "varus positive", "de": "Varus positiv"},
            axis="heel to toe",
            reads="forefoot_deg",
            centre=_HEEL,
            parted=_MIDFOOT,
            upper=_HEEL,
            lower=_TOE,
            twist=True,
            below=_MALLEOLI,
            knee=_KNEE,
        ),
        Joint(
            name="toes",
            de="Zehen",
            sense={"en": "up positive", "de": "nach oben positiv"},
            axis="ball",
            reads="toes_up_deg",
            centre=_BALL,
            upper=_HEEL,
            lower=_TOE,
            below=_MALLEOLI,
            knee=_KNEE,
        ),
    ),
    presets={
        "medial malleolus": 5.0,
        "lateral malleolus": 5.0,
        "navicular": 4.0,
        "fifth metatarsal base": 4.0,
        "first metatarsal head": 3.0,
        "fifth metatarsal head": 3.0,
        "tibial crest": 2.5,
        "fibula head": 5.0,
        "achilles tendon": 2.5,
        "heel": 2.5,
    },
)
