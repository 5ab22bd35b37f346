"""A kind of limb as data: landmarks, sensitive places, axes, centreline, measuring sheet.

A kind is one file of the folder `kinds` that holds a `KIND`:

    KIND = Kind(
        name="foot",
        order=3,
        words={"en": "Foot and ankle", "de": "Fuß und Sprunggelenk"},
        sided=True,
        places=(HEEL, ...),
        ...
    )

`known_kinds.py` finds it there. Command line, files, the app's forms and its API offer it, and
everything that a limb of this kind is asked for follows from its fields. Places of the body that
several kinds have are written once, in the kind that has most of them, and taken from there:
`HEEL`, `TIBIAL_TUBERCLE.at(5)`.

Directions are told by places, by the surface and by each other, so they exist in any frame of the
mesh:

    Line(name="shank", start=Midpoint(("medial malleolus", "lateral malleolus")), end=...)
    Plane(name="plantar", through=(...), towards=Midpoint(...))
    Cross(name="lateral", first="foot", second="plantar")
    SurfaceAxis(name="heel bisection", how="halves across", along="plantar", ...)

All are mirrored with the limb: what is lateral on a right one is lateral on a left one. So is the
sense of an angle, and dorsiflexion, varus and toe-out have one sign on both. Every kind also has
"long axis", "anterior" and "right", the limb frame's own.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, Literal, TypeVar

Facing = Literal["anterior", "posterior", "medial", "lateral", "right", "left", "none"]
"""Side of the limb on which a landmark lies; medial and lateral need the limb's side."""


@dataclass(frozen=True)
class Place:
    """A place of the body that clinicians know by name."""

    identity: str
    """Its first name in English, as in every file."""
    en: tuple[str, ...] = ()
    """Other names in English."""
    de: tuple[str, ...] = ()
    """Names in German, the first of which is shown."""
    facing: Facing = "none"
    half: Literal["right", "left", "none"] = "none"
    """Half of the patient in which one of a pair in front or behind lies, on a limb that has both:
    an iliac spine lies as far to its side as forwards."""
    level: int | None = None
    """Order along the limb: one of higher level lies more proximal; equal ones tell nothing. None
    where the name is understood, and not asked for."""

    def at(self, level: int | None) -> "Place":
        """The same place in a kind where it lies at another level."""
        return replace(self, level=level)


@dataclass(frozen=True, kw_only=True)
class SensitivePlace:
    """A place on which nothing should press unless somebody means it."""

    name: str
    why: str
    reach_mm: float
    """How far from the landmark, straight, the place is taken to go."""
    also: tuple[str, ...] = ()
    """Identities of other landmarks that lie on it; its own is its name."""


@dataclass(frozen=True)
class Midpoint:
    """The midpoint of landmarks."""

    of: tuple[str, ...]
    otherwise: tuple[str, ...] = ()
    """In place of these, where one of them was not placed."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """An axis from one place to another; its direction points to the end."""

    name: str
    start: Midpoint
    end: Midpoint
    within: str | None = None
    """The plane in which it is taken to lie: a foot's axis, in the plantar plane."""


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A plane through three places; its direction is its normal."""

    name: str
    through: tuple[Midpoint, Midpoint, Midpoint]
    """All of their first choice; or all of their second, where one of the first was not placed."""
    towards: Midpoint
    """On the side of the plane to which the normal points."""


@dataclass(frozen=True, kw_only=True)
class Cross:
    """The cross product of two directions on a right limb: forward x up is lateral."""

    name: str
    first: str
    second: str


@dataclass(frozen=True, kw_only=True)
class Square:
    """The part of a direction square to another one, such as forward square to upwards."""

    name: str
    of: str
    to: str


@dataclass(frozen=True, kw_only=True)
class Tilted:
    """A direction without landmarks of its own, at usual angles to two others."""

    name: str
    along: str
    """From this one it is turned."""
    above: str
    """Normal of the plane in which `along` lies, upwards."""
    up_deg: float
    """How far it rises above that plane."""
    medial_deg: float
    """How far it points to the medial side of `along`, seen from above."""


@dataclass(frozen=True, kw_only=True)
class SurfaceAxis:
    """An axis fitted to the surface: landmarks only choose the part of it that counts.

    So it hardly hangs on where along the surface they were placed. `surface_lines.py` finds it.
    """

    name: str
    how: Literal["halves", "halves across", "under"]
    """It goes through the middles of the part's sections square to `along`; of those square to the
    line itself, as the bisection of a heel; or it is that of the plane that fits the part from
    below."""
    along: str
    """The direction that the line lies next to."""
    towards: str
    """The direction in which it may lean; of what lies under a part, upwards."""
    start: Midpoint
    end: Midpoint
    """The ends of the part along the line; it fades over a quarter of the way at both."""
    whole: Midpoint
    none: Midpoint
    """The part is whole up to there and fades until there: along the direction square to the other
    two, or upwards under a part."""
    reach: float | None = None
    """To both sides of the line from start to end, as a share of it; None for all."""


Direction = Line | Plane | Cross | Square | Tilted | SurfaceAxis


@dataclass(frozen=True, kw_only=True)
class BentCentreline:
    """A bent centreline through midpoints of landmarks, with rounded corners."""

    nodes: tuple[Midpoint, ...]
    """From proximal to distal."""
    reference: str
    """Landmark in the limb's middle: charts count in distances from the distal dome to it."""
    rounded: float = 0.85
    """How much of the shorter way from a corner to the next node or to the middle between two
    corners the arc takes up."""


