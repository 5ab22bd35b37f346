"""Head: measures of a cranium, and no device.

The base plane goes through sellion and both tragia; the midline is in it, from the middle of the
tragia to the sellion. Ten equal levels reach from the base plane to the vertex; the measuring level
is the third, as scanners of heads have it. CVA and its index: Loveday; diagonals at a fixed 30
degrees to the midline repeat better than those between landmarks (Sci Rep 2022,
s41598-022-24555-1). The denominator of the index differs between authors, so both stand in the
sheet, each with its formula. No severity is told.
"""

from limbgram.workbench.anatomy.kind import (
    Cranial,
    Cross,
    Difference,
    Distance,
    Kind,
    LandmarkFrame,
    Line,
    Midpoint,
    Place,
    Plane,
    Section,
    SensitivePlace,
    Share,
)

VERTEX = Place("vertex", en=("top of the head",), de=("Scheitel", "Scheitelpunkt"), level=4)
GLABELLA = Place("glabella", de=("Glabella", "Stirnmitte"), facing="anterior", level=2)
SELLION = Place(
    "sellion",
    en=("nasion", "bridge of the nose"),
    de=("Sellion", "Nasenwurzel", "Nasion"),
    facing="anterior",
    level=1,
)
OPISTHOCRANION = Place(
    "opisthocranion",
    en=("back of the head",),
    de=("Opisthokranion", "Opisthocranion", "Hinterhaupt"),
    facing="posterior",
    level=2,
)
RIGHT_TRAGION = Place(
    "right tragion",
    en=("right tragus",),
    de=("rechtes Tragion", "rechter Tragus", "Tragus rechts"),
    facing="right",
    level=1,
)
LEFT_TRAGION = Place(
    "left tragion",
    en=("left tragus",),
    de=("linkes Tragion", "linker Tragus", "Tragus links"),
    facing="left",
    level=1,
)
RIGHT_EURION = Place(
    "right eurion", de=("rechtes Euryon", "Euryon rechts", "Eurion rechts"), facing="right", level=3
)
LEFT_EURION = Place(
    "left eurion", de=("linkes Euryon", "Euryon links", "Eurion links"), facing="left", level=3
)
RIGHT_FRONTOZYGOMA = Place(
    "right frontozygoma",
    en=("right frontozygomatic point",),
    de=("rechtes Frontozygoma", "Frontozygoma rechts"),
)
LEFT_FRONTOZYGOMA = Place(
    "left frontozygoma",
    en=("left frontozygomatic point",),
    de=("linkes Frontozygoma", "Frontozygoma links"),
)

_TRAGIA = Midpoint(("right tragion", "left tragion"))
_SELLION = Midpoint(("sellion",))
_GLABELLA, _OPISTHOCRANION = Midpoint(("glabella",)), Midpoint(("opisthocranion",))

