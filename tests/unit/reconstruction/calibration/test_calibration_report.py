"""The report of a calibration says what the calibration holds."""

import io
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from limbgram.core.typed import tree_of
from limbgram.findings import note
from limbgram.reconstruction.calibration.board import calibrate_detections
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.report.calibration import calibration_picture, calibration_summary, calibration_text


def test_the_summary_is_json_and_holds_every_number(capture: Callable[..., Any]) -> None:
    result = calibrate_detections(*capture().arguments)
    summary = json.loads(json.dumps(tree_of(calibration_summary(result)), allow_nan=False))
    camera = result.calibration.camera
    assert summary["parameters"]["fx"] == {
        "value": camera.fx,
        "sigma": float(result.calibration.sigmas[0]),
        "fixed": False,
    }
    assert summary["parameters"]["skew"]["fixed"]
    assert summary["skew_px"]["sigma"] == result.skew.sigma
    assert [photo["name"] for photo in summary["photos"]] == [p.name for p in result.photos]
    np.testing.assert_array_equal(summary["correlations"]["matrix"], result.correlations)


def test_the_text_rounds_to_the_sigma_and_names_what_is_held(capture: Callable[..., Any]) -> None:
    result = calibrate_detections(*capture().arguments)
    lines = calibration_text(result).splitlines()
    fx = next(line for line in lines if line.split()[:1] == ["fx"]).split()
    assert abs(float(fx[1]) - result.calibration.camera.fx) < result.calibration.sigmas[0]
    assert any("skew" in line and "held at zero" in line for line in lines)
    assert fx[2] == "±"
    assert float(fx[3]) == pytest.approx(1.96 * result.calibration.sigmas[0], rel=0.1)
    assert sum("± holds in 95 of 100" in line for line in lines) == 1


def test_photos_that_were_set_aside_are_named_with_the_reason(
    capture: Callable[..., Any],
) -> None:
    result = calibrate_detections(*capture(photos=6).arguments)
    assert "cut off" not in calibration_text(result)
    result = replace(
        result,
        set_aside=(SetAside("CAL_7.jpg", note("said.as_is", message="the board is cut off")),),
    )
    lines = calibration_text(result).splitlines()
    counted = next(k for k, line in enumerate(lines) if "1 set aside" in line)
    assert lines[counted + 1] == "  CAL_7.jpg: the board is cut off"
    few = replace(result, doubts=(note("lens.doubt.few_photos", photos=6),))
    assert "! 6 Fotos sind wenig" in calibration_text(few, "de")


def test_the_picture_is_drawn_and_a_name_with_dollar_signs_is_no_formula_in_it(
    capture: Callable[..., Any],
) -> None:
    result = calibrate_detections(*capture(photos=6).arguments)
    first, *others = result.photos
    result = replace(
        result,
        photos=(replace(first, name="CAL$__$1.jpg"), *others),
        set_aside=(SetAside("CAL$__$2.jpg", note("said.as_is", message="cut off")),),
    )
    picture = Image.open(io.BytesIO(calibration_picture(result)))
    assert picture.format == "PNG"
    assert min(picture.size) > 800
    grey = np.asarray(picture.convert("L"))
    quarters = [part for half in np.array_split(grey, 2) for part in np.array_split(half, 2, 1)]
    assert all((part < 128).mean() > 0.002 for part in quarters)
