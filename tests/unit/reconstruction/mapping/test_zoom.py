"""Photos that were zoomed are found by their points alone, and no others."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from limbgram.core.geometry.lens import LENS_SIZE, Camera
from limbgram.findings import told
from limbgram.reconstruction.calibration.cameras import Calibration, Cameras
from limbgram.reconstruction.mapping.bundle_adjustment import adjust
from limbgram.reconstruction.mapping.placement import MappingOptions, readjusted
from limbgram.reconstruction.mapping.scene import Observations, OwnLenses, PhotoVerdict, Scene
from limbgram.reconstruction.mapping.zoom import (
    FocalFit,
    _outliers,
    focal_fits,
    odd_focals,
    zoomed_by_solved_focals,
)

Maker = Callable[..., Scene]
LENS = Camera(width_px=900, height_px=700, fx=1500.0, fy=1490.0, cx=450.0, cy=345.0, k1=-0.08)


def zoomed(scene: Scene, photo: int, zoom: float) -> Scene:
    """One photo enlarged about its principal point, as a digital zoom does."""
    seen = scene.observations
    xy_px = seen.xy_px.copy()
    rows = seen.photo_idx == photo
    middle = np.array([LENS.cx, LENS.cy])
    xy_px[rows] = middle + zoom * (xy_px[rows] - middle)
    return replace(scene, observations=Observations(seen.photo_idx, seen.point_idx, xy_px))


def adjusted(scene: Scene) -> Scene:
    return adjust(scene, calibrated(LENS).calibrations).scene


def calibrated(camera: Camera) -> Cameras:
    covariance = np.diag([1.0, 1.0, 1.0, 1.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 0.0])
    return Cameras((Calibration(camera=camera, covariance=covariance, source="board"),))


def with_verdicts(scene: Scene) -> Scene:
    fine = [PhotoVerdict(name=name, placed=True, points=1, rms_px=0.1) for name in scene.names]
    return replace(scene, verdicts=tuple(fine))


@pytest.fixture
def ring(make_scene: Maker) -> Scene:
    return make_scene(photos=15, points=600, noise_px=0.1, share=0.5, lenses=(LENS,))


@pytest.mark.parametrize("zoom", [1.0, 1.01, 0.97])
def test_on_true_points_the_zoom_comes_back_with_its_sigma(ring: Scene, zoom: float) -> None:
    fits = focal_fits(zoomed(ring, 4, zoom))
    offs = [
        (fit.ratio - (zoom if k == 4 else 1.0)) / fit.sigma for k, fit in enumerate(fits) if fit
    ]
    assert len(offs) == 15
    assert np.abs(offs).max() < 1.5  # sigmas are three times those of independent errors
    assert np.abs(offs).max() > 0.1


def test_a_zoomed_photo_is_named_after_the_adjustment_and_no_other(ring: Scene) -> None:
    assert odd_focals(adjusted(ring)) == {}
    found = odd_focals(adjusted(zoomed(ring, 4, 1.03)))
    assert list(found) == [4]
    assert "longer than that of the other photos" in told(found[4])
    assert "shorter" in told(odd_focals(adjusted(zoomed(ring, 7, 0.97)))[7])


@pytest.mark.parametrize(("off", "sigma", "odd"), [(0.02, 0.003, False), (0.02, 0.0003, True)])
def test_a_photo_that_tells_its_zoom_badly_may_be_off_as_much_more(
    off: float, sigma: float, odd: bool
) -> None:
    """The others are off by five of their sigmas, as on a sheet that bends."""
    others = [FocalFit(1.0 + 0.0015 * (-1) ** k, 0.0003) for k in range(14)]
    assert (14 in _outliers([*others, FocalFit(1.0 + off, sigma)], 5.0)) == odd


@pytest.mark.parametrize(
    "zoom", [1.02, *(pytest.param(one, marks=pytest.mark.slow) for one in (1.06, 0.94))]
)
def test_zoomed_neighbours_are_both_named_and_set_aside(ring: Scene, zoom: float) -> None:
    """Each of them bends the points that both see, so by itself neither stands out enough."""
    known, ring = calibrated(LENS), with_verdicts(ring)
    assert not any(one.reason for one in readjusted(ring, known, MappingOptions()).verdicts)
    found = readjusted(zoomed(zoomed(ring, 4, zoom), 5, zoom), known, MappingOptions())
    named = {k: one.reason for k, one in enumerate(found.verdicts) if one.reason}
    assert list(named) == [4, 5]
    way = "longer" if zoom > 1 else "shorter"
    assert all(f"{way} than that of the other photos" in told(one) for one in named.values())
    assert not {4, 5} & {*found.placed}
    assert not any(one.remark for one in found.verdicts)


@pytest.mark.parametrize(
    "zoom", [1.05, *(pytest.param(one, marks=pytest.mark.slow) for one in (1.2, 0.95))]
)
@pytest.mark.parametrize(
    "photos",
    [
        pytest.param(range(7), id="half of a walk"),
        pytest.param(range(1, 15, 2), id="every other", marks=pytest.mark.slow),
    ],
)
def test_half_of_the_photos_zoomed_are_named_and_used(
    ring: Scene, zoom: float, photos: range
) -> None:
    """Too many to be set aside: their focal lengths are found, and the poses stay true."""
    changed = with_verdicts(ring)
    for photo in photos:
        changed = zoomed(changed, photo, zoom)
    found = readjusted(changed, calibrated(LENS), MappingOptions())
    assert found.placed == ring.placed
    assert [k for k, one in enumerate(found.verdicts) if one.remark] == [*photos]
    factors = [view.camera.fx / found.cameras[0].fx for view in found.views]
    wanted = [zoom if k in photos else 1.0 for k in range(len(ring.names))]
    assert np.abs(np.array(factors) / wanted - 1.0).max() < 0.01
    assert zoomed_by_solved_focals(found).keys() == {*photos}


def longer(shares: np.ndarray) -> np.ndarray:
    """Shifts of photos' lenses whose focal length differs by these shares of itself."""
    shifts = np.zeros((len(shares), LENS_SIZE))
    shifts[:, 0], shifts[:, 1] = shares * LENS.fx, shares * LENS.fy
    return shifts


