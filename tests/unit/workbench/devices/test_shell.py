"""A shell is as thick as asked, round at its edges, closed, and bridges creases."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import EditError
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.folds import ANY_SHAPE, find_folds
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_half_edges, face_components, volume_mm3
from limbgram.workbench.devices import shell as shell_making
from limbgram.workbench.devices.blocks import Boss, RoundCone
from limbgram.workbench.devices.proof import fold_findings, measure_wall, require_solid
from limbgram.workbench.devices.shell import Layout, _without_crossings, make_shell, without_folds

RADIUS, TOP, THICK = 20.0, 62.0, 4.0


def tube(top_mm: float = 76.0, spokes: int = 120, step_mm: float = 2.0) -> Mesh:
    """Half a sphere, and a tube on it; open at its top."""
    angle = 2 * np.pi * np.arange(spokes) / spokes
    polar = np.linspace(0, np.pi / 2, 32)[1:]
    rows = [(RADIUS * np.sin(p), RADIUS * (1 - np.cos(p))) for p in polar]
    rows += [(RADIUS, z) for z in np.arange(RADIUS + step_mm, top_mm + 1e-9, step_mm)]
    rings = [
        np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle + z]) for r, z in rows
    ]
    here = 1 + np.arange(spokes)
    ahead = np.roll(here, -1)
    faces = [np.column_stack([0 * here, ahead, here])]
    for row in range(len(rows) - 1):
        a, b = here + row * spokes, ahead + row * spokes
        faces += [np.column_stack([a, b, b + spokes]), np.column_stack([a, b + spokes, a + spokes])]
    return Mesh(
        vertices_mm=np.concatenate([np.zeros((1, 3)), *rings]),
        faces=np.concatenate(faces).astype(np.int32),
    )


@pytest.fixture(scope="module")
def layout() -> Layout:
    mesh = tube()
    return Layout(
        positive=mesh,
        beyond_mm=mesh.vertices_mm[:, 2] - TOP,
        thickness_mm=np.full(len(mesh), THICK),
    )


@pytest.fixture(scope="module")
def shell(layout: Layout) -> Mesh:
    return make_shell(layout).solid


def test_it_is_one_closed_solid(shell: Mesh) -> None:
    assert not len(boundary_half_edges(shell.faces))
    assert face_components(shell.faces).max() == 0
    assert not len(find_crossings(shell.vertices_mm, shell.faces))
    require_solid(shell)


def test_it_is_as_thick_as_asked_by_rays_of_another_library(shell: Mesh) -> None:
    rng = np.random.default_rng(1)
    heights, angles = rng.uniform(24, 55, 300), rng.uniform(0, 2 * np.pi, 300)
    out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    axis = np.column_stack([0 * heights, 0 * heights, heights])
    body = trimesh.Trimesh(shell.vertices_mm, shell.faces, process=False)
    places, rays, _ = body.ray.intersects_location(axis, out)
    radii = np.linalg.norm((places - axis[rays])[:, :2], axis=1)
    walls = [np.ptp(radii[rays == k]) for k in range(300)]
    assert [np.sum(rays == k) for k in range(300)] == [2] * 300
    np.testing.assert_allclose(walls, THICK, atol=0.05)


def test_its_edge_is_a_half_circle_of_half_the_thickness(shell: Mesh) -> None:
    x, y, z = shell.vertices_mm.T
    above = z > TOP - THICK / 2 + 0.05
    assert above.sum() > 300
    off = np.hypot(np.hypot(x, y) - (RADIUS + THICK / 2), z - (TOP - THICK / 2))[above]
    np.testing.assert_allclose(off, THICK / 2, atol=0.03)
    assert z.max() == pytest.approx(TOP, abs=0.01)


def test_its_volume_is_that_of_the_form(shell: Mesh) -> None:
    outer, inner = RADIUS + THICK, RADIUS
    bowl = 2 / 3 * np.pi * (outer**3 - inner**3)
    straight = np.pi * (outer**2 - inner**2) * (TOP - THICK / 2 - RADIUS)
    half = 2 * np.pi * (inner + THICK / 2) * np.pi * (THICK / 2) ** 2 / 2
    assert volume_mm3(shell) == pytest.approx(bowl + straight + half, rel=3e-3)


def test_the_wall_that_is_told_is_the_wall(shell: Mesh, layout: Layout) -> None:
    wall = measure_wall(shell, layout)
    assert wall.off_mm < 0.05
    assert THICK - 0.05 < wall.thinnest_mm < THICK + 0.01
    assert np.isfinite(wall.at_vertices_mm).mean() > 0.7


def test_a_wall_that_is_thinner_than_asked_is_told(shell: Mesh, layout: Layout) -> None:
    thicker = Layout(
        positive=layout.positive,
        beyond_mm=layout.beyond_mm,
        thickness_mm=layout.thickness_mm + 0.3,
    )
    assert measure_wall(shell, thicker).off_mm == pytest.approx(0.3, abs=0.05)


def test_local_thickness_is_local() -> None:
    mesh = tube()
    z = mesh.vertices_mm[:, 2]
    thick = 3.0 + 3.0 * np.clip((z - 28) / 20, 0, 1)
    layout = Layout(positive=mesh, beyond_mm=z - TOP, thickness_mm=thick)
    solid = make_shell(layout).solid
    r, height = np.hypot(*solid.vertices_mm[:, :2].T), solid.vertices_mm[:, 2]
    outer = (r > RADIUS + 1.5) & (height < TOP - 5)
    np.testing.assert_allclose(r[outer & (np.abs(height - 24) < 3)], RADIUS + 3.0, atol=0.05)
    np.testing.assert_allclose(r[outer & (height > 52)], RADIUS + 6.0, atol=0.05)
    assert measure_wall(solid, layout).off_mm < 0.05


def test_a_wall_thicker_than_what_it_covers_is_round_as_thick_as_asked() -> None:
    """A toe of a small child: the grid's cells are half of its radius."""
    toe = trimesh.creation.icosphere(5, 4.0)
    mesh = Mesh(vertices_mm=np.asarray(toe.vertices, np.float64), faces=toe.faces.astype(np.int32))
    layout = Layout(
        positive=mesh,
        beyond_mm=np.full(len(mesh), -40.0),
        thickness_mm=np.full(len(mesh), 5.0),
    )
    solid = make_shell(layout).solid
    middles = np.linalg.norm(solid.vertices_mm[solid.faces].mean(1), axis=1)
    skins = np.where(middles < 6.5, 4.0, 9.0)
    assert np.abs(middles - skins).max() < 0.05


