"""Marks as ends of known distances: scale bars, mats and rings in the scene.

In      where the photos show coded marks, and the plates on which they are printed.
Out     known distances, which set the scale where there is no board, and check it where there is.
Limits  a plate must be flat and lie still: what counts is the crossing of a mark's diagonals.
"""

from collections.abc import Sequence

from limbgram.core.errors import OptionsError, ScaleError
from limbgram.reconstruction.scale.stated_lengths import KnownDistance, Pick
from limbgram.reconstruction.targets.marks import MarkDetections
from limbgram.reconstruction.targets.plates import MarkPlate

_SIGMA_PX = 0.05
"""Standard deviation of one coordinate of a mark's middle; the photos' own spread if larger."""


def mark_distances(
    detections: MarkDetections, plates: Sequence[MarkPlate]
) -> tuple[KnownDistance, ...]:
    """The known lengths of all plates, seen or not: who measures them names what is not seen.

    Raises:
        OptionsError: two plates claim the same mark.
    """
    claimed: dict[int, str] = {}
    for plate in plates:
        for mark in plate.marks:
            if mark.mark_id in claimed:
                raise OptionsError(
                    "scale.mark_twice",
                    mark=mark.mark_id,
                    first=claimed[mark.mark_id],
                    second=plate.name,
                )
            claimed[mark.mark_id] = plate.name
    return tuple(
        _distance(detections, plate.name, one.first_id, one.second_id, one.length_mm)
        for plate in plates
        for one in plate.lengths()
    )


def distance_between_marks(
    detections: MarkDetections, first_id: int, second_id: int, length_mm: float
) -> KnownDistance:
    """The known distance between the middles of two marks.

    Raises:
        ScaleError: one of the marks is in fewer than two photos.
    """
    for mark_id in (first_id, second_id):
        seen = detections.seen_in(mark_id)
        if seen < 2:
            raise ScaleError("scale.mark_unseen", mark=mark_id, photos=seen)
    return _distance(detections, "", first_id, second_id, length_mm)


def _distance(
    detections: MarkDetections, plate: str, first_id: int, second_id: int, length_mm: float
) -> KnownDistance:
    label = f"marks {first_id} to {second_id}"
    return KnownDistance(
        label=f"{plate}, {label}" if plate else label,
        length_mm=length_mm,
        first=_picks(detections, first_id),
        second=_picks(detections, second_id),
        sigma_px=_SIGMA_PX,
        ends=(f"mark {first_id}", f"mark {second_id}"),
        between="plate" if plate else "marks",
        marks=(first_id, second_id),
    )


def _picks(detections: MarkDetections, mark_id: int) -> tuple[Pick, ...]:
    return tuple(
        Pick(photo.name, float(x), float(y))
        for photo in detections.photos
        for x, y in photo.centres_px[photo.ids == mark_id]
    )
