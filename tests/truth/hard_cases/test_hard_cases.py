"""Highlights, shadow edges, contours, thin parts and the brim, each against the same limb without.

The bounds are multiples of the clean capture's error at the same places. They are two-sided: a
capture that is no harder than the clean one would test nothing.
"""

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from limbgram.reconstruction.measuring.thin_plate import thin_plate_of
from limbgram.synthetic.rendering.shading import LAMP_IN_WORLD, Lighting, Shadow, shadow_edge


def rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def times_clean(bench, result, points_mm: np.ndarray) -> float:
    """RMS error at points of the result over that of the clean capture's nearest points."""
    clean = bench.clean.samples()
    away, nearest = KDTree(clean).query(points_mm)
    assert np.quantile(away, 0.99) < 2.0
    return rms(result.errors_mm(points_mm)) / rms(bench.clean.errors_mm(clean[nearest]))


def inner(bench, points_mm: np.ndarray) -> np.ndarray:
    """Points off the edges of the measured piece."""
    middle, out, across = bench.axes
    off = points_mm - middle
    return points_mm[(np.abs(off[:, 2]) < 42) & (off @ out > 0.55 * np.abs(off @ across))]


def values_at(picture: np.ndarray, view, points_mm: np.ndarray) -> np.ndarray:
    xy = np.rint(view.project(points_mm)).astype(int)
    high, wide = picture.shape
    inside = (xy >= 0).all(1) & (xy < [wide, high]).all(1)
    values = np.zeros(len(points_mm))
    values[inside] = picture[xy[inside, 1], xy[inside, 0]]
    return values


@pytest.mark.slow
def test_a_start_of_two_thirds_of_a_pixel_in_short_waves_is_forgotten(bench) -> None:
    """RMS 0.31 mm at the start; patches of half size alone leave 0.044 mm and 0.43 at most."""
    points = inner(bench, bench.start().vertices_mm)
    assert rms(bench.clean.errors_mm(points)) > 0.6 * bench.pixel_mm
    errors = bench.clean.errors_mm(inner(bench, bench.clean.samples()))
    assert rms(errors) < 0.075 * bench.pixel_mm
    assert np.abs(errors).max() < 0.5 * bench.pixel_mm


@pytest.mark.slow
def test_wet_paint_does_not_draw_the_surface_to_its_highlights(bench) -> None:
    """The highlight moves with the camera; in it half of the paint is burnt out."""
    wet = bench.lit("wet", Lighting(gloss=30.0, polish=60.0))
    points = inner(bench, wet.samples())
    seen = wet.shots.sees(points, wet.normals(points), 65.0)
    shiny, burnt = np.zeros(len(points), bool), np.zeros(len(points), bool)
    for view, glare, plain, sees in zip(
        wet.shots.views, wet.shots.grey(), bench.clean.shots.grey(), seen, strict=True
    ):
        more = cv2.GaussianBlur(glare - plain, (0, 0), 2.0)
        shiny |= sees & (values_at(more, view, points) > 25)
        burnt |= sees & (values_at(cv2.dilate(glare, np.ones((5, 5))), view, points) >= 250)
    burnt &= shiny
    assert shiny.sum() > 5000
    assert burnt.sum() > 2000
    assert 1.02 < times_clean(bench, wet, points[shiny]) < 1.4
    assert 1.01 < times_clean(bench, wet, points[burnt]) < 1.4
    errors = wet.errors_mm(points[burnt])
    assert abs(errors.mean()) < 0.3 * rms(errors)
    assert np.abs(errors).max() < 0.8 * bench.pixel_mm


@pytest.mark.slow
def test_the_edge_of_a_moving_shadow_leaves_no_step(bench) -> None:
    lighting = Lighting(ambient=0.25, lamp=1.2, flash=0.25, shadow=Shadow.MOVING)
    shaded = bench.lit("shaded", lighting)
    points = inner(bench, shaded.samples())
    middle, out, _ = bench.axes
    edges = [shadow_edge(lighting, middle + 50 * out, bench.seed, k) for k in range(7)]
    beside = np.abs((points - LAMP_IN_WORLD) @ np.array(edges).T).min(1) < 1.5
    assert beside.sum() > 5000
    for dark, plain in zip(shaded.shots.grey(), bench.clean.shots.grey(), strict=True):
        change = cv2.GaussianBlur(dark - plain, (0, 0), 2.0)
        assert change.max() > 30
        assert change.min() < -30
    times = times_clean(bench, shaded, points[beside])
    error_mm = rms(shaded.errors_mm(points[beside]))
    # What the shadow adds, in mm: a share of the clean capture's error grows as that becomes less.
    assert 0.0 < error_mm * np.sqrt(1 - 1 / times**2) < 0.0135


