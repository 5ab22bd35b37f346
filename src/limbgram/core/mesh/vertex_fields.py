"""Vertex fields: per-vertex attributes of a Mesh, each declared once, beside its field.

A new attribute is one field of `Mesh`: cutting, subdividing, filling, moving, scaling and PLY
follow from its declaration.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np

_DECLARED = "vertex_field"


@dataclass(frozen=True, kw_only=True)
class VertexField:
    """What the values of an attribute are, and how they are carried along."""

    kind: Literal["colour", "mark", "number"]
    """Numbers describe the measurement: a surface that is no longer the measured one has none."""
    columns: tuple[str, ...]
    """Names in a PLY; of a counted attribute the prefix of its numbered columns."""
    counted: bool = False
    older: tuple[str, ...] = ()
    """Names of its columns in older files."""
    unmeasured: float = 0.0
    """Value at a vertex that no photo measured. Colours stay; a new vertex takes a neighbour's."""
    least: tuple[float, ...] = ()
    """Least value of each column, where there is one."""
    known_everywhere: bool = True
    """Whether it is a finite number at every vertex."""
    in_mm: bool = False
    """Its values are lengths, scaled with the unit of a file."""
    shown_as: str = ""
    """Its name in programs that show surfaces; empty: only our own files have it."""
    detail: bool = False
    """It describes relief finer than the surface resolves: known of one of two surfaces alone, it
    would pass for a difference between them."""
    axis: bool = False
    """It is a direction along the surface, rotated with it; either sign is the same."""

    @property
    def flat(self) -> bool:
        """Whether it is one value per vertex, not a row."""
        return len(self.columns) == 1 and not self.counted

    def at_unmeasured(self, values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """The values, with the chosen vertices set to unmeasured."""
        if self.kind == "colour":
            return values
        rows = chosen.reshape(-1, *[1] * (values.ndim - 1))
        return np.where(rows, values.dtype.type(self.unmeasured), values)

    def with_unmeasured(self, values: np.ndarray, like: np.ndarray) -> np.ndarray:
        """The values, extended by new, unmeasured vertices; `like`: a neighbour of each."""
        if self.kind == "colour":
            return np.concatenate([values, values[like]])
        new = np.full((len(like), *values.shape[1:]), self.unmeasured, values.dtype)
        return np.concatenate([values, new])

    def between(self, values: np.ndarray, ends: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Values interpolated between two vertices, at a share of the way from the first."""
        first, second = (values[end] for end in ends.T)
        if self.kind == "mark":
            return first | second
        if self.axis:
            opposed = np.einsum("kd,kd->k", first, second) < 0
            new = first + shares[:, None] * (np.where(opposed[:, None], -second, second) - first)
        else:
            rows = shares.reshape(-1, *[1] * (values.ndim - 1))
            new = first + rows * (second.astype(np.float64) - first)
        return (np.rint(new) if self.kind == "colour" else new).astype(values.dtype)


def of_vertices(
    kind: Literal["colour", "mark", "number"], *columns: str, **more: Any
) -> Mapping[str, VertexField]:
    """Metadata of a Mesh field with a value or a row per vertex; None: not known."""
    return {_DECLARED: VertexField(kind=kind, columns=columns, **more)}


def vertex_fields(kind: type) -> dict[str, VertexField]:
    """The fields of Mesh declared by `of_vertices`, by name."""
    return {one.name: one.metadata[_DECLARED] for one in fields(kind) if _DECLARED in one.metadata}