@dataclass(frozen=True, kw_only=True)
class LandmarkFrame:
    """The limb frame by landmarks alone, for kinds without a long axis to be fitted."""

    up: str
    """The direction that becomes +Z."""
    forward: str
    """The direction that comes to lie nearest to +Y."""


@dataclass(frozen=True, kw_only=True)
class Item:
    """One figure of a measuring sheet."""

    name: str
    """In files; its ending is its unit: _mm, _deg, _ml, _per_cent."""
    en: str
    de: str
    note: str = ""
    """The formula or the definition, where several are in use."""

    @property
    def words(self) -> Mapping[str, str]:
        """Its name for people, by language."""
        return {"en": self.en, "de": self.de}


@dataclass(frozen=True, kw_only=True)
class Angle(Item):
    """An angle from one direction to another about a third, right-handed on a right limb."""

    of: str
    to: str
    about: str
    zero_deg: float = 0.0
    """What is taken off, so that nought is the neutral position."""
    pitch: tuple[Midpoint, Midpoint] | None = None
    """From heel to ball: what a shoe's heel is higher than its sole inclines this line."""


@dataclass(frozen=True, kw_only=True)
class Distance(Item):
    """A distance between two places: straight, or its part along a direction."""

    start: Midpoint
    end: Midpoint
    along: str | None = None


@dataclass(frozen=True, kw_only=True)
class Extent(Item):
    """The extent along a direction of the surface below a place."""

    along: str
    up: str
    below: Midpoint


@dataclass(frozen=True, kw_only=True)
class Share(Item):
    """One distance of the sheet over another, in per cent."""

    part: str
    whole: str


@dataclass(frozen=True, kw_only=True)
class Difference(Item):
    """One distance of the sheet less another, with its sign."""

    part: str
    less: str


@dataclass(frozen=True, kw_only=True)
class Section(Item):
    """A measure of the section that a plane makes with the limb."""

    at: Midpoint
    """On the plane, and inside the outline that counts."""
    normal: str
    """Direction across which it is cut; "centreline" is that of the curve beside the place."""
    holds: str = ""
    """A direction that lies in the plane: the normal is made square to it."""
    what: Literal["girth", "width", "turn", "half along", "half against"] = "girth"
    """As a tape reads it; the calliper along a direction; how far the longest width is turned from
    that direction, about the normal; the area to the side to which that direction points, and to
    the other one."""
    along: str = ""
    """The direction of a width."""
    parted: Midpoint | None = None
    """Across that direction, halves are parted by the plane through here."""
    beyond_mm: float = 0.0
    """How far beyond the place, along the normal, the plane lies."""


@dataclass(frozen=True, kw_only=True)
class Extreme(Item):
    """The largest or smallest girth across a direction between two places, where it lies, or the
    width there."""

    normal: str
    between: tuple[Midpoint, Midpoint]
    which: Literal["largest", "smallest"]
    height_from: Midpoint | None = None
    """The height of that girth from here, along the direction, in place of the girth."""
    width_along: str = ""
    """The calliper at that height, along this direction, in place of the girth."""


@dataclass(frozen=True, kw_only=True)
class Arch(Item):
    """The apex of a foot's arch, in the upright plane through two places under it."""

    start: Midpoint
    end: Midpoint
    base: str
    """The plane over which it is high."""
    what: Literal["height", "place"]
    """Over the base, or its way from the start along the line to the end."""


@dataclass(frozen=True, kw_only=True)
class Cranial(Item):
    """A figure of a head above its base plane; the formulas stand in `measures/cranial.py`."""

    what: str