KIND = Kind(
    name="head",
    order=5,
    words={"en": "Head", "de": "Kopf"},
    sided=False,
    long=False,
    upright=LandmarkFrame(up="base", forward="midline"),
    places=(
        VERTEX,
        GLABELLA,
        SELLION,
        OPISTHOCRANION,
        RIGHT_TRAGION,
        LEFT_TRAGION,
        RIGHT_EURION,
        LEFT_EURION,
        RIGHT_FRONTOZYGOMA,
        LEFT_FRONTOZYGOMA,
    ),
    sensitive=(
        SensitivePlace(name="vertex", why="an infant's fontanelle may lie under it", reach_mm=25.0),
        SensitivePlace(
            name="right tragion", why="cartilage and nerve before the ear", reach_mm=12.0
        ),
        SensitivePlace(
            name="left tragion", why="cartilage and nerve before the ear", reach_mm=12.0
        ),
        SensitivePlace(name="sellion", why="bone under the skin", reach_mm=8.0),
    ),
    directions=(
        Plane(
            name="base",
            through=(_SELLION, Midpoint(("right tragion",)), Midpoint(("left tragion",))),
            towards=Midpoint(("glabella",), otherwise=("vertex",)),
        ),
        Line(name="midline", start=_TRAGIA, end=_SELLION, within="base"),
        Cross(name="to the right", first="midline", second="base"),
        Line(name="greatest length", start=_OPISTHOCRANION, end=_GLABELLA),
    ),
    sheet=(
        Cranial(
            name="width_mm",
            en="Width at the measuring level",
            de="Breite in der Messebene",
            what="width",
        ),
        Cranial(
            name="length_mm",
            en="Length at the measuring level",
            de="Länge in der Messebene",
            what="length",
        ),
        Cranial(
            name="circumference_mm",
            en="Circumference at the measuring level",
            de="Umfang in der Messebene",
            what="girth",
        ),
        Cranial(
            name="cranial_ratio_per_cent",
            en="Cranial ratio",
            de="Kranialindex",
            what="ratio",
            note="width / length x 100, at the measuring level",
        ),
        Cranial(
            name="diagonal_left_front_mm",
            en="Diagonal, left front to right back",
            de="Diagonale, links vorn nach rechts hinten",
            what="diagonal left",
            note="through the middle, 30 degrees from the midline",
        ),
        Cranial(
            name="diagonal_right_front_mm",
            en="Diagonal, right front to left back",
            de="Diagonale, rechts vorn nach links hinten",
            what="diagonal right",
            note="through the middle, 30 degrees from the midline",
        ),
        Cranial(
            name="cva_mm",
            en="Cranial vault asymmetry",
            de="Schädelasymmetrie (CVA)",
            what="asymmetry",
            note="|left front - right front| diagonal",
        ),
        Cranial(
            name="cva_signed_mm",
            en="CVA with its sign; positive: the diagonal from the left front is the longer",
            de="CVA mit Vorzeichen; positiv: die Diagonale von links vorn ist die längere",
            what="asymmetry signed",
            note="left front - right front diagonal, 30 degrees from the midline",
        ),
        Cranial(
            name="cvai_shorter_per_cent",
            en="CVAI over the shorter diagonal",
            de="CVAI, geteilt durch die kürzere Diagonale",
            what="index shorter",
            note="asymmetry / shorter diagonal x 100 (Loveday)",
        ),
        Cranial(
            name="cvai_longer_per_cent",
            en="CVAI over the longer diagonal",
            de="CVAI, geteilt durch die längere Diagonale",
            what="index longer",
            note="asymmetry / longer diagonal x 100",
        ),
        Cranial(
            name="volume_right_front_ml",
            en="Volume, right front",
            de="Volumen, rechts vorn",
            what="volume right front",
        ),
        Cranial(
            name="volume_left_front_ml",
            en="Volume, left front",
            de="Volumen, links vorn",
            what="volume left front",
        ),
        Cranial(
            name="volume_right_back_ml",
            en="Volume, right back",
            de="Volumen, rechts hinten",
            what="volume right back",
        ),
        Cranial(
            name="volume_left_back_ml",
            en="Volume, left back",
            de="Volumen, links hinten",
            what="volume left back",
        ),
        Cranial(
            name="symmetry_front_per_cent",
            en="Symmetry of the front volumes",
            de="Symmetrie der vorderen Volumen",
            what="symmetry front",
            note="smaller / larger x 100",
        ),
        Cranial(
            name="symmetry_back_per_cent",
            en="Symmetry of the back volumes",
            de="Symmetrie der hinteren Volumen",
            what="symmetry back",
            note="smaller / larger x 100",
        ),
        Cranial(
            name="symmetry_per_cent",
            en="Symmetry of the halves",
            de="Symmetrie der Hälften",
            what="symmetry",
            note="smaller / larger x 100",
        ),
        Cranial(
            name="radial_symmetry_mm",
            en="Radial symmetry index",
            de="Radialer Symmetrieindex",
            what="radial",
            note="sum of |left - right radius| over spokes of every 15 degrees",
        ),
        Distance(
            name="eurion_width_mm",
            en="Width, eurion to eurion",
            de="Breite, Euryon zu Euryon",
            start=Midpoint(("left eurion",)),
            end=Midpoint(("right eurion",)),
        ),
        Distance(
            name="glabella_length_mm",
            en="Length, glabella to opisthocranion",
            de="Länge, Glabella bis Opisthokranion",
            start=_OPISTHOCRANION,
            end=_GLABELLA,
        ),
        Share(
            name="cephalic_index_per_cent",
            en="Cranial ratio between landmarks",
            de="Kranialindex zwischen Landmarken",
            part="eurion_width_mm",
            whole="glabella_length_mm",
            note="eurion to eurion / glabella to opisthocranion x 100",
        ),
        Section(
            name="head_circumference_mm",
            en="Head circumference over glabella and opisthocranion",
            de="Kopfumfang über Glabella und Opisthokranion",
            at=Midpoint(("glabella", "opisthocranion")),
            normal="base",
            holds="greatest length",
            note="taut tape in the plane through both, level from side to side",
        ),
        Distance(
            name="oblique_left_front_mm",
            en="Left frontozygoma to right eurion",
            de="Linkes Frontozygoma bis rechtes Euryon",
            start=Midpoint(("left frontozygoma",)),
            end=Midpoint(("right eurion",)),
        ),
        Distance(
            name="oblique_right_front_mm",
            en="Right frontozygoma to left eurion",
            de="Rechtes Frontozygoma bis linkes Euryon",
            start=Midpoint(("right frontozygoma",)),
            end=Midpoint(("left eurion",)),
        ),
        Difference(
            name="oblique_cva_mm",
            en="CVA between landmarks; positive: the diagonal from the left front is the longer",
            de="CVA zwischen Landmarken; positiv: die Diagonale von links vorn ist die längere",
            part="oblique_left_front_mm",
            less="oblique_right_front_mm",
            note="left frontozygoma to right eurion - right frontozygoma to left eurion",
        ),
    ),
)
