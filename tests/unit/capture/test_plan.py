"""Plans against what optics and geometry ask, worked out by hand."""

import io
import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from limbgram.capture.camera_positions import Stand
from limbgram.capture.plan import (
    LimbForm,
    PlannedCamera,
    Sock,
    form_of,
    plain_limb,
    plan_capture,
    showing_of_sock,
)
from limbgram.capture.prediction import predict
from limbgram.cli.main import app
from limbgram.core.errors import OptionsError, PlanError

CAMERA = PlannedCamera.of(35.0, 22.3, 3000, 2000)
LEG = form_of(LimbForm.LOWER_LEG)


def test_a_plan_reaches_what_was_asked_by_the_formula_of_the_check() -> None:
    plan = plan_capture(0.04, CAMERA, LEG, 900.0)
    assert plan.sigma_mm <= 0.04
    assert plan.sigma_middle_mm <= plan.sigma_mm
    stands = [
        Stand(azimuth_deg=turn, elevation_deg=ring.elevation_deg, distance=plan.distance_mm)
        for ring in plan.rings
        for turn in ring.azimuths_deg
    ]
    assert len(stands) == plan.photos
    views = [one.view(CAMERA.camera, LEG.middle, 0.0) for one in stands]
    shown = showing_of_sock(len(LEG.mesh), len(views), plan.blur_px, Sock.PAINTED)
    again = predict(LEG, views, shown)
    assert again.middle_sigma_mm(LEG) == pytest.approx(plan.sigma_middle_mm, rel=0.03)


def test_a_stricter_sigma_takes_more_photos_and_a_looser_one_no_fewer_than_a_ring() -> None:
    easy = plan_capture(0.2, CAMERA, LEG, 900.0)
    hard = plan_capture(0.98 * easy.sigma_mm, CAMERA, LEG, 900.0)
    assert easy.photos == 12  # 30 degrees apart
    assert 12 < hard.photos <= 48
    assert hard.sigma_mm < easy.sigma_mm


def test_pixel_and_paint_follow_from_the_lens() -> None:
    plan = plan_capture(0.2, CAMERA, LEG, 900.0)
    assert plan.pixel_mm == pytest.approx(900 * 22.3 / 3000 / 35)
    assert plan.paint_mm == pytest.approx(5 * plan.pixel_mm)


def test_a_camera_whose_photos_stand_upright_is_the_same_camera() -> None:
    lying = plan_capture(0.04, CAMERA, LEG, 900.0)
    upright = plan_capture(0.04, PlannedCamera.of(35.0, 22.3, 2000, 3000), LEG, 900.0)
    for name in ("photos", "pixel_mm", "portrait", "aperture", "sigma_mm", "distance_mm"):
        assert getattr(upright, name) == pytest.approx(getattr(lying, name)), name
    assert lying.portrait  # a leg stands


def test_rings_stand_where_they_say() -> None:
    ring = plan_capture(0.2, CAMERA, LEG, 900.0).rings[0]
    assert math.hypot(ring.above_middle_mm, ring.level_distance_mm) == pytest.approx(900.0)
    assert np.diff(ring.azimuths_deg) == pytest.approx([360 / ring.photos] * (ring.photos - 1))


def test_the_aperture_balances_defocus_and_diffraction() -> None:
    plan = plan_capture(0.2, CAMERA, LEG, 900.0)
    near, far = plan.depth_mm
    assert 900 - 130 < near < 900 - 40 < 900 < far < 900 + 60
    assert plan.focus_mm == pytest.approx(2 / (1 / near + 1 / far))
    assert plan.aperture is not None
    pitch = 22.3 / 3000

    def blur2(stop: float) -> float:
        disc = 35**2 * (plan.focus_mm / near - 1) / (stop * (plan.focus_mm - 35)) / pitch
        airy = 0.42 * 0.00055 * stop / pitch
        return (disc / 4) ** 2 + airy**2

    # A third of a stop either way is no better; the lens focused near is a little longer.
    assert blur2(plan.aperture) < 1.1 * blur2(plan.aperture * 2 ** (1 / 6))
    assert blur2(plan.aperture) < 1.1 * blur2(plan.aperture / 2 ** (1 / 6))