def test_a_crease_is_bridged_without_a_crossing() -> None:
    """Two spheres that meet: between them the surface turns in more sharply than the wall is
    thick."""
    one = trimesh.creation.icosphere(4, 18.0)
    two = one.copy()
    two.apply_translation([30.0, 0, 0])
    both = trimesh.boolean.union([one, two], engine="manifold")
    mesh = Mesh(
        vertices_mm=np.asarray(both.vertices, np.float64), faces=both.faces.astype(np.int32)
    )
    layout = Layout(
        positive=mesh,
        beyond_mm=mesh.vertices_mm[:, 2] - 9.0,
        thickness_mm=np.full(len(mesh), 5.0),
    )
    solid = make_shell(layout).solid
    require_solid(solid)
    assert measure_wall(solid, layout).off_mm < 0.08


def test_skins_that_nearly_touch_go_back_all_the_way_where_they_would_cross() -> None:
    """Two balls 0.01 mm apart, pushed 12 mm into each other: 1/256 of that is still too far."""
    one = trimesh.creation.icosphere(3, 10.0)
    two = one.copy()
    two.apply_translation([20.01, 0, 0])
    vertices = np.concatenate([one.vertices, two.vertices])
    faces = np.concatenate([one.faces, two.faces + len(one.vertices)]).astype(np.int32)
    apart = Mesh(vertices_mm=vertices, faces=faces)
    pushed = vertices + [6.0, 0, 0] * np.sign(10 - vertices[:, :1])
    freed = _without_crossings(apart, pushed)
    assert len(find_crossings(pushed, faces))
    assert not len(find_crossings(freed.vertices_mm, faces))


