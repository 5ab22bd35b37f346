"""Loose bodies beside a limb: left out and named; several limbs: refused."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import MeasureError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.formats.aop.writing import write_aop
from limbgram.workbench.bodies import (
    kept_findings,
    left_out_findings,
    outer_bodies,
    outside_of,
    without_loose,
)
from limbgram.workbench.frame.alignment import AlignOptions, align
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.measures.tape import TapeReading, fit_to_tape

N = 96
GIRTH_MM = 100 * math.pi * (1 - (math.pi / N) ** 2 / 3)
"""At the smoothing length: of the circle at the mean distance of the polygon's sides."""
AREA_MM2 = 0.5 * N * math.sin(2 * math.pi / N) * 2500
FRAME = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
AT_100 = LimbMeasureOptions(heights_mm=(100.0,), volumes_mm=((0.0, 150.0),))


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh) for mesh in meshes[:-1])])
    return Mesh(
        vertices_mm=np.concatenate([mesh.vertices_mm for mesh in meshes]),
        faces=np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts)]).astype(
            np.int32
        ),
    )


def crumb(make_turned: Callable[..., Mesh], *middle_mm: float, capped: bool = True) -> Mesh:
    """A drum of 3 mm radius, 6 mm high."""
    drum = make_turned(np.full(2, 3.0), np.array([-3.0, 3.0]), 16, capped=capped)
    return drum.with_vertices(drum.vertices_mm + np.array(middle_mm))


def drum_of(make_turned: Callable[..., Mesh], radius_mm: float, high_mm: float) -> Mesh:
    return make_turned(np.full(3, radius_mm), np.linspace(0, high_mm, 3), N)


@pytest.mark.parametrize("capped", [True, False])
def test_a_crumb_far_from_the_limb_changes_no_figure(
    make_turned: Callable[..., Mesh], cylinder: Mesh, capped: bool
) -> None:
    both = joined(crumb(make_turned, 200, 10, 100, capped=capped), cylinder)
    table = measure_limb(AlignedLimb(mesh=both, frame=FRAME), AT_100)
    alone = measure_limb(AlignedLimb(mesh=cylinder, frame=FRAME), AT_100)
    row = table.rows[0]
    assert row.figures["tape_mm"] is not None
    assert row.figures["tape_mm"].value == pytest.approx(GIRTH_MM, rel=3e-5)
    assert row.figures == alone.rows[0].figures
    assert row.loops == 1
    assert table.volumes[0].volume_mm3.value == pytest.approx(150 * AREA_MM2, rel=1e-9)
    assert table.bodies_left_out == 1
    (body,) = table.loose
    np.testing.assert_allclose(body.place_mm, [200, 10, 100], atol=1e-9)
    assert body.size_mm == pytest.approx(6)
    (noted,) = left_out_findings(table.bodies_left_out, table.loose)
    assert "6.0 mm across at x 200, y 10, z 100 mm" in told(noted)
    fit = fit_to_tape(
        AlignedLimb(mesh=both, frame=FRAME), [TapeReading(height_mm=100.0, girth_mm=1.1 * GIRTH_MM)]
    )
    assert fit.changes[0].factor == pytest.approx(1.1, rel=1e-5)


def test_what_touches_patches_or_hollows_the_limb_stays(
    make_turned: Callable[..., Mesh], cylinder: Mesh
) -> None:
    hollow = crumb(make_turned, 0, 0, 100)
    hollow = Mesh(vertices_mm=hollow.vertices_mm, faces=hollow.faces[:, ::-1].copy())
    for part in (
        crumb(make_turned, 52, 0, 100),
        crumb(make_turned, 58, 0, 100, capped=False),
        hollow,
    ):
        found = outer_bodies(joined(cylinder, part))
        assert (found.bodies_left_out, found.loose, found.rivals) == (0, (), ())
        assert len(found.mesh) == len(cylinder) + len(part)
    chain = joined(cylinder, crumb(make_turned, 52, 0, 100), crumb(make_turned, 57, 0, 100))
    assert not outer_bodies(chain).loose
    clear = outer_bodies(joined(cylinder, crumb(make_turned, 58, 0, 100)))
    assert len(clear.loose) == 1
    assert len(clear.mesh) == len(cylinder)


def test_a_hollow_in_the_limb_hides_neither_a_crumb_nor_another_limb(
    make_turned: Callable[..., Mesh], cylinder: Mesh
) -> None:
    """From the wall of the hollow alone, which faces inwards, all that is outside looks inside."""
    hollow = crumb(make_turned, 20, 0, 100)
    hollow = Mesh(vertices_mm=hollow.vertices_mm, faces=hollow.faces[:, ::-1])
    limb = joined(cylinder, hollow)
    beside = cylinder.with_vertices(cylinder.vertices_mm + np.array([300.0, 0, 0]))
    found = outer_bodies(joined(limb, crumb(make_turned, 200, 0, 100)))
    assert (len(found.loose), len(found.mesh.faces)) == (1, len(limb.faces))
    with pytest.raises(MeasureError, match="2 bodies of comparable size"):
        outer_bodies(joined(limb, beside)).require_one_limb()


