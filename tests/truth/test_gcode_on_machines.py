"""Programs carried out by a machine of our own making, which knows no plan, only the text.

It reads each control's language by that control's rules (modal groups, feed, offsets, rollover),
takes material off a blank, and the shape that is left is held against the formula of the limb.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.gcode.control import Control
from limbgram.formats.gcode.writing import write_gcode
from limbgram.workbench.carving.setup import FAST, CarveOptions
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame

Radius = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""mm, of height and of the angle from the front towards the patient's right."""

TALL_MM, TOOL_MM, FEED, TURN = 56.0, 16.0, 2400.0, 7200.0
CARVE = CarveOptions(
    tool_diameter_mm=TOOL_MM,
    scallop_mm=0.2,
    tolerance_mm=0.02,
    rough_depth_mm=20.0,
    feed_mm_min=FEED,
    turn_deg_min=TURN,
    plunge_mm_min=600.0,
    spindle_rpm=9000,
)
LIMIT_DEG = 1440.0


# The limbs, by formula.


def calf(z: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Wider above, a crest in front, a bulge behind on the right, and a round end."""
    wall = 27 + 0.06 * z + 3 * np.exp(3 * (np.cos(theta) - 1)) - 2 * np.cos(2 * theta)
    wall = wall + 4 * np.exp(-(((z - 38) / 12) ** 2)) * np.exp(4 * (np.cos(theta - 2.4) - 1))
    return wall * dome(z, 22.0)


def leaning(z: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Round, and thrown over to one side as it rises."""
    off = 0.1 * z
    wall = off * np.cos(theta - 1.0) + np.sqrt(29.0**2 - (off * np.sin(theta - 1.0)) ** 2)
    return wall * dome(z, 26.0)


def dome(z: np.ndarray, high_mm: float) -> np.ndarray:
    inside = np.clip(z / high_mm, 0, 1)
    return np.sqrt(np.clip(1 - (1 - inside) ** 2, 0, None))


def limb_of(radius: Radius) -> Limb:
    """Its surface, in an aligned limb."""
    rise = np.linspace(0, 1, 91)[1:] ** 1.5 * TALL_MM
    turns = 2 * np.pi * np.arange(180) / 180
    z, theta = np.meshgrid(rise, turns, indexing="ij")
    r = radius(z, theta)
    wall = np.stack([r * np.sin(theta), r * np.cos(theta), z], -1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(89), np.arange(180), indexing="ij"))
    here, beside = i * 180 + j, i * 180 + (j + 1) % 180
    k = np.arange(180)
    faces = np.concatenate(
        [
            np.column_stack([beside, here, beside + 180]),
            np.column_stack([here, here + 180, beside + 180]),
            np.column_stack([k, (k + 1) % 180, np.full(180, 90 * 180)]),
        ]
    )
    mesh = Mesh(vertices_mm=np.vstack([wall, [[0.0, 0, 0]]]), faces=faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="right"))


# The machine.


class Fault(Exception):
    """What a control would stop at, or a machine be harmed by."""


@dataclass(frozen=True)
class Rules:
    """What a control reads, as its makers say."""

    codes: frozenset[str]
    angles_in_feed: bool
    """Feed per minute counts degrees as millimetres; else of the linear axes alone."""
    wraps: str
    """How it takes the rotary axis when that is set to roll over."""
    dwell_unit_s: float
    percent: bool = False


_COMMON = "G0 G1 G4 G17 G21 G40 G49 G54 G80 G90 G92 G93 G94 M3 M5 M8 M7 M9 M30"
RULES = {
    "linuxcnc": Rules(frozenset(f"{_COMMON} G43 G64 M6".split()), False, "sign", 1.0),
    "mach": Rules(frozenset(f"{_COMMON} G43 G64 M6".split()), False, "none", 1.0),
    "fanuc": Rules(frozenset(f"{_COMMON} G43 M6".split()), True, "shortest", 0.001, True),
    "grbl": Rules(frozenset(_COMMON.split()), True, "none", 1.0),
}
GROUPS = [
    {"G0", "G1", "G80"},
    {"G17"},
    {"G21"},
    {"G90"},
    {"G93", "G94"},
    {"G40"},
    {"G43", "G49"},
    {"G54"},
    {"M3", "M5"},
    {"G4", "G92"},
]
NEEDED = {"G21", "G17", "G40", "G54", "G80", "G90", "G94"}


