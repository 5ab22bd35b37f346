"""Profiles: what programs of the trade do differently with the same format.

mm      what this program writes: everything in millimetres, angles from the front.
omega   landmark radii in inches, everything else in millimetres.
ampscan its reader and writer stand one spoke behind (the first spoke lies one spacing after the
        front), and its landmarks are angles from +x in a frame with the front at -y.
ampscan-early
        files of its first writer (February to October 2022) count the spokes the other way round:
        taken as they stand they are mirror images. Measured on two of its files against the shapes
        they were made of: 0.12 and 0.21 mm RMS so, over 5 mm the usual way. Nothing in a file says
        surely which writer it was: both list slices or not as they are asked to.
"""

from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.units import MM_PER_INCH
from limbgram.formats.aop.grammar import AopFile
from limbgram.workbench.carving.radius_map import RadiusMap

Profile = Literal["mm", "omega", "ampscan", "ampscan-early"]
_EVEN = 1e-3
"""Listed heights are even within this part of their spacing (files have six decimals)."""


def profile_of(file: AopFile) -> Profile:
    """The profile that a file speaks for; omega is told later, by the landmarks' radii.

    Files of the first writer of ampscan that are known list even heights one by one; the later one
    does so only where it is asked to. Either way the reader notes that it may be the other one.
    """
    if not any("ampscan" in line.lower() for line in file.comments):
        return "mm"
    steps = np.diff(file.radius_map.z_mm)
    even = float(np.ptp(steps)) <= _EVEN * float(steps.mean())
    early = file.slices_listed and even and not written_here(file)
    return "ampscan-early" if early else "ampscan"


def written_here(file: AopFile) -> bool:
    """Whether this program wrote the file, whose spokes begin at the front of the limb frame."""
    return any(line.upper().startswith("UNIT: MM") for line in file.comments)


def from_the_front(found: RadiusMap, profile: Profile) -> RadiusMap:
    """The map with its angles counted from the front to the patient's right, from 0 to 360."""
    within = found.thetas_deg < found.thetas_deg[0] + 360
    thetas = found.thetas_deg[within]
    if profile == "ampscan":
        thetas = thetas + found.thetas_deg[1]
    elif profile == "ampscan-early":
        thetas = -thetas
    thetas = thetas % 360
    order = np.argsort(thetas)
    return RadiusMap(
        thetas_deg=thetas[order],
        z_mm=found.z_mm,
        radii_mm=found.radii_mm[:, within][:, order],
    )


def landmarks_from_file(
    places: Float64[np.ndarray, "k 3"], profile: Profile, mm_per_radius: float
) -> Points3:
    """Radius, theta, z as a file has them, to the limb frame."""
    radii, angles = places[:, 0] * mm_per_radius, np.radians(places[:, 1])
    across, ahead = radii * np.sin(angles), radii * np.cos(angles)
    if profile in ("ampscan", "ampscan-early"):
        across, ahead = -ahead, -across
    return np.column_stack([across, ahead, places[:, 2]])


def landmarks_to_file(points_in_limb: Points3, profile: Profile) -> Float64[np.ndarray, "k 3"]:
    """Points of the limb frame as radius, theta and z in the file's units."""
    x, y, z = points_in_limb.T
    radii = np.hypot(x, y)
    if profile == "ampscan":
        return np.column_stack([radii, np.degrees(np.arctan2(-y, -x)), z])
    thetas = np.degrees(np.arctan2(x, y)) % 360
    return np.column_stack([radii / MM_PER_INCH if profile == "omega" else radii, thetas, z])
