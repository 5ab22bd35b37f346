"""The scene: placed photos, sparse points, their observations, and a verdict for every photo."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from limbgram.core.geometry.arrays import Points2, Points3
from limbgram.core.geometry.frames import Rigid, Similarity, cross_matrix, fit_similarity
from limbgram.core.geometry.lens import POSE_SIZE, Camera, View
from limbgram.core.notebook import brief
from limbgram.findings import Finding


@dataclass(frozen=True, kw_only=True)
class PhotoVerdict:
    """What became of one photo, with what a clinician can do about it."""

    name: str
    placed: bool
    points: int
    """Scene points seen in it."""
    rms_px: float
    reason: Finding | None = None
    """Why it was not placed; None of a placed photo."""
    remark: Finding | None = None
    """That it is used though its focal length is not that of the others."""


@dataclass(frozen=True)
class Observations:
    """Measured image points: photo photo_idx[k] sees point point_idx[k] at xy_px[k].

    Pixels are as measured, with lens distortion in them.
    """

    photo_idx: Int32[np.ndarray, " m"]
    point_idx: Int32[np.ndarray, " m"]
    xy_px: Points2
    own_sigma_px: Float64[np.ndarray, " m"] | None = None
    """Standard deviation of a coordinate, for corners of coded marks; zero for other keypoints.
    None where there are no marks."""

    def some(self, keep: Bool[np.ndarray, " m"]) -> "Observations":
        """A subset, in the same order."""
        own = self.own_sigma_px
        return Observations(
            self.photo_idx[keep],
            self.point_idx[keep],
            self.xy_px[keep],
            None if own is None else own[keep],
        )


@dataclass(frozen=True, kw_only=True)
class Ring:
    """How the photos are distributed round the object, in the best-fit plane of their centres."""

    largest_gap_deg: float
    """Widest angle without a photo, seen from the object."""
    weakest_bridge: int
    """Fewest scene points that join the photos on both sides of any gap."""
    closed: bool
    """Whether every gap, the last to first included, is narrow and bridged."""


Rule = Literal[
    "chance",
    "lens",
    "size",
    "one photo",
    "lenses of photos",
    "model",
    "few points",
    "board",
    "motion",
]
"""Tests that a term has to pass before it counts as a fact.

