"""Brims of sockets: PTB, supracondylar, TSB; quadrilateral and ischial containment.

Each brim is one edge round the limb, its points at heights over landmarks, seen from angles.
"""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.trims import Loop, Measure, Trim, TrimPoint, point_round_axis

_END = TrimPoint(name="distal end", at="distal end", seen_from="anterior", up_mm=12.0)


FRONT = Measure(
    name="front_mm",
    usual=0.0,
    within=Within(-10, 15),
    en="Front, over the middle of the patella",
    de="Vorn, über der Kniescheibenmitte",
)
SIDES = Measure(
    name="sides_mm",
    usual=10.0,
    within=Within(0, 20),
    en="Sides, over the middle of the patella",
    de="Seiten, über der Kniescheibenmitte",
)
BACK = Measure(
    name="back_mm",
    usual=0.0,
    within=Within(-10, 10),
    en="Behind, over the patellar tendon's level",
    de="Hinten, über der Höhe der Patellasehne",
)
SCOOP = Measure(
    name="scoop_mm",
    usual=12.0,
    within=Within(5, 18),
    en="Scoops for the hamstrings, below the edge behind",
    de="Aussparungen der Beugesehnen, unter dem hinteren Rand",
)


def _below_knee(sides: TrimPoint, measures: tuple[Measure, ...]) -> Trim:
    """Behind, a scoop, the side, the corner beside the patella, the front, and back."""
    medial = TrimPoint(
        name="side, medial",
        at=sides.at.replace("lateral", "medial"),
        up_mm=sides.up_mm,
        around_deg=-90.0,
    )
    return Trim(
        loops=(
            Loop(
                name="brim",
                points=(
                    point_round_axis("back", "patellar tendon", "back_mm", 180.0),
                    point_round_axis(
                        "scoop, lateral", "patellar tendon", ("back_mm", "-scoop_mm"), 142.0
                    ),
                    sides,
                    point_round_axis("corner, lateral", "mid patella", ("front_mm", -2.0), 42.0),
                    point_round_axis("front", "mid patella", "front_mm", 0.0),
                    point_round_axis("corner, medial", "mid patella", ("front_mm", -2.0), -42.0),
                    medial,
                    point_round_axis(
                        "scoop, medial", "patellar tendon", ("back_mm", "-scoop_mm"), -142.0
                    ),
                ),
                keeps=_END,
            ),
        ),
        measures=measures,
    )


_PTB_SIDE = point_round_axis("side, lateral", "mid patella", "sides_mm", 90.0)
PTB = _below_knee(_PTB_SIDE, (FRONT, SIDES, BACK, SCOOP))
SUPRACONDYLAR = _below_knee(
    point_round_axis("side, lateral", "lateral femoral epicondyle", "sides_mm", 90.0),
    (
        FRONT,
        Measure(
            name="sides_mm",
            usual=28.0,
            within=Within(20, 40),
            en="Sides, over the femoral epicondyles",
            de="Seiten, über den Femurepikondylen",
        ),
        BACK,
        SCOOP,
    ),
)
TSB = _below_knee(
    _PTB_SIDE,
    (
        Measure(
            name="front_mm",
            usual=-8.0,
            within=Within(-20, 0),
            en="Front, over the middle of the patella",
            de="Vorn, über der Kniescheibenmitte",
        ),
        Measure(
            name="sides_mm",
            usual=0.0,
            within=Within(-10, 10),
            en="Sides, over the middle of the patella",
            de="Seiten, über der Kniescheibenmitte",
        ),
        Measure(
            name="back_mm",
            usual=-10.0,
            within=Within(-20, 0),
            en="Behind, over the patellar tendon's level",
            de="Hinten, über der Höhe der Patellasehne",
        ),
        Measure(
            name="scoop_mm",
            usual=6.0,
            within=Within(0, 15),
            en="Scoops for the hamstrings, below the edge behind",
            de="Aussparungen der Beugesehnen, unter dem hinteren Rand",
        ),
    ),
)

