"""Mapping: a surface as a radius map, or the reason why it cannot be one.

In      a mesh in the limb frame; spokes, spacing of slices, from where to where.
Out     a MappedSurface: the radius map with heights from its first slice, and what was left out.
Fails   CarveError: rays cross the surface twice or not at all (undercuts, folds, an axis outside
        the section), too much would be lost at an end, or a height that is not there.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.carving.radial_rays import RadialCast, axis_heights_mm, cast_radii
from limbgram.workbench.carving.radius_map import POINT_MM, Grid, RadiusMap

_ABOVE_DISC_MM = 1e-6
"""A flat distal disc is cut this far above it."""
_STEP_MM = 0.001
"""Heights are multiples of this, as files hold them."""
_SPOKES, _MOST_DISTAL, _SPACINGS_MM = (3, 3600), 100, (0.05, 50.0)
"""What a map may have."""
_FINE_STEPS = 101
MOST_MENDED = 0.01
"""Share of the rays that may miss or cross several times; they take their neighbours' radii."""
MOST_LOST_MM = 10.0
"""Surface below the first slice that may be left out unasked."""
_AT_ONCE = 25
"""Heights cast together: the one sought is mostly among the first."""


@dataclass(frozen=True, kw_only=True)
class MapOptions:
    """Resolution of the map, and where it begins and ends."""

    spokes: int = 120
    spacing_mm: float = 2.0
    """Of the slices; made a little less so that they end at the top."""
    distal_slices: int = 0
    """More slices within the first spacing, closer towards the tip: a dome is round there."""
    from_mm: float | None = None
    """Height of the first slice in the limb frame; None: where the axis pierces the distal end."""
    to_mm: float | None = None
    """Height of the last; None: the highest that goes all round."""


DEFAULTS = MapOptions()


@dataclass(frozen=True, kw_only=True)
class MappedSurface:
    """A radius map of a surface, and its place in the limb frame."""

    radius_map: RadiusMap
    """Heights from its first slice, or those of the grid that was given."""
    first_mm: float
    """Height of the map's zero in the limb frame."""
    girths_mm: Float64[np.ndarray, " m"]
    """Girths of the mesh itself at every slice; 0 at a distal point."""
    whole: Bool[np.ndarray, " m"]
    """Slices that every ray meets once, so that nothing was interpolated."""
    rays: int
    rays_mended: int
    distal_cut_mm: float
    """Length of the part below the first slice."""
    proximal_cut_mm: float
    """Length of the part above the last slice."""


def map_radii(mesh: Mesh, options: MapOptions = DEFAULTS) -> MappedSurface:
    """Express a surface by its radii round the z axis."""
    _check(options)
    thetas = 360.0 / options.spokes * np.arange(options.spokes)
    first_mm = _first_slice_mm(mesh, thetas, options)
    last_mm = _last_slice_mm(mesh, thetas, first_mm, options)
    return _map_at(mesh, thetas, first_mm, _slice_heights_mm(last_mm - first_mm, options), options)


def map_radii_on(mesh: Mesh, grid: Grid, options: MapOptions = DEFAULTS) -> MappedSurface:
    """Express a surface by its radii at given angles and heights, such as those of its file."""
    return _map_at(mesh, grid.thetas_deg, 0.0, grid.z_mm, options, within_mm=_ABOVE_DISC_MM)


