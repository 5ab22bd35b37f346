"""Movement: test for relative rigid motion of two bodies, from the camera poses by each.

In      two scenes of the same photos, each placed by the points of one body alone.
Out     a Movement: by photo, how far the second body moved against the first, and how sure that is.
Method  If both bodies held still, the photos' places by the one are the places by the other, in
        another frame and size. What is left is a small turn and shift of every photo, in its own
        frame, with the covariance of both adjustments, that between photos too: neighbours err
        together, and an open arc of them bends. Not counted is the shift along the line of
        sight (another focus or zoom looks the same), nor a turn and a shift across that all photos
        of one camera share (an error of its lens looks the same). The rest is explained by steps
        between the photos, in their order, or by an even drift, which may turn the body or not:
        each must lessen the sum of squares by more than chance does, by an F test with Bonferroni's
        correction for all that was tried; the noise is that of the adjustments or of what no step
        explains, whichever is larger. And each must explain clearly more than a motion that follows
        the camera round the limb, as a lens that focuses anew bends a whole ring.
        A photo that explains all by itself, and that one body holds by few points, is left out.
        Where much is left by both, that is restlessness; so it is where neither is told, chance
        leaves less, and neither that motion round the limb explains it nor one photo. Where lenses
        are not known, it is unknown.
Limits  Movement along a line that no photo looks across is not seen; in a walk round the limb there
        is no such line. Nor is movement in one photo alone that a body holds by few points.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float64, Int64
from scipy import stats
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid, Similarity, fit_similarity
from limbgram.core.geometry.lens import POSE_SIZE
from limbgram.findings import Finding, note
from limbgram.reconstruction.mapping.scene import Movement, Scene

_FEWEST_PHOTOS = 10
"""Fewer tell nothing: half a ring of 7 photos of 0.24 MP seemed to move, and did not."""
_FEWEST_POINTS = 15
_FEWEST_SHARED = 8
"""Points that two photos must share to hang together, and that a photo must share with two others:
one that has only pairs in common slips along them. Of 12 photos one with 7 seemed to move by 1.4 %
of the distance, and did not; those that kept still have 11 and more."""
_FIRMLY = 30
"""Points shared with two others from which a photo that lies elsewhere is believed. Of 100 captures
that kept still two had one that lay 2 and 7 mm elsewhere by the surroundings, held by 8 and 24."""
_COUNTED = np.array([0, 1, 2, 3, 4])
"""Turn about three axes and shift across; not the shift along the line of sight."""
_SAME = 1e-9
"""Of the largest: directions that differ by less are one."""
_UNEXPLAINED = 4.0
"""What steps or a drift leave, in variances of the adjustments, from which they explain nothing:
twice the sigma. Captures without movement leave 0.3 to 1.1."""
_SPREAD = 0.01
"""Chance below which what is left without a step or drift is a sway, once what changes evenly round
the limb is taken out as well, and once the photo that explains most is: errors of neighbouring
photos are alike, one photo may be held badly, and a sway is in all of them."""
_CLEARLY = 10.0
"""Difference of Bayesian criteria that is very strong evidence (Kass and Raftery 1995)."""
_MOVE, _SHIFT = 6, 3
"""Numbers of a rigid motion, and of one without a turn."""


@dataclass(frozen=True, kw_only=True)
class MovementOptions:
    """What counts as movement."""

    false_alarm: float = 1e-5
    """Chance at which photos without any movement are said to show one. Of 41 steps of 2 mm the
    least clear had 4e-7; one of 100 captures that kept still looks like a step by 4e-5."""
    drift_alarm: float = 1e-4
    """The same of a drift. Its test takes the noise to be that of the adjustments at least, twice
    what most photos without movement show."""
    least_shift: float = 0.0003
    """Least shift of a photo's group, as a share of the distance of the cameras: less is below what
    the surface shows (0.45 mm from 1.5 m)."""


DEFAULTS = MovementOptions()


def joined_photos(scene: Scene) -> tuple[int, ...]:
    """The largest set of photos that hang together by shared points, each with enough of them."""
    seen = scene.observations
    count = np.bincount(seen.photo_idx, minlength=len(scene.names))
    sees = csr_array(
        (np.ones(len(seen.photo_idx), np.int32), (seen.photo_idx, seen.point_idx)),
        shape=(len(scene.names), len(scene.points_in_world)),
    )
    shared = (sees @ sees.T).toarray()
    enough = (count >= _FEWEST_POINTS) & (tied_points(scene) >= _FEWEST_SHARED)
    graph = (shared >= _FEWEST_SHARED) & enough[:, None] & enough[None]
    label = connected_components(csr_array(graph), directed=False)[1]
    sizes = np.bincount(label[enough], minlength=1) if enough.any() else np.zeros(1)
    return tuple(np.flatnonzero(enough & (label == int(sizes.argmax()))).tolist())


def tied_points(scene: Scene) -> Int64[np.ndarray, " n"]:
    """By photo, the points that it shares with two other photos or more."""
    seen = scene.observations
    shown = np.bincount(seen.point_idx, minlength=len(scene.points_in_world))
    tied = seen.photo_idx[shown[seen.point_idx] > 2]
    return np.bincount(tied, minlength=len(scene.names)).astype(np.int64)


@dataclass(frozen=True, kw_only=True)
class BodyMotion:
    """A Movement, and by photo the motion itself."""

    movement: Movement
    middle: Vector3
    """Of the first body, in its scene's world; motions turn about it."""
    motions: Float64[np.ndarray, "n 6"]
    """Turn (axis times angle, rad) and shift of the second body from its place in the photos that
    the Movement refers to; nought where nothing is known. World frame and unit of the first."""

    @classmethod
    def unknown(cls, photos: int, reason: Finding, chance: float = 1.0) -> "BodyMotion":
        none = Movement.unknown(photos, reason, chance)
        return cls(movement=none, middle=np.zeros(3), motions=np.zeros((photos, _MOVE)))

    def moved(self, photo: int) -> Rigid:
        """The motion of the second body in one photo."""
        turn = Rigid.from_rotation_vector(self.motions[photo, :3], np.zeros(3))
        shift = self.middle + self.motions[photo, 3:] - turn.apply(self.middle[None])[0]
        return Rigid(turn.rotation, shift)


