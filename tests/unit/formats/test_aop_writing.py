"""AOP as written: exact radii, costs as closed forms tell them, and refusals with their count."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from limbgram.core.errors import CarveError, MeasureError, OptionsError
from limbgram.core.geometry.frames import Rigid, angle_between_deg
from limbgram.core.mesh.closest_point import TriangleTree
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.formats.aop import axis
from limbgram.formats.aop.profiles import Profile
from limbgram.formats.aop.reading import read_aop
from limbgram.formats.aop.writing import AopOptions, LineEnd, write_aop
from limbgram.formats.reading import read_limb
from limbgram.workbench.carving.mapping import MapOptions
from limbgram.workbench.carving.radial_rays import RadialCast, cast_radii
from limbgram.workbench.carving.radius_map import RadiusMap
from limbgram.workbench.limb import AlignedLimb, Landmark, Limb, LimbFrame

FRAME = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")


def limb_of(radius_map: RadiusMap) -> Limb:
    return AlignedLimb(mesh=radius_map.surface(), frame=FRAME)


def turned_body(radii_mm: np.ndarray, z_mm: np.ndarray, spokes: int = 720) -> RadiusMap:
    """Radii by slice, all round; or by slice and spoke."""
    thetas = 360.0 / spokes * np.arange(spokes)
    full = np.broadcast_to(radii_mm.reshape(len(z_mm), -1), (len(z_mm), spokes))
    return RadiusMap(thetas_deg=thetas, z_mm=z_mm.astype(float), radii_mm=full.copy())


def deficit(spokes: int) -> float:
    """Area of a regular polygon over that of its circle."""
    return np.sin(2 * np.pi / spokes) / (2 * np.pi / spokes)


@pytest.mark.parametrize("spokes", [36, 72, 90, 120])
def test_a_cylinder_and_a_cone_cost_what_the_polygon_costs(tmp_path: Path, spokes: int) -> None:
    z = np.linspace(0, 200, 3)
    for radii in (np.full(3, 50.0), np.linspace(30, 60, 3)):
        body = turned_body(radii, z)
        options = AopOptions(map=MapOptions(spokes=spokes))
        report = write_aop(limb_of(body), tmp_path / "body.aop", options)
        expected = deficit(spokes) / deficit(720)
        assert report.volume_change == pytest.approx(expected - 1, abs=2e-5)
        girth = np.sinc(1 / spokes) / np.sinc(1 / 720)
        assert report.girth_change == pytest.approx(girth - 1, abs=2e-5)
        sagitta = radii.max() * (1 - np.cos(np.pi / spokes))
        assert 0.7 * sagitta < report.max_mm < 1.05 * sagitta


def test_an_ellipse_is_cast_exactly(tmp_path: Path) -> None:
    angles = np.radians(0.5 * np.arange(720))
    radii = 1 / np.hypot(np.sin(angles) / 60, np.cos(angles) / 45)
    body = turned_body(np.tile(radii, (11, 1)), np.linspace(0, 100, 11))
    write_aop(limb_of(body), tmp_path / "ellipse.aop", AopOptions(map=MapOptions(spokes=90)))
    found = read_aop((tmp_path / "ellipse.aop").read_bytes(), "ellipse.aop").radius_map
    expected = radii[::8]  # rays through the body's own corners
    np.testing.assert_allclose(found.radii_mm, np.tile(expected, (51, 1)), atol=5.1e-4)
    assert volume_mm3(found.surface()) == pytest.approx(
        np.pi * 60 * 45 * 100 * deficit(90), rel=5e-4
    )


def test_a_bump_at_the_patients_right_stays_there(tmp_path: Path) -> None:
    thetas = np.radians(0.5 * np.arange(720))
    bump = 50 + 8 * np.exp(-(((thetas - np.pi / 2) / 0.2) ** 2))
    limb = limb_of(turned_body(np.tile(bump, (21, 1)), np.linspace(0, 100, 21)))
    for profile in ("mm", "omega", "ampscan"):
        options = AopOptions(profile=profile)
        mesh = read_limb(write_aop(limb, tmp_path / f"{profile}.aop", options).path).mesh
        farthest = mesh.vertices_mm[np.hypot(*mesh.vertices_mm[:, :2].T).argmax()]
        np.testing.assert_allclose(farthest[:2], (58, 0), atol=1e-3)
        assert volume_mm3(mesh) > 0


def wavy(amplitudes: list[float], phases: list[float]) -> Limb:
    """A star-shaped limb with a tip, its landmarks on it."""
    thetas = np.radians(2.0 * np.arange(180))
    waves = 1 + sum(
        a * np.cos((k + 1) * thetas + p) for k, (a, p) in enumerate(zip(amplitudes, phases))
    )
    z = np.concatenate([[0, 1, 4, 9], np.arange(14, 201, 6)])
    profile = 50 * np.sqrt(np.minimum(z, 60) / 60)
    body = turned_body(profile[:, None] * waves, z, 180)
    place = body.points_mm()[10, 40]
    return replace(limb_of(body), landmarks=(Landmark(name="Fibula Head", position_mm=place),))


@settings(max_examples=6)
@given(
    amplitudes=st.lists(st.floats(0, 0.08), min_size=3, max_size=3),
    phases=st.lists(st.floats(0, 6.3), min_size=3, max_size=3),
    spokes=st.sampled_from([12, 72, 90, 121]),
    profile=st.sampled_from(["mm", "omega", "ampscan"]),
    end=st.sampled_from(["lf", "cr", "crlf"]),
    listed=st.booleans(),
)
def test_written_again_it_is_the_same_file(
    tmp_path_factory: pytest.TempPathFactory,
    amplitudes: list[float],
    phases: list[float],
    spokes: int,
    profile: Profile,
    end: LineEnd,
    listed: bool,
) -> None:
    folder = tmp_path_factory.mktemp("aop")
    limb = wavy(amplitudes, phases)
    options = AopOptions(
        map=MapOptions(spokes=spokes, spacing_mm=5.0),
        profile=profile,
        line_end=end,
        slices_listed=listed,
        spokes_listed=profile != "ampscan" and listed,
    )
    first = write_aop(limb, folder / "first.aop", options)
    assert first.rms_mm < 50 * (1 - np.cos(np.pi / spokes)) + 0.5
    again = read_limb(first.path)
    assert again.frame.side == "right"
    # Radii are kept to 0.0005 mm, landmarks in inches to 0.013 mm.
    away = np.abs(again.landmarks[0].position_mm - limb.landmarks[0].position_mm).max()
    assert away < (0.014 if profile == "omega" else 0.0015)
    second = write_aop(again, folder / "second.aop", options)
    assert second.path.read_bytes() == first.path.read_bytes()
    assert second.max_mm < 1e-3


def test_more_slices_at_the_tip_follow_its_dome(tmp_path: Path) -> None:
    angles = np.linspace(0, np.pi / 2, 60)
    body = turned_body(50 * np.sin(angles), 50 * (1 - np.cos(angles)))
    plain = write_aop(limb_of(body), tmp_path / "plain.aop")
    fine = AopOptions(map=MapOptions(distal_slices=6))
    close = write_aop(limb_of(body), tmp_path / "close.aop", fine)
    # A chord from the tip to 2 mm over it leaves a dome of 50 mm by R (1 - cos(a / 2)).
    reached = np.arccos(1 - np.array([0, 2, 4]) / 50)
    first, second = 50 * (1 - np.cos(np.diff(reached) / 2))
    assert plain.max_mm == pytest.approx(first, abs=0.01)
    assert close.max_mm == pytest.approx(second, abs=0.01)
    with pytest.raises(OptionsError, match="one by one"):
        write_aop(limb_of(body), tmp_path / "no.aop", replace(fine, slices_listed=False))


def test_undercuts_are_refused_with_their_count(tmp_path: Path) -> None:
    inner = turned_body(np.full(5, 30.0), np.linspace(0, 100, 5), 180).surface()
    outer = turned_body(np.full(5, 50.0), np.linspace(0, 100, 5), 180).surface()
    wall = Mesh(
        vertices_mm=np.concatenate([outer.vertices_mm, inner.vertices_mm]),
        faces=np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer)]),
    )
    with pytest.raises(CarveError, match=r"6,120 of 6,120 rays .*100.0%.* cross it several"):
        write_aop(AlignedLimb(mesh=wall, frame=FRAME), tmp_path / "wall.aop")
    assert not (tmp_path / "wall.aop").exists()


def capsule(lean_mm: float = 0.0) -> Limb:
    """Half a ball of 40 mm below a tube up to 160 mm; the axis bends to the right."""
    polar = np.linspace(0, np.pi / 2, 46)
    z = np.concatenate([40 * (1 - np.cos(polar)), np.linspace(40, 160, 61)[1:]])
    radii = np.concatenate([40 * np.sin(polar), np.full(60, 40.0)])
    mesh = turned_body(radii, z, 360).surface()
    mesh = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)
    lean = np.zeros_like(mesh.vertices_mm)
    lean[:, 0] = lean_mm * (mesh.vertices_mm[:, 2] / 160) ** 2
    moved = mesh.with_vertices(mesh.vertices_mm + lean)
    right = np.array([40 + lean_mm * (100 / 160) ** 2, 0.0, 100.0])
    return AlignedLimb(
        mesh=moved, frame=FRAME, landmarks=(Landmark(name="right", position_mm=right),)
    )


def subdivided(mesh: Mesh) -> Mesh:
    vertices, faces = trimesh.remesh.subdivide(mesh.vertices_mm, mesh.faces)
    return Mesh(vertices_mm=np.asarray(vertices), faces=faces.astype(np.int32))


def test_girths_are_told_above_the_rounded_tip_and_the_tip_for_itself(tmp_path: Path) -> None:
    report = write_aop(capsule(), tmp_path / "capsule.aop")
    assert report.cap is not None
    # The slope of a ball is 45 degrees at R (1 - cos 45); slices are 2 mm apart.
    assert 40 * (1 - np.sqrt(0.5)) <= report.cap.to_mm <= 40 * (1 - np.sqrt(0.5)) + 2.0
    chord = 40 * (1 - np.cos(np.arccos(1 - 2 / 40) / 2))
    assert report.cap.max_mm == pytest.approx(chord, abs=0.02)
    assert report.above_cap_max_mm < 0.1 * chord
    assert -0.4 < report.cap.volume_change_ml < 0
    assert report.worst_girth is not None
    assert min(level.height_mm for level in report.girths) >= report.cap.to_mm
    lost = 1 - np.sinc(1 / 120) / np.sinc(1 / 360)
    for level in report.girths:
        assert -level.change_mm / level.limb_mm == pytest.approx(lost, abs=3e-5)


def test_a_fitted_axis_holds_a_bent_limb_and_the_file_says_where_it_lies(tmp_path: Path) -> None:
    limb = capsule(lean_mm=60.0)
    with pytest.raises(CarveError, match=r"tilted by \d+\.\d degrees would do: --axis fit"):
        write_aop(limb, tmp_path / "bent.aop")
    report = write_aop(limb, tmp_path / "fitted.aop", AopOptions(axis="fit"))
    tilt_deg = np.degrees(np.linalg.norm(report.axis_from_limb.rotation_vector))
    assert 5 < tilt_deg < 35
    assert report.mapped.rays_mended < 0.01 * report.mapped.rays
    read = read_limb(report.path)
    back = read.frame.limb_from_mesh
    (mark,) = read.landmarks
    np.testing.assert_allclose(
        back.apply(mark.position_mm[None])[0], limb.landmarks[0].position_mm, atol=2e-3
    )
    away = TriangleTree.of(limb.mesh.vertices_mm, limb.mesh.faces).closest(
        back.apply(read.mesh.vertices_mm)
    )
    # The cut at the top is level in the file's axes, and the fan that closes none is left out.
    assert np.quantile(away.distances_mm, 0.99) < 0.01


def test_heights_of_the_limb_cannot_be_given_along_a_fitted_axis(tmp_path: Path) -> None:
    limb = capsule(lean_mm=60.0)
    for wanted in (MapOptions(from_mm=20.0), MapOptions(to_mm=120.0)):
        with pytest.raises(OptionsError, match="Leave out --from-mm and --to-mm"):
            write_aop(limb, tmp_path / "no.aop", AopOptions(axis="fit", map=wanted))
    with pytest.raises(CarveError, match="takes it without --from-mm and --to-mm"):
        write_aop(limb, tmp_path / "no.aop", AopOptions(map=MapOptions(from_mm=1.0)))


def test_a_finer_surface_takes_no_finer_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faces that all the steps of the search cast, for a surface and for its refinement."""
    cast: list[int] = []

    def counted(mesh: Mesh, *where: Any) -> RadialCast:
        cast.append(len(mesh.faces))
        return cast_radii(mesh, *where)

    monkeypatch.setattr(axis, "cast_radii", counted)
    limb = capsule(lean_mm=60.0)
    coarse = axis.fitted_axis(limb.mesh, MapOptions())
    finer = subdivided(limb.mesh)
    assert len(finer.faces) == 4 * len(limb.mesh.faces) > 120_000
    cast.clear()
    fine = axis.fitted_axis(finer, MapOptions())
    assert 10_000 < max(cast) < 40_000
    assert len(cast) <= 160
    assert angle_between_deg(fine.rotation, coarse.rotation) < 3.0


