"""Constants that other programs, tables or papers state: each against its source."""

import json
import math

import pytest
from scipy.stats import norm

from limbgram.core.errors import RED_EXIT_CODE, UNDECIDED_EXIT_CODE
from limbgram.core.files import ContentError, json_of
from limbgram.core.geometry.lens import FROM_CORNER_PX
from limbgram.core.interval import COVER, MAD_TO_SIGMA, widening
from limbgram.core.tape import (
    AGREES_SIGMAS,
    CONTRADICTS_SIGMAS,
    PLACING_SIGMA_MM,
    read_girth,
    tape_sigma_mm,
)
from limbgram.core.units import MM3_PER_ML, MM_PER_INCH


def test_intervals_are_those_of_a_gaussian() -> None:
    assert norm.cdf(COVER) - norm.cdf(-COVER) == pytest.approx(0.95, abs=1e-5)
    assert pytest.approx(1 / norm.ppf(0.75), abs=1e-4) == MAD_TO_SIGMA
    assert COVER * widening(5) == pytest.approx(2.571, abs=1e-3)  # Student's table


def test_units_are_those_of_their_definition() -> None:
    assert pytest.approx(254) == 10 * MM_PER_INCH
    assert MM3_PER_ML == 10.0**3  # a millilitre is a cubic centimetre
    assert FROM_CORNER_PX + FROM_CORNER_PX == 1.0


def test_a_tape_repeats_within_a_per_cent_of_a_girth() -> None:
    """Commean et al. 1996: 3 mm on 300 mm, two standard deviations."""
    girth_mm, sigma_mm = read_girth("300")
    assert 2 * sigma_mm == 0.01 * girth_mm
    assert tape_sigma_mm(1.5, 2.0) == 2.5
    assert 2 * sigma_mm == PLACING_SIGMA_MM


def test_a_right_surface_disagrees_in_5_readings_of_100_and_four_sigmas_are_three_plies() -> None:
    assert math.erf(AGREES_SIGMAS / math.sqrt(2)) == pytest.approx(0.95, abs=0.005)
    assert CONTRADICTS_SIGMAS * read_girth("350")[1] == 6.0


def test_commands_end_as_their_users_know() -> None:
    assert (RED_EXIT_CODE, UNDECIDED_EXIT_CODE) == (7, 8)


def test_a_tree_is_as_deep_as_64_levels() -> None:
    assert json_of(_nested(63)) == json.loads(_nested(63))
    with pytest.raises(ContentError):
        json_of(_nested(64))


def _nested(levels: int) -> bytes:
    return b"[" * levels + b"1" + b"]" * levels
