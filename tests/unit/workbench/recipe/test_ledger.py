"""The ledger's girths, as printed, are those of the shape at the heights that are printed."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.workbench.edits.ends import Extension
from limbgram.workbench.edits.solids import Fill, Offset
from limbgram.workbench.limb import Limb, LimbFrame
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.recipe.ledger import choose_levels, lines_of
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

SIDES = 256
RECIPE = Recipe(name="none", entries=(Entry(edit=Offset(distance_mm=1.0)),))
AS_PRINTED = re.compile(r"(\d+(?:\.\d+)?): (\d+\.\d)")


def cone(radius_mm: float, high_mm: float) -> Limb:
    """A radius that falls by 0.45 mm a millimetre: 0.1 mm of height shows in the girth."""
    made = trimesh.creation.cone(radius_mm, high_mm, sections=SIDES)
    mesh = Mesh(vertices_mm=np.asarray(made.vertices), faces=made.faces.astype(np.int32))
    return Limb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def test_printed_girths_are_found_by_measuring_at_the_printed_heights() -> None:
    limb = cone(60.0, 133.3)
    done = replay(RECIPE, limb)
    last = lines_of(done.ledger)[-1]
    printed = [(float(level), float(girth)) for level, girth in AS_PRINTED.findall(last)]
    assert len(printed) == 6
    options = LimbMeasureOptions(heights_mm=tuple(height for height, _ in printed))
    for (_, girth), row in zip(printed, measure_limb(done.limb, options).rows, strict=True):
        found = row.figures["contour_mm"]
        assert found is not None
        assert girth == pytest.approx(found.value, abs=0.0501)


def test_girths_before_the_edit_are_the_cones() -> None:
    limb = cone(60.0, 133.3)
    ledger = replay(RECIPE, limb).ledger
    assert [level % 1 for level in ledger.levels_mm] == [0.0] * 6
    for level, girth in zip(ledger.levels_mm, ledger.lines[0].before.girths_mm, strict=True):
        radius = 60 * (1 - level / 133.3)
        stays = 1 / (1 + (5 / (2 * math.pi * radius)) ** 4)  # of the circle as a wave
        smooth = 2 * math.pi * radius * stays * (1 - (math.pi / SIDES) ** 2 / 3)
        assert girth == pytest.approx(smooth, rel=5e-5)


@pytest.mark.parametrize("edit", [Extension(length_mm=30.0), Fill(brim=True)])
def test_what_only_adds_surface_has_a_volume_and_no_displacement(edit: Extension | Fill) -> None:
    """Beyond the brim there is no outside and inside of the old surface."""
    made = trimesh.creation.cylinder(40.0, 100.0, sections=SIDES)
    cup = made.faces[made.face_normals[:, 2] < 0.5].astype(np.int32)
    limb = replace(cone(1, 1), mesh=Mesh(vertices_mm=np.asarray(made.vertices), faces=cup))
    done = replay(Recipe(name="more", entries=(Entry(edit=edit),)), limb)
    (line,) = done.ledger.lines
    assert line.displacement is None
    area = SIDES / 2 * math.sin(2 * math.pi / SIDES) * 40**2
    longer_mm = 30 if isinstance(edit, Extension) else 0
    assert line.after.volume_ml == pytest.approx((100 + longer_mm) * area / 1000, rel=0.07)
    assert not any("largest" in told for told in lines_of(done.ledger))


def test_a_flat_shape_keeps_its_levels_apart() -> None:
    levels = choose_levels(cone(30.0, 6.0))
    assert np.allclose(np.diff(levels), 1.0)
    assert levels[0] == pytest.approx(0.5)
