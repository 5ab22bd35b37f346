"""What to photograph and how: the options of a synthetic capture."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain

from limbgram.core.errors import OptionsError
from limbgram.findings import Finding, fault
from limbgram.reconstruction.targets.plates import MarkPlate
from limbgram.synthetic.faults import Faults
from limbgram.synthetic.movement import Movement, MovementKind
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.bent import BentShape
from limbgram.synthetic.props.board import CALIBRATION_BOARD, SCALE_BOARD, PrintedBoard
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.gauges import Gauge
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.paint import Paint, SockSpot
from limbgram.synthetic.props.scan import Scan
from limbgram.synthetic.props.stickers import SockSticker
from limbgram.synthetic.rendering.renderer import SAMPLES
from limbgram.synthetic.rendering.shading import Lighting
from limbgram.synthetic.turned_limb import TurnedOver, Turning

_Rules = Iterator[tuple[bool, Finding]]
"""Conditions, and the finding for each that fails."""


@dataclass(frozen=True, kw_only=True)
class CaptureOptions:
    """A limb, its paint, and a walk round it with a camera."""

    kind: LimbKind = LimbKind.TRANSTIBIAL
    gauge: Gauge | None = None
    """A painted gauge instead of a limb."""
    scan: Scan | BentShape | None = None
    """The shape of a file instead of one of ours; `distance_for` gives the distance at which it
    fills the photo."""
    seed: int = 11
    """Determines the person, the walk round and the room."""
    paint: Paint = Paint.DABS
    coverage: float = 0.55
    """Share of the sock that paint hides."""
    bare: float = 0.0
    """Share of the dabs that is left out, in contiguous patches."""
    uneven: float = 0.0
    """Share of the dabs that is left out on one side of the limb, falling to 0 on the other."""
    spots: tuple[SockSpot, ...] = ()
    """Spots of one colour over the paint; their places are in the truth's notes."""
    stickers: tuple[SockSticker, ...] = ()
    """Coded marks over the paint; their places are in the truth's notes."""
    lighting: Lighting = field(default_factory=Lighting)
    """Light on the limb; the calibration board has the usual one."""
    relief: Relief = field(default_factory=Relief)
    """Fine relief of skin and knit."""
    details: SkinDetails = field(default_factory=SkinDetails)
    """Knit, veins, scars and wrinkles; none by default."""
    fin_mm: float = 0.0
    """Thickness of an upright fin on the limb's side, 12 mm high; 0 for none."""
    photos: int = 15
    rings: int = 1
    """Heights at which the photographer walks round, 1 to 3."""
    elevations_deg: tuple[float, ...] = ()
    """Elevation of each ring as seen from the limb's middle; empty for the usual ones. A foot that
    is held up shows its back only to a ring at about its own height."""
    filmed: bool = False
    """Whether the photos are frames of a video: one continuous walk of uneven speed."""
    movement: Movement | None = None
    """How limb or board move between the photos; None: neither does."""
    turning: Turning | TurnedOver | None = None
    """How the limb is turned between the photos; None: the camera walks round it."""
    distance_mm: float = 1500.0
    """From the camera to the limb's middle, where the lens is focused for all photos."""
    width_px: int = 1500
    height_px: int = 1000
    lens: Lens = field(default_factory=Lens)
    faults: Faults = field(default_factory=Faults)
    """Faults of a real camera; none by default."""
    board: PrintedBoard | None = SCALE_BOARD
    """The board on the table; None for a capture without scale."""
    plates: tuple[MarkPlate, ...] = ()
    """Scale bars and the like on the table, of exact size."""
    calibration_board: PrintedBoard = CALIBRATION_BOARD
    calibration_photos: int = 15
    noise: float = 1.0
    """Sensor noise; 1 is a good camera at low sensitivity, 0 none."""
    blur_px: float = 0.5
    """Standard deviation of the lens's blur."""
    shaken: tuple[int, ...] = ()
    """Indices of the photos with motion blur."""
    shake_px: float = 14.0
    """Length of the motion blur."""
    samples: int = SAMPLES
    """Samples along the side of a pixel that shows limb or print. 2 take a third of the time, and
    suffice if pixels are smaller than the details of print and paint."""
    jpeg_quality: int = 94
    mesh_step_mm: float = 0.7
    """Edge of the truth's triangles, which are rendered as they are."""

    def __post_init__(self) -> None:
        rules = (self._limb_rules, self._walk_rules, self._paint_rules, self._camera_rules)
        for possible, rule in chain.from_iterable(told() for told in rules):
            if not possible:
                raise OptionsError("made.impossible", rule=rule)

    def _limb_rules(self) -> _Rules:
        details, relief = self.details, self.relief
        heights_mm = (details.veins_mm, details.scars_mm, details.wrinkles_mm)
        yield 0 <= self.seed < 2**63, fault("made.rule.seed")
        yield (
            0 <= relief.rms_mm <= 2 and 1 <= relief.finest_mm <= 40 and 0 <= relief.growth <= 3,
            fault("made.rule.relief"),
        )
        yield (
            self.scan is None or (self.gauge is None and self.fin_mm == 0),
            fault("made.rule.scan"),
        )
        yield (
            0 <= details.knit_mm <= 0.5
            and 1 <= details.knit_period_mm <= 4
            and all(0 <= high <= 3 for high in heights_mm),
            fault("made.rule.details"),
        )
        yield (
            self.mesh_step_mm <= details.coarsest_step_mm,
            fault("made.rule.edges", most_mm=details.coarsest_step_mm),
        )
        yield self.gauge is None or not details.any, fault("made.rule.plain_gauge")
        yield self.fin_mm == 0 or 2 <= self.fin_mm <= 20, fault("made.rule.fin")

    def _walk_rules(self) -> _Rules:
        movement, turning = self.movement, self.turning
        yield movement is None or 0 <= movement.shift_mm <= 30, fault("made.rule.movement")
        yield (
            movement is None
            or movement.kind is not MovementKind.PUSHED_BOARD
            or self.board is not None,
            fault("made.rule.pushed_board"),
        )
        yield turning is None or not (self.filmed or movement), fault("made.rule.turned")
        yield (
            not isinstance(turning, TurnedOver) or self.photos >= 6 * self.rings,
            fault("made.rule.ring_of_pose"),
        )
        yield 1 <= self.rings <= 3, fault("made.rule.rings")
        yield self.photos >= 3 * self.rings, fault("made.rule.ring")
        yield (
            not self.elevations_deg
            or (
                len(self.elevations_deg) == self.rings
                and all(-15 <= one <= 80 for one in self.elevations_deg)
                and not (self.filmed or self.turning)
            ),
            fault("made.rule.elevations"),
        )
        yield self.calibration_photos >= 0, fault("made.rule.calibration_photos")

    def _paint_rules(self) -> _Rules:
        yield 0 <= self.coverage <= 0.9, fault("made.rule.paint")
        yield 0 <= self.bare < 1 and 0 <= self.uneven <= 1, fault("made.rule.dabs")
        yield (
            self.paint is Paint.DABS or self.bare == self.uneven == 0,
            fault("made.rule.dabs_alone"),
        )
        yield min(self.width_px, self.height_px) >= 100, fault("made.rule.picture")
        yield (
            all(_on_limb(one) and 2 <= one.diameter_mm <= 30 for one in self.spots),
            fault("made.rule.spots"),
        )
        yield (
            all(
                _on_limb(one) and 6 <= one.side_mm <= 40 and 0 <= one.mark_id <= 586
                for one in self.stickers
            ),
            fault("made.rule.stickers"),
        )

    def _camera_rules(self) -> _Rules:
        yield 500 <= self.distance_mm <= 2500, fault("made.rule.distance")
        yield min(self.noise, self.blur_px, self.shake_px) >= 0, fault("made.rule.noise")
        yield 1 <= self.samples <= 8, fault("made.rule.samples")
        yield 0.3 <= self.mesh_step_mm <= 3.0, fault("made.rule.truth_edges")
        yield (
            all(0 <= k < self.photos for k in self.shaken),
            fault("made.rule.shaken", last=self.photos - 1),
        )


def _on_limb(mark: SockSpot | SockSticker) -> bool:
    return 0 <= mark.around <= 1 and 0.05 <= mark.height <= 0.95


DEFAULTS = CaptureOptions()

SMALL = CaptureOptions(
    photos=8,
    width_px=864,
    height_px=576,
    distance_mm=1400.0,
    calibration_photos=8,
    mesh_step_mm=1.2,
)
"""For tests: a capture in a few seconds."""
