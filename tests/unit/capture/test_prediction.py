"""The prediction: which photos see a cell, against geometry known beforehand; how sigma moves."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from limbgram.capture.camera_positions import Stand, stands_to_add
from limbgram.capture.prediction import (
    Prediction,
    Showing,
    bridging_factor,
    predict,
    vertex_sigma_mm,
)
from limbgram.capture.proxy import COLUMNS, LimbProxy, plain_tube
from limbgram.core.geometry.lens import Camera, View

CAMERA = Camera(width_px=3000, height_px=2000, fx=3600.0, fy=3600.0, cx=1499.5, cy=999.5)
LIMB = plain_tube(np.array([0.0, 250.0]), np.array([55.0, 50.0]), 35.0)
DISTANCE = 900.0


def ring(azimuths_deg: np.ndarray, elevation_deg: float = 25.0, distance: float = DISTANCE):
    return [
        Stand(azimuth_deg=float(one), elevation_deg=elevation_deg, distance=distance).view(
            CAMERA, LIMB.middle, 0.0
        )
        for one in azimuths_deg
    ]


def predicted(views: list[View], edge_px: float = 0.6, slope: float = 20.0) -> Prediction:
    return predict(LIMB, views, Showing.alike(len(LIMB.mesh), len(views), edge_px, slope))


def side(values: np.ndarray, proxy: LimbProxy = LIMB) -> np.ndarray:
    return proxy.by_row(values)[: proxy.side_rows]


def test_cells_are_seen_by_the_photos_within_65_degrees() -> None:
    """Level photos every 20 degrees: a cell of an upright tube is seen by those within 65."""
    found = predicted(ring(np.arange(0, 360, 20.0), elevation_deg=0.0))
    middle = side(found.squarely)[4]
    assert set(middle.tolist()) <= {6}  # 6 or 7 of them do, and measuring takes six at most
    few = predicted(ring(np.arange(0, 360, 45.0), elevation_deg=0.0))
    assert set(side(few.squarely)[4].tolist()) == {3}
    three = predicted(ring(np.arange(0, 360, 120.0), elevation_deg=0.0))
    # Photos at 0, 120 and 240: cells at 0 see the first alone, those at 60 both of their sides.
    assert side(three.squarely)[4][[0, 4]].tolist() == [1, 2]


def test_a_side_without_photos_is_unseen_and_the_opposite_is_not() -> None:
    found = predicted(ring(np.arange(-80, 81, 20.0)))
    seen = side(found.squarely)[4]
    assert (seen[:3] >= 4).all()
    assert (seen[COLUMNS // 2 - 2 : COLUMNS // 2 + 3] == 0).all()
    assert np.isnan(side(found.sigma_mm)[4][COLUMNS // 2])
    assert 0.4 < found.share(found.squarely >= 2, LIMB) < 0.75


def test_the_pixel_is_that_of_the_nearest_frontal_photo() -> None:
    found = predicted(ring(np.arange(0, 360, 24.0)))
    pixel_mm = side(found.pixel_mm)[4]
    true = (DISTANCE - 52.0 * np.cos(np.radians(25))) / CAMERA.fx
    assert np.abs(pixel_mm / true - 1).max() < 0.03


def test_sigma_grows_with_distance_blur_and_fewer_photos() -> None:
    usual = predicted(ring(np.arange(0, 360, 24.0)))
    base = usual.middle_sigma_mm(LIMB)
    assert 0.008 < base < 0.03  # pixels of 0.25 mm
    twice = predicted(ring(np.arange(0, 360, 24.0), distance=2 * DISTANCE)).middle_sigma_mm(LIMB)
    assert 2.0 < twice / base < 2.4
    blurred = predicted(ring(np.arange(0, 360, 24.0)), edge_px=2.0).middle_sigma_mm(LIMB)
    assert 1.7 < blurred / base < 2.1
    fewer = predicted(ring(np.arange(0, 360, 40.0))).middle_sigma_mm(LIMB)
    assert 1.05 < fewer / base < 1.6


def test_turning_the_whole_capture_changes_nothing() -> None:
    azimuths = np.arange(0, 360, 36.0)
    one, other = predicted(ring(azimuths)), predicted(ring(azimuths + 15.0))
    first, second = side(one.sigma_mm), np.roll(side(other.sigma_mm), -1, axis=1)
    np.testing.assert_allclose(np.median(first), np.median(second), rtol=1e-3)
    assert np.mean(np.abs(first / second - 1) < 0.01) > 0.9  # where no photo is just at a limit


@settings(max_examples=30)
@given(
    pixel_mm=st.floats(0.05, 1.5),
    edge_px=st.floats(0, 3),
    photos=st.integers(2, 6),
    spread=st.floats(0.1, 10),
    slope=st.floats(1, 60),
)
def test_more_of_anything_good_never_costs(
    pixel_mm: float, edge_px: float, photos: int, spread: float, slope: float
) -> None:
    def sigma(pixel: float, edge: float, count: int, apart: float, steep: float) -> float:
        arrays = (np.array([v]) for v in (pixel, edge, count, apart, steep))
        return float(vertex_sigma_mm(*arrays)[0])

    base = sigma(pixel_mm, edge_px, photos, spread, slope)
    assert 0 < base < pixel_mm
    assert sigma(pixel_mm / 2, edge_px, photos, spread, slope) < base / 2
    assert sigma(pixel_mm, edge_px / 2, photos, spread, slope) <= base
    assert sigma(pixel_mm, edge_px, photos + 1, spread, slope) <= base
    assert sigma(pixel_mm, edge_px, photos, 2 * spread, slope) < base
    assert sigma(pixel_mm, edge_px, photos, spread, 2 * slope) < base


def test_photos_are_asked_for_where_they_are_missing_and_then_no_more() -> None:
    views = ring(np.arange(-80, 81, 20.0))
    found = predicted(views)
    asked = stands_to_add(LIMB, found.squarely, 3, CAMERA, DISTANCE, 0.0, -1000.0, 12)
    assert 3 <= len(asked) <= 12
    turns = np.array([one.azimuth_deg for one in asked])
    assert ((turns > 80) & (turns < 280)).all()
    more = [one.view(CAMERA, LIMB.middle, 0.0) for one in asked]
    whole = predicted([*views, *more])
    assert whole.share(whole.squarely >= 3, LIMB) > 0.97
    assert not stands_to_add(LIMB, whole.squarely + 3, 3, CAMERA, DISTANCE, 0.0, -1000.0, 12)


def test_nothing_is_asked_for_from_under_the_floor() -> None:
    none = np.zeros(len(LIMB.mesh), int)
    floor = float(LIMB.mesh.vertices_mm[:, 2].min())
    asked = stands_to_add(LIMB, none, 3, CAMERA, DISTANCE, 0.0, floor, 12)
    heights = [one.view(CAMERA, LIMB.middle, 0.0).centre_in_world[2] for one in asked]
    assert min(heights) > floor


def test_a_surface_far_from_paint_is_less_sure_there_alone() -> None:
    views = ring(np.arange(0, 360, 20.0))
    cells = len(LIMB.mesh)
    alike = Showing.alike(cells, len(views), 0.6, 20.0)
    gap_px = np.zeros(cells)
    gap_px[40:50] = 24.0
    dense = predict(LIMB, views, alike).sigma_mm
    bare = predict(LIMB, views, replace(alike, gap_px=gap_px)).sigma_mm
    grown = bare / dense
    np.testing.assert_array_equal(grown[:40], 1.0)
    assert ((grown[40:50] > 1.6) & (grown[40:50] < 1.8)).all()
    assert bridging_factor(np.array([0.0, 10.0, 20.0, 40.0])).tolist() == sorted(
        bridging_factor(np.array([0.0, 10.0, 20.0, 40.0]))
    )


@pytest.mark.parametrize(
    ("pixel_mm", "edge_px", "photos", "spread", "slope", "sigma_mm"),
    [
        (0.4, 0.0, 5, 0.5, 20.0, 0.0379),
        (0.8, 0.0, 5, 0.5, 20.0, 0.0830),  # 2 to the power 1.13
        (0.4, 1.0, 5, 0.5, 20.0, 0.0536),  # the square root of 2
        (0.4, 0.0, 2, 0.5, 20.0, 0.0397),
        (0.4, 0.0, 5, 0.125, 20.0, 0.0599),  # the square root of 5 instead of 2
        (0.4, 0.0, 5, 0.5, 5.0, 0.0467),
    ],
)
def test_the_fitted_formula_worked_by_hand(
    pixel_mm: float, edge_px: float, photos: int, spread: float, slope: float, sigma_mm: float
) -> None:
    """As docs/method/prediction.md has it: 0.067 pixel at 0.4 mm, five photos and a slope of 20."""
    figures = [np.array([one]) for one in (pixel_mm, edge_px, photos, spread, slope)]
    assert vertex_sigma_mm(*figures)[0] == pytest.approx(sigma_mm, rel=0.002)
