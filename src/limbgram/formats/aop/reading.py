"""Reading AOP: from the numbers of a file to a limb in its own frame."""

from dataclasses import dataclass, replace

import numpy as np

from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.units import MM_PER_INCH
from limbgram.findings import Finding, doubt, note
from limbgram.formats.aop.grammar import AopFile, AopLandmark, parse_aop
from limbgram.formats.aop.profiles import (
    Profile,
    from_the_front,
    landmarks_from_file,
    profile_of,
    written_here,
)
from limbgram.formats.format import Format
from limbgram.formats.triangle_soup import Soup
from limbgram.workbench.carving.radius_map import Grid, RadiusMap
from limbgram.workbench.frame.alignment import expected_direction
from limbgram.workbench.frame.landmarks import known_anywhere
from limbgram.workbench.limb import Landmark, LimbFrame, names_apart

_ON_SURFACE_MM = 3.0
"""If a landmark is farther than this from the surface in every unit, its radius is no radius."""
_UNIT_COMMENT = "LANDMARK RADIUS UNIT:"
LIMB_FROM_FILE_COMMENT = "LIMB FROM FILE:"
"""Followed by the rows of the motion from the file's axes to the limb's: 12 numbers, mm."""
_ROUNDING = 1e-6
_FRONT_AT_MINUS_Y: tuple[Profile, ...] = ("ampscan", "ampscan-early")
"""These programs count from -Y of the shape's own frame, wherever the front may be."""


@dataclass(frozen=True, kw_only=True)
class AopReading:
    """The interpreted content of an AOP file."""

    radius_map: RadiusMap
    frame: LimbFrame
    landmarks: tuple[Landmark, ...]
    profile: Profile
    mm_per_landmark_radius: float
    """25.4 where the landmarks' radii are in inches."""
    writer_known: bool
    """Whether a comment names the program that wrote it, as ours and ampscan's do."""
    warnings: tuple[Finding, ...]


def read_aop(content: bytes, name: str, profile: Profile | None = None) -> AopReading:
    """Read an AOP file; None takes its likely profile.

    The limb frame is that of the file, z along the carving axis and the front at angle 0, unless a
    comment by this program gives the motion from the file's axes to the limb's.
    """
    file = parse_aop(content, name)
    profile = profile or profile_of(file)
    if profile in ("ampscan", "ampscan-early") and file.spokes_listed:
        raise ShapeFileError("aop.ampscan_listed", name=name)
    radius_map = from_the_front(file.radius_map, profile)
    mm_per_radius = _landmark_unit(file, radius_map, profile)
    stated = any(_UNIT_COMMENT in line.upper() for line in file.comments)
    warnings = list(file.warnings)
    front_told = profile not in _FRONT_AT_MINUS_Y or written_here(file)
    if not front_told:
        warnings.append(doubt("aop.ampscan_turn", early=profile == "ampscan-early"))
        warnings.append(doubt("aop.front_left_open"))
    landmarks: list[Landmark] = []
    for mark in file.landmarks:
        points = landmarks_from_file(mark.places, profile, mm_per_radius)
        on_surface = _projected_on(points, radius_map)
        off_mm = np.abs(np.hypot(*points[:, :2].T) - np.hypot(*on_surface[:, :2].T))
        if not stated and off_mm.max() > _ON_SURFACE_MM:
            radius = float(mark.places[off_mm.argmax(), 0])
            warnings.append(doubt("aop.landmark_unit", landmark=mark.name, radius=radius))
            points = np.where((off_mm > _ON_SURFACE_MM)[:, None], on_surface, points)
        landmarks += _landmarks_from(mark, points)
    landmarks = _with_unique_names(landmarks, warnings)
    return AopReading(
        radius_map=radius_map,
        frame=LimbFrame(
            limb_from_mesh=_limb_from_file(file.comments, warnings),
            side=file.side,
            front_told=front_told,
        ),
        landmarks=tuple(landmarks),
        profile="omega" if profile == "mm" and mm_per_radius == MM_PER_INCH else profile,
        mm_per_landmark_radius=mm_per_radius,
        writer_known=profile in _FRONT_AT_MINUS_Y or written_here(file),
        warnings=tuple(warnings),
    )


