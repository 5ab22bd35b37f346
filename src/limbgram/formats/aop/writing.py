"""AOP: the limb as a radius map, as the trade's carvers and programs take it.

In      an aligned Limb; spacing, profile, line ends and form of the header.
Out     the file, read back by our own reader, and an AopReport: how far it differs from the limb.
Fails   CarveError: not aligned, or no radius map can hold the shape. OptionsError.
"""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.files import require, write_bytes
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.known_words import require_known_words
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.units import MM_PER_INCH
from limbgram.findings import fault
from limbgram.formats.aop.axis import fitted_axis
from limbgram.formats.aop.cost import AopReport, cost_of
from limbgram.formats.aop.profiles import Profile, landmarks_to_file
from limbgram.formats.aop.reading import LIMB_FROM_FILE_COMMENT, AopReading, read_aop
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
class SourceGrid:
    """Spokes, slices and axis of the AOP file that a shape was read from."""

    grid: Grid
    limb_from_file: Rigid


@dataclass(frozen=True, kw_only=True)
class AopOptions:
    """What the program that will read the file expects."""

    map: MapOptions = field(default_factory=MapOptions)
    source_grid: SourceGrid | None = None
    """Used in place of `map` and `axis`: the radii are not resampled, and writing the shape again
    gives the same file."""
    axis: Literal["limb", "fit"] = "limb"
    """fit: the file's axis is fitted so that rays meet the surface once, and the file has the
    motion to the limb's axis. The map's heights are not the limb's then, and cannot be given."""
    profile: Profile = "mm"
    line_end: LineEnd = "lf"
    spokes_listed: bool = False
    """Write every angle, not the spacing."""
    slices_listed: bool = True
    """Write every height, not the spacing: as all files seen from other programs do."""

    def __post_init__(self) -> None:
        require_known_words(self)

    @property
    def all_spokes_listed(self) -> bool:
        """Whether every angle is written: by choice, or because the spacing is uneven."""
        return self.spokes_listed or (
            self.source_grid is not None and not self.source_grid.grid.even
        )


DEFAULTS = AopOptions()


def write_aop(limb: Limb, path: Path | str, options: AopOptions = DEFAULTS) -> AopReport:
    """Write an aligned limb as AOP, and report how far the file differs from it."""
    path = Path(path)
    limb = limb.aligned()
    _check_options(options)
    points = limb.limb_from_mesh.apply(limb.mesh.vertices_mm)
    outside = outer_bodies(Mesh(vertices_mm=points, faces=limb.mesh.faces))
    outside.require_one_limb()
    axis_from_limb, mesh, mapped = _mapped(outside.mesh, options)
    frame = replace(limb.frame, limb_from_mesh=axis_from_limb @ limb.limb_from_mesh)
    limb = replace(limb, frame=frame)
    limb_from_file = _limb_from_file(axis_from_limb, mapped, options)
    _check_slices(mapped, options)
    text = _text(limb, mapped, options, limb_from_file)
    held: list[AopReading] = []
    content = text.replace("\n", _LINE_ENDS[options.line_end]).encode("ascii")

    def check(written: Path) -> None:
        held.append(read_aop(written.read_bytes(), path.name))
        _require_equal(held[0], limb, mapped, options)
        found = held[0].frame.limb_from_mesh
        require(
            _distance_mm(found, limb_from_file or Rigid.identity()) < _ROUNDING_MM,
            fault("aop.read.place"),
        )

    write_bytes(path, content, check)
    return cost_of(path, mesh, mapped, held[0], axis_from_limb, outside)


def _mapped(mesh: Mesh, options: AopOptions) -> tuple[Rigid, Mesh, MappedSurface]:
    """The motion to the file's axis, the mesh in that frame, and its radii."""
    if options.source_grid is not None:
        axis_from_limb = options.source_grid.limb_from_file.inverse
        moved = mesh.moved(axis_from_limb)
        return axis_from_limb, moved, map_radii_on(moved, options.source_grid.grid, options.map)
    if options.axis == "fit":
        try:
            return _mapped_about(fitted_axis(mesh, options.map), mesh, options)
        except CarveError as error:
            raise CarveError("aop.fit_fails", why=error.finding) from error
    try:
        return _mapped_about(Rigid.identity(), mesh, options)
    except CarveError as error:
        unlimited = replace(options, map=replace(options.map, from_mm=None, to_mm=None))
        try:
            found, _, _ = _mapped_about(fitted_axis(mesh, unlimited.map), mesh, unlimited)
        except CarveError:
            raise error from None
        raise CarveError(
            "aop.other_axis",
            why=error.finding,
            tilt_deg=angle_between_deg(found.rotation, np.eye(3)),
            without_limits=unlimited.map != options.map,
        ) from error


