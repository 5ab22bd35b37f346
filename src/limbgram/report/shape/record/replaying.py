"""Replaying: a recipe done again, so that a record's ledger is computed and not copied."""

from dataclasses import dataclass

import numpy as np

from limbgram.errors import OptionsError
from limbgram.report.shape.record.sources import RecipeSource, ShapeSource
from limbgram.shape.recipe import Ledger, replay_as_it_is
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

SAME_MM = 0.01
"""A shape nearer than this to what the recipe makes is what the recipe made."""


@dataclass(frozen=True, kw_only=True)
class Replaying:
    """What a recipe does to the scan it is for."""

    recipe: RecipeSource
    scan: ShapeSource
    ledger: Ledger
    apart_mm: float | None
    """Largest distance between what it makes of the scan and the shape of the record; None where
    the record is of the scan itself."""


def replayed_on(recipe: RecipeSource, shape: ShapeSource, against: ShapeSource | None) -> Replaying:
    """Do a recipe to the scan it is for: the other shape or, if it is for that, the shape itself.

    Raises:
        OptionsError: it is for neither of them.
    """
    scan = _scan(recipe, shape, against)
    done = replay_as_it_is(recipe.recipe, scan.limb)
    apart = None if scan is shape else _apart_mm(done.limb.mesh, shape.limb.mesh)
    return Replaying(recipe=recipe, scan=scan, ledger=done.ledger, apart_mm=apart)


def _scan(recipe: RecipeSource, shape: ShapeSource, against: ShapeSource | None) -> ShapeSource:
    wanted = recipe.recipe.scan_sha256
    others = [source for source in (against, shape) if source is not None]
    for source in others:
        if wanted in ("", source.sha256):
            return source
    raise OptionsError(
        "The recipe was made for another scan than "
        + " and ".join(source.limb.name for source in others)
        + ". Name the scan it was made for by --against, or leave the recipe out."
    )


def _apart_mm(one: Mesh, other: Mesh) -> float:
    """Largest distance between two surfaces, at their vertices."""
    if one.vertices_mm.shape == other.vertices_mm.shape:
        direct = float(np.abs(one.vertices_mm - other.vertices_mm).max())
        if direct <= SAME_MM:
            return direct
    trees = (TriangleTree.of(mesh.vertices_mm, mesh.faces) for mesh in (other, one))
    both = zip(trees, (one, other), strict=True)
    return max(float(tree.closest(mesh.vertices_mm).distances_mm.max()) for tree, mesh in both)
