"""Known distances: two points, each picked in two or more photos, a typed length apart.

Coded marks (single ArUco or AprilTag markers) are found in the photos instead of picked by hand.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32, Float64

from limbgram.core.errors import OptionsError, ScaleError
from limbgram.core.geometry.arrays import GreyImage, Matrix3, Vector3
from limbgram.core.geometry.triangulation import triangulate
from limbgram.core.run import in_parallel
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.decoding import in_flight_mb, load_luma
from limbgram.reconstruction.photos.photo import PhotoSet, SetAside
from limbgram.reconstruction.scale.ruler import Ruler, RulerLength
from limbgram.reconstruction.targets.board import DICTIONARIES, parse_dictionary
from limbgram.reconstruction.targets.finding import SEARCH_BYTES

_LEAST_ANGLE_DEG = 2.0
_LEAST_RESIDUAL_PX = 1.0
_MOST_RESIDUAL = 0.002
"""Largest accepted distance of a pick from the common point, as a share of the photo's width."""


@dataclass(frozen=True)
class Pick:
    """Where a point appears in a photo, in the sensor's orientation; (0, 0) is a pixel's centre."""

    photo: str
    x_px: float
    y_px: float


@dataclass(frozen=True, kw_only=True)
class KnownDistance:
    """Two points a known length apart, each picked in two or more photos."""

    label: str
    length_mm: float
    first: tuple[Pick, ...]
    second: tuple[Pick, ...]

    def __post_init__(self) -> None:
        if not 0 < self.length_mm < 1e5:
            raise OptionsError(
                f"{self.label}: {self.length_mm:g} mm is no length. Give millimetres above 0."
            )


@dataclass(frozen=True)
class _End:
    point_in_world: Vector3
    covariance: Matrix3


def measure_distances(
    scene: Scene, distances: Sequence[KnownDistance], pick_sigma_px: float, *, all_check: bool
) -> Ruler:
    """The distances as a ruler: by turns one sets the scale and one checks it, in the given order.

    With `all_check` every one checks, and the ruler's own scale is only for comparison.

    Raises:
        ScaleError: none could be measured, or the picks of one point do not meet.
    """
    lengths: list[RulerLength] = []
    set_aside: list[SetAside] = []
    for distance in distances:
        ends = [
            _locate(scene, distance.label, picks, pick_sigma_px)
            for picks in (distance.first, distance.second)
        ]
        missing = [end for end in ends if isinstance(end, str)]
        if missing:
            set_aside.append(SetAside(distance.label, missing[0]))
        else:
            check = all_check or len(lengths) % 2 == 1
            first, second = (end for end in ends if isinstance(end, _End))
            lengths.append(_length(distance, first, second, check=check))
    if not lengths:
        raise ScaleError(
            "None of the known distances could be measured: "
            + "; ".join(f"{one.name}: {one.reason}" for one in set_aside)
            + ". Pick both ends in two or more placed photos taken from different sides."
        )
    return _ruler(lengths, tuple(set_aside))


def _locate(scene: Scene, label: str, picks: Sequence[Pick], pick_sigma_px: float) -> _End | str:
    """One end in the scene, or why it cannot be had."""
    unknown = [pick.photo for pick in picks if pick.photo not in scene.names]
    if unknown:
        raise ScaleError(
            f"{label} was picked in {unknown[0]}, which is not among the photos. Check the name."
        )
    views = {scene.names[k]: scene.view(k) for k in scene.placed}
    usable = [pick for pick in picks if pick.photo in views]
    if len(usable) < 2:
        return f"one end is picked in {len(usable)} placed photos; 2 are needed"
    seen = [views[pick.photo] for pick in usable]
    xy_px = np.array([(pick.x_px, pick.y_px) for pick in usable])
    order = np.arange(len(seen), dtype=np.int32)
    located = triangulate(seen, order, np.zeros(len(seen), np.int32), xy_px, 1)
    point = located.points_in_world[0]
    directions = np.array([view.centre_in_world - point for view in seen])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    narrowest = float((directions @ directions.T).min())
    if not np.isfinite(point).all() or narrowest > np.cos(np.radians(_LEAST_ANGLE_DEG)):
        return f"the rays to one end meet at less than {_LEAST_ANGLE_DEG:g} degrees"
    _check_meeting(
        label,
        usable,
        [view.camera.width_px for view in seen],
        np.array([view.project(point[None])[0] for view in seen]) - xy_px,
    )
    freedom = max(1, 2 * len(seen) - 3)
    spread_px = float(located.rms_px[0] * np.sqrt(len(seen) / freedom))
    return _End(point, located.covariance[0] * max(pick_sigma_px, spread_px) ** 2)


