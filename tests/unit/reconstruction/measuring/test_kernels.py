"""The measuring kernels against the same formulas in plain Python, one number at a time.

The references know nothing of the kernels' order of work: projection and its slopes come from
`View.project` and differences, interpolation from the B-spline's definition, eliminations from
dense projections. Kernels sample in single precision; tolerances are a few of its roundings.
"""

import hashlib
import math
import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import limbgram
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring import joint, patches, sampling
from limbgram.reconstruction.measuring.imagery import Imagery

SIDE = 2 * sampling.HALF_WIDTH + 1
STEP_MM = 0.8
GREY_ATOL = 2e-3
"""Sums of 81 products of grey levels in single precision."""
NO_PHOTO = -1


# The references


def cubic(t: float) -> float:
    """The cubic B-spline."""
    t = abs(t)
    if t < 1:
        return 2 / 3 - t * t + t**3 / 2
    return (2 - t) ** 3 / 6 if t < 2 else 0.0


def cubic_slope(t: float) -> float:
    sign = math.copysign(1.0, t)
    t = abs(t)
    if t < 1:
        return sign * (-2 * t + 1.5 * t * t)
    return sign * (-((2 - t) ** 2) / 2) if t < 2 else 0.0


def grey_at(imagery: Imagery, photo: int, x: float, y: float) -> np.ndarray:
    """Value, d/dx and d/dy at a pixel of the crop."""
    start, _, _, width, height = imagery.crops[photo]
    pixels = imagery.coefficients[start : start + width * height].reshape(height, width)
    found = np.zeros(3)
    for row in range(math.floor(y) - 1, math.floor(y) + 3):
        for column in range(math.floor(x) - 1, math.floor(x) + 3):
            c, along_x, along_y = float(pixels[row, column]), x - column, y - row
            found += c * np.array(
                [
                    cubic(along_x) * cubic(along_y),
                    cubic_slope(along_x) * cubic(along_y),
                    cubic(along_x) * cubic_slope(along_y),
                ]
            )
    return found


