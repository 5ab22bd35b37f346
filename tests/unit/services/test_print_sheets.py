"""What a pixel shows of the limb: said in one way, or refused."""

from dataclasses import replace
from pathlib import Path

import pytest

from limbgram.core.errors import OptionsError
from limbgram.services.print_sheets import PrintRequest

BY_FILM = PrintRequest(distance_mm=500, focal_35mm=26, width_px=4000)
CAMERA = Path("camera.json")


def test_what_a_pixel_shows_follows_from_distance_and_lens() -> None:
    assert BY_FILM.options().pixel_mm == pytest.approx(500 * 36 / (26 * 4000))


@pytest.mark.parametrize(
    "asked",
    [
        replace(BY_FILM, pixel_mm=0.2),
        replace(BY_FILM, camera=CAMERA),
        replace(BY_FILM, width_px=None),
        PrintRequest(distance_mm=500),
        PrintRequest(distance_mm=500, camera=CAMERA, focal_35mm=26),
        PrintRequest(distance_mm=500, camera=CAMERA, width_px=4000),
    ],
)
def test_a_lens_that_is_told_twice_or_by_half_is_refused(asked: PrintRequest) -> None:
    with pytest.raises(OptionsError) as refusal:
        asked.options()
    assert refusal.value.finding.code == "options.print.pixel"