@pytest.mark.slow
def test_a_thin_fin_keeps_its_two_sides_and_what_lies_behind_its_contour(bench) -> None:
    """A fin of 9 pixels' thickness and 12 mm height; behind it the skin is seen past its edge."""
    fin = bench.fin()
    points = fin.samples()
    rise = bench.above_skin_mm(points)
    on_fin = rise > 2.0
    away = KDTree(points[on_fin]).query(points)[0]
    behind = inner(bench, points[~on_fin & (away > 6) & (away < 20)])
    assert 1.02 < times_clean(bench, fin, behind) < 2.0

    truth = bench.truth_with_fin.vertices_mm
    middle, out, across = bench.axes
    for height in (4.0, 9.0):
        widths = []
        for surface in (points, truth):
            rises = bench.above_skin_mm(surface)
            part = surface[(np.abs(rises - height) < 1.5) & (np.abs(surface - middle)[:, 2] < 15)]
            side = (part - middle) @ across
            middle_of_fin = 0.5 * (side.min() + side.max())
            left, right = side[side < middle_of_fin], side[side >= middle_of_fin]
            widths.append(np.median(right) - np.median(left))
        assert 3.0 < widths[1] < 5.5
        assert abs(widths[0] - widths[1]) < 0.3
    tips = [((s - middle) @ out)[np.abs(s - middle)[:, 2] < 15].max() for s in (points, truth)]
    assert abs(tips[0] - tips[1]) < 0.3
    assert 0.02 < rms(fin.errors_mm(points[on_fin])) < 0.25


def test_the_rim_stays_beside_its_neighbours(bench) -> None:
    """Windows at the brim look past it; the cut's underside and the table lie behind."""
    brim = bench.at_brim()
    thin_plate = thin_plate_of(brim.mesh)
    row = thin_plate.is_boundary.astype(float)
    rim = thin_plate.is_boundary & (brim.mesh.vertices_mm[:, 2] < 75)
    for _ in range(3):
        row = row + thin_plate.neighbours @ row
    errors = brim.errors_mm(brim.mesh.vertices_mm)
    assert rim.sum() > 60
    assert 1.2 < rms(errors[rim]) / rms(errors[row == 0]) < 4.0
    assert np.abs(errors[rim]).max() < 0.8 * bench.pixel_mm


@pytest.mark.slow  # of a ball, `test_what_no_photo_sees_is_called_filled_and_stays`
def test_what_fewer_than_two_photos_see_is_marked_filled(bench) -> None:
    """Of three photos from one side; what they see is asked of rays cast at the truth.

    Beside a fill, what no two photos agree on is filled, too: what is plainly seen lies two rings
    away from what is not.
    """
    few = bench.fin(slice(4, 7))
    truth = bench.truth_with_fin
    points = few.mesh.vertices_mm
    normals = few.normals(points)
    rays = trimesh.Trimesh(truth.vertices_mm, truth.faces, process=False).ray
    free = np.stack(
        [
            ~rays.intersects_any(points + 0.8 * normals, view.centre_in_world - points)
            for view in few.shots.views
        ]
    )
    barely = (free & few.shots.sees(points, normals, 105.0)).sum(0)
    well = (free & few.shots.sees(points, normals, 75.0)).sum(0)
    near = thin_plate_of(few.mesh).neighbours
    hidden = (near @ (barely >= 2).astype(float) == 0) & (barely < 2)
    plain = (near @ (near @ (well < 2).astype(float)) == 0) & (well >= 2)
    assert hidden.sum() > 200
    assert plain.sum() > 2000
    assert few.mesh.filled[hidden].all()
    assert not few.mesh.filled[plain].any()
