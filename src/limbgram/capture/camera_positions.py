"""Camera positions (stands): where photos are taken from, and which ones to add.

In      a proxy with the photos that see each cell; the places that photos have already.
Out     Stands in words, the first photo at 12 o'clock, and the views that they would give.
Method  Places on rings round the limb are tried: each with how much thinly seen surface it would
        show, by rays. The best is taken, what it shows is counted, and so on (greedy cover:
        Nemhauser, Wolsey and Fisher 1978).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from limbgram.capture.prediction import incidence_cosines
from limbgram.capture.proxy import CoarseSkin
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid, towards
from limbgram.core.geometry.lens import Camera, View
from limbgram.findings import Finding, note

_UP = np.array([0.0, 0.0, 1.0])
_AZIMUTHS_DEG = np.arange(0.0, 360.0, 15.0)
_ELEVATIONS_DEG = (25.0, 45.0, 0.0, 65.0, -20.0, 80.0)
"""Those that are easiest to reach come first: of two as good, the first is taken."""
_LEVEL_DEG = 8.0
_SQUARELY = float(np.cos(np.radians(60.0)))
"""A photo that is asked for stands a little nearer to the normal than one that just measures."""
_WORTH = 0.004
"""Share of the limb that a photo must add to be asked for."""


@dataclass(frozen=True, kw_only=True)
class Stand:
    """A camera position, seen from the middle of the limb."""

    azimuth_deg: float
    """Seen from above, counter-clockwise from the first photo."""
    elevation_deg: float
    """Above level."""
    distance: float
    """In the scene's unit."""

    def view(self, camera: Camera, middle: Vector3, first_rad: float, name: str = "") -> View:
        """The view of a camera that stands here and aims at the middle.

        Args:
            first_rad: Direction of azimuth 0 in the world's plane of x and y.
        """
        turn, rise = first_rad + np.radians(self.azimuth_deg), np.radians(self.elevation_deg)
        pose = Rigid.looking_at(middle + self.distance * towards(turn, rise), middle, _UP)
        return View(name, camera, pose)


def clock_hour(azimuth_deg: float) -> int:
    """The clock hour of an azimuth: 12 at 0, clockwise."""
    return round(-azimuth_deg / 30.0) % 12 or 12


def height_of(elevation_deg: float) -> Finding:
    """The height of a camera in words, in steps that a hand can follow."""
    step_deg = 5 * round(elevation_deg / 5)
    if abs(elevation_deg) < _LEVEL_DEG:
        return note("coach.height.level")
    if step_deg >= 75:
        return note("coach.height.straight_above")
    return note("coach.height", off_deg=abs(step_deg), above=step_deg > 0)


def stand_of(centre: Vector3, middle: Vector3, first_rad: float) -> Stand:
    """The stand of a camera centre."""
    away = centre - middle
    distance = float(np.linalg.norm(away))
    azimuth = np.degrees(np.arctan2(away[1], away[0]) - first_rad) % 360.0
    elevation = np.degrees(np.arcsin(np.clip(away[2] / max(distance, 1e-12), -1, 1)))
    return Stand(azimuth_deg=float(azimuth), elevation_deg=float(elevation), distance=distance)


def camera_as_held(views: Sequence[View]) -> Camera:
    """The first view's camera, turned by a quarter where most of the photos were held so."""
    turned = [
        abs(view.camera_from_world.rotation[0, 2]) > abs(view.camera_from_world.rotation[1, 2])
        for view in views
    ]
    camera = views[0].camera
    return quarter_turned(camera) if 2 * sum(turned) > len(views) else camera


def quarter_turned(camera: Camera) -> Camera:
    """The camera turned by a quarter."""
    return replace(
        camera,
        width_px=camera.height_px,
        height_px=camera.width_px,
        fx=camera.fy,
        fy=camera.fx,
        cx=camera.cy,
        cy=camera.width_px - 1 - camera.cx,
        p1=0.0,
        p2=0.0,
        skew=0.0,
    )


def squarely_shown_cells(skin: CoarseSkin, views: Sequence[View]) -> Bool[np.ndarray, "n v"]:
    """Which cells each view shows squarely enough to be planned with."""
    if not views:
        return np.zeros((len(skin.mesh), 0), bool)
    return incidence_cosines(skin, views) >= _SQUARELY


def stands_to_add(
    skin: CoarseSkin,
    photos: Int64[np.ndarray, " n"],
    wanted: int,
    camera: Camera,
    distance: float,
    first_rad: float,
    floor_z: float | None,
    most: int,
) -> tuple[Stand, ...]:
    """Stands to add so that every cell is seen by `wanted` photos, as far as possible."""
    tried: list[Stand] = []
    for elevation_deg in _ELEVATIONS_DEG:
        height = skin.middle[2] + distance * np.sin(np.radians(elevation_deg))
        if floor_z is None or height > floor_z + 0.03 * distance:
            tried += [
                Stand(azimuth_deg=float(one), elevation_deg=elevation_deg, distance=distance)
                for one in _AZIMUTHS_DEG
            ]
    views = [one.view(camera, skin.middle, first_rad) for one in tried]
    sees = squarely_shown_cells(skin, views)
    area = np.where(skin.known, skin.area_mm2, 0.0)
    return tuple(tried[k] for k in _greedy_cover(sees, area / area.sum(), photos, wanted, most))


def _greedy_cover(
    sees: Bool[np.ndarray, "n v"],
    area: Float64[np.ndarray, " n"],
    photos: Int64[np.ndarray, " n"],
    wanted: int,
    most: int,
) -> Sequence[int]:
    """A greedy set cover: the columns that add most, one after the other."""
    lack = np.maximum(wanted - photos, 0).astype(float)
    taken: list[int] = []
    while len(taken) < most:
        gain = (np.minimum(lack, 1.0) * area) @ sees
        gain[taken] = 0.0
        best = int(np.argmax(gain))
        if gain[best] < _WORTH:
            break
        taken.append(best)
        lack = np.maximum(lack - sees[:, best], 0.0)
    return taken