chance: it is significant; lens: it explains more than a lens that changes along the same course;
size: its effect surely matters; one photo: it is significant whichever photo is left out; lenses of
photos: it is significant with four times the variance of lens deviations; model: it is significant
beside what a lens does beyond its model where no board calibrated it; few points: it is significant
without the photos that few points determine; board: something beside the board shows that it was
not pushed; motion: of a lens, it explains more than a limb that lies elsewhere in every photo.
"""
Bodies = Literal["limb and room", "halves", "limb and board", "lenses", "board"]
"""Which two bodies are compared; or lenses: deviations of photos; or board: its own shape."""
Deviation = Literal["principal point", "focal length", "rolling shutter"]


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """One term of the search, with its evidence."""

    bodies: Bodies
    kind: Literal["step", "drift", "photo", "sway", "rest", "camera file", "bend"] | Deviation
    """photo: one alone lies elsewhere; sway: each does; rest: what no term explains; camera file:
    all photos of a camera have another focal length than it; bend: the board is no plane; a
    deviation: each photo has one."""
    photos: tuple[int, ...]
    """Photos that show the second body elsewhere than most, or have another lens."""
    numbers: int
    """Number of its parameters."""
    score: float
    """Twice the log-likelihood ratio of the term, less a penalty for its parameters and for the
    candidates of its kind; positive where it explains more than it costs (BIC)."""
    chance: float
    """p-value: chance that photos without it show as much, all candidates of its kind counted."""
    effect: float
    """Largest motion of a point of the first body, in the scene's unit; of a board, how far the
    ends of its print lie off the plane through its middle; of a focal length, by which share of
    itself it differs."""
    low: float
    high: float
    """Its interval of 95 %."""
    variance_before: float
    variance_after: float
    """Variance factors of the residuals without and with the term (reduced chi-squared)."""
    failed: tuple[Rule, ...] = ()
    floor: float = 0.0
    """Smallest effect that matters, in the unit of `effect`."""

    @property
    def is_share(self) -> bool:
        """Whether the effect is a share of the focal length."""
        return self.kind in ("focal length", "camera file")

    @property
    def is_undecided(self) -> bool:
        """Whether it is no fact, but may be large enough to matter."""
        return bool(self.failed) and self.high >= self.floor

    @property
    def is_fact(self) -> bool:
        """Whether it passes all rules."""
        return not self.failed

    def scaled(self, factor: float) -> "Explanation":
        """The same with lengths in another unit."""
        if self.is_share:
            return self
        return replace(
            self,
            effect=factor * self.effect,
            low=factor * self.low,
            high=factor * self.high,
            floor=factor * self.floor,
        )


@dataclass(frozen=True, kw_only=True)
class Movement:
    """How one body moved against another while the photos were taken, by photo."""

    kind: Literal["still", "step", "drift", "restless", "unclear", "unknown"]
    """step: photos fall into groups within which all keeps still. drift: it moved evenly.
    restless: every photo shows it elsewhere. unclear: it moved, and photos do not tell which of
    these it was. unknown: nor whether it moved."""
    group: Int64[np.ndarray, " n"]
    """Number of a group of photos between which nothing moved; -1 where that is not known."""
    shift: Float64[np.ndarray, " n"]
    """From the largest group, or from the middle where there are none, in scene units; NaN where
    unknown."""
    turn_deg: Float64[np.ndarray, " n"]
    chance: float = 1.0
    """p-value: chance that photos without movement show as much."""
    reason: Finding | None = None
    """Why it is not known."""
    alone: bool = False
    """Whether the photos were placed by the points of what they aim at alone."""
    beside: bool = False
    """Whether other things round it moved, while it and the scale board kept still."""
    pushed: bool = False
    """Whether the scale board moved, while it and other things round it kept still."""
    largest: float = float("nan")
    """Largest shift between any two photos, in scene units; NaN where it is not known."""
    explanations: tuple[Explanation, ...] = ()
    """What may have happened, the most likely first; empty where photos without movement look
    alike."""
    instead_of_lenses: tuple[Deviation, ...] = ()
    """Deviations of single photos' lenses that a motion drawn anew for each photo explains as
    well."""

    @classmethod
    def unknown(cls, photos: int, reason: Finding | None = None, chance: float = 1.0) -> "Movement":
        nan = np.full(photos, np.nan)
        return cls(
            kind="unknown",
            group=np.full(photos, -1, np.int64),
            shift=nan,
            turn_deg=nan.copy(),
            chance=chance,
            reason=reason,
        )

    def scaled(self, factor: float) -> "Movement":
        """The same with lengths in another unit."""
        return replace(
            self,
            shift=factor * self.shift,
            largest=factor * self.largest,
            explanations=tuple(one.scaled(factor) for one in self.explanations),
        )

    @property
    def moved(self) -> bool:
        return self.kind in ("step", "drift", "restless", "unclear")

    @property
    def undecided(self) -> tuple[Explanation, ...]:
        """What may have happened, would matter, and is not told as a fact."""
        return tuple(one for one in self.explanations if one.is_undecided)

    @property
    def misfit(self) -> bool:
        """Whether something does not fit beyond chance, and what it is cannot be known."""
        return self.kind == "unknown" and self.chance < 1.0


@dataclass(frozen=True, kw_only=True)
class JoinedByMarks:
    """What coded marks did for photos that keypoints alone did not join all round."""

    photos_by_paint: int
    """Number of photos placed by keypoints alone."""
    ids: tuple[int, ...]
    """Marks that join the photos."""
    left_out: tuple[int, ...]
    """Marks that do not fit."""
    reasons: tuple[Finding, ...]
    """Why they do not, in the same order."""


@dataclass(frozen=True, kw_only=True)
class OwnLenses:
    """Deviation of each photo's lens from that of its camera (`lens_deviations`)."""

    deviations: tuple[Deviation, ...]
    """The kinds that the residuals support, the most significant first."""
    values: Float64[np.ndarray, "n q"]
    """By photo, the parameters of these kinds."""
    spread: Float64[np.ndarray, " q"]
    """Standard deviation of each parameter from photo to photo."""
    shifts: Float64[np.ndarray, "n lens"]
    """Lens of the photo less that of its camera (PARAMETERS)."""
    chances: tuple[float, ...]
    """By kind, its p-value: chance that photos of one lens show as much."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Placed photos and points in a world frame of arbitrary origin, orientation and SCALE."""

    names: tuple[str, ...]
    """All photos of the capture, placed or not."""
    cameras: tuple[Camera, ...]
    """By camera group, refined where the options asked for it."""
    camera_idx: tuple[int, ...]
    """Camera group of each photo."""
    camera_from_world: tuple[Rigid | None, ...]
    """By photo; None where it could not be placed."""
    points_in_world: Points3
    observations: Observations
    verdicts: tuple[PhotoVerdict, ...]
    sigma_px: float = float("nan")
    """Standard deviation of a measured coordinate, robustly from the residuals."""
    lens_covariance: Float64[np.ndarray, "c lens lens"] | None = None
    """Of every camera's lens after the adjustment (PARAMETERS); zero where held."""
    camera_covariance: Float64[np.ndarray, "u u"] | None = None
    """Of all that was adjusted beside the points: six numbers a placed photo (turn in its own
    frame, rad; shift of its translation, scene units; see geometry.projection), then ten a lens:
    a camera's, or a placed photo's where photos have lenses of their own (`lens_idx`).
    The seven directions of the world's own frame carry nothing."""
    ring: Ring | None = None
    full_size: Finding | None = None
    """What keypoints of reduced photos left open, so that those of the full size were needed."""
    movement: Movement | None = None
    """Of what the photos aim at against its surroundings. None where nobody looked."""
    bending: Movement | None = None
    """Of one half of its length against the other."""
    marks: JoinedByMarks | None = None
    """None where paint joins the photos, or marks do not help."""
    own: OwnLenses | None = None
    """Lens deviations of single photos. None where one lens explains all photos of a camera."""
    lens_explanations: tuple[Explanation, ...] = ()
    """What lenses of single photos, camera files and a bent board explain, likeliest first."""

    __repr__ = brief

    @property
    def placed(self) -> tuple[int, ...]:
        """Indices of the placed photos."""
        return tuple(k for k, pose in enumerate(self.camera_from_world) if pose is not None)

    def view(self, photo_idx: int) -> View:
        """The view of a placed photo."""
        pose = self.camera_from_world[photo_idx]
        if pose is None:
            raise KeyError(f"{self.names[photo_idx]} was not placed")
        return View(self.names[photo_idx], self.camera(photo_idx), pose)

    def camera(self, photo_idx: int) -> Camera:
        """The lens of one photo: its camera's, with the photo's own deviation."""
        camera = self.cameras[self.camera_idx[photo_idx]]
        if self.own is None:
            return camera
        return camera.with_parameters(camera.packed + self.own.shifts[photo_idx])

    @property
    def lens_idx(self) -> tuple[int, ...]:
        """By placed photo, the index of its lens in `camera_covariance`."""
        if self.own is not None:
            return tuple(range(len(self.placed)))
        return tuple(self.camera_idx[k] for k in self.placed)

    @property
    def lenses(self) -> int:
        """How many lenses `camera_covariance` holds."""
        return len(self.cameras) if self.own is None else len(self.placed)

    def centres_in_world(self, photos: Iterable[int]) -> Points3:
        """Camera centres of these placed photos."""
        return np.array([view.centre_in_world for view in self.views_of(photos)])

    def views_of(self, photos: Iterable[int]) -> tuple[View, ...]:
        """Views of these placed photos."""
        return tuple(self.view(k) for k in photos)

    @property
    def views(self) -> tuple[View, ...]:
        """Views of the placed photos, in the order of `placed`."""
        return self.views_of(self.placed)

    def residuals_px(self) -> Float64[np.ndarray, "m 2"]:
        """Measured minus projected, by observation."""
        residuals = np.full(self.observations.xy_px.shape, np.nan)
        points = self.points_in_world[self.observations.point_idx]
        by_photo = np.argsort(self.observations.photo_idx, kind="stable")
        ends = np.cumsum(np.bincount(self.observations.photo_idx, minlength=len(self.names)))
        for photo in self.placed:
            rows = by_photo[ends[photo - 1] if photo else 0 : ends[photo]]
            residuals[rows] = self.observations.xy_px[rows] - self.view(photo).project(points[rows])
        return residuals

    def moved(self, new_from_world: Similarity) -> "Scene":
        """The same scene in another world frame."""
        return replace(
            self,
            camera_from_world=tuple(
                None if pose is None else new_from_world.move_camera(pose)
                for pose in self.camera_from_world
            ),
            points_in_world=new_from_world.apply(self.points_in_world),
            camera_covariance=self._moved_covariance(new_from_world),
            movement=self.movement and self.movement.scaled(new_from_world.scale),
            bending=self.bending and self.bending.scaled(new_from_world.scale),
            lens_explanations=tuple(
                one.scaled(new_from_world.scale) for one in self.lens_explanations
            ),
        )

    def _moved_covariance(self, new_from_world: Similarity) -> Float64[np.ndarray, "u u"] | None:
        """The covariance for the same photos in another world frame.

        A photo's turn w pivots on the world's origin. With another origin the same move has
        another shift: d_new = scale d - w x (R_new translation).
        """
        if self.camera_covariance is None:
            return None
        step = np.eye(len(self.camera_covariance))
        for k, view in enumerate(self.views):
            pose = new_from_world.move_camera(view.camera_from_world)
            turns = slice(POSE_SIZE * k, POSE_SIZE * k + 3)
            shifts = slice(POSE_SIZE * k + 3, POSE_SIZE * (k + 1))
            step[shifts, shifts] *= new_from_world.scale
            step[shifts, turns] = cross_matrix(pose.rotation @ new_from_world.translation)
        return step @ self.camera_covariance @ step.T


def other_from_one(one: Scene, other: Scene, photos: Sequence[int]) -> Similarity:
    """By the centres of photos that both scenes place."""
    return fit_similarity(one.centres_in_world(photos), other.centres_in_world(photos))
