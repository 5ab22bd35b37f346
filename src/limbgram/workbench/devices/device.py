"""Device: a kind of orthosis or socket as data: its edges, wall, fittings and measures.

A device is one file of the folder `kinds`, with `DEVICE = Device(...)`; the command line, the app's
tables and the tests follow from it. All ranges are general knowledge of the trade where no source
stands beside them: a clinic sets its own.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Annotated, Literal

from limbgram.core.notebook import brief
from limbgram.core.request_fields import Within
from limbgram.findings.tell import add_terms
from limbgram.workbench.devices import kinds
from limbgram.workbench.devices.trims import Amount, Measure, Trim, TrimPoint, measures_in

Fabrication = Literal["printed", "draped"]
FlexedJoint = Literal["knee", "hip"]
"""Where it flexes, a knee takes the end of the limb backwards, a hip forwards."""


@dataclass(frozen=True, kw_only=True)
class EdgeMargin:
    """The distance over the surface that a slot keeps from an edge."""

    edge: str
    """A loop of the trim, or the opening of a slit."""
    margin_mm: Amount
    """From the edge as it was drawn to the slot's nearest side."""
    away: Literal["up", "down", "round", "back"]
    """Direction from the edge: up or down the limb, round it as angles grow, or back."""
    stretch: tuple[str, str] | None = None
    """From one point of the loop onwards to another; all of it without."""


@dataclass(frozen=True, kw_only=True)
class Slot:
    """A slot for a strap, or a vent, cut through the shell."""

    name: str
    at: TrimPoint
    """Its middle; only a start where it keeps margins to edges."""
    length_mm: Amount
    width_mm: Amount
    upright: bool = True
    """Its length runs up the limb; else round it."""
    strap: Amount = 0.0
    """Width of the strap through it, which presses beside it; zero for a vent."""
    asked: Amount = 1.0
    """It is cut where this is more than zero."""
    inside: tuple[EdgeMargin, ...] = ()
    """The margins that place it, at most one for each direction."""
    yields: str = ""
    """The measure that moves it out of the way of other straps, where nobody gave it."""


@dataclass(frozen=True, kw_only=True)
class Pad:
    """A place where a printed wall is thicker."""

    name: str
    at: TrimPoint
    reach_mm: float
    falloff_mm: float
    add_mm: Amount


@dataclass(frozen=True, kw_only=True)
class WallZone:
    """A place where somebody wants a printed wall thicker, or thinner, than the device has it."""

    at: str
    """The landmark at its centre."""
    add_mm: Annotated[float, Within(-6.0, 12.0)]
    """Thinner where negative."""
    reach_mm: Annotated[float, Within(5.0, 200.0)]
    """Distance over the surface from its centre to where it begins to fall off."""


@dataclass(frozen=True, kw_only=True)
class Ridge:
    """A rib through points, on a printed wall."""

    name: str
    through: tuple[TrimPoint, ...]
    width_mm: float
    falloff_mm: float
    add_mm: Amount


@dataclass(frozen=True, kw_only=True)
class Seat:
    """A flat round seat for a joint or a stop, drilled along an axis between two landmarks."""

    name: str
    at: TrimPoint
    axis: tuple[str, str]
    """From and to: the seat faces along it, or against it, whichever leads outwards."""
    radius_mm: float
    rise_mm: float
    """Height of the flat face above the outer side."""
    hole_mm: Amount


@dataclass(frozen=True, kw_only=True)
class Slit:
    """An opening from the upper to the lower edge."""

    side: Literal["anterior", "posterior"]
    width_mm: Amount

    @property
    def name(self) -> str:
        return "front opening" if self.side == "anterior" else "back opening"


@dataclass(frozen=True, kw_only=True)
class WidthCheck:
    """A width of the positive that is compared with one measured on the patient."""

    measure: str
    at: str
    """Landmark at whose height it is taken, from side to side as by a calliper."""


@dataclass(frozen=True, kw_only=True)
class Label:
    """Where the outer side of a printed wall can be lettered."""

    at: TrimPoint
    """Middle of the text."""
    runs: Literal["up", "round", "ahead"]
    """Its direction: up the limb, level round it, or along the foot."""


