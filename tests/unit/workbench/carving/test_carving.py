"""Carving proved on shapes whose offset is known, and the proof proved on faults put in."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import CarveError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.carving.contact import ContactField, sample_surface
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.carving.setup import Blank, CarveOptions
from limbgram.workbench.carving.simulation import Moves, check_carving, simulate
from limbgram.workbench.carving.toolpath import Strip, Toolpath, plan_toolpath

COARSE = CarveOptions(scallop_mm=0.1, tool_diameter_mm=16.0)
HEIGHT = 40.0


@cache
def body(kind: str) -> Mesh:
    """A cylinder, a cone that widens upwards, or half an ellipsoid on its tip."""
    thetas = np.arange(0, 360, 1.5)
    z = np.linspace(0, HEIGHT, 5)
    radii = np.full_like(z, 30.0)
    if kind == "cone":
        radii = 20 + z / 2
    if kind == "ellipsoid":
        angle = np.linspace(0, np.pi / 2, 41)
        z, radii = HEIGHT * (1 - np.cos(angle)), 30 * np.sin(angle)
    full = np.broadcast_to(radii[:, None], (len(z), len(thetas))).copy()
    return RadiusMap(thetas_deg=thetas, z_mm=z, radii_mm=full).surface()


@cache
def planned(kind: str, options: CarveOptions) -> Toolpath:
    return plan_toolpath(body(kind), options)


def moves_of(toolpath: Toolpath, deeper_mm: float = 0.0) -> Moves:
    """The strips as moves, with rapid ones to their beginning and from their end."""
    ball = toolpath.options.ball_mm
    x, a, tip, rapid = [], [], [], []
    safe_mm = toolpath.blank.radius_mm + 10
    for strip in toolpath.strips:
        x.append(np.pad(strip.x_mm, 1, mode="edge"))
        a.append(np.pad(strip.a_deg, 1, mode="edge"))
        tip.append(np.pad(strip.centre_mm - ball - deeper_mm, 1, constant_values=safe_mm))
        rapid.append(np.pad(np.zeros(len(strip.x_mm), np.bool_), 1, constant_values=True))
    joined = [np.concatenate(part) for part in (x, a, tip, rapid)]
    return Moves(x_mm=joined[0], a_deg=joined[1], tip_mm=joined[2], rapid=joined[3], minutes=0.0)


@pytest.mark.parametrize(("kind", "slope"), [("cylinder", 0.0), ("cone", 1 / 2)])
def test_a_ball_stops_at_the_true_offset(kind: str, slope: float) -> None:
    field = ContactField.of(sample_surface(body(kind), 0.3))
    z, angles = np.linspace(15, 32, 7), np.linspace(0, 6, 7)
    found = field.stops_mm(z, angles, 6.0, 0.0)
    # A cone's wall keeps the ball off by R / cos(slope), not by R.
    expected = (30.0 if not slope else 20 + z / 2) + 6 * np.hypot(1, slope)
    np.testing.assert_allclose(found, expected, atol=0.008)
    assert (found <= expected + 1e-6).all()  # samples lie on the surface, never outside


def test_a_ball_stops_at_the_offset_of_a_sphere_off_the_axis() -> None:
    ball = trimesh.creation.icosphere(subdivisions=6, radius=40)
    ball.apply_translation((10, 5, 0))
    mesh = Mesh(vertices_mm=np.asarray(ball.vertices), faces=ball.faces.astype(np.int32))
    field = ContactField.of(sample_surface(mesh, 0.4))
    angles = np.linspace(0, 2 * np.pi, 25)
    z = np.linspace(-45, 45, 25)
    found = field.stops_mm(z, angles, 8.0, 0.0)
    along = 10 * -np.sin(angles) + 5 * np.cos(angles)
    across = 10 * np.cos(angles) + 5 * np.sin(angles)
    free2 = 48.0**2 - across**2 - z**2
    expected = np.where(free2 > 0, along + np.sqrt(np.maximum(free2, 0)), 0)
    steep = 48 / np.sqrt(np.maximum(free2, 1))
    assert (np.abs(found - np.maximum(expected, 0)) < 0.02 * steep).all()


@pytest.mark.parametrize(
    ("pattern", "kind"),
    [
        ("helix", "cone"),
        ("helix", "ellipsoid"),
        ("rings", "ellipsoid"),
        pytest.param("rings", "cone", marks=pytest.mark.slow),
        pytest.param("helix", "cylinder", marks=pytest.mark.slow),
        pytest.param("rings", "cylinder", marks=pytest.mark.slow),
    ],
)
def test_the_shape_is_carved_and_not_cut_into(kind: str, pattern: str) -> None:
    mesh = body(kind)
    options = replace(COARSE, pattern=pattern)
    toolpath = planned(kind, options)
    check = check_carving(moves_of(toolpath), toolpath.blank, options.ball_mm, mesh)
    assert check.gouge_mm < 0.01
    # 95 % of the ridges' height, and the 0.01 mm that keep samples clear.
    assert 0.05 < check.scallop_mm < 0.13
    assert check.left_mm < 0.2
    assert check.rapid_hits == 0


@pytest.mark.slow
def test_finer_ridges_are_finer() -> None:
    mesh = body("cone")
    found = []
    for scallop_mm in (0.2, 0.05):
        options = replace(COARSE, scallop_mm=scallop_mm)
        toolpath = planned("cone", options)
        found.append(check_carving(moves_of(toolpath), toolpath.blank, 8.0, mesh).scallop_mm)
    assert found[0] > 2 * found[1]


@pytest.mark.parametrize("deeper_mm", [0.1])
def test_a_path_too_deep_is_seen_as_deep_as_it_is(deeper_mm: float) -> None:
    mesh = body("cone")
    toolpath = planned("cone", COARSE)
    moves = moves_of(toolpath, deeper_mm)
    check = check_carving(moves, toolpath.blank, COARSE.ball_mm, mesh)
    cosine = 1 / np.hypot(1, 1 / 2)
    assert check.gouge_mm == pytest.approx(deeper_mm * cosine, abs=0.02)


def test_a_radial_offset_would_cut_into_a_cone() -> None:
    mesh = body("cone")
    toolpath = planned("cone", COARSE)
    strip = toolpath.strips[-1]
    radial = np.clip(20 + strip.x_mm / 2, 20, 40) + COARSE.ball_mm
    wrong = replace(toolpath, strips=(replace(strip, centre_mm=radial),))
    check = check_carving(moves_of(wrong), toolpath.blank, COARSE.ball_mm, mesh)
    missing = COARSE.ball_mm * (1 - 1 / np.hypot(1, 1 / 2))
    assert check.gouge_mm == pytest.approx(missing, abs=0.03)


def test_a_mirrored_or_turned_program_is_seen() -> None:
    thetas = np.arange(0, 360, 3.0)
    radii = 30 + 5 * np.exp(-(((thetas - 90) / 20) ** 2))
    z = np.linspace(0, HEIGHT, 3)
    full = np.broadcast_to(radii, (3, 120)).copy()
    mesh = RadiusMap(thetas_deg=thetas, z_mm=z, radii_mm=full).surface()
    toolpath = plan_toolpath(mesh, replace(COARSE, scallop_mm=0.5))
    moves = moves_of(toolpath)
    assert check_carving(moves, toolpath.blank, 8.0, mesh).gouge_mm < 0.02
    mirrored = replace(moves, a_deg=-moves.a_deg)
    assert check_carving(mirrored, toolpath.blank, 8.0, mesh).gouge_mm > 4


def test_one_groove_is_cut_where_and_as_deep_as_the_ball_goes() -> None:
    blank = Blank(radius_mm=40, from_mm=0, to_mm=50)
    moves = Moves(
        x_mm=np.full(4, 25.0),
        a_deg=np.array([0.0, 0.0, 360.0, 360.0]),
        tip_mm=np.array([60.0, 35.0, 35.0, 60.0]),
        rapid=np.array([True, False, False, True]),
        minutes=0.0,
    )
    carved = simulate(moves, blank, 8.0)
    away = carved.x_mm - 25
    groove = np.where(np.abs(away) < 8, 43 - np.sqrt(np.maximum(64 - away**2, 0)), 40)
    expected = np.minimum(groove, 40)
    np.testing.assert_allclose(carved.radii_mm, np.tile(expected[:, None], 720), atol=0.01)


def test_rapid_moves_through_the_blank_are_counted() -> None:
    mesh = body("cone")
    toolpath = planned("cone", COARSE)
    moves = moves_of(toolpath)
    low = replace(moves, tip_mm=np.where(moves.rapid, 20.0, moves.tip_mm))
    assert check_carving(low, toolpath.blank, 8.0, mesh).rapid_hits >= len(toolpath.strips) - 1


def test_a_spigot_is_left_standing() -> None:
    options = replace(COARSE, spigot_mm=10.0)
    toolpath = planned("ellipsoid", options)
    carved = simulate(moves_of(toolpath), toolpath.blank, options.ball_mm)
    assert carved.radii_mm[carved.x_mm < 0.5].min() == pytest.approx(10.0, abs=0.02)
    assert min(float(strip.centre_mm.min()) for strip in toolpath.strips) == 18.0


def test_rings_do_not_wind_up() -> None:
    strip: Strip = planned("ellipsoid", replace(COARSE, pattern="rings")).strips[-1]
    assert strip.a_deg.min() == 0
    assert strip.a_deg.max() == 360


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (CarveOptions(blank_diameter_mm=50), "too thin: the shape needs 80.0 mm"),
        (CarveOptions(blank_length_mm=50), "too short: 51.0 mm"),
        (CarveOptions(tool_reach_mm=30, scallop_mm=0.5), "the holder would hit it"),
    ],
)
def test_a_blank_or_tool_that_does_not_do_is_refused(options: CarveOptions, says: str) -> None:
    with pytest.raises(CarveError, match=says):
        plan_toolpath(body("cone"), options)


def test_a_tool_too_short_is_refused_before_any_way_is_planned(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A foot's program had been planned for minutes, to say what its blank alone tells."""
    options = replace(COARSE, tool_reach_mm=30)
    whole = planned("ellipsoid", replace(options, tool_reach_mm=120))
    deepest_mm = min(float(strip.centre_mm.min()) for strip in whole.strips) - options.ball_mm
    places = []
    stops_mm = ContactField.stops_mm

    def counted(field: ContactField, z_mm: np.ndarray, *rest: np.ndarray) -> np.ndarray:
        places.append(len(z_mm))
        return stops_mm(field, z_mm, *rest)

    monkeypatch.setattr(ContactField, "stops_mm", counted)
    with pytest.raises(CarveError) as refused:
        plan_toolpath(body("ellipsoid"), options)
    assert refused.value.finding.code == "carve.tool.short"
    needed_mm = refused.value.finding.values["needed_mm"]
    assert needed_mm == pytest.approx(whole.blank.radius_mm - deepest_mm, abs=0.01)
    assert sum(places) < len(whole.strips[-1].x_mm) / 20


@pytest.mark.parametrize(
    "options",
    [
        CarveOptions(tool_diameter_mm=0),
        CarveOptions(scallop_mm=float("nan")),
        CarveOptions(beyond_tip_mm=20),
        CarveOptions(to_mm=500),
    ],
)
def test_what_no_carver_has_is_refused(options: CarveOptions) -> None:
    with pytest.raises(OptionsError):
        plan_toolpath(body("cone"), options)


def test_the_blank_holds_the_end_of_a_shape_of_few_triangles() -> None:
    """Carving ends half way up a cone whose only corners lie at its ends: 40 mm from the axis."""
    radii = np.repeat([[20.0], [60.0]], 12, axis=1)
    thetas = 30.0 * np.arange(12)
    cone = RadiusMap(thetas_deg=thetas, z_mm=np.array([0.0, 120.0]), radii_mm=radii).surface()
    options = replace(COARSE, to_mm=60.0, scallop_mm=1.0, tolerance_mm=0.04)
    assert plan_toolpath(cone, options).blank.radius_mm == 45
    with pytest.raises(CarveError, match=r"too thin: the shape needs 80\.0 mm"):
        plan_toolpath(cone, replace(options, blank_diameter_mm=60.0))
