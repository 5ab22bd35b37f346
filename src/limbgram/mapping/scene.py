"""The scene: placed photos, sparse points, their observations, and a verdict for every photo."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int32

from limbgram.geometry.arrays import Points2, Points3
from limbgram.geometry.camera import Camera, View
from limbgram.geometry.rigid import Rigid
from limbgram.geometry.similarity import Similarity


@dataclass(frozen=True, kw_only=True)
class PhotoVerdict:
    """What became of one photo, in words a clinician can act on."""

    name: str
    placed: bool
    points: int
    """Scene points seen in it."""
    rms_px: float
    reason: str = ""
    """Why it was not placed and what to do; empty for a placed photo."""


@dataclass(frozen=True)
class Observations:
    """Measured image points: photo photo_idx[k] sees point point_idx[k] at xy_px[k].

    Pixels are as measured, with lens distortion in them.
    """

    photo_idx: Int32[np.ndarray, " m"]
    point_idx: Int32[np.ndarray, " m"]
    xy_px: Points2


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

    @property
    def placed(self) -> tuple[int, ...]:
        """Indices of the placed photos."""
        return tuple(k for k, pose in enumerate(self.camera_from_world) if pose is not None)

    def view(self, photo_idx: int) -> View:
        pose = self.camera_from_world[photo_idx]
        if pose is None:
            raise KeyError(f"{self.names[photo_idx]} was not placed")
        return View(self.names[photo_idx], self.cameras[self.camera_idx[photo_idx]], pose)

    @property
    def views(self) -> tuple[View, ...]:
        """Views of the placed photos, in the order of `placed`."""
        return tuple(self.view(k) for k in self.placed)

    def residuals_px(self) -> Float64[np.ndarray, "m 2"]:
        """Measured minus projected, by observation."""
        residuals = np.full(self.observations.xy_px.shape, np.nan)
        points = self.points_in_world[self.observations.point_idx]
        for photo in self.placed:
            rows = self.observations.photo_idx == photo
            residuals[rows] = self.observations.xy_px[rows] - self.view(photo).project(points[rows])
        return residuals

    def moved(self, new_from_world: Similarity) -> "Scene":
        """The same scene in another world frame."""
        return Scene(
            names=self.names,
            cameras=self.cameras,
            camera_idx=self.camera_idx,
            camera_from_world=tuple(
                None if pose is None else new_from_world.move_camera(pose)
                for pose in self.camera_from_world
            ),
            points_in_world=new_from_world.apply(self.points_in_world),
            observations=self.observations,
            verdicts=self.verdicts,
        )