@dataclass
class Motion:
    """One straight move as the axes make it."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    """X, physical turn of the rotary axis in degrees, Z."""
    rapid: bool
    minutes: float
    line: int


@dataclass
class Control4:
    """The state of a four-axis control."""

    rules: Rules
    letter: str = "A"
    rolls: bool = False
    a_limit: float = LIMIT_DEG
    place: dict[str, float] = field(default_factory=lambda: {"X": -50.0, "A": 0.0, "Z": 120.0})
    offset: float = 0.0
    modal: set[str] = field(default_factory=set)
    feed: float | None = None
    spindle: bool = False
    waited: float = 0.0
    ended: bool = False
    motions: list[Motion] = field(default_factory=list)

    def run(self, text: str) -> None:
        lines = text.splitlines()
        if self.rules.percent:
            lines = self._between_percents(lines)
        for number, line in enumerate(lines, 1):
            if self.ended:
                raise Fault(f"line {number}: after the end")
            self._block(line, number)
        if not self.ended or self.spindle:
            raise Fault("no end, or the spindle still runs")

    def _between_percents(self, lines: list[str]) -> list[str]:
        if lines[0] != "%" or lines[-1] != "%" or not re.fullmatch(r"O\d{4}.*", lines[1]):
            raise Fault("no program between % signs with an O number")
        if "".join(lines) != "".join(lines).upper():
            raise Fault("small letters")
        for line in lines[2:-1]:
            for letter, value in re.findall(r"([XYZABCF])(-?[\d.]+)", re.sub(r"\(.*\)", "", line)):
                if "." not in value:
                    raise Fault(f"{letter}{value} would be in thousandths")
        return lines[2:-1]

    def _block(self, line: str, number: int) -> None:
        plain = re.sub(r"\([^()]*\)", "", line).strip()
        if "(" in plain or ")" in plain or len(plain) > 80:
            raise Fault(f"line {number}: {line}")
        words: dict[str, float] = {}
        texts: dict[str, str] = {}
        codes: list[str] = []
        for token in plain.split():
            found = re.fullmatch(r"([A-Z])(-?\d+(?:\.\d+)?)", token)
            if found is None:
                raise Fault(f"line {number}: {token}")
            if found[1] in "GM":
                codes.append(token)
            elif found[1] in words:
                raise Fault(f"line {number}: {found[1]} twice")
            else:
                words[found[1]], texts[found[1]] = float(found[2]), found[2]
        if set(codes) - self.rules.codes:
            raise Fault(f"line {number}: {codes} is not known")
        for group in GROUPS:
            if len(group & set(codes)) > 1:
                raise Fault(f"line {number}: two of {group}")
            if group & set(codes):
                self.modal -= group
        self.modal |= set(codes)
        self._act(set(codes), words, texts, number)

    def _act(self, codes: set[str], words: dict[str, float], texts: dict[str, str], n: int) -> None:
        if "F" in words:
            self.feed = words["F"]
        if "M3" in codes:
            self.spindle = True
        if "M5" in codes:
            self.spindle = False
        if "M30" in codes:
            self.ended = True
        if "G4" in codes:
            self.waited += words["P"] * self.rules.dwell_unit_s
            return
        if "G92" in codes:
            if set(words) != {self.letter}:
                raise Fault(f"line {n}: G92 of {words}")
            self.offset = self.place["A"] - words[self.letter]
            return
        if codes & {"G43", "G64"} or not set(words) & {"X", "Z", self.letter}:
            return
        if {"Y", "B", "C", "A"} - {self.letter} & set(words):
            raise Fault(f"line {n}: a foreign axis")
        if not NEEDED - {"G94", "G80"} <= self.modal or not self.modal & {"G0", "G1"}:
            raise Fault(f"line {n}: moves before it is told in what")
        after = dict(self.place)
        after.update({name: words[name] for name in ("X", "Z") if name in words})
        if self.letter in words:
            after["A"] = self._turned(words[self.letter], texts[self.letter], n)
        self._move(after, "F" in words, n)

    def _turned(self, word: float, text: str, n: int) -> float:
        if not self.rolls:
            if abs(word) > self.a_limit:
                raise Fault(f"line {n}: {self.letter}{word} beyond {self.a_limit}")
            return word + self.offset
        now = self.place["A"]
        if abs(word) >= 360:
            raise Fault(f"line {n}: {self.letter}{word} is more than a turn")
        if self.rules.wraps == "shortest":
            way = (word - now + 180) % 360 - 180
            return now + way
        # By the sign: the next place of that size above, or below, wherever it stands now.
        target = abs(word) + 360 * np.floor(now / 360)
        if text.startswith("-"):
            return float(target - 360 if target > now else target)
        return float(target + 360 if target < now else target)

    def _move(self, after: dict[str, float], own_feed: bool, n: int) -> None:
        dx, da, dz = (after[name] - self.place[name] for name in "XAZ")
        rapid = "G0" in self.modal
        minutes = 0.0
        if not rapid:
            if not self.spindle or self.feed is None or self.feed <= 0:
                raise Fault(f"line {n}: cuts without spindle or feed")
            if "G93" in self.modal:
                if not own_feed:
                    raise Fault(f"line {n}: G93 without F")
                minutes = 1 / self.feed
            elif self.rules.angles_in_feed:
                minutes = float(np.sqrt(dx**2 + da**2 + dz**2)) / self.feed
            else:
                minutes = (float(np.hypot(dx, dz)) or abs(da)) / self.feed
        start = (self.place["X"], self.place["A"], self.place["Z"])
        self.place = after
        end = (after["X"], after["A"], after["Z"])
        self.motions.append(Motion(start, end, rapid, minutes, n))


# The stock.

CELL_MM, CELL_DEG = 0.5, 1.5


@dataclass
class Stock:
    """A cylinder as radii by place along the axis and by angle from the front to the right."""

    from_mm: float
    to_mm: float
    blank_mm: float
    turns_tool: bool
    radii: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.x = np.arange(self.from_mm + CELL_MM / 2, self.to_mm, CELL_MM)
        self.theta = np.radians(np.arange(0, 360, CELL_DEG))
        self.radii = np.full((len(self.x), len(self.theta)), self.blank_mm)

    def cut(self, x: float, a_deg: float, tip: float, ball: float) -> None:
        """A ball on a shank as thick, that points at the axis, at one place."""
        towards = np.radians(-a_deg if self.turns_tool else a_deg)
        centre = tip + ball
        _cut(self.radii, self.x - x, self.theta - towards, centre, ball)


@njit(cache=True)
def _cut(
    radii: np.ndarray, along_mm: np.ndarray, turn: np.ndarray, centre: float, ball: float
) -> None:
    """Lower the radii to a ball whose centre lies at this radius, at zero along and turned by zero.

    Compiled: a program cuts at ten thousand places.
    """
    for column in range(len(turn)):
        above, aside = centre * np.cos(turn[column]), centre * np.sin(turn[column])
        if above <= 0 or abs(aside) >= ball:
            continue
        for row in range(len(along_mm)):
            room2 = ball**2 - along_mm[row] ** 2 - aside**2
            if room2 > 0:
                inner = max(above - np.sqrt(room2), 0.0)
                radii[row, column] = min(radii[row, column], inner)


def carried_out(
    text: str, control: Control4, stock: Stock, ball: float, core: float = -np.inf
) -> None:
    """Run a program, and take away what it cuts.

    Raises:
        Fault: the control stops, a rapid move goes into the blank, or the tool into the core.
    """
    control.run(text)
    for motion in control.motions:
        (x0, a0, z0), (x1, a1, z1) = motion.start, motion.end
        if min(z0, z1) < core:
            raise Fault(f"line {motion.line}: into the mandrel")
        if abs(a1 - a0) > 180 and motion.line > 40:
            raise Fault(f"line {motion.line}: turns {a1 - a0:.0f} degrees at once")
        if motion.rapid:
            straight_out = x0 == x1 and a0 == a1 and z1 >= z0
            if min(z0, z1) < stock.blank_mm and not straight_out:
                raise Fault(f"line {motion.line}: rapid into the blank")
            continue
        reach = max(abs(x1 - x0), abs(z1 - z0), np.radians(abs(a1 - a0)) * (max(z0, z1) + ball))
        steps = max(1, int(np.ceil(reach / 1.0)))
        for share in (np.arange(steps) + 1) / steps:
            stock.cut(x0 + share * (x1 - x0), a0 + share * (a1 - a0), z0 + share * (z1 - z0), ball)


@dataclass
class Judged:
    """What is left against the formula, along the normal."""

    gouge_mm: float
    ridge_mm: float
    """95 of 100 cells have less left."""
    highest_mm: float
    """The most left anywhere."""
    over_tip_mm: float
    """Largest radius of what stands beyond the distal end."""


def judged(stock: Stock, radius: Radius) -> Judged:
    grid_x, grid_t = np.meshgrid(stock.x, stock.theta, indexing="ij")
    on = (grid_x > 2.0) & (grid_x < TALL_MM - 1.0)
    step = 1e-4
    true = radius(grid_x, grid_t)
    up = (radius(grid_x + step, grid_t) - radius(grid_x - step, grid_t)) / (2 * step)
    aside = (radius(grid_x, grid_t + step) - radius(grid_x, grid_t - step)) / (2 * step)
    cosine = 1 / np.sqrt(1 + up**2 + (aside / np.maximum(true, 1.0)) ** 2)
    left = ((stock.radii - true) * cosine)[on]
    beyond = stock.radii[stock.x < -1.0]
    return Judged(
        gouge_mm=float(max(-left.min(), 0)),
        ridge_mm=float(np.quantile(left, 0.95)),
        highest_mm=float(left.max()),
        over_tip_mm=float(beyond.max()) if len(beyond) else 0.0,
    )


def speeds(control: Control4, ball: float) -> tuple[np.ndarray, np.ndarray]:
    """Of cutting moves that turn: speed of the ball's centre, mm/min, and turning, degrees/min."""
    over, turning = [], []
    for motion in control.motions:
        (x0, a0, z0), (x1, a1, z1) = motion.start, motion.end
        if motion.rapid or a0 == a1:
            continue
        way_round = np.radians(a1 - a0) * ((z0 + z1) / 2 + ball)
        way = np.sqrt((x1 - x0) ** 2 + (z1 - z0) ** 2 + way_round**2)
        over.append(way / motion.minutes)
        turning.append(abs(a1 - a0) / motion.minutes)
    return np.array(over), np.array(turning)