def _map_at(
    mesh: Mesh,
    thetas: Float64[np.ndarray, " n"],
    first_mm: float,
    rises: Float64[np.ndarray, " m"],
    options: MapOptions,
    within_mm: float = 0.0,
) -> MappedSurface:
    """The map at given angles and heights.

    Args:
        within_mm: How far below the top the last slice is cut, because rounding of a motion may
            have moved the top's corners.
    """
    low_mm, high_mm = float(mesh.vertices_mm[:, 2].min()), float(mesh.vertices_mm[:, 2].max())
    cut_at = np.minimum(first_mm + rises, high_mm - within_mm)
    cut_at[0] += _ABOVE_DISC_MM
    cast = cast_radii(mesh, thetas, cut_at)
    radii = cast.radii_mm.copy()
    pointed = float(cast.outermost_mm[0].min()) < POINT_MM
    if pointed and options.from_mm is None:
        radii[0] = 0.0
    bad = np.isnan(radii)
    _refuse_if_many_bad(cast, bad, first_mm + rises)
    return MappedSurface(
        radius_map=RadiusMap(
            thetas_deg=thetas, z_mm=rises, radii_mm=_with_rays_interpolated(radii, bad)
        ),
        first_mm=first_mm,
        girths_mm=np.where(radii[:, 0] == 0, 0.0, cast.girths_mm),
        whole=np.asarray(~bad.any(1)),
        rays=radii.size,
        rays_mended=int(bad.sum()),
        distal_cut_mm=max(0.0, first_mm + float(rises[0]) - low_mm),
        proximal_cut_mm=max(0.0, high_mm - (first_mm + float(rises[-1]))),
    )


def highest_whole_mm(mesh: Mesh) -> float:
    """The highest level at which the surface goes all round the z axis.

    Raises:
        CarveError: there is none, or the limb leaves the axis above it.
    """
    thetas = 360.0 / DEFAULTS.spokes * np.arange(DEFAULTS.spokes)
    low_mm = float(mesh.vertices_mm[:, 2].min())
    return _last_slice_mm(mesh, thetas, low_mm, DEFAULTS)


def _check(options: MapOptions) -> None:
    fewest, most = _SPOKES
    if not (fewest <= options.spokes <= most and 0 <= options.distal_slices <= _MOST_DISTAL):
        raise OptionsError(
            "carve.map.counts",
            spokes=options.spokes,
            distal_slices=options.distal_slices,
            fewest_spokes=fewest,
            most_spokes=most,
            usual_spokes=DEFAULTS.spokes,
            most_distal_slices=_MOST_DISTAL,
        )
    least_mm, most_mm = _SPACINGS_MM
    if not least_mm <= options.spacing_mm <= most_mm:
        raise OptionsError(
            "carve.map.spacing",
            spacing_mm=options.spacing_mm,
            least_mm=least_mm,
            most_mm=most_mm,
            usual_mm=DEFAULTS.spacing_mm,
        )


def _first_slice_mm(mesh: Mesh, thetas: np.ndarray, options: MapOptions) -> float:
    heights = mesh.vertices_mm[:, 2]
    low_mm, high_mm = float(heights.min()), float(heights.max())
    if options.from_mm is not None:
        if not low_mm <= options.from_mm < high_mm:
            raise OptionsError(
                "carve.map.no_slice", height_mm=options.from_mm, low_mm=low_mm, high_mm=high_mm
            )
        return options.from_mm
    pierced = axis_heights_mm(mesh)
    if len(pierced) and pierced[0] < (low_mm + high_mm) / 2:
        first_mm = float(pierced[0])
    else:
        first_mm = _height_with_all_rays(mesh, thetas, low_mm, high_mm, options)
    if first_mm - low_mm > MOST_LOST_MM:
        raise CarveError("carve.map.tip_lost", lost_mm=first_mm - low_mm)
    return first_mm


def _last_slice_mm(mesh: Mesh, thetas: np.ndarray, first_mm: float, options: MapOptions) -> float:
    high_mm = float(mesh.vertices_mm[:, 2].max())
    if options.to_mm is None:
        last_mm = _height_with_all_rays(mesh, thetas, high_mm, first_mm, options)
        _refuse_if_bent(mesh, thetas, last_mm, options)
        return last_mm
    if not first_mm + _STEP_MM < options.to_mm <= high_mm:
        raise OptionsError(
            "carve.map.no_slice", height_mm=options.to_mm, low_mm=first_mm, high_mm=high_mm
        )
    return options.to_mm