def test_bones_and_crumbs_are_told_apart(make_turned: Callable[..., Mesh], cylinder: Mesh) -> None:
    both = joined(
        cylinder, crumb(make_turned, 0, 0, 100), *(crumb(make_turned, k, 0, 9) for k in (90, 120))
    )
    limb = outside_of(Limb(mesh=both))
    assert len(limb.mesh) == len(cylinder)
    inside, loose = map(told, limb.notes)
    assert inside == "1 body inside the limb was left out."
    assert loose.startswith("2 loose bodies apart from the limb (")
    assert loose.endswith(" were left out.")


def test_two_limbs_in_one_file_have_no_girth(
    make_turned: Callable[..., Mesh], cylinder: Mesh, tmp_path: Path
) -> None:
    other = drum_of(make_turned, 40.0, 150.0)
    both = joined(other.with_vertices(other.vertices_mm + np.array([150.0, 0, 0])), cylinder)
    limb = AlignedLimb(mesh=both, frame=FRAME)
    for use in (
        lambda: measure_limb(limb, AT_100),
        lambda: fit_to_tape(limb, [TapeReading(height_mm=100.0, girth_mm=300.0)]),
        lambda: align(limb, AlignOptions(side="right", axis=np.array([0, 0, 1.0]))),
        lambda: write_aop(limb, tmp_path / "two.aop"),
    ):
        with pytest.raises(MeasureError, match=r"2 bodies of comparable size"):
            use()
    assert not list(tmp_path.iterdir())
    (note,) = outside_of(limb).notes
    assert note.code == "limb.rivals.mixed"
    small = drum_of(make_turned, 15.0, 40.0)
    found = outer_bodies(joined(small.with_vertices(small.vertices_mm + 100.0), cylinder))
    assert (len(found.loose), found.rivals) == (1, ())


def test_axes_and_files_are_the_limbs_own(
    make_turned: Callable[..., Mesh], cylinder: Mesh, tmp_path: Path
) -> None:
    options = AlignOptions(
        side="left", proximal=np.array([0, 0, 1.0]), anterior=np.array([0, 1.0, 0])
    )
    both = joined(cylinder, crumb(make_turned, 200, 0, -50))
    alone, found = align(Limb(mesh=cylinder), options), align(Limb(mesh=both), options)
    assert len(found.mesh) == len(both)
    for name in ("rotation", "translation"):
        np.testing.assert_array_equal(
            getattr(found.frame.limb_from_mesh, name), getattr(alone.frame.limb_from_mesh, name)
        )
    plain, report = (write_aop(limb, tmp_path / f"{len(limb.mesh)}.aop") for limb in (alone, found))
    assert (plain.bodies_left_out, report.bodies_left_out, len(report.loose)) == (0, 1, 1)
    assert report.path.read_bytes() == plain.path.read_bytes()


def test_loose_bodies_alone_go_and_bones_stay(
    make_turned: Callable[..., Mesh], cylinder: Mesh
) -> None:
    bone = crumb(make_turned, 0, 0, 100)
    shell = drum_of(make_turned, 10.0, 20.0)
    shell = shell.with_vertices(shell.vertices_mm + np.array([150.0, 0, 0]))
    limb = joined(cylinder, bone)
    found = without_loose(joined(cylinder, crumb(make_turned, 200, 0, 50), bone))
    np.testing.assert_array_equal(found.mesh.vertices_mm, limb.vertices_mm)
    np.testing.assert_array_equal(found.mesh.faces, limb.faces)
    assert (found.inside, len(found.loose)) == (1, 1)
    (inner,) = kept_findings(found)
    assert told(inner) == "1 body inside the limb, such as a bone, was written too."
    # A kernel within a loose body is no bone of the limb.
    nested = without_loose(joined(limb, shell, crumb(make_turned, 150, 0, 10)))
    np.testing.assert_array_equal(nested.mesh.faces, limb.faces)
    assert (nested.inside, len(nested.loose)) == (1, 2)
    other = drum_of(make_turned, 40.0, 150.0)
    two = without_loose(joined(cylinder, other.with_vertices(other.vertices_mm + 200.0)))
    assert len(two.mesh) == len(cylinder) + len(other)
    assert kept_findings(two)[0].code == "limb.rivals.written"