@pytest.fixture(scope="module", params=[pytest.param("calf", marks=pytest.mark.slow), "leaning"])
def shape(request: pytest.FixtureRequest) -> tuple[Limb, Radius]:
    radius = {"calf": calf, "leaning": leaning}[request.param]
    return limb_of(radius), radius


def on(control: Control) -> Control4:
    return Control4(
        RULES[control.dialect],
        letter=control.letter,
        rolls=control.winding == "rollover",
        a_limit=control.a_limit_deg,
    )


PROFILES = {
    "linuxcnc": Control(a_limit_deg=LIMIT_DEG),
    "linuxcnc rollover": Control(winding="rollover"),
    "mach reset": Control(dialect="mach", winding="reset", a_limit_deg=LIMIT_DEG, coolant="mist"),
    "fanuc": Control(dialect="fanuc", a_limit_deg=LIMIT_DEG, tool_number=7, program_number=42),
    "fanuc rollover": Control(dialect="fanuc", winding="rollover", feed="per-minute"),
    "grbl": Control(dialect="grbl", a_limit_deg=LIMIT_DEG, rotary_word="Y"),
    "grbl reset": Control(dialect="grbl", winding="reset", feed="inverse-time", a_limit_deg=800),
}
QUICK = ("linuxcnc", "mach reset", "fanuc rollover", "grbl")
"""Every control's language, and every way to keep the angles within their limit."""


