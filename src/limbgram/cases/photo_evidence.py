"""Photo evidence for a surface point: the image patches that measured it, compared.

In      a finished case with its products, a surface point and the outward normal there.
Out     for each photo that sees the point: its pixel, viewing angle, millimetres per pixel, and the
        difference of the image patch round the point from the mean patch of all photos.
Method  The patch is a square on the tangent plane, sampled in each photo through its lens; each is
        normalised in brightness and contrast, as the measurement does, and compared with the mean
        patch. A ray against the surface tells whether the surface hides the point.
Fails   never: where there are no products or photos any more, a note says so.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64

from limbgram.cases.case_assessment import kept_evidence
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import LimbgramError
from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import axes_across
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import signed_on
from limbgram.findings import Finding, note
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.photo import Photo
from limbgram.report.accuracy.evidence import Evidence

_PATCH_MM = 3.0
"""Half the side of the patch."""
_CELLS = 25
"""Samples along a side of the patch."""
_MOST_PHOTOS = 8
_STEEPEST_COS = 0.17
"""80 degrees: a photo that looks along the surface more closely measures nothing there."""
_LIFT_MM = 0.6
"""Of the ray above the surface, so that it does not start inside it."""
_STEP_MM = 2.0
_MOST_STEPS = 250


@dataclass(frozen=True, kw_only=True)
class PointPhoto:
    """One photo's view of a place."""

    photo: str
    x_px: float
    y_px: float
    """Where the place lies in it, in the sensor's orientation; (0, 0) is a pixel's centre."""
    angle_deg: float
    """Between the line of sight and the surface's normal."""
    mm_per_px: float
    distance_mm: float
    residual: float | None = None
    """Root mean square difference of its patch from the mean of all, in shares of the contrast."""
    patch: tuple[int, ...] = ()
    """Brightness of the patch, 25 x 25 rows of 0 to 255."""


@dataclass(frozen=True)
class PointEvidence:
    """Who saw a place."""

    photos: tuple[PointPhoto, ...]
    note: Finding | None = None
    """Why there are none."""


def point_evidence(case: CaseFolder, place_mm: Vector3, normal: Vector3) -> PointEvidence:
    """The photos that see a surface point, the most frontal view first."""
    try:
        evidence = kept_evidence(case)
    except LimbgramError as error:
        return PointEvidence((), note("photo.point_unknown", reason=error.finding))
    return evidence_at(evidence, place_mm, normal)


def evidence_at(evidence: Evidence, place_mm: Vector3, normal: Vector3) -> PointEvidence:
    """The photos that see a surface point, by products that are loaded already."""
    scene = evidence.metric.scene
    photos = [evidence.photos.photos[idx] for idx in scene.placed]
    seeing = [
        (cosine, photo, view)
        for photo, view in zip(photos, scene.views, strict=True)
        if (cosine := _cosine(view, place_mm, normal)) >= _STEEPEST_COS
        and not _hidden(evidence.mesh, view, place_mm, normal)
    ]
    seeing.sort(key=lambda one: -one[0])
    chosen = seeing[:_MOST_PHOTOS]
    patches = [_patch(photo, view, place_mm, normal) for _, photo, view in chosen]
    return PointEvidence(
        tuple(
            _point_photo(cosine, photo, view, place_mm, patch, patches)
            for (cosine, photo, view), patch in zip(chosen, patches, strict=True)
        ),
        None if chosen else note("photo.point_filled"),
    )


def _cosine(view: View, place_mm: Vector3, normal: Vector3) -> float:
    """Between the line of sight and the normal; -1 where the point lies outside the picture."""
    to_camera = view.centre_in_world - place_mm
    if view.camera_from_world.apply(place_mm[None])[0, 2] <= 0:
        return -1.0
    x, y = view.project(place_mm[None])[0]
    if not (0 <= x < view.camera.width_px - 1 and 0 <= y < view.camera.height_px - 1):
        return -1.0
    return float(to_camera @ normal / np.linalg.norm(to_camera))


def _hidden(mesh: Mesh, view: View, place_mm: Vector3, normal: Vector3) -> bool:
    """Whether the ray to the camera enters the surface; sampled as far as the limb reaches."""
    to_camera = view.centre_in_world - place_mm
    distance_mm = float(np.linalg.norm(to_camera))
    size_mm = float(np.linalg.norm(np.ptp(mesh.vertices_mm, axis=0)))
    steps_mm = np.arange(_STEP_MM, min(distance_mm, size_mm, _STEP_MM * _MOST_STEPS), _STEP_MM)
    ray_mm = place_mm + _LIFT_MM * normal + steps_mm[:, None] * (to_camera / distance_mm)
    return bool((signed_on(mesh).query(ray_mm).signed_mm < -_LIFT_MM).any())


def _patch(
    photo: Photo, view: View, place_mm: Vector3, normal: Vector3
) -> Float64[np.ndarray, "c c"] | None:
    """Brightness on the tangent plane; None where the photo is gone or does not show it all."""
    across, along = axes_across(normal)
    steps = np.linspace(-_PATCH_MM, _PATCH_MM, _CELLS)
    grid = (place_mm + steps[None, :, None] * across + steps[:, None, None] * along).reshape(-1, 3)
    pixels = view.project(grid).astype(np.float32)
    last = np.array([view.camera.width_px - 1, view.camera.height_px - 1])
    if not ((pixels >= 0) & (pixels <= last)).all():  # NaN, where the lens cannot project, is not
        return None
    try:
        luma = load_luma(photo)
    except LimbgramError:
        return None
    sampled = cv2.remap(luma, pixels[:, None, 0], pixels[:, None, 1], cv2.INTER_CUBIC)
    return np.asarray(sampled, np.float64).reshape(_CELLS, _CELLS)


def _point_photo(
    cosine: float,
    photo: Photo,
    view: View,
    place_mm: Vector3,
    patch: Float64[np.ndarray, "c c"] | None,
    patches: list[Float64[np.ndarray, "c c"] | None],
) -> PointPhoto:
    x, y = view.project(place_mm[None])[0]
    distance_mm = float(np.linalg.norm(view.centre_in_world - place_mm))
    normalised = [_normalised(one) for one in patches if one is not None]
    residual = None
    if patch is not None and len(normalised) > 1:
        difference = _normalised(patch) - np.mean(normalised, axis=0)
        residual = float(np.sqrt(np.mean(difference**2)))
    shown = () if patch is None else tuple(np.clip(patch, 0, 255).astype(int).ravel().tolist())
    return PointPhoto(
        photo=photo.name,
        x_px=float(x),
        y_px=float(y),
        angle_deg=float(np.degrees(np.arccos(min(cosine, 1.0)))),
        mm_per_px=distance_mm / float(view.camera.fx),
        distance_mm=distance_mm,
        residual=residual,
        patch=shown,
    )


def _normalised(patch: Float64[np.ndarray, "c c"]) -> Float64[np.ndarray, "c c"]:
    """The patch with mean 0 and standard deviation 1."""
    return (patch - patch.mean()) / max(float(patch.std()), 1e-6)