def movement_between(
    first: Scene, second: Scene, options: MovementOptions = DEFAULTS, *, lenses_known: bool = True
) -> BodyMotion:
    """How the second body moved against the first, at the middle of the first one's points.

    Args:
        lenses_known: Whether a board calibrated them all. What no course explains is then
            movement; otherwise it may be the lens, which focuses anew for every photo.
    """
    photos = tuple(sorted({*first.placed} & {*second.placed}))
    if len(photos) < _FEWEST_PHOTOS:
        few = note("movement.unknown.few_shown", photos=len(photos))
        return BodyMotion.unknown(len(first.names), few)
    apart = _Apart.of(first, second, photos)
    loose = _loose(apart, np.minimum(tied_points(first), tied_points(second)), options)
    if loose is not None:
        photos = tuple(photo for photo in photos if photo != loose)
        if len(photos) < _FEWEST_PHOTOS:
            few = note("movement.unknown.few_held", photos=len(photos))
            return BodyMotion.unknown(len(first.names), few)
        apart = _Apart.of(first, second, photos)
    found = _course(apart, options)
    if found.fit.unlikely < options.false_alarm and not lenses_known:
        lens = note("movement.unknown.lens")
        return BodyMotion.unknown(len(first.names), lens, found.fit.unlikely)
    if found.fit.noise > _UNEXPLAINED or (not found.told and _sways(apart, found.fit, options)):
        found = _restless(apart)
    return _told(apart, found, len(first.names), options)


def stood_with_first(
    first: Scene, third: Scene, second: BodyMotion, options: MovementOptions = DEFAULTS
) -> bool:
    """Whether a third body kept still with the first where the second moved against it.

    It did where nothing is found to move between both, and where what the photos show of it is less
    likely by `false_alarm` if it had moved as the second did.
    """
    told = second.movement.group >= 0
    photos = tuple(k for k in sorted({*first.placed} & {*third.placed}) if told[k])
    if len(photos) < _FEWEST_PHOTOS:
        return False
    if movement_between(first, third, options).movement.kind != "still":
        return False
    apart = _Apart.of(first, third, photos)
    still = apart.fitted(np.zeros((len(photos), 0))).left
    moved = np.einsum("mnj,nj->m", apart.moves, second.motions[list(photos)])
    with_second = replace(apart, values=apart.values - moved)
    left = with_second.fitted(np.zeros((len(photos), 0))).left
    return left - still > -2.0 * float(np.log(options.false_alarm))


