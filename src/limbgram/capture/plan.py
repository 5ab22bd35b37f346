"""Plan: how a limb is photographed so that its surface becomes as sure as is asked.

In      the sigma that is asked for, the camera, the distance, the limb's rough form.
Out     a CapturePlan: photos on each ring, how high, aperture and focus, size of the paint's marks,
        and the sigma and coverage that follow.
Method  Rings of photos round a plain limb are tried, the fewest photos first; what they give is
        told by the formula that also checks captures (`prediction`). The aperture is the one at
        which defocus and diffraction together blur least: a disc of diameter c blurs like a
        Gaussian of c / 4, an Airy pattern like one of 0.42 wavelength N (Zhang et al. 2007). Focus
        lies at the harmonic mean of the nearest and the farthest place that a photo measures.
Fails   PlanError: the limb does not fit into the picture, or no number of photos reaches the sigma;
        it says what would.
"""

import math
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from limbgram.capture.answer import Coverage
from limbgram.capture.camera_positions import Stand, height_of, quarter_turned
from limbgram.capture.coverage import coverage_from_prediction
from limbgram.capture.prediction import (
    FINE_POWER,
    Prediction,
    Showing,
    incidence_cosines,
    predict,
)
from limbgram.capture.proxy import LimbProxy, plain_tube
from limbgram.core.errors import OptionsError, PlanError
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.interval import COVER
from limbgram.core.notebook import brief
from limbgram.findings import Finding, Value, doubt, note
from limbgram.formats.sheets.sock import SPECKLE_PX
from limbgram.reconstruction.measuring.measurement_pass import MAX_INCIDENCE_DEG

_RINGS_DEG = ((25.0,), (15.0, 45.0), (10.0, 35.0, 60.0))
"""Heights of one, two and three rings."""
_SHARES = ((1.0,), (0.6, 0.4), (0.45, 0.33, 0.22))
"""Of the photos, on each of them: the lowest ring joins all, high ones see the end."""
_STOPS = tuple(float(2 ** (k / 6)) for k in range(6, 61))
"""Thirds of a stop from 1.4 to 32, exactly."""
_WAVELENGTH_MM = 0.00055
_DISC, _AIRY = 0.25, 0.42
_SQUARELY = math.cos(math.radians(MAX_INCIDENCE_DEG))
_BOARD_PX = 0.88
"""Width of a board's edges where the camera's own are not known."""
_FINER_PIXEL_SHARE = 0.66
"""Edges of dabs, which stand close, read narrower than those of a board, by so much in quadrature:
0.42 to 0.84 px in 13 captures of docs/method/prediction.md."""
_DABS_SLOPE = 13.1
"""Grey slope of dabs times the width of their edges: 11 to 16 there."""
_PRINT_SLOPE = 34.5
"""Of a printed sock, times the width of a board's edges: 34 to 36 in five captures."""
_FINEST_PX = 1.1
"""As for dabs: edges of its spots read as 0 px where a board's are 0.8 to 0.9 px wide, and as 0.3
px where they are 1.1 px."""
_NARROWEST_PX = 0.4
_SURE_SHARE = 0.9
"""Share of the measured surface that must be as sure as asked."""
_COVERED_SHARE = 0.97
"""Share of the limb that three photos or more must see squarely, so that one may fail."""
_MOST_PHOTOS, _FEWEST_A_RING = 48, 8
_WIDEST_GAP_DEG = 30.0
"""Between neighbours on the lowest ring, which joins all photos: 12 or more."""
_ROOM = 1.15
"""The picture's side over the limb's, so that the limb never leaves it."""


class Sock(Enum):
    """What the limb wears for the photos."""

    PAINTED = "painted"
    PRINTED = "printed"
    """With the pattern of `limbgram print sock`."""


class LimbForm(Enum):
    """Rough forms of limbs, standing with the distal end up."""

    LOWER_LEG = "lower-leg"
    THIGH = "thigh"
    FOREARM = "forearm"