AnyItem = Angle | Distance | Extent | Share | Difference | Section | Extreme | Arch | Cranial


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A joint about whose anatomical axis the distal part can be turned.

    The places that tell axis and plane lie on the axis, or well within a part that turns or stays
    whole: so they tell the same joint after the turn.
    """

    name: str
    """In files, and in English sentences."""
    de: str
    """The same in German."""
    sense: Mapping[str, str]
    """What turns by a positive angle, by language."""
    axis: str
    """Direction about which it turns, by the right hand on a right limb."""
    reads: str
    """The angle of the sheet in which people tell how it stands."""
    centre: Midpoint
    """A point on the axis."""
    upper: Midpoint
    """Well within what stays."""
    lower: Midpoint
    """Well within what turns."""
    square: str | None = None
    """The plane that parts the limb is square to this direction of the lower part, as it lies half
    way through the turn; without it, the plane halves the way from the upper part to the lower."""
    twist: bool = False
    """The plane is square to the axis."""
    parted: Midpoint | None = None
    """A point on the plane that parts the limb, where it is not `centre`."""
    below: Midpoint | None = None
    """What lies proximal of here stays, towards `knee`, though it lies beyond the plane: a shank
    that leans over the forefoot."""
    knee: Midpoint | None = None
    rigid: tuple[str, ...] = ()
    """Landmarks whose surroundings stay."""

    @property
    def turn(self) -> str:
        """The purpose of its landmarks, for refusals."""
        return f"turn of the {self.name}"

    def words(self, language: str) -> str:
        """Its label in forms: "Ankle: dorsiflexion positive"."""
        called = self.name.capitalize() if language == "en" else self.de
        return f"{called}: {self.sense[language]}"


@dataclass(frozen=True, kw_only=True)
class Kind:
    """All that is known of a kind of limb."""

    name: str
    """In files and on the command line."""
    order: int
    """In lists."""
    words: Mapping[str, str]
    """Its name for people, by language."""
    sided: bool
    """Whether it is a left or a right one."""
    places: tuple[Place, ...]
    """Those with a level are asked for, in this order."""
    sensitive: tuple[SensitivePlace, ...] = ()
    round_ended: bool = False
    """Whether its distal end is a dome: the place farthest along the long axis."""
    long: bool = True
    """Whether an axis fitted to the surface is its long axis."""
    upright: LandmarkFrame | None = None
    """Its frame by landmarks, where these are placed."""
    directions: tuple[Direction, ...] = ()
    centreline: BentCentreline | None = None
    """None: the straight long axis."""
    sheet: tuple[AnyItem, ...] = ()
    joints: tuple[Joint, ...] = ()
    presets: Mapping[str, float] = field(default_factory=dict[str, float])
    """Build-ups by the identity of a landmark, mm: general trade knowledge, to be edited."""

    @property
    def asked(self) -> tuple[Place, ...]:
        """The places that somebody is asked to mark."""
        return tuple(one for one in self.places if one.level is not None)

    def tilted(self, name: str, up_deg: float | None, medial_deg: float | None) -> "Kind":
        """The kind with a tilted direction at other than the usual angles."""
        return replace(
            self,
            directions=tuple(
                replace(
                    one,
                    up_deg=one.up_deg if up_deg is None else up_deg,
                    medial_deg=one.medial_deg if medial_deg is None else medial_deg,
                )
                if isinstance(one, Tilted) and one.name == name
                else one
                for one in self.directions
            ),
        )

    def names_in(self, what: Any) -> set[str]:
        """All strings inside items, joints and names, and inside the directions that these name."""
        directions = {one.name: one for one in self.directions}
        found: set[str] = set()
        due = list(strings_in(what))
        while due:
            word = due.pop()
            if word not in found:
                found.add(word)
                due += strings_in(directions.get(word))
        return found

    def midpoints_in(self, what: Any) -> tuple[Midpoint, ...]:
        """All midpoints inside items and joints, and inside the directions that these name."""
        names = self.names_in(what)
        named = [one for one in self.directions if one.name in names]
        return tuple(dict.fromkeys(_instances_in((what, named), Midpoint)))


def strings_in(what: Any) -> Iterator[str]:
    """All strings inside a value: in lists, and in the fields of dataclasses."""
    return _instances_in(what, str)


_Instance = TypeVar("_Instance")


def _instances_in(what: Any, of: type[_Instance]) -> Iterator[_Instance]:
    """All values of a type inside a value: in lists, and in the fields of dataclasses."""
    if isinstance(what, of):
        yield what
    elif isinstance(what, list | tuple):
        for one in what:
            yield from _instances_in(one, of)
    elif is_dataclass(what):
        for one in fields(what):
            yield from _instances_in(getattr(what, one.name), of)
