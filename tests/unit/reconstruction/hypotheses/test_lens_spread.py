"""Spread of lens deviations: found as it was, and nought where lenses do not differ."""

from collections.abc import Callable
from typing import Any

import numpy as np

from limbgram.reconstruction.hypotheses.lens_spread import lens_spread
from limbgram.reconstruction.mapping.lens_equations import MAX_SPREAD, USUAL_SPREAD

Take = Callable[..., Any]
N = 24


def test_lenses_of_one_kind_show_no_spread(take: Take) -> None:
    found = lens_spread(take(photos=N, noise_px=0.05).equations) / USUAL_SPREAD
    assert (found[:2] < 0.2).all()  # stabiliser
    assert (found[3:7] < 0.3).all()  # rolling shutter


def test_a_phone_shows_its_spread(take: Take) -> None:
    own = np.random.default_rng(4).normal(size=(N, 9)) * USUAL_SPREAD
    found = lens_spread(take(photos=N, own=own, noise_px=0.05).equations)
    true = own.std(axis=0)
    assert (found[:7] / true[:7] > 0.2).all(), "a part of them counts as noise"
    assert (found[:7] / true[:7] < 2.0).all()


def test_no_spread_is_larger_than_that_of_cameras(take: Take) -> None:
    """A limb that moves is not to vanish in lenses that no camera has."""
    motions = np.zeros((N, 6))
    motions[:, 3:] = np.random.default_rng(1).normal(0.0, 15.0, (N, 3))
    found = lens_spread(take(photos=N, motions=motions).equations)
    assert (found <= MAX_SPREAD * (1 + 1e-9)).all()
