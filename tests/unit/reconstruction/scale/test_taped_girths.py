"""A tape is held against the surface where it was laid, across the limb's own axis."""

import numpy as np
import pytest

from limbgram.core.errors import OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.reconstruction.scale.stated_lengths import TapedGirth
from limbgram.reconstruction.scale.taped_girths import hold_tapes

RINGS, SPOKES = 121, 120
HEIGHT_MM = 240.0


def barrel(bulge_mm: float, taper_mm: float = 0.0, lean_deg: float = 0.0) -> Mesh:
    """An open limb 50 mm in radius at both ends but for bulge and taper, leaning about its foot."""
    share = np.linspace(0, 1, RINGS)
    radius = 50 + bulge_mm * np.sin(np.pi * share) - taper_mm * share
    azimuth = np.arange(SPOKES) * 2 * np.pi / SPOKES
    places = np.empty((RINGS, SPOKES, 3))
    places[..., 0] = radius[:, None] * np.cos(azimuth)
    places[..., 1] = radius[:, None] * np.sin(azimuth)
    places[..., 2] = HEIGHT_MM * share[:, None]
    grid = np.arange(RINGS * SPOKES, dtype=np.int32).reshape(RINGS, SPOKES)
    a, b = grid[:-1], np.roll(grid, -1, axis=1)[:-1]
    c, d = np.roll(grid, -1, axis=1)[1:], grid[1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    lean = np.radians(lean_deg)
    turn = np.array([[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]])
    return Mesh(vertices_mm=places.reshape(-1, 3) @ turn.T, faces=np.ascontiguousarray(faces))


@pytest.mark.parametrize("lean_deg", [0.0, 20.0])
def test_the_widest_place_is_found_however_the_limb_leans(lean_deg: float) -> None:
    (held,) = hold_tapes(barrel(12.0, lean_deg=lean_deg), None, (TapedGirth(girth_mm=390),)).found
    assert held.measured_mm == pytest.approx(2 * np.pi * 62, rel=2e-3)
    assert held.sigma_mm == pytest.approx(1.5)


def test_a_height_counts_from_the_table_and_a_taper_makes_it_less_sure() -> None:
    mesh = barrel(0.0, taper_mm=24.0)
    lifted = mesh.with_vertices(mesh.vertices_mm + np.array([0, 0, 40.0]))
    (held,) = hold_tapes(lifted, 0.0, (TapedGirth(girth_mm=300, height_mm=160),)).found
    assert held.measured_mm == pytest.approx(2 * np.pi * 38, rel=2e-3)
    taper_mm = 2 * np.pi * 24 / HEIGHT_MM * 3
    assert held.sigma_mm == pytest.approx(np.hypot(1.5, taper_mm), rel=0.02)


def test_a_tape_between_holes_is_no_surer_than_one_on_a_whole_limb() -> None:
    """3 mm above and below it no girth is whole; nearer there is one."""
    mesh = barrel(0.0, taper_mm=24.0)
    middles = mesh.vertices_mm[mesh.faces].mean(1)
    holed = np.isin(middles[:, 2] // 2, [59, 62]) & (middles[:, 0] > 35)
    torn = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[~holed])
    whole, held = (
        hold_tapes(one, 0.0, (TapedGirth(girth_mm=300, height_mm=121.5),)).found[0]
        for one in (mesh, torn)
    )
    assert held.measured_mm == pytest.approx(whole.measured_mm, abs=0.05)
    assert held.sigma_mm == pytest.approx(whole.sigma_mm, rel=0.02)


def test_a_trunk_is_taped_without_its_arms() -> None:
    """The arms hang beside it, and one of them lies higher than the other."""
    trunk = barrel(12.0)
    parts = [trunk]
    for aside, up in ((-120.0, 30.0), (118.0, 20.0)):
        arm = trunk.vertices_mm * [0.3, 0.3, 0.8] + [aside, 0, up]
        parts.append(trunk.with_vertices(arm))
    faces = np.concatenate([part.faces + k * len(trunk) for k, part in enumerate(parts)])
    body = Mesh(
        vertices_mm=np.concatenate([part.vertices_mm for part in parts]),
        faces=faces.astype(np.int32),
    )
    for taped in (TapedGirth(girth_mm=390), TapedGirth(girth_mm=390, height_mm=120)):
        (held,) = hold_tapes(body, 0.0, (taped,)).found
        assert held.measured_mm == pytest.approx(2 * np.pi * 62, rel=2e-3)


@pytest.mark.parametrize(
    ("mesh", "floor", "taped", "why"),
    [
        (barrel(0.0, taper_mm=24.0), 0.0, TapedGirth(girth_mm=300), "open end"),
        (barrel(12.0), None, TapedGirth(girth_mm=300, height_mm=100), "no table"),
        (barrel(12.0), 0.0, TapedGirth(girth_mm=300, height_mm=500), "no whole girth"),
        (barrel(12.0, lean_deg=80), 0.0, TapedGirth(girth_mm=300, height_mm=50), "lies"),
    ],
)
def test_what_cannot_be_told_says_why(
    mesh: Mesh, floor: float | None, taped: TapedGirth, why: str
) -> None:
    (held,) = hold_tapes(mesh, floor, (taped,)).found
    assert np.isnan(held.measured_mm)
    assert why in told(held.reason)


@pytest.mark.parametrize("girth_mm", [3.45, float("nan"), 1e6])
def test_what_is_no_girth_is_refused(girth_mm: float) -> None:
    with pytest.raises(OptionsError, match=r"345, not 34\.5"):
        TapedGirth(girth_mm=girth_mm)