@pytest.mark.parametrize(
    "profile",
    [pytest.param(one, marks=[] if one in QUICK else pytest.mark.slow) for one in PROFILES],
)
def test_every_profile_carves_the_limb(tmp_path: Path, shape, profile: str) -> None:
    limb, radius = shape
    control = PROFILES[profile]
    # Where the work turns the angles go down, which is the harder half of the rollovers.
    options = replace(CARVE, a_turns="work" if profile.endswith("rollover") else "tool")
    report = write_gcode(limb, tmp_path / "limb.nc", options, control)
    blank = report.toolpath.blank
    stock = Stock(blank.from_mm, blank.to_mm, blank.radius_mm, options.a_turns == "tool")
    machine = on(control)
    carried_out(report.path.read_text("ascii"), machine, stock, TOOL_MM / 2)
    found = judged(stock, radius)
    assert found.gouge_mm < 0.05
    assert 0.05 < found.ridge_mm < 0.2
    # Without a turn on the spot where a helix turns back, 0.7 mm stand between two ways.
    assert found.highest_mm < 0.3
    assert found.over_tip_mm < 0.01
    assert machine.waited == pytest.approx(control.spindle_start_s)
    over, turning = speeds(machine, TOOL_MM / 2)
    assert over.max() < 1.02 * FEED
    assert turning.max() < 1.01 * TURN
    held = np.maximum(over / FEED, turning / TURN)
    assert np.quantile(held, 0.02) > 0.97, "as fast as may be, nearly everywhere"
    turned = np.array([motion.end[1] for motion in machine.motions])
    if control.winding == "unwind":
        assert 720 <= np.ptp(turned) <= LIMIT_DEG
    else:
        assert np.ptp(turned) > LIMIT_DEG, "it did need taking care of"


