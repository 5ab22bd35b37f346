"""Arm: a residual limb or a whole one, above the elbow or below it, in the anatomical position.

Sensitive places: bony prominences under the skin, and the ulnar nerve behind the medial epicondyle;
reaches are general trade knowledge.
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
from limbgram.workbench.kinds.torso import AXILLA
from limbgram.workbench.kinds.transtibial import CUT_END, DISTAL_END

ACROMION = Place(
    "acromion",
    en=("tip of the shoulder",),
    de=("Akromion", "Schulterhöhe", "Acromion"),
    facing="lateral",
    level=5,
)
OLECRANON = Place(
    "olecranon",
    en=("tip of the elbow",),
    de=("Olekranon", "Ellenbogenspitze", "Olecranon"),
    facing="posterior",
    level=3,
)
LATERAL_HUMERAL_EPICONDYLE = Place(
    "lateral humeral epicondyle",
    en=("lateral epicondyle of the humerus",),
    de=(
        "lateraler Humerusepikondylus",
        "äußerer Oberarmepikondylus",
        "Epicondylus lateralis humeri",
    ),
    facing="lateral",
    level=3,
)
MEDIAL_HUMERAL_EPICONDYLE = Place(
    "medial humeral epicondyle",
    en=("medial epicondyle of the humerus",),
    de=("medialer Humerusepikondylus", "innerer Oberarmepikondylus", "Epicondylus medialis humeri"),
    facing="medial",
    level=3,
)
CUBITAL_FOLD = Place(
    "cubital fold",
    en=("elbow crease", "cubital fossa"),
    de=("Ellenbeuge", "Ellenbogenbeuge"),
    facing="anterior",
    level=3,
)
RADIAL_STYLOID = Place(
    "radial styloid",
    en=("styloid of the radius",),
    de=("Speichengriffel", "Processus styloideus radii"),
    facing="lateral",
    level=1,
)
ULNAR_STYLOID = Place(
    "ulnar styloid",
    en=("styloid of the ulna",),
    de=("Ellengriffel", "Processus styloideus ulnae"),
    facing="medial",
    level=1,
)

_EPICONDYLES = Midpoint(("medial humeral epicondyle", "lateral humeral epicondyle"))

KIND = Kind(
    name="arm",
    order=6,
    words={"en": "Arm", "de": "Arm"},
    sided=True,
    round_ended=True,
    places=(
        ACROMION,
        AXILLA,
        OLECRANON,
        LATERAL_HUMERAL_EPICONDYLE,
        MEDIAL_HUMERAL_EPICONDYLE,
        CUBITAL_FOLD,
        RADIAL_STYLOID,
        ULNAR_STYLOID,
        DISTAL_END.at(0),
    ),
    sensitive=(
        SensitivePlace(name="acromion", why="bone under the skin", reach_mm=12.0),
        SensitivePlace(name="axilla", why="vessels and nerves of the arm", reach_mm=15.0),
        SensitivePlace(name="olecranon", why="bone under the skin", reach_mm=12.0),
        SensitivePlace(
            name="medial humeral epicondyle",
            why="bone, and the ulnar nerve runs behind it",
            reach_mm=15.0,
        ),
        SensitivePlace(name="lateral humeral epicondyle", why="bone under the skin", reach_mm=10.0),
        SensitivePlace(name="radial styloid", why="bone under the skin", reach_mm=8.0),
        SensitivePlace(name="ulnar styloid", why="bone under the skin", reach_mm=8.0),
        CUT_END,
    ),
    directions=(
        Line(
            name="elbow",
            start=Midpoint(("medial humeral epicondyle",)),
            end=Midpoint(("lateral humeral epicondyle",)),
        ),
    ),
    sheet=(
        Distance(
            name="elbow_width_mm",
            en="Width of the epicondyles",
            de="Breite der Epikondylen",
            start=Midpoint(("medial humeral epicondyle",)),
            end=Midpoint(("lateral humeral epicondyle",)),
        ),
        Distance(
            name="olecranon_to_end_mm",
            en="Olecranon to the distal end, along the axis",
            de="Olekranon bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("olecranon",)),
            along="long axis",
        ),
        Distance(
            name="acromion_to_end_mm",
            en="Acromion to the distal end, along the axis",
            de="Akromion bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("acromion",)),
            along="long axis",
        ),
        Section(
            name="elbow_girth_mm",
            en="Girth at the epicondyles",
            de="Umfang an den Epikondylen",
            at=_EPICONDYLES,
            normal="long axis",
        ),
        Section(
            name="axilla_girth_mm",
            en="Girth at the axilla",
            de="Umfang an der Achsel",
            at=Midpoint(("axilla",)),
            normal="long axis",
        ),
        Section(
            name="styloid_girth_mm",
            en="Girth at the styloids",
            de="Umfang an den Griffelfortsätzen",
            at=Midpoint(("radial styloid", "ulnar styloid")),
            normal="long axis",
        ),
    ),
)
