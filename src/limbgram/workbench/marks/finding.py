"""Finding: marks of one plain colour on the sock, from the placed photos.

In      photos with their views, and the surface they show, in one frame.
Out     PaintedMarks: places on the surface where several photos agree, the plainest colour first,
        and what was seen but not offered, with the reason.
Method  round spots of one hue in every photo, their middles measured on the surface; spots of
        several photos that lie within 2 mm are one mark. Without a given colour a hue
        counts only if it is unlike the paint: most of what has it lies in such marks.
Fails   OptionsError: the given colour is grey.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64, UInt8
from scipy.spatial import KDTree

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.geometry.frames import plane_basis, turn_rad
from limbgram.core.geometry.lens import View
from limbgram.core.interval import widening
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import components
from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.photo import Photo
from limbgram.workbench.marks.pixels import (
    LEAST_COSINE,
    SurfaceRays,
    coloured_pixels_by_photo,
    hue_and_saturation,
)
from limbgram.workbench.marks.spots import SAME_HUE_RAD, Spots, hues_of, spots_of

_AGREEMENT_MM = 2.0
"""Photos that see one mark put it this close to its place."""
_LEAST_SATURATION = 0.6
"""Share of the light that is not white, for a pixel to have a hue."""
_PLAINEST_SHARE = 0.6
"""So much of what has a hue must lie in marks, for the hue to be unlike the paint."""


_LEAST_PHOTOS = 3
_LEAST_SHARE = 0.5
"""Of the photos that look at the place squarely, so many must show the mark."""
_PIXEL_MM = 0.5
"""Photos are halved as long as their pixels stay finer than this on the surface."""
_SQUARE_COSINE = 0.64
_SLACK_MM = 2.0
_MEDIAN = np.pi / 2
"""Variance of a median of many normal errors over that of their mean; of one error it is 1."""
_CELL_PX = 2.0
"""Side of the cells of the surface in which photos are joined, in pixels of the coarsest."""
_RIM_PLACES = 36
_MOST_HIDDEN_RAD, _TABLE_STEPS = np.radians(120.0), 241
"""Half of the arc; with more hidden, a disc is not round enough to be a mark."""
_SHARED_PX = 0.25
"""One standard deviation, along one direction, of what blur and shading do to all photos alike."""


@dataclass(frozen=True, kw_only=True)
class PaintedMark:
    """A painted mark at a place on which several photos agree."""

    position_mm: Vector3
    """On the surface, in the mesh's frame."""
    colour: UInt8[np.ndarray, "3"]
    diameter_mm: float
    spread_mm: float
    """Root mean square distance of the photos' places from the position."""
    sigma_mm: float
    """One standard deviation of the position along one direction of the surface: by how the photos
    disagree, for the blur and shading that they share, and for what none of them shows of it; not
    the scale."""
    photos: tuple[str, ...]
    """Those that show it."""
    looking: int
    """Photos that show it, or look at the place squarely and could."""


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A spot that was seen but is not offered as a mark, with the reason."""

    position_mm: Vector3
    colour: UInt8[np.ndarray, "3"]
    reason: Finding


@dataclass(frozen=True)
class PaintedMarks:
    """Painted marks, and spots of their colours that are no marks."""

    marks: tuple[PaintedMark, ...]
    left_out: tuple[LeftOut, ...]
    shared_share: float = 0.0
    """Of what has a given colour, so much lies elsewhere than in round spots: the paint has it.
    0 where no pixel has that colour."""


def find_painted_marks(
    photos: Sequence[Photo],
    views: Sequence[View],
    mesh: Mesh,
    colour: tuple[int, int, int] | None,
) -> PaintedMarks:
    """Marks of one plain colour, as several photos see them.

    Args:
        colour: sRGB of the marks; None: any colour that the rest of the paint does not have.

    Raises:
        OptionsError: the given colour has no hue.
    """
    given = None if colour is None else _hue_of(colour)
    caster = SurfaceRays(mesh)
    pixels = coloured_pixels_by_photo(photos, views, mesh, caster, _PIXEL_MM, _LEAST_SATURATION)
    hues = hues_of(pixels)
    if given is not None:
        hues = _given_first(hues, given)
    tree = TriangleTree.of(mesh.vertices_mm, mesh.faces)
    offered: list[tuple[float, PaintedMarks]] = []
    shared = 0.0
    looked_for = len(hues) if given is None else 1
    for found in spots_of(pixels, hues, looked_for):
        plainness = found.inside_mm2 / found.total_mm2 if found.total_mm2 else 0.0
        if given is None and plainness < _PLAINEST_SHARE:
            continue
        shared = 1 - plainness if given is not None and found.total_mm2 else 0.0
        seen = _agreed_places(found.spots, views, caster, tree)
        if seen.marks or given is not None:
            offered.append((plainness, seen))
    offered.sort(key=lambda one: -one[0])
    return PaintedMarks(
        marks=tuple(mark for _, seen in offered for mark in seen.marks),
        left_out=tuple(spot for _, seen in offered for spot in seen.left_out),
        shared_share=shared,
    )


def _hue_of(colour: tuple[int, int, int]) -> float:
    hue, saturation = hue_and_saturation(np.array([colour], np.uint8))
    if float(saturation[0]) < _LEAST_SATURATION:
        raise OptionsError("landmark.marks.grey", colour=colour)
    return float(hue[0])


def _given_first(hues: np.ndarray, given: float) -> np.ndarray:
    """The hue in the photos that is nearest to the given one, then the others."""
    if len(hues):
        nearest = float(hues[np.abs(turn_rad(hues, given)).argmin()])
        if abs(turn_rad(nearest, given)) < SAME_HUE_RAD:
            given = nearest
    return np.array([given, *(hue for hue in hues if abs(turn_rad(hue, given)) >= SAME_HUE_RAD)])


def _agreed_places(
    spots: Spots,
    views: Sequence[View],
    caster: SurfaceRays,
    tree: TriangleTree,
) -> PaintedMarks:
    """Places where the spots of several photos agree, the highest first."""
    marks: list[PaintedMark] = []
    left_out: list[LeftOut] = []
    for rows in _spot_groups(spots):
        union = _union_of_photos(spots, rows)
        place = tree.closest(union.middle_mm[None]).points_mm[0]
        colour = np.median(spots.colours[rows], axis=0).astype(np.uint8)
        looking = sum(
            k in spots.photo_idx[rows] or caster.sees(view, place, _SQUARE_COSINE, _SLACK_MM)
            for k, view in enumerate(views)
        )
        reason = _refusal_reason(len(rows), looking)
        if reason is not None:
            left_out.append(LeftOut(position_mm=place, colour=colour, reason=reason))
            continue
        away_mm = np.linalg.norm(spots.middles_mm[rows] - place, axis=1)
        shown_by = [views[k] for k in spots.photo_idx[rows].tolist()]
        hidden = _hidden_share_of_rim(place, union.diameter_mm / 2, shown_by, caster, tree)
        marks.append(
            PaintedMark(
                position_mm=place,
                colour=colour,
                diameter_mm=union.diameter_mm,
                spread_mm=float(np.sqrt((away_mm**2).mean())),
                sigma_mm=float(
                    np.hypot(
                        sigma_of_median_mm(away_mm, spots.pixels_mm[rows]),
                        shift_by_hidden_mm(union.diameter_mm / 2, hidden),
                    )
                ),
                photos=tuple(view.name for view in shown_by),
                looking=looking,
            )
        )
    marks.sort(key=lambda mark: tuple(-mark.position_mm[::-1]))
    return PaintedMarks(tuple(marks), tuple(one for one in left_out if not _beside(one, marks)))


@dataclass(frozen=True)
class _Union:
    """What all photos together show of a mark."""

    middle_mm: Vector3
    diameter_mm: float
    """Of the circle of the same area."""


def _union_of_photos(spots: Spots, rows: Int64[np.ndarray, " k"]) -> _Union:
    """On a tip each photo shows only the side of a mark that faces it, and so do all the photos of
    a ring that looks down. What several show counts once, in cells of the surface.
    """
    kept = np.isin(spots.spot_idx, rows)
    points, areas, spot = spots.points_mm[kept], spots.areas_mm2[kept], spots.spot_idx[kept]
    cell_mm = _CELL_PX * float(spots.pixels_mm[rows].max())
    cell = np.unique(np.floor(points / cell_mm), axis=0, return_inverse=True)[1].ravel()
    shown = np.unique(np.stack([cell, spot]), axis=1)[0]
    weights = areas / np.bincount(shown)[cell]
    total = float(weights.sum())
    return _Union((weights @ points) / total, float(np.sqrt(4 * total / np.pi)))


def _hidden_share_of_rim(
    place_mm: Vector3,
    radius_mm: float,
    views: Sequence[View],
    caster: SurfaceRays,
    tree: TriangleTree,
) -> float:
    """Share of a mark's rim that no photo of it shows: there it may go on, unseen."""
    outward = caster.normal_at(int(tree.closest(place_mm[None]).faces[0]))
    angles = 2 * np.pi / _RIM_PLACES * np.arange(_RIM_PLACES)
    ring = np.column_stack([np.cos(angles), np.sin(angles)]) @ plane_basis(outward)
    rim = tree.closest(place_mm + radius_mm * ring).points_mm
    hidden = [
        not any(caster.sees(view, place, LEAST_COSINE, _SLACK_MM) for view in views)
        for place in rim
    ]
    return float(np.mean(hidden))