def test_rings_stay_within_a_turn(tmp_path: Path) -> None:
    control = Control(a_limit_deg=720)
    options = replace(CARVE, pattern="rings")
    report = write_gcode(limb_of(calf), tmp_path / "limb.nc", options, control)
    blank = report.toolpath.blank
    stock = Stock(blank.from_mm, blank.to_mm, blank.radius_mm, turns_tool=True)
    machine = on(replace(control, a_limit_deg=360))
    carried_out(report.path.read_text("ascii"), machine, stock, TOOL_MM / 2)
    assert judged(stock, calf).gouge_mm < 0.05
    turned = [motion.end[1] for motion in machine.motions]
    assert (min(turned), max(turned)) == (0.0, 360.0)


def test_a_mandrel_is_left_alone(tmp_path: Path) -> None:
    """It stands through the tip; the rest of the limb is carved as without it."""
    options = replace(CARVE, mandrel_diameter_mm=16.0)
    report = write_gcode(limb_of(calf), tmp_path / "limb.nc", options)
    blank = report.toolpath.blank
    stock = Stock(blank.from_mm, blank.to_mm, blank.radius_mm, turns_tool=True)
    machine = on(Control())
    carried_out(report.path.read_text("ascii"), machine, stock, TOOL_MM / 2, core=8.0)
    found = judged(stock, calf)
    assert found.gouge_mm < 0.05
    assert stock.radii.min() == pytest.approx(9.0, abs=0.01)
    assert stock.radii[0].max() < 9.5
    with pytest.raises(CarveError, match="would stand out of the shape"):
        write_gcode(limb_of(calf), tmp_path / "b.nc", replace(options, mandrel_diameter_mm=58.0))


def test_the_fast_preset_saves_time_and_size_and_cuts_into_nothing(tmp_path: Path) -> None:
    limb = limb_of(calf)
    fine = write_gcode(limb, tmp_path / "fine.nc", CarveOptions())
    options = replace(CarveOptions(), **FAST)
    fast = write_gcode(limb, tmp_path / "fast.nc", options)
    # Of a limb as short as this the ends take much; of one of 260 mm fast takes 0.42 of the time.
    assert fast.check.minutes < 0.6 * fine.check.minutes
    assert fast.path.stat().st_size < 0.35 * fine.path.stat().st_size
    blank = fast.toolpath.blank
    stock = Stock(blank.from_mm, blank.to_mm, blank.radius_mm, turns_tool=True)
    machine = on(replace(Control(), a_limit_deg=9999))
    carried_out(fast.path.read_text("ascii"), machine, stock, options.ball_mm)
    found = judged(stock, calf)
    assert found.gouge_mm < 0.05
    assert found.ridge_mm < 0.25
    minutes = sum(motion.minutes for motion in machine.motions)
    assert minutes == pytest.approx(fast.check.minutes, rel=0.01)