def test_a_zoom_is_told_in_parts_of_the_solved_focal_length(ring: Scene) -> None:
    """Not in parts of one that was guessed, in which a zoom of 5 % counts as 7 %."""
    shares = np.where(np.arange(15) < 7, 0.05, 0.0)
    own = OwnLenses(
        deviations=("focal length",),
        values=(shares * LENS.fx / (1.2 * LENS.width_px))[:, None],
        spread=np.array([0.03]),
        shifts=longer(shares),
        chances=(1e-9,),
    )
    changed = ring
    for photo in range(7):
        changed = zoomed(changed, photo, 1.05)
    found = zoomed_by_solved_focals(replace(changed, own=own))
    assert [one.values["share"] for one in found.values()] == pytest.approx([0.05] * 7, abs=1e-3)


@pytest.mark.parametrize(("noise_px", "named"), [(0.0, {4}), (60.0, set())])
def test_a_solved_focal_length_that_nothing_holds_is_no_zoom(
    ring: Scene, noise_px: float, named: set[int]
) -> None:
    """Solved for from points that barely tell it; 3 % off, where it tells them to 1 %."""
    values = 0.0005 * np.random.default_rng(5).normal(size=(15, 1))
    values[4] = 0.03
    own = OwnLenses(
        deviations=("focal length",),
        values=values,
        spread=np.array([0.01]),
        shifts=longer(values[:, 0]),
        chances=(1e-9,),
    )
    seen = ring.observations
    theirs = (seen.photo_idx == 4)[:, None]
    noise = np.where(theirs, np.random.default_rng(6).normal(0, noise_px, seen.xy_px.shape), 0.0)
    changed = Observations(seen.photo_idx, seen.point_idx, seen.xy_px + noise)
    found = zoomed_by_solved_focals(replace(ring, observations=changed, own=own))
    assert found.keys() == named


def test_the_file_of_another_camera_is_no_zoom(ring: Scene) -> None:
    """All photos differ from it alike; nobody zoomed."""
    file = calibrated(replace(LENS, fx=1.06 * LENS.fx, fy=1.06 * LENS.fy))
    found = readjusted(with_verdicts(ring), file, MappingOptions())
    assert not any(one.remark or one.reason for one in found.verdicts)
    assert zoomed_by_solved_focals(found) == {}


def test_photos_with_few_points_are_not_judged(make_scene: Maker) -> None:
    scene = make_scene(photos=6, points=20, lenses=(LENS,))
    assert focal_fits(scene) == (None,) * 6
