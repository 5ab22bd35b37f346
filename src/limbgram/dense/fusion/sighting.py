"""Sighting: which photos agree on a point of the cloud, and what colour it has in them."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from limbgram.dense.depth import DepthMap
from limbgram.geometry.camera import View
from limbgram.photos.decoding import in_flight_mb, load_colour
from limbgram.photos.photo import PhotoSet
from limbgram.run import in_parallel
from limbgram.scale.metric import MetricScene

_BEHIND = 4.0
"""Something this many tolerances behind a point is another surface."""


@dataclass(frozen=True, kw_only=True)
class Sightings:
    """By point: photos whose depth map has it, and its mean colour in them."""

    views: UInt8[np.ndarray, " n"]
    through: UInt8[np.ndarray, " n"]
    """Photos that saw something behind the point: it would have hidden that."""
    colours: UInt8[np.ndarray, "n 3"]


def sight(
    photos: PhotoSet,
    metric: MetricScene,
    depth_maps: Sequence[DepthMap],
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> Sightings:
    """Look for each point in each depth map; where it is, the photo's colour counts by cosine^2."""

    def one(depth_map: DepthMap) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        seen, cosine, through = _seen(depth_map, points_mm, normals, agree_mm)
        view = metric.scene.view(depth_map.photo_idx)
        colours = _colours(photos, depth_map.photo_idx, view, points_mm[seen])
        return seen, cosine**2, colours, through

    each_mb = in_flight_mb(photos.photos, colour=True)
    views, through = np.zeros((2, len(points_mm)), np.uint8)
    weights = np.full(len(points_mm), 1e-9)
    sums = np.zeros((len(points_mm), 3))
    for seen, weight, colours, behind in in_parallel(one, depth_maps, each_mb=each_mb):
        views[seen] += 1
        through[behind] += 1
        weights[seen] += weight
        sums[seen] += weight[:, None] * colours
    colours = np.round(sums / weights[:, None]).astype(np.uint8)
    return Sightings(views=views, through=through, colours=colours)


def _seen(
    depth_map: DepthMap,
    points_mm: Float32[np.ndarray, "n 3"],
    normals: Float32[np.ndarray, "n 3"],
    agree_mm: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points that the map has, the cosines of their incidence, and points it saw behind of."""
    pose, camera = depth_map.camera_from_world, depth_map.camera
    in_camera = pose.apply(points_mm.astype(float))
    rays = in_camera / np.linalg.norm(in_camera, axis=1, keepdims=True)
    cosine = -(rays * (normals @ pose.rotation.T)).sum(1)
    xy = camera.project(in_camera) - (depth_map.x0, depth_map.y0)
    height, width = depth_map.depth_mm.shape
    within = np.flatnonzero(np.all((xy > -0.5) & (xy < (width - 0.5, height - 0.5)), axis=1))
    column, row = np.round(xy[within]).astype(int).T
    behind_mm = depth_map.depth_mm[row, column] - in_camera[within, 2]
    tolerance_mm = agree_mm + in_camera[within, 2] / camera.fx
    facing = cosine[within]
    seen = within[(facing > 0.1) & (np.abs(behind_mm) * facing < tolerance_mm)]
    return seen, cosine[seen], within[behind_mm > _BEHIND * tolerance_mm]


def _colours(
    photos: PhotoSet, photo_idx: int, view: View, points_mm: np.ndarray
) -> Float32[np.ndarray, "n 3"]:
    if not len(points_mm):
        return np.zeros((0, 3), np.float32)
    xy = view.project(points_mm.astype(float)).astype(np.float32)
    colour = load_colour(photos.photos[photo_idx])
    rows = max(1, -(-len(xy) // 1024))
    x, y = np.resize(xy, (rows * 1024, 2)).T.copy().reshape(2, rows, 1024)
    sampled = cv2.remap(colour, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return sampled.reshape(-1, 3)[: len(xy)].astype(np.float32)