def _mapped_about(
    axis_from_limb: Rigid, mesh: Mesh, options: AopOptions
) -> tuple[Rigid, Mesh, MappedSurface]:
    moved = mesh.moved(axis_from_limb)
    return axis_from_limb, moved, map_radii(moved, options.map)


def _limb_from_file(
    axis_from_limb: Rigid, mapped: MappedSurface, options: AopOptions
) -> Rigid | None:
    """The motion from the file's axes to the limb's; None where they are the limb's own.

    Heights in the file count from its first slice, unless they are those of the source file.
    """
    if options.source_grid is not None:
        motion = options.source_grid.limb_from_file
        return None if _distance_mm(motion, Rigid.identity()) < _ROUNDING_MM else motion
    if options.axis != "fit":
        return None
    return axis_from_limb.inverse @ Rigid(np.eye(3), np.array([0.0, 0.0, mapped.first_mm]))


def _distance_mm(one: Rigid, other: Rigid) -> float:
    """Largest distance between the images of points 500 mm from the origin under two motions."""
    corners = 500.0 * np.concatenate([np.zeros((1, 3)), np.eye(3)])
    return float(np.abs(one.apply(corners) - other.apply(corners)).max())


def _check_options(options: AopOptions) -> None:
    if options.axis == "fit" and (options.map.from_mm, options.map.to_mm) != (None, None):
        raise OptionsError("aop.heights_and_fit")
    listed = options.all_spokes_listed
    if options.profile == "ampscan-early" or (options.profile == "ampscan" and listed):
        raise OptionsError("aop.ampscan_mirrors")


def _check_slices(mapped: MappedSurface, options: AopOptions) -> None:
    heights = mapped.radius_map.z_mm
    uneven = float(np.ptp(np.diff(heights))) > 1e-6 or heights[0] != 0
    if not options.slices_listed and uneven:
        raise OptionsError("aop.uneven_slices")


def _text(
    limb: AlignedLimb, mapped: MappedSurface, options: AopOptions, limb_from_file: Rigid | None
) -> str:
    found = mapped.radius_map
    inches = options.profile == "omega"
    lines = ["AAOP1", "AAOP1", "Written by limbgram", "UNIT: MM"]
    lines.append(f"LANDMARK RADIUS UNIT: {'IN' if inches else 'MM'}")
    if options.profile == "ampscan":
        lines.append("Spokes as ampscan reads them")
    if limb_from_file is not None:
        numbers = " ".join(f"{value:.9f}" for value in limb_from_file.matrix_3x4.ravel())
        lines += ["AXIS FITTED, NOT THE LIMB'S OWN", f"{LIMB_FROM_FILE_COMMENT} {numbers}"]
    lines += ["END COMMENTS", "CYLINDRICAL", limb.side.upper(), str(len(limb.landmarks))]
    places = _landmark_places(limb, mapped, options.profile)
    names = names_apart([_plain_name(mark.name) for mark in limb.landmarks])
    for name, (radius, theta, z) in zip(names, places.tolist(), strict=True):
        lines += [name, "1", f"{radius:.3f}", f"{theta:.{_ANGLE_DIGITS}f}"]
        lines.append(f"{z:.3f}")
    spokes = len(found.thetas_deg)
    spacing = 360.0 / spokes
    listed = options.all_spokes_listed
    lines += [str(spokes), "0" if listed else _compact(spacing)]
    lines += [_compact(theta) for theta in found.thetas_deg] if listed else []
    heights = found.z_mm.tolist()
    lines.append(str(len(heights)))
    lines += ["0", *map(_compact, heights)] if options.slices_listed else [_compact(heights[1])]
    lines += [
        f"{radius:.3f}" for radius in _radii_in_file_order(mapped, options.profile).ravel().tolist()
    ]
    return "\n".join(lines) + "\n"


def _landmark_places(
    limb: AlignedLimb, mapped: MappedSurface, profile: Profile
) -> Float64[np.ndarray, "k 3"]:
    in_limb = limb.landmarks_in_limb_mm - np.array([0.0, 0.0, mapped.first_mm])
    return landmarks_to_file(in_limb, profile)


def _radii_in_file_order(mapped: MappedSurface, profile: Profile) -> Float64[np.ndarray, "m n"]:
    """Radii in the file's order of spokes: ampscan's first spoke is our second."""
    return np.roll(mapped.radius_map.radii_mm, -1 if profile == "ampscan" else 0, axis=1)


def _plain_name(name: str) -> str:
    """A name in ASCII that cannot be taken for another line of the file."""
    plain = re.sub(r"[^ -~]", "?", without_accents(name)).strip()[:_LONGEST_NAME].strip()
    return plain or "unnamed"


def _compact(value: float) -> str:
    """Six decimals without trailing zeros."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


def _require_equal(
    held: AopReading, limb: AlignedLimb, mapped: MappedSurface, options: AopOptions
) -> None:
    """Refuse a file that reads back with another side, map or landmarks, within its digits."""
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