@dataclass(frozen=True, kw_only=True)
class Device:
    """A kind of device."""

    name: str
    kind: str
    """Of limb."""
    order: int
    en: str
    de: str
    trim: Trim
    label: Label
    wall: Mapping[Fabrication, Measure]
    """Its thickness for each way of fabrication; the first is the usual one."""
    slots: tuple[Slot, ...] = ()
    pads: tuple[Pad, ...] = ()
    ridges: tuple[Ridge, ...] = ()
    seats: tuple[Seat, ...] = ()
    slits: tuple[Slit, ...] = ()
    adapter: FlexedJoint | None = None
    """The joint above, if a modular adapter with its alignment stands under the distal end."""
    widths: tuple[WidthCheck, ...] = ()
    more: tuple[Measure, ...] = ()
    """Measures beside those of the trim, the wall and the adapter."""

    __repr__ = brief

    def measures(self, made: Fabrication) -> tuple[Measure, ...]:
        """All measures, in the order of forms; a draped sheet has no pads and no ribs."""
        fitted = ADAPTER if self.adapter else ()
        drawn = (DRAW,) if made == "draped" else ()
        thicker = measures_in([one.add_mm for one in (*self.pads, *self.ridges)])
        more = [one for one in self.more if made == "printed" or one.name not in thicker]
        return (*self.trim.measures, self.wall[made], *drawn, *more, *fitted)

    @property
    def landmarks(self) -> tuple[str, ...]:
        """The landmarks that its edges and fittings need, each once."""
        points = (
            *(one.at for one in (*self.slots, *self.pads, *self.seats)),
            *(point for ridge in self.ridges for point in ridge.through),
        )
        named = [name for point in points for name in (point.at, point.towards) if name]
        axes = [name for seat in self.seats for name in seat.axis]
        widths = [one.at for one in self.widths]
        return tuple(dict.fromkeys([*self.trim.landmarks(), *named, *axes, *widths]))

    @property
    def usual_fabrication(self) -> Fabrication:
        return next(iter(self.wall))

    @property
    def words(self) -> Mapping[str, str]:
        return {"en": self.en, "de": self.de}


SHEET = Measure(
    name="sheet_mm",
    usual=4.8,
    within=Within(2, 12),
    en="Sheet before it is draped",
    de="Platte vor dem Tiefziehen",
)
DRAW = Measure(
    name="draw_mm",
    usual=16.0,
    within=Within(8, 60),
    en="Length over which the soft sheet draws in; by 16 mm a heel loses a third",
    de="Länge, über die die weiche Platte nachfließt; bei 16 mm verliert eine Ferse ein Drittel",
)
WALL = Measure(name="wall_mm", usual=3.5, within=Within(2, 8), en="Wall", de="Wandstärke")
ORTHOSIS: Mapping[Fabrication, Measure] = {"draped": SHEET, "printed": WALL}
SOCKET: Mapping[Fabrication, Measure] = {
    "printed": Measure(name="wall_mm", usual=5.0, within=Within(3, 10), en="Wall", de="Wandstärke"),
    "draped": Measure(
        name="sheet_mm",
        usual=12.0,
        within=Within(6, 15),
        en="Sheet before it is draped",
        de="Platte vor dem Tiefziehen",
    ),
}
ADAPTER = (
    Measure(
        name="flexion_deg",
        usual=5.0,
        within=Within(-5, 30),
        en="Flexion of the socket",
        de="Beugung des Schafts",
    ),
    Measure(
        name="adduction_deg",
        usual=5.0,
        within=Within(-10, 20),
        en="Adduction of the socket",
        de="Adduktion des Schafts",
    ),
    Measure(
        name="toe_out_deg",
        usual=5.0,
        within=Within(-10, 20),
        en="Toe-out of the foot",
        de="Außenrotation des Fußes",
    ),
    Measure(
        name="inset_mm",
        usual=0.0,
        within=Within(-20, 20),
        en="Inset of the foot, medially",
        de="Versatz des Fußes nach medial",
    ),
    Measure(
        name="forward_mm",
        usual=0.0,
        within=Within(-20, 40),
        en="Adapter in front of the line through the middle of the socket",
        de="Adapter vor der Linie durch die Schaftmitte",
    ),
    Measure(
        name="build_mm",
        usual=10.0,
        within=Within(4, 60),
        en="From the shell's end to the plate",
        de="Vom Schaftende zur Platte",
    ),
    Measure(
        name="plate_mm",
        usual=65.0,
        within=Within(55, 82),
        en="Width of the plate; its four holes lie 36 mm apart",
        de="Breite der Platte; ihre vier Löcher liegen 36 mm auseinander",
    ),
    Measure(
        name="plate_height_mm",
        usual=14.0,
        within=Within(10, 23),
        en="Height of the plate",
        de="Höhe der Platte",
    ),
    Measure(
        name="hole_mm",
        usual=6.5,
        within=Within(5, 8),
        en="Holes of the plate",
        de="Löcher der Platte",
    ),
    Measure(
        name="pyramid_mm",
        usual=0.0,
        within=Within(0, 18),
        en="Height of a male pyramid under the plate; 0 for none",
        de="Höhe einer Pyramide unter der Platte; 0 für keine",
    ),
    Measure(
        name="pilot_mm",
        usual=0.0,
        within=Within(0, 14),
        en="Hole through the end, for a pin or a vent; 0 for none",
        de="Bohrung durch das Ende, für Stift oder Entlüftung; 0 für keine",
    ),
)


def _load_devices() -> Iterator[Device]:
    for file in iter_modules(kinds.__path__):
        yield import_module(f"{kinds.__name__}.{file.name}").DEVICE


@cache
def devices() -> Mapping[str, Device]:
    """Every kind of device by its name, in the order of lists."""
    add_terms(_terms)
    return {one.name: one for one in sorted(_load_devices(), key=lambda one: one.order)}


def _terms(language: str) -> dict[str, str]:
    """Names of devices and their measures in a language, by the English ones."""
    found: dict[str, str] = {}
    for one in devices().values() if language == "de" else ():
        measures = (each for made in one.wall for each in one.measures(made))
        found |= {one.en: one.de, **{each.en: each.de for each in measures}}
    return found