@dataclass(frozen=True)
class _Apart:
    """Turn and shift of all photos between the two bodies, less what frame, size and lenses
    explain, whitened together: photos that neighbours hold err with them, and an open arc of
    photos bends as a whole."""

    photos: tuple[int, ...]
    values: Float64[np.ndarray, " m"]
    moves: Float64[np.ndarray, "m n 6"]
    """What a motion of the second body (turn, shift, in the world) in one photo does to them."""
    rough: Float64[np.ndarray, "n 6"]
    """Turn and shift in the world, not whitened, of every photo by itself."""
    around: Float64[np.ndarray, " n"]
    """Where the cameras stand round the middle, rad."""
    middle: Vector3
    distance: float

    @classmethod
    def of(cls, first: Scene, second: Scene, photos: tuple[int, ...]) -> "_Apart":
        middle = np.median(first.points_in_world, axis=0)
        first = first.moved(Similarity(1.0, np.eye(3), -middle))
        there = np.array([first.view(k).centre_in_world for k in photos])
        here = np.array([second.view(k).centre_in_world for k in photos])
        second = second.moved(fit_similarity(here, there))
        groups = sorted({first.camera_idx[k] for k in photos})
        values, common, moves, rough = [], [], [], []
        for k in photos:
            one, other = (scene.view(k).camera_from_world for scene in (first, second))
            turn = Rotation.from_matrix(other.rotation @ one.rotation.T).as_rotvec()
            apart = np.concatenate([turn, other.translation - one.translation])
            move = np.zeros((_MOVE, _MOVE))
            move[:3, :3] = move[3:, 3:] = one.rotation
            growth = np.concatenate([np.zeros(3), one.translation])[:, None]
            lens = np.zeros((_MOVE, len(_COUNTED) * len(groups)))
            place = len(_COUNTED) * groups.index(first.camera_idx[k])
            lens[_COUNTED, place + np.arange(len(_COUNTED))] = 1.0
            rough.append(move.T @ apart)
            values.append(apart[_COUNTED])
            common.append(np.hstack([move, growth, lens])[_COUNTED])
            moves.append(move[_COUNTED])
        white = _whitener(_covariance(first, photos) + _covariance(second, photos), common)
        by_photo = white.reshape(len(white), len(photos), len(_COUNTED))
        return cls(
            photos=photos,
            values=white @ np.concatenate(values),
            moves=np.einsum("mni,nij->mnj", by_photo, np.array(moves)),
            rough=np.array(rough),
            around=_around(there),
            middle=middle,
            distance=float(np.median(np.linalg.norm(there - middle, axis=1))),
        )

    def without_turns(self) -> "_Apart":
        """The same where the second body may shift, and turns nowhere."""
        moves = self.moves.copy()
        moves[:, :, :3] = 0.0
        return replace(self, moves=moves)

    def fitted(self, courses: Float64[np.ndarray, "n m"]) -> "_Fit":
        """With one motion for each course: how much of it each photo shows."""
        size = courses.shape[1]
        design = np.einsum("mnj,nk->mkj", self.moves, courses).reshape(
            len(self.values), _MOVE * size
        )
        scale = np.linalg.norm(design, axis=0)
        scale[scale == 0.0] = 1.0
        solved, _, rank, _ = np.linalg.lstsq(design / scale, self.values, rcond=1e-9)
        off = self.values - (design / scale) @ solved
        motions = (solved / scale).reshape(size, _MOVE)
        return _Fit(float(off @ off), len(off) - int(rank), courses @ motions)


def _around(centres: Float64[np.ndarray, "n 3"]) -> Float64[np.ndarray, " n"]:
    """Angles in the plane that lies nearest to all of them."""
    off = centres - centres.mean(axis=0)
    x, y = np.linalg.svd(off)[2][:2] @ off.T
    return np.arctan2(y, x)


def _covariance(scene: Scene, photos: tuple[int, ...]) -> Float64[np.ndarray, "k k"]:
    """Of what is counted of these photos' poses, all together."""
    assert scene.camera_covariance is not None
    first = [POSE_SIZE * scene.placed.index(photo) for photo in photos]
    rows = np.add.outer(first, _COUNTED).ravel()
    return scene.camera_covariance[np.ix_(rows, rows)]


