"""Photos to add: in gaps between those that count, and for places that too few of them show.

In      the photos that were checked; what they show of the limb.
Out     MissingPhotos, with the findings that they belong to.
Fails   never.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
from jaxtyping import Float64, Int64

from limbgram.capture.answer import CheckedPhoto, MissingPhotos
from limbgram.capture.camera_positions import (
    Stand,
    camera_as_held,
    clock_hour,
    height_of,
    squarely_shown_cells,
    stands_to_add,
)
from limbgram.capture.closed_surface import Underside
from limbgram.capture.coverage import ShownProxy
from limbgram.capture.criteria import (
    LEAST_PHOTOS,
    MAX_GAP_DEG,
    MAX_GAP_RATIO,
    MAX_SIGMA_MM,
    MAX_THIN,
    MAX_UNSEEN,
    MOST_ADDED,
    STEP_DEG,
    WANTED_PHOTOS,
    WIDEST_GAP_DEG,
    WIDEST_PAIR_DEG,
)
from limbgram.capture.proxy import CoarseSkin
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.interval import COVER
from limbgram.findings import Finding, Value, doubt, fault, note
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.scale.metric import MetricScene

_OTHER_RING_DEG = 8.0
"""Between the heights of photos of one ring and those of the next: hands waver by half of it."""
_WORTH_A_NOTE = 0.01
"""Of the limb: what faces down and is hidden is told, though the verdict would not name it."""


def photos_for_gaps(
    checked: Sequence[CheckedPhoto],
    max_gap_deg: float = MAX_GAP_DEG,
    max_gap_ratio: float = MAX_GAP_RATIO,
) -> tuple[MissingPhotos, ...]:
    """Photos to add in gaps between neighbouring photos that count, the widest gap first.

    Args:
        max_gap_deg: A gap is wide beyond this, and
        max_gap_ratio: beyond so many times the mean gap of the fullest ring.
    """
    around = sorted((one for one in checked if one.counts), key=lambda one: one.azimuth_deg)
    first = photo_at_12(checked)
    found: list[MissingPhotos] = []
    gaps = gaps_deg([one.azimuth_deg for one in around])
    limit_deg = min(max_gap_ratio * _usual_gap_deg(around), WIDEST_GAP_DEG)
    for one, following, gap in zip(around, [*around[1:], *around[:1]], gaps):
        if gap <= max(max_gap_deg, limit_deg):
            continue
        count = max(math.ceil(gap / STEP_DEG) - 1, 1)
        places = tuple(
            float((one.azimuth_deg + gap * k / (count + 1)) % 360) for k in range(1, count + 1)
        )
        height_deg = (one.elevation_deg + following.elevation_deg) / 2
        asked = fault(
            "coach.add_between",
            count=count,
            before=one.name,
            after=following.name,
            gap_deg=float(gap),
            hours=_hours(places),
            first=first,
            height=height_of(height_deg),
        )
        found.append(
            MissingPhotos(
                count=count,
                azimuths_deg=places,
                elevations_deg=(height_deg,) * count,
                between=(one.name, following.name),
                asked=asked,
            )
        )
    return tuple(sorted(found, key=lambda one: -one.count))


def gaps_tolerable(gaps: Sequence[MissingPhotos], checked: Sequence[CheckedPhoto]) -> bool:
    """Whether the gaps in a walk are too small for the case's verdict to name them.

    A photo that was taken in a gap and does not count is to be taken again.
    """
    around = {one.name: one.azimuth_deg for one in checked if one.counts}
    spoilt_deg = [one.azimuth_deg for one in checked if one.placed and not one.counts]
    for gap in gaps:
        if gap.between is None:
            return False
        start, end = (around[name] for name in gap.between)
        width = (end - start) % 360.0
        if width > WIDEST_GAP_DEG or any((k - start) % 360.0 < width for k in spoilt_deg):
            return False
    return True


def photo_at_12(checked: Sequence[CheckedPhoto]) -> str:
    """The photo that stands at 12 o'clock."""
    return next((one.name for one in checked if one.placed), "")


def gaps_deg(azimuths_deg: Sequence[float]) -> Float64[np.ndarray, " n"]:
    """Gaps from each photo to the next one, in their order round the limb."""
    around = np.sort(np.asarray(azimuths_deg, float))
    if not len(around):
        return np.zeros(0)
    return np.diff(around, append=around[0] + 360.0)


def _usual_gap_deg(around: Sequence[CheckedPhoto]) -> float:
    """The mean gap of the ring that has most photos.

    A second ring at another height falls between the photos of the first: by all photos together
    the usual gap would seem smaller than anybody walked, and a good walk be held back.
    """
    rings: list[list[CheckedPhoto]] = []
    for one in sorted(around, key=lambda one: one.elevation_deg):
        if rings and one.elevation_deg - rings[-1][-1].elevation_deg < _OTHER_RING_DEG:
            rings[-1].append(one)
        else:
            rings.append([one])
    return 360.0 / max(map(len, rings), default=1)


def _hours(azimuths_deg: Iterable[float]) -> tuple[int, ...]:
    """The clock hours of azimuths, each once."""
    return tuple(dict.fromkeys(clock_hour(azimuth) for azimuth in azimuths_deg))


