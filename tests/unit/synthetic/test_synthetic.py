"""Options, paint, poses and files of synthetic captures."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from limbgram.core.errors import Cancelled, CaseError, OptionsError
from limbgram.core.run import Run
from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.board import SCALE_BOARD, PrintedBoard
from limbgram.synthetic.props.limb import LimbKind, Relief, make_limb
from limbgram.synthetic.props.paint import (
    MAGENTA,
    Paint,
    Painting,
    SockSpot,
    bake,
    places_mm,
)
from limbgram.synthetic.truth import stage_truth, surface_points

TINY = CaptureOptions(photos=4, width_px=240, height_px=160, calibration_photos=2, mesh_step_mm=3.0)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    return make_capture(tmp_path_factory.mktemp("made") / "tiny", TINY)


def test_the_same_options_give_the_same_bytes_on_one_thread_and_on_many(
    tiny: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = contents(tiny.folder)
    monkeypatch.setattr("limbgram.core.run.worker_count", lambda: 1)
    second = contents(make_capture(tmp_path / "b", TINY).folder)
    other = contents(make_capture(tmp_path / "c", replace(TINY, seed=12)).folder)
    assert len(first) == 4 + 4 + 2 + 4
    assert first == second
    assert all(first[name] != other[name] for name in first)


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    with pytest.raises(CaseError, match="there already"):
        make_capture(tmp_path / "a", TINY)
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]


def test_a_cancelled_capture_leaves_nothing(tmp_path: Path) -> None:
    run = Run()
    run.listener = lambda _stage, done, total: run.cancel() if 0 < done < total else None
    with pytest.raises(Cancelled):
        run(make_capture, tmp_path / "a", TINY)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "change",
    [
        {"photos": 2},
        {"rings": 4},
        {"elevations_deg": (28.0, 2.0)},
        {"elevations_deg": (-40.0,)},
        {"coverage": 0.95},
        {"distance_mm": 100.0},
        {"shaken": (4,)},
        {"noise": -1.0},
        {"mesh_step_mm": 0.0},
    ],
)
def test_captures_that_cannot_be_made_are_refused(change: dict) -> None:
    with pytest.raises(OptionsError, match="cannot be made"):
        replace(TINY, **change)


def test_a_lens_focused_within_its_reach_is_refused() -> None:
    with pytest.raises(OptionsError, match="Step back"):
        stage_truth(replace(TINY, lens=Lens(focal_mm=300.0), distance_mm=550.0))


@pytest.mark.parametrize("kind", list(LimbKind))
def test_limbs_are_closed_and_of_human_size(kind: LimbKind) -> None:
    limb = make_limb(kind, 5, 4.0, 60.0)
    corners = limb.mesh.vertices_mm[limb.mesh.faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    edges = limb.mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    directed = set(map(tuple, edges.tolist()))
    assert len(directed) == len(edges)
    assert all((b, a) in directed for a, b in directed)
    assert 0.8e6 < volume < 5e6
    assert 180 < limb.height_mm < 300
    assert limb.mesh.vertices_mm[:, 2].min() == pytest.approx(60.0)
    assert np.ptp(limb.mesh.vertices_mm[limb.cut, 2]) < 1e-3


def test_a_limb_is_the_same_at_every_mesh_step() -> None:
    fine = make_limb(LimbKind.TRANSTIBIAL, 5, 1.0, 60.0)
    coarse = make_limb(LimbKind.TRANSTIBIAL, 5, 2.5, 60.0)
    assert fine.height_mm == pytest.approx(coarse.height_mm, abs=0.3)
    for axis in range(2):
        spans = [np.ptp(limb.mesh.vertices_mm[:, axis]) for limb in (fine, coarse)]
        assert spans[0] == pytest.approx(spans[1], abs=0.3)


def test_relief_is_as_high_and_as_fine_as_asked_for() -> None:
    def lifted_mm(relief: Relief) -> np.ndarray:
        rough = make_limb(LimbKind.TRANSTIBIAL, 5, 1.0, 60.0, relief=relief).mesh
        return np.einsum("ni,ni->n", rough.vertices_mm - smooth.vertices_mm, outward)

    smooth = make_limb(LimbKind.TRANSTIBIAL, 5, 1.0, 60.0, relief=Relief(rms_mm=0.0)).mesh
    outward = smooth.vertex_normals()
    usual, fine = lifted_mm(Relief()), lifted_mm(Relief(finest_mm=2.5))
    assert np.sqrt(np.mean(usual**2)) == pytest.approx(0.2, rel=0.15)
    assert np.sqrt(np.mean(fine**2)) == pytest.approx(0.2, rel=0.15)
    ends = smooth.faces[:, :2]
    steep = [np.abs(np.diff(lift[ends], axis=1)).mean() for lift in (usual, fine)]
    assert steep[1] > 1.2 * steep[0]


@pytest.mark.parametrize("coverage", [0.2, 0.55])
def test_paint_covers_the_share_that_was_asked_for(coverage: float) -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 5, 2.0, 60.0)
    painted = bake(limb, Painting(Paint.DABS, coverage), 5, 0.4)[200:-200, :, 3] > 20
    assert painted.mean() == pytest.approx(coverage, abs=0.05)
    assert not (bake(limb, Painting(Paint.NONE, coverage), 5, 0.4)[..., 3] > 20).any()


def test_paint_is_left_out_in_patches() -> None:
    """Half of the dabs go, and what they leave bare hangs together."""
    limb = make_limb(LimbKind.TRANSTIBIAL, 5, 2.0, 60.0)
    even, patchy = (
        bake(limb, Painting(Paint.DABS, coverage, bare=bare), 5, 0.8)[100:-100, :, 3] > 20
        for coverage, bare in ((0.5, 0.0), (0.5, 0.5))
    )
    assert patchy.mean() < 0.75 * even.mean()
    rows, columns = (size // 20 * 20 for size in even.shape)
    blocks = [
        one[:rows, :columns].reshape(rows // 20, 20, columns // 20, 20).mean((1, 3))
        for one in (even, patchy)
    ]
    assert np.mean(blocks[0] < 0.02) < 0.05
    assert np.mean(blocks[1] < 0.02) > 0.2
    np.testing.assert_array_equal(patchy & ~even, False)


def test_wrinkles_are_as_high_as_long_waves() -> None:
    smooth = make_limb(LimbKind.TRANSTIBIAL, 5, 1.0, 60.0, relief=Relief(rms_mm=0.0)).mesh
    ends, steep = smooth.faces[:, :2], []
    for growth in (0.7, 0.0):
        limb = make_limb(LimbKind.TRANSTIBIAL, 5, 1.0, 60.0, relief=Relief(growth=growth)).mesh
        away = limb.vertices_mm - smooth.vertices_mm
        lift = np.einsum("ij,ij->i", away, smooth.vertex_normals())
        steep.append(np.abs(np.diff(lift[ends], axis=1)).mean())
    assert steep[1] > 1.4 * steep[0]


@pytest.mark.slow
def test_a_plain_sock_shows_next_to_nothing_to_match(tmp_path: Path) -> None:
    options = replace(TINY, width_px=720, height_px=480, photos=3, calibration_photos=0)
    counts: dict[Paint, int] = {}
    for paint in Paint:
        capture = make_capture(tmp_path / paint.value, replace(options, paint=paint))
        path = capture.photos[0]
        mask = cv2.imread(str(capture.folder / "truth/masks" / f"{path.stem}.png"), 0)
        inside = cv2.erode(mask, np.ones((9, 9), np.uint8))
        counts[paint] = len(cv2.SIFT_create().detect(cv2.imread(str(path), 0), inside))
    assert min(counts[Paint.DABS], counts[Paint.PRINT]) > 600
    assert counts[Paint.NONE] < counts[Paint.DABS] // 20


def test_a_shaken_photo_is_less_sharp_and_the_others_stay_as_they_were(
    tiny: Capture, tmp_path: Path
) -> None:
    moved = make_capture(tmp_path / "moved", replace(TINY, shaken=(1,)))
    sharp, soft = (
        cv2.Laplacian(cv2.imread(str(c.photos[1]), 0), cv2.CV_64F).var() for c in (tiny, moved)
    )
    assert soft < 0.3 * sharp
    assert tiny.photos[0].read_bytes() == moved.photos[0].read_bytes()


def test_surface_points_lie_in_the_pictures_that_see_them() -> None:
    truth = stage_truth(TINY)
    points = surface_points(truth, 500, seed=3)
    assert points.points_in_world.shape == (500, 3)
    np.testing.assert_allclose(np.linalg.norm(points.normals_in_world, axis=1), 1.0, atol=1e-9)
    assert (points.seen.sum(1) >= 2).all()
    for k, view in enumerate(truth.views):
        rows = points.seen[:, k]
        assert 50 < rows.sum() < 450
        assert view.camera.contains(view.project(points.points_in_world[rows])).all()
        toward = view.centre_in_world - points.points_in_world[rows]
        assert ((toward * points.normals_in_world[rows]).sum(1) > 0).all()


def test_the_walk_goes_all_the_way_round_at_several_heights() -> None:
    truth = stage_truth(replace(TINY, photos=24, rings=2))
    centres = np.array([view.centre_in_world for view in truth.views])
    angles = np.sort(np.degrees(np.arctan2(centres[:15, 1], centres[:15, 0])))
    steps = np.diff(np.append(angles, angles[0] + 360))
    assert 8 < steps.min() < steps.max() < 40
    assert centres[15:, 2].min() > centres[:15, 2].max()


def test_a_ring_can_be_walked_as_low_as_the_limb_stands() -> None:
    usual = stage_truth(replace(TINY, photos=24, rings=3))
    low = stage_truth(replace(TINY, photos=24, rings=3, elevations_deg=(28.0, 50.0, 2.0)))
    distance_mm = TINY.distance_mm
    heights = np.array([view.centre_in_world[2] for view in low.views])
    before = np.array([view.centre_in_world[2] for view in usual.views])
    # The third ring stands 2 degrees over the limb's middle where it stood 40, each by up to 6.
    fallen = (before - heights)[-7:] / distance_mm
    assert fallen.min() > np.sin(np.radians(27)) - 0.05
    assert fallen.max() < np.sin(np.radians(48)) + 0.05
    np.testing.assert_array_equal(before[:-7], heights[:-7])


def test_a_board_printed_too_large_is_larger_in_truth_and_not_in_name() -> None:
    printed = PrintedBoard(SCALE_BOARD.board, print_scale=1.03)
    np.testing.assert_allclose(printed.corners_mm(), 1.03 * SCALE_BOARD.board.corners_mm)
    truth = stage_truth(replace(TINY, board=printed))
    assert truth.board is not None
    corners = truth.board.corners_in_world()
    assert np.linalg.norm(corners[1] - corners[0]) == pytest.approx(30.9)
    assert truth.board.printed.board.square_mm == 30.0
    assert stage_truth(replace(TINY, board=None)).board is None


def test_a_spot_once_all_the_way_round_is_where_it_began() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 5, 2.0, 60.0)
    begun, round_again = (
        bake(limb, Painting(Paint.NONE, 0.9, (SockSpot(around=around, height=0.5),)), 5, 0.4)
        for around in (0.0, 1.0)
    )
    np.testing.assert_array_equal(begun, round_again)


def test_a_spot_near_a_place_lies_there() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 5, 2.0, 60.0)
    row, column = len(limb.grid_mm) // 3, 11
    beside = limb.grid_mm[row, column] + 0.3
    spot = SockSpot(near_mm=tuple(beside.tolist()), diameter_mm=8.0)
    (place,) = places_mm(limb, (spot,))
    np.testing.assert_allclose(place, limb.grid_mm[row, column])
    texture = bake(limb, Painting(Paint.NONE, 0.9, (spot,)), 5, 0.4)
    fine = (len(texture) - 1) // (len(limb.grid_mm) - 1)
    assert tuple(texture[row * fine, column * fine, :3]) == MAGENTA
    painted = (texture[..., :3] == MAGENTA).all(2)
    texels = np.argwhere(painted).mean(0) / fine
    np.testing.assert_allclose(texels, (row, column), atol=0.2)


def test_a_printed_sock_lies_round_the_limb_without_a_seam() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 3, 3.0, 20.0)
    texture = bake(limb, Painting(Paint.PRINT, 0.5), 3, 1.0, pixel_mm=0.8)[..., :3].astype(int)
    assert (texture[:, 0] == texture[:, -1]).all()
    tube = texture[len(texture) // 4 : len(texture) // 2]
    dark = (tube.sum(2) < 300).mean()
    assert 0.3 < dark < 0.5
    beside = np.abs(tube[:, 1] - tube[:, -2]).mean()  # over the seam, as over any two columns
    within = np.abs(tube[:, 20] - tube[:, 22]).mean()
    assert beside < 1.6 * within
    assert np.abs(tube[:, 0] - tube[:, tube.shape[1] // 3]).mean() > 1.5 * beside