def test_a_fixed_aperture_is_kept_and_its_blur_is_counted() -> None:
    wide = PlannedCamera.of(35.0, 22.3, 3000, 2000, aperture=1.4)
    plan, best = plan_capture(0.5, wide, LEG, 700.0), plan_capture(0.5, CAMERA, LEG, 700.0)
    assert plan.aperture == 1.4
    assert plan.blur_px > 2 * best.blur_px
    assert plan.sigma_mm > best.sigma_mm
    assert any(one.code == "plan.defocus" for one in plan.notes)


def test_a_camera_whose_board_photos_were_less_sharp_is_planned_to_be_less_sure() -> None:
    sharp, soft = (
        plan_capture(0.5, replace(CAMERA, edge_px=edge_px), LEG, 900.0) for edge_px in (0.8, 1.6)
    )
    assert sharp.photos == soft.photos
    assert 1.4 < soft.sigma_mm / sharp.sigma_mm < 2.2


def test_a_printed_sock_shows_more_than_a_painted_one() -> None:
    painted, printed = (plan_capture(0.5, CAMERA, LEG, 900.0, sock) for sock in Sock)
    assert 0.7 < printed.sigma_mm / painted.sigma_mm < 0.95


@pytest.mark.parametrize("sock", Sock)
def test_the_wider_the_edges_the_flatter_the_slopes(sock: Sock) -> None:
    shown = [showing_of_sock(1, 1, blur_px, sock) for blur_px in (0.5, 0.9, 1.5, 3.0)]
    assert all(one.slope > two.slope for one, two in pairwise(shown))
    assert all(one.edge_px <= two.edge_px for one, two in pairwise(shown))
    assert shown[-1].edge_px == pytest.approx(3.0, rel=0.1)


def test_a_limb_that_does_not_fit_is_refused_and_the_distance_named_fits() -> None:
    with pytest.raises(PlanError, match="Step back to") as refusal:
        plan_capture(0.1, CAMERA, LEG, 400.0)
    named = float(str(refusal.value).split("Step back to ")[1].split(" mm")[0])
    assert plan_capture(0.1, CAMERA, LEG, named).distance_mm == named


def test_what_cannot_be_reached_is_refused_and_what_is_named_reaches_it() -> None:
    with pytest.raises(PlanError, match="Come as near as") as refusal:
        plan_capture(0.03, CAMERA, LEG, 2200.0)
    named = float(str(refusal.value).split("as near as ")[1].split(" mm")[0])
    assert plan_capture(0.03, CAMERA, LEG, 0.95 * named).sigma_mm <= 0.03
    with pytest.raises(PlanError, match="megapixels"):
        plan_capture(0.002, CAMERA, LEG)


def test_odd_limbs_are_refused() -> None:
    with pytest.raises(OptionsError, match="thick"):
        plain_limb(5.0, 200.0)


def test_the_command_says_draws_and_encodes_the_same_plan(tmp_path: Path) -> None:
    picture = tmp_path / "plan.png"
    asked = ["plan", "--sigma", "0.1", "--distance", "1500", "--focal", "50", "--sensor", "22.3"]
    asked += ["--pixels", "1500x1000", "--diameter", "100", "--length", "250"]
    said = CliRunner().invoke(app, [*asked, "--picture", str(picture), "--json"])
    assert said.exit_code == 0, said.output
    tree = json.loads(said.stdout)
    plan = plan_capture(
        0.1, PlannedCamera.of(50.0, 22.3, 1500, 1000), plain_limb(100.0, 250.0), 1500.0
    )
    assert tree["photos"] == plan.photos
    assert tree["sigma_mm"] == pytest.approx(plan.sigma_mm)
    drawn = np.asarray(Image.open(io.BytesIO(picture.read_bytes())))
    photos = (drawn == np.array([92, 122, 133])).all(axis=2).sum()
    assert photos > 200 * plan.photos
    words = CliRunner().invoke(app, asked)
    assert f"{plan.photos} photos in" in words.output
    refused = CliRunner().invoke(app, [*asked[:-2], "--json"])
    assert refused.exit_code == 2
    assert "belong together" in refused.stdout