SEAT = Measure(
    name="seat_mm",
    usual=0.0,
    within=Within(-10, 10),
    en="Seat behind, over the ischial tuberosity",
    de="Sitz hinten, über dem Sitzbein",
)
LATERAL_WALL = Measure(
    name="lateral_wall_mm",
    usual=20.0,
    within=Within(0, 50),
    en="Lateral wall, over the greater trochanter",
    de="Laterale Wand, über dem großen Rollhügel",
)
SKELETAL_ML = Measure(
    name="skeletal_ml_mm",
    usual=None,
    within=Within(60, 200),
    en="Skeletal width, ischium to below the trochanter, as measured on the patient",
    de="Knöchernes ML-Maß, Sitzbein bis unter den Rollhügel, am Patienten gemessen",
)
QUADRILATERAL = Trim(
    loops=(
        Loop(
            name="brim",
            points=(
                point_round_axis("back, seat", "ischial tuberosity", "seat_mm", 180.0),
                point_round_axis("back, lateral", "ischial tuberosity", ("seat_mm", 8.0), 135.0),
                point_round_axis("lateral", "greater trochanter", "lateral_wall_mm", 90.0),
                point_round_axis("front, lateral", "ischial tuberosity", "front_wall_mm", 45.0),
                point_round_axis("front", "ischial tuberosity", "front_wall_mm", 0.0),
                point_round_axis("front, medial", "ischial tuberosity", "0.5*front_wall_mm", -48.0),
                point_round_axis("medial", "ischial tuberosity", "seat_mm", -90.0),
                point_round_axis("seat, medial", "ischial tuberosity", "seat_mm", -140.0),
            ),
            keeps=_END,
        ),
    ),
    measures=(
        SEAT,
        Measure(
            name="front_wall_mm",
            usual=60.0,
            within=Within(50, 70),
            en="Front wall, over the ischial tuberosity",
            de="Vordere Wand, über dem Sitzbein",
        ),
        LATERAL_WALL,
    ),
)
ISCHIAL_CONTAINMENT = Trim(
    loops=(
        Loop(
            name="brim",
            points=(
                point_round_axis("back", "ischial tuberosity", ("seat_mm", 6.0), 180.0),
                point_round_axis("back, lateral", "ischial tuberosity", ("seat_mm", 12.0), 135.0),
                point_round_axis("lateral", "greater trochanter", "lateral_wall_mm", 90.0),
                point_round_axis("front, lateral", "ischial tuberosity", "front_wall_mm", 45.0),
                point_round_axis("front", "ischial tuberosity", "front_wall_mm", 0.0),
                point_round_axis(
                    "front, medial", "ischial tuberosity", ("0.6*contain_mm", 2.0), -45.0
                ),
                point_round_axis(
                    "ramus", "ischial tuberosity", "contain_mm", (-90.0, "-ramus_deg")
                ),
                point_round_axis(
                    "ischium", "ischial tuberosity", "contain_mm", (-115.0, "-ramus_deg")
                ),
            ),
            keeps=_END,
        ),
    ),
    measures=(
        SEAT,
        Measure(
            name="contain_mm",
            usual=35.0,
            within=Within(30, 40),
            en="Medial brim, over the ischial tuberosity",
            de="Medialer Rand, über dem Sitzbein",
        ),
        Measure(
            name="ramus_deg",
            usual=None,
            within=Within(0, 55),
            en="Angle of the ischial ramus to straight ahead, as measured on the patient",
            de="Winkel des Sitzbeinastes zur Laufrichtung, am Patienten gemessen",
        ),
        Measure(
            name="front_wall_mm",
            usual=35.0,
            within=Within(15, 55),
            en="Front wall, over the ischial tuberosity",
            de="Vordere Wand, über dem Sitzbein",
        ),
        LATERAL_WALL,
    ),
)