def pixel_and_slopes(view: View, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Full-size pixel of a point, and how it moves with the point (2, 3)."""
    small = 1e-4
    slopes = [
        (view.project((point + small * e)[None])[0] - view.project((point - small * e)[None])[0])
        / (2 * small)
        for e in np.eye(3)
    ]
    return view.project(point[None])[0], np.array(slopes).T


def in_crop(imagery: Imagery, photo: int, xy: np.ndarray) -> np.ndarray:
    return (xy + 0.5) * imagery.factor - 0.5 - imagery.crops[photo, 1:3]


def gaussian() -> np.ndarray:
    sigma = 0.75 * sampling.HALF_WIDTH
    offsets = [
        (k % SIDE - sampling.HALF_WIDTH, k // SIDE - sampling.HALF_WIDTH) for k in range(SIDE**2)
    ]
    weights = np.array([math.exp(-(i * i + j * j) / (2 * sigma**2)) for i, j in offsets])
    return weights / weights.sum()


@dataclass(frozen=True)
class Patch:
    vertex: np.ndarray
    axes: np.ndarray
    quadric: np.ndarray


def a_patch(random: np.random.Generator, spread_mm: float = 8.0) -> Patch:
    """Near the plane, its normal about upwards."""
    normal = np.array([0.0, 0.0, 1.0]) + random.normal(0, 0.1, 3)
    normal /= np.linalg.norm(normal)
    first = np.cross([0.0, 1.0, 0.0], normal)
    first /= np.linalg.norm(first)
    vertex = np.array([*random.uniform(-spread_mm, spread_mm, 2), random.normal(0, 0.1)])
    axes = np.stack([first, np.cross(normal, first), normal])
    return Patch(vertex, axes, random.normal(0, 0.01, 3))


@dataclass(frozen=True)
class Windows:
    """Rows by photo: grey values less their mean, their change for a millimetre."""

    photos: list[int]
    value: np.ndarray
    slope: np.ndarray
    level: np.ndarray
    px_per_mm: float


def windows(
    imagery: Imagery, views: list[View], seen_by: np.ndarray, patch: Patch, state: np.ndarray,
    least_variance: float,
) -> Windows:  # fmt: skip
    """Pixels move linearly with the patch's points; the patch is bent by its quadric."""
    weights = gaussian()
    tangents, normal = patch.axes[:2], patch.axes[2]
    q = patch.quadric
    photos, values, slopes, levels, scales = [], [], [], [], []
    for photo in seen_by[seen_by >= 0]:
        middle, by_point = pixel_and_slopes(views[photo], patch.vertex + state[0] * normal)
        centre, by_point = in_crop(imagery, photo, middle), by_point * imagery.factor
        along_normal = by_point @ normal
        value, slope, places = [], [], []
        highest = (abs(q[0]) + 2 * abs(q[1]) + abs(q[2])) * (sampling.HALF_WIDTH * STEP_MM) ** 2 / 2
        edges = [by_point @ (t + s * normal) * STEP_MM for t, s in zip(tangents, state[1:])]
        reach = sampling.HALF_WIDTH * np.abs(edges).sum(0) + highest * np.abs(along_normal) + 3.0
        size = imagery.crops[photo, 3:5]
        if not (np.all(centre > reach) and np.all(centre + reach < size - 1)):
            continue
        for k in range(SIDE**2):
            u, v = (
                (k % SIDE - sampling.HALF_WIDTH) * STEP_MM,
                (k // SIDE - sampling.HALF_WIDTH) * STEP_MM,
            )
            lift = (q[0] * u * u + 2 * q[1] * u * v + q[2] * v * v) / 2
            offset = (
                u * tangents[0] + v * tangents[1] + (lift + state[1] * u + state[2] * v) * normal
            )
            places.append(centre + by_point @ offset)
            grey, along_x, along_y = grey_at(imagery, photo, *places[-1])
            value.append(grey)
            slope.append(np.array([along_x, along_y]) @ along_normal)
        level = float(weights @ value)
        if weights @ (np.array(value) - level) ** 2 < least_variance:
            continue
        photos.append(int(photo))
        values.append(np.array(value) - level)
        slopes.append(slope)
        levels.append(level)
        scales.append(np.linalg.norm(along_normal))
    px_per_mm = float(np.mean(scales)) if scales else 0.0
    return Windows(photos, np.array(values), np.array(slopes), np.array(levels), px_per_mm)


def power_steps(gram: np.ndarray) -> np.ndarray:
    gains = np.sqrt(np.diag(gram))
    for _ in range(12):
        gains = gram @ gains
        gains = gains / np.linalg.norm(gains)
    return gains


def those_that_agree(found: Windows) -> tuple[Windows, np.ndarray] | None:
    """Without the photos, one by one, that are unlike the others; with the gains."""
    weights, keep = gaussian(), list(range(len(found.photos)))
    while True:
        value = found.value[keep]
        gram = np.einsum("ik,jk,k->ij", value, value, weights)
        gains = power_steps(gram)
        energy = gains @ gram @ gains
        correlation = gains * np.sqrt(energy / np.maximum(np.diag(gram), 1e-9))
        if len(keep) < 3 or correlation.min() >= 0.5:
            break
        keep.pop(int(np.argmin(correlation)))
        if 2 * len(keep) <= len(found.photos):
            return None
    if not np.all(gains > 0.02):
        return None
    kept = Windows(
        [found.photos[k] for k in keep], found.value[keep], found.slope[keep], found.level[keep],
        found.px_per_mm,
    )  # fmt: skip
    return kept, gains


@dataclass(frozen=True)
class Step:
    of_state: np.ndarray
    sigma_mm: float
    noise: float
    correlation: float


def gauss_newton(found: Windows, gains: np.ndarray, state: np.ndarray, seen: int) -> Step:
    """Texture, gains and means eliminated by dense projections."""
    weights, used = gaussian(), len(found.photos)
    texture = gains @ found.value
    energy = float(weights @ texture**2)
    u = np.array([(k % SIDE - sampling.HALF_WIDTH) * STEP_MM for k in range(SIDE**2)])
    v = np.array([(k // SIDE - sampling.HALF_WIDTH) * STEP_MM for k in range(SIDE**2)])
    off_gains = np.eye(used) - np.outer(gains, gains)
    off_means = np.eye(SIDE**2) - np.outer(weights, np.ones(SIDE**2))
    off_texture = np.eye(SIDE**2) - np.outer(weights * texture, texture) / energy
    changes = [off_gains @ found.slope * along @ off_means @ off_texture for along in (1, u, v)]
    residual = found.value - np.outer(gains, texture)
    normal = np.array([[(a * b * weights).sum() for b in changes] for a in changes])
    right = -np.array([(a * residual * weights).sum() for a in changes])

    total = float((found.value**2 * weights).sum())
    samples = 1 / float(weights @ weights)
    freedom = (used - 1) * (samples - 2) - 3
    noise2 = max((total - energy) * samples / max(freedom, 1.0), 0.0)
    prior = max(noise2, 0.5) / (samples * 0.3**2) * np.diag([0.0, 1.0, 1.0])
    inverse = np.linalg.inv(normal + prior)
    correlation = (energy / total * used - 1) / (used - 1) * used / seen
    return Step(
        inverse @ (right - prior @ state),
        math.sqrt(noise2 / samples * inverse[0, 0]),
        math.sqrt(noise2),
        correlation,
    )


# Against the kernels


def patches_of(some: Sequence[Patch]) -> sampling.Patches:
    return sampling.Patches(
        np.stack([patch.vertex for patch in some]),
        np.stack([patch.axes for patch in some]),
        np.stack([patch.quadric for patch in some]),
        np.full(len(some), STEP_MM),
    )


def windows_with(value: np.ndarray, slope: np.ndarray) -> sampling.Windows:
    """The windows of as many photos as rows, and their Gram matrix."""
    filled = sampling.empty_windows(len(value))
    filled.value[:], filled.slope[:] = value, slope
    filled.mean[:], filled.photo_of[:] = 1.0, np.arange(len(value))
    sampling.fill_gram(filled, len(value))
    return filled


def kernel_windows(painted, seen_by: np.ndarray, patch: Patch, state: np.ndarray, least: float):
    """What sample_windows fills, and what it returns."""
    filled = sampling.empty_windows(len(seen_by))
    used, per_mm = sampling.sample_windows(
        painted.imagery, seen_by, patches_of([patch]), 0, state, least, filled
    )
    return used, per_mm, filled


def test_weights_are_a_gaussian() -> None:
    np.testing.assert_allclose(sampling.window_weights(), gaussian(), atol=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_windows_are_those_of_the_formula(painted, seed: int) -> None:
    random = np.random.default_rng(seed)
    patch, state = a_patch(random), np.array([0.05, 0.2, -0.1]) * random.normal(size=3)
    seen_by = random.permutation(5).astype(np.int32)
    seen_by[4] = NO_PHOTO
    used, per_mm, filled = kernel_windows(painted, seen_by, patch, state, 4.0)
    expected = windows(painted.imagery, painted.views, seen_by, patch, state, 4.0)
    assert filled.photo_of[:used].tolist() == expected.photos == seen_by[:4].tolist()
    np.testing.assert_allclose(per_mm, expected.px_per_mm, rtol=1e-6)
    np.testing.assert_allclose(filled.value[:used], expected.value, atol=GREY_ATOL)
    np.testing.assert_allclose(filled.slope[:used], expected.slope, atol=GREY_ATOL)
    np.testing.assert_allclose(filled.mean[:used], expected.level, rtol=1e-6)


def test_windows_that_leave_a_crop_or_show_nothing_are_left_out(painted) -> None:
    """Round the plane's corners photos drop out one after another, in kernel and reference."""
    random, counts = np.random.default_rng(9), set()
    seen_by = np.arange(5, dtype=np.int32)
    for _ in range(12):
        patch = a_patch(random, 28.0)
        used, _, filled = kernel_windows(painted, seen_by, patch, np.zeros(3), 60.0)
        expected = windows(painted.imagery, painted.views, seen_by, patch, np.zeros(3), 60.0)
        assert filled.photo_of[:used].tolist() == expected.photos
        counts.add(used)
    assert {0, 5} < counts


@pytest.mark.parametrize("odd", [0, 1, 2, 3])
def test_photos_that_are_unlike_the_others_are_left_out(odd: int) -> None:
    """`odd` of five photos show something else; three would be more than half."""
    random = np.random.default_rng(odd)
    texture = random.normal(0, 20, SIDE**2)
    value = np.outer(random.uniform(0.6, 1.4, 5), texture) + random.normal(0, 2, (5, SIDE**2))
    value[:odd] = random.normal(0, 20, (odd, SIDE**2))
    value -= value @ gaussian()[:, None]
    found = Windows(list(range(5)), value, random.normal(size=value.shape), np.ones(5), 1.0)
    expected = those_that_agree(found)
    filled = windows_with(value, found.slope)
    gram, gains, photo_of = filled.gram, filled.gains, filled.photo_of
    np.testing.assert_allclose(
        gram, np.einsum("ik,jk,k->ij", found.value, found.value, gaussian()), rtol=1e-4, atol=1e-2
    )
    used = sampling.drop_inconsistent_photos(filled, 5, 0.0)
    if odd == 3:
        assert used == 0
        assert expected is None
        return
    assert expected is not None
    order = np.argsort(photo_of[:used])
    assert photo_of[:used][order].tolist() == expected[0].photos == list(range(odd, 5))
    np.testing.assert_allclose(gains[:used][order], expected[1], atol=1e-5)
    np.testing.assert_allclose(filled.slope[:used][order], expected[0].slope, rtol=1e-6)
    vectors = np.linalg.eigh(gram[:used, :used])[1]
    np.testing.assert_allclose(gains[:used], np.abs(vectors[:, -1]), atol=1e-4)


@pytest.mark.parametrize(("seed", "off_mm"), [(0, 0.1), (1, -0.3), (2, 1.0), (8, 2.5)])
def test_a_patch_is_measured_by_the_formula(painted, seed: int, off_mm: float) -> None:
    """Report of the start, and the state after one step; far off one photo is left out."""
    random = np.random.default_rng(100 + seed)
    patch = a_patch(random)
    start = np.array([[off_mm, 0.02, -0.03]])
    seen_by = np.arange(5, dtype=np.int32)[None]
    imagery = painted.imagery
    given = (imagery, seen_by, patches_of([patch]))
    state = start.copy()
    report = patches.measure_patches(*given, 0, state)[0]
    np.testing.assert_array_equal(state, start)
    stepped = start.copy()
    patches.measure_patches(*given, 1, stepped)

    found = windows(imagery, painted.views, seen_by[0], patch, start[0], 4.0)
    agreed = those_that_agree(found)
    assert agreed is not None
    kept, gains = agreed
    expected = gauss_newton(kept, gains, start[0], len(found.photos))
    assert report[0] == patches.MEASURED
    assert report[4] == len(kept.photos)
    figures = [expected.sigma_mm, expected.noise, expected.correlation]
    np.testing.assert_allclose(report[1:4], figures, rtol=2e-4)
    damping = 1 / max(1.0, abs(expected.of_state[0]) * found.px_per_mm / 1.5)
    assert (len(kept.photos) < 5) == (off_mm > 2)
    np.testing.assert_allclose(
        stepped[0] - start[0], damping * expected.of_state, rtol=1e-3, atol=2e-5
    )


IN_A_PROCESS = """
import hashlib, pathlib, pickle, sys
from limbgram.reconstruction.measuring.patches import measure_patches
given = pickle.loads(pathlib.Path(sys.argv[1]).read_bytes())
report = measure_patches(*given)
sys.stdout.write(hashlib.sha256(report.tobytes() + given[-1].tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_the_run_that_compiles_gives_the_bytes_of_all_others(painted, tmp_path: Path) -> None:
    """Functions that were compiled apart and linked gave other digits once out of the cache."""
    random = np.random.default_rng(4)
    some = [a_patch(random) for _ in range(50)]
    given = (
        painted.imagery,
        np.tile(np.arange(5, dtype=np.int32), (len(some), 1)),
        patches_of(some),
        4,
        np.tile([0.2, 0.0, 0.0], (len(some), 1)),
    )
    file = tmp_path / "given.pickle"
    file.write_bytes(pickle.dumps(given))
    source = Path(limbgram.__file__).parent.parent
    around = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(source)}
    command = [sys.executable, "-c", IN_A_PROCESS, str(file)]
    compiling, cached = (
        subprocess.run(command, env=around, check=True, capture_output=True, text=True).stdout
        for _ in range(2)
    )
    assert compiling == cached
    report = patches.measure_patches(*given)
    assert np.count_nonzero(report[:, 0] == patches.MEASURED) > 40
    assert compiling == hashlib.sha256(report.tobytes() + given[-1].tobytes()).hexdigest()


def test_what_cannot_be_measured_says_why(painted) -> None:
    """One photo, a place that none shows, and a photo beside its own negative."""
    imagery = painted.imagery
    patch = a_patch(np.random.default_rng(1))
    start, _, _, width, height = imagery.crops[1]
    coefficients = imagery.coefficients.copy()
    coefficients[start : start + width * height] *= -1
    seen_by = np.array([[0, NO_PHOTO], [0, 2], [0, 1]], np.int32)
    elsewhere = replace(patch, vertex=patch.vertex + np.array([300.0, 0, 0]))
    report = patches.measure_patches(
        imagery._replace(coefficients=coefficients),
        seen_by,
        patches_of([patch, elsewhere, patch]),
        3,
        np.zeros((3, 3)),
    )
    assert report[:, 0].tolist() == [patches.UNSEEN, patches.UNSEEN, patches.INCONSISTENT]


def gains_of(painted, patch: Patch, seen_by: np.ndarray) -> np.ndarray:
    """GAIN, MEAN and MEAN_PER_MM by slot, from the formula."""
    rows = np.zeros((len(seen_by), 4))
    found = windows(painted.imagery, painted.views, seen_by, patch, np.zeros(3), 0.0)
    agreed = those_that_agree(found) if len(found.photos) > 1 else None
    if agreed is None:
        return rows
    kept, _ = agreed
    gram = np.einsum("ik,jk,k->ij", kept.value, kept.value, gaussian())
    gram += 25.0 / (kept.level[0] ** 2 + 1) * np.outer(kept.level, kept.level)
    for row, photo in enumerate(kept.photos):
        slot = seen_by.tolist().index(photo)
        rows[slot, joint.GAIN] = power_steps(gram)[row] * math.sqrt(len(kept.photos))
        rows[slot, joint.MEAN] = kept.level[row]
        rows[slot, joint.MEAN_PER_MM] = gaussian() @ kept.slope[row]
    return rows


def test_windows_of_noise_keep_all_photos_but_what_differs_by_more() -> None:
    """Which of them are alike is chance; a highlight in one of them is not."""
    random = np.random.default_rng(5)
    noise_grey = 1.5
    for highlight in (False, True):
        value = random.normal(0, noise_grey, (5, SIDE**2))
        value[0] += highlight * 20.0 * (np.arange(SIDE**2) < 30)
        value -= value @ gaussian()[:, None]
        kept: list[list[int]] = []
        for noise in (0.0, 2 * noise_grey**2):
            filled = windows_with(value, value)
            used = sampling.drop_inconsistent_photos(filled, 5, noise)
            kept.append(sorted(filled.photo_of[:used]))
        blind, knowing = kept
        assert len(blind) < 5
        assert knowing == list(range(int(highlight), 5))


def test_a_photo_burnt_out_where_the_others_show_paint_is_left_out() -> None:
    """It has next to no contrast there: what it differs by is what it lacks."""
    random = np.random.default_rng(6)
    noise_grey, texture = 1.5, np.random.default_rng(7).normal(0, 20.0, SIDE**2)
    value = texture + random.normal(0, noise_grey, (5, SIDE**2))
    value[0] = random.normal(0, 0.3, SIDE**2)
    value -= value @ gaussian()[:, None]
    filled = windows_with(value, value)
    used = sampling.drop_inconsistent_photos(filled, 5, 2 * noise_grey**2)
    assert sorted(filled.photo_of[:used]) == [1, 2, 3, 4]


def test_local_gains_are_those_of_the_formula(painted) -> None:
    random = np.random.default_rng(11)
    few = [a_patch(random, 20.0) for _ in range(8)]
    seen_by = np.stack([random.permutation(5) for _ in few]).astype(np.int32)
    seen_by[1, 3:], seen_by[2, 1:] = NO_PHOTO, NO_PHOTO
    at_vertex = np.zeros((8, 5, 4), np.float32)
    joint.local_gains(painted.imagery, seen_by, patches_of(few), 0.0, at_vertex)
    expected = np.stack([gains_of(painted, p, seen) for p, seen in zip(few, seen_by)])
    assert (expected[..., joint.GAIN] > 0).sum() > 15
    assert not expected[2].any(), "one photo measures nothing"
    np.testing.assert_allclose(at_vertex, expected, rtol=1e-4, atol=GREY_ATOL)


@dataclass
class FaceEquations:
    matrix: np.ndarray
    right: np.ndarray
    pull: np.ndarray
    curvature: float


def face_equations(
    painted, seen_by: np.ndarray, at_vertex: np.ndarray, corners: np.ndarray, normals: np.ndarray,
    points: np.ndarray, noise_grey: float, noise_px: float, robust: float,
) -> FaceEquations:  # fmt: skip
    """Of one face; rows of `seen_by`, `at_vertex`, `corners` and `normals` are its corners."""
    imagery = painted.imagery
    equations = FaceEquations(np.zeros((3, 3)), np.zeros(3), np.zeros(seen_by.shape[1]), 1.0)
    held = bent = 0.0
    for share in points:
        slots, scale, grey, change, steep = [], [], [], [], []
        for slot, photo in enumerate(seen_by[0]):
            places = [np.flatnonzero(row == photo) for row in seen_by]
            if photo == NO_PHOTO or not all(len(place) for place in places):
                continue
            known = np.array([rows[place[0]] for rows, place in zip(at_vertex, places)], float)
            if not np.all(known[:, joint.GAIN] > 0):
                continue
            gain, mean, drift, lift = share @ known
            xy, by_point = pixel_and_slopes(painted.views[photo], share @ corners)
            along = by_point @ (share @ normals)
            x, y = in_crop(imagery, photo, xy + lift * along)
            width, height = imagery.crops[photo, 3:5]
            if not (3 < x < width - 4 and 3 < y < height - 4):
                continue
            value, along_x, along_y = grey_at(imagery, photo, x, y)
            slots.append(slot)
            scale.append(gain)
            grey.append(value - mean)
            change.append(imagery.factor * (along_x * along[0] + along_y * along[1]) - drift)
            steep.append(along_x**2 + along_y**2)
        if len(slots) < 2:
            continue
        gains = np.array(scale)
        off_texture = np.eye(len(gains)) - np.outer(gains, gains) / (gains @ gains)
        residual, slope = off_texture @ grey, off_texture @ change
        variance = noise_grey**2 + noise_px**2 * np.mean(steep)
        limit = (len(slots) - 1) * robust**2
        weight = 1 / (variance * (1 + residual @ residual / variance / limit))
        equations.matrix += weight * (slope @ slope) * np.outer(share, share)
        equations.right -= weight * (residual @ slope) * share
        equations.pull[slots] -= weight * residual * slope
        held += weight * slope @ slope
        bent += weight * slope @ slope - 2 * (weight * residual @ slope) ** 2 / limit
    if held > 0:
        equations.curvature = min(max(bent / held, 0.1), 1.0)
    return equations


@pytest.mark.parametrize("robust", [0.7, 1.5])
def test_the_equations_of_faces_are_those_of_the_formula(painted, robust: float) -> None:
    """Faces inside the crops, over their edge and outside; photos that only some corners see."""
    random = np.random.default_rng(21)
    vertices = np.column_stack([random.uniform(-26, 26, (40, 2)), random.normal(0, 0.2, 40)])
    normals = np.array([0.0, 0.0, 1.0]) + random.normal(0, 0.1, (40, 3))
    faces = np.array([random.choice(40, 3, replace=False) for _ in range(24)], np.int32)
    seen_by = np.stack([random.permutation(5) for _ in vertices]).astype(np.int32)
    seen_by[::7, 2:] = NO_PHOTO
    at_vertex = np.zeros((40, 5, 4), np.float32)
    at_vertex[..., joint.GAIN] = random.uniform(0.5, 1.5, (40, 5)) * (random.random((40, 5)) > 0.1)
    at_vertex[..., joint.MEAN] = random.uniform(90, 140, (40, 5))
    at_vertex[..., joint.MEAN_PER_MM] = random.normal(0, 2, (40, 5))
    at_vertex[..., joint.LIFT] = random.normal(0, 0.05, (40, 5))
    points = np.array([[2 / 3, 1 / 6, 1 / 6], [1 / 6, 2 / 3, 1 / 6], [0.1, 0.2, 0.7]])
    imagery, noise_grey, noise_px = painted.imagery, 1.5, 0.02
    matrix, right, pull, curvature = joint.assemble(
        imagery, seen_by, at_vertex, Mesh(vertices_mm=vertices, faces=faces), normals, points,
        joint.NoiseModel(noise_grey, noise_px, robust),
    )  # fmt: skip
    bent = 0
    for f, face in enumerate(faces):
        expected = face_equations(
            painted, seen_by[face], at_vertex[face], vertices[face], normals[face],
            points, noise_grey, noise_px, robust,
        )  # fmt: skip
        upper = expected.matrix[np.triu_indices(3)]
        np.testing.assert_allclose(matrix[f], upper, rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(right[f], expected.right, rtol=1e-3, atol=1e-2)
        np.testing.assert_allclose(pull[f], expected.pull, rtol=1e-3, atol=1e-2)
        np.testing.assert_allclose(curvature[f], expected.curvature, atol=1e-3)
        bent += expected.curvature < 0.99
    assert bent > 5, "the robust cost was used"
    assert (np.abs(matrix).sum(1) > 0).sum() > 8, "faces were measured"
    assert (np.abs(matrix).sum(1) == 0).any(), "and some were not"
