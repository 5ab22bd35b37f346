"""Lens groups: what photos themselves tell of the lenses that took them.

In      photos, their features and verified pairs, and the lenses as files tell them.
Out     ByLens: the same photos with a camera group for each lens, and its calibration; None where
        the photos tell nothing else, or that cannot be told.
Method  Two lenses that one name, or none, stands for: every photo is placed with a focal length of
        its own, drawn to a usual one by the wide prior that photos without EXIF have. The points
        that photos share hold it to about 1 %, and a phone's lenses differ by a factor of 1.5 to 5:
        the largest gap between the focal lengths parts the photos, if it is wide and both sides are
        close together.
        Pictures cut out of larger ones with the ratio of their sides look like smaller copies: the
        photos are placed with a lens for each size that is held as little as that of a picture
        which was cut. Copies keep the focal length of the larger ones, reduced as their sides were;
        pictures that were cut have a longer one.
Fails   never.
Limits  Two lenses; fewer than three photos of one are no group. It costs another placing, so two
        lenses are looked for only where one does not place all photos, and cut pictures only where
        sizes are mixed. Less than 4 % cut off is not told from a copy, and then moves the middle of
        the lens by 2 % at most.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from limbgram.core.errors import PlacementError
from limbgram.reconstruction.calibration.cameras import (
    Calibration,
    Cameras,
    cut_lens,
    wide_covariance,
)
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.mapping.placement import MappingOptions, place_roughly
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.photos.lenses import copies_of
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.twoview.pairs import Pairs

_FEWEST_PHOTOS = 3
_LEAST_TIMES = 1.3
"""Focal lengths of two lenses differ by so much at least; the steps of phones are 1.5 to 5."""
_CLEAR = 4.0
"""The gap is so many times as wide as either side at least, in logarithms."""
_FIRM = 0.05
"""Relative sigma of a focal length that photos told so: about 1 % in all of theirs, doubled, and
what the pictures of one lens differ by."""
_CUT = 1.04
"""Focal length of cut pictures over that of copies, at least: mixed sizes of one lens keep within
1 % of each other;"""
_SIGMAS = 5.0
"""and so many of its sigmas: one photo of a size tells little of its lens."""


@dataclass(frozen=True)
class ByLens:
    """Photos with a camera group for each of their lenses."""

    photos: PhotoSet
    cameras: Cameras


def lens_is_told(photos: PhotoSet, cameras: Cameras) -> bool:
    """Whether a file says what took the photos, or they have lenses of their own already."""
    return len(photos.cameras) != 1 or cameras.calibrations[0].source != "guess"


def by_lens(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    mapping: MappingOptions,
) -> ByLens | None:
    """The photos by the lenses that they themselves tell of."""
    (group,), (guess,) = photos.cameras, cameras.calibrations
    count = len(photos.photos)
    apart = replace(
        photos,
        photos=tuple(replace(one, camera_idx=k) for k, one in enumerate(photos.photos)),
        cameras=(group,) * count,
    )
    alone = replace(mapping, photo_lenses="never")
    try:
        scene = place_roughly(apart, features, pairs, Cameras((guess,) * count), alone)
    except PlacementError:
        return None
    placed = np.array(scene.placed)
    focal_px = np.array([scene.cameras[photo].fx for photo in placed])
    order = np.argsort(focal_px)
    logs = np.log(focal_px[order])
    cuts = range(_FEWEST_PHOTOS, len(logs) - _FEWEST_PHOTOS + 1)
    if not cuts:
        return None
    cut = max(cuts, key=lambda k: float(logs[k] - logs[k - 1]))
    gap = float(logs[cut] - logs[cut - 1])
    spread = max(float(np.ptp(logs[:cut])), float(np.ptp(logs[cut:])))
    if gap < np.log(_LEAST_TIMES) or gap < _CLEAR * spread:
        return None
    middles = [float(np.exp(np.median(part))) for part in (logs[:cut], logs[cut:])]
    fewer = order[cut:]
    if len(fewer) * 2 > len(placed):  # most photos are those of the camera's first lens
        middles, fewer = middles[::-1], order[:cut]
    second = {int(placed[k]) for k in fewer}  # of photos without a place nobody knows
    told = tuple(replace(one, camera_idx=int(k in second)) for k, one in enumerate(photos.photos))
    groups = (group, replace(group, longer=middles[1] / middles[0]))
    lenses = tuple(_with_focal(guess, middle) for middle in middles)
    return ByLens(replace(photos, photos=told, cameras=groups), Cameras(lenses))


def by_cut(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    cameras: Cameras,
    mapping: MappingOptions,
) -> ByLens:
    """The photos with those sizes told as cut out whose pictures are no copies of larger ones."""
    as_told = ByLens(photos, cameras)
    copies = copies_of(photos)
    free = {k: cut_lens(cameras.calibrations[k]) for k in copies}
    loose = Cameras(tuple(free.get(k, one) for k, one in enumerate(cameras.calibrations)))
    alone = replace(mapping, photo_lenses="never")
    try:
        scene = place_roughly(photos, features, pairs, loose, alone)
    except PlacementError:
        return as_told

    log_focal = {k: _log_focal(scene, photos, k) for k in {*copies, *copies.values()}}

    def is_cut(part: int, whole: int) -> bool:
        ours, theirs = log_focal[part], log_focal[whole]
        if ours is None or theirs is None:
            return False
        first, second = (cameras.calibrations[k].camera.fx for k in (part, whole))
        longer = ours.value - theirs.value - np.log(first / second)
        return longer > max(np.log(_CUT), _SIGMAS * np.hypot(ours.sigma, theirs.sigma))

    cut = [part for part, whole in copies.items() if is_cut(part, whole)]
    if not cut:
        return as_told
    groups = tuple(replace(one, cut_out=k in cut) for k, one in enumerate(photos.cameras))
    lenses = tuple(
        loose.calibrations[k] if k in cut else one for k, one in enumerate(cameras.calibrations)
    )
    return ByLens(replace(photos, cameras=groups), Cameras(lenses))


class _LogFocal(NamedTuple):
    """Logarithm of a focal length in pixels."""

    value: float
    sigma: float


def _log_focal(scene: Scene, photos: PhotoSet, group: int) -> _LogFocal | None:
    """Of the photos of one size, as they were placed; None where none of them was."""
    placed = [k for k in scene.placed if photos.photos[k].camera_idx == group]
    if not placed or scene.lens_covariance is None:
        return None
    lens = scene.camera_idx[placed[0]]
    focal_px = scene.cameras[lens].fx
    sigma_px = float(np.sqrt(scene.lens_covariance[lens, 0, 0]))
    return _LogFocal(float(np.log(focal_px)), sigma_px / focal_px)


def _with_focal(guess: Calibration, focal_px: float) -> Calibration:
    """The guessed lens with this focal length, known as far as photos told it."""
    camera = replace(guess.camera, fx=focal_px, fy=focal_px)
    return replace(guess, camera=camera, covariance=wide_covariance(camera, _FIRM))
