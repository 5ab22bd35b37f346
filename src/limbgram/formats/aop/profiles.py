"""Profiles: how programs differ in their use of the AOP format.

mm      what this program writes: everything in millimetres, angles from the front.
omega   landmark radii in inches, everything else in millimetres.
ampscan spokes are shifted by one (the first spoke lies one spacing after the front), and landmarks
        are angles from +x in a frame with the front at -y.
ampscan-early
        files of its first writer (February to October 2022) count the spokes in the opposite sense:
        read as other files they give mirror images. Two of its files, read by this profile, differ
        from the shapes they were made from by 0.12 and 0.21 mm RMS; read by `ampscan`, by over
        5 mm. Nothing in a file says surely which writer it was: both can list slices.
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
"""Largest difference of equal spacings, as a share of the spacing (files have six decimals)."""


def profile_of(file: AopFile) -> Profile:
    """The likely profile of a file; omega is recognised later, by the landmarks' radii.

    All known files of ampscan's first writer list equally spaced heights one by one; the later
    writer does so only on request. The reader notes that it may be the other one.
    """
    if not any("ampscan" in line.lower() for line in file.comments):
        return "mm"
    steps = np.diff(file.radius_map.z_mm)
    evenly_spaced = float(np.ptp(steps)) <= _EVEN * float(steps.mean())
    early = file.slices_listed and evenly_spaced and not written_here(file)
    return "ampscan-early" if early else "ampscan"


def written_here(file: AopFile) -> bool:
    """Whether this program wrote the file, whose spokes begin at the front of the limb frame."""
    return any(line.upper().startswith("UNIT: MM") for line in file.comments)


def from_the_front(found: RadiusMap, profile: Profile) -> RadiusMap:
    """The map with its angles from the front towards the patient's right, 0 to 360 degrees."""
    first_turn = found.thetas_deg < found.thetas_deg[0] + 360
    thetas = found.thetas_deg[first_turn]
    if profile == "ampscan":
        thetas = thetas + found.thetas_deg[1]
    elif profile == "ampscan-early":
        thetas = -thetas
    thetas = thetas % 360
    order = np.argsort(thetas)
    return RadiusMap(
        thetas_deg=thetas[order],
        z_mm=found.z_mm,
        radii_mm=found.radii_mm[:, first_turn][:, order],
    )


def landmarks_from_file(
    places: Float64[np.ndarray, "k 3"], profile: Profile, mm_per_radius: float
) -> Points3:
    """Points of the limb frame from radius, theta and z in the file's units."""
    radii_mm, angles = places[:, 0] * mm_per_radius, np.radians(places[:, 1])
    x, y = radii_mm * np.sin(angles), radii_mm * np.cos(angles)
    if profile in ("ampscan", "ampscan-early"):
        x, y = -y, -x
    return np.column_stack([x, y, places[:, 2]])


def landmarks_to_file(points_in_limb: Points3, profile: Profile) -> Float64[np.ndarray, "k 3"]:
    """Points of the limb frame as radius, theta and z in the file's units."""
    x, y, z = points_in_limb.T
    radii = np.hypot(x, y)
    if profile == "ampscan":
        return np.column_stack([radii, np.degrees(np.arctan2(-y, -x)), z])
    thetas = np.degrees(np.arctan2(x, y)) % 360
    return np.column_stack([radii / MM_PER_INCH if profile == "omega" else radii, thetas, z])