def shift_by_hidden_mm(radius_mm: float, hidden: float) -> float:
    """How far the middle of what is seen of a disc lies from the disc's own.

    Args:
        radius_mm: Of a circle as large as what is seen.
        hidden: Share of that circle, round the middle of what is seen, beyond the straight line at
            which sight ends.
    """
    half = np.linspace(0.0, _MOST_HIDDEN_RAD, _TABLE_STEPS)  # of the arc that is hidden
    seen = np.pi - half + np.sin(half) * np.cos(half)  # all of a disc of radius 1
    shift, radius = 2 / 3 * np.sin(half) ** 3 / seen, np.sqrt(seen / np.pi)
    beyond = np.arccos(np.minimum((np.cos(half) + shift) / radius, 1.0)) / np.pi
    return radius_mm * float(np.interp(hidden, beyond, shift / radius))


def sigma_of_median_mm(
    away_mm: Float64[np.ndarray, " k"], pixels_mm: Float64[np.ndarray, " k"]
) -> float:
    """Sigma of a median of places, by their distances along two directions and shared errors."""
    count = len(away_mm)
    freedom = 2 * max(count - 1, 1)
    of_one = np.sqrt((away_mm**2).sum() / freedom) * widening(freedom)
    of_median = of_one * np.sqrt(_MEDIAN / (count - 1 + _MEDIAN))
    shared = _SHARED_PX * float(np.median(pixels_mm))
    return float(np.hypot(of_median, shared))