def _height_with_all_rays(
    mesh: Mesh, thetas: np.ndarray, end_mm: float, inner_mm: float, options: MapOptions
) -> float:
    """The height nearest to an end at which every ray meets the surface."""
    outwards = 1.0 if end_mm > inner_mm else -1.0
    count = int(abs(end_mm - inner_mm) / options.spacing_mm) + 1
    coarse = end_mm - outwards * options.spacing_mm * np.arange(count)
    coarse[0] += 0.0 if outwards > 0 else _ABOVE_DISC_MM
    found = _first_height_with_all_rays(mesh, thetas, coarse)
    outer = min(options.spacing_mm, abs(end_mm - found))
    return _first_height_with_all_rays(
        mesh, thetas, found + outwards * np.linspace(outer, 0, _FINE_STEPS)
    )


def _first_height_with_all_rays(mesh: Mesh, thetas: np.ndarray, tried_mm: np.ndarray) -> float:
    """The first of some heights, rising or falling, at which every ray meets the surface."""
    for some_mm in np.split(tried_mm, range(_AT_ONCE, len(tried_mm), _AT_ONCE)):
        order = np.argsort(some_mm)
        whole = np.empty(len(order), np.bool_)
        whole[order] = (cast_radii(mesh, thetas, some_mm[order]).crossings > 0).all(1)
        if whole.any():
            return float(some_mm[whole.argmax()])
    raise CarveError("carve.map.never_round")


def _refuse_if_bent(mesh: Mesh, thetas: np.ndarray, last_mm: float, options: MapOptions) -> None:
    """Refuse to end the map where a bent limb leaves its axis, rather than at a brim."""
    high_mm = float(mesh.vertices_mm[:, 2].max())
    if high_mm - last_mm <= MOST_LOST_MM:
        return
    above = np.arange(last_mm + options.spacing_mm, high_mm, options.spacing_mm)
    crossings = cast_radii(mesh, thetas, above).crossings
    several = int((crossings > 1).sum())
    if several > (crossings == 1).sum():
        raise CarveError(
            "carve.map.bent",
            height_mm=last_mm,
            several=several,
            meeting=int((crossings > 0).sum()),
        )


def _slice_heights_mm(height_mm: float, options: MapOptions) -> Float64[np.ndarray, " m"]:
    """Heights of slices over the first one: evenly spaced, with more at the tip."""
    count = max(1, round(height_mm / options.spacing_mm))
    step = np.floor(height_mm / count / _STEP_MM + 1e-6) * _STEP_MM
    even = np.round(step * np.arange(count + 1), 3)
    shares = np.arange(1, options.distal_slices + 1) / (options.distal_slices + 1)
    return np.unique(np.round(np.concatenate([even, step * shares**2]), 3))


def _refuse_if_many_bad(
    cast: RadialCast, bad: Bool[np.ndarray, "m n"], heights_mm: np.ndarray
) -> None:
    if bad.mean() <= MOST_MENDED and bad.mean(1).max() <= 0.5:
        return
    rows = heights_mm[bad.any(1)]
    missed = int((bad & (cast.crossings == 0)).sum())
    raise CarveError(
        "carve.map.not_once",
        bad=int(bad.sum()),
        rays=bad.size,
        share=float(bad.mean()),
        missed=missed,
        several=int(bad.sum()) - missed,
        from_mm=float(rows.min()),
        to_mm=float(rows.max()),
    )


def _with_rays_interpolated(
    radii: Float64[np.ndarray, "m n"], bad: Bool[np.ndarray, "m n"]
) -> Float64[np.ndarray, "m n"]:
    """Radii with bad rays interpolated between the good ones of their slice."""
    spokes = np.arange(radii.shape[1])
    mended = radii.copy()
    for k in np.flatnonzero(bad.any(1)):
        good = ~bad[k]
        mended[k, bad[k]] = np.interp(
            spokes[bad[k]], spokes[good], radii[k, good], period=len(spokes)
        )
    return mended