_FORMS = {
    LimbForm.LOWER_LEG: ((57.0, 54.0, 51.0, 44.0, 38.0), 230.0, 40.0),
    LimbForm.THIGH: ((78.0, 73.0, 66.0, 60.0, 52.0), 200.0, 50.0),
    LimbForm.FOREARM: ((48.0, 45.0, 40.0, 34.0, 30.0), 200.0, 25.0),
}
"""Radii from below upwards, length of the side, height of the rounded end, mm."""


@dataclass(frozen=True, kw_only=True)
class PlannedCamera:
    """A camera, and the size of its sensor where that is known."""

    camera: Camera
    sensor_width_mm: float | None = None
    aperture: float | None = None
    """Where it cannot be chosen, as in a phone."""
    edge_px: float | None = None
    """Width of a board's edges in its photos, as its calibration found them; None: not known."""

    @classmethod
    def of(
        cls,
        focal_mm: float,
        sensor_width_mm: float,
        width_px: int,
        height_px: int,
        aperture: float | None = None,
    ) -> "PlannedCamera":
        """A camera by the values of a data sheet; the sensor's width is its longer side."""
        if min(focal_mm, sensor_width_mm) <= 0 or min(width_px, height_px) < 100:
            raise OptionsError("plan.camera")
        focal_px = focal_mm / sensor_width_mm * max(width_px, height_px)
        camera = Camera(
            width_px=width_px,
            height_px=height_px,
            fx=focal_px,
            fy=focal_px,
            cx=(width_px - 1) / 2,
            cy=(height_px - 1) / 2,
        )
        return cls(camera=camera, sensor_width_mm=sensor_width_mm, aperture=aperture)


@dataclass(frozen=True, kw_only=True)
class PlannedRing:
    """Photos at one height, evenly spread round the limb."""

    photos: int
    elevation_deg: float
    above_middle_mm: float
    """Height of the camera above the limb's middle."""
    level_distance_mm: float
    """From the limb's axis, along the floor."""
    azimuths_deg: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class CapturePlan:
    """A plan of photos, and the surface that it will give."""

    asked_sigma_mm: float
    photos: int
    rings: tuple[PlannedRing, ...]
    distance_mm: float
    """From the camera to the limb's middle."""
    portrait: bool
    """Whether the camera is held upright."""
    pixel_mm: float
    """What a pixel shows of the limb's middle."""
    aperture: float | None
    """F-number; None where the sensor's size is not known."""
    focus_mm: float
    """Distance to focus at, and to stay focused at."""
    depth_mm: tuple[float, float]
    """Nearest and farthest place that a photo measures."""
    blur_px: float
    """Of the worst place, as the edges of a board would show it: lens, hand, defocus and
    diffraction."""
    paint_mm: float
    """Width of a typical mark on the sock, and of the gaps between marks."""
    sigma_mm: float
    """Expected: the asked share of the surface is surer."""
    sigma_middle_mm: float
    """Expected: half of the surface is surer."""
    coverage: Coverage
    notes: tuple[Finding, ...]

    __repr__ = brief

    @property
    def summary(self) -> Finding:
        """A sentence of the sigma reached, and the number of photos."""
        return note(
            "plan.reached",
            photos=self.photos,
            rings=len(self.rings),
            distance_mm=self.distance_mm,
            expected_mm=COVER * self.sigma_mm,
            sigma_mm=self.sigma_mm,
            asked_mm=self.asked_sigma_mm,
            measured=self.coverage.measured,
        )

    @property
    def steps(self) -> tuple[Finding, ...]:
        """The plan as a photographer follows it, and what else is worth knowing."""
        rings = (
            note(
                "plan.ring",
                number=number,
                photos=ring.photos,
                step_deg=360 / ring.photos,
                height=height_of(ring.elevation_deg),
                off_mm=abs(ring.above_middle_mm),
                above=ring.above_middle_mm >= 0,
                level_distance_mm=ring.level_distance_mm,
            )
            for number, ring in enumerate(self.rings, start=1)
        )
        near_mm, far_mm = self.depth_mm
        return (
            *rings,
            note("plan.hold", portrait=self.portrait, pixel_mm=self.pixel_mm),
            note(
                "plan.focus",
                aperture=self.aperture,
                focus_mm=self.focus_mm,
                near_mm=near_mm,
                far_mm=far_mm,
            ),
            note("plan.paint", paint_mm=self.paint_mm),
            *self.notes,
        )


