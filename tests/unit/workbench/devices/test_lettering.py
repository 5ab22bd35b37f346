"""Lettering: raised by as much as stated, to be read from outside, refused where nobody could."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from tests.unit.workbench.devices.shapes import make_trunk

from limbgram.core.errors import EditError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.workbench.devices.fittings import with_parts
from limbgram.workbench.devices.lettering import CAPITAL_MM, RAISED_MM, lettering
from limbgram.workbench.devices.making import Order, Preview, preview_device
from limbgram.workbench.devices.order import OrderFile, encode_order, parse_order
from limbgram.workbench.devices.proof import require_solid
from limbgram.workbench.recipe.recipe import Recipe

UP = np.array([0.0, 0.0, 1.0])


def shell_of(made: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices_mm=np.array(made.vertices), faces=np.array(made.faces, np.int32))


def board() -> Mesh:
    """6 mm thick, its upper side at y = 0, which looks to -y, at the reader."""
    made = trimesh.creation.box((200.0, 6.0, 100.0)).subdivide().subdivide()
    return shell_of(made.apply_translation((0, 3.0, 0)))


def test_letters_stand_out_by_what_they_say_and_are_as_high() -> None:
    text = lettering(board(), "H", np.zeros(3), np.array([0.0, -1.0, 0.0]), np.array([1.0, 0, 0]))
    low, high = text.solid.vertices_mm.min(0), text.solid.vertices_mm.max(0)
    assert low[1] == pytest.approx(-RAISED_MM, abs=1e-9)
    assert high[2] - low[2] == pytest.approx(CAPITAL_MM, abs=1e-6)
    assert high + low == pytest.approx([0.0, high[1] + low[1], 0.0], abs=1e-9)
    joined = with_parts(board(), [text])
    require_solid(joined)
    flat_mm2 = volume_mm3(text.solid) / (high[1] - low[1])
    raised_mm3 = volume_mm3(joined) - volume_mm3(board())
    assert raised_mm3 == pytest.approx(flat_mm2 * RAISED_MM, rel=1e-6)


def test_who_looks_at_the_outer_side_reads_it() -> None:
    """The foot of an L lies to the right of its stem; it would lie to the left in a mirror."""
    reader, right = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    level = lettering(board(), "L", np.zeros(3), reader, right).solid.vertices_mm
    foot, stem = level[level[:, 2] < -2.5], level[level[:, 2] > 1.0]
    assert foot[:, 0].max() > stem[:, 0].max() + 1.0
    assert foot[:, 0].min() == pytest.approx(stem[:, 0].min(), abs=1e-6)
    upright = lettering(board(), "L", np.zeros(3), reader, UP).solid.vertices_mm
    np.testing.assert_allclose(upright[:, 2], level[:, 0], atol=1e-9)
    np.testing.assert_allclose(upright[:, 0], -level[:, 2], atol=1e-9)


def test_what_stands_between_two_dollar_signs_is_no_formula() -> None:
    reader, right = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    bare_mm, signed_mm = (
        np.ptp(lettering(board(), text, np.zeros(3), reader, right).solid.vertices_mm[:, 0])
        for text in ("__", "$__$")
    )
    assert signed_mm > bare_mm + CAPITAL_MM


def test_on_a_round_wall_letters_follow_it() -> None:
    tube = shell_of(trimesh.creation.annulus(46.0, 50.0, 200.0, sections=180))
    text = lettering(tube, "left 11/26", np.array([0, -50.0, 0]), np.array([0, -1.0, 0]), UP)
    away_mm = np.hypot(*text.solid.vertices_mm[:, :2].T)
    # The tube's faces lie within 0.008 mm of the circle, and letters lean by 5 degrees at most.
    assert away_mm.max() == pytest.approx(50.0 + RAISED_MM, abs=0.01)
    assert away_mm.min() > 49.5
    require_solid(with_parts(tube, [text]))


@pytest.mark.parametrize(
    ("text", "runs", "code"),
    [
        ("much too long for the calf", np.array([1.0, 0, 0]), "device.lettering.room"),
        ("a text that is longer than the tube is high, by far", UP, "device.lettering.room"),
        ("\u4e2d", UP, "device.lettering.character"),
        ("two\nlines", UP, "device.lettering.character"),
        ("  ", UP, "device.lettering.length"),
        (61 * "x", UP, "device.lettering.length"),
    ],
)
def test_what_nobody_could_read_is_refused(text: str, runs: np.ndarray, code: str) -> None:
    tube = shell_of(trimesh.creation.annulus(36.0, 40.0, 160.0, sections=180))
    with pytest.raises(EditError) as refused:
        lettering(tube, text, np.array([0, -40.0, 0]), np.array([0, -1.0, 0]), runs)
    assert refused.value.finding.code == code


def test_an_order_keeps_its_lettering() -> None:
    order = OrderFile(
        device="ucbl", made="printed", values={}, free={}, recipe=Recipe(name=""), lettering='A "M"'
    )
    assert parse_order(encode_order(order).decode(), "order.toml") == order
    plain = replace(order, lettering="")
    assert b"lettering" not in encode_order(plain)


@pytest.mark.slow
def test_vents_are_holes_of_their_width_and_none_where_none_are_asked() -> None:
    trunk = make_trunk()
    order = Order(device="tlso-back", made="printed")
    whole = preview_device(trunk, order)
    holed = preview_device(trunk, replace(order, values={"vent_mm": 8.0, "vents_apart_mm": 30.0}))

    def kept_mm2(preview: Preview) -> float:
        layout = preview.layout
        inside = (layout.beyond_mm < 0).astype(float)[layout.positive.faces].mean(1)
        areas = np.linalg.norm(layout.positive.face_normals(), axis=1) / 2
        return float((areas * inside).sum())

    holes_mm2 = 36 * np.pi * 8.0**2 / 4
    assert kept_mm2(whole) - kept_mm2(holed) == pytest.approx(holes_mm2, rel=0.05)