def read_aop_soup(content: bytes, name: str) -> Soup:
    """The surface with the landmarks, axes and side of the file."""
    found = read_aop(content, name)
    sure = found.writer_known or any(
        expected_direction(known_anywhere(mark.name, None), found.frame.side)
        for mark in found.landmarks
    )
    unnamed = () if sure else (note("aop.front_taken"),)
    return Soup(
        mesh=found.radius_map.surface(),
        stated_unit="mm",
        landmarks=found.landmarks,
        frame=found.frame,
        grid=Grid(thetas_deg=found.radius_map.thetas_deg, z_mm=found.radius_map.z_mm),
        notes=(*found.warnings, *unnamed),
    )


def _with_unique_names(landmarks: list[Landmark], warnings: list[Finding]) -> list[Landmark]:
    """The landmarks with repeated names made unique, and a note of each."""
    names = names_apart([mark.name for mark in landmarks])
    warnings += [
        note("aop.landmark_twice", landmark=mark.name, called=name)
        for mark, name in zip(landmarks, names, strict=True)
        if mark.name != name
    ]
    return [replace(mark, name=name) for mark, name in zip(landmarks, names, strict=True)]


def _limb_from_file(comments: tuple[str, ...], warnings: list[Finding]) -> Rigid:
    """The motion from the file's axes to the limb's that a comment gives; else the identity."""
    for line in comments:
        if not line.upper().startswith(LIMB_FROM_FILE_COMMENT):
            continue
        try:
            rows = np.array([float(word) for word in line.split(":", 1)[1].split()]).reshape(3, 4)
        except ValueError:
            rows = np.zeros((3, 4))
        turn = rows[:, :3]
        rigid = np.isfinite(rows).all() and np.abs(turn @ turn.T - np.eye(3)).max() < _ROUNDING
        if rigid and np.linalg.det(turn) > 0:
            return Rigid(turn.copy(), rows[:, 3].copy())
        warnings.append(doubt("aop.axis_place"))
    return Rigid.identity()


def _landmark_unit(file: AopFile, radius_map: RadiusMap, profile: Profile) -> float:
    """Millimetres in one unit of the landmarks' radii: by a comment, the profile, or the fit."""
    for line in file.comments:
        if _UNIT_COMMENT in line.upper():
            return MM_PER_INCH if line.upper().split(_UNIT_COMMENT)[1].strip() == "IN" else 1.0
    if profile != "mm":
        return MM_PER_INCH if profile == "omega" else 1.0
    if not file.landmarks:
        return 1.0
    radii, thetas, heights = np.concatenate([mark.places for mark in file.landmarks]).T
    surface = radius_map.radius_at_mm(thetas, heights)
    as_mm = float(np.median(np.abs(radii - surface)))
    as_inches = float(np.median(np.abs(MM_PER_INCH * radii - surface)))
    return MM_PER_INCH if as_inches < min(as_mm, _ON_SURFACE_MM) else 1.0


def _projected_on(points: Points3, radius_map: RadiusMap) -> Points3:
    """The points moved radially on to the surface."""
    angles = np.arctan2(points[:, 0], points[:, 1])
    radii = radius_map.radius_at_mm(np.degrees(angles), points[:, 2])
    return np.column_stack([radii * np.sin(angles), radii * np.cos(angles), points[:, 2]])


def _landmarks_from(mark: AopLandmark, points: np.ndarray) -> list[Landmark]:
    """A landmark for each point; those of a line are numbered."""
    name = "".join(letter for letter in mark.name if letter.isprintable())[:70] or "unnamed"
    if len(points) == 1:
        return [Landmark(name=name, position_mm=points[0])]
    return [
        Landmark(name=f"{name} {count}", position_mm=point) for count, point in enumerate(points, 1)
    ]


FORMAT = Format(
    suffix=".aop",
    place=70,
    used_for={"en": "carver, central fabrication", "de": "Fräse, Zentralfertigung"},
    read=read_aop_soup,
)