def form_of(limb: LimbForm) -> LimbProxy:
    """The proxy of a usual limb."""
    radii, length_mm, end_mm = _FORMS[limb]
    return plain_tube(np.linspace(0, length_mm, len(radii)), np.array(radii), end_mm)


def plain_limb(diameter_mm: float, length_mm: float) -> LimbProxy:
    """A limb of one thickness with a rounded end."""
    if not 20 <= diameter_mm <= 600 or not 20 <= length_mm <= 1500:
        raise OptionsError("plan.limb")
    end_mm = min(0.7 * diameter_mm / 2, 0.4 * length_mm)
    radii = np.full(3, diameter_mm / 2)
    return plain_tube(np.linspace(0, length_mm - end_mm, 3), radii, end_mm)


def plan_capture(
    sigma_mm: float,
    camera: PlannedCamera,
    limb: LimbProxy,
    distance_mm: float | None = None,
    sock: Sock = Sock.PAINTED,
) -> CapturePlan:
    """The fewest photos that reach a sigma.

    Args:
        distance_mm: From the limb's middle; the nearest at which the limb fits where none is given.
    """
    if not 0 < sigma_mm <= 5:
        raise OptionsError("plan.sigma")
    if camera.camera.width_px < camera.camera.height_px:  # its photos stand upright
        camera = replace(camera, camera=quarter_turned(camera.camera))
    fits_mm, portrait = _nearest_mm(camera.camera, limb)
    given = distance_mm is not None
    distance_mm = fits_mm if distance_mm is None else distance_mm
    if distance_mm < fits_mm:
        shown_mm = max(camera.camera.width_px, camera.camera.height_px) / camera.camera.fx
        raise PlanError(
            "plan.too_near",
            distance_mm=distance_mm,
            shown_mm=shown_mm * distance_mm,
            needed_mm=shown_mm * fits_mm,
            back_mm=math.ceil(fits_mm / 10) * 10,
        )
    held = quarter_turned(camera.camera) if portrait else camera.camera
    best: tuple[float, int] | None = None
    for stands, rings in _candidates(distance_mm):
        views = [one.view(held, limb.middle, 0.0) for one in stands]
        sharpness = _best_sharpness(views, held, camera, limb)
        showing = showing_of_sock(len(limb.mesh), len(views), sharpness.blur_px, sock)
        prediction = predict(limb, views, showing)
        reached_mm = prediction.sigma_reached_mm(limb, _SURE_SHARE)
        if prediction.share(prediction.squarely >= 3, limb) < _COVERED_SHARE:
            continue
        if best is None or reached_mm < best[0]:
            best = reached_mm, len(stands)
        if reached_mm <= sigma_mm:
            walk = _PhotoRound(distance_mm, portrait, rings, sharpness, prediction)
            return _as_plan(sigma_mm, camera, limb, walk)
    raise _unreachable_error(sigma_mm, best, distance_mm, fits_mm, given, camera)


def board_edge_px(camera: PlannedCamera) -> float:
    """Width of a board's edges in its photos, in focus."""
    return _BOARD_PX if camera.edge_px is None else camera.edge_px


def showing_of_sock(cells: int, views: int, blur_px: float, sock: Sock) -> Showing:
    """How well photos show a sock, by the width of a board's edges in them.

    A step that is blurred has a slope that goes with one over its width.
    """
    match sock:
        case Sock.PAINTED:
            edge_px = math.sqrt(max(blur_px**2 - _FINER_PIXEL_SHARE**2, 0.0))
            slope = _DABS_SLOPE / max(edge_px, _NARROWEST_PX)
        case Sock.PRINTED:
            edge_px = math.sqrt(max(blur_px**2 - _FINEST_PX**2, 0.0))
            slope = _PRINT_SLOPE / max(blur_px, _NARROWEST_PX)
    return Showing.alike(cells, views, edge_px, slope)


