"""What a mesh knows of its vertices goes along with them, whatever is done to it."""

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import ShapeFileError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import VERTEX_FIELDS, Mesh
from limbgram.core.mesh.topology import select_vertices, unmeasured_at
from limbgram.core.mesh.vertex_fields import VertexField, of_vertices, vertex_fields
from limbgram.formats.ply import read_ply, write_ply


@pytest.fixture
def known() -> Mesh:
    """A square in the plane z = 0, of which all is known at its four corners."""
    return Mesh(
        vertices_mm=np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        colours=np.array([[0, 0, 0], [10, 20, 31], [40, 50, 60], [70, 80, 90]], np.uint8),
        filled=np.array([False, False, True, False]),
        sigma_mm=np.array([0.1, 0.3, np.nan, 0.2], np.float32),
        shared_mm=np.array([[1, 2], [3, 4], [5, 6], [7, 8]], np.float32),
        lost_length=np.array([[0.1, 0.01], [0.3, 0.03], [0.5, 0.05], [0.7, 0.07]], np.float32),
        lost_across=np.array([[1, 0, 0], [-3, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32),
    )


def test_every_field_with_a_row_for_each_vertex_is_declared(known: Mesh) -> None:
    """One that is forgotten would be left behind, or contradict the number of vertices."""
    rows = {
        one.name
        for one in fields(Mesh)
        if isinstance(value := getattr(known, one.name), np.ndarray) and len(value) == len(known)
    }
    assert rows - {"vertices_mm"} == set(VERTEX_FIELDS)


def test_taken_vertices_keep_what_is_known(known: Mesh) -> None:
    taken = select_vertices(known, np.array([3, 1]))
    assert taken.colours is not None
    assert taken.shared_mm is not None
    np.testing.assert_array_equal(taken.colours, [[70, 80, 90], [10, 20, 31]])
    np.testing.assert_array_equal(taken.shared_mm, [[7, 8], [3, 4]])


def test_a_vertex_between_two_has_what_lies_between(known: Mesh) -> None:
    """A quarter of the way from the first to the second, and from there to the third."""
    ends, shares = np.array([[0, 1], [1, 2]]), np.array([0.25, 0.25])
    new = known.of_vertices(lambda one, values: one.between(values, ends, shares))
    np.testing.assert_array_equal(new["colours"], [[2, 5, 8], [18, 28, 38]])  # 17.5, 27.5, 38.25
    np.testing.assert_array_equal(new["filled"], [False, True])
    np.testing.assert_allclose(new["sigma_mm"], [0.15, np.nan], rtol=1e-6)
    np.testing.assert_array_equal(new["shared_mm"], [[1.5, 2.5], [3.5, 4.5]])
    # Either sign of a way says the same: from (1, 0, 0) to (3, 0, 0), a quarter of the way.
    np.testing.assert_array_equal(new["lost_across"][0], [1.5, 0, 0])


def test_what_no_photo_measured_has_no_sigma_and_no_shared_error(known: Mesh) -> None:
    laid = unmeasured_at(known, np.array([True, False, False, False]))
    assert laid.filled is not None
    assert laid.sigma_mm is not None
    assert laid.shared_mm is not None
    assert laid.lost_across is not None
    np.testing.assert_array_equal(laid.filled, [True, False, True, False])
    np.testing.assert_array_equal(np.isnan(laid.sigma_mm), [True, False, True, False])
    np.testing.assert_array_equal(laid.shared_mm, [[0, 0], [3, 4], [5, 6], [7, 8]])
    np.testing.assert_array_equal(laid.lost_across[0], [0, 0, 0])
    np.testing.assert_array_equal(laid.colours, known.colours)
    bare = Mesh(vertices_mm=known.vertices_mm, faces=known.faces)
    np.testing.assert_array_equal(unmeasured_at(bare, np.ones(4, np.bool_)).filled, [True] * 4)


def test_new_vertices_are_unmeasured_and_coloured_as_their_neighbours(known: Mesh) -> None:
    like = np.array([1, 2])
    longer = known.of_vertices(lambda one, values: one.with_unmeasured(values, like))
    np.testing.assert_array_equal(longer["colours"][4:], [[10, 20, 31], [40, 50, 60]])
    np.testing.assert_array_equal(longer["filled"][4:], [True, True])
    assert np.isnan(longer["sigma_mm"][4:]).all()
    for name in ("shared_mm", "lost_length", "lost_across"):
        assert not longer[name][4:].any()


def test_a_way_turns_with_the_mesh_and_nothing_else_does(known: Mesh) -> None:
    """A quarter turn about z takes x to y."""
    turned = known.moved(Rigid.from_rotation_vector(np.array([0, 0, np.pi / 2]), np.zeros(3)))
    assert turned.lost_across is not None
    np.testing.assert_allclose(turned.lost_across[0], [0, 1, 0], atol=1e-7)
    np.testing.assert_allclose(turned.vertices_mm[1], [0, 1, 0], atol=1e-12)
    for name in set(VERTEX_FIELDS) - {"lost_across"}:
        np.testing.assert_array_equal(getattr(turned, name), getattr(known, name))


def test_ply_brings_every_field_back(known: Mesh, tmp_path: Path) -> None:
    path = write_ply(known, tmp_path / "known.ply", "mm")
    read = read_ply(path.read_bytes(), path.name).mesh
    for name in VERTEX_FIELDS:
        np.testing.assert_array_equal(getattr(read, name), getattr(known, name), err_msg=name)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("lost_length", np.nan),
        ("lost_length", -1.0),
        ("lost_across", np.inf),
        ("shared_mm", np.inf),
    ],
)
def test_ply_refuses_numbers_that_cannot_be(
    known: Mesh, tmp_path: Path, name: str, value: float
) -> None:
    spoilt = getattr(known, name).copy()
    spoilt[2, -1] = value
    path = write_ply(replace(known, **{name: spoilt}), tmp_path / "spoilt.ply", "mm")
    with pytest.raises(ShapeFileError, match=VERTEX_FIELDS[name].columns[0].removesuffix("_x")):
        read_ply(path.read_bytes(), path.name)


def test_a_new_field_is_declared_in_one_place() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Warmer:
        warmth: np.ndarray | None = field(
            default=None, metadata=of_vertices("number", "warmth", unmeasured=37.0)
        )

    declared = vertex_fields(Warmer)
    assert declared == {
        "warmth": VertexField(kind="number", columns=("warmth",), unmeasured=37.0),
    }
    warmth = np.array([30.0, 34.0], np.float32)
    one = declared["warmth"]
    np.testing.assert_array_equal(one.at_unmeasured(warmth, np.array([True, False])), [37.0, 34.0])
    np.testing.assert_array_equal(one.with_unmeasured(warmth, np.array([0])), [30.0, 34.0, 37.0])
