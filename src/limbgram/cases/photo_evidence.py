"""Photo evidence for a surface point: the image patches that measured it, compared.

In      a finished case with its products, a place and the outward normal there.
Out     for each photo that sees the place: where it lies in it, how squarely it looks, how many
        millimetres a pixel is, and how far the little picture round the place, laid out on the
        surface, is from the mean of all photos'.
Method  The patch is a square on the tangent plane, sampled in each photo through its lens; each is
        freed of its own brightness and contrast, as the measurement does, and compared with the
        mean. Whether something stands in between is asked of the surface itself, by a ray.
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
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import signed_on
from limbgram.reconstruction.photos.decoding import load_luma
from limbgram.reconstruction.photos.photo import Photo
from limbgram.report.accuracy.evidence import Evidence

_PATCH_MM = 3.0
"""Half a side of the patch."""
_CELLS = 25
"""Of the patch, along a side."""
_MOST_PHOTOS = 8
_STEEPEST_COS = 0.17
"""80 degrees: a photo that looks along the surface more closely measures nothing there."""
_LIFT_MM = 0.6
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
    note: str = ""
    """Why there are none."""


def point_evidence(case: CaseFolder, place_mm: Vector3, normal: Vector3) -> PointEvidence:
    """The photos that see a place, the squarest first."""
    try:
        kept = kept_evidence(case)
    except LimbgramError as error:
        return PointEvidence((), f"The photos that measured it are not known here: {error}")
    return look(kept, place_mm, normal)


def look(kept: Evidence, place_mm: Vector3, normal: Vector3) -> PointEvidence:
    """The same with the products at hand."""
    scene = kept.metric.scene
    photos = [kept.photos.photos[idx] for idx in scene.placed]
    seeing = [
        (cosine, photo, view)
        for photo, view in zip(photos, scene.views, strict=True)
        if (cosine := _cosine(view, place_mm, normal)) >= _STEEPEST_COS
        and not _hidden(kept.mesh, view, place_mm, normal)
    ]
    seeing.sort(key=lambda one: -one[0])
    chosen = seeing[:_MOST_PHOTOS]
    patches = [_patch(photo, view, place_mm, normal) for _, photo, view in chosen]
    return PointEvidence(
        tuple(
            _witness(cosine, photo, view, place_mm, patch, patches)
            for (cosine, photo, view), patch in zip(chosen, patches, strict=True)
        ),
        "" if chosen else "No photo sees this place: it was filled in.",
    )


def _cosine(view: View, place_mm: Vector3, normal: Vector3) -> float:
    """Between the line of sight and the normal; -1 where the place lies out of the picture."""
    towards = view.centre_in_world - place_mm
    if view.camera_from_world.apply(place_mm[None])[0, 2] <= 0:
        return -1.0
    x, y = view.project(place_mm[None])[0]
    if not (0 <= x < view.camera.width_px - 1 and 0 <= y < view.camera.height_px - 1):
        return -1.0
    return float(towards @ normal / np.linalg.norm(towards))


def _hidden(mesh: Mesh, view: View, place_mm: Vector3, normal: Vector3) -> bool:
    """Whether the way to the camera enters the surface; in steps, as far as the limb reaches."""
    towards = view.centre_in_world - place_mm
    reach_mm = float(np.linalg.norm(towards))
    size_mm = float(np.linalg.norm(np.ptp(mesh.vertices_mm, axis=0)))
    steps = np.arange(_STEP_MM, min(reach_mm, size_mm, _STEP_MM * _MOST_STEPS), _STEP_MM)
    way = place_mm + _LIFT_MM * normal + steps[:, None] * (towards / reach_mm)
    return bool((signed_on(mesh).signed(way).signed_mm < -_LIFT_MM).any())


def _patch(
    photo: Photo, view: View, place_mm: Vector3, normal: Vector3
) -> Float64[np.ndarray, "c c"] | None:
    """Brightness on the tangent plane; None where the photo is gone or the patch leaves it."""
    try:
        luma = load_luma(photo)
    except LimbgramError:
        return None
    across = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    steps = np.linspace(-_PATCH_MM, _PATCH_MM, _CELLS)
    grid = (place_mm + steps[None, :, None] * across + steps[:, None, None] * along).reshape(-1, 3)
    pixels = view.project(grid).astype(np.float32)
    sampled = cv2.remap(luma, pixels[:, None, 0], pixels[:, None, 1], cv2.INTER_CUBIC)
    return np.asarray(sampled, np.float64).reshape(_CELLS, _CELLS)


def _witness(
    cosine: float,
    photo: Photo,
    view: View,
    place_mm: Vector3,
    patch: Float64[np.ndarray, "c c"] | None,
    patches: list[Float64[np.ndarray, "c c"] | None],
) -> PointPhoto:
    x, y = view.project(place_mm[None])[0]
    distance = float(np.linalg.norm(view.centre_in_world - place_mm))
    plain = [_plain(one) for one in patches if one is not None]
    residual = None
    if patch is not None and len(plain) > 1:
        residual = float(np.sqrt(np.mean((_plain(patch) - np.mean(plain, axis=0)) ** 2)))
    shown = () if patch is None else tuple(np.clip(patch, 0, 255).astype(int).ravel().tolist())
    return PointPhoto(
        photo=photo.name,
        x_px=float(x),
        y_px=float(y),
        angle_deg=float(np.degrees(np.arccos(min(cosine, 1.0)))),
        mm_per_px=distance / float(view.camera.fx),
        distance_mm=distance,
        residual=residual,
        patch=shown,
    )


def _plain(patch: Float64[np.ndarray, "c c"]) -> Float64[np.ndarray, "c c"]:
    """Without its own brightness and contrast."""
    return (patch - patch.mean()) / max(float(patch.std()), 1e-6)