@dataclass(frozen=True, kw_only=True)
class _Sharpness:
    """How the lens is set, and how sharp the worst place becomes."""

    aperture: float | None
    focus_mm: float
    depth_mm: tuple[float, float]
    blur_px: float
    defocus_px: float = field(default=0.0)


def _nearest_mm(camera: Camera, limb: LimbProxy) -> tuple[float, bool]:
    """The nearest distance at which the limb fits, and whether upright pictures do it."""
    long_mm = _ROOM * limb.length + limb.radius
    wide_mm = _ROOM * 2 * limb.radius
    sides = camera.width_px / camera.fx, camera.height_px / camera.fy
    level = max(wide_mm / sides[0], long_mm / sides[1]) + limb.radius
    upright = max(wide_mm / sides[1], long_mm / sides[0]) + limb.radius
    return min(level, upright), upright < level


def _candidates(
    distance_mm: float,
) -> list[tuple[list[Stand], tuple[PlannedRing, ...]]]:
    """Rings of photos, fewest photos first, then fewest rings."""
    least = math.ceil(360 / _WIDEST_GAP_DEG)
    found: list[tuple[list[Stand], tuple[PlannedRing, ...]]] = []
    for total in range(least, _MOST_PHOTOS + 1):
        for heights_deg, shares in zip(_RINGS_DEG, _SHARES):
            counts = [round(share * total) for share in shares]
            counts[0] += total - sum(counts)
            if counts[0] < least or min(counts) < min(_FEWEST_A_RING, counts[0]):
                continue
            rings = tuple(
                _ring(count, height_deg, number, distance_mm)
                for number, (count, height_deg) in enumerate(zip(counts, heights_deg))
            )
            stands = [
                Stand(azimuth_deg=turn, elevation_deg=ring.elevation_deg, distance=distance_mm)
                for ring in rings
                for turn in ring.azimuths_deg
            ]
            found.append((stands, rings))
    return found


def _ring(count: int, elevation_deg: float, number: int, distance_mm: float) -> PlannedRing:
    """A ring of photos; every second ring stands in the gaps of the one below."""
    start = 0.5 * (number % 2)
    rise = math.radians(elevation_deg)
    return PlannedRing(
        photos=count,
        elevation_deg=elevation_deg,
        above_middle_mm=distance_mm * math.sin(rise),
        level_distance_mm=distance_mm * math.cos(rise),
        azimuths_deg=tuple((k + start) * 360.0 / count for k in range(count)),
    )


def _best_sharpness(
    views: list[View], held: Camera, planned: PlannedCamera, limb: LimbProxy
) -> _Sharpness:
    """Aperture and focus for all that these photos measure."""
    seen = incidence_cosines(limb, views) >= _SQUARELY
    depths = np.stack(
        [view.camera_from_world.apply(limb.mesh.vertices_mm)[:, 2] for view in views], axis=1
    )
    near, far = float(depths[seen].min()), float(depths[seen].max())
    focus = 2 * near * far / (near + far)
    sharp_px = board_edge_px(planned)
    if planned.sensor_width_mm is None:
        return _Sharpness(aperture=None, focus_mm=focus, depth_mm=(near, far), blur_px=sharp_px)
    longer = max(held.width_px, held.height_px)
    pitch_mm = planned.sensor_width_mm / longer
    focal_mm = held.fx * pitch_mm * focus / (focus + held.fx * pitch_mm)
    stops = _STOPS if planned.aperture is None else (planned.aperture,)
    blurs = [
        (_blur_px(stop, focal_mm, pitch_mm, near, far, focus, sharp_px), stop) for stop in stops
    ]
    blur_px, stop = min(blurs)
    disc = _defocus_px(stop, focal_mm, pitch_mm, near, far, focus)
    return _Sharpness(
        aperture=stop, focus_mm=focus, depth_mm=(near, far), blur_px=blur_px, defocus_px=disc
    )


