"""Plates of two dictionaries: each is measured by its own marks."""

from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from limbgram.core.run import Run
from limbgram.reconstruction.calibration.cameras import cameras_for
from limbgram.reconstruction.photos.reading import read_photos
from limbgram.reconstruction.pipeline import plate_distances
from limbgram.reconstruction.targets.board import KIT_DICTIONARY, marker_dictionary
from limbgram.reconstruction.targets.marks import DEFAULTS
from limbgram.reconstruction.targets.plates import MarkPlate, PrintedMark

SIDE_PX = 80
CORNERS_PX = {
    KIT_DICTIONARY: {5: (60, 60), 6: (400, 60)},
    "4X4_50": {5: (60, 260), 6: (400, 260)},
}
"""Left and top of each mark in the first photo."""


def test_marks_of_one_number_in_two_dictionaries_are_not_confused(tmp_path: Path) -> None:
    for k in range(2):
        picture = np.full((400, 560), 230, np.uint8)
        for dictionary, marks in CORNERS_PX.items():
            for mark_id, (x, y) in marks.items():
                mark = marker_dictionary(dictionary).generateImageMarker(mark_id, SIDE_PX)
                picture[y : y + SIDE_PX, x + k : x + k + SIDE_PX] = 20 + mark // 255 * 210
        Image.fromarray(cv2.GaussianBlur(picture, (0, 0), 0.8)).save(tmp_path / f"{k}.png")
    photos = read_photos([tmp_path])
    plates = [
        MarkPlate(
            name=dictionary,
            side_mm=20.0,
            marks=tuple(PrintedMark(mark_id=k, x_mm=85.0 * (k - 5), y_mm=0.0) for k in marks),
            dictionary=dictionary,
        )
        for dictionary, marks in CORNERS_PX.items()
    ]
    distances = plate_distances(photos, cameras_for(photos, ()), plates, DEFAULTS, Run())
    middle = (SIDE_PX - 1) / 2
    for one, marks in zip(distances, CORNERS_PX.values(), strict=True):
        for picks, (x, y) in zip((one.first, one.second), marks.values(), strict=True):
            assert [pick.photo for pick in picks] == ["0.png", "1.png"]
            seen = np.array([(pick.x_px, pick.y_px) for pick in picks])
            shown = np.array([(x + middle, y + middle), (x + 1 + middle, y + middle)])
            assert np.abs(seen - shown).max() < 0.2
