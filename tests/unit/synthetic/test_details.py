"""Knit, veins, scars and wrinkles are as high, as wide and as far apart as they are said to be."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.limb import Limb, LimbKind, make_limb
from limbgram.synthetic.props.paint import Paint, Painting, bake

STEP_MM = 0.5
SEED = 5


@cache
def plain_limb(step_mm: float) -> Limb:
    return make_limb(LimbKind.TRANSTIBIAL, SEED, step_mm, 60.0)


def raised_mm(details: SkinDetails, step_mm: float = STEP_MM) -> np.ndarray:
    """Of every point of the skin's rings, outwards."""
    plain = plain_limb(step_mm)
    other = make_limb(LimbKind.TRANSTIBIAL, SEED, step_mm, 60.0, details=details)
    assert (plain.mesh.faces == other.mesh.faces).all()
    moved = other.mesh.vertices_mm - plain.mesh.vertices_mm
    out = np.einsum("ij,ij->i", moved, plain.normals)
    skin = out[~plain.cut][:-1].reshape(-1, plain.grid_mm.shape[1] - 1)
    return skin[2:-2]


def runs_mm(marked: np.ndarray) -> np.ndarray:
    """Lengths of what is marked along one column."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(int), [0]])))
    return STEP_MM * (edges[1::2] - edges[::2])


def test_a_knit_has_its_height_and_its_period() -> None:
    knit = raised_mm(SkinDetails(knit_mm=0.1, knit_period_mm=2.0))
    tube = knit[: len(knit) // 2]
    assert tube.max() == pytest.approx(0.05, abs=0.006)
    assert tube.min() == pytest.approx(-0.05, abs=0.006)
    spectrum = np.abs(np.fft.rfft(tube, axis=0)).mean(1)
    waves = len(tube) * STEP_MM / np.arange(1, len(spectrum))
    assert waves[np.argmax(spectrum[1:])] == pytest.approx(2.0, rel=0.08)


@pytest.mark.slow
def test_veins_stand_out_and_scars_lie_deep_and_most_of_the_skin_is_left_alone() -> None:
    veins = raised_mm(SkinDetails(veins_mm=0.7))
    assert 0.4 < veins.max() <= 0.71
    assert veins.min() > -0.02
    assert 0.02 < (veins > 0.1).mean() < 0.15
    scars = raised_mm(SkinDetails(scars_mm=0.6))
    assert -0.61 < scars.min() < -0.5
    assert scars.max() < 0.02
    assert 0.001 < (scars < -0.1).mean() < 0.03


def test_wrinkles_are_folds_round_the_limb_above_the_cut() -> None:
    folds = raised_mm(SkinDetails(wrinkles_mm=1.2))
    assert folds.max() == pytest.approx(1.2, abs=0.03)
    rows = len(folds)
    assert folds[rows * 2 // 3 :].max() < 0.05
    column = int(np.argmax(folds.max(0)))
    band = folds[: rows // 2, column]
    gaps = runs_mm(band > 0.25 * 1.2)
    assert len(gaps) >= 2
    assert gaps.max() < 15.0
    around, along = (np.abs(np.diff(folds, axis=k)).mean() for k in (1, 0))
    assert around < 0.3 * along


def test_each_kind_is_the_same_with_the_others() -> None:
    alone = [
        raised_mm(one, 1.0) for one in (SkinDetails(veins_mm=0.7), SkinDetails(wrinkles_mm=1.0))
    ]
    both = raised_mm(SkinDetails(veins_mm=0.7, wrinkles_mm=1.0), 1.0)
    np.testing.assert_allclose(both, alone[0] + alone[1], atol=1e-4)  # float32 in the grid


def test_details_need_a_mesh_that_carries_them() -> None:
    with pytest.raises(OptionsError, match=r"edges of 0\.375 mm or less"):
        CaptureOptions(details=SkinDetails(knit_mm=0.1))
    fine = CaptureOptions(details=SkinDetails(knit_mm=0.1), mesh_step_mm=0.375)
    assert fine.details.any
    with pytest.raises(OptionsError, match="0 to 3 mm high"):
        replace(fine, details=SkinDetails(veins_mm=4.0))


def test_uneven_paint_is_thin_on_one_side() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, SEED, 2.0, 60.0)
    even, uneven = (
        bake(limb, Painting(Paint.DABS, 0.5, uneven=share), SEED, 0.8)[100:-100, :, 3] > 20
        for share in (0.0, 0.9)
    )
    eighths = [
        np.array([part.mean() for part in np.array_split(one, 8, axis=1)]) for one in (even, uneven)
    ]
    left = eighths[1] / eighths[0]
    assert left.min() < 0.3
    assert left.max() > 0.85
    opposite = (int(np.argmin(left)) + 4) % 8
    assert left[opposite] > 0.75