def _blur_px(
    stop: float,
    focal_mm: float,
    pitch_mm: float,
    near: float,
    far: float,
    focus: float,
    sharp_px: float,
) -> float:
    """Blur at the worst place, as the sigma of a Gaussian."""
    magnified = focal_mm / (focus - focal_mm)
    airy_px = _AIRY * _WAVELENGTH_MM * stop * (1 + magnified) / pitch_mm
    disc_px = _defocus_px(stop, focal_mm, pitch_mm, near, far, focus)
    return math.sqrt(sharp_px**2 + airy_px**2 + disc_px**2)


def _defocus_px(
    stop: float, focal_mm: float, pitch_mm: float, near: float, far: float, focus: float
) -> float:
    """Thin lens: a point at z is a disc of f^2 |z - s| / (N z (s - f))."""
    widest = max(abs(z - focus) / z for z in (near, far))
    return _DISC * focal_mm**2 * widest / (stop * (focus - focal_mm)) / pitch_mm


@dataclass(frozen=True)
class _PhotoRound:
    """Rings of photos round the limb, with their sharpness and prediction."""

    distance_mm: float
    portrait: bool
    rings: tuple[PlannedRing, ...]
    sharpness: _Sharpness
    prediction: Prediction


def _as_plan(
    asked_mm: float, camera: PlannedCamera, limb: LimbProxy, walk: _PhotoRound
) -> CapturePlan:
    sharpness, prediction = walk.sharpness, walk.prediction
    pixel_mm = walk.distance_mm / camera.camera.fx
    notes: list[Finding] = []
    if sharpness.aperture is None:
        notes.append(note("plan.no_aperture"))
    elif sharpness.defocus_px > _FINER_PIXEL_SHARE:
        notes.append(doubt("plan.defocus", blur_px=float(sharpness.defocus_px)))
    return CapturePlan(
        asked_sigma_mm=asked_mm,
        photos=sum(ring.photos for ring in walk.rings),
        rings=walk.rings,
        distance_mm=walk.distance_mm,
        portrait=walk.portrait,
        pixel_mm=pixel_mm,
        aperture=sharpness.aperture,
        focus_mm=sharpness.focus_mm,
        depth_mm=sharpness.depth_mm,
        blur_px=sharpness.blur_px,
        paint_mm=SPECKLE_PX * pixel_mm,
        sigma_mm=prediction.sigma_reached_mm(limb, _SURE_SHARE),
        sigma_middle_mm=prediction.middle_sigma_mm(limb),
        coverage=coverage_from_prediction(limb, prediction, in_mm=True),
        notes=tuple(notes),
    )


def _unreachable_error(
    asked_mm: float,
    best: tuple[float, int] | None,
    distance_mm: float,
    fits_mm: float,
    given: bool,
    camera: PlannedCamera,
) -> PlanError:
    """A refusal that says why a sigma cannot be reached, and what would reach it."""
    if best is None:
        return PlanError(
            "plan.uncovered",
            photos=_MOST_PHOTOS,
            distance_mm=distance_mm,
            share=_COVERED_SHARE,
        )
    reached_mm, photos = best
    nearer_mm = distance_mm * (asked_mm / reached_mm) ** (1 / (1 + FINE_POWER))
    reached: dict[str, Value] = {
        "asked_mm": asked_mm,
        "distance_mm": distance_mm,
        "photos": photos,
        "reached_mm": reached_mm,
    }
    if given and nearer_mm >= fits_mm:
        return PlanError("plan.beyond.nearer", nearer_mm=nearer_mm, **reached)
    factor = distance_mm / nearer_mm
    size = camera.camera.width_px * camera.camera.height_px / 1e6
    return PlanError(
        "plan.beyond.camera",
        fits_mm=fits_mm,
        needed_megapixels=size * factor**2,
        megapixels=size,
        **reached,
    )
