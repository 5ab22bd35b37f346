"""Products survive the way to the disk unchanged; what does not fit its type is not read."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from jaxtyping import Float32, Float64

from limbgram.cases.encoding import from_tree, to_tree
from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.typed import Mismatch
from limbgram.findings import note
from limbgram.reconstruction.mapping.scene import PhotoVerdict


@dataclass(frozen=True)
class Inner:
    kind: Literal["a", "b"]
    points: Float64[np.ndarray, "n 3"]


@dataclass(frozen=True)
class Outer:
    name: str
    path: Path
    share: float
    count: int
    good: bool
    inner: tuple[Inner, ...]
    either: Inner | Rigid | None = None
    pair: tuple[str, int] = ("x", 1)
    soft: Float32[np.ndarray, " n"] | None = None


ROOT = Path("/somewhere")
RNG = np.random.default_rng(1)


def there_and_back(value: object, hint: Any) -> Any:
    arrays: list[np.ndarray] = []
    tree = json.loads(json.dumps(to_tree(value, arrays, str), allow_nan=False))
    return from_tree(tree, hint, arrays, ROOT)


def test_everything_comes_back() -> None:
    inner = Inner("b", RNG.normal(size=(4, 3)))
    outer = Outer(
        name="Fuß 1",
        path=Path("photos/a b.jpg"),
        share=math.nan,
        count=3,
        good=True,
        inner=(inner, Inner("a", np.zeros((0, 3)))),
        either=Rigid.identity(),
        soft=np.float32([1, 2]),
    )
    back = there_and_back(outer, Outer)
    assert (back.name, back.count, back.good, back.pair) == ("Fuß 1", 3, True, ("x", 1))
    assert math.isnan(back.share)
    assert back.path == ROOT / "photos/a b.jpg"
    np.testing.assert_array_equal(back.inner[0].points, inner.points)
    assert back.inner[1].points.shape == (0, 3)
    assert isinstance(back.either, Rigid)
    np.testing.assert_array_equal(back.soft, outer.soft)


def test_numpy_scalars_become_plain_ones() -> None:
    camera = Camera(width_px=np.int64(8), height_px=6, fx=np.float64(5.5), fy=5, cx=3.5, cy=2.5)
    back = there_and_back(camera, Camera)
    assert type(back.width_px) is int
    assert type(back.fx) is float
    assert type(back.fy) is float  # an int where a float is wanted


@pytest.mark.parametrize(
    ("value", "hint"),
    [
        (Inner("a", np.zeros((3, 3), np.float32)), Inner),  # another dtype
        (Inner("a", np.zeros((3, 2))), Inner),  # another shape
        (Inner("c", np.zeros((3, 3))), Inner),  # type: ignore[arg-type]
        (Inner("a", np.zeros((3, 3))), Rigid),
        (True, int),
        (1, bool),
        ("1", float),
        (1.5, int),
        (None, str),
        (("a", 1, 2), tuple[str, int]),
        ((1, "a"), tuple[int, ...]),
    ],
)
def test_what_does_not_fit_is_not_read(value: object, hint: Any) -> None:
    with pytest.raises(Mismatch):
        there_and_back(value, hint)


def test_missing_and_unknown_fields_are_not_read() -> None:
    tree: Any = to_tree(Rigid.identity(), arrays := [], str)
    with pytest.raises(Mismatch):
        from_tree({k: v for k, v in tree.items() if k != "translation"}, Rigid, arrays, ROOT)
    with pytest.raises(Mismatch):
        from_tree({**tree, "more": 1}, Rigid, arrays, ROOT)
    with pytest.raises(Mismatch):
        from_tree({**tree, "rotation": {"array": 7}}, Rigid, arrays, ROOT)


def test_a_field_that_came_later_takes_its_default() -> None:
    tree: Any = to_tree(
        Mesh(vertices_mm=np.zeros((3, 3)), faces=np.zeros((1, 3), np.int32)), arrays := [], str
    )
    older = {k: v for k, v in tree.items() if k != "shared_mm"}
    assert from_tree(older, Mesh, arrays, ROOT).shared_mm is None


@pytest.mark.parametrize("value", [[1, 2], {"a": 1}, {1}, b"x", object(), lambda: 0])
def test_what_is_no_product_is_a_bug(value: object) -> None:
    with pytest.raises(TypeError):
        to_tree(value, [], str)


def test_findings_are_kept_and_sentences_of_earlier_versions_are_read_as_such() -> None:
    verdict = PhotoVerdict(
        name="a", placed=False, points=3, rms_px=0.1, reason=note("placing.photo.loose", points=3)
    )
    arrays: list[np.ndarray] = []
    tree: Any = json.loads(json.dumps(to_tree(verdict, arrays, str)))
    assert from_tree(tree, PhotoVerdict, arrays, ROOT) == verdict
    older = from_tree({**tree, "reason": "Too few.", "remark": ""}, PhotoVerdict, arrays, ROOT)
    assert (older.reason, older.remark) == (note("said.as_is", message="Too few."), None)