def photos_for_hidden_places(
    shown: ShownProxy,
    metric: MetricScene,
    checked: Sequence[CheckedPhoto],
    missing: Sequence[MissingPhotos],
) -> tuple[tuple[MissingPhotos, ...], list[Finding], tuple[Finding, ...]]:
    """Photos to add for places that too few photos show, with their findings and notes."""
    proxy, prediction, under = shown.proxy, shown.prediction, shown.underside
    unseen = prediction.share(prediction.squarely < LEAST_PHOTOS, proxy)
    lacking: tuple[CoarseSkin, Int64[np.ndarray, " n"]] = (proxy, prediction.squarely)
    if under is not None and under.share > unseen:
        unseen, lacking = under.share, (under.skin, under.squarely)
    unsure = prediction.share(prediction.sigma_mm > MAX_SIGMA_MM, proxy)
    findings: list[Finding] = []
    asked: tuple[MissingPhotos, ...] = ()
    first = photo_at_12(checked)
    if unseen > MAX_UNSEEN:
        asked = _photos_by_place(*lacking, metric, missing)
        part: dict[str, Value] = {"share": float(unseen), "least": LEAST_PHOTOS}
        if asked:
            count, places = sum(one.count for one in asked), _hours_by_height(asked)
            added = fault("coach.unseen.add", count=count, places=places, first=first, **part)
            findings.append(added)
        elif missing:
            findings.append(fault("coach.unseen.coming", **part))
        else:
            findings.append(fault("coach.unseen.blocked", **part))
    if shown.thin > MAX_THIN:
        between = () if missing or asked else photos_for_gaps(checked, WIDEST_PAIR_DEG, 0.0)
        asked = (*asked, *between)
        thin = fault(
            "coach.thin",
            share=float(shown.thin),
            widest_deg=WIDEST_PAIR_DEG,
            parts=len(between),
            places=_hours_by_height(between),
            first=first,
        )
        findings.append(thin)
    if metric.scale.unit == "mm" and unsure > MAX_UNSEEN:
        most_mm = COVER * MAX_SIGMA_MM
        findings.append(fault("coach.unsure", share=float(unsure), most_mm=most_mm))
    notes: list[Finding] = []
    if under is not None and _WORTH_A_NOTE < under.share <= MAX_UNSEEN:
        notes.append(_overhang_findings(under, metric, missing, first))
    if not proxy.known[-1]:
        notes.append(note("coach.no_upper_end"))
    if shown.bare:
        notes.append(doubt("coach.unpainted", regions=shown.bare, first=first))
    if shown.coverage.weakest is not None:
        notes.append(note("coach.least_sure", weakest=shown.coverage.weakest))
    return asked, findings, tuple(notes)


def _overhang_findings(
    under: Underside,
    metric: MetricScene,
    missing: Sequence[MissingPhotos],
    first: str,
) -> Finding:
    """A finding that the underside is shown by too few photos, with photos to add for it."""
    added = _photos_by_place(under.skin, under.squarely, metric, missing)
    return doubt(
        "coach.overhang",
        share=under.share,
        least=LEAST_PHOTOS,
        count=sum(one.count for one in added),
        places=_hours_by_height(added),
        first=first,
    )


def _photos_by_place(
    skin: CoarseSkin,
    squarely: Int64[np.ndarray, " n"],
    metric: MetricScene,
    missing: Sequence[MissingPhotos],
) -> tuple[MissingPhotos, ...]:
    """Photos to add for places that too few photos show, from below upwards.

    Args:
        squarely: Photos that show each place of the skin well enough to measure it.
        missing: Photos that are asked for already; what they will show is not asked for again.
    """
    scene = metric.scene
    away = [np.linalg.norm(view.centre_in_world - skin.middle) for view in scene.views]
    distance, camera = float(np.median(away)), camera_as_held(scene.views)
    first_rad = first_direction_rad(scene, skin.middle)
    coming = [
        replace(one, distance=distance).view(camera, skin.middle, first_rad)
        for part in missing
        for one in _stands_of(part)
    ]
    stands = stands_to_add(
        skin,
        squarely + squarely_shown_cells(skin, coming).sum(axis=1),
        WANTED_PHOTOS,
        camera,
        distance,
        first_rad,
        metric.floor_z_mm,
        MOST_ADDED,
    )
    by_height = sorted(stands, key=lambda one: (one.elevation_deg, one.azimuth_deg))
    return tuple(
        MissingPhotos(
            count=1,
            azimuths_deg=(one.azimuth_deg,),
            elevations_deg=(one.elevation_deg,),
            between=None,
            asked=fault(
                "coach.add_at",
                hour=clock_hour(one.azimuth_deg),
                height=height_of(one.elevation_deg),
            ),
        )
        for one in by_height
    )


def _stands_of(asked: MissingPhotos) -> list[Stand]:
    return [
        Stand(azimuth_deg=azimuth, elevation_deg=elevation, distance=math.nan)
        for azimuth, elevation in zip(asked.azimuths_deg, asked.elevations_deg)
    ]


def _hours_by_height(asked: Sequence[MissingPhotos]) -> tuple[Finding, ...]:
    """Hours by height: "at 2, 4 o'clock, 25 degrees above level"."""
    stands = [one for part in asked for one in _stands_of(part)]
    return tuple(
        note("coach.stands", hours=_hours(one.azimuth_deg for one in group), height=height)
        for height, group in groupby(stands, key=lambda one: height_of(one.elevation_deg))
    )


def first_direction_rad(scene: Scene, middle: Vector3) -> float:
    """Direction of azimuth 0 in the plane of x and y: where the first placed photo stands."""
    x, y, _ = scene.view(scene.placed[0]).centre_in_world - middle
    return float(np.arctan2(y, x))