def _whitener(
    covariance: Float64[np.ndarray, "k k"], common: Sequence[Float64[np.ndarray, "5 c"]]
) -> Float64[np.ndarray, "m k"]:
    """What turns values of this covariance into independent ones that `common` leaves as they are.

    Restricted likelihood (Patterson, Thompson 1971): the values are seen in the directions that no
    column of `common` reaches, and there in the eigenvectors of their covariance.
    """
    scale = np.sqrt(np.diag(covariance))
    columns = np.concatenate(common) / scale[:, None]
    lengths = np.linalg.norm(columns, axis=0)
    columns = columns[:, lengths > 0.0] / lengths[lengths > 0.0]
    left, sizes, _ = np.linalg.svd(columns, full_matrices=True)
    free = left[:, int((sizes > _SAME * sizes[0]).sum()) :]
    variances, axes = np.linalg.eigh(free.T @ (covariance / np.outer(scale, scale)) @ free)
    known = variances > _SAME * variances[-1]
    return ((free @ axes[:, known]) / np.sqrt(variances[known])).T / scale


@dataclass(frozen=True)
class _Fit:
    """Weighted sum of squares that is left, its degrees of freedom, and each photo's motion."""

    left: float
    freedom: int
    motions: Float64[np.ndarray, "n 6"]

    @property
    def unlikely(self) -> float:
        """Chance that noise of the adjustments alone leaves so much."""
        return float(stats.chi2.sf(self.left, max(self.freedom, 1)))

    @property
    def noise(self) -> float:
        """Variance in units of that of the adjustments; these are never too small."""
        return max(1.0, self.left / max(self.freedom, 1))


@dataclass(frozen=True)
class _Course:
    """How the second body moved from photo to photo."""

    kind: Literal["still", "step", "drift", "restless"]
    fit: _Fit
    group: Int64[np.ndarray, " n"]
    chance: float
    """That photos without movement look as much like it."""

    numbers: int
    """Numbers that it is made of: six for each motion, three where nothing turns."""

    @property
    def told(self) -> bool:
        return self.kind != "still"

    @property
    def criterion(self) -> float:
        """Bayesian information criterion (Schwarz 1978); the lower, the better explained."""
        return self.fit.left + self.numbers * float(np.log(5 * len(self.group)))


def _chance(before: _Fit, after: _Fit, tried: int) -> float:
    """That noise alone lessens the sum of squares so much, by the best of what was tried."""
    numbers = before.freedom - after.freedom
    if numbers < 1 or after.freedom < 1:
        return 1.0
    ratio = (before.left - after.left) / numbers / after.noise
    return min(1.0, tried * float(stats.f.sf(ratio, numbers, after.freedom)))


def _course(apart: _Apart, options: MovementOptions) -> _Course:
    """The steps or the drift that explain most, where the camera's way explains clearly less.

    A drift looks much like a step of half its way in the middle, which may be too slight to tell.
    """
    stepwise = _stepwise(apart, options)
    told = [one for one in (stepwise, _drifting(apart, options)) if one.told]
    clear = [one for one in told if not _slight(apart, _off(apart, one), options)]
    found = min(clear or told or [stepwise], key=lambda one: one.criterion)
    count = len(apart.photos)
    if found.told and found.criterion > _round_the_limb(apart).criterion - _CLEARLY:
        still = apart.fitted(np.zeros((count, 0)))
        return _Course("still", still, np.zeros(count, np.int64), 1.0, 0)
    return found


def _round_the_limb(apart: _Apart) -> _Course:
    """A motion that goes to and fro once, as the camera goes round."""
    fit = apart.fitted(np.column_stack([np.cos(apart.around), np.sin(apart.around)]))
    return _Course("still", fit, np.zeros(len(apart.photos), np.int64), 1.0, 2 * _MOVE)


def _stepwise(apart: _Apart, options: MovementOptions) -> _Course:
    """Steps between photos, one by one, each where it explains most, while chance does not."""
    count = len(apart.photos)
    borders: list[int] = []
    fit, chance = apart.fitted(np.zeros((count, 0))), 1.0
    while True:
        tried = [
            (apart.fitted(_courses(count, sorted([*borders, at]))), at)
            for at in range(1, count)
            if at not in borders
        ]
        usable = [one for one in tried if one[0].freedom >= _MOVE]
        if not usable:
            break
        best, at = min(usable, key=lambda one: one[0].left)
        by_chance = _chance(fit, best, len(usable))
        if by_chance > options.false_alarm:
            break
        chance = min(chance, by_chance)
        borders.append(at)
        fit = best
    group = np.searchsorted(np.sort(np.array(borders, np.int64)), np.arange(count), side="right")
    return _Course(
        "step" if borders else "still", fit, group.astype(np.int64), chance, _MOVE * len(borders)
    )


