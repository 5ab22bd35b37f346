"""Vertex fields: what a Mesh knows of each vertex, declared once, beside the field.

A new one is a line of `Mesh`; cutting, dividing, filling, moving, scaling and PLY follow from it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np

_DECLARED = "vertex_field"


@dataclass(frozen=True, kw_only=True)
class VertexField:
    """What the values of one field are, and what becomes of them."""

    kind: Literal["colour", "mark", "number"]
    """Numbers tell of the measurement: a surface that is no longer the measured one has none."""
    columns: tuple[str, ...]
    """In a PLY; one that is counted has its beginning here, and as many columns as it has parts."""
    counted: bool = False
    older: tuple[str, ...] = ()
    """Its columns in files from before."""
    unmeasured: float = 0.0
    """At a vertex that no photo measured; a colour stays, and a new vertex takes a neighbour's."""
    least: tuple[float, ...] = ()
    """Of each column, where it has a least value."""
    known_everywhere: bool = True
    """Whether it is a finite number at every vertex."""
    in_mm: bool = False
    """Its numbers are lengths, scaled with the surface."""
    shown_as: str = ""
    """Its name in programs that show surfaces; empty where files of ours alone have it."""
    detail: bool = False
    """It tells of relief that is too fine for the surface: of one surface alone it would pass for a
    difference from another."""
    axis: bool = False
    """It is a way along the surface, turned with it; either sign says the same."""

    @property
    def flat(self) -> bool:
        """Whether it is one value a vertex, not a row."""
        return len(self.columns) == 1 and not self.counted

    def at_unmeasured(self, values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """The values, with those of the chosen vertices as no photo measured them."""
        if self.kind == "colour":
            return values
        rows = chosen.reshape(-1, *[1] * (values.ndim - 1))
        return np.where(rows, values.dtype.type(self.unmeasured), values)

    def with_unmeasured(self, values: np.ndarray, like: np.ndarray) -> np.ndarray:
        """The values, with those of new vertices that no photo measured; like: their neighbours."""
        if self.kind == "colour":
            return np.concatenate([values, values[like]])
        new = np.full((len(like), *values.shape[1:]), self.unmeasured, values.dtype)
        return np.concatenate([values, new])

    def between(self, values: np.ndarray, ends: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Values so far on the way from the first vertex to the second of each pair."""
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
    """Declares a field of Mesh with a value, or a row, for each vertex; `more` as VertexField has.

    It is None where nothing is known.
    """
    return {_DECLARED: VertexField(kind=kind, columns=columns, **more)}


def vertex_fields(kind: type) -> dict[str, VertexField]:
    """The declared fields of Mesh, by name."""
    return {one.name: one.metadata[_DECLARED] for one in fields(kind) if _DECLARED in one.metadata}
