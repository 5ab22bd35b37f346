"""Several bodies are told to people; a single one is not."""

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import trimesh

from limbgram.core.mesh.mesh import Mesh, Part, Relation
from limbgram.findings import note
from limbgram.reconstruction.pipeline import OtherPart, Reconstruction
from limbgram.report.blocks import Section, Table
from limbgram.report.case import parts_section
from limbgram.report.drawings.sides import sides_figure
from limbgram.report.parts import PartSummary, part_lines, part_summaries

OUTSIDE = PartSummary(
    number=1,
    relation="chosen",
    name="the surface",
    area=64_100.0,
    middle=(1.0, 2.0, 70.2),
    size=151.0,
    file="surface.stl",
    reason="",
)
INSIDE = replace(
    OUTSIDE,
    number=2,
    relation="other side",
    name="the other side of its wall",
    area=52_340.0,
    file="surface-part-2.stl",
)


def table_of(sections: Iterator[Section]) -> Table:
    (section,) = sections
    (table,) = (block for block in section.blocks if isinstance(block, Table))
    return table


def test_one_body_is_not_told() -> None:
    assert part_lines([OUTSIDE], "mm") == ()
    assert list(parts_section([OUTSIDE], "mm")) == []


def test_each_of_several_is_told_with_area_place_and_file() -> None:
    first, outside, inside = part_lines([OUTSIDE, INSIDE], "mm")
    assert "2 bodies" in first
    assert "--part" in first
    place = "round x 1, y 2, z 70 mm, 151 mm long (surface.stl)"
    assert outside == f"  part 1: the surface, 641 cm\N{SUPERSCRIPT TWO}, {place}"
    assert "the other side of its wall, 523 cm" in inside
    first, second = table_of(parts_section([OUTSIDE, INSIDE], "mm")).rows
    assert first[-1] == "surface.stl"
    assert second[-1] == "surface-part-2.stl"


def test_a_part_that_could_not_be_measured_says_why() -> None:
    failed = replace(INSIDE, file=None, reason="Hardly a place looks alike.")
    assert part_lines([OUTSIDE, failed], "mm")[2].endswith(". Hardly a place looks alike.")
    assert table_of(parts_section([OUTSIDE, failed], "mm")).rows[1][-1] == failed.reason


def test_areas_without_scale_are_no_square_centimetres() -> None:
    assert "cm" not in " ".join(part_lines([OUTSIDE, INSIDE], "unitless"))


def reconstruction(chosen: Mesh, other: Mesh | None, relation: Relation) -> Reconstruction:
    """Only what the parts are told from."""
    part = Part(
        number=2,
        area_mm2=900.0,
        middle_mm=np.zeros(3),
        size_mm=40.0,
        looked_at=0.4,
        relation=relation,
    )
    found = SimpleNamespace(
        mesh=chosen,
        others=(OtherPart(part=part, mesh=other, reason=note("said.as_is", message="-")),),
    )
    return cast(Reconstruction, found)


def cup(radius_mm: float, *, inwards: bool) -> Mesh:
    """A drum open at its top."""
    drum = trimesh.creation.cylinder(radius_mm, 50, sections=24)
    faces = drum.faces[drum.face_normals[:, 2] < 0.5].astype(np.int32)
    turned = np.ascontiguousarray(faces[:, ::-1]) if inwards else faces
    return Mesh(vertices_mm=np.asarray(drum.vertices, float), faces=turned)


def test_the_sides_of_a_wall_are_called_inside_and_outside() -> None:
    outside, inside = cup(30, inwards=False), cup(28, inwards=True)
    first, second = part_summaries(reconstruction(outside, inside, "other side"))
    assert first.name == "the surface, the outside of a wall"
    assert second.name == "the inside of its wall"
    assert second.file == "surface-part-2.stl"
    first, second = part_summaries(reconstruction(inside, outside, "other side"))
    assert first.name == "the surface, the inside of a wall"
    assert second.name == "the outside of its wall"


def test_a_part_without_a_mesh_has_no_file() -> None:
    first, second = part_summaries(reconstruction(cup(30, inwards=False), None, "apart"))
    assert first.name == "the surface"
    assert (second.file, second.reason, second.area) == (None, "-", 900.0)


def test_an_inside_is_drawn_as_its_cast() -> None:
    """Seen from outside, the faces of an inside show their dark backs."""
    solid, hollow = cup(30, inwards=False), cup(30, inwards=True)
    of_solid, of_hollow = (
        np.asarray(sides_figure(mesh, None, in_mm=True).axes[0].get_images()[0].get_array())
        for mesh in (solid, hollow)
    )
    np.testing.assert_array_equal(of_hollow, of_solid)


def test_views_of_a_limb_are_named_by_the_patients_sides() -> None:
    """A toe forwards lies where the corner says F: right of the heel, seen from the right."""
    shank = trimesh.creation.box((20.0, 20.0, 100.0))
    toe = trimesh.creation.box((10.0, 60.0, 10.0))
    toe.apply_translation((0.0, 35.0, -40.0))
    both = trimesh.util.concatenate([shank, toe])
    mesh = Mesh(vertices_mm=np.array(both.vertices), faces=np.array(both.faces, np.int32))
    figure = sides_figure(mesh, None, in_mm=False, sides=True)
    found: dict[str, float] = {}
    for axes in figure.axes:
        picture = np.asarray(axes.get_images()[0].get_array())
        drawn = (picture != picture[0, 0]).any(axis=2)
        low = drawn[int(0.85 * len(drawn)) : int(0.95 * len(drawn))].any(axis=0).nonzero()[0].mean()
        high = drawn[: len(drawn) // 2].any(axis=0).nonzero()[0].mean()
        found[axes.get_title()] = np.sign(np.round((low - high) / 10))
    assert found == {"patient's right": 1, "front": 0, "patient's left": -1, "back": 0}