def test_bodies_inside_are_left_out(tmp_path: Path) -> None:
    skin = capsule()
    bone = skin.mesh.with_vertices(skin.mesh.vertices_mm * 0.4 + np.array([5.0, 0, 40.0]))
    both = Mesh(
        vertices_mm=np.concatenate([skin.mesh.vertices_mm, bone.vertices_mm]),
        faces=np.concatenate([skin.mesh.faces, bone.faces + len(skin.mesh)]).astype(np.int32),
    )
    plain = write_aop(skin, tmp_path / "skin.aop")
    report = write_aop(replace(skin, mesh=both), tmp_path / "both.aop")
    assert (plain.bodies_left_out, report.bodies_left_out) == (0, 1)
    assert report.path.read_bytes() == plain.path.read_bytes()


def test_a_limb_off_its_axis_is_refused(tmp_path: Path) -> None:
    body = turned_body(np.full(11, 40.0), np.linspace(0, 100, 11), 90)
    bent = body.surface()
    lean = np.zeros_like(bent.vertices_mm)
    lean[:, 0] = 90 * (bent.vertices_mm[:, 2] / 100) ** 2
    limb = AlignedLimb(mesh=bent.with_vertices(bent.vertices_mm + lean), frame=FRAME)
    with pytest.raises(CarveError, match="axis leaves the limb"):
        write_aop(limb, tmp_path / "bent.aop")
    away = bent.with_vertices(bent.vertices_mm + np.array([60.0, 0, 0]))
    with pytest.raises(CarveError, match="go all round"):
        write_aop(AlignedLimb(mesh=away, frame=FRAME), tmp_path / "away.aop")
    to_the_bend = AopOptions(map=MapOptions(to_mm=60.0))
    assert write_aop(limb, tmp_path / "short.aop", to_the_bend).height_mm == 60


