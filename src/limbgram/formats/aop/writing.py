"""AOP: the limb as a radius map, as the trade's carvers and programs take it.

In      an aligned Limb; how fine, whose quirks, which line ends and which form of header.
Out     the file, read back by our own reader, and an AopReport: what the file costs.
Fails   CarveError: not aligned, or no radius map can hold the shape. OptionsError.
"""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.files import require, write_file
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.units import MM_PER_INCH
from limbgram.findings import fault
from limbgram.formats.aop.axis import fitted_axis
from limbgram.formats.aop.cost import AopReport, cost_of
from limbgram.formats.aop.profiles import Profile, landmarks_to_file
from limbgram.formats.aop.reading import PLACE_COMMENT, AopReading, read_aop
from limbgram.workbench.anatomy.names import without_accents
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.carving.mapping import MapOptions, MappedSurface, map_radii, map_radii_on
from limbgram.workbench.carving.radius_map import Grid
from limbgram.workbench.limb import AlignedLimb, Limb, names_apart

LineEnd = Literal["lf", "cr", "crlf"]
_LINE_ENDS: dict[LineEnd, str] = {"lf": "\n", "cr": "\r", "crlf": "\r\n"}
_LONGEST_NAME = 40
_ROUNDING_MM = 0.0005 + 1e-9
_INCH_ROUNDING_MM = MM_PER_INCH * 0.0005 + 1e-9
_ANGLE_DIGITS = 6


@dataclass(frozen=True, kw_only=True)
class Own:
    """Where the radii of a file stand, and how its axes lie in the limb."""

    grid: Grid
    limb_from_file: Rigid


@dataclass(frozen=True, kw_only=True)
class AopOptions:
    """What the program that will read the file expects."""

    map: MapOptions = field(default_factory=MapOptions)
    own: Own | None = None
    """Spokes, slices and axis of the AOP file that the shape was read of; they stand in place of

    those of `map` and `axis`. Nothing is sampled anew then, and a second writing gives the same."""
    axis: Literal["limb", "fit"] = "limb"
    """fit: the file's axis is not the limb's but one from which rays meet the surface once; the
    file says where it lies. Then the map's heights are not the limb's, and cannot be given."""
    profile: Profile = "mm"
    line_end: LineEnd = "lf"
    spokes_listed: bool = False
    """Write every angle, not the spacing."""
    slices_listed: bool = True
    """Write every height, not the spacing: the form of all files seen from the trade."""


DEFAULTS = AopOptions()


def write_aop(limb: Limb, path: Path | str, options: AopOptions = DEFAULTS) -> AopReport:
    """Write an aligned limb as AOP, and tell what the format costs."""
    path = Path(path)
    limb = limb.aligned()
    _check(options)
    points = limb.limb_from_mesh.apply(limb.mesh.vertices_mm)
    outside = outer_bodies(Mesh(vertices_mm=points, faces=limb.mesh.faces))
    outside.require_one_limb()
    axis_from_limb, mesh, mapped = _mapped(outside.mesh, options)
    frame = replace(limb.frame, limb_from_mesh=axis_from_limb @ limb.limb_from_mesh)
    limb = replace(limb, frame=frame)
    place = _place(axis_from_limb, mapped, options)
    _check_form(mapped, options)
    text = _text(limb, mapped, options, place)
    held: list[AopReading] = []

    def encode(stream: BinaryIO) -> None:
        stream.write(text.replace("\n", _LINE_ENDS[options.line_end]).encode("ascii"))

    def check(written: Path) -> None:
        held.append(read_aop(written.read_bytes(), path.name))
        _compare(held[0], limb, mapped, options)
        found = held[0].frame.limb_from_mesh
        require(
            _apart(found, place or Rigid.identity()) < _ROUNDING_MM,
            fault("aop.read.place"),
        )

    write_file(path, encode, check)
    return cost_of(path, mesh, mapped, held[0], axis_from_limb, outside)


def _mapped(mesh: Mesh, options: AopOptions) -> tuple[Rigid, Mesh, MappedSurface]:
    """The motion to the file's axis, the mesh there, and its radii."""
    if options.own is not None:
        axis_from_limb = options.own.limb_from_file.inverse
        moved = mesh.moved(axis_from_limb)
        return axis_from_limb, moved, map_radii_on(moved, options.own.grid, options.map)
    if options.axis == "fit":
        try:
            return _mapped_round(fitted_axis(mesh, options.map), mesh, options)
        except CarveError as error:
            raise CarveError("aop.fit_fails", why=error.finding) from error
    try:
        return _mapped_round(Rigid.identity(), mesh, options)
    except CarveError as error:
        free = replace(options, map=replace(options.map, from_mm=None, to_mm=None))
        try:
            found, _, _ = _mapped_round(fitted_axis(mesh, free.map), mesh, free)
        except CarveError:
            raise error from None
        raise CarveError(
            "aop.other_axis",
            why=error.finding,
            tilt_deg=angle_between_deg(found.rotation, np.eye(3)),
            without_limits=free.map != options.map,
        ) from error


def _mapped_round(
    axis_from_limb: Rigid, mesh: Mesh, options: AopOptions
) -> tuple[Rigid, Mesh, MappedSurface]:
    moved = mesh.moved(axis_from_limb)
    return axis_from_limb, moved, map_radii(moved, options.map)


def _place(axis_from_limb: Rigid, mapped: MappedSurface, options: AopOptions) -> Rigid | None:
    """Where the file's axes lie in the limb; None where they are the limb's own.

    The file counts heights from its first slice, unless they are those of an older file.
    """
    if options.own is not None:
        place = options.own.limb_from_file
        return None if _apart(place, Rigid.identity()) < _ROUNDING_MM else place
    if options.axis != "fit":
        return None
    return axis_from_limb.inverse @ Rigid(np.eye(3), np.array([0.0, 0.0, mapped.first_mm]))


