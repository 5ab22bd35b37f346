"""Coded marks: single ArUco or AprilTag markers whose distance from each other is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64

from limbgram.errors import ScaleError
from limbgram.geometry.arrays import GreyImage
from limbgram.photos import PhotoSet, in_flight_mb, load_luma
from limbgram.run import in_parallel
from limbgram.scale.distances.known import KnownDistance, Pick
from limbgram.targets.board import DICTIONARIES, parse_dictionary
from limbgram.targets.finding import SEARCH_BYTES


@dataclass(frozen=True)
class MarkSighting:
    """A marker's centre in a photo: where the diagonals of its black square cross."""

    mark_id: int
    pick: Pick


def find_marks(photos: PhotoSet, dictionary: str) -> tuple[MarkSighting, ...]:
    """All markers of a dictionary in all photos; one that a photo shows twice is left out."""
    marks = cv2.aruco.getPredefinedDictionary(DICTIONARIES[parse_dictionary(dictionary)])
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX

    def work(photo_idx: int) -> list[MarkSighting]:
        photo = photos.photos[photo_idx]
        detector = cv2.aruco.ArucoDetector(marks, parameters)
        return _in_photo(detector, load_luma(photo), photo.name)

    each_mb = in_flight_mb(photos.photos, SEARCH_BYTES)
    found = in_parallel(work, range(len(photos.photos)), each_mb=each_mb)
    return tuple(sighting for one_photo in found for sighting in one_photo)


def distance_between_marks(
    sightings: Sequence[MarkSighting], first_id: int, second_id: int, length_mm: float
) -> KnownDistance:
    """The known distance between the centres of two markers.

    Raises:
        ScaleError: one of the markers is in fewer than two photos.
    """
    ends = [
        tuple(one.pick for one in sightings if one.mark_id == mark_id)
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


def _in_photo(detector: cv2.aruco.ArucoDetector, luma: GreyImage, name: str) -> list[MarkSighting]:
    corners, ids, _ = detector.detectMarkers(luma)
    if not corners:
        return []
    labels = np.asarray(ids).ravel()
    return [
        MarkSighting(int(label), Pick(name, *map(float, _centre(np.reshape(square, (4, 2))))))
        for label, square in zip(labels, corners, strict=True)
        if np.count_nonzero(labels == label) == 1
    ]


def _centre(square: Float64[np.ndarray, "4 2"]) -> Float64[np.ndarray, "2"]:
    """Crossing of the diagonals, which perspective keeps."""
    rows = np.column_stack([square.astype(float), np.ones(4)])
    crossing = np.cross(np.cross(rows[0], rows[2]), np.cross(rows[1], rows[3]))
    return crossing[:2] / crossing[2]
