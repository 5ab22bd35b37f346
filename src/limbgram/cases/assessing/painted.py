"""Painted marks of a case: found in its photos, on the surface that it keeps."""

import numpy as np

from limbgram.cases.assessing.kept import kept_evidence
from limbgram.cases.folder import CaseFolder
from limbgram.errors import OptionsError
from limbgram.shape.painted import PaintedMarks, PaintedOptions, find_painted_marks
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

_MOST_TRIED = 2000
_APART_MM = 3.0


def painted_marks_of(case: CaseFolder, shape: Mesh, options: PaintedOptions) -> PaintedMarks:
    """The marks that a case's photos show, in the frame of a shape made from this case.

    Raises:
        CaseError: it is no finished case, or its products cannot be read.
        OptionsError: the shape does not lie where the case's surface does; a grey colour.
    """
    kept = kept_evidence(case)
    tree = TriangleTree.of(kept.mesh.vertices_mm, kept.mesh.faces)
    tried = shape.vertices_mm[:: max(1, len(shape) // _MOST_TRIED)]
    apart_mm = float(np.median(tree.closest(tried).distances_mm))
    if not apart_mm <= _APART_MM:
        raise OptionsError(
            f"The shape lies {apart_mm:.0f} mm from the surface of {case.root} (median), so the "
            "photos are not of this shape as it lies now. Name the case that made it, or take "
            f"{case.deliverables / 'surface.ply'}."
        )
    scene = kept.metric.scene
    photos = [kept.photos.photos[idx] for idx in scene.placed]
    return find_painted_marks(photos, scene.views, kept.mesh, options)