def _courses(count: int, borders: list[int]) -> Float64[np.ndarray, "n m"]:
    return (np.arange(count)[:, None] >= np.array(borders)[None]).astype(float)


def _drifting(apart: _Apart, options: MovementOptions) -> _Course:
    """An even movement from the first photo to the last, with a turn or without."""
    count = len(apart.photos)
    still = apart.fitted(np.zeros((count, 0)))
    even = np.array(apart.photos, float)[:, None]
    course = (even - even.mean()) / np.ptp(even)
    fits = apart.fitted(course), apart.without_turns().fitted(course)
    chances = [_chance(still, fit, len(fits)) for fit in fits]
    best = int(np.argmin(chances))
    told = chances[best] <= options.drift_alarm
    return _Course(
        "drift" if told else "still",
        fits[best],
        np.arange(count),
        chances[best],
        (_MOVE, _SHIFT)[best],
    )


def _loose(apart: _Apart, tied: Int64[np.ndarray, " n"], options: MovementOptions) -> int | None:
    """The photo that alone explains what is seen, if one of the bodies holds it by few points.

    Such a photo slips to where wrong matches draw it; nothing is told of it (Baarda 1968 finds
    gross errors so, one at a time).
    """
    still = apart.fitted(np.zeros((len(apart.photos), 0)))
    if still.unlikely >= options.false_alarm:
        return None
    fits = [apart.fitted(own[:, None]) for own in np.eye(len(apart.photos))]
    best = min(range(len(fits)), key=lambda k: fits[k].left)
    photo = apart.photos[best]
    if tied[photo] >= _FIRMLY or fits[best].unlikely < _SPREAD:
        return None
    return photo if _chance(still, fits[best], len(fits)) < options.false_alarm else None


def _sways(apart: _Apart, still: _Fit, options: MovementOptions) -> bool:
    """Whether so much is left without movement, and neither by errors that neighbours share nor by
    one photo."""
    if still.unlikely >= options.false_alarm:
        return False
    even = _round_the_limb(apart).fit
    each = np.eye(len(apart.photos))
    but_one = min((apart.fitted(own[:, None]) for own in each), key=lambda fit: fit.left)
    return max(even.unlikely, but_one.unlikely) < _SPREAD


def _restless(apart: _Apart) -> _Course:
    """Every photo by itself."""
    count = len(apart.photos)
    still = apart.fitted(np.zeros((count, 0)))
    own = _Fit(0.0, 0, apart.rough - np.median(apart.rough, axis=0))
    return _Course("restless", own, np.arange(count), still.unlikely, _MOVE * count)


def _off(apart: _Apart, course: _Course) -> Float64[np.ndarray, "n 6"]:
    """Motions against the largest group; where there are no groups, against the middle photo."""
    if course.kind == "step":
        largest = int(np.bincount(course.group).argmax())
        reference = course.fit.motions[int(np.flatnonzero(course.group == largest)[0])]
    elif course.kind == "drift":
        reference = course.fit.motions[len(apart.photos) // 2]
    else:
        reference = np.zeros(_MOVE)
    return course.fit.motions - reference


def _slight(apart: _Apart, off: Float64[np.ndarray, "n 6"], options: MovementOptions) -> bool:
    """Whether no photo's shift shows on the surface."""
    shift = np.linalg.norm(off[:, 3:], axis=1)
    return bool(shift.max() < options.least_shift * apart.distance)


def _told(apart: _Apart, course: _Course, photos: int, options: MovementOptions) -> BodyMotion:
    """By photo."""
    off = _off(apart, course)
    slight = _slight(apart, off, options)
    told = np.array(apart.photos)
    motions = np.zeros((photos, _MOVE))
    nothing = Movement.unknown(photos)
    group, shift, turn = nothing.group.copy(), nothing.shift.copy(), nothing.turn_deg.copy()
    group[told], shift[told], turn[told] = 0, 0.0, 0.0
    if course.told and not slight:
        motions[told], group[told] = off, course.group
        shift[told] = np.linalg.norm(off[:, 3:], axis=1)
        turn[told] = np.degrees(np.linalg.norm(off[:, :3], axis=1))
    movement = Movement(
        kind="still" if slight else course.kind,
        group=group,
        shift=shift,
        turn_deg=turn,
        chance=course.chance,
    )
    return BodyMotion(movement=movement, middle=apart.middle, motions=motions)
