"""Pixels: where on the surface the pixels of a photo lie, and the strong colours among them.

Method  a ray through every strongly coloured pixel, by the exact lens; the first triangle it
        meets is what the pixel shows, so that nothing hidden counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float32, Float64, Int32, UInt8

from limbgram.core.geometry.arrays import ColourImage, Points3, Vector3
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.photos.decoding import LINEAR_OF_SRGB, load_colour
from limbgram.reconstruction.photos.photo import Photo

_MARGIN_PX = 4
LEAST_COSINE = 0.5
"""Pixels that meet the surface more obliquely than 60 degrees are left out."""
_OUTLINE_VERTICES = 20_000
"""So many of the mesh's vertices are enough to find it in a photo."""


@dataclass(frozen=True)
class ColouredPixels:
    """Strongly coloured pixels of one photo that show the surface."""

    shape: tuple[int, int]
    at: Int32[np.ndarray, "n 2"]
    """Row and column in the reduced crop of that shape."""
    hue_rad: Float32[np.ndarray, " n"]
    saturation: Float32[np.ndarray, " n"]
    colours: UInt8[np.ndarray, "n 3"]
    points_mm: Float32[np.ndarray, "n 3"]
    areas_mm2: Float32[np.ndarray, " n"]
    """Of the surface that each pixel covers."""


class SurfaceRays:
    """Rays against one mesh; the place is exact, whatever the ray caster's precision."""

    def __init__(self, mesh: Mesh) -> None:
        self._corners = mesh.vertices_mm[mesh.faces]
        weighted = mesh.face_normals()
        length = np.linalg.norm(weighted, axis=1, keepdims=True)
        self._normals = weighted / np.maximum(length, 1e-30)
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, self._corners.astype(np.float32))

    def first(
        self, origin_mm: Vector3, rays: Points3
    ) -> tuple[Bool[np.ndarray, " n"], Points3, Float64[np.ndarray, " n"]]:
        """Whether each unit ray meets the surface's outside, where, and the cosine there."""
        origins = np.broadcast_to(origin_mm, rays.shape).astype(np.float32)
        faces = np.asarray(self._scene.run(origins, rays.astype(np.float32), query="INTERSECT"))
        normals = self._normals[faces]
        cosines = np.where(faces >= 0, -(normals * rays).sum(1), 0.0)
        hit = cosines > 0
        reach = ((self._corners[faces, 0] - origin_mm) * normals).sum(1)
        along = np.where(hit, reach / np.where(hit, -cosines, 1.0), 0.0)
        return hit, origin_mm + along[:, None] * rays, cosines

    def normal_at(self, face: int) -> Vector3:
        """Unit normal of a face."""
        return self._normals[face]

    def sees(self, view: View, place_mm: Vector3, least_cosine: float, slack_mm: float) -> bool:
        """Whether a photo shows a place squarely and nothing stands before it."""
        if not view.camera.contains(view.project(place_mm[None]), _MARGIN_PX)[0]:
            return False
        ray = place_mm - view.centre_in_world
        distance = float(np.linalg.norm(ray))
        hit, place, cosine = self.first(view.centre_in_world, (ray / distance)[None])
        near = np.linalg.norm(place[0] - place_mm) < slack_mm
        return bool(hit[0] and near and cosine[0] >= least_cosine)


def coloured_pixels(
    photo: Photo,
    view: View,
    caster: SurfaceRays,
    outline_mm: Points3,
    pixel_mm: float,
    least_saturation: float,
) -> ColouredPixels:
    """The strongly coloured pixels of a photo on the surface.

    Args:
        outline_mm: Points whose projections enclose the surface's.
        pixel_mm: The photo is reduced until a pixel is about this large on the surface.
    """
    crop, left, top, factor = _reduced_crop(load_colour(photo), view, outline_mm, pixel_mm)
    hue, saturation = hue_and_saturation(crop)
    at = np.argwhere(saturation >= least_saturation).astype(np.int32)
    xy = (at[:, ::-1] + 0.5) / factor - 0.5 + np.array([left, top])
    rays = view.camera.rays(xy) @ view.camera_from_world.rotation
    hit, points, cosines = caster.first(view.centre_in_world, rays)
    kept = np.flatnonzero(hit & (cosines > LEAST_COSINE))
    at, points = at[kept], points[kept]
    depths = view.camera_from_world.apply(points)[:, 2]
    across = depths / (factor * view.camera.fx) * depths / (factor * view.camera.fy)
    return ColouredPixels(
        shape=(crop.shape[0], crop.shape[1]),
        at=at,
        hue_rad=hue[at[:, 0], at[:, 1]],
        saturation=saturation[at[:, 0], at[:, 1]],
        colours=crop[at[:, 0], at[:, 1]],
        points_mm=points.astype(np.float32),
        areas_mm2=(across / cosines[kept]).astype(np.float32),
    )


def hue_and_saturation(
    pixels: UInt8[np.ndarray, "*shape 3"],
) -> tuple[Float32[np.ndarray, "*shape"], Float32[np.ndarray, "*shape"]]:
    """Hue, and share of the light that is not white, in linear light: shade changes neither."""
    red, green, blue = np.moveaxis(LINEAR_OF_SRGB.astype(np.float32)[pixels], -1, 0)
    hue = np.arctan2(np.float32(np.sqrt(3)) * (green - blue), 2 * red - green - blue)
    brightest = np.maximum(np.maximum(red, green), blue)
    least = np.minimum(np.minimum(red, green), blue)
    dark = brightest < np.float32(0.02)
    return hue, np.where(dark, 0, (brightest - least) / np.maximum(brightest, 1e-6))


def _reduced_crop(
    pixels: ColourImage, view: View, outline_mm: Points3, pixel_mm: float
) -> tuple[UInt8[np.ndarray, "rows columns 3"], int, int, float]:
    """The part of a photo that holds the surface, reduced; its corner, and by how much."""
    xy = view.project(outline_mm)
    xy = xy[view.camera.contains(xy)]
    if not len(xy):
        return np.zeros((1, 1, 3), np.uint8), 0, 0, 1.0
    left, top = np.maximum(np.floor(xy.min(0)).astype(int) - _MARGIN_PX, 0)
    right, bottom = np.ceil(xy.max(0)).astype(int) + _MARGIN_PX
    depth = float(np.median(view.camera_from_world.apply(outline_mm)[:, 2]))
    halvings = max(0, int(np.floor(np.log2(pixel_mm * view.camera.fx / depth))))
    crop = pixels[top:bottom, left:right]
    step = 2**halvings
    size = max(1, crop.shape[1] // step), max(1, crop.shape[0] // step)
    crop = crop[: size[1] * step, : size[0] * step]
    if halvings:
        crop = cv2.resize(crop, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    return np.ascontiguousarray(crop), int(left), int(top), 0.5**halvings


def coloured_pixels_by_photo(
    photos: Sequence[Photo],
    views: Sequence[View],
    mesh: Mesh,
    caster: SurfaceRays,
    pixel_mm: float,
    least_saturation: float,
) -> list[ColouredPixels]:
    """The strongly coloured pixels of each photo."""
    outline = mesh.vertices_mm[:: max(1, len(mesh) // _OUTLINE_VERTICES)]
    return [
        coloured_pixels(photo, view, caster, outline, pixel_mm, least_saturation)
        for photo, view in zip(photos, views, strict=True)
    ]
