"""The setup: tool, blank and machine, and how well to carve."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.known_words import require_known_words

Radii = Float64[np.ndarray, " n"]


@dataclass(frozen=True, kw_only=True)
class CarveOptions:
    """A four-axis carver: the blank turns about X, a ball-end tool points at its axis."""

    tool_diameter_mm: float = 12.0
    tool_reach_mm: float = 120.0
    """From the tool's tip to its holder."""
    blank_diameter_mm: float | None = None
    """None: the next 10 mm over what the shape needs."""
    blank_length_mm: float | None = None
    """From its free end to the chuck. None: what the shape needs."""
    beyond_tip_mm: float = 5.0
    """How far the blank reaches over the distal tip; not more than the tool's diameter, so that
    nothing is sawn off."""
    spigot_mm: float = 0.0
    """Radius left standing at the distal end for a tailstock; 0 carves the tip."""
    mandrel_diameter_mm: float = 0.0
    """Of a bar through the whole blank, which the tool must not touch; 0 for none."""
    to_mm: float | None = None
    """Height at which to stop; None: the highest at which the surface goes all round."""
    scallop_mm: float = 0.05
    """Height of the ridges that the finishing pass may leave."""
    tolerance_mm: float = 0.01
    """How far straight moves may leave the curved path."""
    pattern: Literal["helix", "rings"] = "helix"
    """Rings go to and fro within one turn."""
    most_turns: int | None = None
    """The helix turns back after so many turns, so that the angle stays between nothing and that;
    None winds on from beginning to end."""
    rough_depth_mm: float = 15.0
    rough_allowance_mm: float = 1.0
    """What roughing leaves for finishing."""
    rough_stepover: float = 0.4
    """Part of the tool's diameter."""
    feed_mm_min: float = 3000.0
    """Of the tool over the surface."""
    plunge_mm_min: float = 800.0
    turn_deg_min: float = 7200.0
    """The fastest that the blank may turn."""
    spindle_rpm: int = 12000
    clearance_mm: float = 10.0
    """Over the blank, for moves that do not cut."""
    a_turns: Literal["tool", "work"] = "tool"
    """What turns counter-clockwise seen from proximal when A grows: the tool round the work (the
    rule of G-code: the work then turns clockwise), or the work itself."""

    def __post_init__(self) -> None:
        require_known_words(self)

    @property
    def ball_mm(self) -> float:
        """Radius of the tool's end."""
        return self.tool_diameter_mm / 2

    @property
    def stepover_mm(self) -> float:
        """Distance between neighbouring passes of the ball's centre, for the wanted scallop."""
        scallop = min(self.scallop_mm, self.ball_mm)
        return 2 * math.sqrt(2 * self.ball_mm * scallop - scallop**2)

    @property
    def standing_mm(self) -> float:
        """Radius that is left uncut everywhere: the spigot, or a little over the mandrel."""
        mandrel = self.mandrel_diameter_mm
        return max(self.spigot_mm, mandrel / 2 + _MANDREL_GAP_MM if mandrel else 0.0)

    @property
    def floor_mm(self) -> float:
        """Least distance of the ball's centre from the axis."""
        return self.standing_mm + self.ball_mm if self.standing_mm else 0.0


DEFAULTS = CarveOptions()
FAST: dict[str, float] = {
    "tool_diameter_mm": 19.0,
    "scallop_mm": 0.15,
    "tolerance_mm": 0.03,
    "rough_stepover": 0.5,
    "rough_depth_mm": 25.0,
}
"""For a model that is sanded anyway: ridges of 0.15 mm, wide ways."""
_MANDREL_GAP_MM = 1.0
_ROUND_TIP_MM = 30.0
"""Up to so far over the distal end a shape may be thinner than the mandrel: there it is round."""