def test_from_where_to_where(tmp_path: Path) -> None:
    body = turned_body(np.linspace(30, 60, 4), np.linspace(0, 150, 4))
    options = AopOptions(map=MapOptions(from_mm=50, to_mm=100))
    report = write_aop(limb_of(body), tmp_path / "part.aop", options)
    found = read_aop(report.path.read_bytes(), "part.aop").radius_map
    assert found.z_mm[[0, -1]].tolist() == [0, 50]
    np.testing.assert_allclose(found.radii_mm[[0, -1], 0], [40, 50], atol=1e-3)
    assert (report.mapped.distal_cut_mm, report.mapped.proximal_cut_mm) == pytest.approx((50, 50))
    for wrong in (MapOptions(from_mm=-5), MapOptions(to_mm=151), MapOptions(from_mm=90, to_mm=80)):
        with pytest.raises(OptionsError, match="no slice"):
            write_aop(limb_of(body), tmp_path / "no.aop", AopOptions(map=wrong))


def test_names_cannot_break_the_file(tmp_path: Path) -> None:
    limb = wavy([0, 0, 0], [0, 0, 0])
    mark = replace(limb.landmarks[0], name="Höhe des Fibulaköpfchens, außen, nach dem Abguss")
    report = write_aop(replace(limb, landmarks=(mark,)), tmp_path / "name.aop")
    assert report.held.landmarks[0].name == "Hoehe des Fibulakoepfchens, aussen, nach"
    assert report.path.read_bytes().isascii()


def test_what_would_be_a_mirror_image_is_not_written(tmp_path: Path) -> None:
    limb = wavy([0, 0, 0], [0, 0, 0])
    for options in (
        AopOptions(profile="ampscan", spokes_listed=True),
        AopOptions(profile="ampscan-early"),
    ):
        with pytest.raises(OptionsError, match="mirror"):
            write_aop(limb, tmp_path / "no.aop", options)
    with pytest.raises(MeasureError, match="not aligned"):
        write_aop(limb.unaligned(), tmp_path / "no.aop")