def _apart(one: Rigid, other: Rigid) -> float:
    """How far a motion takes the corners of a limb's size to other places, mm."""
    corners = 500.0 * np.concatenate([np.zeros((1, 3)), np.eye(3)])
    return float(np.abs(one.apply(corners) - other.apply(corners)).max())


def _check(options: AopOptions) -> None:
    if options.axis == "fit" and (options.map.from_mm, options.map.to_mm) != (None, None):
        raise OptionsError("aop.heights_and_fit")
    listed = options.spokes_listed or (options.own is not None and not options.own.grid.even)
    if options.profile == "ampscan-early" or (options.profile == "ampscan" and listed):
        raise OptionsError("aop.ampscan_mirrors")


def _check_form(mapped: MappedSurface, options: AopOptions) -> None:
    heights = mapped.radius_map.z_mm
    uneven = float(np.ptp(np.diff(heights))) > 1e-6 or heights[0] != 0
    if not options.slices_listed and uneven:
        raise OptionsError("aop.uneven_slices")


def _text(
    limb: AlignedLimb, mapped: MappedSurface, options: AopOptions, place: Rigid | None
) -> str:
    found = mapped.radius_map
    inches = options.profile == "omega"
    lines = ["AAOP1", "AAOP1", "Written by limbgram", "UNIT: MM"]
    lines.append(f"LANDMARK RADIUS UNIT: {'IN' if inches else 'MM'}")
    if options.profile == "ampscan":
        lines.append("Spokes as ampscan reads them")
    if place is not None:
        numbers = " ".join(f"{value:.9f}" for value in place.matrix_3x4.ravel())
        lines += ["AXIS FITTED, NOT THE LIMB'S OWN", f"{PLACE_COMMENT} {numbers}"]
    lines += ["END COMMENTS", "CYLINDRICAL", limb.side.upper(), str(len(limb.landmarks))]
    places = _landmark_places(limb, mapped, options.profile)
    names = names_apart([_plain_name(mark.name) for mark in limb.landmarks])
    for name, (radius, theta, z) in zip(names, places.tolist(), strict=True):
        lines += [name, "1", f"{radius:.3f}", f"{theta:.{_ANGLE_DIGITS}f}"]
        lines.append(f"{z:.3f}")
    spokes = len(found.thetas_deg)
    spacing = 360.0 / spokes
    listed = options.spokes_listed or (options.own is not None and not options.own.grid.even)
    lines += [str(spokes), "0" if listed else _short(spacing)]
    lines += [_short(theta) for theta in found.thetas_deg] if listed else []
    heights = found.z_mm.tolist()
    lines.append(str(len(heights)))
    lines += ["0", *map(_short, heights)] if options.slices_listed else [_short(heights[1])]
    lines += [f"{radius:.3f}" for radius in _rows(mapped, options.profile).ravel().tolist()]
    return "\n".join(lines) + "\n"


def _landmark_places(
    limb: AlignedLimb, mapped: MappedSurface, profile: Profile
) -> Float64[np.ndarray, "k 3"]:
    in_limb = limb.landmarks_in_limb_mm - np.array([0.0, 0.0, mapped.first_mm])
    return landmarks_to_file(in_limb, profile)


def _rows(mapped: MappedSurface, profile: Profile) -> Float64[np.ndarray, "m n"]:
    """Radii in the file's order of spokes: ampscan's first spoke is our second."""
    return np.roll(mapped.radius_map.radii_mm, -1 if profile == "ampscan" else 0, axis=1)


def _plain_name(name: str) -> str:
    """A name in ASCII that cannot be taken for another line of the file."""
    plain = re.sub(r"[^ -~]", "?", without_accents(name)).strip()[:_LONGEST_NAME].strip()
    return plain or "unnamed"


def _short(value: float) -> str:
    """Six decimals without idle zeros."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


def _compare(
    held: AopReading, limb: AlignedLimb, mapped: MappedSurface, options: AopOptions
) -> None:
    """What our reader finds is the map, the side and the landmarks, within the file's digits."""
    found, wanted = held.radius_map, mapped.radius_map
    require(
        held.frame.side == limb.side,
        fault("aop.read.side", found=held.frame.side, written=limb.side),
    )
    same_form = found.radii_mm.shape == wanted.radii_mm.shape
    require(
        same_form, fault("aop.read.form", found=found.radii_mm.shape, written=wanted.radii_mm.shape)
    )
    apart = float(np.abs(found.radii_mm - wanted.radii_mm).max())
    require(apart <= _ROUNDING_MM, fault("aop.read.radii", apart_mm=apart))
    turned = float(np.abs(found.thetas_deg - wanted.thetas_deg).max())
    require(turned < 1e-2, fault("aop.read.turned", turned_deg=turned))
    lifted = float(np.abs(found.z_mm - wanted.z_mm).max())
    require(lifted <= _ROUNDING_MM, fault("aop.read.heights"))
    marks, written = len(held.landmarks), len(limb.landmarks)
    require(marks == written, fault("aop.read.landmarks", found=marks, written=written))
    places = _landmark_places(limb, mapped, "mm")
    tolerance = _INCH_ROUNDING_MM if options.profile == "omega" else 2 * _ROUNDING_MM
    for mark, (radius, theta, z) in zip(held.landmarks, places.tolist(), strict=True):
        angle = np.radians(theta)
        there = np.array([radius * np.sin(angle), radius * np.cos(angle), z])
        off = float(np.abs(mark.position_mm - there).max())
        require(off <= tolerance, fault("aop.read.landmark", landmark=mark.name, off_mm=off))
