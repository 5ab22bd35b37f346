"""Each fault of a real camera does to the photos what geometry says that it does."""

import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PIL.JpegImagePlugin import JpegImageFile

from limbgram.core.errors import OptionsError
from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.lens import View
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.targets.board_detection import find_board
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.faults import (
    Faults,
    Readout,
    Session,
    crept,
    exposure_of,
    readout_of,
)
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.props.board import CALIBRATION_BOARD
from limbgram.synthetic.props.room import Panel, make_room, shifted_about
from limbgram.synthetic.rendering.developing import defocused, denoised, sharpened
from limbgram.synthetic.rendering.renderer import RenderScene, inverse_depth_of, render, silhouette
from limbgram.synthetic.rendering.shading import Lighting, light_of
from limbgram.synthetic.truth import ideal_camera, stage_truth, surface_points

FEW = replace(
    SMALL, photos=3, calibration_photos=3, mesh_step_mm=3.0, noise=0.2, samples=2, coverage=0.0
)
STAGE = replace(FEW, calibration_photos=0)


@pytest.fixture(scope="module")
def without(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return make_capture(tmp_path_factory.mktemp("ideal") / "limb", FEW)


def corners(capture: Capture) -> list[Points2]:
    """The calibration board's corners as they are found in its photos; NaN where one is not.

    A checkerboard looks the same turned by half: its numbers are put right by the truth.
    """
    photos = read_photos([capture.folder / "calibration"])
    truth = capture.truth.calibration_board.corners_in_world()
    rows: list[Points2] = []
    found = find_board(photos, CALIBRATION_BOARD.board).photos
    for view, photo in zip(capture.truth.calibration_views, found, strict=True):
        row = np.full((len(truth), 2), np.nan)
        row[photo.ids] = photo.xy_px
        told = view.project(truth)
        as_is, turned = (np.nanmean(np.linalg.norm(one - told, axis=1)) for one in (row, row[::-1]))
        rows.append(row if as_is < turned else row[::-1])
    assert all(np.isfinite(row).all(1).sum() > 130 for row in rows)
    return rows


def mean_length(moves: Points2) -> float:
    return float(np.nanmean(np.linalg.norm(moves, axis=1)))


def recorded(capture: Capture, group: str) -> list[dict[str, float]]:
    record = json.loads((capture.folder / "truth" / "cameras.json").read_text())
    return [row.get("own_lens", {}) for row in record[group]]


def test_a_stabiliser_moves_what_is_drawn_by_the_offsets_that_the_truth_records(
    without: Capture, tmp_path: Path
) -> None:
    faulty = make_capture(tmp_path / "limb", replace(FEW, faults=Faults(stabiliser_px=3.0)))
    ideal = ideal_camera(FEW)
    told = np.array(
        [(row["cx"] - ideal.cx, row["cy"] - ideal.cy) for row in recorded(faulty, "calibration")]
    )
    pairs = zip(corners(faulty), corners(without), strict=True)
    moved = np.array([np.nanmean(shifted - still, axis=0) for shifted, still in pairs])
    np.testing.assert_allclose(moved, told, atol=0.01)
    assert np.abs(told).max() > 1.0
    assert recorded(without, "calibration") == [{}] * 3


@pytest.mark.slow
def test_breathing_draws_every_photo_larger_or_smaller_about_its_principal_point(
    without: Capture, tmp_path: Path
) -> None:
    faulty = make_capture(tmp_path / "limb", replace(FEW, faults=Faults(breathing=0.004)))
    ideal = ideal_camera(FEW)
    middle = np.array([ideal.cx, ideal.cy])
    rows = recorded(faulty, "calibration")
    pairs = zip(corners(faulty), corners(without), rows, strict=True)
    for drawn, still, row in pairs:
        away = still - middle
        grown = np.nansum((drawn - middle) * away) / np.nansum(away**2)
        assert grown == pytest.approx(row["fx"] / ideal.fx, abs=1e-4)  # 0.03 px at the edge
        assert abs(grown - 1) > 5e-4


@pytest.mark.slow
def test_wandering_has_the_strength_that_was_asked_for_and_photos_differ() -> None:
    options = replace(
        FEW, photos=60, calibration_photos=60, faults=Faults(stabiliser_px=2.5, breathing=0.002)
    )
    truth, ideal = stage_truth(options), ideal_camera(options)
    for views in (truth.views, truth.calibration_views):
        lenses = np.array([view.camera.packed for view in views]) - ideal.packed
        assert lenses[:, 2:4].std() == pytest.approx(2.5, rel=0.25)
        assert (lenses[:, 0] / ideal.fx).std() == pytest.approx(0.002, rel=0.3)
        assert (lenses[:, 4:] == 0).all()
        assert len(np.unique(lenses[:, 2])) == 60
    assert truth.views[0].camera != truth.calibration_views[0].camera


@pytest.mark.slow
def test_a_rolling_shutter_draws_every_row_from_where_the_hand_was(
    without: Capture, tmp_path: Path
) -> None:
    faults = Faults(readout_s=0.02, hand_deg_s=6.0, hand_mm_s=60.0)
    faulty = make_capture(tmp_path / "limb", replace(FEW, faults=faults))
    truth = faulty.truth.calibration_board.corners_in_world()
    pairs = zip(faulty.truth.calibration_views, corners(faulty), corners(without), strict=True)
    for idx, (view, drawn, still) in enumerate(pairs):
        readout = readout_of(faults, FEW.height_px, FEW.seed, Session.CALIBRATION, idx)
        assert readout is not None
        told = [_by_rows(view, readout, point) for point in truth]
        np.testing.assert_allclose(np.nanmean(drawn - told, axis=0), 0.0, atol=0.02)
        assert mean_length(drawn - told) < 0.08  # what finding corners costs in an oblique photo
        assert mean_length(drawn - still) > 0.3


def _by_rows(view: View, readout: Readout, point: np.ndarray) -> np.ndarray:
    """Where a rolling shutter shows a point: found by bisection over the rows."""

    def shown(row: float) -> np.ndarray:
        placed = readout.at_row(row) @ view.camera_from_world
        return view.camera.project(placed.apply(point[None]))[0]

    low, high = -100.0, view.camera.height_px + 100.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shown(middle)[1] > middle else (low, middle)
    return shown(low)


def test_a_rolling_shutter_moves_the_limb_as_it_moves_the_board() -> None:
    truth = stage_truth(FEW)
    view = truth.views[0]
    readout = Readout(FEW.height_px, np.array([0.04, 0.0, 0.0]), np.zeros(3))
    light = light_of(Lighting(), view.camera_from_world, FEW.distance_mm, np.zeros(3))
    skin = np.full((2, 2, 4), 255, np.uint8)
    stage = RenderScene((_far_panel(),), truth.limb, None, skin)
    heights = []
    for read in (None, readout):
        lit = render(view, stage, light, 1, read)[..., 0] > 0.05
        heights.append(np.flatnonzero(lit.any(1))[[0, -1]])
    points = truth.limb.mesh.vertices_mm
    still = np.argsort(view.project(points)[:, 1])
    outermost = points[np.concatenate([still[:60], still[-60:]])]
    told = np.array([_by_rows(view, readout, point)[1] for point in outermost])
    assert heights[1][0] == pytest.approx(told.min(), abs=2.0)
    assert heights[1][1] == pytest.approx(min(told.max(), FEW.height_px - 1), abs=2.0)
    assert np.abs(heights[1] - heights[0]).max() > 4


def _far_panel() -> Panel:
    """Something to see that no camera here looks at."""
    black = np.zeros((2, 2, 3), np.uint8)
    up = np.array([0.0, 0.0, 5000.0])
    return Panel(up, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([1.0, 1.0]), black)


@pytest.mark.parametrize(
    "spoiled",
    [
        pytest.param({"sag_mm": 1.5}, marks=pytest.mark.slow),
        pytest.param({"stretch": 0.01}, marks=pytest.mark.slow),
        {"sag_mm": 0.8, "stretch": -0.004},
    ],
)
def test_a_spoiled_board_is_drawn_where_the_truth_has_its_corners(
    spoiled: dict[str, float], tmp_path: Path
) -> None:
    board = replace(CALIBRATION_BOARD, **spoiled)
    capture = make_capture(tmp_path / "limb", replace(FEW, calibration_board=board))
    places = capture.truth.calibration_board
    flat = replace(places, printed=CALIBRATION_BOARD).corners_in_world()
    for view, found in zip(capture.truth.calibration_views, corners(capture), strict=True):
        off = found - view.project(places.corners_in_world())
        np.testing.assert_allclose(np.nanmean(off, axis=0), 0.0, atol=0.02)
        assert mean_length(off) < 0.08
        assert mean_length(found - view.project(flat)) > 0.3


def test_a_bent_board_keeps_the_lengths_of_its_print_and_stands_up_by_its_sag() -> None:
    flat, bent = CALIBRATION_BOARD, replace(CALIBRATION_BOARD, sag_mm=0.5)
    along = np.linspace(0.0, flat.size_mm[0], 2001)
    curve = bent.bent_mm(along)
    assert np.linalg.norm(np.diff(curve, axis=0), axis=1).sum() == pytest.approx(along[-1])
    assert -curve[:, 1].min() == pytest.approx(0.5, rel=1e-3)
    np.testing.assert_allclose(curve[[0, -1], 1], 0.0, atol=1e-9)
    stretched = replace(CALIBRATION_BOARD, stretch=0.002).corners_mm()
    np.testing.assert_allclose(stretched, flat.corners_mm() * [1.0, 1.002, 1.0])


@pytest.mark.parametrize("wave_px", [3.0, 5.0, 9.0, 20.0])
def test_sharpening_raises_waves_by_its_transfer_function(wave_px: float) -> None:
    wave = np.sin(2 * np.pi * np.arange(360) / wave_px)
    picture = np.repeat((128 + 40 * wave)[None, :, None], 3, axis=2).repeat(30, axis=0)
    sharp = sharpened(np.rint(picture).astype(np.uint8), 0.8)[15, 20:-20, 1].astype(float)
    gain = (sharp - 128) @ wave[20:-20] / (wave[20:-20] @ wave[20:-20]) / 40
    blur = np.exp(-2 * np.pi**2 / wave_px**2)
    assert gain == pytest.approx(1 + 0.8 * (1 - blur), rel=0.015)


def test_noise_goes_down_and_edges_stay_where_noise_is_reduced() -> None:
    rng = np.random.default_rng(3)
    grey = np.where(np.arange(80) < 40, 60.0, 180.0)[None].repeat(60, axis=0)
    noisy = grey[..., None] + rng.normal(0, 3.0, (60, 80, 3))
    clean = denoised(np.clip(np.rint(noisy), 0, 255).astype(np.uint8), 1.0).astype(float)
    assert clean[5:-5, 5:35].std() < 0.6 * 3.0
    assert clean[:, 45:].mean() - clean[:, :35].mean() == pytest.approx(120, abs=1.5)
    assert clean[:, 40].mean() - clean[:, 39].mean() > 110


def test_what_is_out_of_focus_is_blurred_by_the_disc_of_its_depth() -> None:
    edge = np.where(np.arange(120) < 60, 0.0, 1.0).astype(np.float32)
    picture = np.repeat(edge[None, :, None], 3, axis=2).repeat(60, axis=0)
    near = np.full((60, 120), 1 / 400.0, np.float32)
    near[:20] = 1 / 500.0
    reach = 2.4 * 3000.0
    blurred = defocused(picture, near, 500.0, reach)
    np.testing.assert_array_equal(blurred[:18], picture[:18])
    spread = np.diff(blurred[45, :, 0].astype(float))
    at = np.arange(len(spread)) - (spread * np.arange(len(spread))).sum()
    radius = 0.5 * reach * (1 / 400 - 1 / 500)
    assert (spread * at**2).sum() == pytest.approx(radius**2 / 4, rel=0.05)
    assert (spread * at).sum() == pytest.approx(0.0, abs=1e-3)


def test_depth_is_that_of_the_limb_and_of_the_table() -> None:
    truth = stage_truth(STAGE)
    view = truth.views[0]
    panels = make_room(FEW.seed, under_stand=True)[:1]
    near = inverse_depth_of(view, RenderScene(panels, truth.limb))
    points = surface_points(truth, 200)
    in_camera = view.camera_from_world.apply(points.points_in_world[points.seen[:, 0]])
    at = np.rint(view.camera.project(in_camera)).astype(int)
    depth = 1 / near[at[:, 1], at[:, 0]]
    assert np.median(np.abs(depth - in_camera[:, 2])) < 1.0
    on_table = np.array([[0.0, -130.0, 0.0], [140.0, 0.0, 0.0], [-120.0, 90.0, 0.0]])
    shown = view.camera_from_world.apply(on_table)
    xy = np.rint(view.project(on_table)).astype(int)
    clear = ~silhouette(view, truth.limb)[xy[:, 1], xy[:, 0]]
    assert clear.any()
    np.testing.assert_allclose(
        1 / near[xy[clear, 1], xy[clear, 0]], shown[clear, 2], rtol=1e-3, atol=1.0
    )


def test_the_lamps_part_and_the_rest_add_up_to_the_whole_light() -> None:
    view = stage_truth(STAGE).views[0]
    stage = RenderScene(make_room(FEW.seed, under_stand=True))
    light = light_of(Lighting(), view.camera_from_world, FEW.distance_mm, np.zeros(3))
    lamp = light._replace(ambient=0.0, flash_strength=0.0)
    rest = light._replace(lamp_strength=0.0)
    whole, *parts = (render(view, stage, one, 1) for one in (light, lamp, rest))
    np.testing.assert_allclose(parts[0] + parts[1], whole, atol=1e-5)


def test_cloth_slides_down_its_open_end_and_the_shape_stays() -> None:
    limb = stage_truth(STAGE).limb
    slid = crept(limb, 0.3, FEW.seed)
    assert slid.mesh is limb.mesh
    moved = (slid.chart - limb.chart)[..., 1]
    at = limb.chart.astype(int)
    height = (limb.grid_mm[at[..., 1], at[..., 0], 2] - limb.base_mm) / limb.height_mm
    np.testing.assert_array_equal((slid.chart - limb.chart)[..., 0], 0.0)
    sides = (height > 0.15) & (height < 0.25)
    by_mm = moved[sides] * 3.0  # rows of the chart are about 3 mm apart
    assert 0.2 < by_mm.max() < 0.3
    assert 0.05 < by_mm.min() < 0.12
    assert moved[height > 0.999].max() < 1e-3


def test_loose_things_move_as_wholes_and_the_table_stays() -> None:
    room = make_room(FEW.seed, under_stand=True)
    first, again, second = (shifted_about(room, 30.0, FEW.seed, k) for k in (0, 0, 1))
    for before, one, same, other in zip(room, first, again, second, strict=True):
        np.testing.assert_array_equal(one.origin, same.origin)
        moved = np.linalg.norm(one.origin - other.origin)
        assert (moved > 0.1) == bool(before.loose)
    boxes = [one.loose for one in room if [two.loose for two in room].count(one.loose) == 5]
    assert len(boxes) == 20
    for box in set(boxes) - {0}:
        apart = [[one.origin for one in panels if one.loose == box] for panels in (room, first)]
        still, gone = (np.linalg.norm(np.diff(one, axis=0), axis=1) for one in apart)
        np.testing.assert_allclose(still, gone)


def test_a_photo_that_is_stored_again_has_the_second_quality_and_its_exif(
    tmp_path: Path,
) -> None:
    once = replace(FEW, photos=3, calibration_photos=0, width_px=240, height_px=160)
    twice = replace(once, faults=Faults(stored_again=70))
    first, second = (
        make_capture(tmp_path / name, options).photos[0]
        for name, options in (("once", once), ("twice", twice))
    )
    with Image.open(first) as one, Image.open(second) as two:
        assert isinstance(one, JpegImageFile)
        assert isinstance(two, JpegImageFile)
        told = io.BytesIO()
        two.convert("RGB").save(told, "JPEG", quality=70)
        with Image.open(told) as known:
            assert isinstance(known, JpegImageFile)
            assert two.quantization == known.quantization
        assert two.quantization != one.quantization
        assert two.getexif().get_ifd(0x8769)[0x920A] == one.getexif().get_ifd(0x8769)[0x920A]
        off = np.asarray(one.convert("L"), float) - np.asarray(two.convert("L"), float)
    assert 0.3 < off.std() < 8


def test_exposure_and_colours_wander_by_what_was_asked_for() -> None:
    faults = Faults(exposure_ev=0.2, tint=0.05)
    factors = np.array([exposure_of(faults, 5, Session.RING, k) for k in range(300)])
    assert np.log2(factors[:, 1]).std() == pytest.approx(0.2, rel=0.12)
    assert (factors[:, 0] / factors[:, 1]).std() == pytest.approx(0.05, rel=0.12)
    assert (exposure_of(Faults(), 5, Session.RING, 0) == 1.0).all()


def test_one_fault_does_not_change_another() -> None:
    alone = stage_truth(replace(STAGE, faults=Faults(stabiliser_px=2.0)))
    both = stage_truth(replace(STAGE, faults=Faults(stabiliser_px=2.0, breathing=0.001)))
    for one, other in zip(alone.views, both.views, strict=True):
        assert (one.camera.cx, one.camera.cy) == (other.camera.cx, other.camera.cy)
        np.testing.assert_array_equal(
            one.camera_from_world.matrix_3x4, other.camera_from_world.matrix_3x4
        )


def test_a_fault_of_negative_strength_is_refused() -> None:
    with pytest.raises(OptionsError, match="0 or more"):
        Faults(stabiliser_px=-1.0)