def test_winding_on_is_refused_beyond_the_limit_and_kept_below(tmp_path: Path) -> None:
    limb = limb_of(leaning)
    wound = Control(winding="continuous", a_limit_deg=LIMIT_DEG)
    with pytest.raises(CarveError, match=r"wind up to [\d,]+ degrees and 1,440"):
        write_gcode(limb, tmp_path / "limb.nc", CARVE, wound)
    assert not (tmp_path / "limb.nc").exists()
    far = replace(wound, a_limit_deg=1e6)
    report = write_gcode(limb, tmp_path / "limb.nc", CARVE, far)
    assert report.rotary_deg[1] > 5 * LIMIT_DEG


@pytest.mark.parametrize(
    ("control", "says"),
    [
        (Control(dialect="mach", winding="rollover"), "turn back a whole turn"),
        (Control(dialect="grbl", winding="rollover"), "turn back a whole turn"),
        (Control(dialect="linuxcnc", feed="per-minute"), "speed over the surface"),
        (Control(dialect="grbl", tool_number=1), "no tool change"),
        (Control(a_limit_deg=360), "a_limit_deg"),
    ],
)
def test_what_a_control_does_not_read_is_not_written(tmp_path: Path, control, says: str) -> None:
    with pytest.raises(OptionsError, match=says):
        write_gcode(limb_of(calf), tmp_path / "limb.nc", CARVE, control)


# That the machine sees faults.


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Stock]:
    path = tmp_path_factory.mktemp("program") / "limb.nc"
    control = Control(winding="reset", a_limit_deg=LIMIT_DEG)
    report = write_gcode(limb_of(calf), path, CARVE, control)
    blank = report.toolpath.blank
    return path.read_text("ascii"), Stock(
        blank.from_mm, blank.to_mm, blank.radius_mm, turns_tool=True
    )


@pytest.mark.parametrize(
    ("pattern", "instead", "says"),
    [
        (r"G92 A\S+\n", "", "at once"),
        ("G21 ", "", "before it is told"),
        ("S9000 M3\n", "", "without spindle"),
        (r"(G1 X\S+ A\S+ Z\S+) F\S+", r"\1", "without F"),
        (r"M5\n", "", "still runs"),
        (r"G0 Z\S+\n(\( finishing)", r"G0 Z20.000\n\1", "rapid into the blank"),
        ("G90", "G91", "not known"),
    ],
)
def test_the_machine_stops_at_what_is_wrong(program, pattern: str, instead: str, says: str) -> None:
    text, stock = program
    wrong = re.sub(pattern, instead, text)
    assert wrong != text
    fresh = Stock(stock.from_mm, stock.to_mm, stock.blank_mm, turns_tool=True)
    with pytest.raises(Fault, match=says):
        carried_out(wrong, Control4(RULES["linuxcnc"]), fresh, TOOL_MM / 2)


def test_the_machine_knows_its_limit(program) -> None:
    with pytest.raises(Fault, match="beyond 700"):
        Control4(RULES["linuxcnc"], a_limit=700).run(program[0])


@pytest.mark.parametrize(("fault", "at_least_mm"), [("deeper", 0.15), ("mirrored", 1.5)])
def test_the_machine_sees_a_limb_that_is_cut_into(program, fault: str, at_least_mm: float) -> None:
    text, stock = program
    fresh = Stock(stock.from_mm, stock.to_mm, stock.blank_mm, turns_tool=fault == "deeper")
    if fault == "deeper":
        text = re.sub(
            r"(G1 X\S+ A\S+ Z)(\S+)", lambda found: f"{found[1]}{float(found[2]) - 0.2:.3f}", text
        )
    carried_out(text, Control4(RULES["linuxcnc"]), fresh, TOOL_MM / 2)
    assert judged(fresh, calf).gouge_mm > at_least_mm