_SMALLEST_BLANK_MM, _LARGEST_BLANK_MM = 1.0, 3000.0
"""No carver for limbs or torsos takes a larger one."""
LIMITS: dict[str, tuple[float, float]] = {
    "tool_diameter_mm": (1, 60),
    "tool_reach_mm": (5, 1000),
    "spigot_mm": (0, 100),
    "mandrel_diameter_mm": (0, 100),
    "scallop_mm": (0.001, 2),
    "tolerance_mm": (0.001, 0.04),
    "rough_depth_mm": (0.5, 100),
    "rough_allowance_mm": (0.1, 10),
    "rough_stepover": (0.05, 0.8),
    "feed_mm_min": (10, 50_000),
    "plunge_mm_min": (10, 50_000),
    "turn_deg_min": (36, 360_000),
    "spindle_rpm": (0, 60_000),
    "clearance_mm": (1, 200),
}
"""Between what each value of a carver lies."""


def check_options(options: CarveOptions) -> None:
    """Refuse values that no carver can have."""
    for name, (low, high) in LIMITS.items():
        value = float(getattr(options, name))
        if not low <= value <= high:
            raise OptionsError(
                "carve.option.beyond", option=name, given=value, least=float(low), most=float(high)
            )
    for name in ("blank_diameter_mm", "blank_length_mm"):
        value = getattr(options, name)
        if value is not None and not _SMALLEST_BLANK_MM <= value <= _LARGEST_BLANK_MM:
            raise OptionsError(
                "carve.option.beyond",
                option=name,
                given=value,
                least=_SMALLEST_BLANK_MM,
                most=_LARGEST_BLANK_MM,
            )
    if options.most_turns is not None and options.most_turns < 2:
        raise OptionsError("carve.turns.few")
    if not 0 <= options.beyond_tip_mm <= options.tool_diameter_mm:
        raise OptionsError(
            "carve.blank.over_tip",
            beyond_tip_mm=options.beyond_tip_mm,
            tool_diameter_mm=options.tool_diameter_mm,
        )


@dataclass(frozen=True, kw_only=True)
class Blank:
    """A cylinder round the long axis; heights in the limb frame."""

    radius_mm: float
    from_mm: float
    """Free end."""
    to_mm: float
    """Where carving ends; the chuck lies the tool's radius beyond, or more."""

    @property
    def length_mm(self) -> float:
        return self.to_mm - self.from_mm


def fit_blank(options: CarveOptions, radius_mm: float, low_mm: float, high_mm: float) -> Blank:
    """The blank for a shape of this radius between these heights; refuses one that is too small."""
    needed_mm = high_mm - low_mm + options.beyond_tip_mm + options.ball_mm
    diameter_mm = options.blank_diameter_mm or 10 * math.ceil((2 * radius_mm + 2) / 10)
    if diameter_mm < 2 * radius_mm:
        raise CarveError(
            "carve.blank.thin", diameter_mm=float(diameter_mm), needed_mm=2 * radius_mm
        )
    if options.blank_length_mm is not None and options.blank_length_mm < needed_mm:
        raise CarveError(
            "carve.blank.short",
            length_mm=options.blank_length_mm,
            needed_mm=needed_mm,
            beyond_tip_mm=options.beyond_tip_mm,
            to_chuck_mm=options.ball_mm,
        )
    return Blank(radius_mm=diameter_mm / 2, from_mm=low_mm - options.beyond_tip_mm, to_mm=high_mm)


def check_mandrel(options: CarveOptions, radii_mm: Radii, over_tip_mm: Radii) -> None:
    """Refuse a shape that does not cover the mandrel, except for its round tip."""
    if not options.mandrel_diameter_mm:
        return
    bare = (radii_mm < options.standing_mm) & (over_tip_mm > _ROUND_TIP_MM)
    if bare.any():
        worst = int(np.argmin(np.where(bare, radii_mm, np.inf)))
        raise CarveError(
            "carve.mandrel.bare",
            mandrel_diameter_mm=options.mandrel_diameter_mm,
            radius_mm=float(radii_mm[worst]),
            over_tip_mm=float(over_tip_mm[worst]),
            needed_mm=options.standing_mm,
        )


def check_reach(options: CarveOptions, blank: Blank, lowest_tip_mm: float) -> None:
    """Refuse a tool whose holder would enter the blank at the deepest cut."""
    needed_mm = blank.radius_mm - lowest_tip_mm
    if options.tool_reach_mm < needed_mm:
        raise CarveError("carve.tool.short", reach_mm=options.tool_reach_mm, needed_mm=needed_mm)
