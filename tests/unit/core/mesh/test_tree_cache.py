"""Trees that are kept: the right one for each mesh, few of them, and none without its mesh."""

import gc
from weakref import ref

import numpy as np

from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.tree_cache import MOST_KEPT, AnswersByMesh, tree_on


def triangle(height_mm: float) -> Mesh:
    corners = np.array([[0.0, 0, height_mm], [10, 0, height_mm], [0, 10, height_mm]])
    return Mesh(vertices_mm=corners, faces=np.array([[0, 1, 2]], np.int32))


def test_each_mesh_has_its_own_tree_and_it_is_planted_once() -> None:
    low, high = triangle(1.0), triangle(5.0)
    query = np.array([[1.0, 1.0, 0.0]])
    first = tree_on(low)
    assert tree_on(high).closest(query).distances_mm[0] == 5.0
    assert tree_on(low) is first
    assert first.closest(query).distances_mm[0] == 1.0
    moved = low.with_vertices(low.vertices_mm + 1)
    assert tree_on(moved).closest(query + 1).points_mm[0, 2] == 2.0


def test_a_tree_ends_with_its_mesh_and_with_too_many_others() -> None:
    mesh, kept = triangle(1.0), triangle(2.0)
    alone, pushed = ref(tree_on(mesh)), ref(tree_on(kept))
    del mesh
    gc.collect()
    assert alone() is None
    assert pushed() is not None
    others = [triangle(float(k)) for k in range(MOST_KEPT)]
    for other in others:
        tree_on(other)
    gc.collect()
    assert pushed() is None


def test_answers_are_found_once_for_each_mesh_and_question_and_the_last_ones_stay() -> None:
    found: list[tuple[Mesh, str]] = []
    answers = AnswersByMesh[list[str]](most=2)

    def ask(mesh: Mesh, question: str) -> list[str]:
        def find() -> list[str]:
            found.append((mesh, question))
            return [question]

        return answers(mesh, question, find)

    low, high = triangle(1.0), triangle(5.0)
    first = ask(low, "a")
    assert first == ["a"]
    assert ask(low, "a") is first
    assert ask(high, "a") is not first
    assert ask(low, "b") == ["b"]
    assert ask(low, "a") is first
    assert ask(low, "c") == ["c"]  # the third: "b" was asked longest ago
    assert ask(low, "a") is first
    ask(low, "b")
    assert [question for mesh, question in found if mesh is low] == ["a", "b", "c", "b"]


def test_an_answer_ends_with_its_mesh() -> None:
    answers = AnswersByMesh[Mesh](most=1)
    mesh = triangle(1.0)
    answer = ref(answers(mesh, "another", lambda: triangle(2.0)))
    assert answer() is not None
    del mesh
    gc.collect()
    assert answer() is None