def _check_meeting(
    label: str, picks: Sequence[Pick], widths_px: Sequence[int], misses: np.ndarray
) -> None:
    off_px = np.linalg.norm(misses, axis=1)
    worst = int(np.argmax(off_px))
    if off_px[worst] > max(_LEAST_RESIDUAL_PX, _MOST_RESIDUAL * widths_px[worst]):
        raise ScaleError(
            f"{label}: the picks of one end do not meet; the one in {picks[worst].photo} misses "
            f"the others by {off_px[worst]:.1f} px. Another point was picked there, or the mark "
            "moved. Pick it again."
        )


def _length(distance: KnownDistance, first: _End, second: _End, *, check: bool) -> RulerLength:
    between = second.point_in_world - first.point_in_world
    measured = float(np.linalg.norm(between))
    direction = between / max(measured, 1e-300)
    variance = float(direction @ (first.covariance + second.covariance) @ direction)
    return RulerLength(
        label=distance.label,
        known_mm=distance.length_mm,
        measured=measured,
        sigma=float(np.sqrt(variance)),
        role="check" if check else "control",
    )


def _ruler(lengths: Sequence[RulerLength], set_aside: tuple[SetAside, ...]) -> Ruler:
    """Weighted mean of measured over known length; its sigma grows where the lengths differ."""
    control = [one for one in lengths if one.role == "control"] or list(lengths)
    ratios = np.array([one.measured / one.known_mm for one in control])
    sigmas = np.array([one.sigma / one.known_mm for one in control])
    weights = 1 / np.maximum(sigmas, 1e-12 * ratios) ** 2
    mean = float(weights @ ratios / weights.sum())
    excess = float(weights @ (ratios - mean) ** 2) / max(1, len(control) - 1)
    sigma = float(np.sqrt(max(1.0, excess) / weights.sum()))
    return Ruler(
        units_per_mm=mean,
        relative_sigma=sigma / mean,
        lengths=tuple(lengths),
        set_aside=set_aside,
    )


@dataclass(frozen=True)
class MarkerObservation:
    """A marker's centre in a photo: where the diagonals of its black square cross."""

    mark_id: int
    pick: Pick


def find_markers(photos: PhotoSet, dictionary: str) -> tuple[MarkerObservation, ...]:
    """All markers of a dictionary in all photos; one that a photo shows twice is left out."""
    marks = cv2.aruco.getPredefinedDictionary(DICTIONARIES[parse_dictionary(dictionary)])
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX

    def work(photo_idx: int) -> list[MarkerObservation]:
        photo = photos.photos[photo_idx]
        detector = cv2.aruco.ArucoDetector(marks, parameters)
        return _in_photo(detector, load_luma(photo), photo.name)

    each_mb = in_flight_mb(photos.photos, SEARCH_BYTES)
    found = in_parallel(work, range(len(photos.photos)), each_mb=each_mb)
    return tuple(observation for one_photo in found for observation in one_photo)


def distance_between_marks(
    observations: Sequence[MarkerObservation], first_id: int, second_id: int, length_mm: float
) -> KnownDistance:
    """The known distance between the centres of two markers.

    Raises:
        ScaleError: one of the markers is in fewer than two photos.
    """
    ends = [
        tuple(one.pick for one in observations if one.mark_id == mark_id)
        for mark_id in (first_id, second_id)
    ]
    for mark_id, picks in zip((first_id, second_id), ends, strict=True):
        if len(picks) < 2:
            raise ScaleError(
                f"Marker {mark_id} was found in {len(picks)} photos; 2 are needed. Check its "
                "number and the dictionary, and keep it in view with a white border round it."
            )
    return KnownDistance(
        label=f"markers {first_id} to {second_id}",
        length_mm=length_mm,
        first=ends[0],
        second=ends[1],
    )


def _in_photo(
    detector: cv2.aruco.ArucoDetector, luma: GreyImage, name: str
) -> list[MarkerObservation]:
    corners, ids, _ = detector.detectMarkers(luma)
    if not corners:
        return []
    labels = np.asarray(ids).ravel()
    return [
        MarkerObservation(int(label), Pick(name, *map(float, _centre(np.reshape(square, (4, 2))))))
        for label, square in zip(labels, corners, strict=True)
        if np.count_nonzero(labels == label) == 1
    ]


def _centre(square: Float32[np.ndarray, "4 2"]) -> Float64[np.ndarray, "2"]:
    """Crossing of the diagonals, which perspective keeps."""
    rows = np.column_stack([square.astype(float), np.ones(4)])
    crossing = np.cross(np.cross(rows[0], rows[2]), np.cross(rows[1], rows[3]))
    return crossing[:2] / crossing[2]
