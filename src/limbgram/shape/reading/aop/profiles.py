"""Profiles: what programs of the trade do differently with the same format.

mm      what this program writes: everything in millimetres, angles from the front.
omega   landmark radii in inches, everything else in millimetres.
ampscan its reader and writer stand one spoke behind (the first spoke lies one spacing after the
        front), and its landmarks are angles from +x in a frame with the front at -y.
"""

from typing import Literal

import numpy as np
from jaxtyping import Float64

from limbgram.geometry.arrays import Points3
from limbgram.shape.reading.aop.grammar import AopFile

Profile = Literal["mm", "omega", "ampscan"]
MM_PER_INCH = 25.4


def profile_of(file: AopFile) -> Profile:
    """The profile that a file's comments and landmarks speak for; omega is told by its radii."""
    return "ampscan" if any("ampscan" in line.lower() for line in file.comments) else "mm"


def spoke_turn_deg(profile: Profile, spacing_deg: float) -> float:
    """What is added to a file's angles to count them from the front."""
    return spacing_deg if profile == "ampscan" else 0.0


def landmarks_from_file(
    places: Float64[np.ndarray, "k 3"], profile: Profile, mm_per_radius: float
) -> Points3:
    """Radius, theta, z as a file has them, to the limb frame."""
    radii, angles = places[:, 0] * mm_per_radius, np.radians(places[:, 1])
    across, ahead = radii * np.sin(angles), radii * np.cos(angles)
    if profile == "ampscan":
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
