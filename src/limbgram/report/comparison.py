"""Comparison: a reconstructed surface against its exact truth.

In      a Mesh, the truth's mesh and which of it the photos show, and camera centres of both.
Out     a Comparison, mm and fractions.
Method  rigid alignment alone (camera centres, then point to plane), so that a wrong scale stays
        in the figures; girth and volume between the same two heights of both.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64
from scipy.spatial import ConvexHull

from limbgram.geometry.arrays import Faces, Points3
from limbgram.geometry.rigid import Rigid
from limbgram.geometry.similarity import fit_similarity
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

_SAMPLES = 40_000
_ROUNDS = 12
_FAR_MM = 3.0
"""Samples farther away take no part in the alignment."""
_SECTIONS = 40
_GIRTHS = (0.2, 0.4, 0.6, 0.8)
"""Heights at which girths are compared, as shares of the seen height."""
_NEAR_MM = 0.25
_FEWEST_SEGMENTS = 8


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The true surface."""

    vertices_mm: Points3
    faces: Faces
    seen: Bool[np.ndarray, " n"]
    """True at vertices that three photos or more show."""
    centres_mm: Points3
    """Where the photos were taken."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How far a surface is from the truth."""

    rms_mm: float
    p95_mm: float
    mean_mm: float
    """Signed; positive: the surface lies outside the truth."""
    scale_error: float
    """Fraction by which the surface is too large."""
    covered: float
    """Share of the seen truth with the surface within 0.25 mm."""
    girth_errors_mm: tuple[float, ...]
    volume_error: float
    """Fraction, between the lowest and the highest compared height."""
    camera_rms_mm: float
    """Of the camera centres after the alignment."""


def compare(mesh: Mesh, centres_mm: Points3, truth: Truth) -> Comparison:
    """Compare a surface with the truth; `centres_mm` are its cameras in the truth's order."""
    start = fit_similarity(centres_mm, truth.centres_mm, with_scale=False)
    tree = TriangleTree.of(truth.vertices_mm, truth.faces)
    truth_from_world = Rigid(start.rotation, start.translation)
    samples = _measured_samples(mesh)
    scale = 0.0
    for _ in range(_ROUNDS):
        step, scale = _towards(truth_from_world.apply(samples), tree, truth)
        truth_from_world = step @ truth_from_world
    placed = mesh.with_vertices(truth_from_world.apply(mesh.vertices_mm))
    signed_mm = _signed_mm(truth_from_world.apply(samples), tree, truth)
    back = TriangleTree.of(placed.vertices_mm, placed.faces)
    off_mm = back.closest(truth.vertices_mm[truth.seen]).distances_mm
    girths_mm, volume_error = _sections(placed, truth)
    cameras_mm = np.linalg.norm(truth_from_world.apply(centres_mm) - truth.centres_mm, axis=1)
    return Comparison(
        rms_mm=float(np.sqrt(np.mean(signed_mm**2))),
        p95_mm=float(np.quantile(np.abs(signed_mm), 0.95)),
        mean_mm=float(signed_mm.mean()),
        scale_error=scale,
        covered=float(np.mean(off_mm < _NEAR_MM)),
        girth_errors_mm=tuple(float(error) for error in girths_mm),
        volume_error=volume_error,
        camera_rms_mm=float(np.sqrt(np.mean(cameras_mm**2))),
    )


def girth_mm(segments: Float64[np.ndarray, "n 2 2"]) -> float:
    """Circumference of a section as a taut tape reads it: of its convex hull; NaN without any."""
    if len(segments) < _FEWEST_SEGMENTS:
        return float("nan")
    return float(ConvexHull(segments.reshape(-1, 2)).area)


def area_mm2(segments: Float64[np.ndarray, "n 2 2"]) -> float:
    """Area inside closed outlines, counter-clockwise ones positive (Green's theorem)."""
    (ax, ay), (bx, by) = segments[:, 0].T, segments[:, 1].T
    return float((ax * by - bx * ay).sum() / 2)


