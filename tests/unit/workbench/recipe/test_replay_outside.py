"""Bodies inside a limb, such as bones, take no part in its recipe, nor in comparing it."""

from dataclasses import replace

import numpy as np
import trimesh

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.workbench.compare.frames import outside_by_name
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame
from limbgram.workbench.recipe.recipe import Entry, Recipe, replay

RECIPE = Recipe(name="wider", entries=(Entry(edit=Offset(distance_mm=3.0)),))


def ball(radius_mm: float, at_mm: tuple[float, float, float]) -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(3, radius_mm)
    made.apply_translation(at_mm)
    return made


def limb_of(*parts: trimesh.Trimesh) -> Limb:
    whole = trimesh.util.concatenate(list(parts))
    mesh = Mesh(vertices_mm=np.asarray(whole.vertices), faces=whole.faces.astype(np.int32))
    return AlignedLimb(mesh=mesh, frame=LimbFrame(limb_from_mesh=Rigid.identity(), side="left"))


def test_the_skin_is_edited_as_if_no_bones_were_there() -> None:
    skin = ball(60, (0, 0, 60))
    # 2 mm apart: both grown by 3 mm they would pass through each other.
    bones = ball(15, (-16, 0, 60)), ball(15, (16, 0, 60))
    alone = replay(RECIPE, limb_of(skin))
    found = replay(RECIPE, limb_of(skin, *bones))
    np.testing.assert_array_equal(found.limb.mesh.vertices_mm, alone.limb.mesh.vertices_mm)
    np.testing.assert_array_equal(found.limb.mesh.faces, alone.limb.mesh.faces)
    assert found.ledger == alone.ledger
    assert [told(note) for note in found.limb.notes] == [
        "2 bodies inside the limb, such as bones, were left out."
    ]
    assert alone.limb.notes == ()
    with_one = replay(RECIPE, limb_of(skin, bones[0]))
    assert [told(note) for note in with_one.limb.notes] == [
        "1 body inside the limb, such as a bone, was left out."
    ]


def test_shapes_are_compared_by_their_outsides() -> None:
    skin, bones = ball(60, (0, 0, 60)), (ball(15, (-16, 0, 60)), ball(15, (16, 0, 60)))
    shape = replace(limb_of(skin, *bones), name="scan")
    (noted,) = outside_by_name(shape).notes
    assert told(noted) == "2 bodies inside scan were left out."
    nameless = outside_by_name(replace(limb_of(skin, bones[0]), name=""))
    assert [told(note) for note in nameless.notes] == ["1 body inside a shape was left out."]
    assert len(nameless.mesh.faces) == len(skin.faces)


def test_a_hollow_stays() -> None:
    wall = ball(50, (0, 0, 60))
    hollow = wall.copy()
    hollow.invert()
    both = limb_of(ball(60, (0, 0, 60)), hollow)
    kept = replay(replace(RECIPE, entries=()), both)
    assert len(kept.limb.mesh.faces) == len(both.mesh.faces)
    assert kept.limb.notes == ()