def _spot_groups(spots: Spots) -> list[Int64[np.ndarray, " k"]]:
    """Spots that lie together, each photo once: the spot nearest to the middle of all."""
    count = len(spots.middles_mm)
    if count == 0:
        return []
    pairs = KDTree(spots.middles_mm).query_pairs(_AGREEMENT_MM, output_type="ndarray")
    pairs = pairs[spots.photo_idx[pairs[:, 0]] != spots.photo_idx[pairs[:, 1]]]
    labels = components(pairs, count)
    groups: list[Int64[np.ndarray, " k"]] = []
    for label in range(int(labels.max()) + 1):
        rows = np.flatnonzero(labels == label)
        away = _distances_from_median(spots.middles_mm[rows])
        rows = rows[np.argsort(away, kind="stable")]
        rows = rows[np.sort(np.unique(spots.photo_idx[rows], return_index=True)[1])]
        rows = rows[_distances_from_median(spots.middles_mm[rows]) <= _AGREEMENT_MM]
        if len(rows):
            groups.append(np.sort(rows))
    return groups


def _distances_from_median(places_mm: Points3) -> np.ndarray:
    """Distances from the middle, which a few wild places do not move."""
    return np.linalg.norm(places_mm - np.median(places_mm, axis=0), axis=1)


def _beside(one: LeftOut, marks: Sequence[PaintedMark]) -> bool:
    """Whether a spot is a mark's own, misjudged in a single photo."""
    return any(
        np.linalg.norm(one.position_mm - mark.position_mm) < mark.diameter_mm for mark in marks
    )


def _refusal_reason(showing: int, looking: int) -> Finding | None:
    """Why a group is no mark; None if it is one."""
    if showing < _LEAST_PHOTOS:
        return note("landmark.spot.few", showing=showing, looking=looking, least=_LEAST_PHOTOS)
    if showing < _LEAST_SHARE * looking:
        return note("landmark.spot.minority", showing=showing, looking=looking)
    return None