def section(mesh: Mesh, height_mm: float) -> Float64[np.ndarray, "n 2 2"]:
    """The mesh cut at a height: segments with the inside to their left, seen from above."""
    heights = mesh.vertices_mm[:, 2][mesh.faces] - height_mm
    above = heights > 0
    cut = above.any(1) & ~above.all(1)
    corners, heights, above = mesh.vertices_mm[mesh.faces[cut]], heights[cut], above[cut]
    lone = np.argmax(above == (above.sum(1) == 1)[:, None], axis=1)
    rows = np.arange(len(lone))
    ends: list[np.ndarray] = []
    for side in (1, 2):
        other = (lone + side) % 3
        share = heights[rows, lone] / (heights[rows, lone] - heights[rows, other])
        from_mm, to_mm = corners[rows, lone], corners[rows, other]
        ends.append((from_mm + share[:, None] * (to_mm - from_mm))[:, :2])
    segments = np.stack(ends, axis=1)
    down = ~above[rows, lone]
    segments[down] = segments[down, ::-1]
    return segments


def _measured_samples(mesh: Mesh) -> Points3:
    """Vertices that were measured, evenly thinned."""
    vertices = mesh.vertices_mm if mesh.filled is None else mesh.vertices_mm[~mesh.filled]
    return vertices[:: max(1, len(vertices) // _SAMPLES)]


def _towards(points_mm: Points3, tree: TriangleTree, truth: Truth) -> tuple[Rigid, float]:
    """One point-to-plane step (Chen and Medioni 1992), and the scale error that it leaves."""
    found = tree.closest(points_mm)
    near = (found.distances_mm < _FAR_MM) & truth.seen[truth.faces[found.faces]].all(1)
    points, normals = points_mm[near], _normals(truth)[found.faces[near]]
    off = np.einsum("nc,nc->n", points - found.points_mm[near], normals)
    middle = points.mean(0)
    arms = points - middle
    columns = np.column_stack(
        [np.cross(arms, normals), normals, np.einsum("nc,nc->n", arms, normals)]
    )
    with_scale = np.linalg.lstsq(columns, -off, rcond=None)[0]
    rigid = np.linalg.lstsq(columns[:, :6], -off, rcond=None)[0]
    turn = Rigid.from_rotation_vector(rigid[:3], np.zeros(3)).rotation
    return Rigid(turn, middle + rigid[3:] - turn @ middle), -float(with_scale[6])


def _signed_mm(points_mm: Points3, tree: TriangleTree, truth: Truth) -> Float64[np.ndarray, " n"]:
    """Distances from the seen truth, positive outside."""
    found = tree.closest(points_mm)
    seen = truth.seen[truth.faces[found.faces]].all(1) & (found.distances_mm < 5 * _FAR_MM)
    normals = _normals(truth)[found.faces[seen]]
    side = np.einsum("nc,nc->n", points_mm[seen] - found.points_mm[seen], normals)
    return np.where(side < 0, -1.0, 1.0) * found.distances_mm[seen]


def _normals(truth: Truth) -> Float64[np.ndarray, "f 3"]:
    a, b, c = (truth.vertices_mm[truth.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def _sections(placed: Mesh, truth: Truth) -> tuple[Float64[np.ndarray, " k"], float]:
    """Errors of girths at a few heights, and of the volume between the outer ones."""
    true = Mesh(vertices_mm=truth.vertices_mm, faces=truth.faces)
    seen_mm = truth.vertices_mm[truth.seen, 2]
    low, high = np.quantile(seen_mm, 0.02), np.quantile(seen_mm, 0.98)
    girths = [
        girth_mm(section(placed, height)) - girth_mm(section(true, height))
        for height in low + (high - low) * np.array(_GIRTHS)
    ]
    heights = np.quantile(seen_mm, 0.1), np.quantile(seen_mm, 0.9)
    heights = np.linspace(heights[0], heights[1], _SECTIONS)
    volumes = [
        sum(area_mm2(section(mesh, height)) for height in heights) for mesh in (placed, true)
    ]
    return np.array(girths), float(volumes[0] / volumes[1] - 1)