def folded_over(mesh: Mesh) -> tuple[Mesh, int]:
    """The mesh with a vertex of its outside drawn along the skin, over its neighbours."""
    r, z = np.hypot(*mesh.vertices_mm[:, :2].T), mesh.vertices_mm[:, 2]
    at = int(np.argmin(np.abs(z - 42.0) + 100 * (r < RADIUS + THICK - 0.1)))
    places = mesh.vertices_mm.copy()
    places[at, 2] += 3.0
    return mesh.with_vertices(places), at


def test_a_fold_is_laid_back_and_nothing_else_moves(
    layout: Layout, shell: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    folded, _ = folded_over(shell)
    assert len(find_folds(folded, ANY_SHAPE))
    assert without_folds(shell) is shell
    monkeypatch.setattr("limbgram.workbench.devices.shell._HALVINGS", 0)
    straight = make_shell(layout).solid
    planted, at = folded_over(straight)

    def with_a_fold(*_: object) -> Mesh:
        return planted

    monkeypatch.setattr("limbgram.workbench.devices.shell._without_crossings", with_a_fold)
    flat = make_shell(layout).solid
    assert not len(find_folds(flat, ANY_SHAPE))
    require_solid(flat)
    from_it_mm = np.linalg.norm(straight.vertices_mm - straight.vertices_mm[at], axis=1)
    moved_mm = np.linalg.norm(flat.vertices_mm - straight.vertices_mm, axis=1)
    assert moved_mm[from_it_mm > 8.0].max() == 0
    near = flat.vertices_mm[from_it_mm < 3.0]
    outside = np.hypot(near[:, 0], near[:, 1]) - (RADIUS + THICK)
    np.testing.assert_allclose(outside, 0, atol=0.1)


def test_a_fold_at_a_fitting_is_told_with_its_place(shell: Mesh) -> None:
    assert fold_findings(shell) == ()
    folded, at = folded_over(shell)
    (told,) = fold_findings(folded)
    assert told.code == "device.folded"
    place = np.array(told.values["point_mm"], np.float64)
    assert np.linalg.norm(place - shell.vertices_mm[at]) < 4.0


def test_a_block_grows_out_of_the_wall_and_never_reaches_the_skin(layout: Layout) -> None:
    cone = RoundCone(
        start_mm=np.array([0.0, 0, -15]),
        end_mm=np.array([0.0, 0, 20]),
        start_radius_mm=15.0,
        end_radius_mm=18.0,
        floor=np.array([0.0, 0, 1]),
    )
    boss = Boss(
        face_mm=np.array([RADIUS + 9, 0, 42.0]),
        outward=np.array([1.0, 0, 0]),
        radius_mm=9.0,
        depth_mm=16.0,
    )
    solid = make_shell(layout, [cone, boss]).solid
    require_solid(solid)
    x, y, z = solid.vertices_mm.T
    assert z.min() == pytest.approx(-15.0, abs=0.05)
    assert x.max() == pytest.approx(RADIUS + 9, abs=0.05)
    from_axis = np.where(z > RADIUS, np.hypot(x, y), np.hypot(np.hypot(x, y), z - RADIUS))
    assert from_axis.min() > RADIUS - 0.06  # nothing of it inside the limb
    assert measure_wall(solid, layout, [cone, boss]).off_mm < 0.05


def test_what_leaves_nothing_or_is_too_large_is_refused(layout: Layout) -> None:
    nothing = Layout(
        positive=layout.positive,
        beyond_mm=np.ones(len(layout.positive)),
        thickness_mm=layout.thickness_mm,
    )
    with pytest.raises(EditError) as refused:
        make_shell(nothing)
    assert refused.value.finding.code == "device.nothing_left"
    thin = Layout(
        positive=layout.positive.with_vertices(20 * layout.positive.vertices_mm),
        beyond_mm=layout.beyond_mm,
        thickness_mm=np.full(len(layout.positive), 0.5),
    )
    with pytest.raises(EditError) as refused:
        make_shell(thin)
    assert refused.value.finding.code == "device.too_large"


@pytest.mark.parametrize("most_nodes", [4e5, 1e4])
def test_a_device_too_large_for_its_wall_is_told_what_would_fit(
    layout: Layout, most_nodes: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tube of 40 mm across and 62 of height, with a wall of 3 mm that is thin at one place."""
    monkeypatch.setattr(shell_making, "_MOST_NODES", most_nodes)
    mesh = layout.positive
    thickness_mm = np.full(len(mesh), 3.0)
    thickness_mm[5] = 1.0
    thin = replace(layout, thickness_mm=thickness_mm)
    with pytest.raises(EditError) as refused:
        make_shell(thin)
    said = refused.value.finding.values
    assert said["across_mm"] == pytest.approx(40 + 2 * 5, abs=2)  # with room for the wall
    assert said["deep_mm"] == pytest.approx(40 + 2 * 5, abs=2)
    assert said["high_mm"] == pytest.approx(62 + 2 * 5, abs=5)
    assert said["longest"] == "high"
    assert said["thinnest_mm"] == 1.0
    assert said["point_mm"] == pytest.approx(mesh.vertices_mm[5])
    if most_nodes == 1e4:
        assert said["fitting_mm"] is None
        return
    thicker = replace(thin, thickness_mm=np.maximum(thickness_mm, said["fitting_mm"]))
    assert make_shell(thicker).cell_mm == pytest.approx(said["fitting_mm"] / 2.5)
    too_little = replace(thin, thickness_mm=np.maximum(thickness_mm, said["fitting_mm"] - 0.3))
    with pytest.raises(EditError):
        make_shell(too_little)
    lower = replace(thin, beyond_mm=thin.beyond_mm + said["over_mm"])
    assert make_shell(lower).cell_mm == 0.5


def test_what_is_no_solid_is_refused_with_the_place(shell: Mesh) -> None:
    open_one = Mesh(vertices_mm=shell.vertices_mm, faces=shell.faces[1:])
    moved = shell.vertices_mm + np.array([0, 0, 300.0])
    two = Mesh(
        vertices_mm=np.concatenate([shell.vertices_mm, moved]),
        faces=np.concatenate([shell.faces, shell.faces + len(shell)]).astype(np.int32),
    )
    through = two.with_vertices(
        np.concatenate([shell.vertices_mm, shell.vertices_mm + np.array([30.0, 0, 1])])
    )
    for solid, code in ((open_one, "device.open"), (two, "device.pieces")):
        with pytest.raises(EditError) as refused:
            require_solid(solid)
        assert refused.value.finding.code == code
        assert len(refused.value.finding.values["point_mm"]) == 3
    with pytest.raises(EditError) as refused:
        require_solid(through)
    assert refused.value.finding.code in ("device.pieces", "device.crosses")


def test_what_settling_pushed_through_the_surface_goes_back_and_the_rest_stays() -> None:
    ball = trimesh.creation.icosphere(4, 20.0)
    even = Mesh(vertices_mm=np.array(ball.vertices), faces=ball.faces.astype(np.int32))
    settled = 1.01 * even.vertices_mm
    top = int(np.argmax(settled[:, 2]))
    settled[top] = [0.0, 0.0, -30.0]
    assert len(find_crossings(settled, even.faces))
    mended = _without_crossings(even, settled).vertices_mm
    assert not len(find_crossings(mended, even.faces))
    others = np.arange(len(mended)) != top
    size = np.linalg.norm(mended[others], axis=1)
    assert size.min() > 20.0 - 1e-9
    assert size.max() < 20.2 + 1e-9
    stayed = (mended == settled).all(1)
    assert 0.9 < stayed.mean() < 1
    assert not stayed[top]
